/* SPDX-License-Identifier: MIT
 *
 * OpenGL's own corners around attachments: one-layer arrays beside plain images, framebuffers whose
 * images have gone, an image that is target and storage in turn, and stencil values from the
 * fragment shader, which the driver has to take through SPIR-V.
 */
#include "gpu/rig.h"

#define SIZE   16u
#define TEXELS (SIZE * SIZE)

static const char *const flat = "STRATA_PARAMS { vec4 color; } params;\n"
                                "layout(location = 0) out vec4 color;\n"
                                "void main() { color = params.color; }\n";

static int open_rig(void **state) {
    *state = rig_open("gl");
    return 0;
}

static int close_rig(void **state) {
    if (*state)
        rig_close(*state);
    return 0;
}

static rig *rig_of(void **state) {
    if (!*state)
        skip();
    rig_clear(*state);
    return *state;
}

static strata_attachment attach(strata_image image, uint32_t load) {
    return (strata_attachment){
        .struct_size = sizeof(strata_attachment), .image = image, .load = load};
}

static void paint(rig *r, strata_program program, const strata_attachment *color,
                  const strata_attachment *depth, float value) {
    const float values[4] = {value, value, value, value};
    rig_pass(r, (strata_pass){.program = program,
                              .params = values,
                              .params_size = sizeof values,
                              .color = color,
                              .color_count = color ? 1 : 0,
                              .depth = depth,
                              .depth_write = depth != NULL});
}

static void expect_color(rig *r, strata_image image, float value) {
    float found[TEXELS][4];
    rig_texels(r, image, 0, found, sizeof found);
    for (uint32_t i = 0; i < TEXELS; i++)
        assert_true(found[i][0] == value && found[i][3] == value);
}

static void one_layer_array_beside_plain_image(void **state) {
    rig *r = rig_of(state);
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, flat);
    for (uint32_t layers = 0; layers < 2; layers++) {
        for (uint32_t depth_layers = 0; depth_layers < 2; depth_layers++) {
            strata_image image = rig_image(r, "color", STRATA_FORMAT_RGBA32F, SIZE, SIZE, layers);
            strata_image deep = rig_image(r, "depth", STRATA_FORMAT_D32F, SIZE, SIZE, depth_layers);
            const strata_attachment color = attach(image, STRATA_LOAD_CLEAR);
            const strata_attachment depth = attach(deep, STRATA_LOAD_CLEAR);
            gpu_begin(r->g, SIZE, SIZE);
            paint(r, program, &color, &depth, 2);
            rig_submit(r);
            expect_color(r, image, 2);
        }
    }
}

/* A new image may get the name or the address of one that has gone; its framebuffer is another. */
static void framebuffers_go_with_their_images(void **state) {
    rig *r = rig_of(state);
    for (uint32_t i = 0; i < 50; i++) {
        rig_clear(r);
        strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, flat);
        strata_image first = rig_image(r, "first", STRATA_FORMAT_RGBA32F, SIZE, SIZE, 0);
        strata_image second = rig_image(r, "second", STRATA_FORMAT_RGBA32F, SIZE, SIZE, 0);
        const strata_attachment a = attach(first, STRATA_LOAD_DISCARD);
        const strata_attachment b = attach(second, STRATA_LOAD_DISCARD);
        gpu_begin(r->g, SIZE, SIZE);
        paint(r, program, &a, NULL, (float)i);
        paint(r, program, &b, NULL, (float)i + 0.5f);
        rig_submit(r);
        expect_color(r, first, (float)i);
        expect_color(r, second, (float)i + 0.5f);
    }
}

/* Blended into, doubled as storage, blended into: each sees what the one before it wrote. */
static void target_and_storage_in_turn(void **state) {
    rig *r = rig_of(state);
    float expected = 0;
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, flat);
    strata_program twice = rig_program(r, STRATA_PROGRAM_COMPUTE,
                                       "layout(local_size_x = 16, local_size_y = 16) in;\n"
                                       "layout(rgba32f) uniform image2D picture;\n"
                                       "void main() {\n"
                                       "    ivec2 p = ivec2(gl_GlobalInvocationID.xy);\n"
                                       "    imageStore(picture, p, imageLoad(picture, p) * 2.0);\n"
                                       "}\n");
    strata_image image = rig_image(r, "picture", STRATA_FORMAT_RGBA32F, SIZE, SIZE, 0);
    const strata_bind bind = rig_bind_image("picture", image);
    strata_attachment color = attach(image, STRATA_LOAD_KEEP);
    color.blend = STRATA_BLEND_ADD;
    gpu_begin(r->g, SIZE, SIZE);
    for (uint32_t i = 0; i < 10; i++) {
        paint(r, program, &color, NULL, 1);
        rig_pass(r,
                 (strata_pass){.program = twice, .groups = {1}, .binds = &bind, .bind_count = 1});
        expected = (expected + 1) * 2;
    }
    rig_submit(r);
    expect_color(r, image, expected);
}

static void stencil_from_the_shader(void **state) {
    rig *r = rig_of(state);
    if (!gpu_fact(r->g, "feature.stencil_export"))
        skip();
    uint32_t found[TEXELS][2];
    strata_program program =
        rig_program(r, STRATA_PROGRAM_FULLSCREEN,
                    "#extension GL_ARB_shader_stencil_export : require\n"
                    "void main() { gl_FragStencilRefARB = int(gl_FragCoord.x) + 100; }\n");
    strata_image image = rig_image(r, "stencil", STRATA_FORMAT_D32F_S8, SIZE, SIZE, 0);
    const strata_attachment depth = attach(image, STRATA_LOAD_CLEAR);
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, (strata_pass){.program = program,
                              .depth = &depth,
                              .stencil_test = STRATA_TEST_ALWAYS,
                              .stencil_pass = STRATA_STENCIL_REPLACE});
    rig_submit(r);
    rig_texels(r, image, 0, found, sizeof found);
    for (uint32_t i = 0; i < TEXELS; i++)
        assert_int_equal(found[i][1], i % SIZE + 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_layer_array_beside_plain_image),
        cmocka_unit_test(framebuffers_go_with_their_images),
        cmocka_unit_test(target_and_storage_in_turn),
        cmocka_unit_test(stencil_from_the_shader),
    };
    return cmocka_run_group_tests(tests, open_rig, close_rig);
}
