/* SPDX-License-Identifier: MIT
 *
 * Technique module `abuffer`: captures every transparent fragment, in whatever order it arrives.
 *
 *   contiguous  count (additive blending) -> sums -> offsets -> ranges -> store: exactly as many
 *               records as fragments (S-buffer, Vasilakis and Fudos 2012)
 *   linked      heads -> store: one geometry pass, a list for each pixel (Yang et al. 2010)
 *
 * Fills fragments/1. Nothing is dropped: a pool that is too small is counted, grown by the host,
 * and the frame recorded again.
 */
#include "abuffer_glsl.h"
#include "shared/counting.h"
#include "shared/create.h"
#include "shared/records.h"
#include "shared/slots.h"
#include "strata/strata.h"

#include <string.h>

typedef struct abuffer {
    const strata_gpu *gpu;
    uint32_t layout;
    int cursors;   /* contiguous: cursors are in an attachment, not counted down in storage */
    int subgroups; /* linked: one addition to the common counter for a subgroup */
    strata_draws draws;
    strata_image limit;
    strata_buffer ranges;
    strata_pool records;
    counting counting;
    strata_program heads_program, store_program;
} abuffer;

static strata_result program(const abuffer *a, uint32_t kind, const char *label,
                             const strata_glsl *source, strata_program *out) {
    const char *defines[2];
    uint32_t count = 0;
    if (a->cursors)
        defines[count++] = "STRATA_CURSORS";
    if (a->subgroups)
        defines[count++] = "STRATA_SUBGROUPS";
    return a->gpu->program_create(a->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = kind,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = defines,
                                                         .define_count = count},
                                  out);
}

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((abuffer *)state)->gpu = gpu;
    return STRATA_OK;
}

static strata_result prepare(void *state, const strata_view *view) {
    abuffer *a = state;
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height;
    a->layout = view->layout;
    a->cursors = a->layout == STRATA_FRAGMENTS_CONTIGUOUS &&
                 a->gpu->fact(a->gpu->self, "ordered_attachments") != 0;
    a->subgroups = a->layout == STRATA_FRAGMENTS_LINKED &&
                   a->gpu->fact(a->gpu->self, "feature.subgroup_ballot") != 0;
    a->draws = view->draws(view->self, "draws.transparent/1");
    a->limit = view->image(view->self, "limit/1");
    strata_result r = create_buffer(a->gpu, "ranges", pixels * 8, &a->ranges);
    if (r == STRATA_OK)
        r = records_create(a->gpu, view,
                           a->layout == STRATA_FRAGMENTS_LINKED ? "StrataLinks" : NULL, 0,
                           &a->records);
    if (r == STRATA_OK && a->layout == STRATA_FRAGMENTS_LINKED)
        r = program(a, STRATA_PROGRAM_COMPUTE, "heads", &heads_comp_glsl, &a->heads_program);
    if (r == STRATA_OK && a->layout == STRATA_FRAGMENTS_CONTIGUOUS)
        r = counting_prepare(&a->counting, a->gpu, view,
                             a->cursors ? COUNTING_CURSORS : COUNTING_ENDS);
    if (r == STRATA_OK)
        r = program(a, STRATA_PROGRAM_SCENE, "store", &counting_store_glsl, &a->store_program);
    if (r == STRATA_OK)
        r = view->publish_fragments(view->self,
                                    &(strata_fragments){.struct_size = sizeof(strata_fragments),
                                                        .layout = a->layout,
                                                        .ranges = a->ranges,
                                                        .records = a->records});
    return r;
}

static void record_heads(const abuffer *a, const strata_frame *frame) {
    const strata_bind ranges = {
        .struct_size = sizeof ranges, .name = "StrataRanges", .buffer = a->ranges};
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "heads",
                        .program = a->heads_program,
                        .binds = &ranges,
                        .bind_count = 1};
    strata_groups((uint64_t)frame->band_width * frame->band_height, pass.groups);
    frame->pass(frame->self, &pass);
}

static void record(void *state, const strata_frame *frame) {
    const abuffer *a = state;
    if (a->layout == STRATA_FRAGMENTS_CONTIGUOUS)
        counting_record(&a->counting, frame, a->draws, a->limit, a->ranges, a->records,
                        COUNTING_ALL);
    else
        record_heads(a, frame);

    const strata_bind binds[] = {
        {.struct_size = sizeof(strata_bind), .pool = a->records},
        {.struct_size = sizeof(strata_bind), .name = "StrataRanges", .buffer = a->ranges}};
    const strata_attachment cursors = {
        .struct_size = sizeof cursors, .image = a->counting.count, .read = 1};
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "store",
                       .program = a->store_program,
                       .draws = a->draws,
                       .binds = binds,
                       .bind_count = a->cursors ? 1 : 2,
                       .color = &cursors,
                       .color_count = a->cursors ? 1 : 0,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = a->limit},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static strata_result verify(void *state, const strata_frame *frame) {
    const abuffer *a = state;
    counting_totals totals;
    if (a->layout == STRATA_FRAGMENTS_CONTIGUOUS)
        return counting_verify(&a->counting, frame, &totals);
    const uint64_t total = frame->needed(frame->self, a->records);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_TOTAL, total);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_KEPT, total);
    return STRATA_OK; /* the pool counted; nothing else can go wrong */
}

static void destroy(void *state) {
    memset(state, 0, sizeof(abuffer));
}

/* ---- what the plan reads ------------------------------------------------------------------------
 */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    const int linked = settings->values[0] > 0;
    cost->bytes_per_pixel = linked ? 8 : 12;
    cost->bytes_per_fragment =
        8 + records_payload_bytes[(int)settings->values[1]] + (linked ? 8 : 0);
    cost->bytes_fixed = 64;
    return STRATA_OK;
}

static const strata_slot_use fragments_use = {.struct_size = sizeof(strata_slot_use),
                                              .use = STRATA_SLOT_PRODUCES,
                                              .slot = "fragments/1",
                                              .layouts = 1u << STRATA_FRAGMENTS_CONTIGUOUS |
                                                         1u << STRATA_FRAGMENTS_LINKED};
static const strata_slot_use *const slots[] = {&slots_draws, &slots_limit, &fragments_use};

static const char *const mode_choices[] = {"contiguous", "linked", NULL};
static const strata_knob mode = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "mode",
                                 .title = "how records are laid out",
                                 .maximum = 1,
                                 .choices = mode_choices};
static const strata_knob *const knobs[] = {&mode, &records_payload_knob};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory = "contiguous: 12 pixels + (8 + payload) fragments; "
              "linked: 8 pixels + (16 + payload) fragments; payload: unorm8 4, half 8, float 16"};

static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 20000,
                                       .per_pixel = 0.3,
                                       .per_fragment = 2.4,
                                       .per_triangle = 8};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(abuffer),
    .id = "abuffer",
    .title = "A-buffer: every fragment, in exactly sized or linked storage",
    .reference = "Carpenter 1984; Yang et al. 2010; Vasilakis and Fudos 2012 (S-buffer)",
    .stage = "capture",
    .slots = slots,
    .slot_count = 3,
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
    .id = "abuffer",
    .title = "A-buffer",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
