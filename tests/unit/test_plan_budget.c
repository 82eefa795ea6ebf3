/* SPDX-License-Identifier: MIT
 *
 * host/plan under a budget of time: exact where that is expected to fit, else as many of the
 * nearest fragments as fit, else what comes closest; and what is named, set or asked for beside it.
 */
#include "unit/plan_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* 1,000 fragments over 100 pixels, 10 deep; a fragment takes 1 us, so that 1,000 units are 1 ms.
 * abuffer + ppc: 4. kplus + ppc: 1 + k / 10. slowk + ppc: 5 + k / 10. pass: 0.16 and 0.634 for each
 * layer. */
#define US  .ns = 1000
#define SET "surface kplus slowk abuffer ppc over"

static void what_fits_is_taken(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *order;
        double nearest; /* of what is turned, 0: nothing is */
        const char *warning;
    } rows[] = {
        {{FOR(SET, "b"), US, .budget = 4}, "abuffer ppc", 0, NULL},
        {{FOR(SET, "b"), US, .budget = 3.85}, "abuffer ppc", 0, NULL}, /* by little */
        {{FOR(SET, "b"), US, .budget = 3.6}, "kplus ppc", 10, NULL},
        {{FOR(SET, "b"), US, .budget = 1.55}, "kplus ppc", 5, NULL},
        {{FOR(SET, "b"), US, .budget = 1.1}, "kplus ppc", 1, NULL},
        {{FOR(SET, "b"), US, .budget = 1.05}, "kplus ppc", 1, "not expected to meet"},
        {{FOR(SET, "b"), US, .budget = 1.05, .beside = 1}, "kplus ppc", 1, "not expected to meet"},
        {{FOR(SET, "b"), US, .budget = 3.55, .beside = 2}, "kplus ppc", 5, NULL},
        {{FOR(SET, "b"), US, .budget = 100, .late = 1}, "kplus ppc", 10, NULL},
        /* nothing was measured: exact first, and then the frames tell */
        {{FOR(SET, "b"), .budget = 0.001}, "abuffer ppc", 0, NULL},
        {{FOR(SET, "b"), .budget = 0.001, .late = 1}, "kplus ppc", 10, NULL},
        /* layers are fragments kept, too */
        {{FOR("abuffer ppc pass over", "b"), US, .budget = 3.6}, "pass", 5, NULL},
        {{FOR("abuffer ppc pass over", "b"), US, .budget = 2}, "pass", 2, NULL},
        {{FOR("abuffer kplus ppc pass over", "b"), US, .budget = 2}, "kplus ppc", 10, NULL},
        {{FOR("pass over", "bd"), US, .budget = 35.1}, "pass", 55, NULL},
        {{FOR("pass over", "bd"), US, .budget = 35.6}, "pass", 55, NULL},
        {{FOR("pass over", "bd"), US, .budget = 35.7}, "pass", 56, NULL},
        /* the last resort */
        {{FOR("abuffer ppc wboit over", "b"), US, .budget = 1},
         "wboit",
         0,
         "no bound of its error"},
        {{FOR("abuffer ppc unit over", "b"), US, .budget = 1},
         "abuffer ppc",
         0,
         "not expected to meet"},
        {{FOR("abuffer ppc wboit unit over", "b"), US, .budget = 1},
         "wboit",
         0,
         "no bound of its error"},
        {{FOR("abuffer ppc wboit over", "b"), US, .budget = 4}, "abuffer ppc", 0, NULL},
        {{FOR("slowk ppc wboit over", "b"), US, .budget = 3},
         "slowk ppc",
         1,
         "not expected to meet"},
        {{FOR("slowk ppc wboit over", "b"), US, .budget = 3, .least_late = 1},
         "wboit",
         0,
         "no bound of its error"},
        {{FOR("abuffer ppc over", "b"), US, .budget = 1}, "abuffer ppc", 0, "not expected to meet"},
        {{FOR("abuffer ppc wboit over", "b"), US, .budget = 2, .use = "wboit"}, "wboit", 0, NULL},
        /* what runs beside the fold takes its share: 9 to filter, and objects that are culled for
         * 10 save 20.5 of 40 */
        {{FOR("abuffer kplus ppc blur over", "b"), US, .budget = 13, .samples = 4},
         "abuffer ppc blur",
         0,
         NULL},
        {{FOR("abuffer kplus ppc blur over", "b"), US, .budget = 12, .samples = 4},
         "kplus ppc blur",
         10,
         NULL},
        {{FOR("abuffer kplus ppc blur over", "b"), US, .budget = 10.55, .samples = 4},
         "kplus ppc blur",
         5,
         NULL},
        {{FOR("wboit blur over", "b"), US, .budget = 10.2, .samples = 4, .use = "wboit"},
         "wboit blur",
         0,
         NULL},
        {{FOR("fuser wboit blur over", "b"), US, .budget = 1, .samples = 4},
         "fuser",
         0,
         "not expected to meet"},
        {{FOR("cull painter abuffer kplus ppc over", "obc"), US, .budget = 34},
         "cull painter abuffer ppc",
         0,
         NULL},
        {{FOR("cull painter abuffer kplus ppc over", "obc"), US, .budget = 34, .use = "cull"},
         "cull painter abuffer ppc",
         0,
         NULL},
        {{FOR("painter abuffer kplus ppc over", "obc"), US, .budget = 34},
         "painter kplus ppc",
         1,
         "not expected to meet"},
        /* what is asked for beside it */
        {{FOR(SET, "b"), US, .budget = 5.3, .use = "slowk"}, "slowk ppc", 3, NULL},
        {{FOR(SET, "b"), US, .budget = 1.5, .use = "abuffer"},
         "abuffer ppc",
         0,
         "not expected to meet"},
        {{FOR(SET, "b"), US, .budget = 1.5, .settings = {"kplus.k=2"}},
         "abuffer ppc",
         0,
         "not expected to meet"},
        {{FOR(SET, "b"), US, .budget = 1.5, .deep = 1}, "abuffer ppc", 0, NULL},
        {{FOR(SET, "b"), .use = "kplus", .settings = {"kplus.k=0"}, .deep = 1},
         "kplus ppc",
         0,
         NULL},
        {{FOR(SET, "b"), US, .budget = 1.05, .tolerance = 0.01}, "kplus ppc", 0, NULL},
        {{FOR(SET, "o"), US, .budget = 1}, "surface", 0, NULL},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        if (strcmp(order_of(p), rows[i].order) != 0 || plan_turned(p) != rows[i].nearest)
            fail_msg("row %zu: '%s' at %g, not '%s' at %g", i, order_of(p), plan_turned(p),
                     rows[i].order, rows[i].nearest);
        const char *warning = p->warning_count ? p->warnings[0] : NULL;
        if (!warning != !rows[i].warning || (warning && !strstr(warning, rows[i].warning)))
            fail_msg("row %zu: warning '%s'", i, warning ? warning : "none");
        plan_free(p);
    }
}

/* Each costs what its coefficients say, and what is `measured` in another form ("ppc.half") what it
 * says here: abuffer + ppc 1.5 in place of 4, packk + ppc 0.5 + k / 10 in place of 2 + k / 10, and
 * thin 3 in place of 6. In units of 20 us. */
static void measure_all(costs *c, const kit *k, const char *measured) {
    static const struct {
        const char *id;
        double fragment, packed;
    } rows[] = {
        {"abuffer", 3, 0.5}, {"ppc", 1, 1}, {"kplus", 1, 1}, {"packk", 2, 0.5}, {"thin", 6, 3}};
    *c = (costs){0};
    for (size_t i = 0; i < BASE_COUNT(rows); i++)
        for (uint32_t payload = 0; payload < COSTS_PAYLOADS; payload++) {
            const costs_form form = {.payload = payload};
            const double x[COSTS_TERMS] = {[COSTS_FRAGMENT] =
                                               payload ? rows[i].packed : rows[i].fragment};
            char name[COSTS_NAME];
            costs_name(kit_technique(k, rows[i].id), form, name);
            if (payload == 0 || strstr(measured, name))
                kit_measure(k, c, rows[i].id, form, x, 20, 0);
        }
    costs_fit(c, (const modules_note *const *)k->list, k->count);
}

static void payloads_are_traded_where_they_were_measured(void **state) {
    (void)state;
#define HALVES "abuffer.half ppc.half packk.half thin.half"
    static const struct {
        const char *installed, *scene, *setting, *measured;
        double budget; /* in units */
        uint32_t late;
        const char *order;
        uint32_t payload;
        double nearest;
    } rows[] = {
        /* all of them as half are closer than nine in ten; but not where the ninth hides the tenth
         */
        {"abuffer kplus ppc", "b", "", HALVES, 4.1, 0, "abuffer ppc", STRATA_PAYLOAD_FLOAT, 0},
        {"abuffer kplus ppc", "b", "", HALVES, 1.95, 0, "abuffer ppc", STRATA_PAYLOAD_HALF, 0},
        {"abuffer kplus ppc", "bn", "", HALVES, 1.95, 0, "kplus ppc", STRATA_PAYLOAD_FLOAT, 9},
        {"abuffer kplus ppc", "b", "", HALVES, 1.35, 0, "kplus ppc", STRATA_PAYLOAD_FLOAT, 3},
        {"abuffer kplus ppc", "b", "", "ppc.half", 1.95, 0, "kplus ppc", STRATA_PAYLOAD_FLOAT, 9},
        {"abuffer kplus ppc", "b", "", "abuffer.half", 1.95, 0, "kplus ppc", STRATA_PAYLOAD_FLOAT,
         9},
        {"abuffer kplus ppc", "b", "abuffer.payload=float", HALVES, 1.95, 0, "kplus ppc",
         STRATA_PAYLOAD_FLOAT, 9},
        {"abuffer kplus ppc", "b", "abuffer.payload=half", HALVES, 1.95, 0, "abuffer ppc",
         STRATA_PAYLOAD_HALF, 0},
        {"abuffer kplus ppc", "b", "", HALVES, 0, 0, "abuffer ppc", STRATA_PAYLOAD_FLOAT,
         0}, /* none */
        /* with a payload more are kept */
        {"packk ppc", "b", "", HALVES, 2.45, 0, "packk ppc", STRATA_PAYLOAD_HALF, 10},
        {"packk ppc", "b", "", HALVES, 1.25, 0, "packk ppc", STRATA_PAYLOAD_HALF, 7},
        /* a quantum of unorm8 counts for each fragment that shows: little glass, or much */
        {"abuffer kplus ppc", "bn", "", "abuffer.unorm8 ppc.unorm8", 1.65, 0, "kplus ppc",
         STRATA_PAYLOAD_FLOAT, 6},
        {"abuffer kplus ppc", "b", "", "abuffer.unorm8 ppc.unorm8", 1.95, 0, "abuffer ppc",
         STRATA_PAYLOAD_UNORM8, 0},
        {"abuffer kplus ppc", "bg", "", "abuffer.unorm8 ppc.unorm8", 1.95, 0, "kplus ppc",
         STRATA_PAYLOAD_FLOAT, 9},
        /* streams have payloads, too; what is too deep for one is not */
        {"abuffer ppc thin", "b", "", "thin.half", 3.5, 0, "thin", STRATA_PAYLOAD_HALF, 0},
        {"abuffer kplus ppc thin", "bd", "", "thin.half", 3.5, 1, "kplus ppc", STRATA_PAYLOAD_FLOAT,
         64},
        /* what was late in one precision may fit in the next */
        {"abuffer ppc", "b", "", HALVES, 4.5, 1, "abuffer ppc", STRATA_PAYLOAD_HALF, 0},
        {"abuffer kplus ppc", "b", "", HALVES, 1.95, 3, "kplus ppc", STRATA_PAYLOAD_FLOAT, 9},
        {"abuffer ppc", "b", "", HALVES, 4.5, 3, "abuffer ppc", STRATA_PAYLOAD_FLOAT, 0},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        costs c;
        char installed[96];
        kit_make(&k, "abuffer ppc kplus packk thin over");
        measure_all(&c, &k, rows[i].measured);
        snprintf(installed, sizeof installed, "%s over", rows[i].installed);
        const request r = {FOR(installed, rows[i].scene), .costs = &c, .late = rows[i].late,
                           .settings = {rows[i].setting[0] ? rows[i].setting : NULL},
                           .budget = rows[i].budget * 1000 * 20e-6};
        plan *p = get(&r, &k, &d);
        if (strcmp(order_of(p), rows[i].order) != 0 || plan_turned(p) != rows[i].nearest ||
            p->payload.precision != rows[i].payload)
            fail_msg("row %zu: '%s' at %g with payload %u", i, order_of(p), plan_turned(p),
                     p->payload.precision);
        const char *reason = reason_of(p, p->techniques[0].technique->id);
        assert_int_equal(strstr(reason, "payload half") != NULL,
                         rows[i].payload == STRATA_PAYLOAD_HALF);
        assert_int_equal(strstr(reason, "payload unorm8") != NULL,
                         rows[i].payload == STRATA_PAYLOAD_UNORM8);
        plan_free(p);
        costs_free(&c);
    }
}

/* kplus takes 1 + k / 20, ppc 1, in units of 20 us; with `at` kept it was measured to take `off`
 * times that. */
static void measure_bent(costs *c, const kit *k, double at, double off) {
    static const double one[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1},
                        rising[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1, [COSTS_KEPT] = 0.5};
    strata_scene_stats stats;
    demand d;
    double terms[COSTS_TERMS];
    kit_scene("b", &d, &stats);
    *c = (costs){0};
    kit_measure(k, c, "kplus", (costs_form){0}, rising, 20, 0);
    kit_measure(k, c, "ppc", (costs_form){0}, one, 20, 0);
    for (double keeps = 1; keeps <= 10; keeps++) {
        costs_terms(kit_technique(k, "kplus"), &stats, keeps, terms);
        const double ms = costs_sum(rising, terms) * 20e-6;
        assert_true(costs_add(c, "kplus", terms, keeps == at ? ms * off : ms));
    }
    costs_fit(c, (const modules_note *const *)k->list, k->count);
}

/* One of the times is off: what fits rises with the budget all the same, and no budget is left far
 * from used up. */
static void more_never_costs_less(void **state) {
    (void)state;
    static const struct { double at, off; } rows[] = {{1, 1.5}, {3, 1.5}, {9, 0.6}, {5, 1}};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        double last = 0, last_ms = 0;
        for (int step = 0; step < 40; step++) {
            kit k;
            demand d;
            costs c;
            kit_make(&k, "kplus ppc over");
            measure_bent(&c, &k, rows[i].at, rows[i].off);
            const double budget = 0.02 + 0.001 * step;
            const request r = {FOR("kplus ppc over", "b"), .costs = &c, .budget = budget};
            plan *p = get(&r, &k, &d);
            assert_true(plan_turned(p) >= last && p->ms >= last_ms);
            assert_true(p->warning_count || p->ms <= budget * (1 + 1e-9));
            last = plan_turned(p);
            last_ms = p->ms;
            plan_free(p);
            costs_free(&c);
        }
    }
}

/* kplus + ppc take 1.4 + k / 10, abuffer + ppc as half 1.6, and as float `whole`. */
static void all_is_not_given_up_for_little(void **state) {
    (void)state;
    static const struct {
        double whole, budget;
        uint32_t late;
        const char *order;
        uint32_t payload;
        double keeps;
        const char *setting;
    } rows[] = {
        {4, 1.51, 0, "kplus ppc", STRATA_PAYLOAD_FLOAT, 1, NULL},  /* it fits */
        {4, 1.47, 0, "abuffer ppc", STRATA_PAYLOAD_HALF, 0, NULL}, /* 1.6 of 1.5, and not late */
        {4, 1.44, 0, "kplus ppc", STRATA_PAYLOAD_FLOAT, 1, NULL},  /* it would be */
        {4, 1.47, 2, "kplus ppc", STRATA_PAYLOAD_FLOAT, 1, NULL},
        {1.61, 1.47, 0, "abuffer ppc", STRATA_PAYLOAD_FLOAT, 0, NULL},
        {1.61, 1.47, 1, "abuffer ppc", STRATA_PAYLOAD_HALF, 0, NULL},
        {1.66, 1.499, 0, "abuffer ppc", STRATA_PAYLOAD_HALF, 0, NULL}, /* 1.11 times as much */
        {1.61, 1.47, 0, "abuffer ppc", STRATA_PAYLOAD_FLOAT, 0, "abuffer.payload=float"},
        {1.61, 1.47, 1, "kplus ppc", STRATA_PAYLOAD_FLOAT, 1, "abuffer.payload=float"},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const double one[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1},
                     most[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1.4},
                     less[COSTS_TERMS] = {[COSTS_FRAGMENT] = 0.6},
                     whole[COSTS_TERMS] = {[COSTS_FRAGMENT] = rows[i].whole - 1};
        const costs_form all = {0}, half = {.payload = STRATA_PAYLOAD_HALF};
        kit k;
        demand d;
        costs c = {0};
        kit_make(&k, "abuffer kplus ppc wboit over");
        kit_measure(&k, &c, "kplus", all, most, 20, 0);
        kit_measure(&k, &c, "ppc", all, one, 20, 0);
        kit_measure(&k, &c, "abuffer", all, whole, 20, 0);
        kit_measure(&k, &c, "wboit", all, one, 20, 0); /* has no bound */
        kit_measure(&k, &c, "ppc", half, one, 20, 0);
        kit_measure(&k, &c, "abuffer", half, less, 20, 0);
        costs_fit(&c, (const modules_note *const *)k.list, k.count);
        const request r = {FOR("abuffer kplus ppc wboit over", "b"), .costs = &c,
                           .late = rows[i].late, .settings = {rows[i].setting},
                           .budget = rows[i].budget * 1000 * 20e-6};
        plan *p = get(&r, &k, &d);
        if (strcmp(order_of(p), rows[i].order) != 0 || plan_turned(p) != rows[i].keeps ||
            p->payload.precision != rows[i].payload)
            fail_msg("row %zu: '%s' at %g with payload %u", i, order_of(p), plan_turned(p),
                     p->payload.precision);
        plan_free(p);
        costs_free(&c);
    }
}

/* Halves do for a tolerance of 0.005, and floats where those were measured to take no longer. */
static void a_tolerance_takes_what_costs_less(void **state) {
    (void)state;
    static const struct {
        double whole, half; /* of abuffer, in units; 0: not measured */
        const char *setting;
        uint32_t payload;
    } rows[] = {{4, 2, NULL, STRATA_PAYLOAD_HALF},
                {2, 4, NULL, STRATA_PAYLOAD_FLOAT},
                {2, 0, NULL, STRATA_PAYLOAD_HALF},
                {2, 4, "abuffer.payload=half", STRATA_PAYLOAD_HALF}};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const double one[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1},
                     whole[COSTS_TERMS] = {[COSTS_FRAGMENT] = rows[i].whole},
                     less[COSTS_TERMS] = {[COSTS_FRAGMENT] = rows[i].half};
        const costs_form all = {0}, half = {.payload = STRATA_PAYLOAD_HALF},
                         coarse = {.payload = STRATA_PAYLOAD_UNORM8}; /* too coarse */
        kit k;
        demand d;
        costs c = {0};
        kit_make(&k, "abuffer ppc over");
        kit_measure(&k, &c, "ppc", coarse, one, 20, 0);
        kit_measure(&k, &c, "abuffer", coarse, one, 20, 0);
        kit_measure(&k, &c, "ppc", all, one, 20, 0);
        kit_measure(&k, &c, "ppc", half, one, 20, 0);
        kit_measure(&k, &c, "abuffer", all, whole, 20, 0);
        if (rows[i].half > 0)
            kit_measure(&k, &c, "abuffer", half, less, 20, 0);
        costs_fit(&c, (const modules_note *const *)k.list, k.count);
        const request r = {FOR("abuffer ppc over", "b"), .costs = &c, .tolerance = 0.005,
                           .settings = {rows[i].setting}};
        plan *p = get(&r, &k, &d);
        if (p->payload.precision != rows[i].payload)
            fail_msg("row %zu: payload %u", i, p->payload.precision);
        plan_free(p);
        costs_free(&c);
    }
}

/* kplus takes 3 for a fragment, occupancy 1, and would hide 87 %. What kplus takes then was
 * measured, or not; it counts in place of what is expected, and in what the whole will take. */
static void hiding_pays_as_measured(void **state) {
    (void)state;
    static const struct {
        double clipped;   /* 0: not measured */
        double tolerance; /* frames with a certificate take other times */
        int measured, pays;
        double taken; /* by kplus, for what occupancy takes */
    } rows[] = {{0, 0, 0, 1, 3},
                {1.5, 0, 1, 1, 1.5},
                {1.8, 0, 1, 0, 0},
                {4, 0, 1, 0, 0},
                {1.5, 0.01, 0, 0, 0}};
    static const double three[COSTS_TERMS] = {[COSTS_FRAGMENT] = 3},
                        one[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        costs c = {0};
        kit_make(&k, "occupancy kplus ppc over");
        const double some[COSTS_TERMS] = {[COSTS_FRAGMENT] = rows[i].clipped};
        kit_measure(&k, &c, "kplus", (costs_form){0}, three, 20, 0);
        kit_measure(&k, &c, "ppc", (costs_form){0}, one, 20, 0);
        kit_measure(&k, &c, "occupancy", (costs_form){0}, one, 20, 0);
        if (rows[i].clipped > 0)
            kit_measure(&k, &c, "kplus", (costs_form){.clipped = 1}, some, 20, 0);
        costs_fit(&c, (const modules_note *const *)k.list, k.count);
        const request r = {FOR("occupancy kplus ppc over", "bh"), .costs = &c, .budget = 1,
                           .tolerance = rows[i].tolerance};
        plan *p = get(&r, &k, &d);
        const char *reason = reason_of(p, "occupancy");
        assert_int_equal(strstr(reason, "as measured") != NULL, rows[i].measured);
        assert_string_equal(order_of(p), rows[i].pays ? "occupancy kplus ppc" : "kplus ppc");
        assert_int_equal(p->clipped, rows[i].pays);
        if (rows[i].pays)
            assert_true(fabs(plan_find(p, "kplus")->cost / plan_find(p, "occupancy")->cost -
                             rows[i].taken) < 0.01);
        plan_free(p);
        costs_free(&c);
    }
}

static void turning_follows(void **state) {
    (void)state;
    kit k;
    demand d;
    const request r = {FOR(SET, "b"), US, .budget = 1.55};
    plan *p = get(&r, &k, &d);
    assert_true(p->turned_least == 1 && p->turned_most == 10 && p->nearest == 5);
    assert_true(p->ms > 1.499 && p->ms < 1.501);
    assert_non_null(strstr(reason_of(p, "kplus"), "for the budget of 1.55 ms it begins with the "
                                                  "nearest 5 of up to 10 fragments a pixel"));
    plan_turn(p, 3);
    assert_true(plan_turned(p) == 3 && p->nearest == 3);
    assert_true(plan_find(p, "kplus")->settings.values[0] == 3);
    plan_free(p);
}

/* Layers take 0.63 ms each, all at once 4: with seven there may be more to have. With lists that
 * cost more than any number that is kept there is not, nor where nothing keeps all. */
static void where_exactness_costs_no_more_is_told(void **state) {
    (void)state;
    static const struct {
        request r;
        double from;
    } rows[] = {{{FOR("abuffer ppc pass over", "b"), US, .budget = 3.6}, 7},
                {{FOR(SET, "b"), US, .budget = 1.55}, 0},
                {{FOR("slowk ppc over", "b"), US, .budget = 5.3}, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        assert_true(p->turned && p->turned_exact == rows[i].from);
        plan_free(p);
    }
}

static void is_near(double value, double expected) {
    if (!(fabs(value - expected) <= 1e-9 * expected))
        fail_msg("%.12g, not %.12g", value, expected);
}

/* 1 + k / 10 ms, a thousand units each. */
static void expectations_turn_with_the_knob(void **state) {
    (void)state;
    kit k;
    demand d;
    const request five = {FOR(SET, "b"), US, .budget = 1.55},
                  ten = {FOR(SET, "b"), US, .budget = 3.6};
    plan *p = get(&five, &k, &d);
    is_near(p->turned_each, 100);
    plan_turn(p, 3);
    is_near(p->cost, 1300);
    is_near(p->ms, 1.3);
    plan *later = get(&ten, &k, &d);
    later->ms *= 2;
    later->turned_each /= 2;
    plan_turn(p, 10);
    const modules_technique_note *turned = p->turned;
    p->turned = NULL;
    p->stats.largest_depth = 7;
    plan_expect(p, later);
    assert_true(p->turned == turned && p->stats.largest_depth == 10);
    is_near(p->cost, 2000);
    is_near(p->ms, 4);
    plan_turn(p, 5);
    is_near(p->ms, 3.5);
    plan_free(later);
    plan_free(p);
}

static void exact_ways_say_whether_they_fit(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *words;
    } rows[] = {
        {{FOR(SET, "b"), US, .budget = 5}, "the budget of 5 ms is expected to be met"},
        {{FOR("abuffer ppc over", "b"), US, .budget = 1},
         "the budget of 1 ms is expected to be missed"},
        {{FOR(SET, "b"), .budget = 5}, "whether the budget of 5 ms is met is not known yet"},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        if (!strstr(reason_of(p, "abuffer"), rows[i].words))
            fail_msg("row %zu: '%s'", i, reason_of(p, "abuffer"));
        plan_free(p);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_fits_is_taken),
        cmocka_unit_test(payloads_are_traded_where_they_were_measured),
        cmocka_unit_test(more_never_costs_less),
        cmocka_unit_test(all_is_not_given_up_for_little),
        cmocka_unit_test(a_tolerance_takes_what_costs_less),
        cmocka_unit_test(hiding_pays_as_measured),
        cmocka_unit_test(turning_follows),
        cmocka_unit_test(where_exactness_costs_no_more_is_told),
        cmocka_unit_test(expectations_turn_with_the_knob),
        cmocka_unit_test(exact_ways_say_whether_they_fit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
