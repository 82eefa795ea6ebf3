/* SPDX-License-Identifier: MIT
 *
 * Frames within a budget of time. The plan begins with what is expected to fit; the frames tell
 * whether it does. Frames that keep all and take too long are given up for records of less
 * precision or for the nearest fragments, whose number the feedback rule then turns, in the session
 * as it is. When, is said by plan/budget.h.
 */
#include "render/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void render_budget_end(strata *s) {
    free(s->budget.frames);
    costs_free(&s->budget.costs);
    json_decref(s->budget.plans);
    s->budget = (render_budget){0};
}

void render_budget_begin(strata *s, double asked) {
    render_budget_end(s);
    s->budget.watch.asked = asked;
    s->budget.replan = asked > 0; /* its plan is made for it, whatever was rendered before */
}

/* How many steps of the knob take as long as what a frame of this plan does besides; 0: unknown. */
static double base_of(const render_budget *b, const plan *p) {
    const double unit = p->ms > 0 ? p->ms / p->cost : 0; /* ms of a blended fragment */
    if (!(p->cost > 0) || !(p->turned_each > 0))
        return 0;
    return fmax((p->cost + (unit > 0 ? b->beside / unit : 0)) / p->turned_each - plan_turned(p), 0);
}

static void add_settings(base_text *name, const plan *p, const plan_technique *t) {
    for (uint32_t k = 0; k < t->settings.count; ++k) {
        const strata_knob *knob = t->technique->knobs[k];
        const double value = t->values[k];
        if (value == knob->preset || (t->technique == p->turned && k == p->turned_knob))
            continue;
        if (knob->type == STRATA_KNOB_CHOICE)
            base_text_add(name, " %s=%s", knob->name, knob->choices[(uint32_t)value]);
        else
            base_text_add(name, " %s=%.9g", knob->name, value);
    }
}

/* Of what folds: ids, and knobs that are not at their presets but for the one that is turned. */
static void name_plan(render_budget *b, const plan *p) {
    static const char *const stages[] = {"clip", "capture", "resolve", "stream"};
    base_text name = {0};
    for (uint32_t i = 0; i < p->technique_count; ++i)
        for (size_t k = 0; k < BASE_COUNT(stages); ++k)
            if (strcmp(p->techniques[i].technique->stage, stages[k]) == 0) {
                base_text_add(&name, "%s%s", name.length ? " + " : "",
                              p->techniques[i].technique->id);
                add_settings(&name, p, &p->techniques[i]);
            }
    const char *text = name.data ? name.data : "";
    b->plans = b->plans ? b->plans : json_array();
    for (b->plan = 0; b->plan < json_array_size(b->plans); ++b->plan)
        if (strcmp(json_string_value(json_array_get(b->plans, b->plan)), text) == 0)
            break;
    if (b->plan == json_array_size(b->plans))
        json_array_append_new(b->plans, json_string(text));
    base_text_free(&name);
}

void render_budget_planned(strata *s) {
    budget_watch *w = &s->budget.watch;
    const plan *p = s->session->plan;
    const budget_rule rule = budget_begin(w->asked, p->turned_least, p->turned_most, plan_turned(p),
                                          base_of(&s->budget, p));
    s->budget.replan = s->budget.paced = 0;
    s->budget.paces = 0;
    budget_planned(w, p->turned ? &rule : NULL, p->turned_exact);
    if (w->asked > 0)
        name_plan(&s->budget, p);
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

/* How many times as long as usual frames take: by what is known of the present ones, else by those
 * of the plan before. */
static double pace_of(const render_budget *b) {
    if (b->paced)
        return b->paces / b->paced;
    return b->ns > 0 && b->costs.ns > 0 ? b->ns / b->costs.ns : 1;
}

/* Frames of what was never measured here are added to what is known of the device, for this
 * sequence alone, in the pace that the device had then. */
static strata_result learn(strata *s, const render_figures *figures, base_error *err) {
    render_budget *b = &s->budget;
    if (figures->gpu_ms > 0 && figures->retries == 0) {
        const double beside = fmax(figures->ms - figures->gpu_ms, 0);
        b->beside = b->watch.judged > 1 ? fmin(b->beside, beside) : beside;
    }
    if (render_knows_frame(s))
        return STRATA_OK;
    if (!b->costs.techniques && !costs_copy(&s->costs, &b->costs))
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "budget: out of memory");
    const double pace = render_frame_pace(s);
    b->paces += pace;
    b->paced += pace > 0;
    render_learn_frame(s, &b->costs, pace_of(b));
    return STRATA_OK;
}

/* Another plan, by what was learnt. Where all that runs was measured here before, what differs is
 * the pace of the device: others are as much slower, or faster. So it is where passes are not
 * timed. Where some of it was, that tells the pace. */
static strata_result plan_again(strata *s, base_error *err) {
    render_budget *b = &s->budget;
    const plan *p = s->session->plan;
    const double ms = budget_typical(&b->watch) - b->beside, pace = pace_of(b);
    b->replan = 1;
    strata_result r = b->costs.techniques ? render_costs_fit(s, &b->costs, err) : STRATA_OK;
    if (!(b->costs.ns > 0) || render_knows_frame(s))
        b->ns = p->cost > 0 && ms > 0 ? ms * 1e6 / p->cost : b->ns;
    else
        b->ns = b->costs.ns * pace; /* the fit may have changed the unit */
    return r;
}

/* Frames that prepare do not, nor does the one after: all memory is new to it, it takes half as
 * much again. One that was recorded again for more room says little, unless the next one is, too.
 */
static int says_something(render_budget *b, const render_figures *figures) {
    const int prepared = figures->prepared > 0, after = b->prepared,
              learning = figures->retries > 0 && !b->recorded_again;
    b->prepared = prepared;
    b->recorded_again = figures->retries > 0 && !prepared;
    return !prepared && !after && !learning;
}

strata_result render_budget_learn(strata *s, const strata_render_options *options,
                                  base_error *err) {
    const render_figures *figures = &s->result.frames[s->result.frame_count - 1];
    render_budget *b = &s->budget;
    const render_budget_frame frame = {.ms = figures->ms,
                                       .level = plan_turned(s->session->plan),
                                       .judged = (uint32_t)says_something(b, figures),
                                       .plan = b->plan};
    if (!(b->watch.asked > 0))
        return STRATA_OK;
    if (figures->report.known >> STRATA_REPORT_MAX_PER_PIXEL & 1u)
        b->deepest = fmax(b->deepest, (double)figures->report.largest);
    strata_result r = note(b, frame, err);
    if (r != STRATA_OK || !frame.judged)
        return r;
    budget_take(&b->watch, frame.ms);
    r = learn(s, figures, err);
    if (r != STRATA_OK || options->tolerance > 0 || (options->outputs & STRATA_OUTPUT_DEEP))
        return r; /* these come first */
    switch (budget_follow(&b->watch, s->session->plan->payload.precision)) {
    case BUDGET_TURNS:
        return render_session_turn(s->session, b->watch.rule.level, err);
    case BUDGET_REPLANS:
        return plan_again(s, err);
    case BUDGET_STAYS:
        break;
    }
    return STRATA_OK;
}

/* Not while there are frames to come in which it may yet be met. */
void render_budget_warn(strata *s, const strata_render_options *options) {
    const budget_watch *w = &s->budget.watch;
    const int more = options->repeat == 1 && !w->stuck && !(w->late && !w->turns);
    if (w->asked > 0 && w->ms > BUDGET_MET * w->asked && !more)
        render_warn(s, "the budget of %.3g ms is missed", w->asked);
}

json_t *render_budget_json(const strata *s) {
    const render_budget *b = &s->budget;
    const budget_watch *w = &b->watch;
    const plan *p = s->session->plan;
    if (!(w->asked > 0))
        return json_null();
    json_t *frames = json_array();
    for (uint32_t i = 0; i < b->count; ++i)
        json_array_append_new(
            frames,
            json_pack("{s:f, s:i, s:o, s:b}", "ms", b->frames[i].ms, "plan", (int)b->frames[i].plan,
                      "value", b->frames[i].level > 0 ? json_real(b->frames[i].level) : json_null(),
                      "judged", (int)b->frames[i].judged));
    return json_pack("{s:f, s:o, s:o, s:o, s:o, s:f, s:O, s:o}", "asked_ms", w->asked, "ms",
                     w->ms > 0 ? json_real(w->ms) : json_null(), "met",
                     w->ms > 0 ? json_boolean(w->ms <= BUDGET_MET * w->asked) : json_null(),
                     "technique", p->turned ? json_string(p->turned->id) : json_null(), "knob",
                     p->turned ? json_string(p->turned->knobs[p->turned_knob]->name) : json_null(),
                     "depth", p->stats.largest_depth, "plans", b->plans, "frames", frames);
}
