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

/* In blended, unlit fragments: shading one that is lit, and what each light adds (measured with
 * wboit, one light: 0.5 to 1.2 more than the unlit ones take); and drawing one more time. */
#define SHADING_LIT   0.5
#define SHADING_LIGHT 0.25
#define DRAWING       1.0

/* Savings are estimates of estimates: they must exceed the cost by this factor. */
#define MARGIN 1.25

/* Points that a difference may rest on: few, of one sequence of frames, may be of a slow moment. */
#define SEVERAL 4

/* What holds a pixel's fragments, NULL when nothing does. */
static plan_candidate *find_holder(const plan_work *w) {
    plan_candidate *holder = NULL;
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
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

static costs_form clipped_form(const plan_work *w) {
    costs_form form = plan_form(w->out);
    form.clipped = 1;
    return form;
}

static int is_known(const plan_work *w, const plan_candidate *holder, costs_form form) {
    return costs_knows(w->in->costs, holder->note, form) &&
           plan_price_at(holder, form)->points >= SEVERAL;
}

/* With nothing hidden and with what is: then their difference is what hiding saves. Under a
 * tolerance what is hidden is drawn and shaded all the same, for its bound. */
static int is_measured(const plan_work *w, const plan_candidate *holder) {
    return !(w->in->tolerance > 0.0) && is_known(w, holder, plan_form(w->out)) &&
           is_known(w, holder, clipped_form(w));
}

static double measured_savings(const plan_work *w, const plan_candidate *holder) {
    const double kept = plan_kept(holder), all = plan_cost(w, holder, plan_form(w->out), kept);
    return (all - plan_cost(w, holder, clipped_form(w), kept)) /
           w->in->stats->transparent_fragments;
}

static double expected_savings(const plan_work *w, const plan_candidate *holder, double hidden) {
    const strata_scene_stats *stats = w->in->stats;
    const double *m = plan_price_at(holder, plan_form(w->out))->coefficients;
    const double holding =
        m[COSTS_FRAGMENT] + m[COSTS_FRAGMENT_LOG2_DEPTH] * log2(1.0 + stats->mean_depth);
    const double other = w->in->tolerance > 0.0 ? -DRAWING : shading_cost(w);
    return hidden * (HIDDEN_SAVES * holding + other);
}

/* Decides, where the choice is the plan's, and says why. */
static void weigh(const plan_work *w, plan_candidate *c, const plan_candidate *holder) {
    const strata_scene_stats *stats = w->in->stats;
    const costs_form form = plan_form(w->out);
    const char *unnamed = w->in->use ? "not named in --use; " : "";
    double fragments = stats->transparent_fragments;
    if (c->cost == PLAN_NO_COST || plan_price_at(holder, form)->points < 0 || !(fragments > 0.0)) {
        plan_reason(c, "%swhether it would pay is unknown", unnamed);
        return;
    }
    double hidden = hidden_share(c, w->out->nearest, stats->mean_depth);
    const int measured = is_measured(w, holder);
    double saves =
        fmax(0.0, measured ? measured_savings(w, holder) : expected_savings(w, holder, hidden));
    double price = c->cost / fragments;
    int pays = saves > MARGIN * price;
    c->chosen = pays && !w->in->use;
    plan_reason(c, "%s%s about %.0f %% of the fragments from %s%s%s %.2g x floor and costs %.2g",
                unnamed, c->chosen ? "hides" : "it would hide", 100.0 * hidden, holder->note->id,
                c->chosen ? ": that saves" : ", which saves", measured ? ", as measured," : "",
                saves, price);
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
    plan_candidate *holder = find_holder(w);
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
                   modules_slot(holder->note, "limit/1", STRATA_SLOT_CONSUMES)) {
            weigh(w, c, holder);
            taken = c->chosen;
        }
    }
    return STRATA_OK;
}

/* What one more fragment that is kept costs, of what the knob turned can be set to. */
static double slope(const plan_work *w, const plan_candidate *holder, costs_form form) {
    const plan *p = w->out;
    return (plan_cost(w, holder, form, p->turned_most) -
            plan_cost(w, holder, form, p->turned_least)) /
           (p->turned_most - p->turned_least);
}

void plan_settle_clip(plan_work *w) {
    plan *p = w->out;
    plan_candidate *holder = find_holder(w);
    const costs_form all = plan_form(p);
    for (uint32_t i = 0; i < w->count && holder; i++)
        p->clipped |= w->candidates[i].chosen && w->candidates[i].role == PLAN_CLIP &&
                      modules_slot(holder->note, "limit/1", STRATA_SLOT_CONSUMES);
    const costs_form some = plan_form(p);
    if (!p->clipped || w->in->tolerance > 0.0 || !costs_knows(w->in->costs, holder->note, some))
        return;
    const double kept = plan_kept(holder), whole = plan_cost(w, holder, all, kept);
    holder->cost = plan_cost(w, holder, some, kept) * (whole > 0.0 ? holder->cost / whole : 1.0);
    if (p->turned && p->turned_most > p->turned_least)
        p->turned_each = fmax(p->turned_each + slope(w, holder, some) - slope(w, holder, all), 0.0);
    p->turned_exact = 0.0; /* of what is not clipped */
}
