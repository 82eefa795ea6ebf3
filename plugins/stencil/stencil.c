/* SPDX-License-Identifier: MIT
 *
 * Technique module `stencil`: the stencil-routed A-buffer (Myers and Bavoil 2007). Fills
 * fragments/1, like abuffer, but no shader decides where a fragment goes.
 *
 *   count .. ranges          exactly as many records as fragments (shared/counting.h)
 *   route                    layer i's stencil begins at i + 2; each visible fragment takes one
 *                            off, and the one that finds 2 there is written
 *   store, once a batch      shades what its layers hold
 *   check, once a batch      counts pixels whose layers are not filled one by one
 *   overflow                 and those where more fragments were routed than there are layers
 *
 * The layers of a batch are the samples of one image, which one geometry pass routes together
 * (`begin` sets the stencil of each). Where the device does not route through samples they are
 * channels of plain images, 8 a batch, with a geometry pass each.
 *
 * How many layers a frame has is learned from the counts: where they were too few, the frame is
 * recorded again; and so it is where fragments were routed that were not counted, with a shader
 * that looks for them.
 */
#include "shared/binds.h"
#include "shared/counting.h"
#include "shared/create.h"
#include "shared/records.h"
#include "shared/slots.h"
#include "stencil_glsl.h"
#include "strata/strata.h"

#include <stdio.h>
#include <string.h>

enum {
    BATCH = 8,         /* layers that are stored at once, at most: layers.glsl */
    CHANNELS = 4,      /* layers in a plain image */
    ROUTED = 2,        /* the stencil that lets a fragment through */
    UNROUTED = 255,    /* of samples that no layer is left for: fragment 253 alone finds ROUTED */
    MOST_LAYERS = 254, /* 255 - ROUTED + 1: what a stencil of 8 bits counts down */
    WINDOW = 32        /* frames after which fewer layers are believed */
};

enum { KNOB_PAYLOAD, KNOB_ROUTING, KNOB_COUNT };
enum { ROUTING_AUTO, ROUTING_LAYERS, ROUTING_SAMPLES };

typedef struct stencil {
    const strata_gpu *gpu;
    strata_draws draws;
    counting counting;
    strata_image limit, routing, layers[BATCH / CHANNELS];
    strata_buffer ranges, routing_state;
    strata_pool records;
    strata_program begin_program, route_all_program, route_program, store_program, check_program,
        overflow_program;
    uint32_t samples;                 /* layers that a geometry pass routes; 1: no samples */
    uint32_t batch;                   /* layers that are stored at once */
    uint32_t selects;                 /* 1: some fragments are hidden, or do not exist */
    uint32_t layer_count;             /* that are recorded */
    uint32_t deepest, deepest_before; /* in this window of frames and in the one before */
    uint64_t window;                  /* frame index at which this one began */
} stencil;

static const strata_glsl *const includes[] = {&layers_glsl, NULL};

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((stencil *)state)->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

/* 0 where the device does not route through samples and they were asked for. */
static int choose(stencil *s, double routing) {
    const strata_gpu *gpu = s->gpu;
    const uint64_t most = gpu->fact(gpu->self, "limit.samples");
    const int may = routing != ROUTING_LAYERS && most > 1 &&
                    gpu->fact(gpu->self, "selftest.sample_routing") != 0;
    s->samples = !may ? 1 : most < BATCH ? (uint32_t)most : BATCH;
    s->batch = may ? s->samples : BATCH;
    return may || routing != ROUTING_SAMPLES;
}

static strata_result create_layers(const stencil *s, const char *label, uint32_t format,
                                   strata_image *out) {
    return s->gpu->image_create(s->gpu->self,
                                &(strata_image_desc){.struct_size = sizeof(strata_image_desc),
                                                     .label = label,
                                                     .format = format,
                                                     .samples = s->samples},
                                out);
}

static strata_result create_images(stencil *s) {
    const int plain = s->samples == 1;
    const uint32_t format = plain ? STRATA_FORMAT_RGBA32U : STRATA_FORMAT_RGBA8;
    strata_result r = create_layers(s, "routing stencil", STRATA_FORMAT_D32F_S8, &s->routing);
    for (uint32_t i = 0; i < (plain ? BATCH / CHANNELS : 1) && r == STRATA_OK; ++i)
        r = create_layers(s, "layers", format, &s->layers[i]);
    return r;
}

static strata_result create_buffers(stencil *s, const strata_view *view) {
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height;
    strata_result r = create_buffer(s->gpu, "ranges", pixels * 8, &s->ranges);
    if (r == STRATA_OK)
        r = create_buffer(s->gpu, "routing state", 8, &s->routing_state);
    return r == STRATA_OK ? records_create(s->gpu, view, NULL, 0, &s->records) : r;
}

static strata_result program(const stencil *s, uint32_t kind, const char *label,
                             const strata_glsl *source, const char *define, uint32_t flags,
                             strata_program *out) {
    const char *defines[2];
    char samples[16];
    uint32_t count = 0;
    snprintf(samples, sizeof samples, "SAMPLES=%uu", s->samples);
    if (s->samples > 1)
        defines[count++] = samples;
    if (define)
        defines[count++] = define;
    return s->gpu->program_create(s->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = kind,
                                                         .flags = flags,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = defines,
                                                         .define_count = count,
                                                         .includes = includes},
                                  out);
}

static strata_result create_programs(stencil *s) {
    const struct {
        strata_program *out;
        uint32_t kind;
        const char *label;
        const strata_glsl *source;
        const char *define;
        uint32_t flags;
    } programs[] = {
        {&s->begin_program, STRATA_PROGRAM_FULLSCREEN, "begin", &begin_frag_glsl, NULL,
         STRATA_PROGRAM_LAZY},
        {&s->route_all_program, STRATA_PROGRAM_SCENE, "route all", &route_frag_glsl, "ALL",
         STRATA_PROGRAM_LAZY},
        {&s->route_program, STRATA_PROGRAM_SCENE, "route", &route_frag_glsl, NULL,
         STRATA_PROGRAM_LAZY},
        {&s->store_program, STRATA_PROGRAM_SCENE, "store", &store_frag_glsl, NULL, 0},
        {&s->check_program, STRATA_PROGRAM_COMPUTE, "check", &check_comp_glsl, NULL, 0},
        {&s->overflow_program, STRATA_PROGRAM_FULLSCREEN, "overflow", &overflow_frag_glsl, NULL, 0},
    };
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < sizeof programs / sizeof *programs && r == STRATA_OK; ++i)
        r = program(s, programs[i].kind, programs[i].label, programs[i].source, programs[i].define,
                    programs[i].flags, programs[i].out);
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    stencil *s = state;
    s->draws = view->draws(view->self, "draws.transparent/1");
    s->limit = view->image(view->self, "limit/1");
    if (view->changed & (STRATA_CHANGED_SCENE | STRATA_CHANGED_EFFECTS))
        s->selects = view->stats->opaque_draws > 0;
    if (!choose(s, view->settings->values[KNOB_ROUTING]))
        return STRATA_ERROR_UNSUPPORTED;
    strata_result r = create_images(s);
    if (r == STRATA_OK)
        r = create_buffers(s, view);
    if (r == STRATA_OK)
        r = counting_prepare(&s->counting, s->gpu, view, 0);
    if (r == STRATA_OK)
        r = create_programs(s);
    if (r == STRATA_OK)
        r = view->publish_fragments(view->self,
                                    &(strata_fragments){.struct_size = sizeof(strata_fragments),
                                                        .layout = STRATA_FRAGMENTS_CONTIGUOUS,
                                                        .ranges = s->ranges,
                                                        .records = s->records});
    return r;
}

/* ---- record ---------------------------------------------------------------------------------- */

/* Sample i's stencil begins where that of layer first + i does. */
static void record_begin(const stencil *s, const strata_frame *frame, uint32_t first,
                         uint32_t count) {
    for (uint32_t i = 0; i < count; ++i)
        frame->pass(
            frame->self,
            &(strata_pass){
                .struct_size = sizeof(strata_pass),
                .label = "begin",
                .program = s->begin_program,
                .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                              .image = s->routing,
                                              .load = i == 0 ? STRATA_LOAD_CLEAR : STRATA_LOAD_KEEP,
                                              .clear = {0, UNROUTED}},
                .sample_mask = 1u << i,
                .stencil_test = STRATA_TEST_ALWAYS,
                .stencil_reference = first + i + ROUTED,
                .stencil_pass = STRATA_STENCIL_REPLACE});
}

/* Into layer i goes the fragment that finds 2 in its stencil: number i of those that pass. Routes
 * this layer, whose stencil begins here, or as many as there are samples, for which it has begun.
 */
static void record_route(const stencil *s, const strata_frame *frame, uint32_t layer) {
    const int plain = s->samples == 1;
    const uint32_t image = plain ? layer % BATCH / CHANNELS : 0;
    const uint32_t channel = plain ? layer % CHANNELS : 0;
    const strata_bind limit = bind_image("limit_image", s->limit);
    frame->pass(
        frame->self,
        &(strata_pass){
            .struct_size = sizeof(strata_pass),
            .label = "route",
            .program = s->selects ? s->route_program : s->route_all_program,
            .draws = s->draws,
            .binds = &limit,
            .bind_count = s->selects,
            .color =
                &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                     .image = s->layers[image],
                                     .load = channel == 0 ? STRATA_LOAD_CLEAR : STRATA_LOAD_KEEP,
                                     .mask_off = plain ? 15u & ~(1u << channel) : 0},
            .color_count = 1,
            .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                          .image = s->routing,
                                          .load = plain ? STRATA_LOAD_CLEAR : STRATA_LOAD_KEEP,
                                          .clear = {0, (float)(layer + ROUTED)}},
            .stencil_test = STRATA_TEST_EQUAL,
            .stencil_reference = ROUTED,
            .stencil_pass = STRATA_STENCIL_DECREMENT,
            .stencil_fail = STRATA_STENCIL_DECREMENT});
}

/* Which fragments the store pass of a batch shades, by the stencil. It counts anew: the first batch
 * ends with its last fragment, a later one begins with fragment `first`. With one batch, or where
 * hidden fragments would count too, all fragments of pixels that have some in the batch: there the
 * stencil of the batch's layer i, one below first + i + ROUTED for each fragment of the pixel, is
 * below i + ROUTED. Of plain layers the last one's is left; of samples the first passes as soon as
 * any does. */
static void select_batch(const stencil *s, uint32_t first, uint32_t count,
                         strata_attachment *routing, strata_pass *pass) {
    *routing = (strata_attachment){.struct_size = sizeof *routing, .image = s->routing};
    pass->depth = routing;
    if (s->selects || s->layer_count <= s->batch) {
        pass->stencil_test = STRATA_TEST_GREATER;
        pass->stencil_reference = ROUTED + (s->samples == 1 ? count - 1 : 0);
        return;
    }
    routing->load = STRATA_LOAD_CLEAR;
    routing->clear[1] = (float)(first == 0 ? s->batch : first);
    pass->stencil_test = first == 0 ? STRATA_TEST_LESS : STRATA_TEST_EQUAL; /* 0 < stencil; 0 == */
    pass->stencil_reference = 0;
    if (first == 0)
        pass->stencil_pass = STRATA_STENCIL_DECREMENT;
    else
        pass->stencil_fail = STRATA_STENCIL_DECREMENT;
}

/* Layers first .. first + count - 1 have been routed: stores and checks them. */
static void record_batch(const stencil *s, const strata_frame *frame, uint32_t first,
                         uint32_t count) {
    const uint32_t params[] = {first, count};
    strata_attachment routing;
    binds b = {.count = 0};
    if (s->samples > 1) {
        binds_image(&b, "samples", s->layers[0]);
    } else {
        binds_image(&b, "layers0", s->layers[0]);
        binds_image(&b, "layers4", s->layers[1]);
    }
    binds_buffer(&b, "StrataRanges", s->ranges);
    binds_pool(&b, s->records);
    strata_pass pass = {
        .struct_size = sizeof pass, .params = params, .binds = b.at, .bind_count = b.count};
    pass.label = "store";
    pass.program = s->store_program;
    pass.draws = s->draws;
    pass.params_size = sizeof params[0];
    select_batch(s, first, count, &routing, &pass);
    frame->pass(frame->self, &pass);

    pass.label = "check";
    pass.program = s->check_program;
    pass.draws = (strata_draws){0};
    pass.params_size = sizeof params;
    pass.depth = NULL;
    pass.stencil_test = STRATA_TEST_NONE;
    pass.stencil_pass = pass.stencil_fail = STRATA_STENCIL_KEEP;
    b.at[b.count - 1] = bind_buffer("Routing", s->routing_state);
    strata_groups((uint64_t)frame->band_width * frame->band_height, pass.groups);
    frame->pass(frame->self, &pass);
}

/* By the stencil of the frame's last layer, number count - 1 of its batch. */
static void record_overflow(const stencil *s, const strata_frame *frame, uint32_t count) {
    const strata_bind routing = bind_buffer("Routing", s->routing_state);
    frame->pass(
        frame->self,
        &(strata_pass){.struct_size = sizeof(strata_pass),
                       .label = "overflow",
                       .program = s->overflow_program,
                       .binds = &routing,
                       .bind_count = 1,
                       .depth = &(strata_attachment){.struct_size = sizeof(strata_attachment),
                                                     .image = s->routing},
                       .sample_mask = s->samples > 1 ? 1u << (count - 1) : 0,
                       .stencil_test = STRATA_TEST_EQUAL,
                       .stencil_reference = 0});
}

static void record(void *state, const strata_frame *frame) {
    const stencil *s = state;
    counting_record(&s->counting, frame, s->draws, s->limit, s->ranges, s->records, MOST_LAYERS);
    frame->fill(frame->self, s->routing_state, 0, 0, 0);
    for (uint32_t first = 0; first < s->layer_count; first += s->batch) {
        const uint32_t left = s->layer_count - first, count = left < s->batch ? left : s->batch;
        if (s->samples > 1)
            record_begin(s, frame, first, count);
        for (uint32_t i = 0; i < count; i += s->samples)
            record_route(s, frame, first + i);
        if (count == left)
            record_overflow(s, frame, count); /* storing may count the stencil anew */
        record_batch(s, frame, first, count);
    }
}

/* ---- verify ---------------------------------------------------------------------------------- */

/* Layers grow at once, in a scene that moves by some more; they shrink when no frame of two windows
 * needed them. */
static strata_result learn(stencil *s, const strata_frame *frame, uint32_t largest) {
    if (frame->index - s->window >= WINDOW) {
        s->window = frame->index;
        s->deepest_before = s->deepest;
        s->deepest = 0;
        s->layer_count = s->deepest_before;
    }
    s->deepest = largest > s->deepest ? largest : s->deepest;
    if (largest <= s->layer_count)
        return STRATA_OK;
    const uint32_t wanted = frame->index > 0 ? largest + largest / 16 + 1 : largest;
    s->layer_count = wanted < MOST_LAYERS ? wanted : MOST_LAYERS;
    return STRATA_RETRY;
}

static strata_result refuse(const strata_frame *frame, const char *format, uint32_t number) {
    char text[160];
    snprintf(text, sizeof text, format, number);
    frame->fail(frame->self, STRATA_ERROR_UNSUPPORTED, text);
    return STRATA_ERROR_UNSUPPORTED;
}

static strata_result verify(void *state, const strata_frame *frame) {
    stencil *s = state;
    counting_totals totals;
    uint32_t routing[2] = {0}; /* pixels: misrouted, overflowed */
    const uint32_t layer_count = s->layer_count;
    strata_result r = counting_verify(&s->counting, frame, &totals);
    if (r == STRATA_OK)
        r = frame->read(frame->self, s->routing_state, 0, sizeof routing, routing);
    if (r != STRATA_OK)
        return r;
    if (totals.largest > MOST_LAYERS)
        return refuse(frame,
                      "a pixel holds %u fragments and a stencil of 8 bits routes 254; abuffer has "
                      "no such limit",
                      totals.largest);
    frame->report(frame->self, STRATA_REPORT_MAX_PER_PIXEL, totals.largest);
    r = learn(s, frame, totals.largest);
    const uint32_t wrong = routing[0] > routing[1] ? routing[0] : routing[1];
    if (totals.largest > layer_count || wrong == 0)
        return r;
    if (s->selects)
        return refuse(frame, "this driver routed %u pixels otherwise than it counted them", wrong);
    s->selects = 1;
    return STRATA_RETRY;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(stencil));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    cost->bytes_per_pixel = settings->values[KNOB_ROUTING] == ROUTING_LAYERS ? 52 : 12 + 12 * BATCH;
    cost->bytes_per_fragment = 8 + records_payload_bytes[(int)settings->values[KNOB_PAYLOAD]];
    cost->bytes_fixed = 64;
    return STRATA_OK;
}

static const strata_slot_use fragments_use = {.struct_size = sizeof(strata_slot_use),
                                              .use = STRATA_SLOT_PRODUCES,
                                              .slot = "fragments/1",
                                              .layouts = 1u << STRATA_FRAGMENTS_CONTIGUOUS};
static const strata_slot_use *const slots[] = {&slots_draws, &slots_limit, &fragments_use};

static const char *const routing_choices[] = {"auto", "layers", "samples", NULL};
static const strata_knob routing_knob = {.struct_size = sizeof(strata_knob),
                                         .type = STRATA_KNOB_CHOICE,
                                         .name = "routing",
                                         .title = "what the stencil routes fragments into",
                                         .maximum = 2,
                                         .choices = routing_choices};
static const strata_knob *const knobs[KNOB_COUNT] = {&records_payload_knob, &routing_knob};

static const char *const prefers[] = {"selftest.sample_routing", NULL};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .largest_depth = MOST_LAYERS,
    .memory = "layers: 52 pixels, n samples: (12 + 12 n) pixels; (8 + payload) fragments; "
              "payload: unorm8 4, half 8, float 16"};

/* A geometry pass a layer and an eighth of one, beside the count and what is stored. */
static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 20000,
                                       .per_pixel = 0.3,
                                       .per_fragment = 2.4,
                                       .per_triangle = 8,
                                       .per_depth = 1000,
                                       .per_depth_fragment = 0.7,
                                       .per_depth_triangle = 4.5};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(stencil),
    .id = "stencil",
    .title = "Stencil-routed A-buffer: layers told apart by counting down in the stencil",
    .reference = "Myers and Bavoil 2007, Stencil Routed A-Buffer",
    .stage = "capture",
    .slots = slots,
    .slot_count = 3,
    .knobs = knobs,
    .knob_count = KNOB_COUNT,
    .prefers = prefers,
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
    .id = "stencil",
    .title = "Stencil-routed A-buffer",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
