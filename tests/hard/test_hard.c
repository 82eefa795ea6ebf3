/* SPDX-License-Identifier: MIT
 *
 * Hard cases: every row of the table that is not large, and every limit of capacity, a test each.
 * `test_hard NAME` runs those of this name, with * and ?.
 */
#include "hard/hard.h"
#include "named.h"

#include <stdlib.h>

static void check_row(void **state) {
    hard_check(*state);
}

int main(int argc, char **argv) {
    struct CMUnitTest *tests = calloc(hard_row_count + hard_limit_count, sizeof *tests);
    size_t count = 0;
    if (!tests)
        return 1;
    for (size_t i = 0; i < hard_row_count; i++)
        if (!(hard_rows[i].holds & HARD_LARGE))
            tests[count++] = (struct CMUnitTest){.name = hard_rows[i].name,
                                                 .test_func = check_row,
                                                 .initial_state = (void *)(uintptr_t)&hard_rows[i]};
    for (size_t i = 0; i < hard_limit_count; i++)
        tests[count++] =
            (struct CMUnitTest){.name = hard_limits[i].name, .test_func = hard_limits[i].check};
    const int failed = named_run("hard cases", argc > 1 ? argv[1] : NULL, tests, count);
    picture_close();
    free(tests);
    return failed;
}
