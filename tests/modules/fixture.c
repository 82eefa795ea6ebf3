/* SPDX-License-Identifier: MIT
 *
 * A module for the loader's tests: one technique and one effect that use every kind of declaration
 * there is. Its functions do nothing.
 */
#include "fixture_glsl.h"
#include "strata/strata.h"

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    (void)settings;
    cost->bytes_per_pixel = 8;
    return STRATA_OK;
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)state;
    (void)host;
    (void)gpu;
    return STRATA_OK;
}

static strata_result prepare(void *state, const strata_view *view) {
    (void)state;
    (void)view;
    return STRATA_OK;
}

static void record(void *state, const strata_frame *frame) {
    (void)state;
    (void)frame;
}

static void destroy(void *state) {
    (void)state;
}

static const strata_slot_use fragments = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_CONSUMES,
                                          .slot = "fragments/1",
                                          .layouts = 1u << STRATA_FRAGMENTS_CONTIGUOUS};
static const strata_slot_use color = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use limit = {.struct_size = sizeof(strata_slot_use),
                                      .use = STRATA_SLOT_CONSUMES,
                                      .slot = "limit/1",
                                      .optional = 1};
static const strata_slot_use *const slots[] = {&fragments, &color, &limit};

static const strata_knob count = {.struct_size = sizeof(strata_knob),
                                  .type = STRATA_KNOB_INT,
                                  .name = "k",
                                  .title = "fragments kept in a pixel",
                                  .unit = "fragments",
                                  .minimum = 1,
                                  .maximum = 64,
                                  .preset = 8,
                                  .trades_accuracy = 1};
static const strata_knob threshold = {.struct_size = sizeof(strata_knob),
                                      .type = STRATA_KNOB_FLOAT,
                                      .name = "threshold",
                                      .title = "transmittance at which the fold ends",
                                      .minimum = 0,
                                      .maximum = 1,
                                      .preset = 0.1};
static const char *const modes[] = {"fast", "small", NULL};
static const strata_knob mode = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "mode",
                                 .title = "what to save",
                                 .preset = 1,
                                 .choices = modes};
static const strata_knob *const knobs[] = {&count, &threshold, &mode};

static const strata_promises promises = {.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_NEAREST,
                                         .determinism = STRATA_DETERMINISM_BIT,
                                         .largest_depth = 64,
                                         .memory = "8 pixels"};
static const strata_cost_model cost = {
    .struct_size = sizeof(strata_cost_model), .frame = 1e6, .per_pixel = 0.3, .per_fragment = 1.1};
static const char *const needs[] = {"feature.subgroup_ballot", NULL};
static const char *const prefers[] = {"selftest.ordered_rmw", "feature.int64_atomics", NULL};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = 16,
    .id = "fixture",
    .title = "Nothing, declared in full",
    .reference = "nobody",
    .stage = "resolve",
    .slots = slots,
    .slot_count = 3,
    .knob_count = 3,
    .knobs = knobs,
    .promises = &promises,
    .cost = &cost,
    .needs = needs,
    .prefers = prefers,
    .estimate = estimate,
    .create = create,
    .prepare = prepare,
    .record = record,
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique};

static const strata_field tint = {
    .struct_size = sizeof(strata_field), .channels = 4, .name = "tint"};
static const strata_field index_field = {
    .struct_size = sizeof(strata_field), .channels = 1, .name = "index", .exact = 1};
static const strata_field *const payload[] = {&tint, &index_field};
static const strata_need blend = {
    .struct_size = sizeof(strata_need), .fact = "materials.blend", .threshold = 2.5};
static const strata_need *const called_for_by[] = {&blend};

static const strata_effect effect = {
    .struct_size = sizeof(strata_effect),
    .flags = STRATA_EFFECT_SEQUENTIAL,
    .id = "fixture",
    .title = "a tint",
    .transmittance_channels = 3,
    .field_count = 2,
    .payload = payload,
    .called_for_by = called_for_by,
    .need_count = 1,
    .priority = 7,
    .glsl = &fixture_glsl,
};
static const strata_effect *const effects[] = {&effect};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "fixture",
    .title = "A module for tests",
    .version = "1.2",
    .licence = "MIT",
    .techniques = techniques,
    .effects = effects,
    .technique_count = 1,
    .effect_count = 1,
};
