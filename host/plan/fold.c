/* SPDX-License-Identifier: MIT
 *
 * The choice of what folds transparent fragments: one stream technique, or a capture and a resolve
 * that agree on a layout of fragments/1. The cheapest that is exact, unless the user named one or
 * accepts an error.
 */
#include "plan/fold.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* What the same bits on every device and day are worth: a way that promises them is taken where it
 * costs at most so many times as much as one that does not. Expectations are no closer. */
#define BITS_WORTH 1.1

/* How many times less than what was measured here something must be expected to cost that never
 * was: by its module's coefficients it may be off by as much. */
#define UNMEASURED 4.0

typedef plan_way way;

static const char *const layouts[] = {"contiguous", "linked"};

/* ---- what is promised with these settings ---------------------------------------------------- */

/* Promises hold at the presets of what trades accuracy: a number that is set keeps so many of the
 * nearest fragments, a mode that is set folds in another order. */
static int moved(const plan_candidate *c, uint32_t type, const char *name) {
    for (uint32_t i = 0; i < c->note->knob_count; i++) {
        const strata_knob *knob = c->note->knobs[i];
        if (knob->trades_accuracy && knob->type == type && c->values[i] != knob->preset &&
            (!name || strcmp(knob->name, name) == 0))
            return 1;
    }
    return 0;
}

uint32_t plan_promised_order(const plan_candidate *c) {
    const uint32_t order = c->note->promises->order;
    return order == STRATA_ORDER_EXACT && moved(c, STRATA_KNOB_INT, NULL) ? STRATA_ORDER_NEAREST
                                                                          : order;
}

int plan_folds(const plan_candidate *c) {
    return c->role == PLAN_CAPTURE || c->role == PLAN_RESOLVE || c->role == PLAN_STREAM;
}

int plan_is_exact(const plan_candidate *c) {
    return c->note->promises && plan_promised_order(c) == STRATA_ORDER_EXACT;
}

int plan_way_is_exact(const way *w) {
    return plan_is_exact(w->fold) && (!w->capture || plan_is_exact(w->capture));
}

/* All are the nearest where it keeps 0 of them. */
static int keeps_all(const plan_candidate *c) {
    return plan_is_exact(c) || (c->note->promises->order == STRATA_ORDER_NEAREST &&
                                costs_count_knob(c->note) >= 0 && plan_kept(c) == 0.0);
}

/* Whether it would have to hold more than it can; what keeps the nearest only never has to. */
static int is_too_deep(const plan_work *w, const plan_candidate *c) {
    const strata_promises *p = c->note->promises;
    return p && p->largest_depth > 0 && w->in->stats->largest_depth > (double)p->largest_depth &&
           plan_promised_order(c) == p->order;
}

static int is_bounded(const plan_candidate *c) {
    const strata_promises *p = c->note->promises;
    return p &&
           (p->determinism == STRATA_DETERMINISM_BOUNDED || moved(c, STRATA_KNOB_CHOICE, "mode"));
}

/* ---- who may take part ----------------------------------------------------------------------- */

/* Why c may not fold this frame, whoever asks; 0 when it may. */
static int check_frame(const plan_work *w, plan_candidate *c) {
    const strata_promises *p = c->note->promises;
    if (w->in->need_fragments && c->role == PLAN_STREAM) {
        plan_reason(c, "deep output needs fragments/1, which it does not produce");
        return 1;
    }
    if (w->in->need_fragments && p && !keeps_all(c)) {
        plan_reason(c, "deep output needs every fragment, which it does not keep");
        return 1;
    }
    if (plan_stored(c) >= COSTS_PAYLOADS) {
        plan_reason(c, "of payloads this host knows float, half and unorm8 only");
        return 1;
    }
    if (c->role == PLAN_CAPTURE || !is_bounded(c))
        return 0;
    for (uint32_t i = 0; i < w->out->effect_count; i++) {
        const plan_effect *e = &w->out->effects[i];
        if (!e->active || !(e->effect->flags & STRATA_EFFECT_SEQUENTIAL))
            continue;
        plan_reason(c, "it folds in parallel, and the effect %s is sequential", e->effect->id);
        return 1;
    }
    return 0;
}

/* Why c may not be chosen unless it is named; 0 when it may. */
static int check_accuracy(const plan_work *w, plan_candidate *c) {
    const strata_promises *p = c->note->promises;
    if (!p) {
        plan_reason(c, "it promises nothing about its accuracy; --use may name it");
        return 1;
    }
    if (plan_promised_order(c) == STRATA_ORDER_APPROXIMATE) {
        plan_reason(c, "it is approximate, without a bound; --use may name it");
        return 1;
    }
    if (plan_promised_order(c) == STRATA_ORDER_NEAREST && !(plan_tolerance(w->in) > 0.0)) {
        plan_reason(c, "it keeps the nearest fragments only, and %s",
                    w->in->tolerance > 0.0 ? "the tolerance was missed" : "no tolerance is given");
        return 1;
    }
    if (w->in->tolerance > 0.0 && !plan_certifies(c)) {
        plan_reason(c, "it cannot say how wrong it may be, and a tolerance is given");
        return 1;
    }
    if (is_too_deep(w, c)) {
        plan_reason(c, "it holds %u fragments a pixel, and about %.0f are expected",
                    p->largest_depth, w->in->stats->largest_depth);
        return 1;
    }
    return 0;
}

static strata_result find_named(plan_search *s) {
    plan_work *w = s->w;
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        if (!plan_folds(c) || !c->named)
            continue;
        if (s->named[c->role])
            return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT,
                             "--use: %s and %s both %s; a frame takes one",
                             s->named[c->role]->note->id, c->note->id,
                             c->role == PLAN_CAPTURE ? "produce fragments/1"
                                                     : "fold transparent fragments");
        s->named[c->role] = c;
        if (check_frame(w, c))
            return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT, "--use: %s cannot run: %s",
                             c->note->id, c->reason);
    }
    plan_candidate *stream = s->named[PLAN_STREAM];
    plan_candidate *other =
        s->named[PLAN_CAPTURE] ? s->named[PLAN_CAPTURE] : s->named[PLAN_RESOLVE];
    if (stream && other)
        return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT,
                         "--use: %s folds transparent fragments by itself, %s has no place "
                         "beside it",
                         stream->note->id, other->note->id);
    return STRATA_OK;
}

static int eligible(const plan_work *w, plan_candidate *c) {
    if (c->blocked || c->reason[0])
        return 0;
    return !check_frame(w, c) && (c->named || !check_accuracy(w, c));
}

/* ---- ways ------------------------------------------------------------------------------------ */

/* Layouts, a bit each; a slot that names none means contiguous. */
static uint32_t both_know(const modules_technique_note *capture,
                          const modules_technique_note *resolve) {
    const strata_slot_use *from = modules_slot(capture, "fragments/1", STRATA_SLOT_PRODUCES);
    const strata_slot_use *to = modules_slot(resolve, "fragments/1", STRATA_SLOT_CONSUMES);
    const uint32_t contiguous = 1u << STRATA_FRAGMENTS_CONTIGUOUS;
    return (from->layouts ? from->layouts : contiguous) & (to->layouts ? to->layouts : contiguous);
}

/* The layout in which `capture` hands fragments to `resolve`; 0 when there is none. What the user
 * set stays; else the preset, else the first that both know. */
static int agree(const plan_candidate *capture, const plan_candidate *resolve, uint32_t *layout) {
    uint32_t both = both_know(capture->note, resolve->note);
    int mode = plan_knob(capture->note, "mode");
    if (mode >= 0) {
        uint32_t current = (uint32_t)capture->values[mode];
        if (capture->set_knobs & ((uint64_t)1 << mode))
            both &= current < 32u ? 1u << current : 0u;
        *layout = current;
        if (current < 32u && (both & (1u << current)))
            return 1;
    }
    for (*layout = 0; *layout < BASE_COUNT(layouts); ++*layout)
        if (both & (1u << *layout))
            return 1;
    return 0;
}

static void note_way(plan_candidate *c, double cost) {
    if (!c)
        return;
    c->ways++;
    if (cost != HUGE_VAL && (c->compared == PLAN_NO_COST || cost < c->compared))
        c->compared = cost;
}

plan_candidate *plan_holder(const way *candidate) {
    return candidate->capture ? candidate->capture : candidate->fold;
}

/* A resolve is paid for what the capture keeps. */
static double part_cost(const plan_work *w, const way *candidate, const plan_candidate *part) {
    const plan_candidate *holder = plan_holder(candidate);
    const double cost = plan_cost(w, part, candidate->form, plan_kept(holder));
    return cost == PLAN_NO_COST ? cost : cost * plan_certifying(w, holder);
}

static double cost_of(const plan_work *w, const way *candidate) {
    const double fold = part_cost(w, candidate, candidate->fold),
                 capture = candidate->capture ? part_cost(w, candidate, candidate->capture) : 0.0;
    return fold == PLAN_NO_COST || capture == PLAN_NO_COST ? HUGE_VAL : fold + capture;
}

double plan_whole(const way *candidate) {
    return candidate->cost + candidate->beside;
}

/* What each part is expected to take, together what the way was weighed with. */
static void pay_parts(const plan_work *w, const way *b) {
    const double all = cost_of(w, b),
                 share = b->keeps > 0.0 && all > 0.0 && all < HUGE_VAL ? b->cost / all : 1.0;
    b->fold->cost = part_cost(w, b, b->fold) * share;
    if (b->capture)
        b->capture->cost = part_cost(w, b, b->capture) * share;
}

/* Whether it leaves out nothing that is named. */
static int is_open(const plan_search *s, const way *candidate) {
    return (!s->named[PLAN_CAPTURE] || s->named[PLAN_CAPTURE] == candidate->capture) &&
           (!s->named[PLAN_RESOLVE] || s->named[PLAN_RESOLVE] == candidate->fold) &&
           (!s->named[PLAN_STREAM] || s->named[PLAN_STREAM] == candidate->fold);
}

static double weighed(const way *candidate) {
    return candidate->cost * (is_bounded(candidate->fold) ? BITS_WORTH : 1.0) + candidate->beside;
}

static int is_known(const plan_search *s, const way *candidate) {
    const costs *c = s->w->in->costs;
    return costs_knows(c, candidate->fold->note, candidate->form) &&
           (!candidate->capture || costs_knows(c, candidate->capture->note, candidate->form));
}

static void consider(plan_search *s, way candidate) {
    candidate.cost = cost_of(s->w, &candidate);
    const double whole = plan_whole(&candidate);
    note_way(candidate.capture, whole);
    note_way(candidate.fold, whole);
    s->ways++;
    s->least = s->best.fold ? fmin(s->least, whole) : whole;
    if (!s->best.fold || weighed(&candidate) < weighed(&s->best))
        s->best = candidate;
    if (is_known(s, &candidate) &&
        (!s->measured.fold || weighed(&candidate) < weighed(&s->measured)))
        s->measured = candidate;
}

/* What it may cost, where it was not measured. */
static double doubted(const way *candidate) {
    return UNMEASURED * candidate->cost + candidate->beside;
}

static void doubt(plan_search *s) {
    if (!s->measured.fold || is_known(s, &s->best) ||
        !(plan_whole(&s->measured) < doubted(&s->best)))
        return;
    s->best = s->measured;
    s->doubted = 1;
}

/* Whether the plan may take the layout where another was agreed upon. */
static int may_lay_out(const way *agreed, uint32_t layout) {
    const int mode = agreed->capture ? plan_knob(agreed->capture->note, "mode") : -1;
    return layout == agreed->form.layout ||
           (mode >= 0 && !(agreed->capture->set_knobs >> mode & 1u) &&
            (both_know(agreed->capture->note, agreed->fold->note) >> layout & 1u));
}

/* Where payloads may be traded for time; under a tolerance more precise ones may cost no more. */
static int may_store(const plan_search *s, const way *agreed, uint32_t payload) {
    const plan_candidate *holder = plan_holder(agreed);
    if (payload == agreed->form.payload)
        return 1;
    if (!plan_free_payload(holder))
        return 0;
    return s->within ? payload <= holder->note->knobs[costs_payload_knob(holder->note)]->maximum
                     : plan_tolerance(s->w->in) > 0.0 && payload < agreed->form.payload;
}

/* The way in the form that is agreed upon; in other forms only where both were measured in both. */
static void take_forms(plan_search *s, way agreed, void (*take)(plan_search *, way)) {
    agreed.form.payload = plan_stored(plan_holder(&agreed));
    if (!is_open(s, &agreed))
        return;
    take(s, agreed);
    for (uint32_t i = 0; i < COSTS_LAYOUTS * COSTS_PAYLOADS && is_known(s, &agreed); i++) {
        way other = agreed;
        other.form = (costs_form){.layout = i / COSTS_PAYLOADS, .payload = i % COSTS_PAYLOADS};
        const int same =
            other.form.layout == agreed.form.layout && other.form.payload == agreed.form.payload;
        if (!same && may_lay_out(&agreed, other.form.layout) &&
            may_store(s, &agreed, other.form.payload) && is_known(s, &other))
            take(s, other);
    }
}

/* All ways whose holder may take part. */
static void take_ways(plan_search *s, int (*may)(const plan_work *, plan_candidate *),
                      void (*take)(plan_search *, way)) {
    plan_work *w = s->w;
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *first = &w->candidates[i];
        if ((first->role != PLAN_CAPTURE && first->role != PLAN_STREAM) || !may(w, first))
            continue;
        if (first->role == PLAN_STREAM)
            take_forms(s, (way){.fold = first, .beside = plan_filter_cost(w, first)}, take);
        for (uint32_t k = 0; first->role == PLAN_CAPTURE && k < w->count; k++) {
            plan_candidate *second = &w->candidates[k];
            way pair = {.capture = first, .fold = second, .beside = plan_filter_cost(w, second)};
            if (second->role == PLAN_RESOLVE && eligible(w, second) &&
                agree(first, second, &pair.form.layout))
                take_forms(s, pair, take);
        }
    }
}

/* ---- within a budget ------------------------------------------------------------------------- */

/* Whether accuracy can be traded for time with it, and with a bound: by its payload, or by how many
 * fragments it keeps, whether its promises hold with as many or not. */
static int may_give(const plan_work *w, plan_candidate *c) {
    const strata_promises *p = c->note->promises;
    if (c->blocked || !p || p->order == STRATA_ORDER_APPROXIMATE || check_frame(w, c) ||
        !(c->named || plan_certifies(c)))
        return 0;
    return plan_free_count(c) ||
           (plan_free_payload(c) && (c->named || (plan_is_exact(c) && !is_too_deep(w, c))));
}

/* The less the expected error the better, then the cheaper; where nothing fits, the cheapest. What
 * keeps all and was late is not expected to fit again; where others were measured, what was not may
 * cost more than is expected, which frames correct where the number kept is turned. */
static void consider_within(plan_search *s, way candidate) {
    const int doubtful =
        s->measured.fold && !is_known(s, &candidate) && !plan_free_count(plan_holder(&candidate));
    const double beside = candidate.beside,
                 room = doubtful ? (s->room - beside) / UNMEASURED + beside : s->room;
    const int fits = plan_fit_way(s->w, &candidate, room);
    const double whole = doubtful ? doubted(&candidate) : plan_whole(&candidate);
    if (!(candidate.keeps > 0.0) && (s->w->in->late >> candidate.form.payload & 1u))
        return;
    if (fits && (!s->fitting.fold || candidate.error < s->fitting.error ||
                 (candidate.error == s->fitting.error && whole < plan_whole(&s->fitting))))
        s->fitting = candidate;
    if (!fits && (!s->cheapest.fold || whole < plan_whole(&s->cheapest)))
        s->cheapest = candidate;
}

/* What promises no bound may be the last resort. */
static void consider_approximate(plan_search *s, plan_candidate *c) {
    const way candidate = {.fold = c,
                           .cost = c->cost == PLAN_NO_COST ? HUGE_VAL : c->cost,
                           .beside = plan_filter_cost(s->w, c)};
    if (c->role == PLAN_STREAM && !c->blocked && c->note->promises &&
        plan_promised_order(c) == STRATA_ORDER_APPROXIMATE && !costs_is_unit(c->note) &&
        is_open(s, &candidate) && !check_frame(s->w, c) &&
        (!s->cheapest.fold || plan_whole(&candidate) < plan_whole(&s->cheapest)))
        s->cheapest = candidate;
}

/* What keeps all is not given up for what is hardly faster, where nothing is expected to fit. */
static void consider_all(plan_search *s, way candidate) {
    if (!plan_free_count(plan_holder(&candidate)))
        consider_within(s, candidate);
}

/* exact: the way that would be taken without a budget, or NULL. */
static void consider_alike(plan_search *s, const way *exact) {
    const double room = s->room;
    if (s->fitting.fold || !(s->cheapest.keeps > 0.0))
        return;
    s->room = plan_alike(plan_whole(&s->cheapest), room);
    if (exact && plan_fits(exact, s->room))
        s->fitting = *exact;
    else
        take_ways(s, may_give, consider_all);
    s->alike = s->fitting.fold != NULL;
    s->cheapest = s->alike ? s->fitting : s->cheapest;
    s->fitting = (way){0};
    s->room = room;
}

/* Takes the place of what was chosen, where that is not exact or not fast enough. */
static strata_result choose_within(plan_search *s) {
    plan_work *w = s->w;
    const int exact = s->best.fold && plan_way_is_exact(&s->best);
    const way exact_way = s->best;
    const int late = (int)(w->in->late >> exact_way.form.payload & 1u);
    s->exact = exact ? exact_way : (way){0};
    s->room = plan_room(w);
    if (exact && !late && plan_fits(&exact_way, s->room))
        return STRATA_OK;
    s->within = 1;
    s->cheapest = exact ? s->best : (way){0};
    take_ways(s, may_give, consider_within);
    /* Where the least may be kept its bound is not given up for what is expected: frames tell. */
    const int bounded = s->cheapest.keeps > 0.0 && !w->in->least_late;
    consider_alike(s, exact && !late ? &exact_way : NULL);
    for (uint32_t i = 0; i < w->count && !s->fitting.fold && !bounded; i++)
        consider_approximate(s, &w->candidates[i]);
    if (s->fitting.fold || s->cheapest.fold)
        s->best = s->fitting.fold ? s->fitting : s->cheapest;
    s->doubted = 0;
    s->least = plan_whole(&s->best);
    if (s->fitting.fold || !s->cheapest.fold ||
        (s->best.fold->named && plan_fits(&s->best, s->room)))
        return STRATA_OK;
    return plan_warn(w,
                     plan_promised_order(s->best.fold) == STRATA_ORDER_APPROXIMATE
                         ? "%s has no bound of its error; nothing else is expected to come as "
                           "close to the budget of %.3g ms"
                         : "%s has a bound, but it is not expected to meet the budget of %.3g ms, "
                           "and neither is anything else that has one",
                     plan_holder(&s->best)->note->id, w->in->budget);
}

/* The nearest k that the holder of a pixel's fragments keeps: its knob `k`; 0 = all. */
static uint32_t nearest_of(const plan_candidate *holder) {
    const strata_promises *p = holder->note->promises;
    int k = plan_knob(holder->note, "k");
    if (!p || p->order != STRATA_ORDER_NEAREST || k < 0 || !(holder->values[k] > 0.0))
        return 0;
    return holder->values[k] < 4294967295.0 ? (uint32_t)holder->values[k] : 0xffffffffu;
}

/* Notes the layout, the nearest k and the payload's precision, and sets the mode knob to what was
 * agreed. */
static strata_result settle(plan_search *s) {
    const way *b = &s->best;
    plan *p = s->w->out;
    p->transparent = 1;
    p->captures = b->capture != NULL;
    p->layout = b->form.layout;
    const plan_candidate *holder = plan_holder(b);
    p->nearest = nearest_of(holder);
    p->payload.precision = plan_stored(holder);
    int mode = b->capture ? plan_knob(b->capture->note, "mode") : -1;
    if (mode < 0 || b->capture->values[mode] == (double)b->form.layout)
        return STRATA_OK;
    uint32_t agreed;
    const int cheaper = agree(b->capture, b->fold, &agreed) && agreed != b->form.layout;
    b->capture->values[mode] = (double)b->form.layout;
    size_t length = strlen(b->capture->reason);
    snprintf(b->capture->reason + length, sizeof b->capture->reason - length,
             cheaper ? "; as measured, mode %s costs less" : "; mode %s, which %s reads",
             layouts[b->form.layout], b->fold->note->id);
    return STRATA_OK;
}

strata_result plan_choose_fold(plan_work *w) {
    plan_search s = {.w = w};
    if (w->in->stats->transparent_draws == 0 || w->out->active_effects == 0)
        return plan_leave_fold(w);
    strata_result result = find_named(&s);
    if (result != STRATA_OK)
        return result;
    take_ways(&s, eligible, consider);
    doubt(&s);
    if (plan_has_budget(w->in))
        result = choose_within(&s);
    if (result != STRATA_OK)
        return result;
    if (!s.best.fold)
        return plan_fail_fold(&s);
    s.best.fold->reason[0] = '\0';
    if (s.best.capture)
        s.best.capture->reason[0] = '\0';
    plan_settle_budget(w, &s.best, &s.exact);
    pay_parts(w, &s.best);
    plan_describe_fold(&s);
    if (plan_has_budget(w->in))
        plan_explain_budget(w, &s.best);
    s.best.fold->chosen = 1;
    if (s.best.capture)
        s.best.capture->chosen = 1;
    plan_describe_others(&s);
    result = settle(&s);
    for (plan_candidate *c = s.best.fold; c && result == STRATA_OK;
         c = c == s.best.capture ? NULL : s.best.capture) {
        if (is_too_deep(w, c))
            result = plan_warn(w, "%s holds %u fragments a pixel, and about %.0f are expected",
                               c->note->id, c->note->promises->largest_depth,
                               w->in->stats->largest_depth);
    }
    return result;
}
