/* SPDX-License-Identifier: MIT
 *
 * Whether a clip technique limits how deep the fold looks. One that hides what lies behind the
 * nearest k fragments may stand only before a technique that keeps no more than those; unnamed it
 * runs only where the estimate says that it saves clearly more than it costs.
 */
#include "plan/plan_internal.h"

#include <math.h>

/* Share of what holding a fragment costs that an early depth test saves (measured with abuffer: all
 * fragments 407 ms, none 119 ms). */
#define HIDDEN_SAVES 0.7

/* In blended, unlit fragments: shading one that is lit, and what each light adds; and drawing one
 * more time. */
#define SHADING_LIT   1.0
#define SHADING_LIGHT 0.5
#define DRAWING       1.0

/* Savings are estimates of estimates: they must exceed the cost by this factor. */
#define MARGIN 1.25

/* What holds a pixel's fragments, NULL when nothing does. */
static const plan_candidate *find_holder(const plan_work *w) {
    const plan_candidate *holder = NULL;
    for (uint32_t i = 0; i < w->count; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (c->chosen && (c->role == PLAN_CAPTURE || c->role == PLAN_STREAM))
            holder = c;
    }
    return holder;
}

/* Of n fragments in S buckets about S (1 - exp(-n / S)) buckets hold one, and the limit lies behind
 * the k-th of them. S is what the knob `buckets` says, else enough: 4 k and 2 n. */
static double hidden_share(const plan_candidate *c, double nearest, double depth) {
    int knob = plan_knob(c->note, "buckets");
    double buckets = knob >= 0 ? c->values[knob] : 0.0;
    if (!(depth > 0.0))
        return 0.0;
    if (!(buckets > 0.0))
        buckets = fmax(4.0 * nearest, 2.0 * depth);
    double load = depth / buckets;
    return fmax(0.0, 1.0 - nearest * load / (1.0 - exp(-load)) / depth);
}

static double shading_cost(const plan_work *w) {
    const demand_fact *unlit = demand_find(&w->out->demand, "materials.unlit");
    if (unlit && unlit->value >= w->in->stats->materials)
        return 0.0;
    return SHADING_LIT + SHADING_LIGHT * w->in->stats->lights;
}

/* Decides, where the choice is the plan's, and says why. Under a tolerance the frame is certified:
 * what is hidden is drawn and shaded all the same, for its bound. */
static void weigh(const plan_work *w, plan_candidate *c, const plan_candidate *holder) {
    const strata_scene_stats *stats = w->in->stats;
    const costs_form form = {.layout = w->out->layout, .payload = w->out->payload.precision};
    const plan_price_in *holds = plan_price_at(holder, form);
    const double *m = holds->coefficients;
    const char *unnamed = w->in->use ? "not named in --use; " : "";
    double fragments = stats->transparent_fragments;
    if (c->cost == PLAN_NO_COST || holds->points < 0 || !(fragments > 0.0)) {
        plan_reason(c, "%swhether it would pay is unknown", unnamed);
        return;
    }
    double hidden = hidden_share(c, w->out->nearest, stats->mean_depth);
    double holding =
        m[COSTS_FRAGMENT] + m[COSTS_FRAGMENT_LOG2_DEPTH] * log2(1.0 + stats->mean_depth);
    double other = w->in->tolerance > 0.0 ? -DRAWING : shading_cost(w);
    double saves = fmax(0.0, hidden * (HIDDEN_SAVES * holding + other));
    double price = c->cost / fragments;
    int pays = saves > MARGIN * price;
    c->chosen = pays && !w->in->use;
    plan_reason(c, "%s%s about %.0f %% of the fragments from %s%s %.2g x floor and costs %.2g",
                unnamed, c->chosen ? "hides" : "it would hide", 100.0 * hidden, holder->note->id,
                c->chosen ? ": that saves" : ", which saves", saves, price);
}

/* Why nothing may be hidden from a holder that does not keep the nearest k. */
static const char *wants_all(const plan_candidate *holder) {
    const int k = plan_knob(holder->note, "k");
    if (!holder->note->promises)
        return "promises no order";
    switch (plan_promised_order(holder)) {
    case STRATA_ORDER_APPROXIMATE:
        return "blends all, in approximate order";
    case STRATA_ORDER_NEAREST:
        return k >= 0 && holder->values[k] == 0.0 ? "keeps all (its k is 0)"
                                                  : "does not say by a knob k how many it keeps";
    default:
        return "keeps all";
    }
}

strata_result plan_choose_clip(plan_work *w) {
    const plan_candidate *holder = find_holder(w);
    int taken = 0; /* limit/1 has one producer */
    for (uint32_t i = 0; i < w->count && holder; i++) {
        plan_candidate *c = &w->candidates[i];
        const strata_promises *p = c->note->promises;
        if (c->role != PLAN_CLIP || c->blocked || !p || p->order != STRATA_ORDER_NEAREST)
            continue;
        if (w->out->nearest == 0) {
            plan_reason(c, "it hides what lies behind the nearest k fragments, and %s %s",
                        holder->note->id, wants_all(holder));
            if (c->named)
                return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT, "--use: %s cannot run: %s",
                                 c->note->id, c->reason);
        } else if (!c->named && !taken &&
                   plan_slot(holder->note, "limit/1", STRATA_SLOT_CONSUMES)) {
            weigh(w, c, holder);
            taken = c->chosen;
        }
    }
    return STRATA_OK;
}
