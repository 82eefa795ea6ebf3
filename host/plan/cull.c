/* SPDX-License-Identifier: MIT
 *
 * Whether objects are culled before the surface draws them. Unnamed, a technique that does so runs
 * only where the estimate says that it saves clearly more than it costs.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <stdio.h>

/* Savings are estimates of estimates: they must exceed the cost by this factor. */
#define MARGIN 1.25

static int draws(const plan_candidate *c) {
    return c->chosen && modules_slot(c->note, "draws.opaque/1", STRATA_SLOT_CONSUMES) != NULL;
}

/* What it costs this one to draw that share of the opaque triangles, and to shade what others
 * overdraw. */
static double drawing_cost(const plan_work *w, const plan_candidate *c, double share) {
    const strata_scene_stats *stats = w->in->stats;
    const double *each = plan_price_at(c, (costs_form){0})->coefficients;
    return share * (each[COSTS_TRIANGLE] * (double)stats->opaque_triangles +
                    each[COSTS_FRAGMENT] * stats->opaque_overdraw);
}

static double savings(const plan_work *w, double share) {
    double saves = 0.0;
    for (uint32_t i = 0; i < w->count; i++)
        saves += draws(&w->candidates[i]) ? drawing_cost(w, &w->candidates[i], share) : 0.0;
    return saves;
}

/* They are expected to cost so much less. */
static void save(plan_work *w, double share) {
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        if (draws(c) && c->cost != PLAN_NO_COST)
            c->cost = fmax(c->cost - drawing_cost(w, c, share), 0.0);
    }
}

/* Of the opaque triangles. Who does not learn from depth/1 finds what is outside of the view, and
 * no more. */
static double share_of(const plan_work *w, const plan_candidate *c) {
    const strata_scene_stats *stats = w->in->stats;
    double gone = stats->outside_triangles;
    if (modules_slot(c->note, "depth/1", STRATA_SLOT_CONSUMES))
        gone += stats->hidden_triangles;
    return gone > 0.0 ? fmin(gone / (double)stats->opaque_triangles, 1.0) : 0.0;
}

static void weigh(plan_work *w, plan_candidate *c) {
    const char *unnamed = w->in->use ? "not named in --use; " : "";
    const double share = share_of(w, c);
    char number[32];
    demand_number(w->in->stats->opaque_objects, number);
    if (c->cost == PLAN_NO_COST || !(share > 0.0)) {
        plan_reason(c, "%s%s opaque objects: too few to be culled, or none is hidden", unnamed,
                    number);
        return;
    }
    const double saves = savings(w, share);
    c->chosen = saves > MARGIN * c->cost && !w->in->use;
    plan_reason(c,
                "%sof the triangles of %s opaque objects about %.0f %% %s hidden or outside: that "
                "saves %.2g blended fragments and costs %.2g",
                unnamed, number, 100.0 * share, c->chosen ? "are" : "would be", saves, c->cost);
}

static int has_drawn(const plan_work *w) {
    for (uint32_t i = 0; i < w->count; i++)
        if (draws(&w->candidates[i]))
            return 1;
    return 0;
}

void plan_choose_cull(plan_work *w) {
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        if (c->role != PLAN_DRAWS || c->blocked ||
            !modules_slot(c->note, "objects/1", STRATA_SLOT_UPDATES) ||
            !modules_slot(c->note, "draws.opaque/1", STRATA_SLOT_UPDATES))
            continue;
        if (!c->named) {
            weigh(w, c);
        } else if (has_drawn(w)) {
            c->chosen = 1;
            plan_reason(c, "named in --use");
        }
        if (c->chosen) {
            save(w, share_of(w, c));
            return; /* one is enough */
        }
    }
}
