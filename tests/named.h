/* SPDX-License-Identifier: MIT
 *
 * For test programs that take a name: runs those tests that have it, with * and ?. None is a
 * failure, or a name that is mistyped would pass.
 */
#ifndef STRATA_TESTS_NAMED_H
#define STRATA_TESTS_NAMED_H

#include <fnmatch.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

/* name NULL: all. How many failed. */
static inline int named_run(const char *group, const char *name, const struct CMUnitTest *tests,
                            size_t count) {
    struct CMUnitTest *wanted = calloc(count + 1, sizeof *wanted);
    size_t found = 0;
    if (!wanted)
        return 1;
    for (size_t i = 0; i < count; i++)
        if (!name || fnmatch(name, tests[i].name, 0) == 0)
            wanted[found++] = tests[i];
    if (found == 0)
        fprintf(stderr, "%s: no test is named '%s'\n", group, name ? name : "*");
    const int failed = found ? _cmocka_run_group_tests(group, wanted, found, NULL, NULL) : 1;
    free(wanted);
    return failed;
}

#endif
