/* SPDX-License-Identifier: MIT
 *
 * The self-test `sample_routing`: does a fragment reach all samples of its pixel or none, edges or
 * not, and does each sample count in a stencil of its own? Triangles are routed through the samples
 * as plugins/stencil does it: sample i's stencil begins at i + 2, each fragment takes one off, and
 * the one that finds 2 is written. Which triangles cover a pixel, a pass without samples tells.
 */
#include "gpu/gpu_internal.h"

#include <stdlib.h>

#define SIZE      64u /* pixels along a side */
#define TEXELS    (SIZE * SIZE)
#define TRIANGLES 32u /* bits of a word; they lie anywhere, so that edges cross most pixels */
#define MOST      8u  /* samples: what is routed at once */
#define ROUTED    2u

#define CORNER                                                                                     \
    "STRATA_CORNER(v)=vec2(v * 2654435769u >> 24, v * 2246822519u >> 24) / 64.0 - vec2(2.0)"

/* Fragments that are hidden leave by discard, before the stencil. */
#define HIDDEN                                                                                     \
    "bool hidden() { return ((uint(gl_PrimitiveID) + uint(gl_FragCoord.x)) & 3u) == 0u; }\n"

static const strata_glsl begin_source = {"void main() {}\n", "selftest.sample_routing/begin"};
static const strata_glsl route_source = {HIDDEN
                                         "layout(location = 0) out vec4 routed;\n"
                                         "#ifndef LATE\n"
                                         "layout(early_fragment_tests) in;\n"
                                         "#endif\n"
                                         "void main() {\n"
                                         "#ifdef LATE\n"
                                         "    if (hidden())\n"
                                         "        discard;\n"
                                         "#endif\n"
                                         "    routed = unpackUnorm4x8(uint(gl_PrimitiveID) + 1u);\n"
                                         "}\n",
                                         "selftest.sample_routing/route"};
static const strata_glsl mark_source = {
    HIDDEN "layout(early_fragment_tests) in;\n"
           "layout(std430) buffer Marks { uint marks[]; };\n"
           "void main() {\n"
           "#ifdef LATE\n"
           "    if (hidden())\n"
           "        return;\n"
           "#endif\n"
           "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
           "    atomicOr(marks[p.y * 64u + p.x], 1u << gl_PrimitiveID);\n"
           "}\n",
    "selftest.sample_routing/mark"};
static const strata_glsl copy_source = {
    "layout(local_size_x = 8, local_size_y = 8) in;\n"
    "layout(std430) writeonly buffer Marks { uint marks[]; };\n"
    "uniform sampler2DMS samples;\n"
    "STRATA_PARAMS { uint count; } params;\n"
    "void main() {\n"
    "    uvec2 p = gl_GlobalInvocationID.xy;\n"
    "    for (uint i = 0u; i < params.count; ++i)\n"
    "        marks[(p.y * 64u + p.x) * params.count + i] =\n"
    "            packUnorm4x8(texelFetch(samples, ivec2(p), int(i)));\n"
    "}\n",
    "selftest.sample_routing/copy"};

/* Words a pixel: triangles that cover it; that a test of the samples let through; whether the last
 * sample has counted down to 0; and from the fourth on what the samples hold. */
enum { COVERED, PASSED, OVERFLOWED, HELD };

typedef struct routing {
    gpu *g;
    uint32_t samples;
    strata_program begin, route, mark, flag, copy;
    strata_draws draws;
    strata_buffer words;
    strata_attachment color, depth;
    uint32_t *values;
} routing;

/* ---- making ---------------------------------------------------------------------------------- */

static int make_program(gpu_scope *scope, uint32_t kind, const strata_glsl *source,
                        const char *const *defines, uint32_t define_count, strata_program *out) {
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = kind,
                                      .label = "selftest",
                                      .source = source,
                                      .defines = defines,
                                      .define_count = define_count};
    return gpu_program_create(scope, &desc, out, NULL) == STRATA_OK;
}

/* `late`: some fragments are hidden. */
static int make_programs(routing *t, gpu_scope *scope, const char *corner, uint32_t late) {
    const char *const defines[] = {corner, "LATE"};
    const uint32_t fullscreen = STRATA_PROGRAM_FULLSCREEN, compute = STRATA_PROGRAM_COMPUTE;
    return make_program(scope, fullscreen, &begin_source, NULL, 0, &t->begin) &&
           make_program(scope, fullscreen, &mark_source, NULL, 0, &t->flag) &&
           make_program(scope, fullscreen, &route_source, defines, 1 + late, &t->route) &&
           make_program(scope, fullscreen, &mark_source, defines, 1 + late, &t->mark) &&
           make_program(scope, compute, &copy_source, NULL, 0, &t->copy);
}

static int make_image(gpu_scope *scope, uint32_t format, uint32_t samples, strata_attachment *out) {
    const strata_image_desc desc = {.struct_size = sizeof desc,
                                    .format = format,
                                    .label = "samples",
                                    .width = SIZE,
                                    .height = SIZE,
                                    .samples = samples};
    *out = (strata_attachment){.struct_size = sizeof *out};
    return gpu_image_create(scope, &desc, &out->image, NULL) == STRATA_OK;
}

static uint64_t words_size(const routing *t) {
    return (uint64_t)TEXELS * (HELD + t->samples) * sizeof(uint32_t);
}

static int make_objects(routing *t, gpu_scope *scope) {
    const strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = "words", .size = words_size(t)};
    return make_image(scope, STRATA_FORMAT_RGBA8, t->samples, &t->color) &&
           make_image(scope, STRATA_FORMAT_D32F_S8, t->samples, &t->depth) &&
           gpu_buffer_create(scope, &desc, &t->words, NULL) == STRATA_OK &&
           gpu_selftest_draws(scope, TRIANGLES, &t->draws) == STRATA_OK;
}

/* ---- routing --------------------------------------------------------------------------------- */

/* A pass that marks words of one kind. */
static void mark(const routing *t, strata_pass pass, uint32_t kind) {
    const strata_bind binds[] = {
        {.struct_size = sizeof *binds,
         .name = "Marks",
         .buffer = t->words,
         .offset = (uint64_t)kind * TEXELS * sizeof(uint32_t)},
        {.struct_size = sizeof *binds, .name = "samples", .image = t->color.image}};
    pass.struct_size = sizeof pass;
    pass.label = "mark";
    pass.binds = binds;
    pass.bind_count = pass.groups[0] ? 2 : 1;
    gpu_pass(t->g, "selftest", &pass);
}

static void route(routing *t) {
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "begin",
                        .program = t->begin,
                        .depth = &t->depth,
                        .stencil_test = STRATA_TEST_ALWAYS,
                        .stencil_pass = STRATA_STENCIL_REPLACE};
    t->depth.load = STRATA_LOAD_CLEAR;
    for (uint32_t i = 0; i < t->samples; i++) {
        pass.stencil_reference = i + ROUTED;
        pass.sample_mask = 1u << i;
        gpu_pass(t->g, "selftest", &pass);
        t->depth.load = STRATA_LOAD_KEEP;
    }
    t->color.load = STRATA_LOAD_CLEAR;
    pass = (strata_pass){.struct_size = sizeof pass,
                         .label = "route",
                         .program = t->route,
                         .draws = t->draws,
                         .color = &t->color,
                         .color_count = 1,
                         .depth = &t->depth,
                         .stencil_test = STRATA_TEST_EQUAL,
                         .stencil_reference = ROUTED,
                         .stencil_pass = STRATA_STENCIL_DECREMENT,
                         .stencil_fail = STRATA_STENCIL_DECREMENT};
    gpu_pass(t->g, "selftest", &pass);
}

static int run(routing *t) {
    gpu_begin(t->g, SIZE, SIZE);
    gpu_fill(t->g, "selftest", t->words, 0, 0, 0);
    mark(t, (strata_pass){.program = t->mark, .draws = t->draws}, COVERED);
    route(t);
    strata_pass test = {.program = t->mark,
                        .draws = t->draws,
                        .depth = &t->depth,
                        .stencil_test = STRATA_TEST_GREATER,
                        .stencil_reference = ROUTED};
    mark(t, test, PASSED); /* where the first sample was counted down from 2 */
    test.program = t->flag;
    test.draws = (strata_draws){0};
    test.stencil_test = STRATA_TEST_EQUAL;
    test.stencil_reference = 0;
    test.sample_mask = 1u << (t->samples - 1);
    mark(t, test, OVERFLOWED);
    mark(t,
         (strata_pass){.program = t->copy,
                       .groups = {SIZE / 8, SIZE / 8, 1},
                       .params = &t->samples,
                       .params_size = sizeof t->samples},
         HELD);
    return gpu_submit(t->g, NULL) == STRATA_OK &&
           gpu_buffer_read(t->g, t->words, 0, words_size(t), t->values, NULL) == STRATA_OK;
}

/* ---- judging --------------------------------------------------------------------------------- */

/* Sample i holds number i of the triangles that cover the pixel, plus 1, else 0. */
static int pixel_is_exact(const routing *t, uint32_t pixel) {
    const uint32_t covered = t->values[COVERED * TEXELS + pixel];
    const uint32_t passed = t->values[PASSED * TEXELS + pixel];
    const uint32_t overflowed = t->values[OVERFLOWED * TEXELS + pixel];
    const uint32_t *held = t->values + HELD * TEXELS + (size_t)pixel * t->samples;
    uint32_t count = 0, wrong = covered ^ passed;
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        if (!(covered >> i & 1u))
            continue;
        if (count < t->samples)
            wrong |= held[count] ^ (i + 1);
        count++;
    }
    for (uint32_t i = count; i < t->samples; i++)
        wrong |= held[i];
    return !wrong && (overflowed != 0) == (count > t->samples);
}

/* All pixels are exact, some of which have no fragment, and some more than there are samples. */
static int is_exact(const routing *t) {
    uint32_t exact = 0, empty = 0, overflowed = 0;
    for (uint32_t i = 0; i < TEXELS; i++) {
        exact += (uint32_t)pixel_is_exact(t, i);
        empty += !t->values[COVERED * TEXELS + i];
        overflowed += t->values[OVERFLOWED * TEXELS + i] != 0;
    }
    return exact == TEXELS && empty > 0 && overflowed > 0;
}

int gpu_selftest_routing(gpu *g, gpu_scope *scope, const char *corner) {
    routing t = {.g = g, .samples = g->caps.samples < MOST ? g->caps.samples : MOST};
    int exact = t.samples > 1 && make_objects(&t, scope);
    t.values = exact ? base_calloc(1, (size_t)words_size(&t)) : NULL;
    for (uint32_t late = 0; late < 2 && exact; late++)
        exact = t.values && make_programs(&t, scope, corner, late) && run(&t) && is_exact(&t);
    free(t.values);
    return exact;
}

int gpu_selftest_sample_routing(gpu *g, gpu_scope *scope) {
    return gpu_selftest_routing(g, scope, CORNER);
}
