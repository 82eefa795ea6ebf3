/* SPDX-License-Identifier: MIT
 *
 * Technique module `kbuffer`: the k-buffer, a streaming sorter (Callahan, Ikits, Comba and Silva
 * 2005; the second half of HAVS).
 *
 *   stream -> flush         one geometry pass, one pass over the pixels
 *
 * Each pixel holds k entries; of these and the incoming one the nearest is folded at once. Right
 * for a stream that is sorted but for k places, and a pixel where it is not is found out and
 * counted.
 */
#include "kbuffer_glsl.h"
#include "shared/binds.h"
#include "shared/counting.h"
#include "shared/create.h"
#include "shared/records.h"
#include "shared/slots.h"
#include "strata/strata.h"

#include <stdio.h>
#include <string.h>

enum { KNOB_K, KNOB_PAYLOAD };
enum { LARGEST_K = 16, MAX_ATTACHMENTS = 8 };

typedef struct kbuffer {
    const strata_gpu *gpu;
    const strata_host *host;
    uint32_t words;       /* a pixel's, see sorter.glsl */
    uint32_t attachments; /* that hold them, four words each; 0: they are in storage */
    uint32_t interlock;   /* 1: an interlock is what keeps storage in order */
    strata_draws draws;
    strata_image color, limit, images[MAX_ATTACHMENTS];
    strata_buffer state, lost;
    counting counting;
    strata_program stream_program, flush_program;
} kbuffer;

static const strata_glsl *const includes[] = {&sorter_glsl, NULL};

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    kbuffer *s = state;
    s->gpu = gpu;
    s->host = host;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

static strata_result program(const kbuffer *s, uint32_t kind, const char *label,
                             const strata_glsl *source, uint32_t k, strata_program *out) {
    char entries[16];
    const char *const defines[] = {entries, s->attachments ? "ATTACHMENTS" : "STRATA_INTERLOCK"};
    snprintf(entries, sizeof entries, "K=%u", k);
    return s->gpu->program_create(
        s->gpu->self,
        &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                               .kind = kind,
                               .label = label,
                               .source = source,
                               .defines = defines,
                               .define_count = s->attachments || s->interlock ? 2 : 1,
                               .includes = includes},
        out);
}

static int has(const kbuffer *s, const char *fact) {
    return s->gpu->fact(s->gpu->self, fact) != 0;
}

/* Attachments where they hold the words; storage where accesses to it have been shown to be in
 * order, by themselves or by the interlock. */
static strata_result create_state(kbuffer *s, const strata_view *view) {
    const uint32_t attachments = (s->words + 3) / 4;
    const int held = attachments <= MAX_ATTACHMENTS && has(s, "ordered_attachments");
    strata_result r = STRATA_OK;
    s->attachments = held ? attachments : 0;
    s->interlock = !held && !has(s, "selftest.ordered_rmw");
    if (s->interlock && !has(s, "selftest.interlock")) {
        s->host->log(s->host->self, 0,
                     "this device holds fewer entries: take a smaller k or payload");
        return STRATA_ERROR_UNSUPPORTED;
    }
    if (!s->attachments)
        return create_buffer(s->gpu, "state",
                             4ull * s->words * view->band_width * view->band_height, &s->state);
    for (uint32_t i = 0; i < attachments && r == STRATA_OK; ++i)
        r = create_image(s->gpu, "state", STRATA_FORMAT_RGBA32U, 0, 0, &s->images[i]);
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    kbuffer *s = state;
    const uint32_t k = (uint32_t)view->settings->values[KNOB_K];
    uint32_t payload = 0; /* words */
    for (uint32_t i = 0; i < view->payload_plane_count; ++i)
        payload += view->payload_plane_strides[i] / 4;
    s->words = 7 + view->transmittance_channels + k * (2 + payload);
    if (view->certify)
        s->words += 4 + view->transmittance_channels;
    s->draws = view->draws(view->self, "draws.transparent/1");
    s->color = view->image(view->self, "color/1");
    s->limit = view->image(view->self, "limit/1");
    strata_result r = create_state(s, view);
    if (r == STRATA_OK)
        r = counting_prepare_totals(&s->counting, s->gpu);
    if (r == STRATA_OK)
        r = create_buffer(s->gpu, "lost", 4, &s->lost);
    if (r == STRATA_OK)
        r = program(s, STRATA_PROGRAM_SCENE, "stream", &stream_frag_glsl, k, &s->stream_program);
    if (r == STRATA_OK)
        r = program(s, STRATA_PROGRAM_COMPUTE, "flush", &flush_comp_glsl, k, &s->flush_program);
    return r;
}

/* ---- record and verify ----------------------------------------------------------------------- */

static void record_stream(const kbuffer *s, const strata_frame *frame) {
    const strata_bind state = bind_buffer("State", s->state);
    strata_attachment color[MAX_ATTACHMENTS];
    for (uint32_t i = 0; i < s->attachments; ++i)
        color[i] = (strata_attachment){.struct_size = sizeof *color,
                                       .image = s->images[i],
                                       .load = STRATA_LOAD_CLEAR,
                                       .read = 1};
    if (!s->attachments)
        frame->fill(frame->self, s->state, 0, 0, 0);
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "stream",
                       .program = s->stream_program,
                       .draws = s->draws,
                       .binds = &state,
                       .bind_count = s->attachments ? 0 : 1,
                       .color = color,
                       .color_count = s->attachments,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = s->limit},
                       .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static void record(void *state, const strata_frame *frame) {
    static const char *const names[MAX_ATTACHMENTS] = {"state0", "state1", "state2", "state3",
                                                       "state4", "state5", "state6", "state7"};
    const kbuffer *s = state;
    binds b = {.count = 0};
    binds_image(&b, "color", s->color);
    binds_buffer(&b, "Totals", s->counting.totals);
    binds_buffer(&b, "Lost", s->lost);
    if (!s->attachments)
        binds_buffer(&b, "State", s->state);
    for (uint32_t i = 0; i < s->attachments; ++i)
        binds_image(&b, names[i], s->images[i]);
    frame->fill(frame->self, s->counting.totals, 0, 0, 0);
    frame->fill(frame->self, s->lost, 0, 0, 0);
    record_stream(s, frame);
    strata_pass flush = {.struct_size = sizeof flush,
                         .label = "flush",
                         .program = s->flush_program,
                         .binds = b.at,
                         .bind_count = b.count};
    strata_groups((uint64_t)frame->band_width * frame->band_height, flush.groups);
    frame->pass(frame->self, &flush);
}

static strata_result verify(void *state, const strata_frame *frame) {
    const kbuffer *s = state;
    counting_totals t;
    uint32_t lost = 0;
    strata_result r = counting_verify(&s->counting, frame, &t);
    if (r == STRATA_OK)
        r = frame->read(frame->self, s->lost, 0, sizeof lost, &lost);
    if (r != STRATA_OK)
        return r;
    frame->report(frame->self, STRATA_REPORT_MAX_PER_PIXEL, t.largest);
    frame->report(frame->self, STRATA_REPORT_PIXELS_LOST, lost);
    return STRATA_OK;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(kbuffer));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    const uint64_t entry = 8 + records_payload_bytes[(int)settings->values[KNOB_PAYLOAD]];
    (void)stats;
    cost->bytes_per_pixel = (32 + (uint64_t)settings->values[KNOB_K] * entry + 15) / 16 * 16;
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 24;
    return STRATA_OK;
}

static const strata_slot_use *const slots[] = {&slots_draws, &slots_limit, &slots_color,
                                               &slots_bound};

static const strata_knob k_knob = {.struct_size = sizeof(strata_knob),
                                   .type = STRATA_KNOB_INT,
                                   .name = "k",
                                   .title = "entries a pixel: by how many places its fragments may "
                                            "be out of order",
                                   .minimum = 1,
                                   .maximum = LARGEST_K,
                                   .preset = 4,
                                   .trades_accuracy = 1};
static const strata_knob *const knobs[] = {&k_knob, &records_payload_knob};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_APPROXIMATE,
    .determinism = STRATA_DETERMINISM_BOUNDED,
    .memory = "(32 + k (8 + payload)) pixels, 40 in place of 32 when transmission is coloured; "
              "payload: unorm8 4, half 8, float 16"};

static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 2000,
                                       .per_pixel = 1,
                                       .per_fragment = 2.5,
                                       .per_triangle = 4};

/* ordered_access: attachments or storage that fragments of a pixel touch in order. */
static const char *const needs[] = {"ordered_access", NULL};
static const char *const prefers[] = {"ordered_attachments", NULL};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(kbuffer),
    .id = "kbuffer",
    .title = "k-buffer: a streaming sorter of k entries, which finds out when it fails",
    .reference = "Callahan, Ikits, Comba and Silva 2005",
    .stage = "stream",
    .slots = slots,
    .slot_count = 4,
    .knobs = knobs,
    .knob_count = 2,
    .promises = &promises,
    .cost = &cost,
    .needs = needs,
    .prefers = prefers,
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
    .id = "kbuffer",
    .title = "k-buffer",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
