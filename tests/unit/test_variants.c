/* SPDX-License-Identifier: MIT
 *
 * The variants of the installed techniques that sweeps and tests try: what their values are, and
 * what is said of them, held against the notes.
 */
#include "plan/variants.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const char *const stages[] = {"capture", "resolve", "stream", "clip", "draws"};
static const int breadths[] = {PLAN_BREADTH_EDGES, PLAN_BREADTH_LADDER, PLAN_BREADTH_LADDER_ALL};
static modules *installed;

static plan_variants collect(const char *stage, uint32_t depth, int breadth) {
    plan_variants v = {0};
    base_error err = {0};
    if (plan_variants_collect(installed, stage, depth, breadth, &v, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return v;
}

static const plan_variant *find(const plan_variants *v, const char *id, const char *first,
                                const char *second) {
    for (uint32_t i = 0; i < v->count; ++i)
        if (strcmp(v->at[i].technique->id, id) == 0 && strcmp(v->at[i].settings[0], first) == 0 &&
            strcmp(v->at[i].settings[1], second) == 0)
            return &v->at[i];
    return NULL;
}

static const strata_knob *knob_of(const plan_variant *v, const char *setting, const char **value) {
    const char *name = strchr(setting, '.') + 1;
    *value = strchr(name, '=') + 1;
    for (uint32_t i = 0; i < v->technique->knob_count; ++i) {
        const strata_knob *knob = v->technique->knobs[i];
        const size_t length = strlen(knob->name);
        if (strncmp(name, knob->name, length) == 0 && name[length] == '=')
            return knob;
    }
    fail_msg("%s: no such knob", setting);
    return NULL;
}

static void check_setting(const plan_variant *v, const char *setting, int breadth) {
    const char *value;
    const strata_knob *knob = knob_of(v, setting, &value);
    const int mode = strcmp(knob->name, "mode") == 0;
    double number = strtod(value, NULL);
    if (knob->type == STRATA_KNOB_CHOICE)
        for (number = 0; strcmp(knob->choices[(int)number], value) != 0; ++number)
            assert_non_null(knob->choices[(int)number + 1]);
    else if (number < knob->minimum || number > knob->maximum)
        fail_msg("%s: out of range", setting);
    if (number == knob->preset)
        fail_msg("%s is the preset", setting);
    if (breadth == PLAN_BREADTH_LADDER && !knob->trades_accuracy && !mode)
        fail_msg("%s trades no accuracy", setting);
}

/* Values are allowed, none is the preset's, and nothing is there twice. */
static void values_are_allowed(void **state) {
    (void)state;
    for (size_t b = 0; b < BASE_COUNT(breadths); ++b)
        for (size_t s = 0; s < BASE_COUNT(stages); ++s) {
            plan_variants v = collect(stages[s], 20, breadths[b]);
            for (uint32_t i = 0; i < v.count; ++i) {
                const plan_variant *at = &v.at[i];
                for (int k = 0; k < PLAN_VARIANT_KNOBS && at->settings[k][0]; ++k)
                    check_setting(at, at->settings[k], breadths[b]);
                assert_ptr_equal(find(&v, at->technique->id, at->settings[0], at->settings[1]), at);
            }
            free(v.at);
        }
}

/* k goes up in powers of two to the first that keeps all, and with each payload. */
static void k_climbs_to_the_depth(void **state) {
    (void)state;
    static const char *const there[] = {"0", "1", "2", "4", "16", "32"};
    plan_variants v = collect("capture", 20, PLAN_BREADTH_LADDER);
    for (size_t i = 0; i < BASE_COUNT(there); ++i) {
        char setting[32];
        snprintf(setting, sizeof setting, "kplus.k=%s", there[i]);
        const plan_variant *plain = find(&v, "kplus", setting, ""),
                           *half = find(&v, "kplus", setting, "kplus.payload=half");
        assert_non_null(plain);
        assert_non_null(half);
        assert_true(plain->keeps == strtod(there[i], NULL) && half->keeps == plain->keeps);
        assert_int_equal(plain->exact, plain->keeps == 0 || plain->keeps >= 20);
        assert_int_equal(plain->order,
                         plain->keeps == 0 ? STRATA_ORDER_EXACT : STRATA_ORDER_NEAREST);
        assert_int_equal(half->payload, 1);
        assert_true(plain->crossed && !half->crossed);
    }
    assert_null(find(&v, "kplus", "kplus.k=8", "")); /* the preset, which has no setting */
    assert_null(find(&v, "kplus", "kplus.k=64", ""));
    const plan_variant *preset = find(&v, "kplus", "", "");
    assert_true(preset && preset->keeps == 8 && !preset->exact);
    free(v.at);
    v = collect("capture", 8, PLAN_BREADTH_LADDER);
    assert_true(find(&v, "kplus", "", "")->exact); /* 8 are all */
    assert_null(find(&v, "kplus", "kplus.k=16", ""));
    free(v.at);
}

/* A technique that keeps all keeps the nearest once it is told how many. */
static void layers_make_it_nearest(void **state) {
    (void)state;
    plan_variants v = collect("stream", 20, PLAN_BREADTH_LADDER);
    const plan_variant *all = find(&v, "peel", "", ""),
                       *some = find(&v, "peel", "peel.layers=4", ""),
                       *dual = find(&v, "peel", "peel.mode=dual", "");
    assert_true(all && all->exact && all->orderly && all->order == STRATA_ORDER_EXACT);
    assert_true(some && !some->exact && some->order == STRATA_ORDER_NEAREST && some->keeps == 4);
    assert_true(dual && !dual->exact && !dual->orderly && dual->order == STRATA_ORDER_EXACT);
    assert_true(find(&v, "peel", "peel.layers=32", "")->exact);
    assert_int_equal(find(&v, "floor", "", "")->order, STRATA_ORDER_APPROXIMATE);
    assert_null(find(&v, "floor", "floor.shading=scene", ""));
    free(v.at);
    v = collect("stream", 20, PLAN_BREADTH_LADDER_ALL);
    assert_non_null(find(&v, "floor", "floor.shading=scene", ""));
    free(v.at);
}

/* Deeper than it holds: a promise that does not reach. */
static void promises_end_at_the_largest_depth(void **state) {
    (void)state;
    plan_variants v = collect("capture", 254, PLAN_BREADTH_LADDER);
    assert_true(find(&v, "stencil", "", "")->exact);
    free(v.at);
    v = collect("capture", 255, PLAN_BREADTH_LADDER);
    assert_false(find(&v, "stencil", "", "")->exact);
    assert_true(find(&v, "abuffer", "", "")->exact);
    assert_true(find(&v, "abuffer", "abuffer.mode=linked", "")->exact);
    assert_int_equal(find(&v, "abuffer", "abuffer.payload=unorm8", "")->payload, 2);
    const plan_variant *lists = find(&v, "abuffer", "abuffer.mode=linked", "abuffer.payload=half");
    assert_true(lists && lists->payload == 1 && lists->exact && !lists->crossed);
    free(v.at);
}

static void early_ends_are_told(void **state) {
    (void)state;
    plan_variants v = collect("resolve", 20, PLAN_BREADTH_LADDER);
    const plan_variant *early = find(&v, "fpc", "fpc.threshold=0.00390625", "");
    assert_true(early && early->ends_early && !early->crossed);
    assert_false(find(&v, "fpc", "", "")->ends_early || find(&v, "ppc", "", "")->ends_early);
    free(v.at);
}

static void who_meets_whom(void **state) {
    (void)state;
    plan_variants captures = collect("capture", 20, PLAN_BREADTH_LADDER),
                  resolves = collect("resolve", 20, PLAN_BREADTH_LADDER);
    const plan_variant *k = find(&captures, "kplus", "kplus.k=4", ""),
                       *half = find(&captures, "kplus", "kplus.k=4", "kplus.payload=half"),
                       *preset = find(&captures, "abuffer", "", "");
    const plan_variant *ppc = find(&resolves, "ppc", "", ""), *fpc = find(&resolves, "fpc", "", ""),
                       *mode = find(&resolves, "fpc", "fpc.mode=fragments", ""),
                       *early = find(&resolves, "fpc", "fpc.threshold=0.00390625", "");
    const int ladder = PLAN_BREADTH_LADDER, edges = PLAN_BREADTH_EDGES;
    assert_true(plan_variants_meet(k, ppc, ladder) && plan_variants_meet(k, fpc, ladder));
    assert_true(plan_variants_meet(half, ppc, ladder) && !plan_variants_meet(half, fpc, ladder));
    assert_true(plan_variants_meet(preset, early, ladder) && !plan_variants_meet(k, mode, ladder));
    assert_true(plan_variants_meet(k, mode, edges) && plan_variants_meet(k, early, edges));
    assert_false(plan_variants_meet(half, early, edges));
    free(captures.at);
    free(resolves.at);
}

int main(void) {
    base_error err = {0};
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_allowed),
        cmocka_unit_test(k_climbs_to_the_depth),
        cmocka_unit_test(layers_make_it_nearest),
        cmocka_unit_test(promises_end_at_the_largest_depth),
        cmocka_unit_test(early_ends_are_told),
        cmocka_unit_test(who_meets_whom),
    };
    if (modules_scan(NULL, &installed, &err) != STRATA_OK) {
        fprintf(stderr, "%s\n", err.text);
        return 1;
    }
    const int failed = cmocka_run_group_tests_name("variants", tests, NULL, NULL);
    modules_free(installed);
    return failed;
}
