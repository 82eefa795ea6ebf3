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
    strata_draws draws;
    strata_image color, limit, images[MAX_ATTACHMENTS];
    strata_buffer state, totals, lost;
    strata_program stream_program, flush_program;
} kbuffer;

typedef struct totals { /* block Totals of shaders/strata/totals.glsl */
    uint32_t largest, arrived[2], kept[2];
} totals;

static const strata_glsl *const includes[] = {&sorter_glsl, NULL};

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    kbuffer *s = state;
    s->gpu = gpu;
    s->host = host;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

static strata_result buffer(const kbuffer *s, const char *label, uint64_t size,
                            strata_buffer *out) {
    return s->gpu->buffer_create(s->gpu->self,
                                 &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                       .label = label,
                                                       .size = size},
                                 out);
}

static strata_result program(const kbuffer *s, uint32_t kind, const char *label,
                             const strata_glsl *source, uint32_t k, strata_program *out) {
    char entries[16];
    const char *const defines[] = {entries, "ATTACHMENTS"};
    snprintf(entries, sizeof entries, "K=%u", k);
    return s->gpu->program_create(s->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = kind,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = defines,
                                                         .define_count = s->attachments ? 2 : 1,
                                                         .includes = includes},
                                  out);
}

/* Attachments where they hold the words; storage only where its order has been shown. */
static strata_result create_state(kbuffer *s, const strata_view *view) {
    const uint32_t attachments = (s->words + 3) / 4;
    const strata_image_desc desc = {
        .struct_size = sizeof desc, .label = "state", .format = STRATA_FORMAT_RGBA32U};
    strata_result r = STRATA_OK;
    s->attachments = 0;
    if (attachments <= MAX_ATTACHMENTS && s->gpu->fact(s->gpu->self, "ordered_attachments"))
        s->attachments = attachments;
    else if (!s->gpu->fact(s->gpu->self, "selftest.ordered_rmw")) {
        s->host->log(s->host->self, 0,
                     "kbuffer: this device holds fewer entries: take a smaller k or payload");
        return STRATA_ERROR_UNSUPPORTED;
    }
    if (!s->attachments)
        return buffer(s, "state", 4ull * s->words * view->band_width * view->band_height,
                      &s->state);
    for (uint32_t i = 0; i < attachments && r == STRATA_OK; ++i)
        r = s->gpu->image_create(s->gpu->self, &desc, &s->images[i]);
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
        r = buffer(s, "totals", sizeof(totals), &s->totals);
    if (r == STRATA_OK)
        r = buffer(s, "lost", 4, &s->lost);
    if (r == STRATA_OK)
        r = program(s, STRATA_PROGRAM_SCENE, "stream", &stream_frag_glsl, k, &s->stream_program);
    if (r == STRATA_OK)
        r = program(s, STRATA_PROGRAM_COMPUTE, "flush", &flush_comp_glsl, k, &s->flush_program);
    return r;
}

/* ---- record and verify ----------------------------------------------------------------------- */

static void record_stream(const kbuffer *s, const strata_frame *frame) {
    const strata_bind state = {.struct_size = sizeof state, .name = "State", .buffer = s->state};
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
    strata_bind binds[3 + MAX_ATTACHMENTS] = {
        {.struct_size = sizeof(strata_bind), .name = "color", .image = s->color},
        {.struct_size = sizeof(strata_bind), .name = "Totals", .buffer = s->totals},
        {.struct_size = sizeof(strata_bind), .name = "Lost", .buffer = s->lost},
        {.struct_size = sizeof(strata_bind), .name = "State", .buffer = s->state}};
    for (uint32_t i = 0; i < s->attachments; ++i)
        binds[3 + i] = (strata_bind){
            .struct_size = sizeof(strata_bind), .name = names[i], .image = s->images[i]};
    frame->fill(frame->self, s->totals, 0, 0, 0);
    frame->fill(frame->self, s->lost, 0, 0, 0);
    record_stream(s, frame);
    strata_pass flush = {.struct_size = sizeof flush,
                         .label = "flush",
                         .program = s->flush_program,
                         .binds = binds,
                         .bind_count = 3 + (s->attachments ? s->attachments : 1)};
    strata_groups((uint64_t)frame->band_width * frame->band_height, flush.groups);
    frame->pass(frame->self, &flush);
}

static strata_result verify(void *state, const strata_frame *frame) {
    const kbuffer *s = state;
    totals t = {0};
    uint32_t lost = 0;
    strata_result r = frame->read(frame->self, s->totals, 0, sizeof t, &t);
    if (r == STRATA_OK)
        r = frame->read(frame->self, s->lost, 0, sizeof lost, &lost);
    if (r != STRATA_OK)
        return r;
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_TOTAL,
                  (uint64_t)t.arrived[1] << 32 | t.arrived[0]);
    frame->report(frame->self, STRATA_REPORT_FRAGMENTS_KEPT, (uint64_t)t.kept[1] << 32 | t.kept[0]);
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
    static const uint64_t payload_words[] = {4, 2, 1}; /* STRATA_PAYLOAD_*, of plain transparency */
    const uint64_t entry = 2 + payload_words[(int)settings->values[KNOB_PAYLOAD]];
    (void)stats;
    cost->bytes_per_pixel = ((8 + (uint64_t)settings->values[KNOB_K] * entry) * 4 + 15) / 16 * 16;
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 24;
    return STRATA_OK;
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

static const char *const payload_choices[] = {"float", "half", "unorm8", NULL};
static const strata_knob k_knob = {.struct_size = sizeof(strata_knob),
                                   .type = STRATA_KNOB_INT,
                                   .name = "k",
                                   .title = "entries a pixel: by how many places its fragments may "
                                            "be out of order",
                                   .minimum = 1,
                                   .maximum = LARGEST_K,
                                   .preset = 4,
                                   .trades_accuracy = 1};
static const strata_knob payload_knob = {.struct_size = sizeof(strata_knob),
                                         .type = STRATA_KNOB_CHOICE,
                                         .name = "payload",
                                         .title = "precision of what an entry holds",
                                         .maximum = 2,
                                         .choices = payload_choices,
                                         .trades_accuracy = 1};
static const strata_knob *const knobs[] = {&k_knob, &payload_knob};

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
