/* SPDX-License-Identifier: MIT
 *
 * host/plan: tables of what is installed, what the scene holds and what the user asks, against the
 * techniques that run, their order, and the reasons in words.
 */
#include "unit/plan_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- what runs ------------------------------------------------------------------------------- */

static void techniques_run_in_order(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *order;
    } rows[] = {
        /* the scene decides */
        {{FOR(ALL, "")}, ""},
        {{FOR(ALL, "o")}, "surface"},
        {{FOR(ALL, "b")}, "stencil ppc"},
        {{FOR(ALL, "ob")}, "surface stencil ppc"},
        {{FOR(ALL, "obd")}, "surface abuffer ppc"}, /* too deep for stencil */
        {{FOR(ALL, "ot")}, "surface stencil ppc"},
        {{FOR("surface over", "o")}, "surface"},
        {{FOR("", "")}, ""},
        {{FOR("surface flat", "o")}, "surface"},
        {{FOR("flat surface", "o")}, "surface"}, /* found order does not matter */
        /* the device decides */
        {{FOR(ALL, "ob"), .device = "nothing"}, "surface abuffer ppc"},
        {{FOR(ALL, "ob"), .device = "feature.stencil_export"}, "surface stencil ppc"},
        {{FOR(ALL, "ob"), .device = "?"}, "surface stencil ppc"},
        /* the user decides */
        {{FOR(ALL, "ob"), .use = "abuffer"}, "surface abuffer ppc"},
        {{FOR(ALL, "ob"), .use = "fpc"}, "surface stencil fpc"},
        /* the same bits are worth a tenth: 4 against 3.7, 4 against 3.6 */
        {{FOR("abuffer ppc sums over", "b")}, "abuffer ppc"},
        {{FOR("abuffer sums ppc over", "b")}, "abuffer ppc"},
        {{FOR("abuffer ppc quicksums over", "b")}, "abuffer quicksums"},
        {{FOR(ALL, "ob"), .use = "fpc, abuffer"}, "surface abuffer fpc"},
        {{FOR(ALL, "ob"), .use = "ppc,abuffer,surface"}, "surface abuffer ppc"},
        {{FOR(ALL, "ob"), .use = "peel"}, "surface peel"},
        {{FOR(ALL, "ob"), .use = "wboit"}, "surface wboit"},
        {{FOR(ALL, "ob"), .use = "kbuffer,facesort"}, "facesort surface kbuffer"},
        {{FOR(ALL, "ob"), .use = "kplus"}, "surface kplus ppc"},
        {{FOR(ALL, "ob"), .use = "kplus,hiz,occupancy,fpc"}, "hiz surface occupancy kplus fpc"},
        {{FOR(ALL, "obd"), .use = "stencil"}, "surface stencil ppc"},
        {{FOR(ALL, "ob"), .use = "hiz"}, "hiz surface stencil ppc"},
        {{FOR(ALL, "o"), .use = "hiz"}, "hiz surface"},
        {{FOR(ALL, "o"), .use = "facesort,abuffer,occupancy"}, "surface"}, /* idle, with warnings */
        {{FOR("surface flat", "o"), .use = "flat"}, "flat"},
        /* effects decide */
        {{FOR(ALL, "ob"), .effects = "none"}, "surface"},
        {{FOR(ALL, "ob"), .effects = "over"}, "surface stencil ppc"},
        {{FOR(ALL, "o"), .effects = "over"}, "surface"}, /* active, but nothing to fold */
        {{FOR("surface stencil ppc fpc media", "oe")}, "surface stencil ppc"},
        /* accuracy decides */
        {{FOR(ALL, "ob"), .tolerance = 0.01}, "surface kbuffer"},
        {{FOR(ALL, "ob"), .tolerance = 0.01, .device = "none"}, "surface kplus ppc"},
        {{FOR(ALL, "ob"), .tolerance = 0.01, .deep = 1}, "surface stencil ppc"},
        {{FOR(ALL, "ob"), .tolerance = 0.01, .use = "abuffer"}, "surface abuffer ppc"},
        {{FOR("peel fpc abuffer over", "b"), .settings = {"peel.mode=dual"}}, "peel"},
        {{FOR("peel fpc abuffer over", "b"), .settings = {"peel.layers=5"}}, "abuffer fpc"},
        {{FOR("peel fpc abuffer over", "b"), .settings = {"peel.layers=5"}, .tolerance = 0.1},
         "peel"},
        {{FOR("peel abuffer ppc media", "e"), .settings = {"peel.mode=dual"}}, "abuffer ppc"},
        /* what is hidden or outside decides: 20,000 * share * 2 + 1,000 * share against 10,000 */
        {{FOR("cull painter", "oc")}, "cull painter"},
        {{FOR("cull painter", "ov")}, "painter"},
        {{FOR("cull painter", "o")}, "painter"},
        {{FOR("cull surface", "oc")}, "surface"}, /* a triangle costs nothing there */
        {{FOR("cull painter", "oc"), .use = "painter"}, "painter"},
        {{FOR("cull painter", "ov"), .use = "cull"}, "cull painter"},
        {{FOR("frustum painter", "oc")}, "frustum painter"},
        {{FOR("cull frustum painter", "oc")}, "cull painter"}, /* one is enough */
        /* what a clip technique hides decides */
        {{FOR("occupancy slowk ppc over", "bh"), .tolerance = 0.01}, "occupancy slowk ppc"},
        {{FOR("occupancy slowk ppc over", "b"), .tolerance = 0.01}, "slowk ppc"},  /* not deep */
        {{FOR("occupancy kplus ppc over", "bh"), .tolerance = 0.01}, "kplus ppc"}, /* cheap */
        {{FOR("occupancy slowk ppc over", "bh"), .tolerance = 0.01, .settings = {"slowk.k=0"}},
         "slowk ppc"},
        {{FOR("occupancy slowk ppc over", "bh"), .tolerance = 0.01, .settings = {"slowk.k=64"}},
         "slowk ppc"},
        {{FOR("occupancy slowk ppc over", "bh"), .tolerance = 0.01,
          .settings = {"occupancy.buckets=8"}}, /* too coarse to hide anything */
         "slowk ppc"},
        {{FOR("occupancy slowk ppc over", "bh"), .use = "slowk"}, "slowk ppc"},
        {{FOR("occupancy slowk ppc over", "bh"), .use = "slowk,occupancy"}, "occupancy slowk ppc"},
        {{FOR("occupancy kplus ppc over", "b"), .use = "kplus,occupancy"}, "occupancy kplus ppc"},
        /* layouts decide */
        {{FOR("chain abuffer ppc over", "b")}, "abuffer ppc"}, /* ppc cannot read chain's */
        {{FOR("chain abuffer walker over", "b")}, "chain walker"},
        {{FOR("chain abuffer ppc walker over", "b")}, "chain walker"},
        {{FOR("chain abuffer ppc walker over", "b"), .use = "abuffer"}, "abuffer ppc"},
        {{FOR("chain abuffer ppc walker over", "b"), .settings = {"abuffer.mode=linked"},
          .use = "abuffer"},
         "abuffer walker"},
        /* slots decide */
        {{FOR("surface taker maker maker2 peel over", "ob")}, "maker2 surface taker"},
        {{FOR("surface taker maker maker2 peel over", "ob"), .use = "maker"},
         "maker surface taker"},
        {{FOR("surface taker peel over", "ob")}, "surface peel"},
        {{FOR("surface wisher", "o"), .use = "wisher"}, "wisher surface"},
        {{FOR("surface growk ppc over", "ob"), .use = "growk"}, "surface growk ppc"},
        {{FOR("tinted tinter priceless over", "ob")}, "tinter tinted priceless"},
        /* samples and costs */
        {{FOR(ALL, "ob"), .samples = 1}, "surface stencil ppc"},
        {{FOR(ALL, "ob"), .samples = 4}, "surface stencil ppc filter"},
        {{FOR(ALL, ""), .samples = 4}, "filter"},
        {{FOR("surface fuser filter over", "ob")}, "surface fuser"},
        {{FOR("surface fuser filter over", "ob"), .samples = 4}, "surface fuser"},
        {{FOR("surface fuser over", "ob"), .samples = 4}, "surface fuser"},
        {{FOR("surface fuser filter over", "o"), .samples = 4}, "surface filter"},
        /* peel costs less than fuser, but not with a filter that costs 9 */
        {{FOR("fuser peel filter over", "b"), .samples = 4}, "peel filter"},
        {{FOR("fuser peel blur over", "b"), .samples = 4}, "fuser"},
        {{FOR("fuser peel blur over", "b"), .samples = 4, .use = "blur"}, "peel blur"},
        {{FOR("surface fuser filter over", "ob"), .samples = 4, .use = "filter"},
         "surface fuser filter"},
        {{FOR("surface fuser peel filter over", "ob"), .samples = 4}, "surface peel filter"},
        {{FOR(ALL, "ob"), .use = "filter"}, "surface stencil ppc"},
        {{FOR("priceless peel over", "b")}, "peel"},
        {{FOR("priceless over", "b")}, "priceless"},
        {{FOR("silent over", "b"), .use = "silent"}, "silent"},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        if (strcmp(order_of(p), rows[i].order) != 0)
            fail_msg("row %zu: '%s', not '%s'", i, order_of(p), rows[i].order);
        uint32_t techniques = 0;
        for (uint32_t n = 0; n < k.count; n++)
            techniques += k.list[n]->technique_count;
        assert_int_equal(p->technique_count + p->left_out_count, techniques);
        for (uint32_t n = 0; n < p->left_out_count; n++)
            assert_true(p->left_out[n].reason[0] != '\0');
        for (uint32_t n = 0; n < p->technique_count; n++)
            assert_true(p->techniques[n].reason[0] != '\0');
        plan_free(p);
    }
}

/* Under a tolerance: what runs, and one of its knobs, at each raise. */
static void tolerances_are_traded_and_raised(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *order, *id, *knob;
        double value;
    } rows[] = {
        {{FOR("kplus ppc abuffer over", "b")}, "abuffer ppc", "abuffer", "payload", 0},
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1}, "kplus ppc", "kplus", "k", 8},
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1, .raise = 1},
         "kplus ppc",
         "kplus",
         "k",
         16},
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1, .raise = 3},
         "kplus ppc",
         "kplus",
         "k",
         64},
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1, .raise = 4},
         "kplus ppc",
         "kplus",
         "k",
         64}, /* the most it has */
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1, .raise = 5},
         "abuffer ppc",
         "abuffer",
         "payload",
         0}, /* the exact way */
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1, .raise = 5, .use = "kplus"},
         "kplus ppc",
         "kplus",
         "k",
         0},
        {{FOR("kplus ppc abuffer over", "b"), .tolerance = 0.1, .raise = 2,
          .settings = {"kplus.k=5"}},
         "kplus ppc",
         "kplus",
         "k",
         5}, /* the user's stays */
        /* where pixels may grow, all first have what is likely to be enough: 1.25 x 10 deep, or
         * log(2 / tolerance) / (0.6 x 0.3) fragments */
        {{FOR("growk ppc over", "b"), .tolerance = 0.1}, "growk ppc", "growk", "k", 13},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1}, "growk ppc", "growk", "begin", 0},
        {{FOR("growk ppc over", "b"), .tolerance = 0.5}, "growk ppc", "growk", "k", 8},
        {{FOR("growk ppc over", "bd"), .tolerance = 0.5}, "growk ppc", "growk", "k", 8},
        {{FOR("growk ppc over", "bd"), .tolerance = 1e-5}, "growk ppc", "growk", "begin", 4},
        /* else they begin with few and may grow to all, at every raise */
        {{FOR("growk ppc over", "b"), .use = "growk"}, "growk ppc", "growk", "begin", 0},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .raise = 1}, "growk ppc", "growk", "k", 64},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .raise = 2}, "growk ppc", "growk", "k", 64},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .raise = 1},
         "growk ppc",
         "growk",
         "begin",
         4},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .settings = {"growk.k=3"}},
         "growk ppc",
         "growk",
         "begin",
         3},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .settings = {"growk.k=3"}},
         "growk ppc",
         "growk",
         "k",
         3},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .settings = {"growk.begin=9"}},
         "growk ppc",
         "growk",
         "begin",
         9},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .raise = 5, .use = "growk"},
         "growk ppc",
         "growk",
         "k",
         0},
        {{FOR("growk ppc over", "b"), .tolerance = 0.1, .raise = 5, .use = "growk"},
         "growk ppc",
         "growk",
         "begin",
         0},
        {{FOR("abuffer ppc over", "b"), .tolerance = 0.05}, "abuffer ppc", "abuffer", "payload", 2},
        {{FOR("abuffer ppc over", "b"), .tolerance = 0.05, .raise = 1},
         "abuffer ppc",
         "abuffer",
         "payload",
         1},
        {{FOR("abuffer ppc over", "b"), .tolerance = 0.005},
         "abuffer ppc",
         "abuffer",
         "payload",
         1},
        {{FOR("abuffer ppc over", "b"), .tolerance = 1e-6}, "abuffer ppc", "abuffer", "payload", 0},
        {{FOR("abuffer ppc over", "b"), .tolerance = 0.05, .raise = 9,
          .settings = {"abuffer.payload=unorm8"}},
         "abuffer ppc",
         "abuffer",
         "payload",
         2},
        {{FOR("abuffer ppc priceless over", "b"), .tolerance = 0.05, .use = "priceless"},
         "priceless",
         NULL,
         NULL,
         0},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        if (strcmp(order_of(p), rows[i].order) != 0)
            fail_msg("row %zu: '%s', not '%s'", i, order_of(p), rows[i].order);
        const plan_technique *t = rows[i].id ? plan_find(p, rows[i].id) : NULL;
        for (uint32_t n = 0; t && n < t->technique->knob_count; n++)
            if (strcmp(t->technique->knobs[n]->name, rows[i].knob) == 0 &&
                t->values[n] != rows[i].value)
                fail_msg("row %zu: %s is %g, not %g", i, rows[i].knob, t->values[n], rows[i].value);
        plan_free(p);
    }
}

static void order_of_installation_does_not_matter(void **state) {
    (void)state;
    static const char *const orders[] = {
        "over transmission ppc abuffer peel surface hiz",
        "hiz surface peel abuffer ppc transmission over",
        "peel over hiz abuffer transmission surface ppc",
    };
    json_t *first = NULL;
    for (size_t i = 0; i < BASE_COUNT(orders); i++) {
        kit k;
        demand d;
        plan *p = get(&(request){FOR(orders[i], "obt"), .use = "hiz"}, &k, &d);
        json_t *json = plan_json(p);
        assert_non_null(json);
        if (!first)
            first = json_incref(json);
        assert_true(json_equal(first, json));
        json_decref(json);
        plan_free(p);
    }
    json_decref(first);
}

/* ---- reasons --------------------------------------------------------------------------------- */

static void everything_has_its_reason(void **state) {
    (void)state;
    static const struct {
        request r;
        const char *id, *reason;
    } rows[] = {
        {{FOR(ALL, "ob")}, "surface", "2 opaque draws"},
        {{FOR(ALL, "b")}, "surface", "nothing opaque is drawn"},
        {{FOR(ALL, "ob")},
         "ppc",
         "the cheapest exact way to fold about 1,000 fragments, with stencil: "
         "3 x floor"},
        {{FOR(ALL, "ob")}, "abuffer", "costs 4 against 3 of stencil + ppc"},
        {{FOR(ALL, "ob")}, "fpc", "costs 6 against 3 of stencil + ppc"},
        {{FOR(ALL, "ob")}, "peel", "costs 5 against 3 of stencil + ppc"},
        {{FOR("abuffer ppc sums over", "b")},
         "sums",
         "costs 3.7 against 4 of abuffer + ppc, which promises the same bits everywhere"},
        {{FOR("abuffer ppc sums over", "b")},
         "ppc",
         "the cheapest exact way that promises the same bits everywhere to fold about 1,000 "
         "fragments, with abuffer: 4 x floor"},
        {{FOR(ALL, "ob")}, "wboit", "it is approximate, without a bound; --use may name it"},
        {{FOR(ALL, "ob")},
         "kplus",
         "it keeps the nearest fragments only, and no tolerance is given"},
        {{FOR("kplus abuffer ppc over", "b"), .tolerance = 0.1},
         "kplus",
         "the cheapest way to fold about 1,000 fragments, with ppc: 1.8 x floor; for a tolerance "
         "of 0.1 it begins with k 8"},
        {{FOR("growk abuffer ppc over", "b"), .tolerance = 0.1, .settings = {"growk.k=5"}},
         "growk",
         "the cheapest way to fold about 1,000 fragments, with ppc: 1.98 x floor; for a tolerance "
         "of "
         "0.1 it begins with k from 4 to 5, pixel by pixel"},
        {{FOR("growk abuffer ppc over", "b"), .tolerance = 0.1},
         "growk",
         "the cheapest way to fold about 1,000 fragments, with ppc: 2.7 x floor; for a tolerance "
         "of 0.1 it begins with k 13"},
        {{FOR("growk abuffer ppc over", "b"), .tolerance = 0.1, .raise = 1},
         /* (1 + 1) * (1 + log2(10 / 4)) */
         "growk",
         "costs 4.64 against 4 of abuffer + ppc"},
        {{FOR("kplus abuffer ppc over", "b"), .tolerance = 0.1, .raise = 5},
         "kplus",
         "it keeps the nearest fragments only, and the tolerance was missed"},
        {{FOR("priceless abuffer ppc over", "b"), .tolerance = 0.1},
         "priceless",
         "it cannot say how wrong it may be, and a tolerance is given"},
        {{FOR("peel abuffer ppc over", "b"), .settings = {"peel.layers=5"}},
         "peel",
         "it keeps the nearest fragments only, and no tolerance is given"},
        {{FOR("peel over", "b"), .use = "peel"}, "peel", "named in --use"},
        {{FOR("peel abuffer ppc media", "e"), .settings = {"peel.mode=dual"}},
         "peel",
         "it folds in parallel, and the effect media is sequential"},
        {{FOR("pass priceless over", "b")},
         "pass",
         "the cheapest exact way to fold about 1,000 fragments: 6.5 x floor"},
        {{FOR("pass peel over", "bd")},
         "pass",
         "it holds 100 fragments a pixel, and about 300 are expected"},
        {{FOR(ALL, "ob")}, "hiz", "not named in --use"},
        {{FOR("cull painter", "oc")},
         "cull",
         "of the triangles of 1,000 opaque objects about 50 % are hidden or outside: that saves "
         "2e+04 "
         "blended fragments and costs 1e+04"},
        {{FOR("cull painter", "ov"), .use = "painter"},
         "cull",
         "not named in --use; of the triangles of 1,000 opaque objects about 6 % would be hidden "
         "or "
         "outside: that saves 2.3e+03 blended fragments and costs 1e+04"},
        {{FOR("cull painter", "o")},
         "cull",
         "0 opaque objects: too few to be culled, or none is hidden"},
        {{FOR(ALL, "ob")},
         "occupancy",
         "it hides what lies behind the nearest k fragments, and stencil keeps all"},
        {{FOR("occupancy slowk ppc over", "bh"), .tolerance = 0.01},
         "occupancy",
         "hides about 90 % of the fragments from slowk: that saves 2.2 x floor and costs 1"},
        {{FOR("occupancy slowk ppc over", "b"), .tolerance = 0.01},
         "occupancy",
         "it would hide about 7 % of the fragments from slowk, which saves 0.17 x floor and costs "
         "1"},
        {{FOR("occupancy kplus ppc over", "bhl"), .use = "kplus"},
         "occupancy",
         "not named in --use; it would hide about 90 % of the fragments from kplus, which saves "
         "2 x floor and costs 1"},
        {{FOR("occupancy slowk ppc over", "bh"), .use = "slowk,occupancy"},
         "occupancy",
         "named in --use"},
        {{FOR("range slowk ppc over", "bh"), .tolerance = 0.01}, "range", "not named in --use"},
        {{FOR(ALL, "ob")}, "filter", "a pixel has one sample"},
        {{FOR(ALL, "ob"), .samples = 9}, "filter", "9 samples a pixel"},
        {{FOR("surface fuser filter over", "ob"), .samples = 9},
         "filter",
         "fuser filters as it folds"},
        {{FOR(ALL, "ob"), .device = "-"},
         "stencil",
         "needs feature.stencil_export, which this device does not have"},
        {{FOR(ALL, "obd")},
         "stencil",
         "it holds 254 fragments a pixel, and about 300 are expected"},
        {{FOR(ALL, "o")}, "abuffer", "no effect is active"},
        {{FOR(ALL, "o"), .effects = "over"}, "ppc", "nothing transparent is drawn"},
        {{FOR(ALL, "ob"), .use = "peel"}, "abuffer", "--use names peel"},
        {{FOR(ALL, "ob"), .use = "abuffer"}, "peel", "--use names abuffer"},
        {{FOR(ALL, "ob"), .use = "abuffer"}, "stencil", "--use names abuffer"},
        {{FOR(ALL, "ob"), .use = "abuffer"}, "abuffer", "named in --use"},
        {{FOR(ALL, "ob"), .use = "abuffer"}, "fpc", "costs 7 against 4 of abuffer + ppc"},
        {{FOR("abuffer ppc over", "b")},
         "abuffer",
         "the only exact way to fold transparent fragments, with ppc"},
        {{FOR("abuffer walker over", "b")},
         "abuffer",
         "the only exact way to fold transparent fragments, with walker; mode linked, which "
         "walker reads"},
        {{FOR("chain abuffer ppc over", "b")},
         "chain",
         "nothing that can run here shares its layout of fragments/1"},
        {{FOR(ALL, "ob"), .deep = 1},
         "peel",
         "deep output needs fragments/1, which it does not produce"},
        {{FOR("surface mystic", "o")}, "mystic", "this host knows no stage 'mystery'"},
        {{FOR("surface liar", "o")},
         "liar",
         "its stage is capture, but it does not produce fragments/1"},
        {{FOR("surface thief", "o")}, "thief", "produces color/1, which the host fills itself"},
        {{FOR("surface taker peel over", "ob")},
         "taker",
         "consumes foo/1, which nothing that can run here produces"},
        {{FOR("surface taker maker maker2 peel over", "ob")},
         "maker2",
         "produces foo/1, which taker consumes"},
        {{FOR("surface flat", "o"), .use = "flat"}, "surface", "--use names flat"},
        {{FOR("priceless peel over", "b")}, "priceless", "costs an unknown cost against 5 of peel"},
        {{FOR("abuffer ppc fpc media", "e")},
         "fpc",
         "it folds in parallel, and the effect media is sequential"},
        {{FOR(ALL, "ob")}, "over", "the scene calls for it"},
        {{FOR(ALL, "ob")},
         "transmission",
         "nothing calls for it: materials.transmission is 0 of at least 1"},
        {{FOR(ALL, "ob"), .effects = "none"}, "over", "switched off by --effects none"},
        {{FOR(ALL, "ob"), .effects = "transmission,over"},
         "transmission",
         "named in --effects, though nothing in the scene calls for it"},
        {{FOR("media", "f")},
         "media",
         "nothing calls for it: materials.emissive is 1 of at least 2"},
        {{FOR("precise", "b")},
         "precise",
         "nothing calls for it: materials.unlit is 0 of at least 1"},
        {{FOR("greedy", "")},
         "greedy",
         "nothing calls for it: this host knows no fact 'weather.rain'"},
        {{FOR("idle", "b")}, "idle", "nothing calls for it; --effects may name it"},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        kit k;
        demand d;
        plan *p = get(&rows[i].r, &k, &d);
        if (strcmp(reason_of(p, rows[i].id), rows[i].reason) != 0)
            fail_msg("row %zu, %s: '%s', not '%s'", i, rows[i].id, reason_of(p, rows[i].id),
                     rows[i].reason);
        plan_free(p);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(techniques_run_in_order),
        cmocka_unit_test(tolerances_are_traded_and_raised),
        cmocka_unit_test(order_of_installation_does_not_matter),
        cmocka_unit_test(everything_has_its_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
