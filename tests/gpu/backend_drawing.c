/* SPDX-License-Identifier: MIT
 *
 * Passes that draw a scene, on every backend: indirect draws, culling, depth and stencil tests.
 */
#include "gpu/backend_tests.h"
#include "gpu/gpu_internal.h"
#include "gpu/vk/vk_internal.h"

#include <stdlib.h>

#define SIZE   16u
#define TEXELS 256u /* SIZE x SIZE */

/* ---- scene passes ------------------------------------------------------------------------ */

typedef struct command {
    uint32_t index_count, instance_count, first_index;
    int32_t vertex_offset;
    uint32_t first_instance;
} command;

/* Unit squares of two triangles: vertices 0-3 wind counter-clockwise, 4-7 clockwise. */
static const float squares[8][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0},
                                    {-1, -1, 0}, {-1, 1, 0}, {1, 1, 0}, {1, -1, 0}};
static const uint32_t square_indices[7] = {99, 0, 1, 2, 0, 2, 3};

static strata_draws make_draws(rig *r, const command *commands, uint32_t capacity,
                               strata_buffer count) {
    strata_buffer buffer = rig_buffer(r, "commands", capacity * sizeof *commands, commands);
    strata_buffer indices = rig_buffer(r, "indices", sizeof square_indices, square_indices);
    return rig_draws(r, buffer, count, indices, capacity);
}

static void place(rig *r, const rig_placement *placements, uint32_t count) {
    strata_buffer positions = rig_buffer(r, "positions", sizeof squares, squares);
    rig_scene(r, SIZE, SIZE, positions, placements, count);
}

/* Four cells of 4 x 4 texels on the lowest row of cells. */
static const rig_placement cells[4] = {{0.25f, -0.75f, -0.75f, 0.5f, 1000},
                                       {0.25f, -0.25f, -0.75f, 0.5f, 2000},
                                       {0.25f, 0.25f, -0.75f, 0.5f, 3000},
                                       {0.25f, 0.75f, -0.75f, 0.5f, 4000}};
static const char id_shader[] = "layout(location = 0) flat in uvec4 ids;\n"
                                "layout(location = 0) out uvec4 color;\n"
                                "void main() {\n"
                                "    color = uvec4(ids.y + uint(gl_PrimitiveID) + 1u);\n"
                                "    if (!gl_FrontFacing) color += 100u;\n"
                                "}\n";

/* Each cell has its record's base plus 1 and 2: lower right and upper left triangle. */
static void check_cells(const uint32_t found[TEXELS], const uint32_t bases[4]) {
    for (uint32_t i = 0; i < TEXELS; i++) {
        const uint32_t x = i % SIZE, y = i / SIZE, base = y < 4 ? bases[x / 4] : 0;
        if (x % 4 == y) { /* an edge runs through the centre: either, the backends agree */
            assert_true(!base ? !found[i] || y > 3 : found[i] - base - 1 < 2);
            continue;
        }
        if (found[i] != (base ? base + (x % 4 > y ? 1 : 2) : 0))
            fail_msg("texel %u, %u is %u, of base %u", x, y, found[i], base);
    }
}

static void draw_cells(rig *r, strata_draws draws, uint32_t cull, uint32_t found[TEXELS]) {
    strata_image image = rig_image(r, "ids", STRATA_FORMAT_R32U, SIZE, SIZE, 0);
    strata_program program = rig_program(r, STRATA_PROGRAM_SCENE, id_shader);
    const strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, STRATA_BLEND_NONE);
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(
        r,
        (strata_pass){
            .program = program, .draws = draws, .cull = cull, .color = &target, .color_count = 1});
    rig_submit(r);
    rig_texels(r, image, 0, found, TEXELS * sizeof *found);
}

static void test_multi_draw(void **state) {
    rig *r = backend_rig(state);
    const command commands[] = {{6, 2, 1, 0, 1}, {6, 1, 1, 0, 3}, {6, 1, 1, 0, 0}};
    const uint32_t all[4] = {1000, 2000, 3000, 4000}, two[4] = {0, 2000, 3000, 4000};
    uint32_t found[TEXELS], count = 2;
    place(r, cells, 4);
    draw_cells(r, make_draws(r, commands, 3, (strata_buffer){0}), 0, found);
    check_cells(found, all);
    rig_same(r, "multi-draw", found, sizeof found);
    draw_cells(r, make_draws(r, commands, 3, rig_buffer(r, "count", 4, &count)), 0, found);
    check_cells(found, two);
    count = 0;
    draw_cells(r, make_draws(r, commands, 3, rig_buffer(r, "count", 4, &count)), 0, found);
    for (uint32_t i = 0; i < TEXELS; i++)
        assert_int_equal(found[i], 0);
}

/* A count is that of its draw alone. */
static void test_draws_after_counted_ones(void **state) {
    rig *r = backend_rig(state);
    const command commands[] = {{6, 2, 1, 0, 1}, {6, 1, 1, 0, 3}, {6, 1, 1, 0, 0}};
    const uint32_t all[4] = {1000, 2000, 3000, 4000}, none = 0;
    uint32_t found[TEXELS];
    place(r, cells, 4);
    strata_image image = rig_image(r, "ids", STRATA_FORMAT_R32U, SIZE, SIZE, 0);
    const strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, STRATA_BLEND_NONE);
    strata_pass pass = {.program = rig_program(r, STRATA_PROGRAM_SCENE, id_shader),
                        .draws = make_draws(r, commands, 3, rig_buffer(r, "count", 4, &none)),
                        .color = &target,
                        .color_count = 1};
    const strata_draws uncounted = make_draws(r, commands, 3, (strata_buffer){0});
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, pass);
    pass.draws = uncounted;
    rig_pass(r, pass);
    rig_submit(r);
    rig_texels(r, image, 0, found, sizeof found);
    check_cells(found, all);
}

/* Devices may take few draws at a time; a counted draw cannot be split. */
static void test_draw_limit(void **state) {
    rig *r = backend_rig(state);
    const command commands[] = {{6, 1, 1, 0, 1}, {6, 1, 1, 0, 3}, {6, 1, 1, 0, 0}, {6, 1, 1, 0, 2}};
    const uint32_t all[4] = {1000, 2000, 3000, 4000}, count = 4;
    uint32_t found[TEXELS];
    base_error err = {0};
    if (strcmp(r->backend, "vulkan") != 0)
        skip();
    uint32_t *limit = &((vk *)r->g->self)->limits.maxDrawIndirectCount;
    const uint32_t before = *limit;
    *limit = 3;
    place(r, cells, 4);
    draw_cells(r, make_draws(r, commands, 4, (strata_buffer){0}), 0, found);
    check_cells(found, all);
    strata_image image = rig_image(r, "ids", STRATA_FORMAT_R32U, SIZE, SIZE, 0);
    const strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, STRATA_BLEND_NONE);
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, (strata_pass){.program = rig_program(r, STRATA_PROGRAM_SCENE, id_shader),
                              .draws = make_draws(r, commands, 4, rig_buffer(r, "n", 4, &count)),
                              .color = &target,
                              .color_count = 1});
    *limit = before;
    assert_int_equal(gpu_submit(r->g, &err), STRATA_ERROR_UNSUPPORTED);
}

/* Counter-clockwise as seen with row 0 at the bottom is front; cells 1 and 3 are turned around. */
static void test_facing_and_culling(void **state) {
    rig *r = backend_rig(state);
    const command commands[] = {{3, 1, 1, 0, 0}, {3, 1, 1, 4, 1}, {3, 1, 1, 0, 2}, {3, 1, 1, 4, 3}};
    uint32_t found[TEXELS];
    place(r, cells, 4);
    strata_draws draws = make_draws(r, commands, 4, (strata_buffer){0});
    for (uint32_t cull = 0; cull < 3; cull++) {
        draw_cells(r, draws, cull, found);
        const uint32_t ccw = cull == 2 ? 0 : 1001, cw = cull == 1 ? 0 : 2101;
        assert_int_equal(found[1 * SIZE + 3], ccw);
        assert_int_equal(found[1 * SIZE + 8 + 3], ccw ? ccw + 2000 : 0);
        assert_int_equal(found[3 * SIZE + 4 + 1], cw);
        assert_int_equal(found[3 * SIZE + 12 + 1], cw ? cw + 2000 : 0);
    }
}

static const rig_placement stack[5] = {{1, 0, 0, 0.25f, 0},
                                       {0.5f, 0.5f, 0, 0.75f, 0},
                                       {1, 0, 0, 0.5f, 0},
                                       {1, 0, 0, 0.5f, 0},
                                       {1, 0, 0, 0.125f, 0}};

static void test_depth(void **state) {
    rig *r = backend_rig(state);
    const command commands[] = {{6, 5, 1, 0, 0}};
    const float one[4] = {1, 0, 0, 0};
    float counts[TEXELS], depths[TEXELS];
    strata_image count = rig_image(r, "count", STRATA_FORMAT_R32F, SIZE, SIZE, 0);
    strata_image depth = rig_image(r, "depth", STRATA_FORMAT_D32F, SIZE, SIZE, 0);
    strata_program program = rig_program(r, STRATA_PROGRAM_SCENE, backend_flat_color);
    place(r, stack, 5);
    const strata_attachment target = backend_attach(count, STRATA_LOAD_CLEAR, STRATA_BLEND_ADD);
    strata_attachment z = backend_attach(depth, STRATA_LOAD_CLEAR, 0);
    strata_pass pass = {.program = program,
                        .params = one,
                        .params_size = 16,
                        .draws = make_draws(r, commands, 1, (strata_buffer){0}),
                        .color = &target,
                        .color_count = 1,
                        .depth = &z,
                        .depth_test = STRATA_TEST_GREATER,
                        .depth_write = 1};
    const struct {
        uint32_t test, write;
        float near, far; /* how many of the squares pass where the small one is, and elsewhere */
    } cases[] = {{STRATA_TEST_GREATER, 1, 2, 2},       {STRATA_TEST_EQUAL, 0, 1, 2},
                 {STRATA_TEST_GREATER_EQUAL, 0, 1, 2}, {STRATA_TEST_LESS, 0, 4, 2},
                 {STRATA_TEST_LESS_EQUAL, 0, 5, 4},    {STRATA_TEST_NOT_EQUAL, 0, 4, 2},
                 {STRATA_TEST_NEVER, 0, 0, 0},         {STRATA_TEST_NONE, 0, 5, 4}};
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        pass.depth_test = cases[i].test;
        pass.depth_write = cases[i].write;
        z.load = i ? STRATA_LOAD_KEEP : STRATA_LOAD_CLEAR;
        gpu_begin(r->g, SIZE, SIZE);
        rig_pass(r, pass);
        rig_submit(r);
        rig_texels(r, count, 0, counts, sizeof counts);
        rig_texels(r, depth, 0, depths, sizeof depths);
        for (uint32_t k = 0; k < TEXELS; k++) {
            const int near = k % SIZE >= 8 && k / SIZE >= 4 && k / SIZE < 12;
            assert_true(depths[k] == (near ? 0.75f : 0.5f));
            if (counts[k] != (near ? cases[i].near : cases[i].far))
                fail_msg("test %u: texel %u has %g", cases[i].test, k, (double)counts[k]);
        }
    }
}

/* ---- stencil ----------------------------------------------------------------------------- */

typedef struct depth_stencil {
    float depth;
    uint32_t stencil;
} depth_stencil;

typedef struct stencil_case {
    uint32_t before, test, reference, pass, fail, keep, after, drawn;
} stencil_case;

static const stencil_case stencil_cases[] = {
    {5, STRATA_TEST_NONE, 7, STRATA_STENCIL_REPLACE, 0, 0, 5, 1},
    {5, STRATA_TEST_ALWAYS, 7, STRATA_STENCIL_REPLACE, 0, 0, 7, 1},
    {5, STRATA_TEST_ALWAYS, 7, STRATA_STENCIL_KEEP, 0, 0, 5, 1},
    {5, STRATA_TEST_ALWAYS, 7, STRATA_STENCIL_ZERO, 0, 0, 0, 1},
    {254, STRATA_TEST_ALWAYS, 7, STRATA_STENCIL_INCREMENT, 0, 0, 255, 1},
    {255, STRATA_TEST_ALWAYS, 7, STRATA_STENCIL_INCREMENT, 0, 0, 255, 1},
    {0, STRATA_TEST_ALWAYS, 7, STRATA_STENCIL_DECREMENT, 0, 0, 0, 1},
    {9, STRATA_TEST_EQUAL, 9, STRATA_STENCIL_DECREMENT, 0, 0, 8, 1},
    {9, STRATA_TEST_EQUAL, 8, STRATA_STENCIL_ZERO, STRATA_STENCIL_INCREMENT, 0, 10, 0},
    {9, STRATA_TEST_LESS, 8, STRATA_STENCIL_INCREMENT, 0, 0, 10, 1}, /* reference < value */
    {9, STRATA_TEST_GREATER, 8, STRATA_STENCIL_INCREMENT, 0, 0, 9, 0},
    {0xa5, STRATA_TEST_EQUAL, 0x35, STRATA_STENCIL_ZERO, 0, 0xf0, 0xa0, 1},
    {0xa5, STRATA_TEST_ALWAYS, 0xff, STRATA_STENCIL_REPLACE, 0, 0x0f, 0xf5, 1},
};

static void test_stencil(void **state) {
    rig *r = backend_rig(state);
    const float one[4] = {1, 0, 0, 0};
    strata_image color = rig_image(r, "color", STRATA_FORMAT_R32F, 1, 1, 0);
    strata_image depth = rig_image(r, "depth", STRATA_FORMAT_D32F_S8, 1, 1, 0);
    strata_program program = rig_program(r, STRATA_PROGRAM_FULLSCREEN, backend_flat_color);
    const strata_attachment target = backend_attach(color, STRATA_LOAD_CLEAR, STRATA_BLEND_ADD);
    for (size_t i = 0; i < BASE_COUNT(stencil_cases); i++) {
        const stencil_case *c = &stencil_cases[i];
        strata_attachment z = backend_attach(depth, STRATA_LOAD_CLEAR, 0);
        depth_stencil found;
        float drawn;
        z.clear[0] = 0.5f;
        z.clear[1] = (float)c->before;
        gpu_begin(r->g, 1, 1);
        rig_pass(r, (strata_pass){.program = program,
                                  .params = one,
                                  .params_size = 16,
                                  .color = &target,
                                  .color_count = 1,
                                  .depth = &z,
                                  .stencil_test = c->test,
                                  .stencil_reference = c->reference,
                                  .stencil_pass = c->pass,
                                  .stencil_fail = c->fail,
                                  .stencil_keep_mask = c->keep});
        rig_submit(r);
        rig_texels(r, depth, 0, &found, sizeof found);
        rig_texels(r, color, 0, &drawn, sizeof drawn);
        if (found.stencil != c->after || drawn != (float)c->drawn || found.depth != 0.5f)
            fail_msg("case %zu: stencil %u, drawn %g, depth %g", i, found.stencil, (double)drawn,
                     (double)found.depth);
    }
}

/* A fragment that passes the stencil but not the depth test counts as failed. */
static void test_stencil_depth_fail(void **state) {
    rig *r = backend_rig(state);
    const command commands[] = {{6, 5, 1, 0, 0}};
    const float one[4] = {1, 0, 0, 0};
    depth_stencil found[TEXELS];
    strata_image depth = rig_image(r, "depth", STRATA_FORMAT_D32F_S8, SIZE, SIZE, 0);
    strata_image color = rig_image(r, "color", STRATA_FORMAT_R32F, SIZE, SIZE, 0);
    strata_program program = rig_program(r, STRATA_PROGRAM_SCENE, backend_flat_color);
    const strata_attachment target = backend_attach(color, STRATA_LOAD_CLEAR, STRATA_BLEND_ADD);
    strata_attachment z = backend_attach(depth, STRATA_LOAD_CLEAR, 0);
    z.clear[0] = 0.4f;
    z.clear[1] = 100;
    place(r, stack, 5);
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, (strata_pass){.program = program,
                              .params = one,
                              .params_size = 16,
                              .draws = make_draws(r, commands, 1, (strata_buffer){0}),
                              .color = &target,
                              .color_count = 1,
                              .depth = &z,
                              .depth_test = STRATA_TEST_GREATER,
                              .stencil_test = STRATA_TEST_ALWAYS,
                              .stencil_pass = STRATA_STENCIL_KEEP,
                              .stencil_fail = STRATA_STENCIL_INCREMENT});
    rig_submit(r);
    rig_texels(r, depth, 0, found, sizeof found);
    for (uint32_t i = 0; i < TEXELS; i++)
        assert_int_equal(found[i].stencil, 102); /* those at 0.25 and 0.125 */
}

/* ---- made on the GPU --------------------------------------------------------------------- */

/* Positions, commands and their count come from compute in the same frame. */
static void test_generated_draws(void **state) {
    rig *r = backend_rig(state);
    const uint32_t all[4] = {1000, 2000, 3000, 4000};
    uint32_t found[TEXELS];
    strata_buffer positions = rig_buffer(r, "positions", sizeof squares, NULL);
    strata_buffer commands = rig_buffer(r, "commands", 8 * sizeof(command), NULL);
    strata_buffer count = rig_buffer(r, "count", 4, NULL);
    strata_buffer indices = rig_buffer(r, "indices", sizeof square_indices, NULL);
    strata_program maker = rig_program(
        r, STRATA_PROGRAM_COMPUTE,
        "layout(local_size_x = 1) in;\n"
        "layout(std430) writeonly buffer Positions { float p[]; };\n"
        "layout(std430) writeonly buffer Commands { uint c[]; };\n"
        "layout(std430) buffer Count { uint count; };\n"
        "layout(std430) writeonly buffer Indices { uint n[]; };\n"
        "void main() {\n"
        "    for (uint i = 0u; i < 4u; ++i) {\n"
        "        p[3u * i] = i == 1u || i == 2u ? 1.0 : -1.0;\n"
        "        p[3u * i + 1u] = i > 1u ? 1.0 : -1.0;\n"
        "        p[3u * i + 2u] = 0.0;\n"
        "        uint k = 5u * atomicAdd(count, 1u);\n"
        "        c[k] = 6u; c[k + 1u] = 1u; c[k + 2u] = 0u; c[k + 3u] = 0u; c[k + 4u] = i;\n"
        "    }\n"
        "    n[0] = 0u; n[1] = 1u; n[2] = 2u; n[3] = 0u; n[4] = 2u; n[5] = 3u;\n"
        "}\n");
    const strata_bind binds[] = {
        rig_bind_buffer("Positions", positions), rig_bind_buffer("Commands", commands),
        rig_bind_buffer("Count", count), rig_bind_buffer("Indices", indices)};
    rig_scene(r, SIZE, SIZE, positions, cells, 4);
    strata_image image = rig_image(r, "ids", STRATA_FORMAT_R32U, SIZE, SIZE, 0);
    strata_program program = rig_program(r, STRATA_PROGRAM_SCENE, id_shader);
    const strata_attachment target = backend_attach(image, STRATA_LOAD_CLEAR, STRATA_BLEND_NONE);
    gpu_begin(r->g, SIZE, SIZE);
    rig_pass(r, (strata_pass){.program = maker, .groups = {1}, .binds = binds, .bind_count = 4});
    rig_pass(r, (strata_pass){.program = program,
                              .draws = rig_draws(r, commands, count, indices, 8),
                              .color = &target,
                              .color_count = 1});
    rig_submit(r);
    rig_texels(r, image, 0, found, sizeof found);
    check_cells(found, all);
}

/* Many small triangles at many depths: what is counted and kept agrees between the backends. */
static void test_soup(void **state) {
    rig *r = backend_rig(state);
    enum { TRIANGLES = 500, SIDE = 64 };
    static float positions[TRIANGLES * 3][3], counts[SIDE * SIDE], depths[SIDE * SIDE];
    static uint32_t indices[TRIANGLES * 3];
    uint32_t random = 12345;
    for (uint32_t i = 0; i < TRIANGLES * 3; i++) {
        indices[i] = i;
        for (int c = 0; c < 3; c++) {
            random = random * 1664525u + 1013904223u;
            const float unit = (float)(random >> 8) / 16777216.0f;
            positions[i][c] = c == 2 ? unit : unit * 1.8f - 0.9f;
        }
    }
    const command commands[] = {{TRIANGLES * 3, 1, 0, 0, 0}};
    const rig_placement identity = {1, 0, 0, 0, 0};
    const float one[4] = {1, 0, 0, 0};
    rig_scene(r, SIDE, SIDE, rig_buffer(r, "positions", sizeof positions, positions), &identity, 1);
    strata_buffer buffer = rig_buffer(r, "commands", sizeof commands, commands);
    strata_image count = rig_image(r, "count", STRATA_FORMAT_R32F, SIDE, SIDE, 0);
    strata_image depth = rig_image(r, "depth", STRATA_FORMAT_D32F, SIDE, SIDE, 0);
    const strata_attachment target = backend_attach(count, STRATA_LOAD_CLEAR, STRATA_BLEND_ADD);
    strata_attachment z = backend_attach(depth, STRATA_LOAD_CLEAR, 0);
    strata_pass pass = {.program = rig_program(r, STRATA_PROGRAM_SCENE, backend_flat_color),
                        .params = one,
                        .params_size = 16,
                        .draws = rig_draws(r, buffer, (strata_buffer){0},
                                           rig_buffer(r, "indices", sizeof indices, indices), 1),
                        .color = &target,
                        .color_count = 1,
                        .depth = &z,
                        .depth_test = STRATA_TEST_GREATER,
                        .depth_write = 1};
    gpu_begin(r->g, SIDE, SIDE);
    rig_pass(r, pass);
    z.load = STRATA_LOAD_KEEP;
    pass.depth_test = STRATA_TEST_EQUAL;
    pass.depth_write = 0;
    rig_pass(r, pass); /* the nearest of each covered texel, once */
    rig_submit(r);
    rig_texels(r, count, 0, counts, sizeof counts);
    rig_texels(r, depth, 0, depths, sizeof depths);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        assert_true(counts[i] == (depths[i] > 0 ? 1.0f : 0.0f));
    rig_same(r, "soup depths", depths, sizeof depths);
    pass.depth = NULL;
    pass.depth_test = 0;
    gpu_begin(r->g, SIDE, SIDE);
    rig_pass(r, pass);
    rig_submit(r);
    rig_texels(r, count, 0, counts, sizeof counts);
    rig_same(r, "soup counts", counts, sizeof counts);
}

const struct CMUnitTest drawing_tests[] = {
    cmocka_unit_test(test_multi_draw),
    cmocka_unit_test(test_draws_after_counted_ones),
    cmocka_unit_test(test_draw_limit),
    cmocka_unit_test(test_facing_and_culling),
    cmocka_unit_test(test_depth),
    cmocka_unit_test(test_stencil),
    cmocka_unit_test(test_stencil_depth_fail),
    cmocka_unit_test(test_generated_draws),
    cmocka_unit_test(test_soup),
};
const size_t drawing_test_count = BASE_COUNT(drawing_tests);
