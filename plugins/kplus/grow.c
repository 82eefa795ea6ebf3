/* SPDX-License-Identifier: MIT
 *
 * kplus, k per pixel. See grow.h.
 *
 * What pixels grew to is kept while scene and view stay the same, and only then: a frame's bits do
 * not depend on other views.
 */
#include "kplus/grow.h"

#include "kplus_glsl.h"
#include "shared/binds.h"
#include "shared/create.h"

enum { SEEN_WORDS = 39 }; /* block Seen in seen.comp.glsl */

/* What of the tolerance is left to the payload's precision and to the fold's roundings: a guess, of
 * which nothing depends but whether the plan has to be raised. */
static double margin(double tolerance, uint32_t payload) {
    const double precision = payload == STRATA_PAYLOAD_UNORM8 ? 1.0 / 64
                             : payload == STRATA_PAYLOAD_HALF ? 1.0 / 1024
                                                              : tolerance / 16;
    return precision < tolerance / 2 ? precision : tolerance / 2;
}

strata_result growth_prepare(growth *g, const strata_gpu *gpu, const strata_view *view,
                             uint32_t begin, uint32_t k, const strata_glsl *const *includes) {
    const uint64_t pixels = (uint64_t)view->width * view->height;
    *g = (growth){.begin = view->tolerance > 0 && begin < k ? begin : 0,
                  .k = k,
                  .anew = 1,
                  .truncation = (float)(view->tolerance - margin(view->tolerance, view->payload))};
    if (g->begin == 0)
        return STRATA_OK;
    g->behind = view->image(view->self, "color/1");
    const struct {
        strata_program *out;
        const char *label;
        const strata_glsl *source;
        const char *define;
    } programs[] = {
        {&g->compare_program, "compare", &seen_comp_glsl, "COMPARE"},
        {&g->begin_program, "begin", &seen_comp_glsl, NULL},
        {&g->grow_program, "grow", &grow_comp_glsl, "EXACT"},
        {&g->room_program, "room", &room_comp_glsl, NULL},
    };
    strata_result r = create_buffer(gpu, "nearest", pixels * 4, &g->nearest);
    if (r == STRATA_OK)
        r = create_buffer(gpu, "grown", 8, &g->grown);
    if (r == STRATA_OK)
        r = create_buffer(gpu, "seen", SEEN_WORDS * 4, &g->seen);
    for (size_t i = 0; i < sizeof programs / sizeof *programs && r == STRATA_OK; ++i)
        r = gpu->program_create(gpu->self,
                                &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                       .kind = STRATA_PROGRAM_COMPUTE,
                                                       .label = programs[i].label,
                                                       .source = programs[i].source,
                                                       .defines = &programs[i].define,
                                                       .define_count = programs[i].define != NULL,
                                                       .includes = includes},
                                programs[i].out);
    return r;
}

void growth_begin(growth *g, const strata_frame *frame) {
    if (g->begin == 0 || frame->band > 0 || (frame->attempt > 0 && !g->anew))
        return;
    const uint32_t params[] = {g->begin, g->anew, (uint32_t)frame->scene_revision,
                               (uint32_t)(frame->scene_revision >> 32)};
    const strata_bind b[] = {bind_buffer("Seen", g->seen), bind_buffer("Nearest", g->nearest)};
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "compare",
                        .program = g->compare_program,
                        .groups = {1, 1, 1},
                        .params = params,
                        .params_size = sizeof params,
                        .binds = b,
                        .bind_count = 1};
    frame->pass(frame->self, &pass);
    pass.label = "begin";
    pass.program = g->begin_program;
    pass.bind_count = 2;
    strata_groups((uint64_t)frame->width * frame->height, pass.groups);
    frame->pass(frame->self, &pass);
    g->anew = 0;
}

void growth_record(const growth *g, const strata_frame *frame, const growth_captured *captured) {
    if (g->begin == 0)
        return;
    binds b = {.count = 0}, room = {.count = 0};
    binds_pool(&b, captured->records);
    binds_buffer(&b, "StrataRanges", captured->ranges);
    binds_image(&b, "count_image", captured->count);
    binds_buffer(&b, "Events", captured->events);
    binds_buffer(&b, "Nearest", g->nearest);
    binds_buffer(&b, "Grown", g->grown);
    binds_image(&b, "behind_image", g->behind);
    const struct {
        uint32_t k, tries;
        float truncation;
    } params = {.k = g->k, .truncation = g->truncation};
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "grow",
                        .program = g->grow_program,
                        .params = &params,
                        .params_size = sizeof params,
                        .binds = b.at,
                        .bind_count = b.count};
    strata_groups((uint64_t)frame->band_width * frame->band_height, pass.groups);
    frame->fill(frame->self, g->grown, 0, 0, 0);
    frame->pass(frame->self, &pass);
    binds_pool(&room, captured->records);
    binds_buffer(&room, "Grown", g->grown);
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "room",
                                            .program = g->room_program,
                                            .groups = {1, 1, 1},
                                            .binds = room.at,
                                            .bind_count = room.count});
}

strata_result growth_verify(const growth *g, const strata_frame *frame) {
    uint32_t pixels = 0;
    if (g->begin == 0)
        return STRATA_OK;
    strata_result r = frame->read(frame->self, g->grown, 0, sizeof pixels, &pixels);
    return r == STRATA_OK && pixels > 0 ? STRATA_RETRY : r;
}
