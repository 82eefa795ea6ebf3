/* SPDX-License-Identifier: MIT
 *
 * One frame: the opaque part once (in rounds), the transparent part band by band, the filter once,
 * each verified; and again while something overflowed or was learned. Stands between plan and
 * fragments.
 */
#include "render/render.h"

#include <stdlib.h>
#include <string.h>

#define MAX_ATTEMPTS 64u

/* Parts of a frame, in their order: what is recorded and verified together. */
typedef enum frame_part {
    PART_OPAQUE, /* draws, surface: the whole frame */
    PART_BAND,   /* clip, capture, resolve, stream, certificate */
    PART_FILTER  /* the whole frame again: a pixel's weights reach beyond its band */
} frame_part;

/* ---- strata_frame: what a technique may do while it records or verifies ---------------------- */

/* Commands are recorded by record() alone. */
static int may_record(render_technique *t, const char *what) {
    if (!t->recording)
        base_fail(&t->error, STRATA_ERROR_INVALID_STATE, "%s outside of record()", what);
    return t->recording != 0;
}

static void frame_pass(void *self, const strata_pass *pass) {
    render_technique *t = self;
    if (may_record(t, "a pass"))
        gpu_pass(t->session->owner->gpu, t->planned->technique->id, pass);
}

static void frame_fill(void *self, strata_buffer buffer, uint64_t offset, uint64_t size,
                       uint32_t value) {
    render_technique *t = self;
    if (may_record(t, "a fill"))
        gpu_fill(t->session->owner->gpu, t->planned->technique->id, buffer, offset, size, value);
}

static void frame_copy(void *self, strata_buffer to, uint64_t to_offset, strata_buffer from,
                       uint64_t from_offset, uint64_t size) {
    render_technique *t = self;
    if (may_record(t, "a copy"))
        gpu_copy(t->session->owner->gpu, t->planned->technique->id, to, to_offset, from,
                 from_offset, size);
}

static strata_result frame_read(void *self, strata_buffer buffer, uint64_t offset, uint64_t size,
                                void *data) {
    render_technique *t = self;
    gpu *g = t->session->owner->gpu;
    if (!t->verifying) {
        strata_result r = gpu_submit(g, &t->error);
        if (r != STRATA_OK)
            return r;
        t->session->owner->result.stalls++;
    }
    return gpu_buffer_read(g, buffer, offset, size, data, &t->error);
}

static uint64_t frame_needed(void *self, strata_pool pool) {
    render_technique *t = self;
    uint64_t needed = 0;
    return gpu_pool_needed(t->session->owner->gpu, pool, &needed, &t->error) == STRATA_OK ? needed
                                                                                          : 0;
}

static void frame_report(void *self, uint32_t what, uint64_t value) {
    const render_technique *t = self;
    render_report *report = &t->session->report;
    if (what < STRATA_REPORT_FRAGMENTS_TOTAL || what > STRATA_REPORT_OBJECTS_SLIPPED)
        return;
    if (strcmp(t->technique->stage, "clip") == 0) {
        if (what == STRATA_REPORT_FRAGMENTS_TOTAL) {
            report->known |= RENDER_REPORT_BEFORE;
            report->before += value;
        }
        return;
    }
    report->known |= 1u << what;
    if (what == STRATA_REPORT_FRAGMENTS_TOTAL)
        report->total += value;
    else if (what == STRATA_REPORT_FRAGMENTS_KEPT)
        report->kept += value;
    else if (what == STRATA_REPORT_FRAGMENTS_DROPPED)
        report->dropped += value;
    else if (what == STRATA_REPORT_PIXELS_LOST)
        report->lost += value;
    else if (what == STRATA_REPORT_OBJECTS)
        report->objects += value;
    else if (what == STRATA_REPORT_OBJECTS_OUTSIDE)
        report->outside += value;
    else if (what == STRATA_REPORT_OBJECTS_OCCLUDED)
        report->occluded += value;
    else if (what == STRATA_REPORT_OBJECTS_LATE)
        report->late += value;
    else if (what == STRATA_REPORT_OBJECTS_CERTIFIED)
        report->certified += value;
    else if (what == STRATA_REPORT_OBJECTS_VISIBLE)
        report->visible += value;
    else if (what == STRATA_REPORT_OBJECTS_WRONG)
        report->wrong += value;
    else if (what == STRATA_REPORT_OBJECTS_OVERSHOT)
        report->overshot += value;
    else if (what == STRATA_REPORT_OBJECTS_SLIPPED)
        report->slipped += value;
    else if (value > report->largest)
        report->largest = value;
}

static void frame_failed(void *self, strata_result result, const char *text) {
    render_technique *t = self;
    base_fail(&t->error, result < 0 ? result : STRATA_ERROR_MODULE, "%s", text);
    if (!t->verifying)
        gpu_frame_fail(t->session->owner->gpu, t->planned->technique->id, t->error.result, text);
}

static strata_frame make_frame(render_technique *t, frame_part part, uint32_t band,
                               uint32_t round) {
    const render_session *session = t->session;
    const render_rect whole = {0, 0, session->width, session->height};
    const render_rect *rect = part == PART_BAND ? &session->bands[band] : &whole;
    return (strata_frame){.struct_size = sizeof(strata_frame),
                          .round = round,
                          .rounds = session->rounds,
                          .self = t,
                          .width = session->width,
                          .height = session->height,
                          .band = band,
                          .band_count = part == PART_BAND ? session->band_count : 1,
                          .x = rect->x,
                          .y = rect->y,
                          .band_width = rect->width,
                          .band_height = rect->height,
                          .index = session->frame_index,
                          .attempt = session->attempt,
                          .scene_revision = session->scene_revision,
                          .gpu = &t->gpu,
                          .pass = frame_pass,
                          .fill = frame_fill,
                          .copy = frame_copy,
                          .read = frame_read,
                          .needed = frame_needed,
                          .report = frame_report,
                          .fail = frame_failed};
}

/* ---- the frame block ------------------------------------------------------------------------- */

static strata_result write_block(render_session *session, const scene_view *view,
                                 const strata_render_options *options, const render_rect *rect,
                                 base_error *err) {
    const upload_counts counts = upload_count(session->upload);
    render_frame_block block = {
        .frame_size = {session->width, session->height, session->samples,
                       (uint32_t)session->frame_index},
        .band = {rect->x, rect->y, rect->width, rect->height},
        .counts = {counts.lights, counts.materials, counts.records, counts.textures}};
    memcpy(block.world_to_clip, view->world_to_clip, sizeof block.world_to_clip);
    memcpy(block.world_to_eye, view->world_to_eye, sizeof block.world_to_eye);
    memcpy(block.clip_to_world, view->clip_to_world, sizeof block.clip_to_world);
    memcpy(block.eye, view->eye, sizeof block.eye);
    memcpy(block.background, options->background, sizeof block.background);
    return gpu_buffer_write(session->owner->gpu, session->frame_block, 0, sizeof block, &block,
                            err);
}

/* ---- recording and verifying ----------------------------------------------------------------- */

static int draws(const render_technique *t) {
    return strcmp(t->planned->technique->stage, "draws") == 0;
}

static frame_part part_of(const render_technique *t) {
    const char *stage = t->planned->technique->stage;
    if (draws(t) || strcmp(stage, "surface") == 0)
        return PART_OPAQUE;
    return strcmp(stage, "filter") == 0 ? PART_FILTER : PART_BAND;
}

static strata_result record_technique(render_session *session, render_technique *t, frame_part part,
                                      uint32_t band, uint32_t round, const char **failed,
                                      base_error *err) {
    gpu *g = session->owner->gpu;
    const strata_frame frame = make_frame(t, part, band, round);
    strata_result r = STRATA_OK;
    t->error = (base_error){0};
    t->recording = 1;
    t->technique->record(t->state, &frame);
    t->recording = 0;
    if (gpu_frame_error(g)->result != STRATA_OK)
        *failed = t->planned->technique->id;
    if (session->careful || *failed)
        r = gpu_submit(g, err);
    if (r != STRATA_OK)
        *failed = t->planned->technique->id;
    return r;
}

/* Records the techniques of one part of the frame and submits. Where those that draw learn from the
 * depth that surface leaves, they and it have a round each time, and they one more at the end, in
 * which nothing opaque is drawn any more. */
static strata_result record_techniques(render_session *session, frame_part part, uint32_t band,
                                       const char **failed, base_error *err) {
    gpu *g = session->owner->gpu;
    const uint32_t rounds = part == PART_OPAQUE ? session->rounds : 1;
    strata_result r = STRATA_OK;
    for (uint32_t round = 0; round < rounds + (rounds > 1) && r == STRATA_OK; ++round)
        for (uint32_t i = 0; i < session->technique_count && r == STRATA_OK; ++i) {
            render_technique *t = &session->techniques[i];
            if (part_of(t) == part && (round < rounds || draws(t)))
                r = record_technique(session, t, part, band, round, failed, err);
        }
    return r == STRATA_OK ? gpu_submit(g, err) : r;
}

/* The techniques of one part of the frame, before the next gpu_begin makes their pools' counters
 * void. */
static strata_result verify_techniques(render_session *session, frame_part part, uint32_t band,
                                       int *again, const char **failed, base_error *err) {
    gpu *g = session->owner->gpu;
    for (uint32_t i = 0; i < session->technique_count; ++i) {
        render_technique *t = &session->techniques[i];
        if (part_of(t) != part)
            continue;
        for (uint32_t p = 0; p < t->pool_count; ++p) {
            uint64_t needed = 0;
            strata_result r = gpu_pool_needed(g, t->pools[p], &needed, err);
            if (r != STRATA_OK)
                return r;
            if (needed > t->pool_needed[p])
                t->pool_needed[p] = needed;
            if (needed > gpu_pool_capacity(g, t->pools[p])) {
                *again = 1;
                session->again_by = t->planned->technique->id;
            }
        }
        if (!t->technique->verify)
            continue;
        const strata_frame frame = make_frame(t, part, band, 0);
        t->error = (base_error){0};
        t->verifying = 1;
        strata_result r = t->technique->verify(t->state, &frame);
        t->verifying = 0;
        if (t->error.result != STRATA_OK)
            r = t->error.result;
        if (r == STRATA_RETRY) {
            *again = 1;
            session->again_by = t->planned->technique->id;
        } else if (r != STRATA_OK) {
            *failed = t->planned->technique->id;
            return base_fail(err, r < 0 ? r : STRATA_ERROR_MODULE, "%s: %s", *failed,
                             t->error.text[0] ? t->error.text : "verify failed");
        }
    }
    return STRATA_OK;
}

static strata_result record_opaque(render_session *session, const scene_view *view,
                                   const strata_render_options *options, int *again,
                                   const char **failed, base_error *err) {
    gpu *g = session->owner->gpu;
    const render_rect whole = {0, 0, session->width, session->height};
    const float far[4] = {0, 0, 0, 0};
    strata_result r = write_block(session, view, options, &whole, err);
    if (r != STRATA_OK)
        return r;
    gpu_begin(g, session->width, session->height);
    gpu_clear_image(g, "host", session->color, options->background);
    gpu_clear_image(g, "host", session->depth, far);
    render_bound_begin(session);
    r = record_techniques(session, PART_OPAQUE, 0, failed, err);
    if (r == STRATA_OK)
        r = verify_techniques(session, PART_OPAQUE, 0, again, failed, err);
    return r == STRATA_OK ? render_account_passes(session->owner, err) : r;
}

/* Sub-pixels to pixels, once all bands are folded. */
static strata_result record_filter(render_session *session, const scene_view *view,
                                   const strata_render_options *options, int *again,
                                   const char **failed, base_error *err) {
    const render_rect whole = {0, 0, session->width, session->height};
    if (session->samples == 1)
        return STRATA_OK;
    strata_result r = write_block(session, view, options, &whole, err);
    if (r != STRATA_OK)
        return r;
    gpu_begin(session->owner->gpu, session->width, session->height);
    r = record_techniques(session, PART_FILTER, 0, failed, err);
    if (r == STRATA_OK)
        r = verify_techniques(session, PART_FILTER, 0, again, failed, err);
    return r == STRATA_OK ? render_account_passes(session->owner, err) : r;
}

static strata_result record_bands(render_session *session, const scene_view *view,
                                  const strata_render_options *options, int *again,
                                  const char **failed, base_error *err) {
    gpu *g = session->owner->gpu;
    strata *s = session->owner;
    for (uint32_t band = 0; band < session->band_count; ++band) {
        const render_rect *rect = &session->bands[band];
        strata_result r = write_block(session, view, options, rect, err);
        if (r != STRATA_OK)
            return r;
        gpu_begin(g, session->width, session->height);
        gpu_rectangle(g, rect->x, rect->y, rect->width, rect->height);
        render_bound_begin_band(session);
        r = record_techniques(session, PART_BAND, band, failed, err);
        if (r == STRATA_OK)
            r = verify_techniques(session, PART_BAND, band, again, failed, err);
        if (r == STRATA_OK)
            r = render_account_passes(s, err);
        if (r == STRATA_OK && (options->outputs & STRATA_OUTPUT_DEEP) && !*again)
            r = render_deep_band(session, rect, err);
        if (r != STRATA_OK)
            return r;
        if (options->progress && session->band_count > 1 &&
            options->progress(options->user, (band + 1.0) / session->band_count) != STRATA_OK)
            return base_fail(err, STRATA_ERROR_CANCELLED, "cancelled");
    }
    return STRATA_OK;
}

static void forget_needs(render_session *session) {
    for (uint32_t i = 0; i < session->technique_count; ++i)
        memset(session->techniques[i].pool_needed, 0, sizeof session->techniques[i].pool_needed);
}

strata_result render_frame(render_session *session, const scene_view *view,
                           const strata_render_options *options, const char **failed,
                           base_error *err) {
    strata_result r = STRATA_OK;
    int again = 1;
    *failed = NULL;
    session->again_by = NULL;
    render_room_watch(session, view);
    for (session->attempt = 0; again && r == STRATA_OK; session->attempt++) {
        if (session->attempt == MAX_ATTEMPTS) {
            r = base_fail(err, STRATA_ERROR_OVERFLOW, "the frame was recorded %u times in vain%s%s",
                          MAX_ATTEMPTS, session->again_by ? ", at last for " : "",
                          session->again_by ? session->again_by : "");
            break;
        }
        again = 0;
        session->report = (render_report){0};
        session->owner->result.pass_count = 0;
        r = render_prepare_in_room(session, &again, failed, err);
        if (r == STRATA_OK && !again && session->attempt == 0)
            r = render_room_ahead(session, &again, err);
        if (again)
            continue;
        forget_needs(session);
        if (r == STRATA_OK)
            r = record_opaque(session, view, options, &again, failed, err);
        if (r == STRATA_OK && (options->outputs & STRATA_OUTPUT_DEEP))
            r = render_deep_begin(session, err);
        if (r == STRATA_OK)
            r = record_bands(session, view, options, &again, failed, err);
        if (r == STRATA_OK && !again)
            r = record_filter(session, view, options, &again, failed, err);
        if (r == STRATA_OK && again)
            r = render_make_room(session, err);
        session->owner->result.retries += again ? 1u : 0u;
    }
    session->frame_index++;
    return r;
}
