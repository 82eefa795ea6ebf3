/* SPDX-License-Identifier: MIT
 *
 * Technique module `occupancy`: how deep a capture of the nearest k fragments needs to look
 * (Vasilakis and Papaioannou 2015).
 *
 *   range -> tiles   how a tile of pixels divides its depths into S buckets
 *   clear, mask      one bit for each bucket that holds a fragment
 *   limit            the far edge of the bucket with the k-th bit becomes limit/1
 *   sums, lost       what that hides: its number, and where a certificate is asked for its light
 *
 * Fills limit/1. Whatever is drawn against it by early depth test loses no fragment of the nearest
 * k. Stands before any capture that keeps the nearest k; neither knows of the other.
 */
#include "occupancy_glsl.h"
#include "shared/binds.h"
#include "shared/counting.h"
#include "shared/create.h"
#include "shared/slots.h"
#include "strata/strata.h"

#include <stdio.h>
#include <string.h>

enum { TILE = 8, MAX_BUCKETS = 1024 }; /* TILE: as in buckets.glsl */

typedef struct occupancy {
    const strata_gpu *gpu;
    uint32_t nearest, certify, words, tiles_x, tiles_y;
    uint32_t ordered; /* 1: plain accesses of a pixel's fragments are in order */
    strata_draws draws;
    strata_image depth, range, tiles, mask, count, limit;
    strata_buffer totals;
    strata_program range_program, tiles_program, clear_program, mask_program, limit_program,
        sums_program, lost_program; /* lost_program: where a certificate is asked for */
} occupancy;

static strata_result program(const occupancy *o, uint32_t kind, const char *label,
                             const strata_glsl *source, strata_program *out) {
    static const strata_glsl *const includes[] = {&buckets_glsl, NULL};
    char words[48], nearest[48];
    const char *const defines[] = {words, nearest, "ORDERED"};
    snprintf(words, sizeof words, "OCCUPANCY_WORDS=%uu", o->words);
    snprintf(nearest, sizeof nearest, "OCCUPANCY_NEAREST=%uu", o->nearest);
    return o->gpu->program_create(o->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = kind,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = defines,
                                                         .define_count = 2 + o->ordered,
                                                         .includes = includes},
                                  out);
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    occupancy *o = state;
    o->gpu = gpu;
    o->ordered = gpu->fact(gpu->self, "selftest.ordered_rmw") != 0;
    return STRATA_OK;
}

/* Four buckets for each fragment that is kept, and two for each that there is: with n fragments
 * over S buckets, about n/S / (1 - exp(-n/S)) times k survive. */
static uint32_t mask_words(const strata_settings *settings, uint32_t nearest, double depth) {
    uint32_t buckets = (uint32_t)settings->values[0];
    if (buckets == 0)
        for (buckets = 32; buckets < MAX_BUCKETS && (buckets / 4 < nearest || buckets < 2 * depth);)
            buckets *= 2;
    return (buckets + 31) / 32;
}

static strata_result create_storage(occupancy *o, const strata_view *view) {
    o->tiles_x = (view->width + TILE - 1) / TILE;
    o->tiles_y = (view->height + TILE - 1) / TILE;
    strata_result r = create_image(o->gpu, "depth range", STRATA_FORMAT_RGBA32F, o->tiles_x,
                                   o->tiles_y, &o->range);
    if (r == STRATA_OK)
        r = create_image(o->gpu, "fragment count", STRATA_FORMAT_R32F, 0, 0, &o->count);
    if (r == STRATA_OK)
        r = create_image(o->gpu, "limit/1", STRATA_FORMAT_D32F, 0, 0, &o->limit);
    if (r == STRATA_OK)
        r = create_image(o->gpu, "tiles", STRATA_FORMAT_RGBA32U, o->tiles_x, o->tiles_y, &o->tiles);
    if (r == STRATA_OK)
        r = create_array(o->gpu, "mask", STRATA_FORMAT_R32U, view->band_width, view->band_height,
                         o->words, &o->mask);
    if (r == STRATA_OK)
        r = create_buffer(o->gpu, "totals", sizeof(counting_totals), &o->totals);
    return r;
}

static strata_result create_programs(occupancy *o) {
    strata_result r =
        program(o, STRATA_PROGRAM_SCENE, "range", &range_frag_glsl, &o->range_program);
    if (r == STRATA_OK)
        r = program(o, STRATA_PROGRAM_COMPUTE, "tiles", &tiles_comp_glsl, &o->tiles_program);
    if (r == STRATA_OK)
        r = program(o, STRATA_PROGRAM_FULLSCREEN, "clear", &clear_frag_glsl, &o->clear_program);
    if (r == STRATA_OK)
        r = program(o, STRATA_PROGRAM_SCENE, "mask", &mask_frag_glsl, &o->mask_program);
    if (r == STRATA_OK)
        r = program(o, STRATA_PROGRAM_FULLSCREEN, "limit", &limit_frag_glsl, &o->limit_program);
    if (r == STRATA_OK)
        r = program(o, STRATA_PROGRAM_COMPUTE, "sums", &sums_comp_glsl, &o->sums_program);
    if (r == STRATA_OK && o->certify)
        r = program(o, STRATA_PROGRAM_SCENE, "lost", &lost_frag_glsl, &o->lost_program);
    return r;
}

/* Where all fragments are kept, limit/1 stays what it is: no limit is nearer and loses nothing. */
static strata_result prepare(void *state, const strata_view *view) {
    occupancy *o = state;
    o->nearest = view->nearest;
    o->certify = view->certify;
    if (o->nearest == 0)
        return STRATA_OK;
    o->words = mask_words(view->settings, o->nearest, view->stats->mean_depth);
    o->draws = view->draws(view->self, "draws.transparent/1");
    o->depth = view->image(view->self, "depth/1");
    strata_result r = create_storage(o, view);
    if (r == STRATA_OK)
        r = create_programs(o);
    return r == STRATA_OK ? view->publish_image(view->self, "limit/1", o->limit) : r;
}

/* For the whole frame, once: bands share it. */
static void record_tiles(const occupancy *o, const strata_frame *frame) {
    const strata_bind bound[] = {bind_image("range_image", o->range),
                                 bind_image("depth_image", o->depth),
                                 bind_image("tiles", o->tiles)};
    strata_pass tiles = {.struct_size = sizeof tiles,
                         .label = "tiles",
                         .program = o->tiles_program,
                         .binds = bound,
                         .bind_count = 3};
    strata_groups((uint64_t)o->tiles_x * o->tiles_y, tiles.groups);
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "range",
                       .program = o->range_program,
                       .draws = o->draws,
                       .color = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = o->range,
                                                     .load = STRATA_LOAD_CLEAR,
                                                     .blend = STRATA_BLEND_MAX,
                                                     .clear = {-2, -2, -2, -2}},
                       .color_count = 1,
                       .whole_frame = 1});
    frame->pass(frame->self, &tiles);
}

static void record_mask(const occupancy *o, const strata_frame *frame) {
    const strata_bind bound[] = {bind_image("tiles", o->tiles), bind_image("mask", o->mask)};
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "clear",
                       .program = o->clear_program,
                       .color = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = o->mask,
                                                     .load = STRATA_LOAD_CLEAR},
                       .color_count = 1,
                       .whole_frame = 1});
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "mask",
                       .program = o->mask_program,
                       .draws = o->draws,
                       .binds = bound,
                       .bind_count = 2,
                       .color = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = o->count,
                                                     .load = STRATA_LOAD_CLEAR,
                                                     .blend = STRATA_BLEND_ADD},
                       .color_count = 1,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = o->depth},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static void record_limit(const occupancy *o, const strata_frame *frame) {
    const strata_bind bound[] = {bind_image("depth_image", o->depth), bind_image("tiles", o->tiles),
                                 bind_image("mask", o->mask)};
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "limit",
                       .program = o->limit_program,
                       .binds = bound,
                       .bind_count = 3,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = o->limit},
                       .depth_test = STRATA_TEST_ALWAYS,
                       .depth_write = 1});
}

static void record_sums(const occupancy *o, const strata_frame *frame) {
    const strata_bind bound[] = {bind_image("count_image", o->count),
                                 bind_buffer("Totals", o->totals)};
    strata_pass sums = {.struct_size = sizeof sums,
                        .label = "sums",
                        .program = o->sums_program,
                        .binds = bound,
                        .bind_count = 2};
    strata_groups(((uint64_t)frame->band_width * frame->band_height + 3) / 4, sums.groups);
    frame->fill(frame->self, o->totals, 0, 0, 0);
    frame->pass(frame->self, &sums);
}

static void record_lost(const occupancy *o, const strata_frame *frame) {
    const strata_bind limit = bind_image("limit_image", o->limit);
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "lost",
                       .program = o->lost_program,
                       .draws = o->draws,
                       .binds = &limit,
                       .bind_count = 1,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = o->depth},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static void record(void *state, const strata_frame *frame) {
    const occupancy *o = state;
    if (o->nearest == 0)
        return;
    if (frame->band == 0)
        record_tiles(o, frame);
    record_mask(o, frame);
    record_limit(o, frame);
    record_sums(o, frame);
    if (o->certify)
        record_lost(o, frame);
}

/* What it hides no other technique sees: the frame's total is counted here. */
static strata_result verify(void *state, const strata_frame *frame) {
    const occupancy *o = state;
    counting_totals totals = {0};
    if (o->nearest == 0)
        return STRATA_OK;
    strata_result r = frame->read(frame->self, o->totals, 0, sizeof totals, &totals);
    if (r == STRATA_OK)
        frame->report(frame->self, STRATA_REPORT_FRAGMENTS_TOTAL,
                      (uint64_t)totals.arrived[1] << 32 | totals.arrived[0]);
    return r;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(occupancy));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

/* Of the largest mask that `auto` takes for k = 32. */
static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    cost->bytes_per_pixel = 9 + 4ull * mask_words(settings, 32, stats->mean_depth);
    cost->bytes_fixed = 64;
    return STRATA_OK;
}

static const strata_slot_use depth_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "depth/1"};
static const strata_slot_use limit_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_PRODUCES, .slot = "limit/1"};
static const strata_slot_use *const slots[] = {&slots_draws, &depth_use, &limit_use};

static const strata_knob buckets = {.struct_size = sizeof(strata_knob),
                                    .type = STRATA_KNOB_INT,
                                    .name = "buckets",
                                    .title = "intervals of depth a pixel, in steps of 32; 0: at "
                                             "least 4 k and twice the mean depth complexity",
                                    .maximum = MAX_BUCKETS};
static const strata_knob *const knobs[] = {&buckets};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_NEAREST,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory = "(S / 8) pixels of the band + 8.5 pixels of the frame; S: buckets"};

static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 20000,
                                       .per_pixel = 0.3,
                                       .per_fragment = 1.5,
                                       .per_triangle = 8};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(occupancy),
    .id = "occupancy",
    .title = "occupancy culling: hides what lies behind the nearest k fragments",
    .reference = "Vasilakis and Papaioannou 2015",
    .stage = "clip",
    .slots = slots,
    .slot_count = 3,
    .knobs = knobs,
    .knob_count = 1,
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
    .id = "occupancy",
    .title = "Occupancy culling",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
