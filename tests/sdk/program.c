/* SPDX-License-Identifier: MIT
 *
 * A program that embeds Strata, built with pkg-config's flags: prints what is installed.
 */
#include "strata/host.h"

#include <stdio.h>

static strata_result print(void *user, const char *bytes, size_t size) {
    return fwrite(bytes, 1, size, user) == size ? STRATA_OK : STRATA_ERROR_IO;
}

int main(void) {
    strata *s = NULL;
    const strata_open_options options = {.struct_size = sizeof options, .backend = "null"};
    strata_result result = strata_open(&options, &s);
    if (result == STRATA_OK)
        result = strata_list(s, print, stdout);
    if (result != STRATA_OK)
        fprintf(stderr, "%s\n", strata_error(s));
    strata_close(s);
    return result == STRATA_OK && strata_version() == STRATA_ABI_VERSION ? 0 : 1;
}
