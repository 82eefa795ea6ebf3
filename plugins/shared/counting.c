/* SPDX-License-Identifier: MIT
 *
 * Exact allocation: count (additive blending) -> sums -> offsets -> ranges. See counting.h.
 */
#include "shared/counting.h"

#include "shared/binds.h"
#include "shared/create.h"

enum { TILE = 64 };

static const strata_glsl count_glsl = {"#include \"strata/count.frag.glsl\"\n", "count.frag"};
static const strata_glsl sums_glsl = {"#include \"strata/count_sums.comp.glsl\"\n", "sums.comp"};
static const strata_glsl offsets_glsl = {"#include \"strata/count_offsets.comp.glsl\"\n",
                                         "offsets.comp"};
static const strata_glsl ranges_glsl = {"#include \"strata/count_ranges.comp.glsl\"\n",
                                        "ranges.comp"};

const strata_glsl counting_store_glsl = {"#include \"strata/store.frag.glsl\"\n", "store.frag"};

static uint32_t tiles(uint32_t width, uint32_t height) {
    return ((width + TILE - 1) / TILE) * ((height + TILE - 1) / TILE);
}

strata_result counting_prepare_totals(counting *c, const strata_gpu *gpu) {
    return create_buffer(gpu, "totals", sizeof(counting_totals), &c->totals);
}

strata_result counting_prepare_image(counting *c, const strata_gpu *gpu) {
    return create_image(gpu, "fragment count", STRATA_FORMAT_R32F, 0, 0, &c->count);
}

strata_result counting_prepare(counting *c, const strata_gpu *gpu, const strata_view *view,
                               int offsets) {
    static const char *const offset_defines[] = {"STRATA_RANGE_STARTS", "STRATA_RANGE_ENDS",
                                                 "STRATA_RANGE_CURSORS"};
    const char *const defines[] = {offset_defines[offsets], "STRATA_NEAREST"};
    const uint32_t each = c->nearest.id != 0;
    const struct {
        strata_program *out;
        uint32_t kind;
        const char *label;
        const strata_glsl *source;
        const char *const *defines;
        uint32_t define_count;
    } programs[] = {
        {&c->count_program, STRATA_PROGRAM_SCENE, "count", &count_glsl, NULL, 0},
        {&c->sums_program, STRATA_PROGRAM_COMPUTE, "sums", &sums_glsl, defines + 1, each},
        {&c->offsets_program, STRATA_PROGRAM_COMPUTE, "offsets", &offsets_glsl, NULL, 0},
        {&c->ranges_program, STRATA_PROGRAM_COMPUTE, "ranges", &ranges_glsl, defines, 1 + each},
    };
    strata_result r = counting_prepare_image(c, gpu);
    if (r == STRATA_OK)
        r = counting_prepare_totals(c, gpu);
    if (r == STRATA_OK)
        r = create_buffer(gpu, "tile sums", tiles(view->band_width, view->band_height) * 4ull,
                          &c->sums);
    for (size_t i = 0; i < sizeof programs / sizeof *programs && r == STRATA_OK; ++i)
        r = gpu->program_create(gpu->self,
                                &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                       .kind = programs[i].kind,
                                                       .label = programs[i].label,
                                                       .source = programs[i].source,
                                                       .defines = programs[i].defines,
                                                       .define_count = programs[i].define_count},
                                programs[i].out);
    return r;
}

void counting_record(const counting *c, const strata_frame *frame, strata_draws draws,
                     strata_image limit, strata_buffer ranges, strata_pool records, uint32_t most) {
    const uint32_t tile_count = tiles(frame->band_width, frame->band_height);
    const strata_bind count = {
        .struct_size = sizeof count, .name = "count_image", .image = c->count};
    const strata_bind sums = bind_buffer("Sums", c->sums);
    const strata_bind nearest = bind_buffer("Nearest", c->nearest);
    const uint32_t each = c->nearest.id != 0;
    uint32_t groups[3]; /* one a tile */
    strata_groups((uint64_t)tile_count * 64, groups);

    frame->fill(frame->self, c->totals, 0, 0, 0);
    frame->pass(
        frame->self,
        &(strata_pass){
            .struct_size = sizeof(strata_pass),
            .label = "count",
            .program = c->count_program,
            .draws = draws,
            .color = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                          .image = c->count,
                                          .load = STRATA_LOAD_CLEAR,
                                          .blend = STRATA_BLEND_ADD},
            .color_count = 1,
            .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment), .image = limit},
            .depth_test = STRATA_TEST_GREATER_EQUAL});
    frame->pass(
        frame->self,
        &(strata_pass){
            .struct_size = sizeof(strata_pass),
            .label = "sums",
            .program = c->sums_program,
            .groups = {groups[0], groups[1]},
            .params = &most,
            .params_size = sizeof most,
            .binds = (const strata_bind[]){count, sums, bind_buffer("Totals", c->totals), nearest},
            .bind_count = 3 + each});
    frame->pass(frame->self,
                &(strata_pass){.struct_size = sizeof(strata_pass),
                               .label = "offsets",
                               .program = c->offsets_program,
                               .groups = {1},
                               .params = &tile_count,
                               .params_size = sizeof tile_count,
                               .binds =
                                   (const strata_bind[]){
                                       sums, {.struct_size = sizeof(strata_bind), .pool = records}},
                               .bind_count = 2});
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "ranges",
                       .program = c->ranges_program,
                       .groups = {groups[0], groups[1]},
                       .params = &most,
                       .params_size = sizeof most,
                       .binds = (const strata_bind[]){count, sums,
                                                      bind_buffer("StrataRanges", ranges), nearest},
                       .bind_count = 3 + each});
}

static uint64_t wide(const uint32_t words[2]) {
    return (uint64_t)words[1] << 32 | words[0];
}

strata_result counting_verify(const counting *c, const strata_frame *frame,
                              counting_totals *totals) {
    strata_result r = frame->read(frame->self, c->totals, 0, sizeof *totals, totals);
    if (r != STRATA_OK)
        return r;
    const uint64_t arrived = wide(totals->arrived), kept = wide(totals->kept);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_TOTAL, arrived);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_KEPT, kept);
    if (kept < arrived)
        frame->report(frame->self, STRATA_REPORT_FRAGMENTS_DROPPED, arrived - kept);
    if (totals->largest < COUNTING_LIMIT)
        return STRATA_OK;
    frame->fail(frame->self, STRATA_ERROR_OVERFLOW,
                "a pixel holds 2^24 fragments or more, too many to be counted by blending");
    return STRATA_ERROR_OVERFLOW;
}
