/* SPDX-License-Identifier: MIT
 *
 * Learning what techniques cost here: the passes of a frame become points of the device
 * (plan/costs.h), which the plans after it go by.
 */
#include "render/render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

strata_result render_costs_fit(strata *s, costs *c, base_error *err) {
    strata_result r = render_modules(s, err);
    const modules_note **notes = r == STRATA_OK ? render_notes(s) : NULL;
    if (r == STRATA_OK && !notes)
        r = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "costs: out of memory");
    if (r == STRATA_OK)
        costs_fit(c, notes, modules_count(s->modules));
    free(notes);
    return r;
}

strata_result render_costs_load(strata *s, base_error *err) {
    const gpu_device_info *info = &s->device_info;
    char device[sizeof s->costs.device];
    costs_free(&s->costs);
    snprintf(device, sizeof device, "%.120s, %.20s, %.100s", info->name, info->backend,
             info->driver);
    strata_result r = costs_load(s->cache_dir, device, &s->costs, err);
    return r == STRATA_OK ? render_costs_fit(s, &s->costs, err) : r;
}

/* A capture's knob `mode` is its layout, which the plan may choose. */
static int is_layout(const modules_technique_note *note, const strata_knob *knob) {
    return strcmp(note->stage, "capture") == 0 && strcmp(knob->name, "mode") == 0;
}

/* Points are taken with knobs at their presets, but for those that the terms or the name tell:
 * others are of another technique, so to say. */
static int is_typical(const plan_technique *t) {
    const int count = costs_count_knob(t->technique), payload = costs_payload_knob(t->technique);
    for (uint32_t i = 0; i < t->technique->knob_count; ++i)
        if ((int)i != count && (int)i != payload &&
            !is_layout(t->technique, t->technique->knobs[i]) &&
            t->values[i] != t->technique->knobs[i]->preset)
            return 0;
    return 1;
}

/* What a clip technique leaves depends on its knobs. */
static int clips_as_usual(const plan *p) {
    for (uint32_t i = 0; i < p->technique_count; ++i)
        if (strcmp(p->techniques[i].technique->stage, "clip") == 0 &&
            !is_typical(&p->techniques[i]))
            return 0;
    return 1;
}

/* Of all its passes; below 0 where one was not measured. */
static double time_of(const render_result *result, const char *technique) {
    double sum = 0;
    for (uint32_t i = 0; i < result->pass_count && sum >= 0; ++i)
        if (strcmp(result->passes[i].owner, technique) == 0)
            sum = result->passes[i].gpu_ms < 0 ? -1 : sum + result->passes[i].gpu_ms;
    return sum;
}

/* What the frame's holder keeps of each pixel, 0 = all. */
static double kept_by(const plan *p) {
    for (uint32_t i = 0; i < p->technique_count; ++i) {
        const plan_technique *t = &p->techniques[i];
        const int knob = costs_count_knob(t->technique);
        if (knob >= 0 && (strcmp(t->technique->stage, "capture") == 0 ||
                          strcmp(t->technique->stage, "stream") == 0))
            return t->values[knob];
    }
    return 0;
}

/* Whether objects that it draws were culled before: then it costs less than what its terms say. */
static int is_culled(const plan *p, const modules_technique_note *t) {
    static const char *const draws[] = {"draws.opaque/1", "draws.transparent/1"};
    for (size_t d = 0; d < BASE_COUNT(draws); ++d)
        for (uint32_t i = 0;
             modules_slot(t, draws[d], STRATA_SLOT_CONSUMES) && i < p->technique_count; ++i)
            if (modules_slot(p->techniques[i].technique, draws[d], STRATA_SLOT_UPDATES) &&
                modules_slot(p->techniques[i].technique, "objects/1", STRATA_SLOT_UPDATES))
                return 1;
    return 0;
}

int render_learn_frame(const strata *s, costs *c, double pace) {
    const render_session *session = s->session;
    const render_result *result = &s->result;
    const render_figures *last = &result->frames[result->frame_count - 1];
    const costs_form form = plan_form(session->plan);
    double terms[COSTS_TERMS];
    char name[COSTS_NAME];
    /* A sequence may go by what is true of its own frames alone. */
    const int lasting = c == &s->costs;
    int learnt = 0;
    if (last->prepared || last->retries || session->certify || result->has_deep ||
        !clips_as_usual(session->plan) || (lasting && !session->as_planned))
        return 0;
    for (uint32_t i = 0; i < session->plan->technique_count; ++i) {
        const plan_technique *t = &session->plan->techniques[i];
        const double ms = time_of(result, t->technique->id);
        costs_terms(t->technique, &session->plan->stats, kept_by(session->plan), terms);
        costs_name(t->technique, form, name);
        learnt |= is_typical(t) && !(lasting && is_culled(session->plan, t->technique)) &&
                  costs_add(c, name, terms, ms / pace);
    }
    return learnt;
}

#define PACED 0.25 /* of a frame's time, at least, tells the pace of all */

double render_frame_pace(const strata *s) {
    const plan *p = s->session->plan;
    const costs *c = &s->costs;
    const costs_form form = plan_form(p);
    double all = 0, known = 0, expected = 0, terms[COSTS_TERMS], coefficients[COSTS_TERMS];
    for (uint32_t i = 0; i < p->technique_count; ++i) {
        const plan_technique *t = &p->techniques[i];
        const double ms = time_of(&s->result, t->technique->id);
        all += fmax(ms, 0);
        if (!(ms > 0) || !is_typical(t) || costs_of(c, t->technique, form, coefficients) <= 0 ||
            !costs_knows(c, t->technique, form))
            continue;
        costs_terms(t->technique, &p->stats, kept_by(p), terms);
        known += ms;
        expected += costs_expect(c, t->technique, form, coefficients, terms) * c->ns * 1e-6;
    }
    return expected > 0 && known >= PACED * all ? known / expected : 0;
}

int render_knows_frame(const strata *s) {
    const plan *p = s->session->plan;
    const costs_form form = plan_form(p);
    int timed = 0;
    for (uint32_t i = 0; i < p->technique_count; ++i) {
        const plan_technique *t = &p->techniques[i];
        if (!(time_of(&s->result, t->technique->id) > 0))
            continue;
        if (!is_typical(t) || !costs_knows(&s->costs, t->technique, form))
            return 0;
        timed = 1;
    }
    return timed;
}

void render_learn_keep(strata *s) {
    base_error err = {0};
    strata_result r = render_costs_fit(s, &s->costs, &err);
    if (r == STRATA_OK && s->cache_dir)
        r = costs_save(s->cache_dir, &s->costs, &err);
    if (r != STRATA_OK)
        render_warn(s, "what the frame cost is not kept: %s", err.text);
}
