/* SPDX-License-Identifier: MIT
 *
 * The feedback rule; see budget.h.
 */
#include "plan/budget.h"

#include <math.h>
#include <string.h>

#define LOW 0.93 /* of the target: from there to BUDGET_NEAR a level is settled for */

/* Of the target: a frame that takes so much longer is believed at once, others twice, for what
 * disturbs one may double it; and one that takes so much less, others three times: two may be fast
 * by chance. */
#define DOUBT_LATE  4.0
#define DOUBT_EARLY 2.0

#define AIM     0.95 /* of the target, from above: it shall be met, not missed by a little */
#define LARGEST 4.0  /* factor between two levels */
#define ALIKE   0.25 /* of a time: another differs by noise */
#define TWISTED 2.0  /* factor between the steepness of times and what is expected */
#define OTHER   1.5  /* factor between the times of two scenes */
#define SURE    3u   /* frames of a try, and after which there is one; in vain each doubles that, */
#define DOUBLED 4u   /* so often */
#define FORGETS 96u  /* frames after which what was tried in vain may be tried again */
#define MORE    2.0  /* factor of a level, at most, that is tried */
#define WORTH   1.25 /* and at least */

budget_rule budget_begin(double target, double minimum, double maximum, double level, double base) {
    return (budget_rule){.target = target,
                         .minimum = minimum,
                         .maximum = maximum,
                         .base = base,
                         .level = fmin(fmax(floor(level), minimum), maximum)};
}

/* Of the line through what was measured, ms a level. Two times that differ by little may be noise:
 * where a steepness is expected it is that within TWISTED then. */
static double steepness(const budget_rule *r) {
    const double expected = r->ms / (r->base + r->level);
    double slope = expected;
    if (r->other > 0.0)
        slope = (r->ms - r->other_ms) / (r->level - r->other);
    if (r->base > 0.0 && fabs(r->ms - r->other_ms) < ALIKE * r->ms)
        slope = fmin(fmax(slope, expected / TWISTED), expected * TWISTED);
    return slope;
}

/* By that line; where none rises, as far as may be. */
static double propose(const budget_rule *r) {
    const double slope = steepness(r), aim = r->ms > r->target ? AIM * r->target : r->target;
    if (slope > 0.0)
        return r->level + (aim - r->ms) / slope;
    return r->ms > r->target ? r->level / LARGEST : r->level * LARGEST;
}

/* What holds as a bound is forgotten when a later measurement contradicts it: scenes change. */
static void bracket(budget_rule *r) {
    if (r->ms > r->target) {
        r->misses = r->level;
        if (r->fits >= r->level)
            r->fits = 0.0;
        if (r->trying || r->ms > OTHER * r->target)
            r->barred = r->level;
    } else {
        r->fits = r->level;
        if (r->misses <= r->level)
            r->misses = 0.0;
        if (r->barred <= r->level)
            r->barred = 0.0;
    }
}

/* What is tried beyond a level that fits: what would be met were the line TWISTED times too steep,
 * and less than what was far too much, or was tried in vain. The same level: nothing. */
static double more_than(const budget_rule *r) {
    const double slope = steepness(r) / TWISTED, most = fmin(MORE * r->level, r->maximum);
    double next = most;
    if (slope > 0.0)
        next = fmin(next, floor(r->level + (BUDGET_MET * r->target - r->ms) / slope));
    if (r->barred > 0.0 && next >= r->barred)
        next = floor(0.5 * (r->level + r->barred));
    return next >= WORTH * r->level || next == r->maximum ? next : r->level;
}

/* The level that is left is one that was measured. */
static int leave_for(budget_rule *r, double next) {
    r->other = r->level;
    r->other_ms = r->ms;
    r->level = next;
    r->frames = 0;
    return 1;
}

static int try_more(budget_rule *r) {
    const int sure = r->frames >= SURE << r->in_vain && r->ms <= r->target;
    r->barred = r->frames < FORGETS ? r->barred : 0.0;
    const double next = sure ? more_than(r) : r->level;
    if (next <= r->level)
        return 0;
    r->fits = r->level;
    r->misses = r->barred;
    r->settled_ms = 0.0;
    r->trying = 1;
    return leave_for(r, next);
}

static void succeed(budget_rule *r) {
    r->in_vain = r->trying ? 0 : r->in_vain;
    r->trying = 0;
}

/* A try that takes too long ends where it began. */
static int give_back(budget_rule *r) {
    r->settled_ms = r->other_ms;
    r->in_vain += r->in_vain < DOUBLED;
    r->trying = 0;
    return leave_for(r, r->other);
}

static double next_level(const budget_rule *r) {
    double next = fmin(fmax(propose(r), r->level / LARGEST), r->level * LARGEST);
    next = floor(fmin(fmax(next, r->minimum), r->maximum));
    if (r->ms > r->target)
        next = fmax(fmin(next, r->level - 1.0), r->minimum);
    else
        next = fmin(fmax(next, r->level + 1.0), r->maximum);
    if (r->fits > 0.0 && r->misses > 0.0 && (next <= r->fits || next >= r->misses))
        next = r->misses - r->fits > 1.0 ? floor(0.5 * (r->fits + r->misses)) : r->fits;
    return next;
}

/* Whether a level that was settled for is as good as it was. One whose time is not the target, for
 * there is none between it and the next, is left only when frames are quite different ones. */
static int stays(const budget_rule *r) {
    const double late = r->target * BUDGET_LATE;
    if (r->settled_ms > BUDGET_NEAR * r->target)
        return r->ms <= r->settled_ms * OTHER && r->ms * OTHER >= r->settled_ms;
    const double early =
        r->settled_ms >= LOW * r->target ? r->target * LOW / BUDGET_NEAR : r->settled_ms / OTHER;
    return r->ms <= late && r->ms >= early;
}

int budget_measure(budget_rule *r, double ms) {
    r->frames++;
    r->ms = ms;
    if (r->settled_ms > 0.0) {
        if (stays(r))
            return try_more(r);
        /* The scene is another; a little faster alone does not bring the next level within reach.
         */
        if (ms > r->target || ms * OTHER < r->settled_ms || r->misses != r->level + 1.0)
            r->fits = r->misses = r->other = r->barred = 0.0;
        r->settled_ms = 0.0;
        r->frames = 1;
    }
    if (r->trying && r->frames < SURE && r->ms <= BUDGET_MET * r->target)
        return 0;
    const double most = BUDGET_NEAR * r->target;
    if (r->ms >= LOW * r->target && r->ms <= most) {
        r->settled_ms = r->ms;
        succeed(r);
        return 0;
    }
    if (r->ms > r->target && r->ms <= DOUBT_LATE * r->target && r->frames < 2)
        return 0;
    if (r->ms < r->target && r->ms * DOUBT_EARLY >= r->target && r->frames < 3)
        return 0;
    bracket(r);
    if (r->trying && r->ms > most)
        return give_back(r);
    succeed(r);
    const double next = next_level(r);
    if (next == r->level) { /* the least, the most, or the last that fits */
        r->settled_ms = r->ms;
        return 0;
    }
    return leave_for(r, next);
}

/* ---- plans ----------------------------------------------------------------------------------- */

#define MOST_REPLANS 8u  /* in a sequence: each costs a frame that prepares */
#define MUCH         0.8 /* of what was kept: less was not what was expected to fit */
#define SOME         0.9 /* of the target: room enough where even the least was late */
#define TRUSTS       2u  /* so many of them where what was expected to fit does not */

static void forget(budget_watch *w) {
    w->judged = 0; /* ms stays until there is another */
    w->stuck = 0;
}

void budget_planned(budget_watch *w, const budget_rule *rule, double exact) {
    forget(w);
    w->turns = rule != NULL;
    if (!rule)
        return;
    w->rule = *rule;
    if (exact > 0.0 && !w->late && !w->retried && w->replans < MOST_REPLANS)
        w->rule.maximum = fmin(fmax(exact, rule->level), rule->maximum);
}

void budget_take(budget_watch *w, double ms) {
    memmove(w->recent + 1, w->recent, (BUDGET_RECENT - 1) * sizeof *w->recent);
    w->recent[0] = ms;
    w->judged += w->judged < BUDGET_RECENT;
    double sum = 0.0;
    for (uint32_t i = 0; i < w->judged; i++)
        sum += w->recent[i];
    w->ms = sum / w->judged;
}

static budget_step replan(budget_watch *w) {
    if (w->replans == MOST_REPLANS)
        return BUDGET_STAYS;
    w->replans++;
    return BUDGET_REPLANS;
}

double budget_lasting(const budget_watch *w) {
    double least = HUGE_VAL, second = HUGE_VAL;
    for (uint32_t i = 0; i < w->judged; i++) {
        second = fmin(second, fmax(least, w->recent[i]));
        least = fmin(least, w->recent[i]);
    }
    return w->judged > 2 ? second : least;
}

double budget_typical(const budget_watch *w) {
    double sorted[BUDGET_RECENT] = {0};
    for (uint32_t i = 0; i < w->judged; i++) {
        uint32_t at = i;
        for (; at > 0 && sorted[at - 1] > w->recent[i]; at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = w->recent[i];
    }
    return w->judged > 0 ? 0.5 * (sorted[(w->judged - 1) / 2] + sorted[w->judged / 2]) : 0.0;
}

/* The fewer frames there are the less is believed: the first ones of a plan are slower than those
 * to come, by a quarter at times. */
static int is_late(const budget_watch *w) {
    static const double times[BUDGET_RECENT] = {DOUBT_LATE, 1.3, 1.2, BUDGET_LATE};
    return budget_lasting(w) > times[w->judged - 1] * w->asked;
}

/* What was late was so in a slow moment, perhaps: where there is much room for long enough, which
 * is twice as long each time, all is weighed again; a little room where even the least was late. */
static budget_step weigh_again(budget_watch *w) {
    const double room =
        (w->least_late ? SOME : MUCH) * w->asked; /* any bound is better than none */
    const int much =
        (w->late || w->least_late) && w->judged == BUDGET_RECENT && budget_lasting(w) <= room;
    w->early = much ? w->early + 1 : 0;
    if (w->early < BUDGET_RECENT << w->weighed || w->replans + 2 > MOST_REPLANS)
        return BUDGET_STAYS; /* one plan is left for what is late again */
    w->late = w->least_late = w->early = 0;
    w->weighed++;
    return replan(w);
}

static budget_step follow_fixed(budget_watch *w, uint32_t payload) {
    if ((w->late >> payload & 1u) || !is_late(w))
        return weigh_again(w);
    w->late |= 1u << payload;
    return replan(w);
}

static budget_step follow_turned(budget_watch *w) {
    const budget_rule *rule = &w->rule;
    const double before = rule->trying ? rule->other : rule->level;
    if (budget_measure(&w->rule, budget_lasting(w))) {
        /* Something else may now be expected to give up less, where much is, or where there is room
         * for much more. A frame that prepares is too much for the little by which a scene drifts.
         */
        const int far = rule->level < MUCH * before || rule->level > MORE * before;
        if (far && w->replans < TRUSTS)
            return replan(w);
        forget(w);
        return BUDGET_TURNS;
    }
    w->stuck =
        rule->level <= rule->minimum && is_late(w) && budget_lasting(w) > BUDGET_MET * w->asked;
    w->least_late |= w->stuck;
    if (w->stuck)
        return replan(w); /* with others there may be room for more */
    if (rule->level >= rule->maximum && rule->settled_ms > 0.0 && rule->settled_ms <= w->asked &&
        !w->late && !w->retried) {
        w->retried = 1; /* exact ways may be as fast as more, or there is no more */
        return replan(w);
    }
    return BUDGET_STAYS;
}

budget_step budget_follow(budget_watch *w, uint32_t payload) {
    return w->turns ? follow_turned(w) : follow_fixed(w, payload);
}
