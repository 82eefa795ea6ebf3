/* SPDX-License-Identifier: MIT
 *
 * What the files of host/plan share: the state of a plan in the making.
 *
 *     names.c     lists of ids, suggestions       settings.c  ID.KNOB=VALUE
 *     effects.c   which effects are active        order.c     slots -> order
 *     assess.c    what each technique could do    choose.c    which of them run
 *     fold.c      the one that folds          explain.c   and why it does
 *     clip.c      what limits it
 *     cull.c      what hides opaque objects
 *     within.c    what fits a budget
 *     payload.c   layout of a record              json.c      the plan as JSON
 *     tolerance.c knobs that trade accuracy
 */
#ifndef STRATA_HOST_PLAN_INTERNAL_H
#define STRATA_HOST_PLAN_INTERNAL_H

#include "plan/plan.h"

typedef enum plan_role { /* what a stage is to a frame; the order is that of the stages */
                         PLAN_DRAWS,
                         PLAN_SURFACE,
                         PLAN_CLIP,
                         PLAN_CAPTURE,
                         PLAN_RESOLVE,
                         PLAN_STREAM,
                         PLAN_FILTER,
                         PLAN_CERTIFICATE,
                         PLAN_ROLES
} plan_role;

/* What a technique costs where fragments are held in one form or another. */
typedef struct plan_price_in {
    double coefficients[COSTS_TERMS]; /* zeros when unknown */
    int points;                       /* see costs_of */
} plan_price_in;

/* One installed technique while the plan is made. */
typedef struct plan_candidate {
    const modules_technique_note *note;
    plan_role role; /* PLAN_ROLES: its stage is unknown */
    int named;      /* in --use */
    int blocked;    /* cannot run here; `reason` says why */
    int chosen;
    uint64_t set_knobs; /* bit i: knob i was set by the user */
    double *values;
    double cost; /* alone, PLAN_NO_COST when unknown */
    plan_price_in price[COSTS_CLIPPED][COSTS_LAYOUTS][COSTS_PAYLOADS];
    uint32_t ways;   /* to fold with it, of those open to the choice */
    double compared; /* of the cheapest of them, PLAN_NO_COST when there is none or it is unknown */
    char reason[256];
} plan_candidate;

typedef struct plan_work {
    const plan_input *in;
    plan *out;
    plan_candidate *candidates; /* ordered by stage, then id */
    uint32_t count;
    base_error *err;
} plan_work;

/* ---- names.c */

/* Calls `each` for every id of a comma-separated list, blanks around ids ignored; stops at its
 * first failure. INVALID_ARGUMENT for an empty id; `option` names the list in messages. */
strata_result plan_split(const char *list, const char *option,
                         strata_result (*each)(void *user, const char *id), void *user,
                         base_error *err);

/* " (did you mean 'x'?)" for the nearest of `names`, "" when none is near. */
void plan_suggest(const char *name, const char *const *names, uint32_t count, char *out,
                  size_t size);

/* "a, b, c", or "none". Shortened with "..." to fit. */
void plan_join(const char *const *names, uint32_t count, char *out, size_t size);

strata_result plan_unknown_technique(const plan_work *w, const char *option, const char *id);
strata_result plan_unknown_effect(const plan *p, const char *option, const char *id,
                                  base_error *err);

/* A line for plan->warnings; one that is there already is not repeated. */
strata_result plan_warn(plan_work *w, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* ---- effects.c */
strata_result plan_decide_effects(const plan_input *in, plan *out, base_error *err);

/* ---- settings.c */
strata_result plan_resolve_settings(plan_work *w);                   /* presets, then the user's */
int plan_knob(const modules_technique_note *note, const char *name); /* index or -1 */

/* ---- tolerance.c */
double plan_tolerance(const plan_input *in); /* 0: exact techniques alone */
strata_result plan_trade(plan_work *w); /* knobs that trade accuracy, where the user set none */
strata_result plan_explain_trades(plan_work *w);
/* How many times as long a frame takes for its certificate: where pixels grow it is recorded until
 * each has as many fragments as that takes, in a view that moves every frame; and what may drop
 * some keeps an account of them. */
double plan_certifying(const plan_work *w, const plan_candidate *holder);
/* Whether it says how wrong its image may be; what captures leaves that to what folds. */
int plan_certifies(const plan_candidate *c);

/* ---- within.c */
/* One way to fold. capture is NULL for a stream technique, which stands in `fold`. */
typedef struct plan_way {
    plan_candidate *capture, *fold;
    costs_form form;
    double cost;   /* HUGE_VAL when unknown */
    double beside; /* what it needs beside it costs: a filter of its sub-pixels */
    double keeps;  /* under a budget: how many fragments a pixel, 0 = what its settings say */
    double error;  /* under a budget: that is expected */
} plan_way;

plan_candidate *plan_holder(const plan_way *candidate); /* what holds a pixel's fragments */

double plan_whole(const plan_way *candidate); /* its cost, and what it needs beside it */

double plan_ns(const plan_input *in);      /* of a blended fragment, 0 = unknown */
int plan_has_budget(const plan_input *in); /* that decides */
double plan_room(const plan_work *w);      /* what the fold may cost; HUGE_VAL: unknown */
/* Whether the user leaves open in which precision it stores, or how many it keeps. */
int plan_free_payload(const plan_candidate *holder);
int plan_free_count(const plan_candidate *holder);
/* Whether what has one cost fits: it is not given up for missing the budget by a little. */
int plan_fits(const plan_way *candidate, double room);
/* Where nothing fits: room for what may be as fast as the fastest, and not be late (budget.h). */
double plan_alike(double fastest, double room);
/* Sets keeps, cost and error to the most that fits into `room`; 0: even the least does not, and
 * that is what they are set to. */
int plan_fit_way(const plan_work *w, plan_way *candidate, double room);
/* Sets the way's holder to what it keeps and how it stores it, and notes what is turned. exact: the
 * way that keeps all and would be taken without the budget, fold NULL: there is none. */
void plan_settle_budget(plan_work *w, const plan_way *chosen, const plan_way *exact);
void plan_explain_budget(plan_work *w, const plan_way *chosen);

/* ---- assess.c */
strata_result plan_collect(plan_work *w); /* candidates, with roles */
strata_result plan_price(plan_work *w);   /* and with costs, once settings are known */
strata_result plan_assess(plan_work *w);  /* what is named, and what is blocked */
plan_candidate *plan_candidate_find(const plan_work *w, const char *id);
const plan_price_in *plan_price_at(const plan_candidate *c, costs_form form);
/* In this form, where what holds a pixel's fragments keeps the nearest so many, 0 = all;
 * PLAN_NO_COST. */
double plan_cost(const plan_work *w, const plan_candidate *c, costs_form form, double nearest);
double plan_kept(const plan_candidate *holder);     /* with its settings, 0 = all */
uint32_t plan_stored(const plan_candidate *holder); /* STRATA_PAYLOAD_* with its settings */
int plan_host_fills(const char *slot);
void plan_reason(plan_candidate *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- choose.c */
strata_result plan_choose(plan_work *w);
/* Of what turns the sub-pixels that this one folds into pixels; 0 where it does so itself, or there
 * are none. */
double plan_filter_cost(const plan_work *w, const plan_candidate *fold);

/* ---- fold.c */
strata_result plan_choose_fold(plan_work *w);
/* STRATA_ORDER_* that its promises are worth with what its knobs are set to; it must have some. */
uint32_t plan_promised_order(const plan_candidate *c);

/* ---- clip.c */
strata_result plan_choose_clip(plan_work *w); /* after the fold, before other optional ones */
/* Once it is known what runs: notes whether something is hidden, and what the holder costs then. */
void plan_settle_clip(plan_work *w);

/* ---- cull.c */
void plan_choose_cull(plan_work *w); /* after the surface, before other optional ones */

/* ---- order.c */
/* order: indices of the chosen candidates as they run. INVALID_ARGUMENT names a cycle. */
strata_result plan_order(const plan_work *w, uint32_t *order, uint32_t *count);

#endif
