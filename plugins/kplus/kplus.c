/* SPDX-License-Identifier: MIT
 *
 * Technique module `kplus`: the k+-buffer. Captures the nearest k fragments of each pixel, in
 * whatever order they arrive, into fragments/1.
 *
 *   unlocked, interlock, lock
 *                       cells -> store (cull, shade, insert into an array or a heap) -> finish
 *   ordered             needs -> ordered (keys in attachments, payload by slot) -> gather
 *   atomic64, atomic32  empty -> chain (keys by atomicMin) [-> orders] -> payload -> finish
 *
 * With memory=exact, count -> sums -> offsets -> ranges go before and nothing has to finish. k = 0
 * keeps all: exact allocation and a store that has nothing to exclude. k per pixel (grow.c) is
 * exact allocation with a number of its own for each pixel, and grow -> room after the capture.
 */
#include "kplus/grow.h"
#include "kplus/knobs.h"
#include "kplus_glsl.h"
#include "shared/binds.h"
#include "shared/counting.h"
#include "shared/create.h"
#include "shared/records.h"
#include "shared/slots.h"

#include <stdio.h>
#include <string.h>

enum { FINISH_PIXELS = 16, ORDERED_MOST = 16, ATTACHMENTS_MOST = 8, PLACED_ROW = 4096 };

typedef struct kplus {
    const strata_host *host;
    const strata_gpu *gpu;
    strata_draws draws;
    strata_image limit;
    struct {
        uint32_t k, tries;
    } params;
    path path, other; /* other: of attempts after the lock failed */
    uint32_t exact, heap;
    uint32_t texels;            /* 1: cells, and the array's keys besides, in `placed` */
    uint32_t ordered;           /* 1: the device orders accesses of a pixel without any help */
    uint32_t lock_failed, tied; /* 1: learned in verify() */
    counting counting;
    growth growth;
    strata_buffer ranges, cells, events; /* events: failures of the lock, or ties */
    strata_image placed;                 /* texels.glsl */
    strata_image held[ATTACHMENTS_MOST]; /* keys and orders, two records a texel */
    strata_buffer dropped;               /* where no texel has room to count */
    strata_pool records;
    strata_program needs_program, ordered_program, gather_program, cells_program, store_program,
        finish_program, empty_program, chain_program, orders_program, payload_program,
        late_payload_program, swap_program, chain_finish_program;
} kplus;

static const strata_glsl *const includes[] = {
    &array_glsl, &attachments_glsl, &cells_glsl, &chain_glsl,  &descend_glsl,
    &heap_glsl,  &insert_glsl,      &slots_glsl, &texels_glsl, NULL};

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    kplus *s = state;
    s->host = host;
    s->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

static uint32_t has(const kplus *s, const char *fact) {
    return s->gpu->fact(s->gpu->self, fact) != 0;
}

/* Why this device cannot take a path, or NULL. */
static const char *refusal(const kplus *s, path p) {
    if (p == PATH_UNLOCKED && !s->ordered)
        return "unlocked needs accesses in order (selftest.ordered_rmw)";
    if (p == PATH_INTERLOCK && !has(s, "selftest.interlock"))
        return "interlock needs a fragment interlock (selftest.interlock)";
    if (p == PATH_ORDERED && s->params.k > ORDERED_MOST)
        return "ordered keeps at most 16 fragments";
    if (p == PATH_ORDERED && !has(s, "ordered_attachments"))
        return "ordered needs ordered_attachments";
    if (p == PATH_ATOMIC64 && !has(s, "feature.int64_atomics"))
        return "atomic64 needs feature.int64_atomics";
    return NULL;
}

/* What `auto` takes: the first that may. An interlock costs a wait where fragments of a pixel meet;
 * attachments move all keys of the pixel for each fragment, and where storage is not in order too
 * take a second geometry pass, as atomics always do. */
static const path preferred[] = {PATH_UNLOCKED, PATH_INTERLOCK, PATH_ORDERED, PATH_ATOMIC64,
                                 PATH_ATOMIC32};

/* The path of these settings, and the one that stands in for the lock. */
static strata_result choose(kplus *s, const strata_view *view) {
    const double *values = view->settings->values;
    s->ordered = has(s, "selftest.ordered_rmw");
    s->params.k = (uint32_t)values[KNOB_K];
    s->params.tries = (uint32_t)values[KNOB_TRIES];
    s->exact = kplus_is_exact(values);
    s->path = (path)values[KNOB_EXCLUSION];
    if (s->path == PATH_ORDERED && view->tolerance > 0 && s->params.k > ORDERED_MOST)
        s->params.k = ORDERED_MOST; /* the certificate tells whether that is enough */
    s->other = refusal(s, PATH_ATOMIC64) ? PATH_ATOMIC32 : PATH_ATOMIC64;
    for (size_t i = 0; s->path == PATH_AUTO; ++i)
        if (!refusal(s, preferred[i]))
            s->path = preferred[i];
    s->heap = kplus_is_heap(values, view->stats, s->path == PATH_UNLOCKED);
    s->texels = s->path == PATH_UNLOCKED && !s->heap && !s->exact;
    const char *reason = refusal(s, s->path);
    if (s->params.k == 0 || !reason)
        return STRATA_OK;
    s->host->log(s->host->self, 0, reason);
    return STRATA_ERROR_UNSUPPORTED;
}

/* One geometry pass that inserts. */
static int inserts(path p) {
    return p == PATH_UNLOCKED || p == PATH_INTERLOCK || p == PATH_LOCK;
}

static int is_chain(path p) {
    return p == PATH_ATOMIC64 || p == PATH_ATOMIC32;
}

/* Where attachments are in order but storage is not, payloads take a pass of their own. */
static int is_late(const kplus *s) {
    return s->path == PATH_ORDERED && !s->ordered;
}

static uint32_t attachment_count(uint32_t k) {
    return k < ORDERED_MOST ? (k + 2) / 2 : ATTACHMENTS_MOST;
}

static strata_result create_records(kplus *s, const strata_view *view) {
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height;
    return records_create(s->gpu, view, s->heap && inserts(s->path) ? "Nodes" : NULL,
                          s->exact ? 0 : pixels * s->params.k, &s->records);
}

/* A program and which variant of its source it is. */
typedef struct source {
    strata_program *out;
    uint32_t kind;
    const char *label;
    const strata_glsl *glsl;
    const char *variant; /* a define, or NULL */
} source;

static strata_result create_programs(const kplus *s, path p, const source *sources, size_t count) {
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < count && r == STRATA_OK; ++i) {
        const char *defines[8];
        char number[16];
        uint32_t defined = 0;
        snprintf(number, sizeof number, "K=%u", s->params.k);
        if (p == PATH_ORDERED)
            defines[defined++] = number;
        if (is_late(s))
            defines[defined++] = "LATE";
        if (s->growth.begin)
            defines[defined++] = "EACH";
        if (s->exact)
            defines[defined++] = "EXACT";
        if (p == PATH_INTERLOCK)
            defines[defined++] = "STRATA_INTERLOCK";
        if (p == PATH_LOCK)
            defines[defined++] = "LOCK";
        if (p == PATH_LOCK && !s->ordered)
            defines[defined++] = "FENCES";
        if (s->heap)
            defines[defined++] = "HEAP";
        if (s->texels)
            defines[defined++] = "TEXELS";
        if (p == PATH_ATOMIC64)
            defines[defined++] = "WIDE";
        if (sources[i].variant)
            defines[defined++] = sources[i].variant;
        r = s->gpu->program_create(
            s->gpu->self,
            &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                   .kind = sources[i].kind,
                                   .flags = STRATA_PROGRAM_LAZY,
                                   .label = sources[i].label,
                                   .source = sources[i].glsl,
                                   .defines = defines,
                                   .define_count = defined,
                                   .includes = includes},
            sources[i].out);
    }
    return r;
}

static strata_result prepare_insertion(kplus *s) {
    const source sources[] = {
        {&s->cells_program, STRATA_PROGRAM_COMPUTE, "cells", &cells_comp_glsl, NULL},
        {&s->store_program, STRATA_PROGRAM_SCENE, "store", &store_frag_glsl, NULL},
        {&s->finish_program, STRATA_PROGRAM_COMPUTE, "finish", &finish_comp_glsl, NULL},
    };
    return create_programs(s, s->path, sources, sizeof sources / sizeof *sources);
}

static strata_result prepare_chain(kplus *s, path p) {
    const source sources[] = {
        {&s->empty_program, STRATA_PROGRAM_COMPUTE, "empty", &empty_comp_glsl, NULL},
        {&s->chain_program, STRATA_PROGRAM_SCENE, "chain", &chain_frag_glsl, NULL},
        {&s->payload_program, STRATA_PROGRAM_SCENE, "payload", &payload_frag_glsl,
         p == PATH_ATOMIC32 ? "TAKE_ORDERS" : NULL},
        {&s->chain_finish_program, STRATA_PROGRAM_COMPUTE, "finish", &finish_comp_glsl,
         "CHAIN_COUNTS"},
        {&s->orders_program, STRATA_PROGRAM_SCENE, "orders", &chain_frag_glsl, "ORDERS_PASS"},
        {&s->late_payload_program, STRATA_PROGRAM_SCENE, "payload", &payload_frag_glsl, NULL},
        {&s->swap_program, STRATA_PROGRAM_COMPUTE, "swap", &swap_comp_glsl, NULL},
    };
    return create_programs(s, p, sources, sizeof sources / sizeof *sources);
}

static strata_result prepare_ordered(kplus *s, const strata_view *view) {
    const source sources[] = {
        {&s->needs_program, STRATA_PROGRAM_COMPUTE, "needs", &empty_comp_glsl, "NEEDS_ONLY"},
        {&s->ordered_program, STRATA_PROGRAM_SCENE, "ordered", &ordered_frag_glsl, NULL},
        {&s->gather_program, STRATA_PROGRAM_COMPUTE, "gather", &gather_comp_glsl, NULL},
        {&s->late_payload_program, STRATA_PROGRAM_SCENE, "payload", &payload_frag_glsl, NULL},
    };
    strata_result r = create_programs(s, PATH_ORDERED, sources, sizeof sources / sizeof *sources);
    for (uint32_t i = 0; i < attachment_count(s->params.k) && r == STRATA_OK; ++i)
        r = create_image(s->gpu, "nearest", STRATA_FORMAT_RGBA32U, 0, 0, &s->held[i]);
    if (r == STRATA_OK && s->params.k == ORDERED_MOST)
        r = create_buffer(s->gpu, "dropped", (uint64_t)view->band_width * view->band_height * 4,
                          &s->dropped);
    return r == STRATA_OK && !s->exact ? counting_prepare_totals(&s->counting, s->gpu) : r;
}

/* Where a fixed number of slots makes counting needless, what arrived is counted beside. */
static strata_result prepare_arrivals(kplus *s) {
    strata_result r = counting_prepare_image(&s->counting, s->gpu);
    return r == STRATA_OK ? counting_prepare_totals(&s->counting, s->gpu) : r;
}

static strata_result prepare_all(kplus *s) {
    return s->gpu->program_create(s->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = STRATA_PROGRAM_SCENE,
                                                         .label = "store",
                                                         .source = &counting_store_glsl},
                                  &s->store_program);
}

static strata_result create_cells(kplus *s, const strata_view *view) {
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height,
                   rows = (pixels * (s->params.k + 1) + PLACED_ROW - 1) / PLACED_ROW;
    if (!s->texels)
        return create_buffer(s->gpu, "cells", pixels * 8, &s->cells);
    if (rows > s->gpu->fact(s->gpu->self, "limit.image_size"))
        return STRATA_ERROR_OUT_OF_DEVICE_MEMORY; /* bands have fewer */
    return create_image(s->gpu, "keys by place", STRATA_FORMAT_R32U, PLACED_ROW, (uint32_t)rows,
                        &s->placed);
}

static strata_result prepare_path(kplus *s, const strata_view *view) {
    strata_result r = create_buffer(s->gpu, "events", 4, &s->events);
    if (r == STRATA_OK && s->path == PATH_ORDERED)
        return prepare_ordered(s, view);
    if (r == STRATA_OK && inserts(s->path)) {
        r = create_cells(s, view);
        if (r == STRATA_OK)
            r = prepare_insertion(s);
    }
    if (r == STRATA_OK && (is_chain(s->path) || s->path == PATH_LOCK))
        r = prepare_chain(s, is_chain(s->path) ? s->path : s->other);
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    kplus *s = state;
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height;
    s->draws = view->draws(view->self, "draws.transparent/1");
    s->limit = view->image(view->self, "limit/1");
    s->lock_failed = s->tied = 0;
    const uint32_t begin = (uint32_t)view->settings->values[KNOB_BEGIN];
    strata_result r = choose(s, view);
    if (r == STRATA_OK)
        r = growth_prepare(&s->growth, s->gpu, view, begin, s->params.k, includes);
    s->counting.nearest = s->growth.nearest;
    if (r == STRATA_OK)
        r = create_buffer(s->gpu, "ranges", pixels * 8, &s->ranges);
    if (r == STRATA_OK)
        r = create_records(s, view);
    if (r == STRATA_OK && s->exact)
        r = counting_prepare(&s->counting, s->gpu, view, s->params.k == 0);
    else if (r == STRATA_OK && s->path != PATH_ORDERED)
        r = prepare_arrivals(s);
    if (r == STRATA_OK && s->params.k == 0)
        r = prepare_all(s);
    if (r == STRATA_OK && s->params.k > 0)
        r = prepare_path(s, view);
    if (r == STRATA_OK)
        r = view->publish_fragments(
            view->self,
            &(strata_fragments){.struct_size = sizeof(strata_fragments),
                                .layout = STRATA_FRAGMENTS_CONTIGUOUS,
                                .sorted = s->params.k > 0 && (is_chain(s->path) || is_late(s)),
                                .nearest = s->params.k,
                                .ranges = s->ranges,
                                .records = s->records});
    return r;
}

/* ---- record ---------------------------------------------------------------------------------- */

/* What nearly every pass binds: the pool, and ranges where slots_of reads or `writes` them. */
static binds begin_binds(const kplus *s, int writes) {
    binds b = {.count = 0};
    binds_pool(&b, s->records);
    if (s->exact || writes)
        binds_buffer(&b, "StrataRanges", s->ranges);
    return b;
}

static void compute(const kplus *s, const strata_frame *frame, const char *label,
                    strata_program program, const binds *b, uint64_t items, int params) {
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = label,
                        .program = program,
                        .params = params ? &s->params : NULL,
                        .params_size = params ? sizeof s->params : 0,
                        .binds = b->at,
                        .bind_count = b->count};
    strata_groups(items, pass.groups);
    frame->pass(frame->self, &pass);
}

/* A geometry pass onto `count` attachments. */
static void draw(const kplus *s, const strata_frame *frame, const char *label,
                 strata_program program, const binds *b, const strata_attachment *color,
                 uint32_t count, int params) {
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = label,
                       .program = program,
                       .draws = s->draws,
                       .params = params ? &s->params : NULL,
                       .params_size = params ? sizeof s->params : 0,
                       .binds = b->at,
                       .bind_count = b->count,
                       .color = color,
                       .color_count = count,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = s->limit},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

/* One that counts what arrives, unless that was counted before. */
static void draw_counted(const kplus *s, const strata_frame *frame, const char *label,
                         strata_program program, const binds *b, int params) {
    draw(s, frame, label, program, b,
         &(strata_attachment){.struct_size = sizeof(strata_attachment),
                              .image = s->counting.count,
                              .load = STRATA_LOAD_CLEAR,
                              .blend = STRATA_BLEND_ADD},
         s->exact ? 0 : 1, params);
}

static void binds_cells(binds *b, const kplus *s) {
    if (s->texels)
        binds_image(b, "placed", s->placed);
    else
        binds_buffer(b, "Cells", s->cells);
}

static void finish(const kplus *s, const strata_frame *frame, strata_program program, int cells) {
    if (s->exact)
        return;
    binds b = begin_binds(s, 1);
    binds_image(&b, "count_image", s->counting.count);
    binds_buffer(&b, "Totals", s->counting.totals);
    if (cells)
        binds_cells(&b, s);
    frame->fill(frame->self, s->counting.totals, 0, 0, 0);
    compute(s, frame, "finish", program, &b,
            ((uint64_t)frame->band_width * frame->band_height + FINISH_PIXELS - 1) / FINISH_PIXELS,
            1);
}

static void record_insertion(const kplus *s, const strata_frame *frame) {
    binds b = begin_binds(s, 0);
    binds_cells(&b, s);
    if (s->exact)
        binds_image(&b, "count_image", s->counting.count);
    compute(s, frame, "cells", s->cells_program, &b,
            (uint64_t)frame->band_width * frame->band_height, !s->exact);
    b = begin_binds(s, 0);
    binds_cells(&b, s);
    if (s->path == PATH_LOCK)
        binds_buffer(&b, "Failures", s->events);
    draw_counted(s, frame, "store", s->store_program, &b, !s->exact || s->path == PATH_LOCK);
    finish(s, frame, s->finish_program, 1);
}

static void record_chain(const kplus *s, const strata_frame *frame, path p) {
    const uint64_t slots = s->gpu->pool_capacity(s->gpu->self, s->records);
    const int params = !s->exact;
    binds b = begin_binds(s, 0), alone = {.at = {b.at[0]}, .count = 1};
    compute(s, frame, "empty", s->empty_program, &alone, slots, params);
    draw_counted(s, frame, "chain", s->chain_program, &b, params);
    if (p == PATH_ATOMIC32 && s->tied) {
        draw(s, frame, "orders", s->orders_program, &b, NULL, 0, params);
        draw(s, frame, "payload", s->late_payload_program, &b, NULL, 0, params);
    } else {
        binds t = b;
        if (p == PATH_ATOMIC32)
            binds_buffer(&t, "Ties", s->events);
        draw(s, frame, "payload", s->payload_program, &t, NULL, 0, params);
    }
    finish(s, frame, s->chain_finish_program, 0);
    if (p == PATH_ATOMIC64)
        compute(s, frame, "swap", s->swap_program, &alone, slots, 0);
}

static void record_ordered(const kplus *s, const strata_frame *frame) {
    static const char *const names[ATTACHMENTS_MOST] = {"held_0", "held_1", "held_2", "held_3",
                                                        "held_4", "held_5", "held_6", "held_7"};
    const uint32_t count = attachment_count(s->params.k), uncounted = s->dropped.id != 0;
    strata_attachment held[ATTACHMENTS_MOST];
    binds b = begin_binds(s, 0), alone = {.at = {b.at[0]}, .count = 1}, g = begin_binds(s, 1);
    if (is_late(s) && !s->growth.begin)
        b = alone;
    for (uint32_t i = 0; i < count; ++i) {
        held[i] = (strata_attachment){.struct_size = sizeof(strata_attachment),
                                      .image = s->held[i],
                                      .load = STRATA_LOAD_CLEAR,
                                      .read = 1};
        binds_image(&g, names[i], s->held[i]);
    }
    if (uncounted) {
        frame->fill(frame->self, s->dropped, 0, 0, 0);
        binds_buffer(&b, "Dropped", s->dropped);
    }
    if (!s->exact) {
        compute(s, frame, "needs", s->needs_program, &alone, 1, 1);
        frame->fill(frame->self, s->counting.totals, 0, 0, 0);
        binds_buffer(&g, "Totals", s->counting.totals);
        if (uncounted)
            binds_buffer(&g, "Dropped", s->dropped);
    }
    draw(s, frame, "ordered", s->ordered_program, &b, held, count, !s->exact && !is_late(s));
    compute(s, frame, "gather", s->gather_program, &g,
            (uint64_t)frame->band_width * frame->band_height, !s->exact);
    if (is_late(s)) {
        b = begin_binds(s, 0);
        draw(s, frame, "payload", s->late_payload_program, &b, NULL, 0, !s->exact);
    }
}

static void record(void *state, const strata_frame *frame) {
    kplus *s = state;
    const uint32_t k = s->params.k;
    growth_begin(&s->growth, frame);
    if (s->exact)
        counting_record(&s->counting, frame, s->draws, s->limit, s->ranges, s->records,
                        k ? k : COUNTING_ALL);
    if (k == 0) {
        const binds b = begin_binds(s, 0);
        draw(s, frame, "store", s->store_program, &b, NULL, 0, 0);
        return;
    }
    frame->fill(frame->self, s->events, 0, 0, 0);
    if (s->path == PATH_ORDERED)
        record_ordered(s, frame);
    else if (is_chain(s->path))
        record_chain(s, frame, s->path);
    else if (s->lock_failed)
        record_chain(s, frame, s->other);
    else
        record_insertion(s, frame);
    growth_record(&s->growth, frame,
                  &(growth_captured){.ranges = s->ranges,
                                     .events = s->events,
                                     .count = s->counting.count,
                                     .records = s->records});
}

/* A lock that was given up lost a fragment, equal keys may have lost one: both are learned, and the
 * frame is recorded without the lock, or with a pass for the orders. */
static strata_result verify(void *state, const strata_frame *frame) {
    kplus *s = state;
    counting_totals totals;
    uint32_t events = 0;
    strata_result r = counting_verify(&s->counting, frame, &totals);
    if (r != STRATA_OK || s->params.k == 0)
        return r;
    if (is_chain(s->path) || s->path == PATH_LOCK)
        r = frame->read(frame->self, s->events, 0, sizeof events, &events);
    if (r != STRATA_OK || events == 0)
        return r == STRATA_OK ? growth_verify(&s->growth, frame) : r;
    if (s->path == PATH_LOCK && !s->lock_failed)
        s->lock_failed = 1;
    else
        s->tied = 1;
    return STRATA_RETRY;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(kplus));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    const double k = settings->values[KNOB_K];
    const double begin = settings->values[KNOB_BEGIN], least = begin > 0 && begin < k ? begin : k;
    const uint32_t exact = kplus_is_exact(settings->values);
    const uint64_t beside = kplus_is_heap(settings->values, stats, 0) ? 8 /* node */
                            : !exact                                  ? 4 /* texel, if any */
                                                                      : 0;
    const uint64_t record = 8 + records_payload_bytes[(int)settings->values[KNOB_PAYLOAD]] + beside;
    const double share = k > 0 && stats->mean_depth > least ? least / stats->mean_depth : 1;
    cost->bytes_per_pixel = exact ? (begin > 0 ? 24 : 20) : 20 + (uint64_t)k * record;
    cost->bytes_per_fragment = exact ? (uint64_t)(share * (double)record + 1) : 0;
    cost->bytes_fixed = 4096;
    return STRATA_OK;
}

static const strata_slot_use fragments_use = {.struct_size = sizeof(strata_slot_use),
                                              .use = STRATA_SLOT_PRODUCES,
                                              .slot = "fragments/1",
                                              .layouts = 1u << STRATA_FRAGMENTS_CONTIGUOUS};
static const strata_slot_use behind_use = {.struct_size = sizeof(strata_slot_use),
                                           .use = STRATA_SLOT_CONSUMES,
                                           .slot = "color/1",
                                           .optional = 1};
static const strata_slot_use *const slots[] = {&slots_draws, &slots_limit, &fragments_use,
                                               &behind_use};

static const char *const prefers[] = {"ordered_attachments", "selftest.ordered_rmw",
                                      "selftest.interlock", "feature.int64_atomics", NULL};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_NEAREST,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory =
        "fixed: (20 + k record) pixels; exact: 20 pixels + record min(fragments, k each); "
        "begin: exact, 24 pixels, each its own k; "
        "record: 8 + payload, heap 16 + payload, array unlocked in fixed memory 12 + payload; "
        "payload: unorm8 4, half 8, float 16"};

static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 20000,
                                       .per_pixel = 1,
                                       .per_fragment = 2.2,
                                       .per_triangle = 4};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(kplus),
    .id = "kplus",
    .title = "k+-buffer: the nearest k fragments, in whatever order they arrive",
    .reference = "Vasilakis and Fudos 2014",
    .stage = "capture",
    .slots = slots,
    .slot_count = 4,
    .knobs = kplus_knobs,
    .knob_count = KNOB_COUNT,
    .promises = &promises,
    .cost = &cost,
    .prefers = prefers,
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
    .id = "kplus",
    .title = "k+-buffer",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
