/* SPDX-License-Identifier: MIT
 *
 * Planning by certificates: under a tolerance knobs that trade accuracy begin where they may just
 * suffice. What they begin with is a guess, of which nothing depends but time: the frame's
 * certificate decides, and each time that it does not hold the plan is made again one `raise`
 * higher, at last with exact techniques alone. What the user set stays.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define FIRST        4.0  /* fragments that a pixel which may grow begins with */
#define MOST_FOR_ALL 64.0 /* fragments that every pixel may have at once */
#define CLEARER      0.6  /* of the mean optical depth: where fragments hide less */
#define DEEPER       1.25 /* of the estimated depth */

/* Times what a frame takes without a certificate, where fragments may be dropped that go into one:
 * measured on a software device, with 32 (1.4) and 64 (1.25) kept of a pixel. */
#define ACCOUNTED 1.35

double plan_tolerance(const plan_input *in) {
    return in->raise < PLAN_RAISE_EXACT ? in->tolerance : 0.0;
}

/* Of float, half, unorm8: a pixel's error is about as large as that of one fragment. */
static uint32_t first_payload(double tolerance) {
    return tolerance >= 0.02    ? STRATA_PAYLOAD_UNORM8
           : tolerance >= 0.002 ? STRATA_PAYLOAD_HALF
                                : STRATA_PAYLOAD_FLOAT;
}

static double payload_for(const plan_input *in, const strata_knob *knob) {
    const uint32_t first = first_payload(plan_tolerance(in));
    return fmin(first > in->raise ? first - in->raise : 0, knob->maximum);
}

/* How many fragments are likely to leave no more than half of the tolerance of what is behind them,
 * in pixels whose fragments hide less than the mean; no more than a little above the depth. */
static double enough(const plan_input *in) {
    const double each = CLEARER * in->stats->mean_optical_depth,
                 deepest = DEEPER * in->stats->largest_depth,
                 hidden = log(2.0 / fmin(in->tolerance, 1.0)) / each;
    return fmax(1.0, ceil(fmin(hidden, deepest)));
}

/* A technique with the knobs `k` and `begin` finds the k of each pixel: from few to as many as the
 * certificate takes. That records a moving view again and again: it is left to that once the same k
 * for all was not enough, or would take much memory. */
static void trade_growing(const plan_input *in, plan_candidate *c, int nearest, int begin) {
    const strata_knob *k = c->note->knobs[nearest];
    const uint32_t set = c->set_knobs >> nearest & 1u, begins = c->set_knobs >> begin & 1u;
    const int grow = set || begins || in->raise > 0 || enough(in) > fmin(MOST_FOR_ALL, k->maximum);
    if (!set)
        c->values[nearest] = grow ? k->maximum : enough(in);
    if (!begins)
        c->values[begin] = grow ? fmin(FIRST, c->values[nearest]) : 0;
}

/* What k means to others is theirs: it begins with the preset and is doubled with each raise. */
static void trade_count(const plan_input *in, plan_candidate *c) {
    const int nearest = plan_knob(c->note, "k"), begin = plan_knob(c->note, "begin");
    const strata_knob *k = nearest >= 0 ? c->note->knobs[nearest] : NULL;
    if (!k || !k->trades_accuracy || k->type != STRATA_KNOB_INT)
        return;
    const int grows = begin >= 0 && c->note->knobs[begin]->type == STRATA_KNOB_INT,
              all = in->raise >= PLAN_RAISE_EXACT; /* exact techniques are asked for */
    if (grows && !all)
        trade_growing(in, c, nearest, begin);
    else if (!(c->set_knobs >> nearest & 1u))
        c->values[nearest] = !all ? fmin(k->preset * (double)(1u << in->raise), k->maximum)
                             : k->minimum > 0 ? k->maximum
                                              : 0;
}

strata_result plan_trade(plan_work *w) {
    for (uint32_t i = 0; i < w->count && w->in->tolerance > 0.0; i++) {
        plan_candidate *c = &w->candidates[i];
        const int payload = costs_payload_knob(c->note);
        if (plan_free_payload(c))
            c->values[payload] = payload_for(w->in, c->note->knobs[payload]);
        trade_count(w->in, c);
    }
    return STRATA_OK;
}

int plan_certifies(const plan_candidate *c) {
    return c->role == PLAN_CAPTURE || modules_slot(c->note, "bound/1", STRATA_SLOT_UPDATES) != NULL;
}

/* From what pixels begin with they at most double, until those that need most have it. */
double plan_certifying(const plan_work *w, const plan_candidate *holder) {
    const int nearest = plan_knob(holder->note, "k"), begin = plan_knob(holder->note, "begin");
    if (nearest < 0 || begin < 0 || !(w->in->tolerance > 0.0))
        return 1.0;
    const double depth = w->in->stats->largest_depth, k = holder->values[nearest],
                 first = holder->values[begin];
    if (first > 0.0)
        return 1.0 + log2(fmax(1.0, (k > 0.0 ? fmin(k, depth) : depth) / first));
    return k > 0.0 ? ACCOUNTED : 1.0;
}

/* Appends to the reasons of what folds: which certificate is asked for, and with what. */
strata_result plan_explain_trades(plan_work *w) {
    for (uint32_t i = 0; i < w->count && w->in->tolerance > 0.0; i++) {
        plan_candidate *c = &w->candidates[i];
        if (!c->chosen || (c->role != PLAN_CAPTURE && c->role != PLAN_STREAM))
            continue;
        const int payload = costs_payload_knob(c->note), nearest = plan_knob(c->note, "k"),
                  begin = plan_knob(c->note, "begin");
        size_t length = strlen(c->reason);
        const size_t size = sizeof c->reason;
#define ADD(...) length += (size_t)snprintf(c->reason + length, size - length, __VA_ARGS__)
        if (length < size)
            ADD("; for a tolerance of %.3g it %s", w->in->tolerance,
                w->in->raise ? "now takes" : "begins with");
        if (payload >= 0 && length < size)
            ADD(" payload %s", costs_payload_name(plan_stored(c)));
        if (begin >= 0 && c->values[begin] > 0.0 && length < size)
            ADD("%s k from %.0f to %.0f, pixel by pixel", payload >= 0 ? "," : "", c->values[begin],
                c->values[nearest]);
        else if (nearest >= 0 && length < size)
            ADD("%s k %.0f", payload >= 0 ? "," : "", c->values[nearest]);
        if (payload < 0 && nearest < 0 && length < size)
            ADD(" all there is");
#undef ADD
    }
    return STRATA_OK;
}
