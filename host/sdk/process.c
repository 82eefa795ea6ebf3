/* SPDX-License-Identifier: MIT
 *
 * The functions of strata/host.h that need no instance: they are about the library and the process
 * that it is loaded into.
 */
#include "strata/host.h"

#include <stdlib.h>

#ifdef __GLIBC__
#include <malloc.h>
#endif

uint32_t strata_version(void) {
    return STRATA_ABI_VERSION;
}

const char *strata_release(void) {
    return STRATA_RELEASE;
}

void strata_keep_memory(void) {
#ifdef __GLIBC__
    /* Below 32 MiB, the most that glibc admits, no block gets a mapping of its own, which free()
     * would undo; and the heap's end is kept until this much of it is free. */
    mallopt(M_MMAP_THRESHOLD, 32 << 20);
    mallopt(M_TRIM_THRESHOLD, 512 << 20);
#endif
}
