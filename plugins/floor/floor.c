/* SPDX-License-Identifier: MIT
 *
 * Technique module `floor`: blends every transparent fragment once, in the order in which it comes.
 * Wrong, and what nothing that shows these fragments can undercut: costs are multiples of it. The
 * plan never takes it by itself.
 */
#include "floor_glsl.h"
#include "strata/strata.h"

typedef struct floor_state {
    const strata_gpu *gpu;
    strata_draws draws;
    strata_image color, limit;
    strata_program program;
} floor_state;

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    (void)settings;
    (void)cost; /* keeps nothing */
    return STRATA_OK;
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((floor_state *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result prepare(void *state, const strata_view *view) {
    static const char *const lit = "LIT";
    floor_state *f = state;
    f->draws = view->draws(view->self, "draws.transparent/1");
    f->color = view->image(view->self, "color/1");
    f->limit = view->image(view->self, "limit/1");
    return f->gpu->program_create(
        f->gpu->self,
        &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                               .kind = STRATA_PROGRAM_SCENE,
                               .label = "blend",
                               .source = &floor_frag_glsl,
                               .defines = &lit,
                               .define_count = view->settings->values[0] > 0},
        &f->program);
}

static void record(void *state, const strata_frame *frame) {
    const floor_state *f = state;
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "blend",
                       .program = f->program,
                       .draws = f->draws,
                       .color = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = f->color,
                                                     .blend = STRATA_BLEND_OVER},
                       .color_count = 1,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = f->limit},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static void destroy(void *state) {
    *(floor_state *)state = (floor_state){0};
}

static const strata_slot_use draws_use = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_CONSUMES,
                                          .slot = "draws.transparent/1"};
static const strata_slot_use limit_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "limit/1"};
static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use *const slots[] = {&draws_use, &limit_use, &color_use};

static const char *const shading_choices[] = {"none", "scene", NULL};
static const strata_knob shading = {.struct_size = sizeof(strata_knob),
                                    .type = STRATA_KNOB_CHOICE,
                                    .name = "shading",
                                    .title = "base colours, or lit as the scene is",
                                    .maximum = 1,
                                    .choices = shading_choices};
static const strata_knob *const knobs[] = {&shading};

static const strata_promises promises = {.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_APPROXIMATE,
                                         .determinism = STRATA_DETERMINISM_BOUNDED,
                                         .memory = "none"};
static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model), .per_fragment = 1};

static const strata_technique technique = {.struct_size = sizeof(strata_technique),
                                           .state_size = sizeof(floor_state),
                                           .id = "floor",
                                           .title = "every fragment blended once, unordered",
                                           .reference = "none: a measure",
                                           .stage = "stream",
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
                                           .destroy = destroy};
static const strata_technique *const techniques[] = {&technique};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {.struct_size = sizeof(strata_module),
                                        .abi_version = STRATA_ABI_VERSION,
                                        .min_host_version = STRATA_VERSION(1, 0),
                                        .id = "floor",
                                        .title = "The floor",
                                        .version = "1.0",
                                        .licence = "MIT",
                                        .techniques = techniques,
                                        .technique_count = 1};
