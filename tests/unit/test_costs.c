/* SPDX-License-Identifier: MIT
 *
 * host/plan/costs: the fit to points whose coefficients are known, what few or useless points leave
 * of the modules' own, terms of what keeps the nearest, and files that are not to be believed.
 */
#define _GNU_SOURCE /* mkdtemp */
#include "unit/plan_fixture.h"

#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#define FORM ((costs_form){0})

static kit k;

static const modules_technique_note *note(const char *id) {
    return kit_technique(&k, id);
}

static void fit(costs *c) {
    costs_fit(c, (const modules_note *const *)k.list, k.count);
}

static int near(double a, double b, double share) {
    return fabs(a - b) <= share * fabs(b);
}

/* ---- terms ----------------------------------------------------------------------------------- */

static void terms_say_what_there_is_to_do(void **state) {
    (void)state;
    const strata_scene_stats stats = {.width = 10,
                                      .height = 10,
                                      .covered_pixels = 20,
                                      .mean_depth = 15,
                                      .largest_depth = 40,
                                      .transparent_fragments = 300,
                                      .transparent_triangles = 7,
                                      .opaque_triangles = 5};
    static const struct {
        const char *id;
        double nearest, pixels, fragments, depth, triangles, kept;
    } rows[] = {
        {"abuffer", 0, 20, 300, 40, 7, 0},   {"kplus", 0, 20, 300, 40, 7, 300},
        {"kplus", 4, 20, 300, 4, 7, 80},     {"kplus", 64, 20, 300, 40, 7, 300},
        {"peel", 3, 20, 300, 3, 7, 60},      {"ppc", 0, 20, 300, 40, 0, 0},
        {"ppc", 4, 20, 80, 4, 0, 0}, /* what was kept is all that it sees */
        {"occupancy", 4, 20, 300, 40, 7, 0}, {"surface", 4, 100, 0, 40, 5, 0},
    };
    kit_make(&k, ALL);
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        double t[COSTS_TERMS];
        costs_terms(note(rows[i].id), &stats, rows[i].nearest, t);
        if (t[COSTS_FRAME] != 1 || t[COSTS_PIXEL] != rows[i].pixels ||
            t[COSTS_FRAGMENT] != rows[i].fragments || t[COSTS_DEPTH] != rows[i].depth ||
            t[COSTS_TRIANGLE] != rows[i].triangles || t[COSTS_KEPT] != rows[i].kept ||
            t[COSTS_DEPTH_PIXEL] != rows[i].depth * rows[i].pixels)
            fail_msg("row %zu, %s: pixels %g, fragments %g, depth %g, triangles %g, kept %g", i,
                     rows[i].id, t[COSTS_PIXEL], t[COSTS_FRAGMENT], t[COSTS_DEPTH],
                     t[COSTS_TRIANGLE], t[COSTS_KEPT]);
    }
}

/* ---- the fit --------------------------------------------------------------------------------- */

static void measure(costs *c, const char *id, const double x[COSTS_TERMS], uint32_t points,
                    double noise) {
    kit_measure(&k, c, id, FORM, x, points, noise);
}

/* Two techniques say what the unit is, for theirs are the module's coefficients. */
static void measure_others(costs *c) {
    double x[COSTS_TERMS];
    assert_true(costs_of_module(note("abuffer"), x));
    measure(c, "abuffer", x, 20, 0);
    assert_true(costs_of_module(note("peel"), x));
    measure(c, "peel", x, 20, 0);
}

static void known_coefficients_are_recovered(void **state) {
    (void)state;
    static const double truth[COSTS_TERMS] = {
        [COSTS_FRAME] = 50000, [COSTS_PIXEL] = 3, [COSTS_FRAGMENT] = 1.5, [COSTS_KEPT] = 2.5};
    kit_make(&k, ALL);
    for (int noisy = 0; noisy < 2; noisy++) {
        costs c = {0};
        double x[COSTS_TERMS], terms[COSTS_TERMS];
        measure_others(&c);
        measure(&c, "kplus", truth, 44, noisy ? 0.1 : 0);
        fit(&c);
        assert_true(near(c.ns, 20, 1e-6));
        assert_int_equal(costs_of(&c, note("kplus"), FORM, x), 44);
        for (int i = 0; i < COSTS_TERMS; i++)
            if (x[i] < 0 || (!noisy && truth[i] > 0 && !near(x[i], truth[i], 0.03)))
                fail_msg("coefficient %d is %g, not %g", i, x[i], truth[i]);
        /* What matters is what is predicted, here of a scene and k that were not measured. */
        const strata_scene_stats stats = kit_sizes(52);
        costs_terms(note("kplus"), &stats, 11, terms);
        assert_true(near(costs_sum(x, terms), costs_sum(truth, terms), noisy ? 0.1 : 0.01));
        costs_free(&c);
    }
}

/* One point scales the module's coefficients; what no point says anything of stays. */
static void one_point_scales(void **state) {
    (void)state;
    double module[COSTS_TERMS], x[COSTS_TERMS], terms[COSTS_TERMS];
    costs c = {0};
    kit_make(&k, ALL " pass");
    measure_others(&c);
    const strata_scene_stats stats = kit_sizes(3);
    assert_true(costs_of_module(note("pass"), module));
    costs_terms(note("pass"), &stats, 0, terms);
    assert_true(costs_add(&c, "pass", terms, 3.0 * 20e-6 * costs_sum(module, terms)));
    fit(&c);
    assert_int_equal(costs_of(&c, note("pass"), FORM, x), 1);
    for (int i = 0; i < COSTS_TERMS; i++)
        if (!near(x[i], 3.0 * module[i], 1e-6))
            fail_msg("coefficient %d is %g, not %g", i, x[i], 3.0 * module[i]);
    costs_free(&c);
}

/* Two points that no coefficients explain: each is expected where it was measured. */
static void what_was_measured_is_expected_there(void **state) {
    (void)state;
    double x[COSTS_TERMS], terms[3][COSTS_TERMS];
    costs c = {0};
    kit_make(&k, ALL);
    measure_others(&c);
    for (uint32_t i = 0; i < 3; i++) {
        const strata_scene_stats stats = {.covered_pixels = 1000,
                                          .mean_depth = 10,
                                          .largest_depth = 10,
                                          .transparent_fragments = 10000 * (i == 2 ? 1e4 : 1 + i)};
        costs_terms(note("ppc"), &stats, 0, terms[i]);
    }
    assert_true(costs_add(&c, "ppc", terms[0], 2.0) && costs_add(&c, "ppc", terms[1], 1.0));
    fit(&c);
    assert_int_equal(costs_of(&c, note("ppc"), FORM, x), 2);
    for (int i = 0; i < 2; i++)
        assert_true(
            near(costs_expect(&c, note("ppc"), FORM, x, terms[i]) * c.ns * 1e-6, 2.0 - i, 1e-9));
    assert_true(
        near(costs_expect(&c, note("ppc"), FORM, x, terms[2]), costs_sum(x, terms[2]), 1e-6));
    costs_free(&c);
}

/* Most say that a fragment takes 20 ns, and the one that is a fragment 35. */
static void the_unit_says_what_it_is(void **state) {
    (void)state;
    const double x[COSTS_TERMS] = {[COSTS_FRAGMENT] = 35.0 / 20.0};
    costs c = {0};
    kit_make(&k, ALL " unit");
    measure_others(&c);
    measure(&c, "unit", x, 3, 0);
    fit(&c);
    assert_true(near(c.ns, 35, 1e-6));
    assert_false(costs_is_unit(note("ppc"))); /* as dear, and exact */
    costs_free(&c);
}

static void useless_points_stay_finite(void **state) {
    (void)state;
    double x[COSTS_TERMS], terms[COSTS_TERMS] = {0};
    costs c = {0};
    kit_make(&k, ALL);
    assert_int_equal(costs_of(NULL, note("abuffer"), FORM, x), 0);
    fit(&c); /* none */
    assert_true(c.ns == 0);
    assert_false(costs_add(&c, "abuffer", terms, 0.0));
    assert_false(costs_add(&c, "abuffer", terms, -1.0));
    assert_false(costs_add(&c, "abuffer", terms, NAN));
    assert_false(costs_add(&c, "abuffer", terms, INFINITY));
    terms[COSTS_PIXEL] = NAN;
    assert_false(costs_add(&c, "abuffer", terms, 1.0));
    terms[COSTS_PIXEL] = -1;
    assert_false(costs_add(&c, "abuffer", terms, 1.0));
    assert_int_equal(c.count, 0);
    /* No work at all, and yet a time; then work of any size. */
    terms[COSTS_PIXEL] = 0;
    assert_true(costs_add(&c, "abuffer", terms, 1.0));
    fit(&c);
    for (int scale = -300; scale <= 300; scale += 50) {
        for (int i = 0; i < COSTS_TERMS; i++)
            terms[i] = pow(10.0, scale);
        costs_add(&c, "abuffer", terms, 1e-3);
        costs_add(&c, "unheard_of", terms, 1e-3);
        fit(&c);
        assert_true(costs_of(&c, note("abuffer"), FORM, x) >= 0);
        for (int i = 0; i < COSTS_TERMS; i++)
            assert_true(isfinite(x[i]) && x[i] >= 0);
        assert_true(isfinite(c.ns));
    }
    costs_free(&c);
}

static void equal_terms_share_a_point(void **state) {
    (void)state;
    costs c = {0};
    double terms[COSTS_TERMS] = {1, 10};
    for (int i = 0; i < 4; i++)
        assert_true(costs_add(&c, "ppc", terms, 1.0 + i));
    assert_int_equal(c.techniques[0].count, 1);
    assert_true(near(c.techniques[0].points[0].ms, 2.5, 1e-12));
    for (uint32_t i = 0; i < 2 * COSTS_MOST_POINTS; i++) {
        terms[COSTS_PIXEL] = 11 + i;
        assert_true(costs_add(&c, "ppc", terms, 1.0));
    }
    assert_int_equal(c.techniques[0].count, COSTS_MOST_POINTS); /* the latest */
    assert_true(c.techniques[0].points[0].terms[COSTS_PIXEL] == 11 + COSTS_MOST_POINTS);
    costs_free(&c);
}

/* ---- the plan -------------------------------------------------------------------------------- */

/* A technique is another where it works in another form, but for what does not touch it. */
static void forms_have_names(void **state) {
    (void)state;
    static const struct {
        const char *id;
        costs_form form;
        const char *name;
    } rows[] = {
        {"abuffer", {0}, "abuffer"},
        {"abuffer", {STRATA_FRAGMENTS_LINKED, STRATA_PAYLOAD_HALF, 0}, "abuffer.linked.half"},
        {"fpc", {STRATA_FRAGMENTS_LINKED, STRATA_PAYLOAD_FLOAT, 0}, "fpc.linked"},
        {"ppc", {STRATA_FRAGMENTS_CONTIGUOUS, STRATA_PAYLOAD_UNORM8, 0}, "ppc.unorm8"},
        {"thin", {STRATA_FRAGMENTS_LINKED, STRATA_PAYLOAD_HALF, 0}, "thin.half"},
        {"peel", {STRATA_FRAGMENTS_LINKED, STRATA_PAYLOAD_HALF, 0}, "peel"},
        {"surface", {STRATA_FRAGMENTS_LINKED, STRATA_PAYLOAD_HALF, 0}, "surface"},
        {"kplus", {STRATA_FRAGMENTS_CONTIGUOUS, STRATA_PAYLOAD_FLOAT, 1}, "kplus.clipped"},
        {"kplus", {STRATA_FRAGMENTS_CONTIGUOUS, STRATA_PAYLOAD_HALF, 1}, "kplus.half.clipped"},
        {"ppc", {STRATA_FRAGMENTS_LINKED, STRATA_PAYLOAD_HALF, 1}, "ppc.linked.half"},
        {"ppc", {77, 77, 0}, "ppc"},
    };
    kit_make(&k, ALL " thin");
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        char name[COSTS_NAME];
        costs_name(note(rows[i].id), rows[i].form, name);
        assert_string_equal(name, rows[i].name);
    }
}

/* abuffer + ppc cost 4,000 by their modules, peel 5,000. Here peel was measured to be cheap. */
static void the_plan_goes_by_what_was_measured(void **state) {
    (void)state;
    demand d;
    costs c = {0};
    base_error err;
    plan *p = NULL;
    double x[COSTS_TERMS] = {[COSTS_FRAGMENT] = 2};
    const request r = {FOR("abuffer ppc peel over", "b"), .costs = &c};
    kit_make(&k, "abuffer ppc peel over");
    snprintf(c.device, sizeof c.device, "a device");
    measure(&c, "peel", x, 20, 0);
    assert_true(costs_of_module(note("abuffer"), x));
    measure(&c, "abuffer", x, 20, 0);
    assert_true(costs_of_module(note("ppc"), x));
    measure(&c, "ppc", x, 20, 0);
    fit(&c);
    assert_int_equal(ask(&r, &k, &d, &p, &err), STRATA_OK);
    assert_string_equal(order_of(p), "peel");
    assert_true(near(p->cost, 2000, 0.01) && near(p->ms, 0.04, 0.01));
    assert_int_equal(p->techniques[0].points, 20);
    assert_string_equal(p->measured_on, "a device");
    plan_free(p);
    costs_free(&c);
    assert_int_equal(ask(&r, &k, &d, &p, &err), STRATA_OK); /* nothing is known any more */
    assert_string_equal(order_of(p), "abuffer ppc");
    assert_int_equal(p->techniques[0].points, 0);
    assert_true(p->ms == PLAN_NO_COST && !p->measured_on[0]);
    plan_free(p);
}

/* abuffer + ppc were measured to cost 12,000 or 21,000; peel would cost 5,000 by its module, which
 * may be off by a factor of four. A filter, which both need, is not doubted. */
static void what_was_never_measured_is_doubted(void **state) {
    (void)state;
    const double costs_of_abuffer[] = {11, 20};
    for (size_t i = 0; i < BASE_COUNT(costs_of_abuffer); i++) {
        demand d;
        costs c = {0};
        base_error err;
        plan *p = NULL;
        const double one[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1},
                     many[COSTS_TERMS] = {[COSTS_FRAGMENT] = costs_of_abuffer[i]};
        const request r = {FOR("abuffer ppc peel unit over", "b"), .costs = &c};
        kit_make(&k, "abuffer ppc peel unit over");
        measure(&c, "unit", one, 20, 0);
        measure(&c, "ppc", one, 20, 0);
        measure(&c, "abuffer", many, 20, 0);
        fit(&c);
        assert_int_equal(ask(&r, &k, &d, &p, &err), STRATA_OK);
        assert_string_equal(order_of(p), i == 0 ? "abuffer ppc" : "peel");
        if (i == 0)
            assert_non_null(strstr(reason_of(p, "peel"), "which was measured here"));
        assert_int_equal(strstr(reason_of(p, "abuffer"), "way that was measured here to") != NULL,
                         i == 0);
        plan_free(p);
        const request sampled = {
            FOR("abuffer ppc peel blur unit over", "b"), .costs = &c, .samples = 4};
        kit_make(&k, sampled.installed);
        assert_int_equal(ask(&sampled, &k, &d, &p, &err), STRATA_OK);
        assert_string_equal(order_of(p), i == 0 ? "abuffer ppc blur" : "peel blur");
        plan_free(p);
        costs_free(&c);
    }
}

/* Of 9,000: abuffer + ppc were measured to cost 20,000, kplus + ppc 2,000 and 1,000 for each of 10
 * that are kept; thin keeps all, too, and would cost 6,000 by its module. Where nothing fits it is
 * not the cheapest, either. */
static void so_it_is_within_a_budget(void **state) {
    (void)state;
    static const struct {
        const char *installed, *order;
        double keeps;
    } rows[] = {{"abuffer kplus ppc thin unit over", "kplus ppc", 7},
                {"abuffer ppc thin unit over", "abuffer ppc", 0}};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        demand d;
        costs c = {0};
        base_error err;
        plan *p = NULL;
        const double one[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1},
                     kept[COSTS_TERMS] = {[COSTS_FRAGMENT] = 1, [COSTS_KEPT] = 10},
                     many[COSTS_TERMS] = {[COSTS_FRAGMENT] = 19};
        const request r = {FOR(rows[i].installed, "b"), .costs = &c, .budget = 9000 * 20e-6};
        kit_make(&k, "abuffer kplus ppc thin unit over");
        measure(&c, "unit", one, 20, 0);
        measure(&c, "ppc", one, 20, 0);
        measure(&c, "kplus", kept, 20, 0);
        measure(&c, "abuffer", many, 20, 0);
        fit(&c);
        assert_int_equal(ask(&r, &k, &d, &p, &err), STRATA_OK);
        assert_string_equal(order_of(p), rows[i].order);
        assert_true(plan_turned(p) == rows[i].keeps);
        assert_null(strstr(reason_of(p, rows[i].keeps > 0 ? "kplus" : "abuffer"), "measured here"));
        plan_free(p);
        costs_free(&c);
    }
}

/* abuffer + fpc cost 7,000, as lists 5,000; which counts only where both know it. */
static void layouts_are_measured_apart(void **state) {
    (void)state;
    const costs_form form = {.layout = STRATA_FRAGMENTS_LINKED};
    static const struct {
        const char *lists[2], *setting;
        uint32_t layout;
        double cost;
    } rows[] = {
        {{"abuffer", "fpc"}, NULL, STRATA_FRAGMENTS_LINKED, 5000},
        {{"abuffer", "fpc"}, "abuffer.mode=contiguous", STRATA_FRAGMENTS_CONTIGUOUS, 7000},
        {{"abuffer"}, NULL, STRATA_FRAGMENTS_CONTIGUOUS, 7000},
        {{"fpc"}, NULL, STRATA_FRAGMENTS_CONTIGUOUS, 7000},
        {{"fpc"}, "abuffer.mode=linked", STRATA_FRAGMENTS_LINKED, 7000},
    };
    kit_make(&k, "abuffer ppc fpc peel over");
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        demand d;
        costs c = {0};
        double x[COSTS_TERMS], lists[COSTS_TERMS] = {0};
        const request r = {FOR("abuffer fpc peel over", "b"), .use = "abuffer,fpc",
                           .settings = {rows[i].setting}, .costs = &c};
        measure_others(&c);
        assert_true(costs_of_module(note("fpc"), x));
        measure(&c, "fpc", x, 20, 0);
        for (int n = 0; n < 2 && rows[i].lists[n]; n++) {
            lists[COSTS_FRAGMENT] = strcmp(rows[i].lists[n], "fpc") == 0 ? 4 : 1;
            kit_measure(&k, &c, rows[i].lists[n], form, lists, 20, 0);
        }
        fit(&c);
        plan *p = get(&r, &k, &d);
        if (p->layout != rows[i].layout || !near(p->cost, rows[i].cost, 0.01))
            fail_msg("row %zu: layout %u, cost %g", i, p->layout, p->cost);
        assert_true(p->techniques[0].values[0] == (double)rows[i].layout);
        if (i == 0)
            assert_non_null(strstr(p->techniques[0].reason, "as measured, mode linked costs less"));
        plan_free(p);
        costs_free(&c);
    }
}

/* ---- files ----------------------------------------------------------------------------------- */

static void write_file(const char *path, const char *text) {
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    fputs(text, f);
    assert_int_equal(fclose(f), 0);
}

static void files_are_kept_and_doubted(void **state) {
    (void)state;
#define POINT(term, ms, frames)                                                                    \
    "{\"ms\":" ms ",\"frames\":" frames ",\"terms\":[1,2,3,4,5,6,7,8,9,10," term "]}"
#define FILE_OF(format, device, rows)                                                              \
    "{\"format\":" format ",\"device\":\"" device "\",\"techniques\":[" rows "]}"
#define ROW(id, points) "{\"technique\":\"" id "\",\"points\":[" points "]}"
    static const struct {
        const char *text;
        uint32_t techniques;
    } rows[] = {
        {FILE_OF("3", "gpu", ROW("ppc", POINT("0", "2.5", "3"))), 1},
        {FILE_OF("3", "gpu", ROW("not_installed", POINT("0", "2.5", "3"))), 1},
        {FILE_OF("3", "gpu", ROW("ppc", "")), 1},
        {FILE_OF("3", "gpu", ""), 0},
        {FILE_OF("2", "gpu", ROW("ppc", POINT("0", "2.5", "3"))), 0},
        {FILE_OF("\"3\"", "gpu", ROW("ppc", POINT("0", "2.5", "3"))), 0},
        {FILE_OF("3", "other", ROW("ppc", POINT("0", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("NaN", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("null", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("-1", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("1e16", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("1e999", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("0", "0", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("0", "1e8", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("0", "2.5", "0"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("0", "2.5", "1e9"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", POINT("0,0", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("../x", POINT("0", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("", POINT("0", "2.5", "3"))), 0},
        {FILE_OF("3", "gpu", ROW("ppc", "") "," ROW("ppc", "")), 0},
        {FILE_OF("3", "gpu", "7"), 0},
        {"[]", 0},
        {"", 0},
        {"{\"format\":3", 0},
    };
    char folder[] = "/tmp/strata-costs-XXXXXX", path[128], sub[64];
    base_error err = {0};
    costs c;
    assert_non_null(mkdtemp(folder));
    snprintf(sub, sizeof sub, "%s/costs", folder);
    snprintf(path, sizeof path, "%s/%016" PRIx64 ".json", sub, base_hash(0, "gpu", 3));
    assert_int_equal(costs_load(folder, "gpu", &c, &err), STRATA_OK); /* none is there */
    assert_int_equal(c.count, 0);
    const double terms[COSTS_TERMS] = {1, 2.5, 1.0 / 3.0};
    assert_true(costs_add(&c, "kplus", terms, 0.7));
    assert_int_equal(costs_save(folder, &c, &err), STRATA_OK);
    costs_free(&c);
    assert_int_equal(costs_load(folder, "gpu", &c, &err), STRATA_OK);
    assert_int_equal(c.count, 1);
    assert_memory_equal(c.techniques[0].points[0].terms, terms, sizeof terms);
    assert_true(c.techniques[0].points[0].ms == 0.7);
    costs_free(&c);
    setenv("STRATA_LOG", "error", 1);
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        write_file(path, rows[i].text);
        assert_int_equal(costs_load(folder, "gpu", &c, &err), STRATA_OK);
        if (c.count != rows[i].techniques || strcmp(c.device, "gpu") != 0)
            fail_msg("row %zu: %u techniques", i, c.count);
        costs_free(&c);
    }
    assert_int_equal(costs_load(NULL, "gpu", &c, &err), STRATA_OK); /* no cache */
    assert_int_equal(costs_load("/tmp/no/such/folder", "gpu", &c, &err), STRATA_OK);
    assert_int_equal(unlink(path) | rmdir(sub) | rmdir(folder), 0);
    costs_free(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(terms_say_what_there_is_to_do),
        cmocka_unit_test(known_coefficients_are_recovered),
        cmocka_unit_test(one_point_scales),
        cmocka_unit_test(what_was_measured_is_expected_there),
        cmocka_unit_test(the_unit_says_what_it_is),
        cmocka_unit_test(useless_points_stay_finite),
        cmocka_unit_test(equal_terms_share_a_point),
        cmocka_unit_test(forms_have_names),
        cmocka_unit_test(the_plan_goes_by_what_was_measured),
        cmocka_unit_test(what_was_never_measured_is_doubted),
        cmocka_unit_test(so_it_is_within_a_budget),
        cmocka_unit_test(layouts_are_measured_apart),
        cmocka_unit_test(files_are_kept_and_doubted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
