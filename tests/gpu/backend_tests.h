/* SPDX-License-Identifier: MIT
 *
 * The groups of test_gpu_backends. The state of each test is a rig, or NULL without the backend.
 */
#ifndef STRATA_TESTS_GPU_BACKEND_TESTS_H
#define STRATA_TESTS_GPU_BACKEND_TESTS_H

#include <stdio.h>

#include "gpu/rig.h"

extern const struct CMUnitTest storage_tests[], target_tests[], drawing_tests[];
extern const size_t storage_test_count, target_test_count, drawing_test_count;

/* The rig, with an empty scope; skips the test without one. */
static inline rig *backend_rig(void **state) {
    if (!*state)
        skip();
    rig_clear(*state);
    return *state;
}

/* A fragment shader of one colour, its parameter. */
static const char backend_flat_color[] = "STRATA_PARAMS { vec4 color; } params;\n"
                                         "layout(location = 0) out vec4 color;\n"
                                         "void main() { color = params.color; }\n";

static inline strata_attachment backend_attach(strata_image image, uint32_t load, uint32_t blend) {
    return (strata_attachment){
        .struct_size = sizeof(strata_attachment), .image = image, .load = load, .blend = blend};
}

#endif
