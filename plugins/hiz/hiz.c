/* SPDX-License-Identifier: MIT
 *
 * Technique module `hiz`: two-phase occlusion culling against a pyramid of depth (Greene, Kass and
 * Miller 1993; two phases: Haar and Aaltonen 2015).
 *
 *   round 0    cull: opaque objects in the view that the last frame saw -> surface draws them
 *   round 1    pyramid of what they left -> cull: those that it does not hide -> surface draws them
 *   round 2    pyramid of the final depth -> cull: transparent objects -> whoever draws them
 *
 * All on the GPU, nothing is read back. Whatever the history says, the image is the same: what it
 * is wrong about, the second round finds.
 */
#include "hiz_glsl.h"
#include "shared/binds.h"
#include "shared/create.h"
#include "strata/strata.h"

#include <stdio.h>
#include <string.h>

enum { MAX_LEVELS = 16, CHUNK = 32, SLICE_PIXELS = 1 << 20 }; /* CHUNK: as in marks.glsl */
enum { KNOB_MODE, KNOB_TAPS, KNOB_CERTIFY, KNOB_HISTORY };
enum { MODE_TWO_PHASE, MODE_FRUSTUM };
enum { FIRST, SECOND, LAST, ROUNDS }; /* opaque, opaque, transparent */

/* Of strata/objects.glsl. */
enum { UNTESTED, KEPT, APPEARED, TOO_NEAR, OUTSIDE, SLIPPED, OCCLUDED, STATES };

typedef struct hiz {
    const strata_gpu *gpu;
    uint32_t count; /* objects; 0: nothing to do */
    uint32_t frustum, transparent, taps, certify, history;
    uint32_t levels, offsets[MAX_LEVELS]; /* levels 1 .. levels of the pyramid begin there */
    uint32_t width, height;
    strata_image depth;
    strata_buffer marks, seen, chunks, sums, commands, draw_count, last_commands, last_count,
        pyramid, census, certificates, checked;
    strata_program cull[ROUNDS], reduce, count_program, offsets_program, commands_program,
        census_program, check_program;
} hiz;

static strata_result create(void *state, const strata_host *host, const strata_gpu *gpu) {
    (void)host;
    ((hiz *)state)->gpu = gpu;
    return STRATA_OK;
}

/* ---- prepare --------------------------------------------------------------------------------- */

static strata_result program(const hiz *h, const char *label, const strata_glsl *source,
                             const char *const *defines, uint32_t define_count,
                             strata_program *out) {
    static const strata_glsl *const includes[] = {&certificates_glsl, &extent_glsl, &marks_glsl,
                                                  &pyramid_glsl, NULL};
    return h->gpu->program_create(h->gpu->self,
                                  &(strata_program_desc){.struct_size = sizeof(strata_program_desc),
                                                         .kind = STRATA_PROGRAM_COMPUTE,
                                                         .label = label,
                                                         .source = source,
                                                         .defines = defines,
                                                         .define_count = define_count,
                                                         .includes = includes},
                                  out);
}

static strata_result create_programs(hiz *h) {
    static const char *const rounds[ROUNDS] = {"HIZ_FIRST", "HIZ_SECOND", "HIZ_LAST"};
    const struct {
        strata_program *out;
        const char *label;
        const strata_glsl *source;
    } rows[] = {{&h->reduce, "pyramid", &reduce_comp_glsl},
                {&h->count_program, "count", &count_comp_glsl},
                {&h->offsets_program, "offsets", &offsets_comp_glsl},
                {&h->commands_program, "commands", &commands_comp_glsl},
                {&h->census_program, "census", &census_comp_glsl}};
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && r == STRATA_OK; ++i)
        r = program(h, rows[i].label, rows[i].source, NULL, 0, rows[i].out);
    for (uint32_t i = 0; i < ROUNDS && r == STRATA_OK; ++i) {
        const char *const defines[] = {rounds[i], h->frustum ? "HIZ_FRUSTUM" : "HIZ_CERTIFY"};
        if ((i != SECOND || !h->frustum) && (i != LAST || h->transparent))
            r = program(h, "cull", &cull_comp_glsl, defines, h->frustum || h->certify ? 2 : 1,
                        &h->cull[i]);
    }
    if (r == STRATA_OK && h->certify)
        r = program(h, "check", &check_comp_glsl, NULL, 0, &h->check_program);
    return r;
}

/* Half the size each time, rounded up, down to one texel. */
static uint64_t lay_out_pyramid(hiz *h) {
    uint32_t width = h->width, height = h->height;
    uint64_t texels = 0;
    h->levels = 0;
    while (width > 1 || height > 1) {
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        h->offsets[++h->levels] = (uint32_t)texels;
        texels += (uint64_t)width * height;
    }
    return texels ? texels : 1;
}

static strata_result create_buffers(hiz *h) {
    const uint64_t n = h->count, chunks = (n + CHUNK - 1) / CHUNK;
    const struct {
        strata_buffer *out;
        const char *label;
        uint64_t size;
        uint32_t wanted;
    } rows[] = {
        {&h->marks, "marks", n * 4, 1},
        {&h->chunks, "chunks", chunks * 4, 1},
        {&h->sums, "sums", (chunks + 63) / 64 * 4, 1},
        {&h->commands, "commands", n * 20, 1},
        {&h->draw_count, "draw count", 4, 1},
        {&h->last_commands, "transparent commands", n * 20, h->transparent},
        {&h->last_count, "transparent draw count", 4, h->transparent},
        {&h->pyramid, "pyramid", lay_out_pyramid(h) * 4, !h->frustum},
        {&h->census, "census", STATES * 4, 1},
        {&h->certificates, "certificates", n * 32, h->certify},
        {&h->checked, "checked", 8, h->certify},
    };
    strata_result r = STRATA_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && r == STRATA_OK; ++i)
        if (rows[i].wanted)
            r = create_buffer(h->gpu, rows[i].label, rows[i].size, rows[i].out);
    if (r == STRATA_OK)
        r = h->gpu->buffer_create(h->gpu->self,
                                  &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                        .label = "seen",
                                                        .size = (n + 1) * 4,
                                                        .history = "seen"},
                                  &h->seen);
    return r;
}

static strata_result prepare(void *state, const strata_view *view) {
    hiz *h = state;
    h->count = view->object_count;
    if (h->count == 0)
        return STRATA_OK;
    h->frustum = view->settings->values[KNOB_MODE] == MODE_FRUSTUM;
    h->taps = (uint32_t)view->settings->values[KNOB_TAPS];
    h->history = (uint32_t)view->settings->values[KNOB_HISTORY];
    h->certify = !h->frustum && view->settings->values[KNOB_CERTIFY] > 0;
    h->transparent = view->stats->transparent_draws > 0;
    h->width = view->width;
    h->height = view->height;
    h->depth = view->image(view->self, "depth/1");
    strata_result r = create_buffers(h);
    if (r == STRATA_OK)
        r = create_programs(h);
    if (r == STRATA_OK)
        r = view->publish_draws(view->self, "draws.opaque/1",
                                &(strata_draws_desc){.struct_size = sizeof(strata_draws_desc),
                                                     .capacity = h->count,
                                                     .commands = h->commands,
                                                     .count = h->draw_count});
    if (r == STRATA_OK && h->transparent)
        r = view->publish_draws(view->self, "draws.transparent/1",
                                &(strata_draws_desc){.struct_size = sizeof(strata_draws_desc),
                                                     .capacity = h->count,
                                                     .commands = h->last_commands,
                                                     .count = h->last_count});
    return r;
}

/* ---- record ---------------------------------------------------------------------------------- */

static void compute(const strata_frame *frame, const char *label, strata_program program,
                    const binds *b, uint64_t items, const void *params, uint32_t size) {
    strata_pass pass = {.struct_size = sizeof pass,
                        .label = label,
                        .program = program,
                        .binds = b->at,
                        .bind_count = b->count,
                        .params = params,
                        .params_size = size};
    strata_groups(items, pass.groups);
    frame->pass(frame->self, &pass);
}

static void record_pyramid(const hiz *h, const strata_frame *frame) {
    binds b = {.count = 0};
    binds_image(&b, "depth_image", h->depth);
    binds_buffer(&b, "Pyramid", h->pyramid);
    uint32_t width = h->width, height = h->height;
    for (uint32_t level = 1; level <= h->levels; ++level) {
        const uint32_t params[] = {level, h->offsets[level - 1], h->offsets[level]};
        width = (width + 1) / 2;
        height = (height + 1) / 2;
        compute(frame, "pyramid", h->reduce, &b, (uint64_t)width * height, params, sizeof params);
    }
}

static void record_cull(const hiz *h, const strata_frame *frame, uint32_t round) {
    struct {
        uint32_t count, taps, history, frame, offsets[MAX_LEVELS];
    } params = {
        .count = h->count, .taps = h->taps, .history = h->history, .frame = (uint32_t)frame->index};
    memcpy(params.offsets, h->offsets, sizeof params.offsets);
    binds b = {.count = 0};
    binds_buffer(&b, "Marks", h->marks);
    if (!h->frustum && round != LAST)
        binds_buffer(&b, "Seen", h->seen);
    if (!h->frustum && round != FIRST) {
        binds_image(&b, "depth_image", h->depth);
        binds_buffer(&b, "Pyramid", h->pyramid);
        if (h->certify)
            binds_buffer(&b, "Certificates", h->certificates);
    }
    compute(frame, "cull", h->cull[round], &b, h->count, &params, sizeof params);
}

/* The commands of what is marked, in the objects' order. */
static void record_commands(const hiz *h, const strata_frame *frame, strata_buffer commands,
                            strata_buffer draw_count) {
    const uint64_t chunks = ((uint64_t)h->count + CHUNK - 1) / CHUNK;
    const uint32_t groups = (uint32_t)((chunks + 63) / 64);
    binds b = {.count = 0}, offsets = {.count = 0};
    binds_buffer(&b, "Marks", h->marks);
    binds_buffer(&b, "Chunks", h->chunks);
    binds_buffer(&b, "Sums", h->sums);
    compute(frame, "count", h->count_program, &b, chunks, &h->count, sizeof h->count);
    binds_buffer(&offsets, "Sums", h->sums);
    binds_buffer(&offsets, "Count", draw_count);
    compute(frame, "offsets", h->offsets_program, &offsets, 1, &groups, sizeof groups);
    binds_buffer(&b, "Commands", commands);
    compute(frame, "commands", h->commands_program, &b, chunks, &h->count, sizeof h->count);
}

static void record_census(const hiz *h, const strata_frame *frame) {
    binds b = {.count = 0};
    binds_buffer(&b, "Census", h->census);
    frame->fill(frame->self, h->census, 0, 0, 0);
    compute(frame, "census", h->census_program, &b, ((uint64_t)h->count + CHUNK - 1) / CHUNK,
            &h->count, sizeof h->count);
}

static void record_check(const hiz *h, const strata_frame *frame) {
    const uint64_t pixels = (uint64_t)h->width * h->height;
    const uint32_t params[] = {h->count, (uint32_t)(pixels / SLICE_PIXELS + 1)};
    binds b = {.count = 0};
    binds_image(&b, "depth_image", h->depth);
    binds_buffer(&b, "Certificates", h->certificates);
    binds_buffer(&b, "Checked", h->checked);
    frame->fill(frame->self, h->checked, 0, 0, 0);
    compute(frame, "check", h->check_program, &b, 64ull * params[1] * h->count, params,
            sizeof params);
}

static void record(void *state, const strata_frame *frame) {
    const hiz *h = state;
    if (h->count == 0)
        return;
    if (frame->round > FIRST && !h->frustum && (frame->round != LAST || h->transparent))
        record_pyramid(h, frame);
    if (frame->round == SECOND && h->frustum) {
        frame->fill(frame->self, h->draw_count, 0, 0, 0);
    } else if (frame->round != LAST) {
        record_cull(h, frame, frame->round);
        record_commands(h, frame, h->commands, h->draw_count);
    } else if (h->transparent) {
        record_cull(h, frame, LAST);
        record_commands(h, frame, h->last_commands, h->last_count);
    }
    if (frame->round == LAST)
        record_census(h, frame);
    if (frame->round == LAST && h->certify)
        record_check(h, frame);
}

/* Whether every certificate holds; the frame fails where one does not. */
static int verify_certificates(const hiz *h, const strata_frame *frame) {
    uint32_t checked[2] = {0, 0};
    char line[128];
    if (frame->read(frame->self, h->checked, 0, sizeof checked, checked) != STRATA_OK)
        return 0;
    frame->report(frame->self, STRATA_REPORT_OBJECTS_CERTIFIED, checked[0]);
    if (checked[1] == 0)
        return 1;
    snprintf(line, sizeof line,
             "certificates of hidden objects do not hold: %u pixels of the final depth break them",
             checked[1]);
    frame->fail(frame->self, STRATA_ERROR_INTERNAL, line);
    return 0;
}

static strata_result verify(void *state, const strata_frame *frame) {
    const hiz *h = state;
    uint32_t census[STATES] = {0};
    if (h->count == 0)
        return STRATA_OK;
    const strata_result r = frame->read(frame->self, h->census, 0, sizeof census, census);
    if (r != STRATA_OK)
        return r;
    if (h->certify && !verify_certificates(h, frame))
        return STRATA_ERROR_INTERNAL;
    frame->report(frame->self, STRATA_REPORT_OBJECTS, h->count);
    frame->report(frame->self, STRATA_REPORT_OBJECTS_OUTSIDE, census[OUTSIDE]);
    frame->report(frame->self, STRATA_REPORT_OBJECTS_OCCLUDED, census[OCCLUDED]);
    frame->report(frame->self, STRATA_REPORT_OBJECTS_SLIPPED, census[SLIPPED]);
    frame->report(frame->self, STRATA_REPORT_OBJECTS_LATE, census[APPEARED]);
    return STRATA_OK;
}

static void destroy(void *state) {
    memset(state, 0, sizeof(hiz));
}

/* ---- what the plan reads --------------------------------------------------------------------- */

static strata_result estimate(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost) {
    (void)settings;
    cost->bytes_per_pixel = 2; /* a third of 4, and the edges */
    cost->bytes_per_fragment = 0;
    cost->bytes_fixed = 4096 + 52ull * stats->instances;
    return STRATA_OK;
}

static const strata_slot_use opaque_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "draws.opaque/1"};
static const strata_slot_use transparent_use = {.struct_size = sizeof(strata_slot_use),
                                                .use = STRATA_SLOT_UPDATES,
                                                .slot = "draws.transparent/1"};
static const strata_slot_use objects_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "objects/1"};
static const strata_slot_use depth_use = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "depth/1"};
static const strata_slot_use *const slots[] = {&opaque_use, &transparent_use, &objects_use,
                                               &depth_use};

static const char *const mode_choices[] = {"two_phase", "frustum", NULL};
static const strata_knob mode = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_CHOICE,
                                 .name = "mode",
                                 .title =
                                     "also what is hidden, or only what is outside of the view",
                                 .maximum = 1,
                                 .choices = mode_choices};
static const strata_knob taps = {.struct_size = sizeof(strata_knob),
                                 .type = STRATA_KNOB_INT,
                                 .name = "taps",
                                 .title =
                                     "texels of the pyramid, along one side, that an object is "
                                     "tested against at most: 2, 4 or 8",
                                 .minimum = 2,
                                 .maximum = 8,
                                 .preset = 4};
static const strata_knob certify = {.struct_size = sizeof(strata_knob),
                                    .type = STRATA_KNOB_INT,
                                    .name = "certify",
                                    .title =
                                        "1: each hidden object gets a certificate, which is held "
                                        "against every pixel of the final depth",
                                    .maximum = 1};
static const char *const history_choices[] = {"keep", "none", "all", "random", NULL};
static const strata_knob history = {.struct_size = sizeof(strata_knob),
                                    .type = STRATA_KNOB_CHOICE,
                                    .name = "history",
                                    .title = "for tests: what the last frame is said to have seen; "
                                             "the image does not depend on it",
                                    .maximum = 3,
                                    .choices = history_choices};
static const strata_knob *const knobs[] = {&mode, &taps, &certify, &history};

static const strata_promises promises = {
    .struct_size = sizeof(strata_promises),
    .order = STRATA_ORDER_EXACT,
    .determinism = STRATA_DETERMINISM_BIT,
    .memory = "28 objects + 4/3 pixels, 48 objects where some are transparent; and the host's 148 "
              "an object"};

/* Per pixel: a pyramid; per object: two culls. */
static const strata_cost_model cost = {
    .struct_size = sizeof(strata_cost_model), .frame = 50000, .per_pixel = 0.7, .per_object = 20};

static const strata_technique technique = {
    .struct_size = sizeof(strata_technique),
    .state_size = sizeof(hiz),
    .id = "hiz",
    .title = "Two-phase occlusion culling against a pyramid of depth",
    .reference = "Greene, Kass and Miller 1993; Haar and Aaltonen 2015",
    .stage = "draws",
    .slots = slots,
    .slot_count = 4,
    .knobs = knobs,
    .knob_count = 4,
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
    .id = "hiz",
    .title = "Occlusion culling",
    .version = "1.0",
    .licence = "MIT",
    .techniques = techniques,
    .technique_count = 1,
};
