/* SPDX-License-Identifier: MIT
 *
 * Technique module `ppc`: pixel-parallel composite. Resolves fragments/1 into color/1.
 *
 *   histogram -> dispatch -> lists       pixels in classes of 1, 2-8, -16, -32, -64, more fragments
 *   resolve, once for each class         one invocation a pixel, a sorting network in registers
 *   ties -> tied                         pixels with equal keys, by (key, order)
 *   owners -> blocks -> merge.. -> walk  pixels with more than 64: sorted blocks, merged along
 * paths
 *
 * Which classes a scene has is learned in verify(): a program for a class that never occurs is not
 * even compiled.
 */
#include "ppc_glsl.h"
#include "shared/classes.h"
#include "shared/slots.h"

#include <stddef.h>
#include <string.h>

enum { WALK_CHUNK = 32768 };

typedef struct ppc {
    const strata_gpu *gpu;
    const strata_fragments *fragments;
    strata_image color;
    classes classes;
    strata_pool deep, block, slot, walk, index;
    strata_program dispatch_program, owners_program, gather_program, blocks_program, merge_program,
        walk_program;
    uint32_t rounds, walks; /* of merging and folding deep pixels that are recorded */
} ppc;

static const strata_glsl *const includes[] = {&classes_glsl, &deep_glsl, NULL};

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((ppc *)state)->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare ------------------------------------------------------------------------------------
 */

static strata_result prepare_programs(ppc *p) {
    const struct {
        strata_program *out;
        const char *label;
        const strata_glsl *glsl;
        uint32_t flags;
    } sources[] = {
        {&p->dispatch_program, "dispatch", &dispatch_comp_glsl, 0},
        {&p->owners_program, "owners", &owners_comp_glsl, STRATA_PROGRAM_LAZY},
        {&p->blocks_program, "blocks", &blocks_comp_glsl, STRATA_PROGRAM_LAZY},
        {&p->merge_program, "merge", &merge_comp_glsl, STRATA_PROGRAM_LAZY},
        {&p->walk_program, "walk", &walk_comp_glsl, STRATA_PROGRAM_LAZY},
        {&p->gather_program, "gather", &gather_comp_glsl, STRATA_PROGRAM_LAZY},
    };
    const size_t count = p->fragments->layout == STRATA_FRAGMENTS_LINKED ? 6 : 5;
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < count && r == STRATA_OK; ++i)
        r = p->gpu->program_create(
            p->gpu->self,
            &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                   .kind = STRATA_PROGRAM_COMPUTE,
                                   .flags = sources[i].flags,
                                   .label = sources[i].label,
                                   .source = sources[i].glsl,
                                   .includes = includes},
            sources[i].out);
    return r;
}

static strata_result prepare_pools(ppc *p) {
    const int linked = p->fragments->layout == STRATA_FRAGMENTS_LINKED;
    const struct {
        strata_pool *out;
        strata_pool_desc desc;
    } pools[] = {
        {&p->deep,
         {.label = "deep pixels",
          .counter_name = "DeepPool",
          .plane_count = linked ? 2 : 1,
          .plane_names = {"DeepBase", "DeepCursor"},
          .plane_strides = {4, 4}}},
        {&p->block,
         {.label = "blocks",
          .counter_name = "BlockPool",
          .plane_count = 1,
          .plane_names = {"BlockOwner"},
          .plane_strides = {4}}},
        {&p->slot,
         {.label = "slots",
          .counter_name = "SlotPool",
          .plane_count = 2,
          .plane_names = {"Slots0", "Slots1"},
          .plane_strides = {4, 4}}},
        {&p->walk,
         {.label = "walks",
          .counter_name = "WalkPool",
          .plane_count = 1,
          .plane_names = {"WalkState"},
          .plane_strides = {8}}},
        {&p->index,
         {.label = "deep index",
          .counter_name = "IndexPool",
          .plane_count = 1,
          .plane_names = {"DeepIndex"},
          .plane_strides = {4}}},
    };
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < (linked ? 5u : 4u) && r == STRATA_OK; ++i) {
        strata_pool_desc desc = pools[i].desc;
        desc.struct_size = sizeof desc;
        r = p->gpu->pool_create(p->gpu->self, &desc, pools[i].out);
    }
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    ppc *p = state;
    p->fragments = view->fragments(view->self);
    p->color = view->image(view->self, "color/1");
    strata_result r = classes_prepare(&p->classes, p->gpu, view, 1, 0);
    if (r == STRATA_OK)
        r = prepare_pools(p);
    if (r == STRATA_OK)
        r = prepare_programs(p);
    return r;
}

/* ---- record -------------------------------------------------------------------------------------
 */

static void dispatch_indirect(const ppc *p, const strata_frame *frame, const char *label,
                              strata_program program, const binds *b, uint64_t offset,
                              const uint32_t params[2]) {
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = label,
                                            .program = program,
                                            .indirect = p->classes.table,
                                            .indirect_offset = offset,
                                            .params = params,
                                            .params_size = params ? 8 : 0,
                                            .binds = b->at,
                                            .bind_count = b->count});
}

static void dispatch(const strata_frame *frame, const char *label, strata_program program,
                     const binds *b, const uint32_t groups[3]) {
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = label,
                                            .program = program,
                                            .groups = {groups[0], groups[1], groups[2]},
                                            .binds = b->at,
                                            .bind_count = b->count});
}

static void record_classify(const ppc *p, const strata_frame *frame) {
    const int linked = p->fragments->layout == STRATA_FRAGMENTS_LINKED;
    classes_record_histogram(&p->classes, frame);

    binds b = {.count = 0};
    binds_buffer(&b, "Classes", p->classes.table);
    binds_pool(&b, p->fragments->records);
    binds_pool(&b, p->deep);
    binds_pool(&b, p->block);
    binds_pool(&b, p->slot);
    binds_pool(&b, p->walk);
    if (linked)
        binds_pool(&b, p->index);
    dispatch(frame, "dispatch", p->dispatch_program, &b, (const uint32_t[]){1, 1, 1});

    b.count = 0;
    binds_pool(&b, p->deep);
    if (linked)
        binds_pool(&b, p->index);
    classes_record_lists(&p->classes, frame, &b);
}

static void record_deep(const ppc *p, const strata_frame *frame) {
    const uint64_t deep = offsetof(classes_table, classes[CLASSES_DEEP].groups),
                   block = offsetof(classes_table, block_groups);
    const int linked = p->fragments->layout == STRATA_FRAGMENTS_LINKED;
    binds b = {.count = 0};
    binds_buffer(&b, "StrataRanges", p->fragments->ranges);
    binds_pool(&b, p->fragments->records);
    binds_pool(&b, p->deep);
    binds_pool(&b, p->block);
    binds_pool(&b, p->slot);
    binds_buffer(&b, "Classes", p->classes.table);
    const uint32_t common = b.count;
    binds_buffer(&b, "Lists", p->classes.lists);

    dispatch_indirect(p, frame, "owners", p->owners_program, &b, deep, NULL);
    if (linked) {
        binds g = b;
        uint32_t groups[3];
        g.count = common;
        binds_pool(&g, p->index);
        strata_groups(p->gpu->pool_capacity(p->gpu->self, p->fragments->records), groups);
        dispatch(frame, "gather", p->gather_program, &g, groups);
    }
    dispatch_indirect(p, frame, "blocks", p->blocks_program, &b, block, NULL);
    for (uint32_t i = 0; i < p->rounds; ++i)
        dispatch_indirect(p, frame, "merge", p->merge_program, &b, block,
                          (const uint32_t[]){(uint32_t)CLASSES_BLOCK << i, i & 1u});
    binds_pool(&b, p->walk);
    binds_image(&b, "color", p->color);
    for (uint32_t i = 0; i < p->walks; ++i)
        dispatch_indirect(p, frame, "walk", p->walk_program, &b, deep,
                          (const uint32_t[]){p->rounds & 1u, i * (uint32_t)WALK_CHUNK});
}

static int has_deep(const ppc *p) {
    return (int)(p->classes.seen >> CLASSES_DEEP & 1u);
}

static void record(void *state, const strata_frame *frame) {
    const ppc *p = state;
    record_classify(p, frame);
    classes_record_folds(&p->classes, frame);
    if (has_deep(p))
        record_deep(p, frame);
}

/* ---- verify: what the next attempt has to record
 * -------------------------------------------------- */

/* Merges of deep pixels, so that the largest is one sorted run. */
static uint32_t rounds_of(uint32_t largest) {
    const uint64_t blocks = ((uint64_t)largest + CLASSES_BLOCK - 1) / CLASSES_BLOCK;
    uint32_t rounds = 0;
    while ((1ull << rounds) < blocks)
        ++rounds;
    return rounds;
}

/* One more merge than needed is taken along in a scene that moves. */
static void learn_deep(ppc *p, uint32_t largest, uint64_t frame) {
    const uint32_t rounds = rounds_of(largest) + (frame > 0);
    p->rounds = rounds > p->rounds ? rounds : p->rounds;
    p->walks = largest / WALK_CHUNK + 1 > p->walks ? largest / WALK_CHUNK + 1 : p->walks;
}

static strata_result verify(void *state, const strata_frame *frame) {
    ppc *p = state;
    classes_table t = {.largest = 0};
    strata_result r = frame->read(frame->self, p->classes.table, 0, sizeof t, &t);
    if (r != STRATA_OK)
        return r;
    uint32_t tied;
    const uint32_t missing = classes_learn(&p->classes, frame, &t, &tied);
    const int deep =
        t.classes[CLASSES_DEEP].count > 0 &&
        (rounds_of(t.largest) > p->rounds || t.largest > p->walks * (uint64_t)WALK_CHUNK);
    frame->report(frame->self, STRATA_REPORT_MAX_PER_PIXEL, t.largest);
    if (!missing && !tied && !deep)
        return STRATA_OK;
    if (has_deep(p))
        learn_deep(p, t.largest, frame->index);
    return STRATA_RETRY;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(ppc));
}

/* ---- what the plan reads
 * -------------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)settings;
    cost->bytes_per_pixel = 4;
    cost->bytes_per_fragment = stats->mean_depth > 64 ? 9 : 0;
    cost->bytes_fixed = 65536;
    return STRATA_OK;
}

static const strata_slot_use *const slots[] = {&slots_fragments, &slots_color, &slots_bound};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory =
        "4 pixels + 8.125 fragments of pixels deeper than 64 (+ 32 pixels deeper than 32,768)"};

/* Per depth: one pixel's fragments are sorted by few invocations. */
static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 10000,
                                       .per_pixel = 0.5,
                                       .per_fragment = 0.3,
                                       .per_fragment_log2_depth = 0.12,
                                       .per_depth = 40};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(ppc),
    .id = "ppc",
    .title = "pixel-parallel composite: pixel classes, sorting networks in registers",
    .reference = "Patney, Tzeng, Owens 2010; Knowles, Leach, Zambetta 2012-2014",
    .stage = "resolve",
    .slots = slots,
    .slot_count = 3,
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
    .id = "ppc",
    .title = "Pixel-parallel composite",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
