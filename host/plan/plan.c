/* SPDX-License-Identifier: MIT
 *
 * Making a plan, step by step: effects, candidates, settings, what may run, what is chosen, its
 * order, the payload, and a reason for everything else. See plan.h.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static strata_result no_memory(base_error *err) {
    return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
}

/* ---- output ---------------------------------------------------------------------------------- */

static uint32_t points_of(const plan *p, const plan_candidate *c) {
    costs_form form = plan_form(p);
    form.clipped &= (uint32_t)c->chosen;
    const int points = plan_price_at(c, form)->points;
    return points > 0 ? (uint32_t)points : 0;
}

/* Hands a chosen candidate's values over to the plan. */
static void add_technique(plan *p, plan_candidate *c) {
    plan_technique *t = &p->techniques[p->technique_count++];
    *t = (plan_technique){
        .technique = c->note,
        .values = c->values,
        .settings =
            {
                .struct_size = sizeof t->settings,
                .count = c->note->knob_count,
                .values = c->values,
            },
        .cost = c->cost,
        .points = points_of(p, c),
    };
    memcpy(t->reason, c->reason, sizeof t->reason);
    c->values = NULL;
}

static void add_left_out(plan *p, const plan_candidate *c) {
    plan_left_out *l = &p->left_out[p->left_out_count++];
    *l = (plan_left_out){.technique = c->note, .cost = c->compared, .points = points_of(p, c)};
    memcpy(l->reason, c->reason, sizeof l->reason);
}

static void expect_time(plan_work *w) {
    plan *p = w->out;
    const costs *c = w->in->costs;
    p->cost = 0.0;
    for (uint32_t i = 0; i < p->technique_count; i++)
        p->cost = p->cost == PLAN_NO_COST || p->techniques[i].cost == PLAN_NO_COST
                      ? PLAN_NO_COST
                      : p->cost + p->techniques[i].cost;
    const double ns = plan_ns(w->in);
    p->ms = ns > 0.0 && p->cost != PLAN_NO_COST ? p->cost * ns * 1e-6 : PLAN_NO_COST;
    if (c && c->ns > 0.0)
        snprintf(p->measured_on, sizeof p->measured_on, "%s", c->device);
}

static strata_result write_out(plan_work *w) {
    plan *p = w->out;
    uint32_t count = 0;
    uint32_t *order = base_calloc(w->count, sizeof *order);
    p->techniques = base_calloc(w->count, sizeof *p->techniques);
    p->left_out = base_calloc(w->count, sizeof *p->left_out);
    strata_result result =
        order && p->techniques && p->left_out ? plan_order(w, order, &count) : no_memory(w->err);
    for (uint32_t i = 0; i < count && result == STRATA_OK; i++)
        add_technique(p, &w->candidates[order[i]]);
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++)
        if (!w->candidates[i].chosen)
            add_left_out(p, &w->candidates[i]);
    expect_time(w);
    free(order);
    return result;
}

static strata_result make_payload(plan_work *w) {
    plan *p = w->out;
    if (!p->transparent)
        return STRATA_OK;
    const modules_effect_note **active = base_calloc(p->active_effects, sizeof *active);
    if (!active)
        return no_memory(w->err);
    p->transmittance_channels = 1;
    for (uint32_t i = 0; i < p->effect_count; i++) {
        const plan_effect *e = &p->effects[i];
        if (!e->active)
            continue;
        active[e->index] = e->effect;
        if (e->effect->transmittance_channels > p->transmittance_channels)
            p->transmittance_channels = e->effect->transmittance_channels;
    }
    strata_result result =
        plan_payload_make(active, p->active_effects, p->payload.precision, &p->payload, w->err);
    free(active);
    if (p->captures) /* (key, order), payload, and for linked records (next, pixel) */
        p->bytes_per_fragment =
            8u + p->payload.words * 4u + (p->layout == STRATA_FRAGMENTS_LINKED ? 8u : 0u);
    return result;
}

/* Bands of equal size, so that all planes fit into the memory and the widest into one storage
 * range; what a limit of 0 leaves unknown does not count. */
static strata_result expect_bands(plan_work *w) {
    plan *p = w->out;
    double records = ceil(p->stats.transparent_fragments), bands = 1.0;
    double range = w->in->fact ? (double)w->in->fact(w->in->user, "limit.storage_range") : 0.0;
    if (!p->captures)
        return STRATA_OK;
    if (w->in->memory > 0)
        bands = fmax(bands, ceil(records * p->bytes_per_fragment / (double)w->in->memory));
    if (range > 0.0) /* keys take 8 bytes; no plane is wider */
        bands = fmax(bands, ceil(records * 8.0 / range));
    p->expected_bands = bands < 65536.0 ? (uint32_t)bands : 65536u;
    return STRATA_OK;
}

/* ---- warnings -------------------------------------------------------------------------------- */

/* Facts that show as transparency but that no installed effect answers. */
static strata_result warn_unanswered(plan_work *w) {
    static const char *const facts[] = {"materials.blend", "materials.transmission"};
    strata_result result = STRATA_OK;
    for (size_t f = 0; f < BASE_COUNT(facts) && result == STRATA_OK; f++) {
        const demand_fact *fact = demand_find(&w->out->demand, facts[f]);
        int answered = !fact || fact->value == 0;
        for (uint32_t i = 0; i < w->out->effect_count && !answered; i++) {
            const modules_effect_note *e = w->out->effects[i].effect;
            for (uint32_t k = 0; k < e->need_count; k++)
                answered |= strcmp(e->called_for_by[k]->fact, facts[f]) == 0;
        }
        if (!answered)
            result = plan_warn(w, "no installed effect is called for by %s (%s)", facts[f],
                               fact->evidence);
    }
    return result;
}

static strata_result warn_settings(plan_work *w) {
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (c->set_knobs && !c->chosen)
            result = plan_warn(w, "--set %s: it does not run in this frame", c->note->id);
    }
    return result;
}

static strata_result warn_unchecked(plan_work *w) {
    for (uint32_t i = 0; i < w->count && !w->in->fact; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (c->chosen && c->note->needs && c->note->needs[0])
            return plan_warn(w,
                             "no device is known: whether it has what %s needs (%s) was not "
                             "checked",
                             c->note->id, c->note->needs[0]);
    }
    return STRATA_OK;
}

/* ---- the whole ------------------------------------------------------------------------------- */

static strata_result make(plan_work *w) {
    strata_result (*const steps[])(plan_work *) = {
        plan_collect,  plan_resolve_settings, plan_trade,   plan_price,   plan_assess,
        plan_choose,   plan_explain_trades,   make_payload, expect_bands, warn_unanswered,
        warn_settings, warn_unchecked,        write_out,
    };
    strata_result result = plan_decide_effects(w->in, w->out, w->err);
    for (size_t i = 0; i < BASE_COUNT(steps) && result == STRATA_OK; i++)
        result = steps[i](w);
    return result;
}

strata_result plan_make(const plan_input *input, plan **out, base_error *err) {
    *out = NULL;
    plan *p = base_calloc(1, sizeof *p);
    if (!p)
        return no_memory(err);
    p->stats = *input->stats;
    p->demand = *input->demand;
    plan_work w = {.in = input, .out = p, .err = err};
    strata_result result = make(&w);
    for (uint32_t i = 0; i < w.count; i++)
        free(w.candidates[i].values);
    free(w.candidates);
    if (result != STRATA_OK) {
        plan_free(p);
        return result;
    }
    *out = p;
    return STRATA_OK;
}

void plan_free(plan *p) {
    if (!p)
        return;
    for (uint32_t i = 0; i < p->technique_count; i++)
        free(p->techniques[i].values);
    for (uint32_t i = 0; i < p->warning_count; i++)
        free(p->warnings[i]);
    free(p->warnings);
    free(p->effects);
    free(p->techniques);
    free(p->left_out);
    free(p);
}

costs_form plan_form(const plan *p) {
    return (costs_form){
        .layout = p->layout, .payload = p->payload.precision, .clipped = p->clipped};
}

const plan_technique *plan_find(const plan *p, const char *id) {
    for (uint32_t i = 0; i < p->technique_count; i++)
        if (strcmp(p->techniques[i].technique->id, id) == 0)
            return &p->techniques[i];
    return NULL;
}

static plan_technique *turned(const plan *p) {
    for (uint32_t i = 0; p->turned && i < p->technique_count; i++)
        if (p->techniques[i].technique == p->turned)
            return &p->techniques[i];
    return NULL;
}

double plan_turned(const plan *p) {
    const plan_technique *t = turned(p);
    return t ? t->values[p->turned_knob] : 0.0;
}

void plan_turn(plan *p, double value) {
    plan_technique *t = turned(p);
    if (!t)
        return;
    const double cost = p->cost + p->turned_each * (value - t->values[p->turned_knob]);
    t->values[p->turned_knob] = value;
    if (p->nearest > 0)
        p->nearest = (uint32_t)value;
    if (p->cost == PLAN_NO_COST || !(cost > 0.0))
        return;
    if (p->ms != PLAN_NO_COST)
        p->ms *= cost / p->cost;
    if (t->cost != PLAN_NO_COST)
        t->cost = fmax(t->cost + cost - p->cost, 0.0);
    p->cost = cost;
}

void plan_expect(plan *p, plan *later) {
    const plan before = *p, after = *later;
    for (uint32_t i = 0; i < before.technique_count; i++) {
        plan_technique *t = &before.techniques[i];
        t->cost = after.techniques[i].cost;
        t->points = after.techniques[i].points;
        memcpy(t->reason, after.techniques[i].reason, sizeof t->reason);
    }
    *p = after;
    p->techniques = before.techniques;
    p->effects = before.effects;
    for (uint32_t i = 0; i < p->effect_count; i++) { /* all are there, by id */
        plan_effect *e = &p->effects[i];
        const plan_effect now = after.effects[i];
        e->called_for = now.called_for;
        e->forced = now.forced;
        memcpy(e->evidence, now.evidence, sizeof e->evidence);
        memcpy(e->reason, now.reason, sizeof e->reason);
    }
    *later = before;
    later->techniques = after.techniques;
    later->effects = after.effects;
}

double plan_floors(const plan *p, double cost) {
    if (cost == PLAN_NO_COST || !(p->stats.transparent_fragments > 0.0))
        return PLAN_NO_COST;
    return cost / p->stats.transparent_fragments;
}
