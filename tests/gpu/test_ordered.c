/* SPDX-License-Identifier: MIT
 *
 * Attachments that shaders read and replace: each pixel sees its fragments in primitive order and
 * loses none, in every format; the vertex stage gives the same depth as in other passes (OpenGL
 * compiles it from text there); resources are found by name; storage written beside it stays.
 */
#include <stdlib.h>

#include "gpu/rig.h"

#define SIZE      64u
#define TEXELS    (SIZE * SIZE)
#define TRIANGLES 400u

typedef struct soup {
    float positions[TRIANGLES * 3][3];
    uint32_t indices[TRIANGLES * 3];
    strata_draws draws;
} soup;

static rig *ordered_rig(void **state) {
    if (!*state)
        skip();
    rig *r = *state;
    rig_clear(r);
    if (!gpu_fact(r->g, "ordered_attachments")) {
        print_message("%s: no ordered attachments\n", r->backend);
        skip();
    }
    return r;
}

/* Triangles of all sizes that reach over the edges of the image, some through the near plane. */
static void make_soup(rig *r, soup *s) {
    const uint32_t command[5] = {TRIANGLES * 3, 1, 0, 0, 0};
    const rig_placement identity = {1, 0, 0, 0, 0};
    uint32_t random = 4711;
    for (uint32_t i = 0; i < TRIANGLES * 3; i++) {
        s->indices[i] = i;
        for (int c = 0; c < 3; c++) {
            random = random * 1664525u + 1013904223u;
            const float unit = (float)(random >> 8) / 16777216.0f;
            s->positions[i][c] = c == 2 ? unit * 1.05f : unit * 2.6f - 1.3f;
        }
    }
    rig_scene(r, SIZE, SIZE, rig_buffer(r, "positions", sizeof s->positions, s->positions),
              &identity, 1);
    s->draws = rig_draws(r, rig_buffer(r, "commands", sizeof command, command), (strata_buffer){0},
                         rig_buffer(r, "indices", sizeof s->indices, s->indices), 1);
}

static strata_attachment reading(strata_image image) {
    return (strata_attachment){.struct_size = sizeof(strata_attachment),
                               .image = image,
                               .load = STRATA_LOAD_CLEAR,
                               .read = 1};
}

/* ---- order and formats ------------------------------------------------------------------- */

/* A hash over the numbers of a pixel's primitives, which no other order gives, beside what comes
 * out of blending and of storage that count the same fragments. */
static const char hashing[] =
    "#include \"strata/ordered.glsl\"\n"
    "STRATA_ORDERED_UINT(0)\n"
    "STRATA_ORDERED_UINT(1)\n"
    "STRATA_ORDERED_UINT(2)\n"
    "STRATA_ORDERED_FLOAT(3)\n"
    "STRATA_ORDERED_FLOAT(4)\n"
    "layout(std430) buffer Log { uint log[]; };\n"
    "void main() {\n"
    "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
    "    uint id = uint(gl_PrimitiveID) + 1u;\n"
    "    uint one = STRATA_ORDERED_LOAD(0).r;\n"
    "    uvec2 two = STRATA_ORDERED_LOAD(1).rg;\n"
    "    uvec4 four = STRATA_ORDERED_LOAD(2);\n"
    "    vec4 floats = STRATA_ORDERED_LOAD(3);\n"
    "    float single = STRATA_ORDERED_LOAD(4).r;\n"
    "    uint at = atomicAdd(log[p.y * 64u + p.x], 1u);\n"
    "    STRATA_ORDERED_STORE(0, uvec4(one * 31u + id, 7, 7, 7));\n"
    "    STRATA_ORDERED_STORE(1, uvec4(two.y + 1u, two.x + 1u, 7, 7));\n"
    "    STRATA_ORDERED_STORE(2, uvec4(id, four.xyz));\n"
    "    STRATA_ORDERED_STORE(3, floats * 0.5 + vec4(float(id), at, 1, 0));\n"
    "    STRATA_ORDERED_STORE(4, vec4(single + 1.0));\n"
    "}\n";

typedef struct hashes {
    uint32_t one[TEXELS], two[TEXELS][2], four[TEXELS][4], log[TEXELS];
    float floats[TEXELS][4], single[TEXELS];
} hashes;

static void draw_hashes(rig *r, const soup *s, hashes *out) {
    static const uint32_t formats[5] = {STRATA_FORMAT_R32U, STRATA_FORMAT_RG32U,
                                        STRATA_FORMAT_RGBA32U, STRATA_FORMAT_RGBA32F,
                                        STRATA_FORMAT_R32F};
    strata_attachment color[5];
    const strata_bind bind = rig_bind_buffer("Log", rig_buffer(r, "log", sizeof out->log, NULL));
    for (int i = 0; i < 5; i++)
        color[i] = reading(rig_image(r, "state", formats[i], SIZE, SIZE, 0));
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, (strata_pass){.program = rig_program(r, STRATA_PROGRAM_SCENE, hashing),
                              .draws = s->draws,
                              .binds = &bind,
                              .bind_count = 1,
                              .color = color,
                              .color_count = 5});
    rig_submit(r);
    rig_texels(r, color[0].image, 0, out->one, sizeof out->one);
    rig_texels(r, color[1].image, 0, out->two, sizeof out->two);
    rig_texels(r, color[2].image, 0, out->four, sizeof out->four);
    rig_texels(r, color[3].image, 0, out->floats, sizeof out->floats);
    rig_texels(r, color[4].image, 0, out->single, sizeof out->single);
    rig_read(r, bind.buffer, out->log, sizeof out->log);
}

static void test_order(void **state) {
    rig *r = ordered_rig(state);
    static soup s;
    static hashes found, again;
    uint32_t deepest = 0;
    make_soup(r, &s);
    draw_hashes(r, &s, &found);
    for (uint32_t i = 0; i < TEXELS; i++) {
        const uint32_t count = found.log[i];
        deepest = count > deepest ? count : deepest;
        assert_int_equal(found.two[i][0], (count + 1) / 2 + count / 2);
        assert_true(found.single[i] == (float)count);
        for (int k = 0; k < 3; k++) /* the last ones, the latest first */
            assert_true(found.four[i][k] > found.four[i][k + 1] || found.four[i][k + 1] == 0);
        assert_true(count < 4 || found.four[i][3] > 0);
    }
    assert_true(deepest > 40);
    draw_hashes(r, &s, &again);
    assert_memory_equal(&found, &again, sizeof found);
    rig_same(r, "hashes", &found, sizeof found);
}

/* ---- depth ------------------------------------------------------------------------------- */

static const char depth_only[] = "void main() {}\n";
static const char largest[] =
    "#include \"strata/ordered.glsl\"\n"
    "STRATA_ORDERED_UINT(0)\n"
    "layout(early_fragment_tests) in;\n"
    "void main() {\n"
    "    uvec4 before = STRATA_ORDERED_LOAD(0);\n"
    "    uint z = floatBitsToUint(gl_FragCoord.z);\n"
    "    STRATA_ORDERED_STORE(0, uvec4(max(before.x, z), before.y + 1u, 0, 0));\n"
    "}\n";

/* The nearest depth by the depth test of a program from SPIR-V is the largest that a program which
 * reads attachments sees, and the nearest fragment passes an EQUAL test there. */
static void test_depth(void **state) {
    rig *r = ordered_rig(state);
    static soup s;
    static float depth[TEXELS];
    static uint32_t all[TEXELS][2], equal[TEXELS][2];
    uint32_t covered = 0;
    make_soup(r, &s);
    strata_attachment z = {.struct_size = sizeof z,
                           .image = rig_image(r, "depth", STRATA_FORMAT_D32F, SIZE, SIZE, 0),
                           .load = STRATA_LOAD_CLEAR};
    const strata_attachment color[2] = {
        reading(rig_image(r, "all", STRATA_FORMAT_RG32U, SIZE, SIZE, 0)),
        reading(rig_image(r, "equal", STRATA_FORMAT_RG32U, SIZE, SIZE, 0))};
    strata_pass pass = {.program = rig_program(r, STRATA_PROGRAM_SCENE, depth_only),
                        .draws = s.draws,
                        .depth = &z,
                        .depth_test = STRATA_TEST_GREATER,
                        .depth_write = 1};
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, pass);
    z.load = STRATA_LOAD_KEEP;
    pass.program = rig_program(r, STRATA_PROGRAM_SCENE, largest);
    pass.depth_write = 0;
    pass.color_count = 1;
    pass.color = &color[0];
    pass.depth_test = STRATA_TEST_NONE;
    rig_pass(r, pass);
    pass.color = &color[1];
    pass.depth_test = STRATA_TEST_EQUAL;
    rig_pass(r, pass);
    rig_submit(r);
    rig_texels(r, z.image, 0, depth, sizeof depth);
    rig_texels(r, color[0].image, 0, all, sizeof all);
    rig_texels(r, color[1].image, 0, equal, sizeof equal);
    for (uint32_t i = 0; i < TEXELS; i++) {
        uint32_t bits;
        memcpy(&bits, &depth[i], sizeof bits);
        assert_int_equal(all[i][0], bits);
        assert_int_equal(equal[i][0], bits);
        assert_true((equal[i][1] > 0) == (all[i][1] > 0));
        covered += all[i][1] > 0;
    }
    assert_true(covered > TEXELS / 2);
    rig_same(r, "all depths", all, sizeof all);
}

/* ---- resources --------------------------------------------------------------------------- */

static const char resources[] =
    "#include \"strata/ordered.glsl\"\n"
    "STRATA_ORDERED_FLOAT(1)\n"
    "layout(location = 0) out uvec4 plain;\n"
    "STRATA_PARAMS { uint first; float second; } params;\n"
    "layout(std140) uniform Block { uvec4 third; };\n"
    "layout(std430) readonly buffer Fourth { uint unused[4]; uint fourth; } named;\n"
    "layout(std430) readonly buffer Idle { uint idle; };\n"
    "uniform sampler2D fifth;\n"
    "uniform usampler2D sixth;\n"
    "layout(r32ui) uniform readonly uimage2D seventh;\n"
    "layout(r32ui) uniform writeonly uimage2D eighth;\n"
    "void main() {\n"
    "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
    "    imageStore(eighth, p, uvec4(8u));\n"
    "    plain = uvec4(params.first, third.z, named.fourth, texelFetch(sixth, p, 0).r);\n"
    "    vec4 before = STRATA_ORDERED_LOAD(1);\n"
    "    STRATA_ORDERED_STORE(1, before + vec4(params.second, texelFetch(fifth, p, 0).r,\n"
    "                                          imageLoad(seventh, p).r, 0.0));\n"
    "}\n";

static strata_image cleared(rig *r, const char *label, uint32_t format, float value) {
    const float values[4] = {value, value, value, value};
    strata_image image = rig_image(r, label, format, SIZE, SIZE, 0);
    gpu_clear_image(r->g, "test", image, values);
    return image;
}

/* Beside a plain attachment; what was in the one that is read is kept. */
static void test_resources(void **state) {
    rig *r = ordered_rig(state);
    static uint32_t plain[TEXELS][4], eighth[TEXELS];
    static float sums[TEXELS][4];
    const uint32_t block[4] = {0, 0, 3, 0}, fourth[5] = {0, 0, 0, 0, 4};
    const struct {
        uint32_t first;
        float second;
    } params = {1, 2};
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, resources);
    gpu_begin(r->g, SIZE, SIZE);
    const strata_bind binds[] = {
        rig_bind_buffer("Block", rig_buffer(r, "block", sizeof block, block)),
        rig_bind_buffer("Fourth", rig_buffer(r, "fourth", sizeof fourth, fourth)),
        rig_bind_image("fifth", cleared(r, "fifth", STRATA_FORMAT_R32F, 5)),
        rig_bind_image("sixth", cleared(r, "sixth", STRATA_FORMAT_R32U, 6)),
        rig_bind_image("seventh", cleared(r, "seventh", STRATA_FORMAT_R32U, 7)),
        rig_bind_image("eighth", cleared(r, "eighth", STRATA_FORMAT_R32U, 0))};
    strata_attachment color[2] = {
        {.struct_size = sizeof *color,
         .image = rig_image(r, "plain", STRATA_FORMAT_RGBA32U, SIZE, SIZE, 0)},
        reading(cleared(r, "sums", STRATA_FORMAT_RGBA32F, 0.5f))};
    color[1].load = STRATA_LOAD_KEEP;
    strata_pass pass = {.program = program,
                        .params = &params,
                        .params_size = sizeof params,
                        .binds = binds,
                        .bind_count = 6,
                        .color = color,
                        .color_count = 2};
    rig_pass(r, pass);
    rig_pass(r, pass);
    rig_submit(r);
    rig_texels(r, color[0].image, 0, plain, sizeof plain);
    rig_texels(r, color[1].image, 0, sums, sizeof sums);
    rig_texels(r, binds[5].image, 0, eighth, sizeof eighth);
    for (uint32_t i = 0; i < TEXELS; i++) {
        const uint32_t wanted[4] = {1, 3, 4, 6};
        const float sum[4] = {4.5f, 10.5f, 14.5f, 0.5f};
        assert_memory_equal(plain[i], wanted, sizeof wanted);
        assert_memory_equal(sums[i], sum, sizeof sum);
        assert_int_equal(eighth[i], 8);
    }
}

/* ---- lifetimes and limits ---------------------------------------------------------------- */

static const char stepping[] = "#include \"strata/ordered.glsl\"\n"
                               "STRATA_ORDERED_UINT(0)\n"
                               "void main() {\n"
                               "    STRATA_ORDERED_STORE(0, STRATA_ORDERED_LOAD(0) * 10u + 3u);\n"
                               "}\n";

/* A part of the image, twice in a frame, after which its images make room for others. */
static void test_rectangle(void **state) {
    rig *r = ordered_rig(state);
    uint32_t found[TEXELS];
    for (int round = 0; round < 3; round++) {
        rig_clear(r);
        strata_attachment color = reading(rig_image(r, "state", STRATA_FORMAT_R32U, SIZE, SIZE, 0));
        strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, stepping);
        color.clear[0] = 1;
        gpu_begin(r->g, SIZE, SIZE);
        gpu_rectangle(r->g, 3, 5, 20, 10);
        rig_pass(r, (strata_pass){.program = program, .color = &color, .color_count = 1});
        color.load = STRATA_LOAD_KEEP;
        rig_pass(r, (strata_pass){.program = program, .color = &color, .color_count = 1});
        rig_submit(r);
        rig_texels(r, color.image, 0, found, sizeof found);
        for (uint32_t i = 0; i < TEXELS; i++) {
            const uint32_t x = i % SIZE, y = i / SIZE;
            const int inside = x >= 3 && x < 23 && y >= 5 && y < 15;
            assert_int_equal(found[i], inside ? 133 : 1);
        }
    }
}

static void test_lacking(void **state) {
    rig *r = *state;
    const strata_glsl source = {.text = stepping, .path = "stepping.glsl"};
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_FULLSCREEN,
                                      .label = "stepping",
                                      .source = &source};
    strata_program program;
    base_error err = {0};
    gpu *g = NULL;
    if (!r)
        skip();
    const gpu_open_info info = {.backend = r->backend, .inject = "lacks:ordered_attachments"};
    assert_int_equal(gpu_open(&info, &g, &err), STRATA_OK);
    assert_int_equal(gpu_fact(g, "ordered_attachments"), 0);
    assert_int_equal(gpu_program_create(gpu_scope_create(g, "test"), &desc, &program, &err),
                     STRATA_ERROR_UNSUPPORTED);
    assert_int_equal(gpu_last_code(g), GPU_ERROR_ORDERED_MISSING);
    assert_non_null(strstr(err.text, "stepping"));
    gpu_close(g);
}

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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_order),     cmocka_unit_test(test_depth),
        cmocka_unit_test(test_resources), cmocka_unit_test(test_rectangle),
        cmocka_unit_test(test_lacking),
    };
    return cmocka_run_group_tests_name("vulkan", tests, open_vulkan, close_rig) +
           cmocka_run_group_tests_name("gl", tests, open_gl, close_rig);
}
