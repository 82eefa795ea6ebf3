/* SPDX-License-Identifier: MIT
 *
 * host/plan/budget: the feedback rule on synthetic costs: how many frames it takes to come within
 * 15 % of the target, that it then stays, and that it ends at the best level there is.
 */
#include "plan/budget.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

/* Time at a level, in ms. */
typedef double curve(double level);
static double linear(double k) {
    return 2.0 * k;
}
static double affine(double k) {
    return 30.0 + 0.7 * k;
}
static double flat_then_steep(double k) {
    return 20.0 + 0.002 * k * k;
}
static double saturating(double k) { /* 40 fragments are all there are */
    return 15.0 + 1.2 * fmin(k, 40.0);
}
static double concave(double k) {
    return 10.0 * sqrt(k);
}
static double stairs(double k) { /* of powers of two, as sorting networks have */
    return 10.0 + 8.0 * ceil(log2(k + 1.0));
}

/* A share of -1 .. 1 that differs from frame to frame, always the same. */
static double noise(unsigned frame) {
    return (double)((frame * 2654435761u >> 16) % 2001) / 1000.0 - 1.0;
}

static const struct row {
    const char *name;
    curve *ms;
    double target, level;
} rows[] = {
    {"linear, from above", linear, 50, 254},
    {"linear, from below", linear, 50, 1},
    {"linear, at once", linear, 50, 25},
    {"affine, from above", affine, 50, 254},
    {"affine, from below", affine, 50, 1},
    {"affine, mostly fixed", affine, 34, 200},
    {"steep, from above", flat_then_steep, 40, 254},
    {"steep, from below", flat_then_steep, 40, 1},
    {"saturating, from above", saturating, 50, 254},
    {"saturating, just above", saturating, 60, 254},
    {"saturating, from below", saturating, 50, 1},
    {"concave, from above", concave, 50, 254},
    {"concave, from below", concave, 50, 1},
    {"stairs, from above", stairs, 50, 254},
    {"stairs, from below", stairs, 50, 1},
};

static void comes_within_ten_frames(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        for (int noisy = 0; noisy < 2; noisy++) {
            const struct row *row = &rows[i];
            budget_rule r = budget_begin(row->target, 1, 254, row->level);
            unsigned frame = 0;
            for (; frame < 10; frame++)
                budget_measure(&r, row->ms(r.level) * (1.0 + 0.08 * noisy * noise(frame)));
            const double ratio = row->ms(r.level) / row->target;
            const double off = 0.15 + 0.08 * noisy; /* what it sees is off by as much */
            if (!(ratio <= 1.0 + off && ratio >= 1.0 - off))
                fail_msg("%s%s: %g of the target at %g after ten frames", row->name,
                         noisy ? ", with noise" : "", ratio, r.level);
            const double level = r.level;
            for (; frame < 40 && !noisy; frame++)
                if (budget_measure(&r, row->ms(r.level)))
                    fail_msg("%s: leaves %g for %g", row->name, level, r.level);
        }
}

/* At 100 it takes 100 ms, of 50: the line through the origin gives 49 (0.98 of the target is aimed
 * at). There it takes 64.3, and the line through both, 0.7 ms a fragment, gives 27.1. */
static void steps_follow_the_lines(void **state) {
    (void)state;
    budget_rule r = budget_begin(50, 1, 254, 100);
    assert_int_equal(budget_measure(&r, affine(100)), 1);
    assert_true(r.level == 49);
    assert_int_equal(budget_measure(&r, affine(49)), 1);
    assert_true(r.level == 27);
    assert_int_equal(budget_measure(&r, affine(27)), 0); /* 48.9 */
}

static void ends_at_the_ends(void **state) {
    (void)state;
    budget_rule r = budget_begin(1, 1, 254, 100); /* nothing is fast enough */
    for (int frame = 0; frame < 20; frame++)
        budget_measure(&r, affine(r.level));
    assert_true(r.level == 1);
    r = budget_begin(1000, 1, 254, 3); /* everything is */
    for (int frame = 0; frame < 20; frame++)
        budget_measure(&r, affine(r.level));
    assert_true(r.level == 254);
    r = budget_begin(10, 4, 9, 100);
    assert_true(r.level == 9);
    r = budget_begin(10, 4, 9, 0);
    assert_true(r.level == 4);
}

/* No level is close: the last that fits is taken, and not left in turns. */
static double cliff(double k) {
    return k <= 6 ? 10.0 : 100.0;
}

static void stays_before_a_cliff(void **state) {
    (void)state;
    for (double begin = 1; begin <= 254; begin += 11) {
        budget_rule r = budget_begin(50, 1, 254, begin);
        int changes = 0;
        for (int frame = 0; frame < 20; frame++)
            budget_measure(&r, cliff(r.level));
        assert_true(r.level == 6);
        for (int frame = 0; frame < 50; frame++)
            changes += budget_measure(&r, cliff(r.level));
        assert_int_equal(changes, 0);
    }
}

/* Each fragment becomes three times as dear, then as cheap as before. */
static void follows_the_scene(void **state) {
    (void)state;
    budget_rule r = budget_begin(50, 1, 254, 20);
    for (int scene = 0; scene < 4; scene++) {
        const double dear = scene % 2 ? 3.0 : 1.0;
        for (int frame = 0; frame < 10; frame++)
            budget_measure(&r, dear * affine(r.level) * 0.5);
        const double ratio = dear * affine(r.level) * 0.5 / 50.0;
        if (!(ratio <= 1.15 && ratio >= 0.85))
            fail_msg("scene %d: %g of the target at %g", scene, ratio, r.level);
    }
}

/* Noise within the band changes nothing: to prepare anew costs more than it brings. */
static void small_changes_are_none(void **state) {
    (void)state;
    budget_rule r = budget_begin(50, 1, 254, 26);
    assert_int_equal(budget_measure(&r, 52), 0);
    r = budget_begin(50, 1, 254, 25);
    int changes = 0;
    for (unsigned frame = 0; frame < 200; frame++)
        changes += budget_measure(&r, linear(r.level) * (frame ? 1.0 + 0.1 * noise(frame) : 1.0));
    assert_int_equal(changes, 0);
}

/* The first frame after a change may be slow for reasons of its own. */
static void a_little_late_is_late_twice(void **state) {
    (void)state;
    budget_rule r = budget_begin(50, 1, 254, 25);
    assert_int_equal(budget_measure(&r, 60), 0);
    assert_int_equal(budget_measure(&r, 44), 0); /* 52, the mean */
    r = budget_begin(50, 1, 254, 25);
    assert_int_equal(budget_measure(&r, 60), 0);
    assert_int_equal(budget_measure(&r, 60), 1);
    r = budget_begin(50, 1, 254, 25);
    assert_int_equal(budget_measure(&r, 63), 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(comes_within_ten_frames),
        cmocka_unit_test(steps_follow_the_lines),
        cmocka_unit_test(ends_at_the_ends),
        cmocka_unit_test(stays_before_a_cliff),
        cmocka_unit_test(follows_the_scene),
        cmocka_unit_test(small_changes_are_none),
        cmocka_unit_test(a_little_late_is_late_twice),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
