/* SPDX-License-Identifier: MIT
 *
 * The feedback rule of a time budget: what one knob is set to next, by how long the frames took. A
 * pure function of what it was told. Callahan et al. (SIBGRAPI 2005 course): next = previous *
 * target time / render time, a straight line through the origin; here the line goes through the
 * last two settings that were measured, once there are two, and stays between what fits and what
 * does not.
 */
#ifndef STRATA_HOST_BUDGET_H
#define STRATA_HOST_BUDGET_H

#include <stdint.h>

#define BUDGET_MET  1.15 /* of the target: met */
#define BUDGET_NEAR 1.1  /* of the target: not worth a change */

typedef struct budget_rule {
    double target;           /* ms */
    double minimum, maximum; /* whole; more is more accurate, and takes longer */
    double level;            /* the knob */
    double ms;               /* mean of the frames at this level */
    uint32_t frames;         /* of them */
    double settled_ms;       /* above 0: settled for, and how long that took */
    double other, other_ms;  /* another level that was measured; 0: none */
    double fits, misses;     /* levels below and above the one sought for; 0: unknown */
} budget_rule;

/* 1 <= minimum <= maximum; level is clamped to them. */
budget_rule budget_begin(double target, double minimum, double maximum, double level);

/* Takes the time of a frame at rule->level. 1: level has changed. */
int budget_measure(budget_rule *rule, double ms);

#endif
