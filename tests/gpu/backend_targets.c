/* SPDX-License-Identifier: MIT
 *
 * Full-screen passes on every backend: orientation, attachments, blending, masks, rectangles.
 */
#include "gpu/backend_tests.h"
#include "gpu/gpu_internal.h"

#define SIZE   16u
#define TEXELS 256u /* SIZE x SIZE */

/* A full-screen pass of backend_flat_color. */
static void paint(rig *r, strata_program program, const strata_attachment *target,
                  const float color[4]) {
    rig_pass(r, (strata_pass){.program = program,
                              .params = color,
                              .params_size = 16,
                              .color = target,
                              .color_count = 1});
}

/* ---- full-screen passes ------------------------------------------------------------------ */

static void test_gradient(void **state) {
    rig *r = backend_rig(state);
    float found[5 * 7][4];
    strata_image image = rig_image(r, "image", STRATA_FORMAT_RGBA32F, 7, 5, 0);
    strata_program program =
        rig_program(r, STRATA_PROGRAM_FULLSCREEN,
                    "layout(location = 0) out vec4 color;\n"
                    "void main() {\n"
                    "    color = vec4(gl_FragCoord.xyz, gl_FrontFacing ? 1.0 : 0.0);\n"
                    "}\n");
    const strata_attachment target = backend_attach(image, STRATA_LOAD_DISCARD, STRATA_BLEND_NONE);
    gpu_begin(r->g, 7, 5);
    rig_pass(r, (strata_pass){.program = program, .color = &target, .color_count = 1});
    rig_submit(r);
    rig_texels(r, image, 0, found, sizeof found);
    for (uint32_t i = 0; i < 35; i++) {
        const uint32_t x = i % 7, y = i / 7;
        const float expected[4] = {(float)x + 0.5f, (float)y + 0.5f, 0.0f, 1.0f};
        assert_memory_equal(found[i], expected, sizeof expected);
    }
}

static void test_blend_modes(void **state) {
    rig *r = backend_rig(state);
    const float s[4] = {0.25f, 0.5f, 0.125f, 0.25f}, d[4] = {0.5f, 0.25f, 1.0f, 0.5f};
    float found[4];
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, backend_flat_color);
    strata_image image = rig_image(r, "image", STRATA_FORMAT_RGBA32F, 1, 1, 0);
    for (uint32_t blend = STRATA_BLEND_NONE; blend <= STRATA_BLEND_FOLD; blend++) {
        strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, blend);
        memcpy(target.clear, d, sizeof d);
        gpu_begin(r->g, 1, 1);
        paint(r, program, &target, s);
        rig_submit(r);
        rig_texels(r, image, 0, found, sizeof found);
        for (int c = 0; c < 4; c++) {
            const float fold = c < 3 ? s[c] + s[3] * d[c] : d[3] * s[3];
            const float expected[] = {s[c],
                                      d[c] + s[c],
                                      s[c] + (1 - s[3]) * d[c],
                                      d[c] + (1 - d[3]) * s[c],
                                      d[c] * s[c],
                                      s[c] < d[c] ? s[c] : d[c],
                                      s[c] > d[c] ? s[c] : d[c],
                                      fold};
            if (found[c] != expected[blend])
                fail_msg("blend %u channel %d: %g, expected %g", blend, c, (double)found[c],
                         (double)expected[blend]);
        }
    }
}

static void test_masks_and_loads(void **state) {
    rig *r = backend_rig(state);
    const float color[4] = {1, 2, 3, 4};
    float found[4];
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, backend_flat_color);
    strata_image image = rig_image(r, "image", STRATA_FORMAT_RGBA32F, 1, 1, 0);
    strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, STRATA_BLEND_NONE);
    target.clear[0] = 9;
    target.clear[2] = 8; /* clears obey no mask */
    target.mask_off = 1 | 4;
    gpu_begin(r->g, 1, 1);
    paint(r, program, &target, color);
    target.load = STRATA_LOAD_KEEP;
    target.mask_off = 2 | 4 | 8;
    target.blend = STRATA_BLEND_ADD;
    paint(r, program, &target, color);
    rig_submit(r);
    rig_texels(r, image, 0, found, sizeof found);
    const float expected[4] = {10, 2, 8, 4};
    assert_memory_equal(found, expected, sizeof expected);
}

static void test_eight_targets(void **state) {
    rig *r = backend_rig(state);
    static const uint32_t formats[8] = {
        STRATA_FORMAT_RGBA32F, STRATA_FORMAT_R32U,    STRATA_FORMAT_RGBA8, STRATA_FORMAT_RG32U,
        STRATA_FORMAT_R32F,    STRATA_FORMAT_RGBA16F, STRATA_FORMAT_R32F,  STRATA_FORMAT_RGBA32U};
    strata_attachment targets[8];
    strata_image images[8];
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN,
                                         "layout(location = 0) out vec4 c0;\n"
                                         "layout(location = 1) out uint c1;\n"
                                         "layout(location = 2) out vec4 c2;\n"
                                         "layout(location = 3) out uvec2 c3;\n"
                                         "layout(location = 4) out float c4;\n"
                                         "layout(location = 5) out vec4 c5;\n"
                                         "layout(location = 6) out float c6;\n"
                                         "layout(location = 7) out uvec4 c7;\n"
                                         "void main() {\n"
                                         "    c0 = vec4(1); c1 = 0xfffffff0u; c2 = vec4(1);\n"
                                         "    c3 = uvec2(7, 8); c4 = 5.0; c5 = vec4(1);\n"
                                         "    c6 = 3.0; c7 = uvec4(4, 5, 6, 7);\n"
                                         "}\n");
    for (uint32_t i = 0; i < 8; i++) {
        images[i] = rig_image(r, "target", formats[i], 2, 2, 0);
        targets[i] = backend_attach(images[i], STRATA_LOAD_CLEAR, STRATA_BLEND_NONE);
    }
    targets[6].blend = STRATA_BLEND_ADD; /* blending is each target's own */
    targets[6].clear[0] = 0.5f;
    targets[7].mask_off = 15;
    targets[7].clear[3] = 1000.0f;
    gpu_begin(r->g, 2, 2);
    rig_pass(r, (strata_pass){.program = program, .color = targets, .color_count = 8});
    rig_submit(r);
    uint32_t u[4][4];
    float f[4];
    rig_texels(r, images[1], 0, u, 16);
    assert_int_equal(u[0][3], 0xfffffff0u);
    rig_texels(r, images[3], 0, u, 32);
    assert_int_equal(u[1][1], 8);
    rig_texels(r, images[6], 0, f, 16);
    assert_true(f[2] == 3.5f);
    rig_texels(r, images[7], 0, u, 64);
    assert_int_equal(u[3][3], 1000);
    assert_int_equal(u[3][0], 0);
    for (uint32_t i = 0; i < 8; i += 2) {
        rig_texels(r, images[i], 0, u, 4ull * gpu_format_bytes(formats[i]));
        assert_int_not_equal(u[0][0], 0);
    }
}

static void test_rectangle(void **state) {
    rig *r = backend_rig(state);
    const float one[4] = {1, 0, 0, 0}, two[4] = {2, 0, 0, 0};
    float found[TEXELS];
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, backend_flat_color);
    strata_image image = rig_image(r, "image", STRATA_FORMAT_R32F, SIZE, SIZE, 0);
    strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, STRATA_BLEND_ADD);
    target.clear[0] = 0.5f;
    gpu_begin(r->g, SIZE, SIZE);
    gpu_rectangle(r->g, 3, 2, 5, 7);
    paint(r, program, &target, one);
    target.load = STRATA_LOAD_KEEP;
    gpu_rectangle(r->g, 0, 0, 0, 0);
    paint(r, program, &target, one);
    rig_pass(r, (strata_pass){.program = program,
                              .params = two,
                              .params_size = 16,
                              .color = &target,
                              .color_count = 1,
                              .whole_frame = 1});
    rig_submit(r);
    rig_texels(r, image, 0, found, sizeof found);
    for (uint32_t i = 0; i < TEXELS; i++) {
        const uint32_t x = i % SIZE, y = i / SIZE;
        const int inside = x >= 3 && x < 8 && y >= 2 && y < 9;
        if (found[i] != (inside ? 3.5f : 2.5f))
            fail_msg("texel %u, %u is %g", x, y, (double)found[i]);
    }
}

static void test_without_attachment(void **state) {
    rig *r = backend_rig(state);
    uint32_t counts[9 * 4];
    strata_buffer buffer = rig_buffer(r, "counts", sizeof counts, NULL);
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN,
                                         "layout(std430) buffer Counts { uint counts[]; };\n"
                                         "void main() {\n"
                                         "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
                                         "    atomicAdd(counts[p.y * 9u + p.x], p.x + 1u);\n"
                                         "}\n");
    const strata_bind bind = rig_bind_buffer("Counts", buffer);
    gpu_begin(r->g, 100, 100);
    for (int i = 0; i < 2; i++)
        rig_pass(r,
                 (strata_pass){
                     .program = program, .binds = &bind, .bind_count = 1, .width = 9, .height = 4});
    rig_submit(r);
    rig_read(r, buffer, counts, sizeof counts);
    for (uint32_t i = 0; i < 36; i++)
        assert_int_equal(counts[i], 2 * (i % 9 + 1));
}

static void test_target_is_sampled(void **state) {
    rig *r = backend_rig(state);
    const float color[4] = {0.5f, 3, 4, 5}, zero[4] = {0};
    float found[SIZE][4];
    strata_image first = rig_image(r, "first", STRATA_FORMAT_RGBA32F, SIZE, 1, 0);
    strata_image depth = rig_image(r, "depth", STRATA_FORMAT_D32F, SIZE, 1, 0);
    strata_image second = rig_image(r, "second", STRATA_FORMAT_RGBA32F, SIZE, 1, 0);
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, backend_flat_color);
    strata_program nothing = rig_program(r, STRATA_PROGRAM_FULLSCREEN, "void main() {}\n");
    strata_program reader =
        rig_program(r, STRATA_PROGRAM_FULLSCREEN,
                    "uniform sampler2D first;\n"
                    "uniform sampler2D depth;\n"
                    "layout(location = 0) out vec4 color;\n"
                    "void main() {\n"
                    "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
                    "    color = texelFetch(first, p, 0);\n"
                    "    color.w += texelFetch(depth, p, 0).x + texture(first, vec2(2.0, 0.5)).x;\n"
                    "}\n");
    const strata_bind binds[] = {rig_bind_image("first", first), rig_bind_image("depth", depth)};
    const strata_attachment a = backend_attach(first, STRATA_LOAD_DISCARD, STRATA_BLEND_NONE);
    const strata_attachment b = backend_attach(second, STRATA_LOAD_DISCARD, STRATA_BLEND_NONE);
    strata_attachment z = backend_attach(depth, STRATA_LOAD_CLEAR, 0);
    z.clear[0] = 0.25f;
    gpu_begin(r->g, SIZE, 1);
    for (int i = 0; i < 2; i++) { /* written again while it was read */
        paint(r, program, &a, i ? color : zero);
        rig_pass(r,
                 (strata_pass){.program = nothing, .depth = &z, .depth_test = STRATA_TEST_ALWAYS});
        rig_pass(
            r,
            (strata_pass){
                .program = reader, .binds = binds, .bind_count = 2, .color = &b, .color_count = 1});
    }
    rig_submit(r);
    rig_texels(r, second, 0, found, sizeof found);
    const float expected[4] = {0.5f, 3, 4, 5 + 0.25f + 0.5f};
    for (uint32_t i = 0; i < SIZE; i++)
        assert_memory_equal(found[i], expected, sizeof expected);
}

const struct CMUnitTest target_tests[] = {
    cmocka_unit_test(test_gradient),          cmocka_unit_test(test_blend_modes),
    cmocka_unit_test(test_masks_and_loads),   cmocka_unit_test(test_eight_targets),
    cmocka_unit_test(test_rectangle),         cmocka_unit_test(test_without_attachment),
    cmocka_unit_test(test_target_is_sampled),
};
const size_t target_test_count = BASE_COUNT(target_tests);
