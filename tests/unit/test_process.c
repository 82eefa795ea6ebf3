/* SPDX-License-Identifier: MIT
 *
 * host/sdk: what the library says of itself, and that memory which was freed stays with the
 * process.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <sys/resource.h>

#include <cmocka.h>

#include "strata/host.h"

enum { BLOCKS = 24, BLOCK = 8 << 20, ROUNDS = 4, PAGE = 4096 };

static long faults(void) {
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    return usage.ru_minflt;
}

/* Takes, writes and frees what drivers take for the vertices of some draws. */
static void work(void) {
    char *blocks[BLOCKS];
    for (int i = 0; i < BLOCKS; i++) {
        blocks[i] = malloc(BLOCK);
        assert_non_null(blocks[i]);
        memset(blocks[i], i, BLOCK);
    }
    for (int i = 0; i < BLOCKS; i++)
        free(blocks[i]);
}

static void speaks_its_abi(void **state) {
    (void)state;
    assert_int_equal(strata_version(), STRATA_ABI_VERSION);
    assert_string_equal(strata_release(), STRATA_RELEASE);
}

/* Handed back, each round would fault all pages in again; kept, the first does alone. */
static void freed_memory_is_kept(void **state) {
    (void)state;
#if !defined(__GLIBC__) || defined(__SANITIZE_ADDRESS__)
    skip();
#endif
    strata_keep_memory();
    work();
    const long before = faults();
    for (int i = 0; i < ROUNDS; i++)
        work();
    assert_true(faults() - before < BLOCKS * (BLOCK / PAGE) / 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(speaks_its_abi),
        cmocka_unit_test(freed_memory_is_kept),
    };
    return cmocka_run_group_tests_name("process", tests, NULL, NULL);
}
