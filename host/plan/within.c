/* SPDX-License-Identifier: MIT
 *
 * Planning within a budget of time: exact where that is expected to fit, else the least error that
 * does: records of less precision, or the nearest fragments alone. Expectations rest on what was
 * measured, in the sweep or in the frames before; where nothing was, exactness is tried first, and
 * the frames tell.
 */
#include "plan/budget.h"
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

int plan_fits(const plan_way *way, double room) {
    return plan_whole(way) <= BUDGET_NEAR * room;
}

#define ALIKE 1.1 /* costs that expectations do not tell apart */

double plan_alike(double fastest, double room) {
    return fmin(ALIKE * fastest, BUDGET_LATE * room) / BUDGET_NEAR;
}

static int is_free(const plan_candidate *c, int knob) {
    return knob >= 0 && !(c->set_knobs >> knob & 1u);
}

int plan_free_payload(const plan_candidate *holder) {
    const int knob = costs_payload_knob(holder->note);
    return is_free(holder, knob) && holder->note->knobs[knob]->trades_accuracy;
}

int plan_free_count(const plan_candidate *holder) {
    const strata_promises *p = holder->note->promises;
    return p && p->order != STRATA_ORDER_APPROXIMATE &&
           is_free(holder, costs_count_knob(holder->note));
}

static const strata_knob *count_knob(const plan_candidate *holder) {
    return holder->note->knobs[costs_count_knob(holder->note)];
}

static double least(const plan_candidate *holder) {
    return fmax(1.0, count_knob(holder)->minimum);
}

/* No more than there are in the deepest pixel. */
static double most(const plan_work *w, const plan_candidate *holder) {
    return fmax(least(holder),
                fmin(count_knob(holder)->maximum, ceil(w->in->stats->largest_depth)));
}

static double cost_at(const plan_work *w, const plan_way *way, double keeps) {
    const double fold = plan_cost(w, way->fold, way->form, keeps),
                 capture = way->capture ? plan_cost(w, way->capture, way->form, keeps) : 0.0;
    return fold == PLAN_NO_COST || capture == PLAN_NO_COST ? HUGE_VAL : fold + capture;
}

/* Where fragments hide nothing, they are taken to hide this much: each still adds to the sum. */
#define CLEAREST 1e-3

/* What is dropped behind the nearest so many in the deepest pixel, as bright as 1, seen through as
 * many fragments of the mean transmittance. */
static double dropped_error(const plan_work *w, double keeps) {
    const strata_scene_stats *stats = w->in->stats;
    const double each = fmax(stats->mean_optical_depth, CLEAREST);
    return keeps < stats->largest_depth ? exp(-each * keeps) - exp(-each * stats->largest_depth)
                                        : 0.0;
}

/* Half a quantum of each fragment's colour, and of the alpha that hides what is behind it. A half's
 * is a share of the value, and the values' sum is about 1; unorm8's is the same for all that show,
 * the sum of the transmittances in front of them. */
static double payload_error(const plan_work *w, uint32_t payload) {
    const strata_scene_stats *stats = w->in->stats;
    const double each = fmax(stats->mean_optical_depth, CLEAREST),
                 showing = expm1(-each * stats->largest_depth) / expm1(-each);
    return payload == STRATA_PAYLOAD_UNORM8 ? showing / 255.0
           : payload == STRATA_PAYLOAD_HALF ? 0x1p-10
                                            : 0.0;
}

static void keep(const plan_work *w, plan_way *way, double keeps, double cost) {
    way->keeps = keeps;
    way->cost = cost;
    way->error =
        payload_error(w, way->form.payload) + (keeps > 0.0 ? dropped_error(w, keeps) : 0.0);
}

/* ---- what more of them cost ------------------------------------------------------------------ */

enum { MOST_STEPS = 128 };
#define STEP 1.2 /* factor between two numbers that are looked at, or they are neighbours */

typedef struct ladder {
    double keeps[MOST_STEPS], cost[MOST_STEPS]; /* ascending, neither falls */
    int count;
} ladder;

/* More fragments never cost less, but measurements are a little off, and what is expected bends to
 * them: each cost lies halfway between the most that fewer are expected to cost and the least that
 * more are. */
static void straighten(ladder *l) {
    double least[MOST_STEPS], most = 0.0;
    for (int i = l->count - 1; i >= 0; i--)
        least[i] = i + 1 < l->count ? fmin(l->cost[i], least[i + 1]) : l->cost[i];
    for (int i = 0; i < l->count; i++) {
        most = fmax(most, l->cost[i]);
        l->cost[i] = 0.5 * (most + least[i]);
    }
}

static ladder climb(const plan_work *w, const plan_way *way) {
    const plan_candidate *holder = plan_holder(way);
    const double top = most(w, holder);
    ladder l = {.count = 0};
    for (double k = least(holder); l.count < MOST_STEPS; k = fmax(k + 1.0, floor(k * STEP))) {
        l.keeps[l.count] = l.count + 1 < MOST_STEPS ? fmin(k, top) : top;
        l.cost[l.count] = cost_at(w, way, l.keeps[l.count]);
        if (l.keeps[l.count++] >= top)
            break;
    }
    straighten(&l);
    return l;
}

/* Between two steps costs rise evenly. */
int plan_fit_way(const plan_work *w, plan_way *way, double room) {
    if (!plan_free_count(plan_holder(way))) {
        keep(w, way, 0.0, cost_at(w, way, plan_kept(plan_holder(way))));
        return plan_fits(way, room);
    }
    room -= way->beside;
    const ladder l = climb(w, way);
    int at = l.count - 1;
    while (at > 0 && l.cost[at] > room)
        at--;
    keep(w, way, l.keeps[at], l.cost[at]);
    if (l.cost[at] > room || at + 1 == l.count || !isfinite(l.cost[at + 1]))
        return l.cost[at] <= room;
    const double rise = l.cost[at + 1] - l.cost[at], far = l.keeps[at + 1] - l.keeps[at],
                 more = fmin(floor(far * (room - l.cost[at]) / rise), far - 1.0);
    keep(w, way, l.keeps[at] + more, fmin(l.cost[at] + rise * more / far, room));
    return 1;
}

/* What a kept fragment costs, on the way from the least to the most; 0: unknown. */
static double each_of(const plan_work *w, const plan_way *chosen) {
    const ladder l = climb(w, chosen);
    const double each = (l.cost[l.count - 1] - l.cost[0]) / (l.keeps[l.count - 1] - l.keeps[0]);
    return isfinite(each) && each > 0.0 ? each : 0.0;
}

/* From which step on the ladder is no cheaper than the exact way; 0: from none. */
static double exact_from(const plan_work *w, const plan_way *chosen, const plan_way *exact) {
    const ladder l = climb(w, chosen);
    for (int i = 0; exact->fold && i < l.count; i++)
        if (l.cost[i] + chosen->beside >= plan_whole(exact))
            return l.keeps[i];
    return 0.0;
}

void plan_settle_budget(plan_work *w, const plan_way *chosen, const plan_way *exact) {
    plan_candidate *holder = plan_holder(chosen);
    const int payload = costs_payload_knob(holder->note), count = costs_count_knob(holder->note);
    if (payload >= 0)
        holder->values[payload] = chosen->form.payload;
    if (!(chosen->keeps > 0.0))
        return;
    holder->values[count] = chosen->keeps;
    w->out->turned = holder->note;
    w->out->turned_knob = (uint32_t)count;
    w->out->turned_least = least(holder);
    w->out->turned_most = most(w, holder);
    w->out->turned_each = each_of(w, chosen);
    w->out->turned_exact = exact_from(w, chosen, exact);
}

/* Adds to the reason of what holds. */
void plan_explain_budget(plan_work *w, const plan_way *chosen) {
    plan_candidate *c = plan_holder(chosen);
    const double ns = plan_ns(w->in), room = plan_room(w), budget = w->in->budget;
    const uint32_t payload = chosen->form.payload;
    const size_t length = strlen(c->reason), size = sizeof c->reason;
    char *text = c->reason + length, stored[32] = "";
    if (payload != STRATA_PAYLOAD_FLOAT)
        snprintf(stored, sizeof stored, ", payload %s", costs_payload_name(payload));
    if (chosen->keeps > 0.0)
        snprintf(
            text, size - length,
            "; for the budget of %.3g ms it begins with the nearest %.0f of up to %.0f fragments "
            "a pixel%s%s",
            budget, chosen->keeps, ceil(w->in->stats->largest_depth), stored,
            plan_whole(chosen) <= room ? "" : ", though that is expected to miss it");
    else if (!(ns > 0.0))
        snprintf(text, size - length, "; whether the budget of %.3g ms is met is not known yet",
                 budget);
    else
        snprintf(text, size - length, "%s; the budget of %.3g ms is expected to be %s", stored,
                 budget,
                 plan_fits(chosen, room) && !(w->in->late >> payload & 1u) ? "met" : "missed");
}
