/* SPDX-License-Identifier: MIT
 *
 * Multisampled images on every backend, as far as every driver goes: zeros, clears, full-screen
 * passes, masks, and a stencil of its own for each sample. What triangles with edges do to samples,
 * the self-test `sample_routing` tells.
 */
#include "gpu/rig.h"

#define SIZE    5u
#define TEXELS  (SIZE * SIZE)
#define SAMPLES 4u

static int open_gl(void **state) {
    *state = rig_open("gl");
    return 0;
}

static int open_vulkan(void **state) {
    *state = rig_open("vulkan");
    return 0;
}

static int close_rig(void **state) {
    if (*state)
        rig_close(*state);
    return 0;
}

/* The rig, with an empty scope and a frame begun; skips where there are no four samples. */
static rig *begin(void **state) {
    rig *r = *state;
    if (!r || gpu_fact(r->g, "limit.samples") < SAMPLES)
        skip();
    rig_clear(r);
    gpu_begin(r->g, SIZE, SIZE);
    return r;
}

/* ---- looking into samples -------------------------------------------------------------------- */

/* Copies the first channel of every sample, in the frame that was begun, and submits it. */
static void read_samples(rig *r, strata_image image, float found[TEXELS][SAMPLES]) {
    static const char *const copy = "layout(local_size_x = 5, local_size_y = 5) in;\n"
                                    "layout(std430) writeonly buffer Found { float found[]; };\n"
                                    "uniform sampler2DMS samples;\n"
                                    "void main() {\n"
                                    "    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n"
                                    "    for (int i = 0; i < 4; ++i)\n"
                                    "        found[(p.y * 5 + p.x) * 4 + i] =\n"
                                    "            texelFetch(samples, p, i).r;\n"
                                    "}\n";
    const uint64_t size = TEXELS * SAMPLES * sizeof(float);
    const strata_buffer buffer = rig_buffer(r, "found", size, NULL);
    const strata_bind binds[] = {rig_bind_buffer("Found", buffer),
                                 rig_bind_image("samples", image)};
    rig_pass(r, (strata_pass){.program = rig_program(r, STRATA_PROGRAM_COMPUTE, copy),
                              .groups = {1, 1, 1},
                              .binds = binds,
                              .bind_count = 2});
    rig_submit(r);
    rig_read(r, buffer, found, size);
}

static void expect(rig *r, strata_image image, const float values[SAMPLES]) {
    float found[TEXELS][SAMPLES];
    read_samples(r, image, found);
    for (uint32_t i = 0; i < TEXELS; i++)
        for (uint32_t k = 0; k < SAMPLES; k++)
            if (found[i][k] != values[k])
                fail_msg("%s: texel %u, sample %u: %g, not %g", r->backend, i, k,
                         (double)found[i][k], (double)values[k]);
    gpu_begin(r->g, SIZE, SIZE);
}

static strata_image color_image(rig *r) {
    return rig_multisampled(r, "color", STRATA_FORMAT_RGBA32F, SIZE, SIZE, SAMPLES);
}

static strata_image depth_image(rig *r) {
    return rig_multisampled(r, "depth", STRATA_FORMAT_D32F_S8, SIZE, SIZE, SAMPLES);
}

/* ---- tests ----------------------------------------------------------------------------------- */

static void images_begin_at_zero_and_are_cleared(void **state) {
    static const float zero[SAMPLES] = {0}, seven[SAMPLES] = {7, 7, 7, 7};
    static const float quarter[SAMPLES] = {0.25f, 0.25f, 0.25f, 0.25f};
    rig *r = begin(state);
    const strata_image color = color_image(r), depth = depth_image(r);
    expect(r, color, zero);
    expect(r, depth, zero);
    gpu_clear_image(r->g, "test", color, seven);
    expect(r, color, seven);
    gpu_clear_image(r->g, "test", depth, quarter);
    expect(r, depth, quarter);
}

static const char *const flat = "STRATA_PARAMS { vec4 color; } params;\n"
                                "layout(location = 0) out vec4 color;\n"
                                "void main() { color = params.color; }\n";

/* A full-screen pass that writes `value` to the samples of the mask, 0: to all. */
static void paint(rig *r, strata_pass pass, float value, uint32_t mask) {
    const float color[4] = {value, value, value, value};
    pass.program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, flat);
    pass.params = color;
    pass.params_size = sizeof color;
    pass.sample_mask = mask;
    rig_pass(r, pass);
}

static void passes_reach_the_samples_of_their_mask(void **state) {
    static const float all[SAMPLES] = {3, 3, 3, 3}, some[SAMPLES] = {5, 3, 5, 4};
    rig *r = begin(state);
    strata_attachment color = {.struct_size = sizeof color,
                               .image = color_image(r),
                               .load = STRATA_LOAD_CLEAR,
                               .clear = {9}};
    const strata_pass pass = {.color = &color, .color_count = 1};
    paint(r, pass, 3, 0);
    expect(r, color.image, all);
    color.load = STRATA_LOAD_KEEP;
    paint(r, pass, 4, 8);
    paint(r, pass, 5, 5);
    expect(r, color.image, some);
}

/* A clear reaches all samples, whatever the mask. */
static void clears_are_not_masked(void **state) {
    static const float values[SAMPLES] = {9, 2, 9, 9};
    rig *r = begin(state);
    const strata_attachment color = {.struct_size = sizeof color,
                                     .image = color_image(r),
                                     .load = STRATA_LOAD_CLEAR,
                                     .clear = {9}};
    paint(r, (strata_pass){.color = &color, .color_count = 1}, 2, 2);
    expect(r, color.image, values);
}

/* Sample i begins at i + 2; passes over all samples count down, and what finds 2 is kept. */
static void each_sample_has_a_stencil_of_its_own(void **state) {
    static const float values[SAMPLES] = {1, 2, 3, 0};
    rig *r = begin(state);
    strata_attachment color = {
        .struct_size = sizeof color, .image = color_image(r), .load = STRATA_LOAD_CLEAR};
    strata_attachment depth = {
        .struct_size = sizeof depth, .image = depth_image(r), .load = STRATA_LOAD_CLEAR};
    strata_pass pass = {.color = &color,
                        .color_count = 1,
                        .depth = &depth,
                        .stencil_test = STRATA_TEST_ALWAYS,
                        .stencil_pass = STRATA_STENCIL_REPLACE};
    for (uint32_t i = 0; i < SAMPLES; i++) {
        pass.stencil_reference = i + 2;
        paint(r, pass, 8, 1u << i);
        depth.load = color.load = STRATA_LOAD_KEEP;
    }
    color.load = STRATA_LOAD_CLEAR;
    pass.stencil_test = STRATA_TEST_EQUAL;
    pass.stencil_reference = 2;
    pass.stencil_pass = pass.stencil_fail = STRATA_STENCIL_DECREMENT;
    for (uint32_t i = 0; i < 3; i++) {
        paint(r, pass, (float)i + 1, 15);
        color.load = STRATA_LOAD_KEEP;
    }
    expect(r, color.image, values);
}

/* Fragments run where a sample of the mask passes, once a pixel. */
static void tests_of_masked_samples_let_fragments_run(void **state) {
    static const char *const count = "layout(early_fragment_tests) in;\n"
                                     "layout(std430) buffer Count { uint count; };\n"
                                     "void main() { atomicAdd(count, 1u); }\n";
    rig *r = begin(state);
    const strata_buffer buffer = rig_buffer(r, "count", 4, NULL);
    const strata_bind bind = rig_bind_buffer("Count", buffer);
    const strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, count);
    strata_attachment depth = {.struct_size = sizeof depth,
                               .image = depth_image(r),
                               .load = STRATA_LOAD_CLEAR,
                               .clear = {0, 7}};
    strata_pass pass = {.program = program,
                        .binds = &bind,
                        .bind_count = 1,
                        .depth = &depth,
                        .sample_mask = 4,
                        .stencil_test = STRATA_TEST_ALWAYS,
                        .stencil_pass = STRATA_STENCIL_ZERO};
    const uint32_t masks[] = {15, 4, 11}, expected[] = {TEXELS, TEXELS, 0};
    rig_pass(r, pass); /* sample 2 is 0 now, the others are 7 */
    depth.load = STRATA_LOAD_KEEP;
    pass.stencil_test = STRATA_TEST_EQUAL;
    pass.stencil_pass = STRATA_STENCIL_KEEP;
    for (size_t i = 0; i < BASE_COUNT(masks); i++) {
        uint32_t found = 0;
        gpu_fill(r->g, "test", buffer, 0, 0, 0);
        pass.sample_mask = masks[i];
        rig_pass(r, pass);
        rig_submit(r);
        rig_read(r, buffer, &found, sizeof found);
        assert_int_equal(found, expected[i]);
        gpu_begin(r->g, SIZE, SIZE);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(images_begin_at_zero_and_are_cleared),
        cmocka_unit_test(passes_reach_the_samples_of_their_mask),
        cmocka_unit_test(clears_are_not_masked),
        cmocka_unit_test(each_sample_has_a_stencil_of_its_own),
        cmocka_unit_test(tests_of_masked_samples_let_fragments_run),
    };
    return cmocka_run_group_tests_name("vulkan", tests, open_vulkan, close_rig) +
           cmocka_run_group_tests_name("gl", tests, open_gl, close_rig);
}
