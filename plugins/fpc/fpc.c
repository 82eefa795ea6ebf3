/* SPDX-License-Identifier: MIT
 *
 * Technique module `fpc`: fragment-parallel composite. Resolves fragments/1 into color/1.
 *
 *   tally -> plan -> rank   ranks for pixels that have fragments, ranges of elements and of chunks
 *   expand | append         an element (rank, key) for each fragment
 *   digits, count, scatter  radix sort, 8 bits a pass; mend: short runs of equal keys, by order
 *   runs -> merge ..        instead, in the hybrid: sorted runs of 32, merged where none is too
 * deep fold -> join ..         each pixel's fold as a tree of fixed shape filter weighted sums of
 * sub-pixels, where it fills image/1
 *
 * Work items are elements, streams of elements and chunks of fragments, never pixels: the time
 * depends on the number of fragments and not on where they lie. The hybrid leaves pixels of one
 * chunk to networks. How many passes a scene needs is learned in verify().
 */
#include "fpc_glsl.h"
#include "shared/classes.h"
#include "shared/create.h"
#include "shared/filtering.h"
#include "shared/slots.h"

#include <stddef.h>
#include <string.h>

enum { PIXELS_PER_GROUP = 16 * 64, DIGIT_BITS = 8, CHUNK = 64, RUN = 32 };

/* The hybrid merges sorted runs where no pixel has more fragments; beyond, the radix sort is ahead.
 */
enum { MERGED_LARGEST = 2048 };

/* Mirrors FPC_TABLE in table.glsl. */
typedef struct table {
    uint32_t element_groups[4], stream_groups[4], counter_groups[4], chunk_groups[4],
        joint_groups[4];
    uint32_t pixels, elements, chunks, joints;
    uint32_t streams, largest, inverse_nearest, farthest;
    uint32_t inverse_first, last, key_bits, rank_bits;
    uint32_t order_bits, long_ties, appended, fits, stream;
} table;
_Static_assert(sizeof(table) == 148, "mirrors FPC_TABLE");

enum { KNOB_MODE, KNOB_THRESHOLD };
enum { MODE_FRAGMENTS, MODE_HYBRID };

typedef struct fpc {
    const strata_gpu *gpu;
    const strata_fragments *fragments;
    strata_image color;
    strata_buffer table, sums;
    strata_pool ranked, element, counter, block, joint, rank;
    strata_program tally_program, plan_program, rank_program, expand_program[2], digits_program,
        count_program[2][2], sums_program, blocks_program, offsets_program, scatter_program[2][2],
        mend_program, runs_program[2], merge_program[2], fold_program,
        join_program; /* [side][by_order] */
    classes classes;  /* hybrid: pixels of at most 64 fragments */
    filtering filtering;
    uint32_t hybrid, filters; /* filters: it fills image/1 */
    float threshold;
    uint32_t by_order;               /* 1: some frame had long runs of equal keys */
    uint32_t beyond;                 /* 1: some frame had pixels too deep to be merged */
    uint32_t passes, merges, levels; /* of sorting, merging and joining that are recorded */
} fpc;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((fpc *)state)->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

typedef struct source {
    strata_program *out;
    const char *label;
    const strata_glsl *glsl;
    uint32_t lazy, side, by_order;
} source;

/* A processor with wide subgroups wants many short streams, one with few threads long ones, whose
 * digits are cheaper to add up. */
static const char *stream_of(const fpc *f) {
    return f->gpu->fact(f->gpu->self, "limit.subgroup") >= 32 ? "STREAM_LONGEST=248u"
                                                              : "STREAM_LONGEST=2040u";
}

static strata_result create_program(const fpc *f, const source *s) {
    static const strata_glsl *const includes[] = {&table_glsl,  &pixels_glsl,  &ranked_glsl,
                                                  &extent_glsl, &sorting_glsl, &counters_glsl,
                                                  &joints_glsl, NULL};
    const char *const defines[] = {stream_of(f), s->side ? "SIDE=1" : "SIDE=0",
                                   s->by_order ? "BY_ORDER=1" : "BY_ORDER=0", "HYBRID"};
    return f->gpu->program_create(f->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = STRATA_PROGRAM_COMPUTE,
                                                         .flags = s->lazy ? STRATA_PROGRAM_LAZY : 0,
                                                         .label = s->label,
                                                         .source = s->glsl,
                                                         .defines = defines,
                                                         .define_count = 3 + f->hybrid,
                                                         .includes = includes},
                                  s->out);
}

static strata_result prepare_programs(fpc *f) {
    const source sources[] = {
        {&f->tally_program, "tally", &tally_comp_glsl, 0, 0, 0},
        {&f->plan_program, "plan", &plan_comp_glsl, 0, 0, 0},
        {&f->rank_program, "rank", &rank_comp_glsl, 0, 0, 0},
        {&f->digits_program, "digits", &digits_comp_glsl, 0, 0, 0},
        {&f->sums_program, "sums", &sums_comp_glsl, 1, 0, 0},
        {&f->blocks_program, "blocks", &blocks_comp_glsl, 1, 0, 0},
        {&f->offsets_program, "offsets", &offsets_comp_glsl, 1, 0, 0},
        {&f->mend_program, "mend", &mend_comp_glsl, 1, 0, 0},
        {&f->fold_program, "fold", &fold_comp_glsl, 0, 0, 0},
        {&f->join_program, "join", &join_comp_glsl, 1, 0, 0},
    };
    const int linked = f->fragments->layout == STRATA_FRAGMENTS_LINKED;
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < sizeof sources / sizeof sources[0] && r == STRATA_OK; ++i)
        r = create_program(f, &sources[i]);
    for (uint32_t i = 0; i < 4 && r == STRATA_OK; ++i) {
        const uint32_t side = i & 1u, order = i >> 1;
        r = create_program(f, &(source){&f->count_program[side][order], "count", &count_comp_glsl,
                                        1, side, order});
        if (r == STRATA_OK)
            r = create_program(f, &(source){&f->scatter_program[side][order], "scatter",
                                            &scatter_comp_glsl, 1, side, order});
        if (r == STRATA_OK && order == 0)
            r = create_program(f, &(source){&f->expand_program[side], linked ? "append" : "expand",
                                            linked ? &append_comp_glsl : &expand_comp_glsl, 1, side,
                                            0});
        if (r == STRATA_OK && order == 0)
            r = create_program(
                f, &(source){&f->runs_program[side], "runs", &runs_comp_glsl, 1, side, 0});
        if (r == STRATA_OK && order == 0)
            r = create_program(
                f, &(source){&f->merge_program[side], "merge", &merge_comp_glsl, 1, side, 0});
    }
    return r;
}

static strata_result prepare_pools(fpc *f) {
    const struct {
        strata_pool *out;
        strata_pool_desc desc;
    } pools[] = {
        {&f->ranked,
         {.label = "ranked pixels",
          .counter_name = "RankedPool",
          .plane_count = 2,
          .plane_names = {"RankedElements", "RankedChunks"},
          .plane_strides = {8, 8}}},
        {&f->element,
         {.label = "elements",
          .counter_name = "ElementPool",
          .plane_count = 4,
          .plane_names = {"Elements0", "Elements1", "Slots0", "Slots1"},
          .plane_strides = {8, 8, 4, 4}}},
        {&f->counter,
         {.label = "counters",
          .counter_name = "CounterPool",
          .plane_count = 1,
          .plane_names = {"Counters"},
          .plane_strides = {4}}},
        {&f->block,
         {.label = "counter blocks",
          .counter_name = "BlockPool",
          .plane_count = 1,
          .plane_names = {"BlockSums"},
          .plane_strides = {4}}},
        {&f->joint,
         {.label = "joints",
          .counter_name = "JointPool",
          .plane_count = 1,
          .plane_names = {"Joints"},
          .plane_strides = {8}}},
        {&f->rank,
         {.label = "ranks",
          .counter_name = "RankPool",
          .plane_count = 1,
          .plane_names = {"RankOf"},
          .plane_strides = {4}}},
    };
    const size_t count = f->fragments->layout == STRATA_FRAGMENTS_LINKED ? 6 : 5;
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < count && r == STRATA_OK; ++i) {
        strata_pool_desc desc = pools[i].desc;
        desc.struct_size = sizeof desc;
        r = f->gpu->pool_create(f->gpu->self, &desc, pools[i].out);
    }
    return r;
}

static uint64_t pixel_groups(uint32_t width, uint32_t height) {
    return ((uint64_t)width * height + PIXELS_PER_GROUP - 1) / PIXELS_PER_GROUP;
}

static strata_result prepare(void *state, const strata_view *view) {
    fpc *f = state;
    f->fragments = view->fragments(view->self);
    f->color = view->image(view->self, "color/1");
    f->threshold = (float)view->settings->values[KNOB_THRESHOLD];
    f->hybrid = view->settings->values[KNOB_MODE] == MODE_HYBRID;
    f->filters = view->image(view->self, "image/1").id != 0;
    if (!f->fragments)
        return STRATA_ERROR_INVALID_STATE;
    strata_result r = create_buffer(f->gpu, "table", sizeof(table), &f->table);
    if (r == STRATA_OK)
        r = create_buffer(f->gpu, "pixel sums",
                          16 * pixel_groups(view->band_width, view->band_height), &f->sums);
    if (r == STRATA_OK)
        r = prepare_pools(f);
    if (r == STRATA_OK)
        r = prepare_programs(f);
    f->classes.threshold = f->threshold;
    if (r == STRATA_OK && f->hybrid)
        r = classes_prepare(&f->classes, f->gpu, view, 0, f->threshold > 0);
    if (r == STRATA_OK && f->filters)
        r = filtering_prepare(&f->filtering, f->gpu, view);
    return r;
}

/* ---- record ---------------------------------------------------------------------------------- */

/* The two words of a pass's STRATA_PARAMS block, `size` bytes of which it has. */
typedef struct params {
    uint32_t size, first;
    float second;
} params;
#define PARAM(a) ((params){.size = 4, .first = (a)})

typedef struct step {
    const char *label;
    strata_program program;
    uint64_t indirect; /* where the table has its work groups */
    uint32_t direct;   /* work groups, instead; 0 = indirect */
    params params;
} step;

static void run(const fpc *f, const strata_frame *frame, const binds *b, const step *s) {
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = s->label,
                        .program = s->program,
                        .params = s->params.size ? &s->params.first : NULL,
                        .params_size = s->params.size,
                        .binds = b->at,
                        .bind_count = b->count};
    if (s->direct) {
        strata_groups((uint64_t)s->direct * 64, pass.groups);
    } else {
        pass.indirect = f->table;
        pass.indirect_offset = s->indirect;
    }
    frame->pass(frame->self, &pass);
}

static binds common(const fpc *f) {
    binds b = {.count = 0};
    binds_buffer(&b, "Table", f->table);
    binds_pool(&b, f->fragments->records);
    if (f->fragments->layout == STRATA_FRAGMENTS_LINKED)
        binds_pool(&b, f->rank);
    return b;
}

static void record_ranks(const fpc *f, const strata_frame *frame) {
    const uint32_t groups = (uint32_t)pixel_groups(frame->band_width, frame->band_height);
    binds plan = common(f);
    binds_pool(&plan, f->ranked);
    binds pixels = plan;
    binds_buffer(&plan, "Sums", f->sums);
    binds_pool(&plan, f->element);
    binds_pool(&plan, f->counter);
    binds_pool(&plan, f->block);
    binds_pool(&plan, f->joint);
    binds_buffer(&pixels, "Sums", f->sums);
    binds_buffer(&pixels, "StrataRanges", f->fragments->ranges);
    if (f->hybrid) {
        classes_record_histogram(&f->classes, frame);
        binds_buffer(&plan, "Classes", f->classes.table);
    }
    run(f, frame, &pixels, &(step){"tally", f->tally_program, .direct = groups});
    run(f, frame, &plan, &(step){"plan", f->plan_program, .direct = 1});
    run(f, frame, &pixels, &(step){"rank", f->rank_program, .direct = groups});
}

/* Pixels are sorted by merging runs, not by the radix sort of all. */
static int is_merging(const fpc *f) {
    return f->hybrid && f->fragments->layout == STRATA_FRAGMENTS_CONTIGUOUS && !f->beyond;
}

/* The copy of the slots that a sort begins with is chosen so that it ends in copy 0. */
static void record_merges(const fpc *f, const strata_frame *frame) {
    const uint64_t chunks = offsetof(table, chunk_groups);
    const uint32_t side = f->merges & 1u;
    binds b = common(f);
    binds_pool(&b, f->ranked);
    binds_pool(&b, f->element);
    binds_buffer(&b, "StrataRanges", f->fragments->ranges);
    run(f, frame, &b, &(step){"runs", f->runs_program[side], .indirect = chunks});
    for (uint32_t i = 0; i < f->merges; ++i)
        run(f, frame, &b,
            &(step){"merge", f->merge_program[(side + i) & 1u], .indirect = chunks,
                    .params = PARAM((uint32_t)RUN << i)});
}

static void record_sort(const fpc *f, const strata_frame *frame) {
    const uint64_t elements = offsetof(table, element_groups),
                   streams = offsetof(table, stream_groups),
                   counters = offsetof(table, counter_groups);
    const uint32_t side = f->passes & 1u;
    binds b = common(f);
    binds_pool(&b, f->ranked);
    binds_pool(&b, f->element);
    binds_pool(&b, f->counter);
    binds_pool(&b, f->block);
    binds ranges = b;
    binds_buffer(&ranges, "StrataRanges", f->fragments->ranges);
    run(f, frame, &ranges, &(step){"expand", f->expand_program[side], .indirect = elements});
    run(f, frame, &b,
        &(step){"digits", f->digits_program, .direct = 1, .params = PARAM(f->by_order)});
    for (uint32_t i = 0; i < f->passes; ++i) {
        const uint32_t from = (side + i) & 1u;
        const params of = PARAM(i * DIGIT_BITS);
        run(f, frame, &b,
            &(step){"count", f->count_program[from][f->by_order], .indirect = streams,
                    .params = of});
        run(f, frame, &b, &(step){"sums", f->sums_program, .indirect = counters});
        run(f, frame, &b, &(step){"blocks", f->blocks_program, .direct = 1});
        run(f, frame, &b, &(step){"offsets", f->offsets_program, .indirect = counters});
        run(f, frame, &b,
            &(step){"scatter", f->scatter_program[from][f->by_order], .indirect = streams,
                    .params = of});
    }
    if (!f->by_order)
        run(f, frame, &b, &(step){"mend", f->mend_program, .indirect = elements});
}

static void record_fold(const fpc *f, const strata_frame *frame) {
    binds b = common(f);
    binds_buffer(&b, "StrataRanges", f->fragments->ranges);
    binds_pool(&b, f->ranked);
    binds_pool(&b, f->element);
    binds_pool(&b, f->joint);
    binds_image(&b, "color", f->color);
    params of = {.size = 8, .second = f->threshold};
    run(f, frame, &b,
        &(step){"fold", f->fold_program, .indirect = offsetof(table, chunk_groups), .params = of});
    of.first = 1;
    for (uint32_t i = 0; i < f->levels; ++i, of.first *= CHUNK)
        run(f, frame, &b,
            &(step){"join", f->join_program, .indirect = offsetof(table, joint_groups),
                    .params = of});
}

static void record(void *state, const strata_frame *frame) {
    const fpc *f = state;
    frame->fill(frame->self, f->table, 0, 0, 0);
    record_ranks(f, frame);
    if (f->hybrid) {
        classes_record_lists(&f->classes, frame, &(binds){.count = 0});
        classes_record_folds(&f->classes, frame);
    }
    if (is_merging(f))
        record_merges(f, frame);
    else
        record_sort(f, frame);
    record_fold(f, frame);
    if (f->filters && frame->band + 1 == frame->band_count)
        filtering_record(&f->filtering, frame);
}

/* ---- verify: what the next attempt has to record --------------------------------------------- */

static uint32_t bits_of(uint32_t value) {
    uint32_t bits = 0;
    for (; value; value >>= 1)
        ++bits;
    return bits;
}

/* Levels of joining above the chunks until the largest pixel is one node. */
static uint32_t levels_of(uint32_t largest) {
    uint64_t nodes = ((uint64_t)largest + CHUNK - 1) / CHUNK;
    uint32_t levels = 0;
    for (; nodes > 1; nodes = (nodes + CHUNK - 1) / CHUNK)
        ++levels;
    return levels;
}

/* Merges of runs until the largest pixel is one. */
static uint32_t merges_of(uint32_t largest) {
    uint32_t merges = 0;
    while (((uint64_t)RUN << merges) < largest)
        ++merges;
    return merges;
}

/* Whether what sorts is missing; it is recorded from now on. */
static int learn_sort(fpc *f, const table *t) {
    if (is_merging(f)) {
        const uint32_t merges = merges_of(t->largest);
        const int missing = merges > f->merges;
        f->beyond = t->largest > MERGED_LARGEST;
        f->merges = missing && !f->beyond ? merges : f->merges;
        return missing || f->beyond;
    }
    const uint32_t by_order = f->by_order | t->long_ties;
    const uint32_t order_bits = by_order ? bits_of(t->last - ~t->inverse_first) : 0;
    const uint32_t passes = (t->key_bits + t->rank_bits + order_bits + DIGIT_BITS - 1) / DIGIT_BITS;
    const int missing = by_order != f->by_order || passes > f->passes;
    f->by_order = by_order;
    f->passes = passes > f->passes ? passes : f->passes;
    return missing;
}

/* Whether networks are missing; those that some pixel needs are recorded from now on. */
static strata_result verify_classes(fpc *f, const strata_frame *frame, int *missing,
                                    uint32_t *largest) {
    classes_table t = {.largest = 0};
    uint32_t tied;
    strata_result r = frame->read(frame->self, f->classes.table, 0, sizeof t, &t);
    if (r != STRATA_OK)
        return r;
    *largest = t.largest;
    t.classes[CLASSES_DEEP].count = 0; /* not its business */
    *missing = classes_learn(&f->classes, frame, &t, &tied) != 0;
    *missing |= tied != 0;
    return STRATA_OK;
}

static strata_result verify(void *state, const strata_frame *frame) {
    fpc *f = state;
    table t = {.fits = 0};
    int missing = 0;
    uint32_t largest = 0;
    strata_result r = frame->read(frame->self, f->table, 0, sizeof t, &t);
    if (r == STRATA_OK && f->hybrid)
        r = verify_classes(f, frame, &missing, &largest);
    if (r != STRATA_OK)
        return r;
    frame->report(frame->self, STRATA_REPORT_MAX_PER_PIXEL,
                  t.largest > largest ? t.largest : largest);
    if (t.elements == 0)
        return missing ? STRATA_RETRY : STRATA_OK;
    const uint32_t levels = levels_of(t.largest);
    missing |= learn_sort(f, &t) | (levels > f->levels);
    f->levels = levels > f->levels ? levels : f->levels;
    return missing ? STRATA_RETRY : STRATA_OK;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(fpc));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    cost->bytes_per_pixel = settings->values[KNOB_MODE] == MODE_HYBRID ? 25 : 17;
    cost->bytes_per_fragment = 28;
    cost->bytes_fixed = 4096;
    return STRATA_OK;
}

static const strata_slot_use *const slots[] = {&slots_fragments, &slots_color, &slots_bound,
                                               &slots_image, &slots_image_bound};

static const char *const mode_choices[] = {"fragments", "hybrid", NULL};
static const strata_knob mode = {
    .struct_size = sizeof(strata_knob),
    .type = STRATA_KNOB_CHOICE,
    .name = "mode",
    .title = "all pixels by fragments, or those of at most 64 by ppc's networks",
    .maximum = 1,
    .preset = MODE_HYBRID,
    .choices = mode_choices};
static const strata_knob threshold = {
    .struct_size = sizeof(strata_knob),
    .type = STRATA_KNOB_FLOAT,
    .name = "threshold",
    .title = "a fold ends where less than this share of the light behind comes through",
    .maximum = 1,
    .trades_accuracy = 1};
static const strata_knob *const knobs[] = {[KNOB_MODE] = &mode, [KNOB_THRESHOLD] = &threshold};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BOUNDED,
    .memory =
        "16 pixels sorted + 25 to 28 fragments sorted + 0.5 fragments of pixels deeper than 64 "
        "(+ 4 pixels with linked records); hybrid sorts the deeper ones only, + 4 pixels "
        "(+ 4 with equal keys)"};

/* Of the hybrid; mode=fragments takes about 10 a fragment. */
static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 20000,
                                       .per_pixel = 0.5,
                                       .per_fragment = 0.35,
                                       .per_fragment_log2_depth = 0.12};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(fpc),
    .id = "fpc",
    .title = "fragment-parallel composite: radix sort, segmented fold",
    .reference = "Patney, Tzeng, Owens 2010",
    .stage = "resolve",
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
    .id = "fpc",
    .title = "Fragment-parallel composite",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
