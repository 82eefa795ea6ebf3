/* SPDX-License-Identifier: MIT
 *
 * The GPU core over the null backend: objects, scopes, history, pools, programs and their
 * reflection, derived barriers as the log shows them, injected failures.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_fixture.h"

static const strata_glsl doubling = {"layout(local_size_x = 64) in;\n"
                                     "layout(std430) buffer Values { uint values[]; };\n"
                                     "STRATA_PARAMS { uint count; } params;\n"
                                     "void main() {\n"
                                     "    uint i = gl_GlobalInvocationID.x;\n"
                                     "    if (i < params.count) values[i] *= 2u;\n"
                                     "}\n",
                                     "doubling.glsl"};

static void test_compute_pass(void **state) {
    fixture *f = *state;
    strata_buffer values = make_buffer(f, "values", 256);
    strata_program program = make_program(f, STRATA_PROGRAM_COMPUTE, &doubling);
    uint32_t count = 64;
    const strata_bind binds[] = {bind_buffer("Values", values)};
    gpu_begin(f->g, 16, 16);
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "double",
                              .groups = {1},
                              .program = program,
                              .params = &count,
                              .params_size = 4,
                              .binds = binds,
                              .bind_count = 1};
    gpu_pass(f->g, "test", &pass);
    gpu_pass(f->g, "test", &pass);
    assert_int_equal(gpu_submit(f->g, &f->err), STRATA_OK);
    assert_logged(f, "pass double program program groups 1x1x1 Values=values "
                     "[values copy-write>storage-read|storage-write/c]\n");
    assert_logged(f, "[values storage-read|storage-write/c>storage-read|storage-write/c]\n");
    uint32_t timed;
    const gpu_timing *timings = gpu_timings(f->g, &timed);
    assert_int_equal(timed, 2);
    assert_string_equal(timings[0].label, "double");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_compute_pass, open_null, close_fixture),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
