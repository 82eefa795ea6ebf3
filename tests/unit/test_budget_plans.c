/* SPDX-License-Identifier: MIT
 *
 * host/plan/budget: when a plan is given up for another one, by times that are made up.
 */
#include "plan/budget.h"
#include "strata/frame.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static budget_step take(budget_watch *w, double ms) {
    budget_take(w, ms);
    return budget_follow(w, STRATA_PAYLOAD_HALF);
}

/* Of a plan that turns nothing, within 100 ms: the frame at which it is given up, 0: it never is.
 */
static const struct given_up {
    const char *name;
    double ms[8]; /* then the last of them goes on */
    unsigned frame;
} given_up[] = {
    {"all are in time", {100, 110, 90, 100, 110, 90, 100, 100}, 0},
    {"a little late is met", {109, 109, 109, 109, 109, 109, 109, 109}, 0},
    {"one leaves no doubt", {401, 401, 401, 401, 401, 401, 401, 401}, 1},
    {"one may be disturbed", {399, 100, 100, 100, 100, 100, 100, 100}, 0},
    {"two are much too late", {149, 131, 131, 131, 131, 131, 131, 131}, 2},
    {"three are too late", {149, 121, 121, 121, 121, 121, 121, 121}, 3},
    {"four are late", {111, 111, 111, 111, 111, 111, 111, 111}, 4},
    {"the first ones are slow", {129, 119, 109, 105, 102, 103, 101, 102}, 0},
    {"two of four are in time", {119, 109, 119, 109, 119, 109, 119, 109}, 0},
    {"the scene becomes slower", {90, 90, 90, 120, 120, 120, 120, 120}, 6},
};

static void a_plan_is_given_up_for_lasting_lateness(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof given_up / sizeof *given_up; i++) {
        const struct given_up *row = &given_up[i];
        budget_watch w = {.asked = 100};
        unsigned frame = 0, at = 0;
        budget_planned(&w, NULL, 0);
        for (; frame < 40; frame++)
            if (take(&w, row->ms[frame < 8 ? frame : 7]) == BUDGET_REPLANS && !at)
                at = frame + 1;
        if (at != row->frame)
            fail_msg("%s: given up at frame %u, not %u", row->name, at, row->frame);
        assert_int_equal(w.late, row->frame ? 1u << STRATA_PAYLOAD_HALF : 0);
        assert_int_equal(w.replans, row->frame ? 1 : 0); /* what is late is given up once */
    }
}

/* Of frames of 10 ms after one of 200 the slow one counts for as long as it is among four. */
static void what_is_met_is_the_mean_of_four(void **state) {
    (void)state;
    const double ms[] = {10, 200, 10, 10, 10, 10}, mean[] = {10, 105, 220.0 / 3, 57.5, 57.5, 10};
    budget_watch w = {.asked = 20};
    budget_planned(&w, NULL, 0);
    for (size_t i = 0; i < sizeof ms / sizeof *ms; i++) {
        budget_take(&w, ms[i]);
        assert_true(fabs(w.ms - mean[i]) < 1e-9);
    }
}

/* Of one to four frames, and of five the last four. */
static void what_is_typical_is_the_median(void **state) {
    (void)state;
    const double ms[] = {30, 10, 20, 60, 15}, median[] = {30, 20, 20, 25, 17.5};
    budget_watch w = {.asked = 20};
    assert_true(budget_typical(&w) == 0);
    for (size_t i = 0; i < sizeof ms / sizeof *ms; i++) {
        budget_take(&w, ms[i]);
        assert_true(fabs(budget_typical(&w) - median[i]) < 1e-9);
    }
}

static budget_watch turning(double level, double most) {
    const budget_rule rule = budget_begin(100, 1, most, level, 0);
    budget_watch w = {.asked = 100};
    budget_planned(&w, &rule, 0);
    return w;
}

/* 21 of 26 is above 0.8, 20 is not. What disturbs one frame of two is not seen. */
static void a_knob_that_must_give_much_wants_a_plan(void **state) {
    (void)state;
    budget_watch w = turning(26, 254);
    assert_int_equal(take(&w, 190), BUDGET_STAYS); /* believed twice */
    assert_int_equal(take(&w, 115), BUDGET_TURNS);
    assert_true(w.rule.level == 21);
    assert_int_equal(w.judged, 0); /* frames at another level say nothing of this one */
    w = turning(26, 254);
    take(&w, 201);
    assert_int_equal(take(&w, 201), BUDGET_REPLANS);
    assert_true(w.rule.level == 12);
    const budget_rule rule = budget_begin(100, 1, 254, 26, 0);
    budget_planned(&w, &rule, 0);
    take(&w, 201);
    assert_int_equal(take(&w, 201), BUDGET_REPLANS);
    budget_planned(&w, &rule, 0);
    take(&w, 201);
    assert_int_equal(take(&w, 201), BUDGET_TURNS); /* expectations are not trusted any more */
    assert_int_equal(w.replans, 2);
}

/* 60 of 100 with 10 fragments: 16 are no more than twice as many. With 45 it is 22. */
static void room_for_much_more_wants_a_plan(void **state) {
    (void)state;
    budget_watch w = turning(10, 254);
    take(&w, 60);
    take(&w, 60);
    assert_int_equal(take(&w, 60), BUDGET_TURNS);
    assert_true(w.rule.level == 16);
    w = turning(10, 254);
    assert_int_equal(take(&w, 45), BUDGET_REPLANS);
    assert_true(w.rule.level == 22);
    w = turning(10, 254);
    w.replans = 2; /* expectations are not trusted any more */
    assert_int_equal(take(&w, 45), BUDGET_TURNS);
}

/* Where all was late something is run that turns nothing. Were it a slow moment, there is much room
 * then, after a while; that is asked less and less. */
static void what_was_late_is_weighed_again(void **state) {
    (void)state;
    budget_watch w = {.asked = 100};
    budget_planned(&w, NULL, 0);
    take(&w, 160);
    assert_int_equal(take(&w, 160), BUDGET_REPLANS);
    w.least_late = 1;
    for (unsigned times = 0; times < 3; times++) {
        budget_planned(&w, NULL, 0);
        for (unsigned frame = 1; frame < BUDGET_RECENT - 1 + (BUDGET_RECENT << times); frame++)
            assert_int_equal(take(&w, 79), BUDGET_STAYS);
        assert_int_equal(take(&w, 79), BUDGET_REPLANS);
        assert_true(!w.late && !w.least_late);
        budget_planned(&w, NULL, 0);
        for (unsigned frame = 0; frame < 100; frame++) /* no more than was done before */
            assert_int_equal(take(&w, 79), BUDGET_STAYS);
        assert_int_equal(take(&w, 1e3), BUDGET_STAYS);
        w.late = 1u << STRATA_PAYLOAD_HALF;
        take(&w, 90); /* no room in between */
        take(&w, 90);
        take(&w, 90);
        take(&w, 90);
    }
    budget_planned(&w, NULL, 0);
    for (unsigned frame = 0; frame < 100; frame++)
        assert_int_equal(take(&w, 81), BUDGET_STAYS);
    w = (budget_watch){.asked = 100, .least_late = 1}; /* nothing but the least was late */
    budget_planned(&w, NULL, 0);
    for (unsigned frame = 0; frame < 100; frame++)
        assert_int_equal(take(&w, 91), BUDGET_STAYS);
    for (unsigned frame = 0; frame < BUDGET_RECENT; frame++) /* three of four; a little will do */
        assert_int_equal(take(&w, 89), BUDGET_STAYS);
    assert_int_equal(take(&w, 89), BUDGET_REPLANS);
}

/* The last plan that is asked for is one that is in time. */
static void what_is_late_again_is_given_up_at_last(void **state) {
    (void)state;
    budget_watch w = {.asked = 100};
    int late = 1; /* in turns with what is in time */
    budget_planned(&w, NULL, 0);
    for (int frame = 0; frame < 5000; frame++)
        if (take(&w, late ? 200 : 50) == BUDGET_REPLANS) {
            late = !late;
            budget_planned(&w, NULL, 0);
        }
    assert_int_equal(late, 0);
    assert_true(w.late && w.weighed > 1);
}

/* A try that is late ends where it began. */
static void a_try_wants_no_plan(void **state) {
    (void)state;
    budget_watch w = turning(20, 254);
    for (int i = 0; i < 2; i++)
        assert_int_equal(take(&w, 96), BUDGET_STAYS);
    assert_int_equal(take(&w, 96), BUDGET_TURNS);
    assert_true(w.rule.level == 27);
    assert_int_equal(take(&w, 130), BUDGET_STAYS);
    assert_int_equal(take(&w, 130), BUDGET_TURNS);
    assert_true(w.rule.level == 20);
}

/* More may be kept than was expected: at the most there is, exact ways are weighed again, once, and
 * not where they were late. */
static void the_most_asks_for_exactness_once(void **state) {
    (void)state;
    budget_watch w = turning(8, 8);
    assert_int_equal(take(&w, 60), BUDGET_STAYS); /* once it is sure */
    assert_int_equal(take(&w, 60), BUDGET_STAYS);
    assert_int_equal(take(&w, 60), BUDGET_REPLANS);
    assert_int_equal(take(&w, 60), BUDGET_STAYS);
    assert_int_equal(w.replans, 1);
    w = turning(8, 8);
    w.late = 1;
    for (int frame = 0; frame < 9; frame++)
        assert_int_equal(take(&w, 60), BUDGET_STAYS);
    w = turning(8, 9);
    assert_int_equal(take(&w, 49), BUDGET_TURNS);
}

/* With 12 of 254 an exact way is expected to take as long: it is weighed there, and no more; nor
 * where it was late. */
static void what_costs_as_much_as_exactness_asks_for_it(void **state) {
    (void)state;
    const budget_rule rule = budget_begin(100, 1, 254, 8, 0);
    budget_watch w = {.asked = 100};
    budget_planned(&w, &rule, 12);
    for (int frame = 0; frame < 2; frame++)
        assert_int_equal(take(&w, 60), BUDGET_STAYS);
    assert_int_equal(take(&w, 60), BUDGET_TURNS);
    assert_true(w.rule.level == 12);
    assert_int_equal(take(&w, 104), BUDGET_STAYS); /* in time first */
    w.judged = 0;
    w.rule.settled_ms = 0;
    assert_int_equal(take(&w, 99), BUDGET_REPLANS);
    budget_planned(&w, &rule, 12);
    assert_true(w.rule.maximum == 254);
    w = (budget_watch){.asked = 100, .late = 1};
    budget_planned(&w, &rule, 12);
    assert_true(w.rule.maximum == 254);
    w = (budget_watch){.asked = 100, .replans = 8}; /* none is left to weigh it */
    budget_planned(&w, &rule, 12);
    assert_true(w.rule.maximum == 254);
    w = (budget_watch){.asked = 100};
    budget_planned(&w, &rule, 5); /* what was chosen is not taken back */
    assert_true(w.rule.maximum == 8 && w.rule.level == 8);
}

/* At the least there is nothing more to give; another plan may have something. No more than eight
 * are asked for. */
static void the_least_asks_for_other_plans(void **state) {
    (void)state;
    budget_watch w = turning(1, 8);
    int asked = 0;
    for (int frame = 0; frame < 30; frame++)
        asked += take(&w, 200) == BUDGET_REPLANS;
    assert_true(w.stuck && w.least_late);
    assert_int_equal(asked, 8);
    assert_int_equal(w.replans, 8);
    const budget_rule rule = budget_begin(100, 1, 8, 4, 0);
    budget_planned(&w, &rule, 0);
    assert_true(!w.stuck && w.least_late);
    assert_int_equal(take(&w, 100), BUDGET_STAYS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_is_given_up_for_lasting_lateness),
        cmocka_unit_test(what_is_met_is_the_mean_of_four),
        cmocka_unit_test(what_is_typical_is_the_median),
        cmocka_unit_test(a_knob_that_must_give_much_wants_a_plan),
        cmocka_unit_test(room_for_much_more_wants_a_plan),
        cmocka_unit_test(what_was_late_is_weighed_again),
        cmocka_unit_test(what_is_late_again_is_given_up_at_last),
        cmocka_unit_test(a_try_wants_no_plan),
        cmocka_unit_test(the_most_asks_for_exactness_once),
        cmocka_unit_test(what_costs_as_much_as_exactness_asks_for_it),
        cmocka_unit_test(the_least_asks_for_other_plans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
