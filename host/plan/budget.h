/* SPDX-License-Identifier: MIT
 *
 * What follows from how long frames took that have a budget of time. Pure functions of what they
 * were told.
 *
 * The feedback rule: what one knob is set to next. Callahan et al. (SIBGRAPI 2005 course): next =
 * previous * target time / render time, a straight line through the origin; here through -base, by
 * what the plan expects, or through the last two settings that were measured, once there are two;
 * where those took alike times no more than twice, and no less than half as steep as expected. It
 * stays between what fits and what does not. A setting that is settled for was found by few frames,
 * in a slow moment perhaps: once it is sure, up to twice as much is tried, and kept where it fits.
 */
#ifndef STRATA_HOST_BUDGET_H
#define STRATA_HOST_BUDGET_H

#include <stdint.h>

#define BUDGET_MET    1.15 /* of the target: met */
#define BUDGET_NEAR   1.05 /* of the target: not worth a change */
#define BUDGET_LATE   1.1  /* of the target: worth one, before it is missed */
#define BUDGET_RECENT 4u   /* frames that judgements go back */

typedef struct budget_rule {
    double target;           /* ms */
    double minimum, maximum; /* whole; more is more accurate, and takes longer */
    double level;            /* the knob */
    double base;             /* times are expected to be proportional to this + level; 0: unknown */
    double ms;               /* that frames at this level take */
    uint32_t frames;         /* since it, or what is seen of the scene, is another */
    double settled_ms;       /* above 0: settled for, and how long that took */
    double other, other_ms;  /* another level that was measured; 0: none */
    double fits, misses;     /* levels below and above the one sought for; 0: unknown */
    double barred;           /* from this level on nothing is tried; 0: none */
    int trying;              /* 1: level is one that is tried, from `other` */
    uint32_t in_vain;        /* tries since one that fitted */
} budget_rule;

/* 1 <= minimum <= maximum; level is clamped to them. */
budget_rule budget_begin(double target, double minimum, double maximum, double level, double base);

/* Takes what frames at rule->level take, after each of them. 1: level has changed. */
int budget_measure(budget_rule *rule, double ms);

/* The plans of a sequence: one that keeps all and takes too long is given up for one that turns a
 * knob, and that one where much would have to be given, or there is room for all again; one that
 * gives up more than its knob, where there is room for long. */
typedef struct budget_watch {
    double asked;                 /* ms; 0: none */
    double ms;                    /* mean of the recent frames with one plan and knob */
    double recent[BUDGET_RECENT]; /* their times; the last in [0] */
    uint32_t judged;              /* of them, since then, at most BUDGET_RECENT */
    uint32_t late;       /* bit i: frames that keep all at STRATA_PAYLOAD_ i take too long */
    uint32_t replans;    /* asked for */
    uint32_t retried;    /* 1: exactness was weighed again, where no more was to be kept */
    uint32_t stuck;      /* 1: the least was set and takes too long */
    uint32_t least_late; /* 1: so it was with this plan, or one before */
    uint32_t early;      /* frames in a row with room for another */
    uint32_t weighed;    /* times that what was late was weighed again */
    uint32_t turns;      /* 1: the plan turns a knob, by `rule` */
    budget_rule rule;
} budget_watch;

typedef enum budget_step {
    BUDGET_STAYS,
    BUDGET_TURNS,  /* to watch->rule.level */
    BUDGET_REPLANS /* the next frame wants another plan */
} budget_step;

/* The frames to come have another plan; rule is copied, NULL: it turns nothing. exact: the level
 * from which on an exact way is expected to take no longer, which is weighed there; 0: none. */
void budget_planned(budget_watch *watch, const budget_rule *rule, double exact);
/* Takes the time of a frame that says something. */
void budget_take(budget_watch *watch, double ms);
/* What frames take: the second fastest of the recent ones, of two or one the fastest, for what
 * disturbs a frame makes it slower, never faster. */
double budget_lasting(const budget_watch *watch);
/* Their median, for what is expected of other plans by them: no slow one and no fast one decides. */
double budget_typical(const budget_watch *watch);
/* What follows from the frame that was taken last, with records of that STRATA_PAYLOAD_*. */
budget_step budget_follow(budget_watch *watch, uint32_t payload);

#endif
