/* SPDX-License-Identifier: MIT
 *
 * Why transparent fragments are folded as they are, and by nothing else.
 */
#include "plan/fold.h"

#include <math.h>
#include <stdio.h>

static void cost_text(const plan_work *w, double cost, char text[48]) {
    double floor = w->in->stats->transparent_fragments;
    if (!(cost >= 0.0) || cost == HUGE_VAL)
        snprintf(text, 48, "an unknown cost");
    else if (floor > 0.0)
        snprintf(text, 48, "%.3g", cost / floor);
    else
        snprintf(text, 48, "%.4g blended fragments", cost);
}

strata_result plan_fail_fold(const plan_search *s) {
    base_text text = {0};
    const plan_work *w = s->w;
    for (uint32_t i = 0; i < w->count; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (plan_folds(c))
            base_text_add(&text, "%s%s: %s", text.length ? "; " : "", c->note->id,
                          c->reason[0] ? c->reason : "nothing fits to it");
    }
    strata_result result = base_fail(
        w->err, STRATA_ERROR_UNSUPPORTED,
        "the scene has transparent surfaces and no installed technique may fold them (%s)",
        text.data ? text.data : "none is installed");
    base_text_free(&text);
    return result;
}

strata_result plan_leave_fold(plan_work *w) {
    strata_result result = STRATA_OK;
    const char *why =
        w->out->active_effects ? "nothing transparent is drawn" : "no effect is active";
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++) {
        plan_candidate *c = &w->candidates[i];
        if (!plan_folds(c) || c->blocked)
            continue;
        plan_reason(c, "%s", why);
        if (c->named)
            result = plan_warn(w, "--use %s: it does not run, for %s", c->note->id, why);
    }
    return result;
}

/* Of which ways it is the cheapest, where it is not of all. */
static const char *among(const plan_search *s) {
    return s->doubted                        ? " that was measured here"
           : plan_whole(&s->best) > s->least ? " that promises the same bits everywhere"
                                             : "";
}

void plan_describe_fold(const plan_search *s) {
    const plan_way *b = &s->best;
    plan_candidate *first = plan_holder(b);
    char cost[48], count[32];
    const int exact = plan_way_is_exact(b);
    cost_text(s->w, plan_whole(b), cost);
    demand_number((uint64_t)s->w->in->stats->transparent_fragments, count);
    for (plan_candidate *c = first; c; c = c == b->fold ? NULL : b->fold) {
        const char *partner =
            c == b->fold ? (b->capture ? b->capture->note->id : NULL) : b->fold->note->id;
        if (c->named)
            plan_reason(c, "named in --use");
        else if (s->ways == 1)
            plan_reason(c, "the only %sway to fold transparent fragments%s%s",
                        exact ? "exact " : "", partner ? ", with " : "", partner ? partner : "");
        else if (b->keeps > 0.0 || s->fitting.fold || s->alike)
            plan_reason(c, "folds about %s fragments%s%s: %s%s", count, partner ? ", with " : "",
                        partner ? partner : "", cost,
                        s->w->in->stats->transparent_fragments > 0.0 ? " x floor" : "");
        else
            plan_reason(c, "the cheapest %sway%s to fold about %s fragments%s%s: %s%s",
                        exact ? "exact " : "", among(s), count, partner ? ", with " : "",
                        partner ? partner : "", cost,
                        s->w->in->stats->transparent_fragments > 0.0 ? " x floor" : "");
    }
}

/* The named technique that takes the place of c, or NULL. */
static const plan_candidate *named_instead(const plan_search *s, const plan_candidate *c) {
    if (s->named[c->role])
        return s->named[c->role];
    if (c->role != PLAN_STREAM)
        return s->named[PLAN_STREAM];
    return s->named[PLAN_CAPTURE] ? s->named[PLAN_CAPTURE] : s->named[PLAN_RESOLVE];
}

void plan_describe_others(const plan_search *s) {
    const plan_way *b = &s->best;
    char theirs[48], ours[48];
    cost_text(s->w, plan_whole(b), ours);
    for (uint32_t i = 0; i < s->w->count; i++) {
        plan_candidate *c = &s->w->candidates[i];
        if (!plan_folds(c) || c->reason[0])
            continue;
        const plan_candidate *named = named_instead(s, c);
        cost_text(s->w, c->compared == PLAN_NO_COST ? HUGE_VAL : c->compared, theirs);
        if (named)
            plan_reason(c, "--use names %s", named->note->id);
        else if (c->ways == 0)
            plan_reason(c, "nothing that can run here shares its layout of fragments/1");
        else
            plan_reason(c, "costs %s against %s of %s%s%s%s", theirs, ours,
                        b->capture ? b->capture->note->id : "", b->capture ? " + " : "",
                        b->fold->note->id,
                        c->compared == PLAN_NO_COST || !(c->compared < plan_whole(b)) ? ""
                        : s->doubted ? ", which was measured here"
                                     : ", which promises the same bits everywhere");
    }
}
