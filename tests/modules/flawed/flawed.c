/* SPDX-License-Identifier: MIT
 *
 * A test module: a stream that blends all fragments as they come, and whose faults are chosen by
 * its mode. It claims to be exact and leaves the certificate as it was, which is a lie wherever two
 * fragments meet; it fails in every frame; or only in those that nobody certifies, and so when its
 * error is known. By another knob it breaks a rule of the calls between it and the host. And a
 * capture that hands over no fragments.
 */
#include "flawed_glsl.h"
#include "strata/strata.h"

enum { MODE_LIES, MODE_FAILS, MODE_LATE };
enum { RULE_NONE, RULE_RECORD, RULE_RETRY, RULE_MEMORY };

typedef struct flawed {
    const strata_gpu *gpu;
    int rule, prepared;
    strata_draws draws;
    strata_image color, limit;
    strata_program program;
    int fails;
} flawed;

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    (void)settings;
    (void)cost; /* keeps nothing */
    return STRATA_OK;
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((flawed *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result prepare(void *state, const strata_view *view) {
    static const char *const lit = "LIT";
    flawed *f = state;
    const int mode = (int)view->settings->values[0];
    f->draws = view->draws(view->self, "draws.transparent/1");
    f->color = view->image(view->self, "color/1");
    f->limit = view->image(view->self, "limit/1");
    f->fails =
        mode == MODE_FAILS || (mode == MODE_LATE && view->image(view->self, "bound/1").id == 0);
    f->rule = (int)view->settings->values[1];
    if (f->rule == RULE_MEMORY && !f->prepared++) { /* does without a program, then wants bands */
        static const strata_glsl bad = {"void main() { nonsense }", "bad.frag.glsl"};
        f->gpu->program_create(f->gpu->self,
                               &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                      .kind = STRATA_PROGRAM_SCENE,
                                                      .label = "bad",
                                                      .source = &bad},
                               &f->program);
        return STRATA_ERROR_OUT_OF_DEVICE_MEMORY;
    }
    return f->gpu->program_create(f->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = STRATA_PROGRAM_SCENE,
                                                         .label = "blend",
                                                         .source = &floor_frag_glsl,
                                                         .defines = &lit,
                                                         .define_count = 1},
                                  &f->program);
}

static void blend(const flawed *f, const strata_frame *frame) {
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

static void record(void *state, const strata_frame *frame) {
    blend(state, frame);
}

static strata_result verify(void *state, const strata_frame *frame) {
    const flawed *f = state;
    if (f->fails)
        frame->fail(frame->self, STRATA_ERROR_MODULE, "it fails on purpose");
    if (f->rule == RULE_RECORD)
        blend(f, frame);
    return f->rule == RULE_RETRY ? STRATA_RETRY : STRATA_OK;
}

static strata_result capture_prepare(void *state, const strata_view *view) {
    (void)state;
    (void)view; /* publishes nothing */
    return STRATA_OK;
}

static void capture_record(void *state, const strata_frame *frame) {
    (void)state;
    (void)frame;
}

static void destroy(void *state) {
    (void)state;
}

static const strata_slot_use draws_use = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_CONSUMES,
                                          .slot = "draws.transparent/1"};
static const strata_slot_use limit_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "limit/1"};
static const strata_slot_use color_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use bound_use = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_UPDATES,
                                          .slot = "bound/1",
                                          .optional = 1};
static const strata_slot_use *const slots[] = {&draws_use, &limit_use, &color_use, &bound_use};

static const char *const modes[] = {"lies", "fails", "late", NULL};
static const strata_knob mode = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "mode",
                                 .title = "what is wrong with it",
                                 .maximum = 2,
                                 .choices = modes,
                                 .trades_accuracy = 1};
static const char *const rules[] = {"none", "record", "retry", "memory", NULL};
static const strata_knob rule = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "breaks",
                                 .title = "the rule of the calls that it breaks",
                                 .maximum = 3,
                                 .choices = rules};
static const strata_knob *const knobs[] = {&mode, &rule};

/* So dear that the plan never takes it by itself. */
static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(flawed),
    .id = "flawed",
    .title = "faults to choose from",
    .stage = "stream",
    .slots = slots,
    .slot_count = 4,
    .knobs = knobs,
    .knob_count = 2,
    .promises = &(const strata_promises){.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_EXACT,
                                         .determinism = STRATA_DETERMINISM_BOUNDED},
    .cost =
        &(const strata_cost_model){.struct_size = sizeof(strata_cost_model), .per_fragment = 1e6},
    .estimate = estimate,
    .create = create,
    .prepare = prepare,
    .record = record,
    .verify = verify,
    .destroy = destroy,
};
static const strata_slot_use fragments_use = {.struct_size = sizeof(strata_slot_use),
                                              .use = STRATA_SLOT_PRODUCES,
                                              .slot = "fragments/1",
                                              .layouts = 1u << STRATA_FRAGMENTS_LINKED};
static const strata_slot_use *const capture_slots[] = {&draws_use, &limit_use, &fragments_use};
static const strata_technique silent = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(flawed),
    .id = "silent",
    .title = "hands over no fragments",
    .stage = "capture",
    .slots = capture_slots,
    .slot_count = 3,
    .promises = &(const strata_promises){.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_EXACT,
                                         .determinism = STRATA_DETERMINISM_BOUNDED},
    .cost =
        &(const strata_cost_model){.struct_size = sizeof(strata_cost_model), .per_fragment = 1e6},
    .create = create,
    .prepare = capture_prepare,
    .record = capture_record,
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique, &silent};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "flawed",
    .title = "Flawed",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 2,
};
