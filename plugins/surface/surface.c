/* SPDX-License-Identifier: MIT
 *
 * Technique module `surface`: opaque and alpha-tested geometry, shaded, into color/1 and depth/1.
 *
 *   ties=any    one pass; of opaque fragments at one depth the first drawn is shown
 *   ties=exact  nearest (depth) -> winner (highest primitive number at that depth) -> surface: the
 *               same picture whatever the order of drawing
 *
 * Recorded once a round; a later round draws what earlier ones left out, over their depth.
 */
#include "strata/strata.h"
#include "surface_glsl.h"

#include <string.h>

typedef struct surface {
    const strata_gpu *gpu;
    uint32_t exact;
    strata_draws draws;
    strata_image color, depth, winners;
    strata_program nearest_program, winner_program, surface_program;
} surface;

static strata_result program(const surface *s, const char *label, const strata_glsl *source,
                             strata_program *out) {
    static const char *const exact[] = {"SURFACE_EXACT"};
    return s->gpu->program_create(s->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = STRATA_PROGRAM_SCENE,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = exact,
                                                         .define_count = s->exact},
                                  out);
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((surface *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result prepare_exact(surface *s, const strata_view *view) {
    const strata_image_desc winners = {.struct_size = sizeof winners,
                                       .label = "winners",
                                       .format = STRATA_FORMAT_R32U,
                                       .width = view->width,
                                       .height = view->height};
    strata_result r = s->gpu->image_create(s->gpu->self, &winners, &s->winners);
    if (r == STRATA_OK)
        r = program(s, "nearest", &nearest_frag_glsl, &s->nearest_program);
    if (r == STRATA_OK)
        r = program(s, "winner", &winner_frag_glsl, &s->winner_program);
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    surface *s = state;
    s->exact = view->settings->values[0] > 0;
    s->draws = view->draws(view->self, "draws.opaque/1");
    s->color = view->image(view->self, "color/1");
    s->depth = view->image(view->self, "depth/1");
    strata_result r = s->exact ? prepare_exact(s, view) : STRATA_OK;
    return r == STRATA_OK ? program(s, "surface", &surface_frag_glsl, &s->surface_program) : r;
}

/* Winners of earlier rounds stay, except where this round comes nearer: there the first pass writes
 * that nobody won yet. */
static void record_winners(const surface *s, const strata_frame *frame) {
    const strata_attachment depth = {.struct_size = sizeof depth, .image = s->depth};
    const strata_attachment cleared = {.struct_size = sizeof cleared,
                                       .image = s->winners,
                                       .load = frame->round ? STRATA_LOAD_KEEP : STRATA_LOAD_CLEAR};
    const strata_bind winners = {
        .struct_size = sizeof winners, .name = "winners", .image = s->winners};
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "nearest",
                                            .program = s->nearest_program,
                                            .draws = s->draws,
                                            .color = &cleared,
                                            .color_count = 1,
                                            .depth = &depth,
                                            .depth_test = STRATA_TEST_GREATER,
                                            .depth_write = 1});
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "winner",
                                            .program = s->winner_program,
                                            .draws = s->draws,
                                            .binds = &winners,
                                            .bind_count = 1,
                                            .depth = &depth,
                                            .depth_test = STRATA_TEST_EQUAL});
}

static void record(void *state, const strata_frame *frame) {
    const surface *s = state;
    if (s->exact)
        record_winners(s, frame);
    const strata_attachment color = {.struct_size = sizeof color, .image = s->color};
    const strata_attachment depth = {.struct_size = sizeof depth, .image = s->depth};
    const strata_bind winners = {
        .struct_size = sizeof winners, .name = "winners", .image = s->winners};
    frame->pass(frame->self,
                &(strata_pass){.struct_size = sizeof(strata_pass),
                               .label = "surface",
                               .program = s->surface_program,
                               .draws = s->draws,
                               .binds = &winners,
                               .bind_count = s->exact,
                               .color = &color,
                               .color_count = 1,
                               .depth = &depth,
                               .depth_test = s->exact ? STRATA_TEST_EQUAL : STRATA_TEST_GREATER,
                               .depth_write = !s->exact});
}

static void destroy(void *state) {
    memset(state, 0, sizeof(surface));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    cost->bytes_per_pixel = settings->values[0] > 0 ? 4 : 0;
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 0;
    return STRATA_OK;
}

static const strata_slot_use draws_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "draws.opaque/1"};
static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use depth_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "depth/1"};
static const strata_slot_use *const slots[] = {&draws_use, &color_use, &depth_use};

static const char *const tie_choices[] = {"any", "exact", NULL};
static const strata_knob ties = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "ties",
                                 .title = "opaque surfaces at one depth: the first drawn, or the "
                                          "highest primitive number",
                                 .maximum = 1,
                                 .choices = tie_choices};
static const strata_knob *const knobs[] = {&ties};

static const strata_promises promises = {.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_EXACT,
                                         .determinism = STRATA_DETERMINISM_BIT,
                                         .memory = "ties=any: none; ties=exact: 4 pixels"};

static const strata_cost_model cost = {
    .struct_size = sizeof(strata_cost_model), .frame = 2000, .per_fragment = 8, .per_triangle = 30};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(surface),
    .id = "surface",
    .title = "Opaque surfaces, glTF's metallic-roughness model",
    .reference = "glTF 2.0, appendix B; Walter et al. 2007 (GGX)",
    .stage = "surface",
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
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "surface",
    .title = "Opaque surfaces",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
