/* SPDX-License-Identifier: MIT
 *
 * The groups of test_gpu_backends. The state of each test is a rig, or NULL without the backend.
 */
#ifndef STRATA_TESTS_GPU_BACKEND_TESTS_H
#define STRATA_TESTS_GPU_BACKEND_TESTS_H

#include <stdio.h>

#include "gpu/rig.h"

extern const struct CMUnitTest storage_tests[], drawing_tests[];
extern const size_t storage_test_count, drawing_test_count;

/* The rig, with an empty scope; skips the test without one. */
static inline rig *backend_rig(void **state) {
    if (!*state)
        skip();
    rig_clear(*state);
    return *state;
}

#endif
