/* SPDX-License-Identifier: MIT
 *
 * Technique module `cullcheck`: whether those that cull were right. Once everything opaque is drawn
 * and the transparent objects are culled too, it draws everything again against the final depth:
 * a culled object with a fragment there is one that should have been drawn.
 *
 *   seen     all draws, opaque and transparent, GREATER_EQUAL -> a mark for each object
 *   judge    marks against the objects' states -> how many are wrong, and the first
 *   show     optional: a picture of the states, or of the depth's blocks, in place of the image
 *
 * It knows the slot objects/1 alone, and none of those that cull.
 */
#include "cullcheck_glsl.h"
#include "shared/binds.h"
#include "shared/create.h"
#include "strata/strata.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { CHUNK = 32 }; /* as in judge.comp.glsl */
enum { KNOB_SHOW, KNOB_LEVEL };
enum { SHOW_NONE, SHOW_STATES, SHOW_PYRAMID };
enum { VISIBLE, WRONG, FIRST, OVERSHOT, VERDICTS };

typedef struct cullcheck {
    const strata_gpu *gpu;
    uint32_t count; /* objects; 0: nothing to do */
    uint32_t show, width, height;
    uint32_t params[2]; /* of show=pyramid: level, blocks in a row */
    strata_draws opaque, transparent;
    strata_image color, depth;
    strata_buffer seen, verdict, blocks;
    strata_program seen_program, judge, drawn, culled, blocks_program, pyramid;
} cullcheck;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((cullcheck *)state)->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

static strata_result create_programs(cullcheck *c) {
    static const strata_glsl *const includes[] = {&object_glsl, NULL};
    static const char *const defines[] = {"STRATA_WANTS_RECORD", "CULLCHECK_CULLED"};
    const struct {
        strata_program *out;
        const char *label;
        const strata_glsl *source;
        uint32_t kind, show, defines;
    } rows[] = {
        {&c->seen_program, "seen", &seen_frag_glsl, STRATA_PROGRAM_SCENE, SHOW_NONE, 1},
        {&c->judge, "judge", &judge_comp_glsl, STRATA_PROGRAM_COMPUTE, SHOW_NONE, 0},
        {&c->drawn, "drawn", &states_frag_glsl, STRATA_PROGRAM_SCENE, SHOW_STATES, 1},
        {&c->culled, "culled", &states_frag_glsl, STRATA_PROGRAM_SCENE, SHOW_STATES, 2},
        {&c->blocks_program, "blocks", &blocks_comp_glsl, STRATA_PROGRAM_COMPUTE, SHOW_PYRAMID, 0},
        {&c->pyramid, "pyramid", &pyramid_frag_glsl, STRATA_PROGRAM_FULLSCREEN, SHOW_PYRAMID, 0},
    };
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && r == STRATA_OK; ++i)
        if (rows[i].show == SHOW_NONE || rows[i].show == c->show)
            r = c->gpu->program_create(
                c->gpu->self,
                &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                       .kind = rows[i].kind,
                                       .label = rows[i].label,
                                       .source = rows[i].source,
                                       .defines = defines,
                                       .define_count = rows[i].defines,
                                       .includes = includes},
                rows[i].out);
    return r;
}

static strata_result create_blocks(cullcheck *c) {
    const uint32_t last = (1u << c->params[0]) - 1u, level = c->params[0];
    const uint64_t rows = ((uint64_t)c->height + last) >> level;
    c->params[1] = (uint32_t)(((uint64_t)c->width + last) >> level);
    return create_buffer(c->gpu, "blocks", 8 + 4 * c->params[1] * rows, &c->blocks);
}

static strata_result prepare(void *state, const strata_view *view) {
    cullcheck *c = state;
    c->count = view->object_count;
    if (c->count == 0)
        return STRATA_OK;
    c->show = (uint32_t)view->settings->values[KNOB_SHOW];
    c->params[0] = (uint32_t)view->settings->values[KNOB_LEVEL];
    c->width = view->width;
    c->height = view->height;
    c->opaque = view->draws(view->self, "draws.opaque.all/1");
    c->transparent = view->draws(view->self, "draws.transparent.all/1");
    c->color = view->image(view->self, "color/1");
    c->depth = view->image(view->self, "depth/1");
    strata_result r = create_buffer(c->gpu, "seen", c->count * UINT64_C(4), &c->seen);
    if (r == STRATA_OK)
        r = create_buffer(c->gpu, "verdict", VERDICTS * 4, &c->verdict);
    if (r == STRATA_OK && c->show == SHOW_PYRAMID)
        r = create_blocks(c);
    return r == STRATA_OK ? create_programs(c) : r;
}

/* ---- record ---------------------------------------------------------------------------------- */

static void record_seen(const cullcheck *c, const strata_frame *frame, strata_draws draws) {
    const strata_attachment depth = {.struct_size = sizeof depth, .image = c->depth};
    const strata_bind seen = bind_buffer("Seen", c->seen);
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "seen",
                                            .program = c->seen_program,
                                            .draws = draws,
                                            .binds = &seen,
                                            .bind_count = 1,
                                            .depth = &depth,
                                            .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static void record_judge(const cullcheck *c, const strata_frame *frame) {
    binds b = {.count = 0};
    binds_buffer(&b, "Seen", c->seen);
    binds_buffer(&b, "Verdict", c->verdict);
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "judge",
                        .program = c->judge,
                        .binds = b.at,
                        .bind_count = b.count,
                        .params = &c->count,
                        .params_size = sizeof c->count};
    strata_groups(((uint64_t)c->count + CHUNK - 1) / CHUNK, pass.groups);
    frame->fill(frame->self, c->verdict, 0, 0, 0);
    frame->fill(frame->self, c->verdict, FIRST * 4, 4, UINT32_MAX);
    frame->pass(frame->self, &pass);
}

/* `culled`: without a depth test, translucent. */
static void record_states(const cullcheck *c, const strata_frame *frame, uint32_t culled,
                          uint32_t transparent) {
    const strata_attachment depth = {.struct_size = sizeof depth, .image = c->depth};
    const strata_attachment color = {.struct_size = sizeof color,
                                     .image = c->color,
                                     .load = culled || transparent ? STRATA_LOAD_KEEP
                                                                   : STRATA_LOAD_CLEAR,
                                     .blend = STRATA_BLEND_OVER,
                                     .clear = {0.01f, 0.01f, 0.01f, 1.0f}};
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "states",
                                            .program = culled ? c->culled : c->drawn,
                                            .draws = transparent ? c->transparent : c->opaque,
                                            .color = &color,
                                            .color_count = 1,
                                            .depth = &depth,
                                            .depth_test = culled ? STRATA_TEST_NONE
                                                                 : STRATA_TEST_GREATER_EQUAL});
}

static void record_pyramid(const cullcheck *c, const strata_frame *frame) {
    const strata_attachment color = {.struct_size = sizeof color, .image = c->color};
    binds b = {.count = 0};
    binds_buffer(&b, "Blocks", c->blocks);
    frame->fill(frame->self, c->blocks, 0, 0, UINT32_MAX);
    frame->fill(frame->self, c->blocks, 4, 4, 0);
    const strata_pass show = {.struct_size = sizeof show,
                              .label = "pyramid",
                              .program = c->pyramid,
                              .binds = b.at,
                              .bind_count = b.count,
                              .params = c->params,
                              .params_size = sizeof c->params,
                              .color = &color,
                              .color_count = 1};
    binds blocks = b;
    binds_image(&blocks, "depth_image", c->depth);
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "blocks",
                        .program = c->blocks_program,
                        .binds = blocks.at,
                        .bind_count = blocks.count,
                        .params = c->params,
                        .params_size = sizeof c->params};
    strata_groups((uint64_t)c->width * c->height, pass.groups);
    frame->pass(frame->self, &pass);
    frame->pass(frame->self, &show);
}

/* When all that is opaque has been drawn: it consumes depth/1, so that there is such a call. */
static void record(void *state, const strata_frame *frame) {
    const cullcheck *c = state;
    if (c->count == 0 || frame->round < frame->rounds)
        return;
    frame->fill(frame->self, c->seen, 0, 0, 0);
    record_seen(c, frame, c->opaque);
    record_seen(c, frame, c->transparent);
    record_judge(c, frame);
    for (uint32_t i = 0; i < 4 && c->show == SHOW_STATES; ++i)
        record_states(c, frame, i / 2, i % 2);
    if (c->show == SHOW_PYRAMID)
        record_pyramid(c, frame);
}

static strata_result verify(void *state, const strata_frame *frame) {
    const cullcheck *c = state;
    uint32_t verdict[VERDICTS] = {0};
    char line[160];
    if (c->count == 0)
        return STRATA_OK;
    const strata_result r = frame->read(frame->self, c->verdict, 0, sizeof verdict, verdict);
    if (r != STRATA_OK)
        return r;
    frame->report(frame->self, STRATA_REPORT_OBJECTS_VISIBLE, verdict[VISIBLE]);
    frame->report(frame->self, STRATA_REPORT_OBJECTS_WRONG, verdict[WRONG]);
    frame->report(frame->self, STRATA_REPORT_OBJECTS_OVERSHOT, verdict[OVERSHOT]);
    if (verdict[WRONG] == 0)
        return STRATA_OK;
    snprintf(line, sizeof line,
             "%" PRIu32 " of %" PRIu32 " objects are culled and visible, the "
             "first of them object %" PRIu32,
             verdict[WRONG], c->count, verdict[FIRST]);
    frame->fail(frame->self, STRATA_ERROR_MODULE, line);
    return STRATA_ERROR_MODULE;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(cullcheck));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    cost->bytes_per_pixel = settings->values[KNOB_SHOW] >= SHOW_PYRAMID ? 4 : 0;
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 4096 + 4ull * stats->instances;
    return STRATA_OK;
}

static const strata_slot_use opaque_use = {.struct_size = sizeof(strata_slot_use),
                                           .use = STRATA_SLOT_CONSUMES,
                                           .slot = "draws.opaque.all/1"};
static const strata_slot_use transparent_use = {.struct_size = sizeof(strata_slot_use),
                                                .use = STRATA_SLOT_CONSUMES,
                                                .slot = "draws.transparent.all/1",
                                                .optional = 1};
static const strata_slot_use objects_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "objects/1"};
static const strata_slot_use depth_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "depth/1"};
static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use *const slots[] = {&opaque_use, &transparent_use, &objects_use,
                                               &depth_use, &color_use};

static const char *const show_choices[] = {"none", "states", "pyramid", NULL};
static const strata_knob show = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "show",
                                 .title = "a picture in place of the image: why objects were drawn "
                                          "or culled, or a level of the pyramid of depth",
                                 .maximum = 2,
                                 .choices = show_choices};
static const strata_knob level = {.struct_size = sizeof(strata_knob),
                                  .type = STRATA_KNOB_INT,
                                  .name = "level",
                                  .title = "of the pyramid that is shown: blocks of 2^n pixels",
                                  .maximum = 16,
                                  .preset = 3};
static const strata_knob *const knobs[] = {&show, &level};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory = "4 objects; and the host's 148 an object; show=pyramid: 4 a block"};

static const strata_cost_model cost = {
    .struct_size = sizeof(strata_cost_model), .frame = 4000, .per_triangle = 8};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(cullcheck),
    .id = "cullcheck",
    .title = "Checks that no visible object was culled",
    .stage = "draws",
    .slots = slots,
    .slot_count = 5,
    .knobs = knobs,
    .knob_count = 2,
    .promises = &promises,
    .cost = &cost,
    .estimate = estimate,
    .create = create,
    .prepare = prepare,
    .record = record,
    .verify = verify,
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "cullcheck",
    .title = "Checks of culling",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
