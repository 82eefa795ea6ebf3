/* SPDX-License-Identifier: MIT
 *
 * Technique module `wboit`: weighted blended order-independent transparency (McGuire and Bavoil
 * 2013).
 *
 *   blend -> composite      one geometry pass into two targets, one pass over the pixels
 *
 * Nothing is sorted and nothing is kept: fast, and wrong wherever several fragments meet. The
 * yardstick for what order is worth.
 */
#include "shared/binds.h"
#include "shared/create.h"
#include "shared/slots.h"
#include "strata/strata.h"
#include "wboit_glsl.h"

#include <string.h>

enum { KNOB_WEIGHT, KNOB_SCALE, KNOB_PRECISION };

typedef struct wboit {
    const strata_gpu *gpu;
    float scale;
    strata_draws draws;
    strata_image color, limit, accumulation, revealage;
    strata_program blend_program, composite_program;
} wboit;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((wboit *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result program(const wboit *w, uint32_t kind, const char *label,
                             const strata_glsl *source, const char *define, strata_program *out) {
    return w->gpu->program_create(w->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = kind,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = &define,
                                                         .define_count = define ? 1 : 0},
                                  out);
}

static strata_result prepare(void *state, const strata_view *view) {
    static const char *const weights[] = {"WEIGHT=0", "WEIGHT=7", "WEIGHT=8", "WEIGHT=9",
                                          "WEIGHT=10"};
    wboit *w = state;
    const double *values = view->settings->values;
    const uint32_t wide =
        values[KNOB_PRECISION] > 0 ? STRATA_FORMAT_RGBA16F : STRATA_FORMAT_RGBA32F;
    w->scale = (float)values[KNOB_SCALE];
    w->draws = view->draws(view->self, "draws.transparent/1");
    w->color = view->image(view->self, "color/1");
    w->limit = view->image(view->self, "limit/1");
    strata_result r = create_image(w->gpu, "accumulation", wide, 0, 0, &w->accumulation);
    if (r == STRATA_OK)
        r = create_image(w->gpu, "revealage",
                         view->transmittance_channels == 3 ? wide : (uint32_t)STRATA_FORMAT_R32F, 0,
                         0, &w->revealage);
    if (r == STRATA_OK)
        r = program(w, STRATA_PROGRAM_SCENE, "blend", &blend_frag_glsl,
                    weights[(int)values[KNOB_WEIGHT]], &w->blend_program);
    if (r == STRATA_OK)
        r = program(w, STRATA_PROGRAM_COMPUTE, "composite", &composite_comp_glsl, NULL,
                    &w->composite_program);
    return r;
}

static void record(void *state, const strata_frame *frame) {
    const wboit *w = state;
    const float params[4] = {w->scale};
    const strata_attachment targets[] = {{.struct_size = sizeof(strata_attachment),
                                          .image = w->accumulation,
                                          .load = STRATA_LOAD_CLEAR,
                                          .blend = STRATA_BLEND_ADD},
                                         {.struct_size = sizeof(strata_attachment),
                                          .image = w->revealage,
                                          .load = STRATA_LOAD_CLEAR,
                                          .blend = STRATA_BLEND_MULTIPLY,
                                          .clear = {1, 1, 1, 1}}};
    const strata_bind bound[] = {bind_image("accumulation", w->accumulation),
                                 bind_image("revealage", w->revealage),
                                 bind_image("color", w->color)};
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "blend",
                       .program = w->blend_program,
                       .params = params,
                       .params_size = sizeof params,
                       .draws = w->draws,
                       .color = targets,
                       .color_count = 2,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = w->limit},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
    strata_pass composite = {.struct_size = sizeof composite,
                             .label = "composite",
                             .program = w->composite_program,
                             .binds = bound,
                             .bind_count = 3};
    strata_groups((uint64_t)frame->band_width * frame->band_height, composite.groups);
    frame->pass(frame->self, &composite);
}

static void destroy(void *state) {
    memset(state, 0, sizeof(wboit));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    cost->bytes_per_pixel = settings->values[KNOB_PRECISION] > 0 ? 16 : 32; /* coloured, at most */
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 0;
    return STRATA_OK;
}

static const strata_slot_use *const slots[] = {&slots_draws, &slots_limit, &slots_color,
                                               &slots_bound};

static const char *const weight_choices[] = {"one", "eq7", "eq8", "eq9", "eq10", NULL};
static const char *const precision_choices[] = {"float", "half", NULL};
static const strata_knob weight = {.struct_size = sizeof(strata_knob),
                                   .type = STRATA_KNOB_CHOICE,
                                   .name = "weight",
                                   .title = "weight of a fragment by its depth: an equation of the "
                                            "paper, or one for all",
                                   .maximum = 4,
                                   .preset = 1,
                                   .choices = weight_choices};
static const strata_knob scale = {.struct_size = sizeof(strata_knob),
                                  .type = STRATA_KNOB_FLOAT,
                                  .name = "scale",
                                  .title = "of distances, to those of 0.1 to 500 that equations 7 "
                                           "to 9 are made for",
                                  .minimum = 1e-6,
                                  .maximum = 1e6,
                                  .preset = 1};
static const strata_knob precision = {.struct_size = sizeof(strata_knob),
                                      .type = STRATA_KNOB_CHOICE,
                                      .name = "precision",
                                      .title = "of the sums: 32 or 16 bits a channel",
                                      .maximum = 1,
                                      .choices = precision_choices,
                                      .trades_accuracy = 1};
static const strata_knob *const knobs[] = {&weight, &scale, &precision};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_APPROXIMATE,
    .determinism = STRATA_DETERMINISM_BOUNDED,
    .memory = "precision=float: 20 pixels, 32 when transmission is coloured; half: 12, 16"};

static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 2000,
                                       .per_pixel = 1,
                                       .per_fragment = 1.4,
                                       .per_triangle = 4};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(wboit),
    .id = "wboit",
    .title = "Weighted blended order-independent transparency",
    .reference = "McGuire and Bavoil 2013",
    .stage = "stream",
    .slots = slots,
    .slot_count = 4,
    .knobs = knobs,
    .knob_count = 3,
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
    .id = "wboit",
    .title = "Weighted blended transparency",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
