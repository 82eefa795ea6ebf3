/* SPDX-License-Identifier: MIT
 *
 * Certificates are held to their word: wherever bound/1 states a number, the picture is no further
 * from the exact one, which the fold oracle computes in double from all fragments at full
 * precision. And they are not useless: the median of bound over error is printed, and limited where
 * it matters.
 */
#include "named.h"
#include "oracle/oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One way to render with a certificate. */
typedef struct certified_way {
    const char *use, *settings[3]; /* settings end at NULL */
    uint32_t bands;
    double loosest; /* on soup, the median of bound over error may not exceed it; 0: it may */
} certified_way;

/* Every way on one scene. Returns how many channels were certified. Where many pixels differ in
 * what they hold the median is limited; a scene of equal pixels may be lucky in all of them. */
static uint64_t hold(strata *s, const oracle_case *k, const certified_way *ways, size_t count) {
    strata_scene *sc = oracle_scene(s, k->scene);
    oracle_exact exact = oracle_exact_make(s, sc, k);
    uint64_t certified = 0;
    for (size_t i = 0; i < count; i++) {
        char what[256];
        snprintf(what, sizeof what, "%s, %s %s %s", k->scene, ways[i].use,
                 ways[i].settings[0] ? ways[i].settings[0] : "",
                 ways[i].settings[0] && ways[i].settings[1] ? ways[i].settings[1] : "");
        oracle_certify(s, sc, k, ways[i].use, ways[i].settings, ways[i].bands);
        oracle_tally t = oracle_hold(s, &exact, what);
        assert_true(s->result.bound.uncertified >= s->result.report.lost);
        const double median = t.slack_count ? t.slack[t.slack_count / 2] : 0;
        print_message("  %-88s bound <= %-9.3g error <= %.2f bound, median bound/error %-6.3g "
                      "uncertified %.1f %%\n",
                      what, t.largest, t.worst, median,
                      100.0 * (double)t.uncertified / (double)exact.channels);
        if (ways[i].loosest > 0 && strstr(k->scene, "soup"))
            assert_true(median <= ways[i].loosest);
        certified += t.certified;
        oracle_tally_free(&t);
    }
    oracle_exact_free(&exact);
    strata_scene_close(sc);
    return certified;
}

/* ---- cases ----------------------------------------------------------------------------------- */

static const oracle_case scenes[] = {
    {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 64, 48)},
    {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 64, 48)},
    {ORACLE_FRAME("scene:shells?count=5&subdivision=2&transmission=0.6", 48, 48)},
    {ORACLE_FRAME("scene:particles?count=600&radius=0.08", 48, 48)},
    {ORACLE_FRAME("scene:stack?count=40&alpha=0.05", 32, 32)},
    {ORACLE_FRAME("scene:layers?count=65&width=8&height=8&alpha=0.05", 8, 8)},
    {ORACLE_FRAME("own:crossing", 48, 48)},
    {ORACLE_FRAME("own:clear", 32, 32)},
    {ORACLE_FRAME("own:opaque", 16, 16)},
};

/* The second backend does the same arithmetic; it gets the first half. */
static size_t scene_count(void **state) {
    return strcmp(*state, "gl") == 0 ? BASE_COUNT(scenes) / 2 : BASE_COUNT(scenes);
}

static void test_payloads(void **state) {
    static const certified_way ways[] = {
        {"abuffer,ppc", {"abuffer.payload=float"}, 0, 100},
        {"abuffer,ppc", {"abuffer.mode=linked", "abuffer.payload=half"}, 0, 20},
        {"abuffer,ppc", {"abuffer.payload=unorm8"}, 3, 0},
        {"peel", {"peel.mode=dual", "peel.payload=half"}, 0, 20},
        {"stencil,ppc", {"stencil.payload=float"}, 0, 100},
        {"stencil,fpc", {"stencil.payload=half"}, 3, 20},
        {"stencil,ppc", {"stencil.payload=unorm8"}, 0, 0},
    };
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < scene_count(state); i++) {
        const uint64_t certified = hold(s, &scenes[i], ways, BASE_COUNT(ways));
        assert_true(certified >= 2ull * scenes[i].width * scenes[i].height * 4);
    }
    strata_close(s);
}

/* Colours from 1e-4 to 1e5 and alphas 0, 1/512, 1 - 2^-24, 1: what a narrow payload cuts off is not
 * certified, everything else is. */
static void test_bright(void **state) {
    static const certified_way wide = {"abuffer,ppc", {"abuffer.payload=float"}, 0, 0},
                               narrow[] = {{"abuffer,ppc", {"abuffer.payload=half"}, 0, 0},
                                           {"abuffer,ppc", {"abuffer.payload=unorm8"}, 0, 0}};
    static const oracle_case k = {ORACLE_FRAME("own:bright", 48, 48)};
    const uint64_t all = 48 * 48 * 4;
    strata *s = oracle_open(state);
    if (!s)
        skip();
    assert_int_equal(hold(s, &k, &wide, 1), all);
    for (size_t i = 0; i < 2; i++) {
        const uint64_t certified = hold(s, &k, &narrow[i], 1);
        assert_true(certified < all * 9 / 10 && certified > all / 4);
    }
    strata_close(s);
}

/* Folded as a tree, and ended early: what is not folded is lost. */
static void test_trees(void **state) {
    static const certified_way ways[] = {
        {"abuffer,fpc", {"fpc.mode=fragments", "abuffer.payload=float"}, 0, 100},
        {"abuffer,fpc", {"abuffer.mode=linked", "abuffer.payload=half"}, 0, 20},
        {"abuffer,fpc", {"fpc.mode=fragments", "fpc.threshold=0.05"}, 3, 0},
        {"abuffer,fpc", {"abuffer.payload=unorm8", "fpc.threshold=0.3"}, 0, 0},
    };
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 64, 48)},
        {ORACLE_FRAME("scene:shells?count=40&subdivision=1&transmission=0.6&core=0", 24, 24)},
        {ORACLE_FRAME("scene:layers?count=200&where=pixel&width=8&height=8&alpha=0.02", 8, 8)},
        {ORACLE_FRAME("scene:layers?count=10000&where=pixel&width=8&height=8&alpha=0.0004", 8, 8)},
        {ORACLE_FRAME("own:clear", 32, 32)},
    };
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < BASE_COUNT(cases); i++)
        assert_true(hold(s, &cases[i], ways, BASE_COUNT(ways)) > 0);
    strata_close(s);
}

/* The nearest k: what lies behind them is bounded, and not uselessly. */
static void test_truncation(void **state) {
    static const certified_way ways[] = {
        {"kplus,ppc", {"kplus.k=4"}, 0, 4},
        {"kplus,ppc", {"kplus.k=8"}, 3, 4},
        {"kplus,fpc", {"kplus.k=20", "kplus.payload=half"}, 0, 0},
        {"kplus,ppc", {"kplus.k=2", "kplus.payload=unorm8"}, 0, 0},
        {"peel", {"peel.layers=4"}, 0, 4},
        {"occupancy,kplus,ppc", {"kplus.k=3"}, 2, 4},
    };
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < scene_count(state); i++)
        assert_true(hold(s, &scenes[i], ways, BASE_COUNT(ways)) > 0);
    strata_close(s);
}

/* Fragments as they come: wherever their order was lost nothing is certified, and elsewhere the
 * walk was in order. */
static void test_streams(void **state) {
    static const certified_way ways[] = {
        {"kbuffer", {"kbuffer.k=3"}, 0, 0},
        {"kbuffer", {"kbuffer.k=2", "kbuffer.payload=half"}, 3, 0},
        {"kbuffer", {"kbuffer.k=16", "kbuffer.payload=unorm8"}, 0, 0},
    };
    strata *s = oracle_open(state);
    if (!s)
        skip();
    uint64_t lost = 0, kept = 0;
    for (size_t w = 0; w < BASE_COUNT(ways); w++)
        for (size_t i = 0; i < scene_count(state); i++) {
            const uint64_t channels = 4ull * scenes[i].width * scenes[i].height,
                           certified = hold(s, &scenes[i], &ways[w], 1);
            if (s->result.bound.uncertified == s->result.report.lost)
                assert_int_equal(certified, channels - 4 * s->result.report.lost);
            lost += s->result.report.lost;
            kept += certified;
        }
    assert_true(lost > 1000 && kept > 1000);
    strata_close(s);
}

/* A tolerance is held, or said to be missed; what the user set stays. */
static void test_tolerance(void **state) {
    static const struct {
        const char *use, *setting;
        double tolerance;
        strata_result result;
    } rows[] = {
        {NULL, NULL, 0.3, STRATA_OK},
        {NULL, NULL, 0.01, STRATA_OK},
        {NULL, NULL, 1e-5, STRATA_OK},
        {NULL, NULL, 1e-12, STRATA_PARTIAL},
        {"kplus", "kplus.k=2", 0.01, STRATA_PARTIAL},
        {"kplus", NULL, 0.05, STRATA_OK},
        {"kplus", NULL, 1e-5, STRATA_OK},
        {"wboit", NULL, 0.5, STRATA_PARTIAL},
    };
    strata *s = oracle_open(state);
    if (!s)
        skip();
    strata_scene *sc = oracle_scene(s, scenes[0].scene);
    oracle_exact exact = oracle_exact_make(s, sc, &scenes[0]);
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = scenes[0].width,
                                               .height = scenes[0].height,
                                               .use = rows[i].use,
                                               .settings = &rows[i].setting,
                                               .setting_count = rows[i].setting != NULL,
                                               .tolerance = rows[i].tolerance,
                                               .background = {0.1f, 0.2f, 0.4f, 1.0f},
                                               .has_background = 1};
        assert_int_equal(strata_render(s, sc, &options), rows[i].result);
        assert_true(s->result.step_count > 0);
        const render_bound *bound = &s->result.bound;
        if (rows[i].result == STRATA_OK)
            assert_true(bound->uncertified == 0 && bound->max <= rows[i].tolerance);
        oracle_tally t = oracle_hold(s, &exact, "under a tolerance");
        oracle_tally_free(&t);
    }
    oracle_exact_free(&exact);
    strata_scene_close(sc);
    strata_close(s);
}

/* Long walks: faint layers whose errors add up, and one so long that ppc's fold is interrupted. */
static void test_depths(void **state) {
    static const certified_way ways[] = {
        {"abuffer,ppc", {"abuffer.payload=float"}, 0, 0},
        {"abuffer,ppc", {"abuffer.payload=unorm8"}, 0, 0},
    };
    static const oracle_case cases[] = {
        {ORACLE_FRAME("scene:layers?count=1500&where=pixel&width=8&height=8&alpha=0.004", 8, 8)},
        {ORACLE_FRAME("scene:layers?count=10000&where=pixel&width=8&height=8&alpha=9.5367e-7", 8,
                      8)},
        {ORACLE_FRAME("scene:layers?count=40000&where=pixel&width=8&height=8&alpha=0.00002", 8, 8)},
    };
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < BASE_COUNT(cases); i++)
        hold(s, &cases[i], ways, BASE_COUNT(ways));
    strata_close(s);
}

int main(int argc, char **argv) {
#define ON(test, backend)                                                                          \
    { .name = #test " on " backend, .test_func = test, .initial_state = (void *)(uintptr_t)backend }
    const struct CMUnitTest tests[] = {
        ON(test_tolerance, "vulkan"),  ON(test_tolerance, "gl"),  ON(test_trees, "vulkan"),
        ON(test_streams, "vulkan"),    ON(test_streams, "gl"),    ON(test_trees, "gl"),
        ON(test_truncation, "vulkan"), ON(test_truncation, "gl"), ON(test_payloads, "vulkan"),
        ON(test_payloads, "gl"),       ON(test_bright, "vulkan"), ON(test_bright, "gl"),
        ON(test_depths, "vulkan"),     ON(test_depths, "gl"),
    };
    return named_run("bound", argc > 1 ? argv[1] : NULL, tests, BASE_COUNT(tests));
}
