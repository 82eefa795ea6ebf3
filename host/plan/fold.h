/* SPDX-License-Identifier: MIT
 *
 * The search for what folds transparent fragments: what fold.c finds, and explain.c puts into
 * words.
 */
#ifndef STRATA_HOST_PLAN_FOLD_H
#define STRATA_HOST_PLAN_FOLD_H

#include "plan/plan_internal.h"

typedef struct plan_search {
    plan_work *w;
    plan_candidate *named[PLAN_ROLES]; /* of the three roles, NULL = left open */
    plan_way best, measured;           /* of all, and of those that were measured on the device */
    double least;                      /* cost of any of them */
    int doubted;                       /* 1: what would cost less was not */
    uint32_t ways;                     /* that were open to the choice */
    int within;                        /* 1: of a budget */
    double room;
    plan_way exact;             /* what would be taken without the budget, where that keeps all */
    plan_way fitting, cheapest; /* the best that fits; what comes closest */
    int alike;                  /* 1: that keeps all, and hardly takes longer than the fastest */
} plan_search;

int plan_folds(const plan_candidate *c); /* alone, or as one of a pair */
/* Promises every fragment, in order, with these settings. */
int plan_is_exact(const plan_candidate *c);
int plan_way_is_exact(const plan_way *w);

/* ---- explain.c */
/* Nothing folds: UNSUPPORTED, with what each lacks. */
strata_result plan_fail_fold(const plan_search *s);
/* Nothing is to be folded. */
strata_result plan_leave_fold(plan_work *w);
void plan_describe_fold(const plan_search *s);
void plan_describe_others(const plan_search *s);

#endif
