/* SPDX-License-Identifier: MIT
 *
 * A test module: a capture that claims to keep the nearest k fragments, and stores every one that
 * passes limit/1, in abuffer's lists. What a limit lets through, and what not, is then there to be
 * read.
 */
#include "sieve_glsl.h"
#include "strata/strata.h"

typedef struct sieve {
    const strata_gpu *gpu;
    strata_draws draws;
    strata_image limit;
    strata_buffer ranges;
    strata_pool records;
    strata_program heads_program, store_program;
} sieve;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((sieve *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result program(const sieve *s, uint32_t kind, const char *label,
                             const strata_glsl *source, strata_program *out) {
    return s->gpu->program_create(s->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = kind,
                                                         .label = label,
                                                         .source = source},
                                  out);
}

static strata_result prepare(void *state, const strata_view *view) {
    static const char *const payload[] = {"StrataPayload0", "StrataPayload1", "StrataPayload2",
                                          "StrataPayload3", "StrataPayload4", "StrataPayload5"};
    sieve *s = state;
    strata_pool_desc desc = {.struct_size = sizeof desc,
                             .label = "fragments",
                             .counter_name = "StrataFragmentPool",
                             .plane_names = {"StrataKeys", "StrataLinks"},
                             .plane_strides = {8, 8},
                             .plane_count = 2};
    for (uint32_t i = 0; i < view->payload_plane_count; ++i) {
        desc.plane_names[desc.plane_count] = payload[i];
        desc.plane_strides[desc.plane_count++] = view->payload_plane_strides[i];
    }
    s->draws = view->draws(view->self, "draws.transparent/1");
    s->limit = view->image(view->self, "limit/1");
    strata_result r = s->gpu->buffer_create(
        s->gpu->self,
        &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                              .label = "ranges",
                              .size = (uint64_t)view->band_width * view->band_height * 8},
        &s->ranges);
    if (r == STRATA_OK)
        r = s->gpu->pool_create(s->gpu->self, &desc, &s->records);
    if (r == STRATA_OK)
        r = program(s, STRATA_PROGRAM_COMPUTE, "heads", &heads_comp_glsl, &s->heads_program);
    if (r == STRATA_OK)
        r = program(s, STRATA_PROGRAM_SCENE, "store", &store_frag_glsl, &s->store_program);
    if (r == STRATA_OK)
        r = view->publish_fragments(view->self,
                                    &(strata_fragments){.struct_size = sizeof(strata_fragments),
                                                        .layout = view->layout,
                                                        .nearest = view->nearest,
                                                        .ranges = s->ranges,
                                                        .records = s->records});
    return r;
}

static void record(void *state, const strata_frame *frame) {
    const sieve *s = state;
    const strata_bind binds[] = {
        {.struct_size = sizeof(strata_bind), .name = "StrataRanges", .buffer = s->ranges},
        {.struct_size = sizeof(strata_bind), .pool = s->records}};
    strata_pass heads = {.struct_size = sizeof heads,
                         .label = "heads",
                         .program = s->heads_program,
                         .binds = binds,
                         .bind_count = 1};
    strata_groups((uint64_t)frame->band_width * frame->band_height, heads.groups);
    frame->pass(frame->self, &heads);
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "store",
                       .program = s->store_program,
                       .draws = s->draws,
                       .binds = binds,
                       .bind_count = 2,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = s->limit},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static strata_result verify(void *state, const strata_frame *frame) {
    const uint64_t stored = frame->needed(frame->self, ((sieve *)state)->records);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_TOTAL, stored);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_KEPT, stored);
    return STRATA_OK;
}

static void destroy(void *state) {
    (void)state;
}

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    (void)settings;
    cost->bytes_per_pixel = 8;
    cost->bytes_per_fragment = 32;
    return STRATA_OK;
}

static const strata_slot_use draws_use = {.struct_size = sizeof(strata_slot_use),
                                          .use = STRATA_SLOT_CONSUMES,
                                          .slot = "draws.transparent/1"};
static const strata_slot_use limit_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "limit/1"};
static const strata_slot_use fragments_use = {.struct_size = sizeof(strata_slot_use),
                                              .use = STRATA_SLOT_PRODUCES,
                                              .slot = "fragments/1",
                                              .layouts = 1u << STRATA_FRAGMENTS_LINKED};
static const strata_slot_use *const slots[] = {&draws_use, &limit_use, &fragments_use};

static const strata_knob nearest = {.struct_size = sizeof(strata_knob),
                                    .type = STRATA_KNOB_INT,
                                    .name = "k",
                                    .title = "the nearest that it claims to keep; 0 = all",
                                    .unit = "fragments",
                                    .maximum = 1024,
                                    .preset = 8,
                                    .trades_accuracy = 1};
static const strata_knob *const knobs[] = {&nearest};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(sieve),
    .id = "sieve",
    .title = "what passes limit/1",
    .stage = "capture",
    .slots = slots,
    .slot_count = 3,
    .knobs = knobs,
    .knob_count = 1,
    .promises = &(const strata_promises){.struct_size = sizeof(strata_promises),
                                         .order = STRATA_ORDER_NEAREST},
    .cost = &(const strata_cost_model){.struct_size = sizeof(strata_cost_model), .per_fragment = 3},
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
    .id = "sieve",
    .title = "Sieve",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
