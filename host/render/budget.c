/* SPDX-License-Identifier: MIT
 *
 * Frames within a budget of time. The plan begins with what is expected to fit; the frames tell
 * whether it does. Frames that keep all and take too long are given up for records of less
 * precision or for the nearest fragments, whose number the feedback rule (plan/budget.h) then
 * turns, in the session as it is.
 */
#include "render/render.h"

#include <stdlib.h>
#include <string.h>

#define RECENT       4u  /* frames that a mean goes back */
#define AT_ONCE      1.5 /* times the budget: one frame is enough to see that it is missed */
#define MOST_REPLANS 8u  /* in a sequence: each costs a frame that prepares */
#define MUCH         0.8 /* of what was kept: less was not what was expected to fit */
#define TRUSTS       3u  /* so many of them where what was expected to fit does not */

void render_budget_end(strata *s) {
    free(s->budget.frames);
    costs_free(&s->budget.costs);
    s->budget = (render_budget){0};
}

void render_budget_begin(strata *s, double asked) {
    render_budget_end(s);
    s->budget.asked = asked;
}

static void forget(render_budget *b) {
    b->judged = 0; /* ms stays until there is another */
    b->stuck = 0;
}

void render_budget_planned(strata *s) {
    render_budget *b = &s->budget;
    const plan *p = s->session->plan;
    b->replan = 0;
    forget(b);
    if (p->turned)
        b->rule = budget_begin(b->asked, p->turned_least, p->turned_most, plan_turned(p));
}

static strata_result note(render_budget *b, render_budget_frame frame, base_error *err) {
    if (!b->frames)
        b->frames = base_calloc(RENDER_BUDGET_FRAMES, sizeof *b->frames);
    if (!b->frames)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "budget: out of memory");
    if (b->count == RENDER_BUDGET_FRAMES)
        memmove(b->frames, b->frames + 1, --b->count * sizeof *b->frames);
    b->frames[b->count++] = frame;
    return STRATA_OK;
}

/* The frames so far are added to what is known of the device, for this sequence alone. */
static strata_result learn(strata *s, const render_figures *figures, base_error *err) {
    render_budget *b = &s->budget;
    if (!b->costs.techniques && !costs_copy(&s->costs, &b->costs))
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "budget: out of memory");
    if (render_learn_frame(s, &b->costs))
        b->beside = figures->ms > figures->gpu_ms ? figures->ms - figures->gpu_ms : 0;
    return STRATA_OK;
}

/* Another plan, by what was learnt. Where passes are not timed the frames say how long a blended
 * fragment of this plan takes. */
static strata_result plan_again(strata *s, base_error *err) {
    render_budget *b = &s->budget;
    const plan *p = s->session->plan;
    if (b->replans == MOST_REPLANS)
        return STRATA_OK;
    b->replans++;
    b->replan = 1;
    strata_result r = render_costs_fit(s, &b->costs, err);
    if (b->costs.ns > 0)
        b->ns = 0;
    else if (p->cost > 0)
        b->ns = b->ms * 1e6 / p->cost;
    return r;
}

/* Two frames in a row, or one that leaves no doubt. */
static strata_result judge_fixed(strata *s, base_error *err) {
    render_budget *b = &s->budget;
    const double much = b->judged >= 2 ? BUDGET_MET : AT_ONCE;
    const uint32_t stored = 1u << s->session->plan->payload.precision;
    if ((b->late & stored) || b->ms <= much * b->asked)
        return STRATA_OK;
    b->late |= stored;
    return plan_again(s, err);
}

static strata_result judge_turned(strata *s, double ms, base_error *err) {
    render_budget *b = &s->budget;
    const double before = b->rule.level;
    if (budget_measure(&b->rule, ms)) {
        /* Something else may now be expected to give up less, where much is. A frame that prepares
         * is too much for the little by which a scene drifts. */
        if (b->rule.level < MUCH * before && b->replans < TRUSTS)
            return plan_again(s, err);
        forget(b);
        return render_session_turn(s->session, b->rule.level, err);
    }
    b->stuck = b->rule.level <= b->rule.minimum && b->ms > BUDGET_MET * b->asked;
    if (b->stuck)
        return plan_again(s, err); /* with others there may be room for more */
    if (b->rule.level >= b->rule.maximum && b->ms <= b->asked && !b->late && !b->retried) {
        b->retried = 1; /* there is nothing more to keep: exact ways may be as fast */
        return plan_again(s, err);
    }
    return STRATA_OK;
}

strata_result render_budget_learn(strata *s, const strata_render_options *options,
                                  base_error *err) {
    const render_figures *figures = &s->result.frames[s->result.frame_count - 1];
    render_budget *b = &s->budget;
    /* A frame that was recorded again for more room says little, unless the next one is, too. */
    const int learning = figures->retries > 0 && !b->recorded_again;
    const render_budget_frame frame = {.ms = figures->ms,
                                       .level = plan_turned(s->session->plan),
                                       .judged = figures->prepared == 0 && !learning};
    b->recorded_again = figures->retries > 0 && figures->prepared == 0;
    if (!(b->asked > 0))
        return STRATA_OK;
    strata_result r = note(b, frame, err);
    if (r != STRATA_OK || !frame.judged)
        return r;
    b->judged += b->judged < RECENT;
    b->ms += (frame.ms - b->ms) / b->judged;
    r = learn(s, figures, err);
    if (r != STRATA_OK)
        return r;
    if (options->tolerance > 0 || (options->outputs & STRATA_OUTPUT_DEEP))
        return STRATA_OK; /* these come first */
    if (s->session->plan->turned)
        return judge_turned(s, frame.ms, err);
    return judge_fixed(s, err);
}

/* Not while there are frames to come in which it may yet be met. */
void render_budget_warn(strata *s, const strata_render_options *options) {
    const render_budget *b = &s->budget;
    const int more = options->repeat == 1 && !b->stuck && !(b->late && !s->session->plan->turned);
    if (b->asked > 0 && b->ms > BUDGET_MET * b->asked && !more)
        render_warn(s, "the budget of %.3g ms is missed", b->asked);
}

json_t *render_budget_json(const strata *s) {
    const render_budget *b = &s->budget;
    const plan *p = s->session->plan;
    if (!(b->asked > 0))
        return json_null();
    json_t *frames = json_array();
    for (uint32_t i = 0; i < b->count; ++i)
        json_array_append_new(
            frames, json_pack("{s:f, s:o, s:b}", "ms", b->frames[i].ms, "value",
                              b->frames[i].level > 0 ? json_real(b->frames[i].level) : json_null(),
                              "judged", (int)b->frames[i].judged));
    return json_pack("{s:f, s:o, s:o, s:o, s:o, s:o}", "asked_ms", b->asked, "ms",
                     b->ms > 0 ? json_real(b->ms) : json_null(), "met",
                     b->ms > 0 ? json_boolean(b->ms <= BUDGET_MET * b->asked) : json_null(),
                     "technique", p->turned ? json_string(p->turned->id) : json_null(), "knob",
                     p->turned ? json_string(p->turned->knobs[p->turned_knob]->name) : json_null(),
                     "frames", frames);
}
