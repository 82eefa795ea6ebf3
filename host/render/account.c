/* SPDX-License-Identifier: MIT
 *
 * The account: what the last render cost and how right it is, as JSON. The shape is in the guide.
 */
#include "render/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Passes of one label and technique are one line: bands and rounds add up. */
strata_result render_account_passes(strata *s, base_error *err) {
    render_result *result = &s->result;
    uint32_t count = 0;
    const gpu_timing *timings = gpu_timings(s->gpu, &count);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t at = 0;
        while (at < result->pass_count &&
               (strcmp(result->passes[at].label, timings[i].label) != 0 ||
                strcmp(result->passes[at].owner, timings[i].owner) != 0))
            ++at;
        if (at == result->pass_count) {
            render_pass_time *passes =
                base_realloc(result->passes, (size_t)at + 1, sizeof *result->passes);
            if (!passes)
                return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "account: out of memory");
            result->passes = passes;
            memset(&passes[at], 0, sizeof passes[at]);
            memcpy(passes[at].label, timings[i].label, sizeof timings[i].label);
            memcpy(passes[at].owner, timings[i].owner, sizeof timings[i].owner);
            result->pass_count++;
        }
        render_pass_time *pass = &result->passes[at];
        pass->gpu_ms =
            timings[i].gpu_ms < 0 || pass->gpu_ms < 0 ? -1 : pass->gpu_ms + timings[i].gpu_ms;
        pass->cpu_ms += timings[i].cpu_ms;
    }
    return STRATA_OK;
}

void render_result_clear(render_result *result) {
    image_free(&result->color);
    image_free(&result->depth);
    image_free(&result->bound.map);
    render_deep_free(&result->deep_build);
    free(result->frames);
    free(result->passes);
    for (uint32_t i = 0; i < result->warning_count; ++i)
        free(result->warnings[i]);
    free(result->warnings);
    for (uint32_t i = 0; i < result->step_count; ++i)
        free(result->steps[i].plan);
    free(result->scene_path);
    *result = (render_result){0};
}

static json_t *passes_json(const render_result *result) {
    json_t *passes = json_array();
    for (uint32_t i = 0; i < result->pass_count; ++i) {
        const render_pass_time *p = &result->passes[i];
        json_array_append_new(passes, json_pack("{s:s, s:s, s:o, s:f}", "label", p->label,
                                                "technique", p->owner, "gpu_ms",
                                                p->gpu_ms < 0 ? json_null() : json_real(p->gpu_ms),
                                                "cpu_ms", p->cpu_ms));
    }
    return passes;
}

static json_t *known(const render_report *report, uint32_t what, uint64_t value) {
    return report->known >> what & 1u ? json_integer((json_int_t)value) : json_null();
}

/* A clip technique counts what it hides as well: that is the frame's total, and what of it was not
 * kept was dropped. */
static json_t *fragments_json(const render_report *given) {
    render_report report = *given;
    const uint32_t counted = 1u << STRATA_REPORT_FRAGMENTS_KEPT | RENDER_REPORT_BEFORE;
    if (report.known & RENDER_REPORT_BEFORE) {
        report.total = report.before;
        report.known |= 1u << STRATA_REPORT_FRAGMENTS_TOTAL;
    }
    if ((report.known & counted) == counted)
        report.dropped = report.before - report.kept;
    return json_pack("{s:o, s:o, s:o, s:o, s:o}", "total",
                     known(&report, STRATA_REPORT_FRAGMENTS_TOTAL, report.total), "max_per_pixel",
                     known(&report, STRATA_REPORT_MAX_PER_PIXEL, report.largest), "kept",
                     known(&report, STRATA_REPORT_FRAGMENTS_KEPT, report.kept), "dropped",
                     known(&report,
                           report.known >> STRATA_REPORT_FRAGMENTS_DROPPED & 1u
                               ? STRATA_REPORT_FRAGMENTS_DROPPED
                               : STRATA_REPORT_FRAGMENTS_KEPT, /* kept and none dropped */
                           report.dropped),
                     "pixels_lost", known(&report, STRATA_REPORT_PIXELS_LOST, report.lost));
}

/* Null: nothing is culled one by one. What only a check knows is null where there was none. */
static json_t *objects_json(const render_report *report) {
    if (!(report->known >> STRATA_REPORT_OBJECTS & 1u))
        return json_null();
    const uint64_t culled = report->outside + report->slipped + report->occluded;
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:o, s:o, s:o, s:o}", "total",
                     (json_int_t)report->objects, "drawn", (json_int_t)(report->objects - culled),
                     "outside", (json_int_t)report->outside, "slipped", (json_int_t)report->slipped,
                     "occluded", (json_int_t)report->occluded, "late", (json_int_t)report->late,
                     "certified", known(report, STRATA_REPORT_OBJECTS_CERTIFIED, report->certified),
                     "visible", known(report, STRATA_REPORT_OBJECTS_VISIBLE, report->visible),
                     "wrong", known(report, STRATA_REPORT_OBJECTS_WRONG, report->wrong), "overshot",
                     known(report, STRATA_REPORT_OBJECTS_OVERSHOT, report->overshot));
}

/* What techniques reported, of one frame, into its object. */
static void add_report(json_t *object, const render_report *report) {
    json_object_set_new(object, "fragments", fragments_json(report));
    json_object_set_new(object, "objects", objects_json(report));
}

static json_t *frames_json(const render_result *result) {
    json_t *frames = json_array();
    for (uint32_t i = 0; i < result->frame_count; ++i) {
        const render_figures *f = &result->frames[i];
        json_t *frame = json_pack("{s:f, s:o, s:i, s:i, s:i, s:i}", "ms", f->ms, "gpu_ms",
                                  f->gpu_ms < 0 ? json_null() : json_real(f->gpu_ms), "retries",
                                  (int)f->retries, "stalls", (int)f->stalls, "bands", (int)f->bands,
                                  "prepared", (int)f->prepared);
        add_report(frame, &f->report);
        json_array_append_new(frames, frame);
    }
    return frames;
}

/* Null: not asked for, or uncertified somewhere. */
static json_t *bound_json(uint32_t known, uint64_t uncertified, double max, double mean) {
    return known && uncertified == 0 ? json_pack("{s:f, s:f}", "max", max, "mean", mean)
                                     : json_null();
}

/* Null: none was asked for. Each rendering on the way, the last of them the result. */
static json_t *tolerance_json(const render_result *result) {
    if (!(result->tolerance > 0))
        return json_null();
    json_t *steps = json_array();
    for (uint32_t i = 0; i < result->step_count; ++i) {
        const render_step *s = &result->steps[i];
        json_array_append_new(steps, json_pack("{s:s, s:o, s:I}", "plan", s->plan, "bound",
                                               bound_json(1, s->uncertified, s->max, s->mean),
                                               "uncertified_pixels", (json_int_t)s->uncertified));
    }
    return json_pack("{s:f, s:b, s:o}", "asked", result->tolerance, "certified",
                     render_bound_holds(result), "steps", steps);
}

/* Of each technique that ran, and of the scene and the host's own targets. */
static json_t *bytes_json(const strata *s) {
    json_t *bytes = json_object();
    json_object_set_new(bytes, "scene", json_integer((json_int_t)gpu_bytes(s->gpu, "scene")));
    json_object_set_new(bytes, "host", json_integer((json_int_t)gpu_bytes(s->gpu, "host")));
    for (uint32_t i = 0; s->session && i < s->session->technique_count; ++i) {
        const char *id = s->session->techniques[i].planned->technique->id;
        json_object_set_new(bytes, id, json_integer((json_int_t)gpu_bytes(s->gpu, id)));
    }
    return bytes;
}

static json_t *opened_json(const strata *s) {
    json_t *opened = json_array();
    uint32_t count = 0;
    const char *const *ids = modules_opened(s->modules, &count);
    for (uint32_t i = 0; i < count; ++i)
        json_array_append_new(opened, json_string(ids[i]));
    return opened;
}

json_t *render_device_json(const strata *s) {
    return s->gpu ? json_pack("{s:s, s:s, s:s}", "name", s->device_info.name, "backend",
                              s->device_info.backend, "driver", s->device_info.driver)
                  : json_null();
}

json_t *render_filter_json(uint32_t samples, uint32_t filter) {
    return samples > 1 ? json_string(render_filter_name(filter)) : json_null();
}

json_t *render_warnings_json(const strata *s, const scene *sc, const plan *p) {
    json_t *warnings = json_array();
    for (uint32_t i = 0; i < sc->warning_count; ++i)
        json_array_append_new(warnings, json_string(sc->warnings[i]));
    for (uint32_t i = 0; p && i < p->warning_count; ++i)
        json_array_append_new(warnings, json_string(p->warnings[i]));
    for (uint32_t i = 0; i < s->result.warning_count; ++i)
        json_array_append_new(warnings, json_string(s->result.warnings[i]));
    return warnings;
}

json_t *render_account_json(const strata *s) {
    const render_result *result = &s->result;
    json_t *frame_ms = json_array();
    for (uint32_t i = 0; i < result->frame_count; ++i)
        json_array_append_new(frame_ms, json_real(result->frames[i].ms));
    const render_session *session = s->session;
    json_t *account = json_pack(
        "{s:s, s:o, s:[i,i], s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, "
        "s:i, s:i, s:o}",
        "scene", result->scene_path ? result->scene_path : "", "device", render_device_json(s),
        "size", (int)result->width, (int)result->height, "samples", (int)result->samples, "filter",
        render_filter_json(result->samples, result->filter), "effects",
        plan_json_effects(session->plan), "plan", plan_json_techniques(session->plan),
        "modules_opened", opened_json(s), "passes", passes_json(result), "frame_ms", frame_ms,
        "frames", frames_json(result), "bytes", bytes_json(s), "bound",
        bound_json(result->bound.known, result->bound.uncertified, result->bound.max,
                   result->bound.mean),
        "tolerance", tolerance_json(result), "budget", render_budget_json(s), "retries",
        (int)result->retries, "bands", (int)result->bands, "stalls", (int)result->stalls,
        "warnings", render_warnings_json(s, session->scene, session->plan));
    add_report(account, &result->report);
    json_object_set_new(account, "complexity", render_complexity_json(s));
    return account;
}
