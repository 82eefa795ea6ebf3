/* SPDX-License-Identifier: MIT
 *
 * Pixel classes and their networks. See classes.h.
 */
#include "shared/classes.h"
#include "shared/create.h"

#include <stddef.h>

static const strata_glsl histogram_glsl = {"#include \"strata/class_histogram.comp.glsl\"\n",
                                           "histogram.comp"};
static const strata_glsl lists_glsl = {"#include \"strata/class_lists.comp.glsl\"\n", "lists.comp"};
static const strata_glsl resolve_glsl = {"#include \"strata/class_resolve.comp.glsl\"\n",
                                         "resolve.comp"};
static const strata_glsl ties_glsl = {"#include \"strata/class_ties.comp.glsl\"\n", "ties.comp"};
static const strata_glsl tied_glsl = {"#include \"strata/class_tied.comp.glsl\"\n", "tied.comp"};

/* ---- prepare --------------------------------------------------------------------------------- */

static strata_result program(const strata_gpu *gpu, const char *label, const strata_glsl *source,
                             const char *const *defines, uint32_t define_count, uint32_t flags,
                             strata_program *out) {
    return gpu->program_create(gpu->self,
                               &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                      .kind = STRATA_PROGRAM_COMPUTE,
                                                      .flags = flags,
                                                      .label = label,
                                                      .source = source,
                                                      .defines = defines,
                                                      .define_count = define_count},
                               out);
}

#define NETWORK(n, c)                                                                              \
    {                                                                                              \
        "CLASS=" #c, "SIZE=" #n, "SORT_SIZE=STRATA_SORT_" #n, "REPEAT_SIZE=STRATA_REPEAT_" #n,     \
            "CLASS_THRESHOLD"                                                                      \
    }

static strata_result prepare_networks(classes *c, const strata_gpu *gpu) {
    static const char *const defines[CLASSES_DEEP][5] = {
        {"CLASS=0", "SIZE=1", "SORT_SIZE", "REPEAT_SIZE", "CLASS_THRESHOLD"},
        NETWORK(8, 1),
        NETWORK(16, 2),
        NETWORK(32, 3),
        NETWORK(64, 4)};
    static const char *const labels[CLASSES_DEEP] = {"resolve 1", "resolve 8", "resolve 16",
                                                     "resolve 32", "resolve 64"};
    strata_result r = STRATA_OK;
    for (uint32_t i = 0; i < CLASSES_DEEP && r == STRATA_OK; ++i)
        r = program(gpu, labels[i], &resolve_glsl, defines[i], 4 + c->ends, STRATA_PROGRAM_LAZY,
                    &c->resolve_program[i]);
    return r;
}

static strata_result prepare_programs(classes *c, const strata_gpu *gpu, uint32_t blocks) {
    static const char *const with_blocks[] = {"CLASS_BLOCKS"}, *const ends[] = {"CLASS_THRESHOLD"};
    strata_result r = program(gpu, "histogram", &histogram_glsl, NULL, 0, 0, &c->histogram_program);
    if (r == STRATA_OK)
        r = program(gpu, "lists", &lists_glsl, with_blocks, blocks, 0, &c->lists_program);
    if (r == STRATA_OK)
        r = prepare_networks(c, gpu);
    if (r == STRATA_OK)
        r = program(gpu, "ties", &ties_glsl, NULL, 0, STRATA_PROGRAM_LAZY, &c->ties_program);
    if (r == STRATA_OK)
        r = program(gpu, "tied", &tied_glsl, ends, c->ends, STRATA_PROGRAM_LAZY, &c->tied_program);
    return r;
}

strata_result classes_prepare(classes *c, const strata_gpu *gpu, const strata_view *view,
                              uint32_t blocks, uint32_t ends) {
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height;
    c->fragments = view->fragments(view->self);
    c->color = view->image(view->self, "color/1");
    c->ends = ends;
    if (!c->fragments)
        return STRATA_ERROR_INVALID_STATE;
    strata_result r = create_buffer(gpu, "classes", sizeof(classes_table), &c->table);
    if (r == STRATA_OK)
        r = create_buffer(gpu, "lists", pixels * 4, &c->lists);
    if (r == STRATA_OK)
        r = gpu->pool_create(gpu->self,
                             &(strata_pool_desc){.struct_size = sizeof(strata_pool_desc),
                                                 .label = "tied pixels",
                                                 .counter_name = "TiedPool",
                                                 .plane_count = 1,
                                                 .plane_names = {"TiedPixels"},
                                                 .plane_strides = {4}},
                             &c->tied);
    return r == STRATA_OK ? prepare_programs(c, gpu, blocks) : r;
}

/* ---- record ---------------------------------------------------------------------------------- */

/* A group takes a tile of pixels: strata/class_pixels.glsl. */
static strata_pass pixels_pass(const strata_frame *frame, const char *label, strata_program program,
                               const binds *b) {
    enum { TILE = 32, GROUP = 64 };
    const uint64_t across = (frame->band_width + TILE - 1) / TILE;
    const uint64_t down = (frame->band_height + TILE - 1) / TILE;
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = label,
                        .program = program,
                        .binds = b->at,
                        .bind_count = b->count};
    strata_groups(across * down * GROUP, pass.groups);
    return pass;
}

void classes_record_histogram(const classes *c, const strata_frame *frame) {
    binds b = {.count = 0};
    binds_buffer(&b, "StrataRanges", c->fragments->ranges);
    binds_buffer(&b, "Classes", c->table);
    frame->fill(frame->self, c->table, 0, 0, 0);
    const strata_pass pass = pixels_pass(frame, "histogram", c->histogram_program, &b);
    frame->pass(frame->self, &pass);
}

void classes_record_lists(const classes *c, const strata_frame *frame, const binds *more) {
    binds b = *more;
    binds_buffer(&b, "StrataRanges", c->fragments->ranges);
    binds_buffer(&b, "Classes", c->table);
    binds_buffer(&b, "Lists", c->lists);
    const strata_pass pass = pixels_pass(frame, "lists", c->lists_program, &b);
    frame->pass(frame->self, &pass);
}

static void fold(const classes *c, const strata_frame *frame, const char *label,
                 strata_program program, const binds *b, uint64_t offset) {
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = label,
                                            .program = program,
                                            .indirect = c->table,
                                            .indirect_offset = offset,
                                            .params = c->ends ? &c->threshold : NULL,
                                            .params_size = c->ends ? sizeof c->threshold : 0,
                                            .binds = b->at,
                                            .bind_count = b->count});
}

void classes_record_folds(const classes *c, const strata_frame *frame) {
    static const char *const labels[CLASSES_DEEP] = {"resolve 1", "resolve 8", "resolve 16",
                                                     "resolve 32", "resolve 64"};
    binds b = {.count = 0};
    binds_buffer(&b, "StrataRanges", c->fragments->ranges);
    binds_pool(&b, c->fragments->records);
    binds_image(&b, "color", c->color);
    binds_pool(&b, c->tied);
    const binds common = b;
    binds_buffer(&b, "Classes", c->table);
    binds_buffer(&b, "Lists", c->lists);
    for (uint32_t i = 0; i < CLASSES_DEEP; ++i)
        if (c->seen >> i & 1u)
            fold(c, frame, labels[i], c->resolve_program[i], &b,
                 offsetof(classes_table, classes[0].groups) +
                     i * sizeof(((classes_table *)0)->classes[0]));
    if (!c->tied_seen)
        return;
    binds t = {.count = 0};
    binds_buffer(&t, "Classes", c->table);
    binds_pool(&t, c->tied);
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "ties",
                                            .program = c->ties_program,
                                            .groups = {1, 1, 1},
                                            .binds = t.at,
                                            .bind_count = t.count});
    fold(c, frame, "tied", c->tied_program, &common, offsetof(classes_table, tied_groups));
}

/* ---- verify ---------------------------------------------------------------------------------- */

/* A scene that moves will need what lies next to what it needs: from the second frame on,
 * neighbouring classes are taken along, so that it does not learn them one frame at a time. */
uint32_t classes_learn(classes *c, const strata_frame *frame, const classes_table *table,
                       uint32_t *tied) {
    uint32_t missing = 0;
    for (uint32_t i = 0; i < CLASSES_COUNT; ++i)
        if (table->classes[i].count > 0)
            missing |= 1u << i;
    missing &= ~c->seen;
    *tied = frame->needed(frame->self, c->tied) > 0 && !c->tied_seen;
    c->tied_seen |= *tied;
    c->seen |= missing;
    if (frame->index > 0)
        c->seen |= (missing << 1 | missing >> 1) & ((1u << CLASSES_COUNT) - 1);
    return missing;
}
