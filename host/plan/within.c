/* SPDX-License-Identifier: MIT
 *
 * Planning within a budget of time: exact where that is expected to fit, else as many of the
 * nearest fragments as fit. Expectations rest on what was measured, in the sweep or in the frames
 * before; where nothing was, exactness is tried first, and the frames tell.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

double plan_ns(const plan_input *in) {
    return in->ns > 0.0 ? in->ns : in->costs ? in->costs->ns : 0.0;
}

/* A tolerance comes first, and a deep image has every fragment. */
int plan_has_budget(const plan_input *in) {
    return in->budget > 0.0 && !(in->tolerance > 0.0) && !in->need_fragments;
}

/* Beside what was chosen before the fold. */
double plan_room(const plan_work *w) {
    const double ns = plan_ns(w->in);
    if (!(ns > 0.0))
        return HUGE_VAL;
    double room = (w->in->budget - w->in->beside) * 1e6 / ns;
    for (uint32_t i = 0; i < w->count; i++)
        if (w->candidates[i].chosen && w->candidates[i].cost != PLAN_NO_COST)
            room -= w->candidates[i].cost;
    return room;
}

int plan_free_knob(const plan_candidate *holder) {
    const int knob = costs_count_knob(holder->note);
    const strata_promises *p = holder->note->promises;
    return knob >= 0 && p && p->order != STRATA_ORDER_APPROXIMATE &&
                   !(holder->set_knobs >> knob & 1u)
               ? knob
               : -1;
}

static double least(const plan_candidate *holder) {
    return fmax(1.0, holder->note->knobs[plan_free_knob(holder)]->minimum);
}

/* No more than there are in the deepest pixel. */
static double most(const plan_work *w, const plan_candidate *holder) {
    const double limit = holder->note->knobs[plan_free_knob(holder)]->maximum;
    return fmax(least(holder), fmin(limit, ceil(w->in->stats->largest_depth)));
}

static double cost_at(const plan_work *w, const plan_way *way, double keeps) {
    const double fold = plan_cost(w, way->fold, way->layout, keeps),
                 capture = way->capture ? plan_cost(w, way->capture, way->layout, keeps) : 0.0;
    return fold == PLAN_NO_COST || capture == PLAN_NO_COST ? HUGE_VAL : fold + capture;
}

int plan_fit_way(const plan_work *w, plan_way *way, double room) {
    const plan_candidate *holder = way->capture ? way->capture : way->fold;
    for (way->keeps = most(w, holder);; way->keeps -= 1.0) {
        way->cost = cost_at(w, way, way->keeps);
        if (way->cost <= room)
            return 1;
        if (way->keeps - 1.0 < least(holder))
            return 0;
    }
}

void plan_settle_budget(plan_work *w, const plan_way *chosen) {
    plan_candidate *holder = chosen->capture ? chosen->capture : chosen->fold;
    if (!(chosen->keeps > 0.0))
        return;
    const int knob = plan_free_knob(holder);
    holder->values[knob] = chosen->keeps;
    w->out->turned = holder->note;
    w->out->turned_knob = (uint32_t)knob;
    w->out->turned_least = least(holder);
    w->out->turned_most = most(w, holder);
}

/* Adds to the reason of what holds. */
void plan_explain_budget(plan_work *w, const plan_way *chosen) {
    plan_candidate *c = chosen->capture ? chosen->capture : chosen->fold;
    const double ns = plan_ns(w->in), room = plan_room(w), budget = w->in->budget;
    const size_t length = strlen(c->reason), size = sizeof c->reason;
    char *text = c->reason + length;
    if (chosen->keeps > 0.0)
        snprintf(
            text, size - length,
            "; for the budget of %.3g ms it begins with the nearest %.0f of up to %.0f fragments "
            "a pixel%s",
            budget, chosen->keeps, ceil(w->in->stats->largest_depth),
            chosen->cost <= room ? "" : ", though that is expected to miss it");
    else if (!(ns > 0.0))
        snprintf(text, size - length, "; whether the budget of %.3g ms is met is not known yet",
                 budget);
    else
        snprintf(text, size - length, "; the budget of %.3g ms is expected to be %s", budget,
                 chosen->cost <= room && !w->in->late ? "met" : "missed");
}
