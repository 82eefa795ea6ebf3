/* SPDX-License-Identifier: MIT
 *
 * Arrays as attachments: a clear reaches every layer, what no vertex stage sends elsewhere lands in
 * layer 0, and attachments of different layer counts are refused.
 */
#include "gpu/rig.h"

#define SIZE   8u
#define LAYERS 3u
#define TEXELS (SIZE * SIZE)

static const char *const flat = "STRATA_PARAMS { vec4 color; } params;\n"
                                "layout(location = 0) out vec4 first;\n"
                                "layout(location = 1) out vec4 second;\n"
                                "void main() { first = params.color; second = 2.0 * first; }\n";

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

static void expect(rig *r, strata_image image, uint32_t layer, float value) {
    float found[TEXELS][4];
    rig_texels(r, image, layer, found, sizeof found);
    for (uint32_t i = 0; i < TEXELS; i++)
        if (found[i][0] != value)
            fail_msg("layer %u, texel %u: %g, not %g", layer, i, (double)found[i][0],
                     (double)value);
}

static strata_pass layered_pass(rig *r, strata_attachment color[2], strata_attachment *depth,
                                const float value[4]) {
    const strata_image depth_image = rig_image(r, "depth", STRATA_FORMAT_D32F, SIZE, SIZE, LAYERS);
    for (uint32_t i = 0; i < 2; i++)
        color[i] = (strata_attachment){
            .struct_size = sizeof color[i],
            .image = rig_image(r, "color", STRATA_FORMAT_RGBA32F, SIZE, SIZE, LAYERS),
            .load = STRATA_LOAD_CLEAR,
            .clear = {7.0f + (float)i}};
    *depth = (strata_attachment){.struct_size = sizeof *depth,
                                 .image = depth_image,
                                 .load = STRATA_LOAD_CLEAR,
                                 .clear = {0.25f}};
    return (strata_pass){.program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, flat),
                         .params = value,
                         .params_size = 16,
                         .color = color,
                         .color_count = 2,
                         .depth = depth};
}

static void clears_reach_every_layer(void **state) {
    rig *r = *state;
    if (!r)
        skip();
    rig_clear(r);
    strata_attachment color[2], depth;
    const float value[4] = {3, 3, 3, 3};
    float depths[TEXELS];
    strata_pass pass = layered_pass(r, color, &depth, value);
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, pass);
    rig_submit(r);
    for (uint32_t layer = 0; layer < LAYERS; layer++) {
        expect(r, color[0].image, layer, layer ? 7 : 3);
        expect(r, color[1].image, layer, layer ? 8 : 6);
        rig_texels(r, depth.image, layer, depths, sizeof depths);
        for (uint32_t i = 0; i < TEXELS; i++)
            assert_true(depths[i] == 0.25f);
    }
    color[0].load = color[1].load = STRATA_LOAD_KEEP; /* the other layers are left alone */
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, pass);
    rig_submit(r);
    expect(r, color[0].image, LAYERS - 1, 7);
}

static void layer_counts_agree(void **state) {
    rig *r = *state;
    if (!r)
        skip();
    rig_clear(r);
    strata_attachment color[2], depth;
    const float value[4] = {3, 3, 3, 3};
    base_error err = {0};
    strata_pass pass = layered_pass(r, color, &depth, value);
    for (uint32_t layers = 0; layers < 3; layers++) {
        depth.image = rig_image(r, "deep", STRATA_FORMAT_D32F, SIZE, SIZE, layers);
        gpu_begin(r->g, SIZE, SIZE);
        rig_pass(r, pass);
        assert_int_equal(gpu_submit(r->g, &err), STRATA_ERROR_INVALID_ARGUMENT);
        assert_int_equal(gpu_last_code(r->g), GPU_ERROR_ATTACHMENT_SIZE);
        assert_non_null(strstr(err.text, "deep"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clears_reach_every_layer),
        cmocka_unit_test(layer_counts_agree),
    };
    return cmocka_run_group_tests_name("vulkan", tests, open_vulkan, close_rig) +
           cmocka_run_group_tests_name("gl", tests, open_gl, close_rig);
}
