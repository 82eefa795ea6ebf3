/* SPDX-License-Identifier: MIT
 *
 * Technique module `peel`: depth peeling (Everitt 2001), which draws everything again for each
 * layer and keeps nothing but one fragment a pixel at a time.
 *
 *   fold -> (nearest -> shade -> fold)*n -> rest -> finish     front_to_back
 *   fold -> (range -> shade -> fold)*n -> finish               dual (Bavoil and Myers 2008)
 *
 * Layers follow the total order (key, order), so that fragments at one depth are layers of their
 * own. Steps are recorded in batches; after each the host reads how far the last one got.
 */
#include "peel_glsl.h"
#include "shared/binds.h"
#include "shared/counting.h"
#include "shared/create.h"
#include "shared/records.h"
#include "shared/slots.h"
#include "strata/strata.h"

#include <string.h>

enum {
    PIXELS_PER_INVOCATION = 16,
    BATCH = 4,         /* steps in the first batch of a band that was never rendered */
    STEP_LIMIT = 2048, /* a fragment among several at its depth takes two steps, others one */
    LARGEST_DEPTH = STEP_LIMIT / 2,
    KNOWN_BANDS = 64
};

enum { KNOB_MODE, KNOB_LAYERS, KNOB_PAYLOAD };

typedef struct peel {
    const strata_gpu *gpu;
    uint32_t sides; /* 1, or 2 in dual mode: slots a pixel */
    uint32_t layers;
    strata_draws draws;
    strata_image color, limit;
    strata_image nearest_depth;     /* front to back */
    strata_image nearest, farthest; /* dual */
    strata_buffer last, founds, walks, counts, progress;
    counting totals;
    strata_buffer payload[STRATA_MAX_PLANES];
    uint32_t plane_count;
    strata_program fold_program, nearest_program, shade_program, rest_program, finish_program;
    uint32_t steps[KNOWN_BANDS]; /* that a band took when it was last recorded; 0: not known */
} peel;

static const strata_glsl *const includes[] = {&state_glsl, &walks_glsl, NULL};

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((peel *)state)->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

static strata_result prepare_programs(peel *p) {
    static const char *const sides[2][1] = {{"PEEL_SIDES=1"}, {"PEEL_SIDES=2"}};
    const struct {
        strata_program *out;
        const char *label;
        const strata_glsl *source;
        uint32_t kind;
    } rows[] = {
        {&p->fold_program, "fold", &fold_frag_glsl, STRATA_PROGRAM_FULLSCREEN},
        {&p->nearest_program, "nearest", p->sides == 1 ? &nearest_frag_glsl : &range_frag_glsl,
         STRATA_PROGRAM_SCENE},
        {&p->shade_program, "shade", &shade_frag_glsl, STRATA_PROGRAM_SCENE},
        {&p->finish_program, "finish", &finish_comp_glsl, STRATA_PROGRAM_COMPUTE},
        {&p->rest_program, "rest", &rest_frag_glsl, STRATA_PROGRAM_SCENE},
    };
    const size_t count = sizeof rows / sizeof *rows - (p->layers == 0);
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < count && r == STRATA_OK; ++i)
        r = p->gpu->program_create(
            p->gpu->self,
            &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                   .kind = rows[i].kind,
                                   .label = rows[i].label,
                                   .source = rows[i].source,
                                   .defines = sides[p->sides - 1],
                                   .define_count = 1,
                                   .includes = includes},
            rows[i].out);
    return r;
}

static strata_result prepare_buffers(peel *p, const strata_view *view) {
    const uint64_t pixels = (uint64_t)view->band_width * view->band_height,
                   slots = pixels * p->sides;
    const struct {
        strata_buffer *out;
        const char *label;
        uint64_t size;
    } rows[] = {
        {&p->last, "last", slots * 8},
        {&p->founds, "found", slots * 16},
        {&p->walks, "walks", slots * (view->certify ? 64 : 32)},
        {&p->counts, "counts", pixels * 8},
        {&p->progress, "progress", 4},
    };
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && r == STRATA_OK; ++i)
        r = create_buffer(p->gpu, rows[i].label, rows[i].size, rows[i].out);
    if (r == STRATA_OK)
        r = counting_prepare_totals(&p->totals, p->gpu);
    p->plane_count = view->payload_plane_count;
    for (uint32_t i = 0; i < p->plane_count && r == STRATA_OK; ++i)
        r = create_buffer(p->gpu, records_payload_names[i], slots * view->payload_plane_strides[i],
                          &p->payload[i]);
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    peel *p = state;
    p->sides = view->settings->values[KNOB_MODE] > 0 ? 2 : 1;
    p->layers = (uint32_t)view->settings->values[KNOB_LAYERS];
    p->draws = view->draws(view->self, "draws.transparent/1");
    p->color = view->image(view->self, "color/1");
    p->limit = view->image(view->self, "limit/1");
    memset(p->steps, 0, sizeof p->steps);
    strata_result r = prepare_buffers(p, view);
    if (r == STRATA_OK && p->sides == 1)
        r = create_image(p->gpu, "nearest", STRATA_FORMAT_D32F, 0, 0, &p->nearest_depth);
    if (r == STRATA_OK && p->sides == 2)
        r = create_image(p->gpu, "nearest", STRATA_FORMAT_R32F, 0, 0, &p->nearest);
    if (r == STRATA_OK && p->sides == 2)
        r = create_image(p->gpu, "farthest", STRATA_FORMAT_R32F, 0, 0, &p->farthest);
    return r == STRATA_OK ? prepare_programs(p) : r;
}

/* ---- record ---------------------------------------------------------------------------------- */

static void add_payload(binds *b, const peel *p) {
    for (uint32_t i = 0; i < p->plane_count; ++i)
        binds_buffer(b, records_payload_names[i], p->payload[i]);
}

static strata_attachment attach(strata_image target) {
    return (strata_attachment){.struct_size = sizeof(strata_attachment), .image = target};
}

static void record_fold(const peel *p, const strata_frame *frame, uint32_t step) {
    const uint32_t params[2] = {step, p->layers};
    binds b = {.count = 0};
    binds_buffer(&b, "PeelLast", p->last);
    binds_buffer(&b, "PeelFounds", p->founds);
    binds_buffer(&b, "PeelWalks", p->walks);
    binds_buffer(&b, "PeelCounts", p->counts);
    binds_buffer(&b, "PeelProgress", p->progress);
    add_payload(&b, p);
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "fold",
                        .program = p->fold_program,
                        .params = params,
                        .params_size = sizeof params};
    strata_attachment depth = attach(p->nearest_depth);
    depth.load = STRATA_LOAD_DISCARD;
    if (p->sides == 1) {
        binds_image(&b, "limit", p->limit);
        pass.depth = &depth;
        pass.depth_test = STRATA_TEST_ALWAYS;
        pass.depth_write = 1;
    }
    pass.binds = b.at;
    pass.bind_count = b.count;
    frame->pass(frame->self, &pass);
}

/* Which depths come next. Dual begins below every depth: it keeps the greatest of z and of -z. */
static void record_nearest(const peel *p, const strata_frame *frame) {
    const strata_attachment depth = attach(p->sides == 1 ? p->nearest_depth : p->limit);
    strata_attachment range[2] = {attach(p->nearest), attach(p->farthest)};
    const strata_bind last = {.struct_size = sizeof last, .name = "PeelLast", .buffer = p->last};
    for (int i = 0; i < 2; ++i) {
        range[i].load = STRATA_LOAD_CLEAR;
        range[i].blend = STRATA_BLEND_MAX;
        range[i].clear[0] = -2;
    }
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = p->sides == 1 ? "nearest" : "range",
                                            .program = p->nearest_program,
                                            .draws = p->draws,
                                            .binds = &last,
                                            .bind_count = 1,
                                            .color = range,
                                            .color_count = p->sides == 1 ? 0 : 2,
                                            .depth = &depth,
                                            .depth_test = p->sides == 1 ? STRATA_TEST_GREATER
                                                                        : STRATA_TEST_GREATER_EQUAL,
                                            .depth_write = p->sides == 1});
}

static void record_shade(const peel *p, const strata_frame *frame) {
    const strata_attachment depth = attach(p->sides == 1 ? p->nearest_depth : p->limit);
    binds b = {.count = 0};
    binds_buffer(&b, "PeelLast", p->last);
    binds_buffer(&b, "PeelFounds", p->founds);
    add_payload(&b, p);
    if (p->sides == 2) {
        binds_image(&b, "nearest_image", p->nearest);
        binds_image(&b, "farthest_image", p->farthest);
    }
    frame->pass(frame->self,
                &(strata_pass){.struct_size = sizeof(strata_pass),
                               .label = "shade",
                               .program = p->shade_program,
                               .draws = p->draws,
                               .binds = b.at,
                               .bind_count = b.count,
                               .depth = &depth,
                               .depth_test =
                                   p->sides == 1 ? STRATA_TEST_EQUAL : STRATA_TEST_GREATER_EQUAL});
}

static void record_rest(const peel *p, const strata_frame *frame) {
    const strata_attachment depth = attach(p->limit);
    binds b = {.count = 0};
    binds_buffer(&b, "PeelLast", p->last);
    binds_buffer(&b, "PeelCounts", p->counts);
    frame->pass(frame->self, &(strata_pass){.struct_size = sizeof(strata_pass),
                                            .label = "rest",
                                            .program = p->rest_program,
                                            .draws = p->draws,
                                            .binds = b.at,
                                            .bind_count = b.count,
                                            .depth = &depth,
                                            .depth_test = STRATA_TEST_GREATER_EQUAL});
}

static void record_finish(const peel *p, const strata_frame *frame) {
    binds b = {.count = 0};
    binds_buffer(&b, "PeelWalks", p->walks);
    binds_buffer(&b, "PeelCounts", p->counts);
    binds_buffer(&b, "Totals", p->totals.totals);
    binds_image(&b, "color", p->color);
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = "finish",
                        .program = p->finish_program,
                        .binds = b.at,
                        .bind_count = b.count};
    const uint64_t pixels = (uint64_t)frame->band_width * frame->band_height;
    strata_groups((pixels + PIXELS_PER_INVOCATION - 1) / PIXELS_PER_INVOCATION, pass.groups);
    frame->fill(frame->self, p->totals.totals, 0, 0, 0);
    frame->pass(frame->self, &pass);
}

/* Steps until none of the band's pixels has anything left; 0: the frame failed. */
static uint32_t record_steps(const peel *p, const strata_frame *frame, uint32_t batch) {
    uint32_t steps = 0, reached = 0;
    record_fold(p, frame, 0);
    do {
        if (steps == STEP_LIMIT) {
            frame->fail(frame->self, STRATA_ERROR_OVERFLOW,
                        "after 2048 steps a pixel still has fragments; abuffer has no such limit");
            return 0;
        }
        for (; batch > 0 && steps < STEP_LIMIT; --batch) {
            record_nearest(p, frame);
            record_shade(p, frame);
            record_fold(p, frame, ++steps);
        }
        if (frame->read(frame->self, p->progress, 0, sizeof reached, &reached) != STRATA_OK)
            return 0;
        batch = steps < 2 * BATCH ? BATCH : steps / 2;
    } while (reached == steps);
    return reached + 1;
}

static void record(void *state, const strata_frame *frame) {
    peel *p = state;
    uint32_t *known = &p->steps[frame->band % KNOWN_BANDS];
    if (p->sides == 2 && p->layers) {
        frame->fail(frame->self, STRATA_ERROR_UNSUPPORTED,
                    "peel.layers keeps the nearest layers, which peel.mode=dual cannot");
        return;
    }
    frame->fill(frame->self, p->progress, 0, 0, 0);
    *known = record_steps(p, frame, *known ? *known : BATCH);
    if (p->layers)
        record_rest(p, frame);
    record_finish(p, frame);
}

static strata_result verify(void *state, const strata_frame *frame) {
    const peel *p = state;
    counting_totals totals;
    const strata_result r = counting_verify(&p->totals, frame, &totals);
    if (r == STRATA_OK)
        frame->report(frame->self, STRATA_REPORT_MAX_PER_PIXEL, totals.largest);
    return r;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(peel));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)stats;
    const uint64_t sides = settings->values[KNOB_MODE] > 0 ? 2 : 1;
    cost->bytes_per_pixel =
        8 + sides * (60 + records_payload_bytes[(int)settings->values[KNOB_PAYLOAD]]);
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 64;
    return STRATA_OK;
}

static const strata_slot_use *const slots[] = {&slots_draws, &slots_limit, &slots_color,
                                               &slots_bound};

static const char *const mode_choices[] = {"front_to_back", "dual", NULL};
static const strata_knob mode = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "mode",
                                 .title =
                                     "one layer a step, or the nearest and the farthest, which "
                                     "rounds differently",
                                 .maximum = 1,
                                 .choices = mode_choices,
                                 .trades_accuracy = 1};
static const strata_knob layers = {.struct_size = sizeof(strata_knob),
                                   .type = STRATA_KNOB_INT,
                                   .name = "layers",
                                   .title = "nearest layers that are kept; 0 = all",
                                   .unit = "layers",
                                   .maximum = LARGEST_DEPTH,
                                   .trades_accuracy = 1};
static const strata_knob *const knobs[] = {&mode, &layers, &records_payload_knob};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .largest_depth = LARGEST_DEPTH,
    .memory = "front_to_back: (68 + payload) pixels; dual: (128 + 2 payload) pixels; "
              "payload: unorm8 4, half 8, float 16"};

/* A step: two passes over everything, of which the depth test rejects most, and the fold. */
static const strata_cost_model cost = {.struct_size = sizeof(strata_cost_model),
                                       .frame = 5000,
                                       .per_pixel = 5,
                                       .per_depth = 2000,
                                       .per_depth_pixel = 4,
                                       .per_depth_fragment = 0.7,
                                       .per_depth_triangle = 8};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(peel),
    .id = "peel",
    .title = "Depth peeling: everything is drawn again for each layer",
    .reference = "Everitt 2001; Bavoil and Myers 2008 (dual)",
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
    .verify = verify,
    .destroy = destroy,
};
static const strata_technique *const techniques[] = {&technique};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "peel",
    .title = "Depth peeling",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
