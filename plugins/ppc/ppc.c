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
#include "strata/strata.h"

#include <stddef.h>
#include <string.h>

enum {
    CLASS_COUNT = 6,
    CLASS_DEEP = 5,
    PIXELS_PER_INVOCATION = 16,
    DEEP_BLOCK = 32,
    WALK_CHUNK = 32768
};

/* Mirrors CLASS_TABLE in classes.glsl. */
typedef struct table {
    struct {
        uint32_t count, offset, cursor, unused, groups[4];
    } classes[CLASS_COUNT];
    uint32_t tied_groups[4], block_groups[4];
    uint32_t largest, blocks, cursor, deep_fits;
} table;
_Static_assert(sizeof(table) == 240, "mirrors CLASS_TABLE");

typedef struct ppc {
    const strata_gpu *gpu;
    const strata_fragments *fragments;
    strata_image color;
    strata_buffer classes, lists;
    strata_pool tied, deep, block, slot, walk, index;
    strata_program histogram_program, dispatch_program, lists_program, resolve_program[CLASS_DEEP],
        ties_program, tied_program, owners_program, gather_program, blocks_program, merge_program,
        walk_program;
    uint32_t seen;          /* bit for each class that some frame had */
    uint32_t tied_seen;     /* 1: some frame had equal keys */
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

typedef struct source {
    strata_program *out;
    const char *label;
    const strata_glsl *glsl;
    const char *const *defines;
    uint32_t define_count, flags;
} source;

static strata_result create_programs(const ppc *p, const source *sources, size_t count) {
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < count && r == STRATA_OK; ++i)
        r = p->gpu->program_create(
            p->gpu->self,
            &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                   .kind = STRATA_PROGRAM_COMPUTE,
                                   .flags = sources[i].flags,
                                   .label = sources[i].label,
                                   .source = sources[i].glsl,
                                   .defines = sources[i].defines,
                                   .define_count = sources[i].define_count,
                                   .includes = includes},
            sources[i].out);
    return r;
}

#define NETWORK(n, c)                                                                              \
    { "CLASS=" #c, "SIZE=" #n, "SORT_SIZE=STRATA_SORT_" #n, "REPEAT_SIZE=STRATA_REPEAT_" #n }

static strata_result prepare_programs(ppc *p) {
    static const char *const one[] = {"CLASS=0", "SIZE=1"};
    static const char *const networks[][4] = {NETWORK(8, 1), NETWORK(16, 2), NETWORK(32, 3),
                                              NETWORK(64, 4)};
    const source sources[] = {
        {&p->histogram_program, "histogram", &histogram_comp_glsl, NULL, 0, 0},
        {&p->dispatch_program, "dispatch", &dispatch_comp_glsl, NULL, 0, 0},
        {&p->lists_program, "lists", &lists_comp_glsl, NULL, 0, 0},
        {&p->resolve_program[0], "resolve 1", &resolve_comp_glsl, one, 2, STRATA_PROGRAM_LAZY},
        {&p->resolve_program[1], "resolve 8", &resolve_comp_glsl, networks[0], 4,
         STRATA_PROGRAM_LAZY},
        {&p->resolve_program[2], "resolve 16", &resolve_comp_glsl, networks[1], 4,
         STRATA_PROGRAM_LAZY},
        {&p->resolve_program[3], "resolve 32", &resolve_comp_glsl, networks[2], 4,
         STRATA_PROGRAM_LAZY},
        {&p->resolve_program[4], "resolve 64", &resolve_comp_glsl, networks[3], 4,
         STRATA_PROGRAM_LAZY},
        {&p->ties_program, "ties", &ties_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
        {&p->tied_program, "tied", &tied_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
        {&p->owners_program, "owners", &owners_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
        {&p->gather_program, "gather", &gather_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
        {&p->blocks_program, "blocks", &blocks_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
        {&p->merge_program, "merge", &merge_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
        {&p->walk_program, "walk", &walk_comp_glsl, NULL, 0, STRATA_PROGRAM_LAZY},
    };
    const size_t count = sizeof sources / sizeof sources[0];
    strata_result r = create_programs(p, sources, 11);
    if (r == STRATA_OK && p->fragments->layout == STRATA_FRAGMENTS_LINKED)
        r = create_programs(p, &sources[11], 1);
    if (r == STRATA_OK)
        r = create_programs(p, &sources[12], count - 12);
    return r;
}

static strata_result prepare_pools(ppc *p) {
    const int linked = p->fragments->layout == STRATA_FRAGMENTS_LINKED;
    const struct {
        strata_pool *out;
        strata_pool_desc desc;
    } pools[] = {
        {&p->tied,
         {.label = "tied pixels",
          .counter_name = "TiedPool",
          .plane_count = 1,
          .plane_names = {"TiedPixels"},
          .plane_strides = {4}}},
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
          .plane_count = 4,
          .plane_names = {"WalkState0", "WalkState1", "WalkState2", "WalkState3"},
          .plane_strides = {8, 8, 8, 8}}},
        {&p->index,
         {.label = "deep index",
          .counter_name = "IndexPool",
          .plane_count = 1,
          .plane_names = {"DeepIndex"},
          .plane_strides = {4}}},
    };
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < (linked ? 6u : 5u) && r == STRATA_OK; ++i) {
        strata_pool_desc desc = pools[i].desc;
        desc.struct_size = sizeof desc;
        r = p->gpu->pool_create(p->gpu->self, &desc, pools[i].out);
    }
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    ppc *p = state;
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height;
    p->fragments = view->fragments(view->self);
    p->color = view->image(view->self, "color/1");
    if (!p->fragments)
        return STRATA_ERROR_INVALID_STATE;
    strata_result r = p->gpu->buffer_create(
        p->gpu->self,
        &(strata_buffer_desc){
            .struct_size = sizeof(strata_buffer_desc), .label = "classes", .size = sizeof(table)},
        &p->classes);
    if (r == STRATA_OK)
        r = p->gpu->buffer_create(p->gpu->self,
                                  &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                        .label = "lists",
                                                        .size = pixels * 4},
                                  &p->lists);
    if (r == STRATA_OK)
        r = prepare_pools(p);
    if (r == STRATA_OK)
        r = prepare_programs(p);
    return r;
}

/* ---- record -------------------------------------------------------------------------------------
 */

enum { BIND_MAX = 12 };

/* Binds what a pass names out of all that ppc has: programs differ in what they use, so each pass
 * lists its own. */
typedef struct binds {
    strata_bind at[BIND_MAX];
    uint32_t count;
} binds;

static void add_buffer(binds *b, const char *name, strata_buffer buffer) {
    b->at[b->count++] =
        (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .buffer = buffer};
}

static void add_pool(binds *b, strata_pool pool) {
    b->at[b->count++] = (strata_bind){.struct_size = sizeof(strata_bind), .pool = pool};
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

static void dispatch_indirect(const ppc *p, const strata_frame *frame, const char *label,
                              strata_program program, const binds *b, uint64_t offset,
                              const uint32_t params[2]) {
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = label,
                                            .program = program,
                                            .indirect = p->classes,
                                            .indirect_offset = offset,
                                            .params = params,
                                            .params_size = params ? 8 : 0,
                                            .binds = b->at,
                                            .bind_count = b->count});
}

static void record_classify(const ppc *p, const strata_frame *frame) {
    const uint64_t pixels = (uint64_t)frame->band_width * frame->band_height;
    const int linked = p->fragments->layout == STRATA_FRAGMENTS_LINKED;
    const uint32_t one[3] = {1, 1, 1};
    uint32_t groups[3];
    strata_groups((pixels + PIXELS_PER_INVOCATION - 1) / PIXELS_PER_INVOCATION, groups);

    binds b = {.count = 0};
    add_buffer(&b, "StrataRanges", p->fragments->ranges);
    add_buffer(&b, "Classes", p->classes);
    dispatch(frame, "histogram", p->histogram_program, &b, groups);

    b.count = 0;
    add_buffer(&b, "Classes", p->classes);
    add_pool(&b, p->fragments->records);
    add_pool(&b, p->deep);
    add_pool(&b, p->block);
    add_pool(&b, p->slot);
    add_pool(&b, p->walk);
    if (linked)
        add_pool(&b, p->index);
    dispatch(frame, "dispatch", p->dispatch_program, &b, one);

    b.count = 0;
    add_buffer(&b, "StrataRanges", p->fragments->ranges);
    add_buffer(&b, "Classes", p->classes);
    add_buffer(&b, "Lists", p->lists);
    add_pool(&b, p->deep);
    if (linked)
        add_pool(&b, p->index);
    dispatch(frame, "lists", p->lists_program, &b, groups);
}

static void add_color(binds *b, const ppc *p) {
    b->at[b->count++] =
        (strata_bind){.struct_size = sizeof(strata_bind), .name = "color", .image = p->color};
}

static void record_classes(const ppc *p, const strata_frame *frame) {
    static const char *const labels[CLASS_DEEP] = {"resolve 1", "resolve 8", "resolve 16",
                                                   "resolve 32", "resolve 64"};
    const uint32_t one[3] = {1, 1, 1};
    binds b = {.count = 0};
    add_buffer(&b, "StrataRanges", p->fragments->ranges);
    add_pool(&b, p->fragments->records);
    add_color(&b, p);
    add_pool(&b, p->tied);
    const uint32_t common = b.count;
    add_buffer(&b, "Classes", p->classes);
    add_buffer(&b, "Lists", p->lists);
    for (uint32_t c = 0; c < CLASS_DEEP; ++c)
        if (p->seen >> c & 1u)
            dispatch_indirect(
                p, frame, labels[c], p->resolve_program[c], &b,
                offsetof(table, classes[0].groups) + c * sizeof(((table *)0)->classes[0]), NULL);
    if (!p->tied_seen)
        return;
    binds t = {.count = 0};
    add_buffer(&t, "Classes", p->classes);
    add_pool(&t, p->tied);
    dispatch(frame, "ties", p->ties_program, &t, one);
    b.count = common;
    dispatch_indirect(p, frame, "tied", p->tied_program, &b, offsetof(table, tied_groups), NULL);
}

static void record_deep(const ppc *p, const strata_frame *frame) {
    const uint64_t deep = offsetof(table, classes[CLASS_DEEP].groups),
                   block = offsetof(table, block_groups);
    const int linked = p->fragments->layout == STRATA_FRAGMENTS_LINKED;
    binds b = {.count = 0};
    add_buffer(&b, "StrataRanges", p->fragments->ranges);
    add_pool(&b, p->fragments->records);
    add_pool(&b, p->deep);
    add_pool(&b, p->block);
    add_pool(&b, p->slot);
    add_buffer(&b, "Classes", p->classes);
    const uint32_t common = b.count;
    add_buffer(&b, "Lists", p->lists);

    dispatch_indirect(p, frame, "owners", p->owners_program, &b, deep, NULL);
    if (linked) {
        binds g = b;
        uint32_t groups[3];
        g.count = common;
        add_pool(&g, p->index);
        strata_groups(p->gpu->pool_capacity(p->gpu->self, p->fragments->records), groups);
        dispatch(frame, "gather", p->gather_program, &g, groups);
    }
    dispatch_indirect(p, frame, "blocks", p->blocks_program, &b, block, NULL);
    for (uint32_t i = 0; i < p->rounds; ++i)
        dispatch_indirect(p, frame, "merge", p->merge_program, &b, block,
                          (const uint32_t[]){(uint32_t)DEEP_BLOCK << i, i & 1u});
    add_pool(&b, p->walk);
    add_color(&b, p);
    for (uint32_t i = 0; i < p->walks; ++i)
        dispatch_indirect(p, frame, "walk", p->walk_program, &b, deep,
                          (const uint32_t[]){p->rounds & 1u, i * (uint32_t)WALK_CHUNK});
}

static void record(void *state, const strata_frame *frame) {
    const ppc *p = state;
    frame->fill(frame->self, p->classes, 0, 0, 0);
    record_classify(p, frame);
    record_classes(p, frame);
    if (p->seen >> CLASS_DEEP & 1u)
        record_deep(p, frame);
}

/* ---- verify: what the next attempt has to record
 * -------------------------------------------------- */

/* Merges of deep pixels, so that the largest is one sorted run. */
static uint32_t rounds_of(uint32_t largest) {
    const uint64_t blocks = ((uint64_t)largest + DEEP_BLOCK - 1) / DEEP_BLOCK;
    uint32_t rounds = 0;
    while ((1ull << rounds) < blocks)
        ++rounds;
    return rounds;
}

/* A scene that moves will need what lies next to what it needs: from the second frame on,
 * neighbouring classes and one more merge are taken along, so that it does not learn them one frame
 * at a time. */
static void learn(ppc *p, uint32_t missing, uint32_t largest, uint64_t frame) {
    if (frame > 0)
        missing |= (missing << 1 | missing >> 1) & ((1u << CLASS_COUNT) - 1);
    p->seen |= missing;
    if ((p->seen >> CLASS_DEEP & 1u) == 0)
        return;
    const uint32_t rounds = rounds_of(largest) + (frame > 0);
    p->rounds = rounds > p->rounds ? rounds : p->rounds;
    p->walks = largest / WALK_CHUNK + 1 > p->walks ? largest / WALK_CHUNK + 1 : p->walks;
}

static strata_result verify(void *state, const strata_frame *frame) {
    ppc *p = state;
    table t = {.largest = 0};
    strata_result r = frame->read(frame->self, p->classes, 0, sizeof t, &t);
    if (r != STRATA_OK)
        return r;
    uint32_t present = 0;
    for (uint32_t c = 0; c < CLASS_COUNT; ++c)
        if (t.classes[c].count > 0)
            present |= 1u << c;
    const uint32_t tied = frame->needed(frame->self, p->tied) > 0;
    const int deep = (present >> CLASS_DEEP & 1u) && (rounds_of(t.largest) > p->rounds ||
                                                      t.largest > p->walks * (uint64_t)WALK_CHUNK);
    frame->report(frame->self, STRATA_REPORT_MAX_PER_PIXEL, t.largest);
    if ((present & ~p->seen) == 0 && tied <= p->tied_seen && !deep)
        return STRATA_OK;
    learn(p, present & ~p->seen, t.largest, frame->index);
    p->tied_seen |= tied;
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

static const strata_slot_use fragments_use = {.struct_size = sizeof(strata_slot_use),
                                              .use = STRATA_SLOT_CONSUMES,
                                              .slot = "fragments/1",
                                              .layouts = 1u << STRATA_FRAGMENTS_CONTIGUOUS |
                                                         1u << STRATA_FRAGMENTS_LINKED};
static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use *const slots[] = {&fragments_use, &color_use};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory =
        "4 pixels + 8.125 fragments of pixels deeper than 64 (+ 32 pixels deeper than 32,768)"};

static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 10000,
                                       .per_pixel = 0.5,
                                       .per_fragment = 0.3,
                                       .per_fragment_log2_depth = 0.12};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(ppc),
    .id = "ppc",
    .title = "pixel-parallel composite: pixel classes, sorting networks in registers",
    .reference = "Patney, Tzeng, Owens 2010; Knowles, Leach, Zambetta 2012-2014",
    .stage = "resolve",
    .slots = slots,
    .slot_count = 2,
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
