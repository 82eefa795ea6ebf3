/* SPDX-License-Identifier: MIT
 *
 * The renderer held to the ray oracle: in every pixel exactly those fragments are captured that a
 * ray through its centre meets, at their depths and in their order. Isolates capture: projection,
 * coverage, clipping, facing, occlusion by what is opaque, numbering.
 */
#include "oracle/oracle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ray_case {
    oracle_case render;
    double open;       /* largest share of fragments that may be left open, percent */
    uint32_t each;     /* not 0: fragments that each pixel has */
    const char *needs; /* what the case is for: "seams", "ties" or NULL */
} ray_case;

static void check_each(const oracle_capture *c, uint32_t each) {
    for (size_t p = 0; p < (size_t)c->width * c->height; p++)
        if (c->first[p + 1] - c->first[p] != each)
            fail_msg("pixel %zu has %zu fragments, not %u", p, c->first[p + 1] - c->first[p], each);
}

static void check_verdict(const ray_case *k, const oracle_verdict *v) {
    const uint64_t open = v->edge + v->hidden_or_not;
    const double share = 100.0 * (double)open / (double)(v->judged + open + 1);
    print_message("  %-50s %6llu judged; open: %llu at edges (%llu drawn), %llu by depth; %llu "
                  "seams, %llu ties, %llu slivers; depth error <= %.2f tolerance\n",
                  k->render.scene, (unsigned long long)v->judged, (unsigned long long)v->edge,
                  (unsigned long long)v->edge_drawn, (unsigned long long)v->hidden_or_not,
                  (unsigned long long)v->seams, (unsigned long long)v->ties,
                  (unsigned long long)v->slivers, v->worst_depth);
    if (v->missing + v->surplus + v->misplaced + v->disordered + v->opaque_wrong + v->seam_wrong)
        fail_msg("%s: %llu missing, %llu surplus, %llu misplaced, %llu disordered, %llu opaque "
                 "depths, %llu seams; first: %s",
                 k->render.scene, (unsigned long long)v->missing, (unsigned long long)v->surplus,
                 (unsigned long long)v->misplaced, (unsigned long long)v->disordered,
                 (unsigned long long)v->opaque_wrong, (unsigned long long)v->seam_wrong, v->first);
    if (share > k->open)
        fail_msg("%s: %.2f %% of the fragments are left open", k->render.scene, share);
    if (k->needs)
        assert_true((strcmp(k->needs, "seams") ? v->ties : v->seams) > 50);
}

static oracle_verdict cast_one(strata *s, strata_scene *sc, const ray_case *k) {
    oracle_capture c;
    oracle_verdict v;
    oracle_capture_frame(s, sc, &k->render, &c);
    oracle_judge(&c, &v);
    check_verdict(k, &v);
    if (k->each)
        check_each(&c, k->each);
    oracle_capture_free(&c);
    return v;
}

static void cast_all(void **state, const ray_case *cases, size_t count) {
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < count; i++) {
        strata_scene *sc = oracle_scene(s, cases[i].render.scene);
        cast_one(s, sc, &cases[i]);
        strata_scene_close(sc);
    }
    strata_close(s);
}

/* ---- cases ----------------------------------------------------------------------------------- */

static void test_perspective(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 96, 80)}, .open = 2},
        {.render = {ORACLE_FRAME("scene:shells?count=4&subdivision=2", 96, 96)},
         .open = 2,
         .needs = "seams"},
        {.render = {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 96, 72)}, .open = 18},
        {.render = {ORACLE_FRAME("scene:particles?count=400&radius=0.08", 80, 80)}, .open = 4},
        {.render = {ORACLE_FRAME("scene:city?count=30&glass=0.6", 96, 64), .camera = "aerial"},
         .open = 4},
        {.render = {ORACLE_FRAME("scene:city?count=30&glass=0.6", 96, 64), .camera = "street"},
         .open = 4},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

static void test_orthographic(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("scene:layers?count=1&width=31&height=23", 31, 23)},
         .open = 2,
         .each = 1},
        {.render = {ORACLE_FRAME("scene:layers?count=65&width=32&height=32", 32, 32)},
         .open = 8,
         .each = 65,
         .needs = "seams"},
        {.render = {ORACLE_FRAME("scene:layers?count=1500&width=12&height=8&opaque=1", 12, 8)},
         .open = 1,
         .each = 1500},
        {.render = {ORACLE_FRAME("scene:stack?count=3&tilt=30", 64, 64)}, .open = 4},
        {.render = {ORACLE_FRAME("own:edges", 32, 32)}, .open = 100, .each = 2, .needs = "seams"},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

/* Transparent on opaque, and on transparent, at one depth. */
static void test_equal_depths(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("scene:stack?count=2", 64, 64)}, .open = 8, .needs = "ties"},
        {.render = {ORACLE_FRAME("scene:stack?count=3&opaque=1&split=1", 64, 64)},
         .open = 2,
         .needs = "ties"},
        {.render = {ORACLE_FRAME("scene:stack?count=100&merged=1", 64, 64)},
         .open = 2,
         .needs = "ties"},
        {.render = {ORACLE_FRAME("own:ties", 64, 64)}, .open = 2, .needs = "ties"},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

/* Triangles through each other, around and behind the eye, mirrored, seen from behind. */
static void test_geometry(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("own:crossing", 96, 96)}, .open = 4},
        {.render = {ORACLE_FRAME("own:inside", 96, 96)}, .open = 4},
        {.render = {ORACLE_FRAME("own:inside", 96, 96), .camera = "1"}, .open = 6},
        {.render = {ORACLE_FRAME("own:mirror", 96, 96)}, .open = 4},
        {.render = {ORACLE_FRAME("own:slivers", 96, 96)}, .open = 12},
        {.render = {ORACLE_FRAME("own:opaque", 48, 48)}},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

/* Numbers are the scene's, whatever the storage and the order of drawing. */
static void test_numbers(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("own:ties", 64, 64), .setting = {"abuffer.mode=linked"}},
         .open = 2,
         .needs = "ties"},
        {.render = {ORACLE_FRAME("own:ties", 64, 64), .shuffle = 5}, .open = 2, .needs = "ties"},
        {.render = {ORACLE_FRAME("own:mirror", 96, 96), .shuffle = 9}, .open = 4},
        {.render = {ORACLE_FRAME("scene:stack?count=100&merged=1", 64, 64), .shuffle = 2},
         .open = 8,
         .needs = "ties"},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

/* What is hidden keeps its numbers; what is moved is where it was moved to. */
static void test_edits(void **state) {
    static const float moved[16] = {0, 0.8f, 0,  0, -0.6f, 0,    0.1f, 0,
                                    0, 0.1f, -1, 0, 0.3f,  0.4f, 0,    1};
    const ray_case k = {.render = {ORACLE_FRAME("own:mirror", 96, 96)}, .open = 4};
    strata *s = oracle_open(state);
    if (!s)
        skip();
    strata_scene *sc = oracle_scene(s, k.render.scene);
    const oracle_verdict before = cast_one(s, sc, &k);
    assert_int_equal(strata_scene_set_visible(sc, 0, 0), STRATA_OK);
    const oracle_verdict hidden = cast_one(s, sc, &k);
    assert_true(hidden.judged + 100 < before.judged);
    assert_int_equal(strata_scene_set_transform(sc, 3, moved), STRATA_OK);
    const oracle_verdict after = cast_one(s, sc, &k);
    assert_true(after.judged != hidden.judged);
    strata_scene_close(sc);
    strata_close(s);
}

/* ---- the oracle itself ----------------------------------------------------------------------- */

static uint64_t wrongs(const oracle_capture *c) {
    oracle_verdict v;
    oracle_judge(c, &v);
    return v.missing + v.surplus + v.misplaced + v.disordered + v.opaque_wrong + v.seam_wrong;
}

/* A pixel with an opaque surface and several records, the second at 0.75, which is exact. */
static size_t find_pixel(const oracle_capture *c) {
    for (size_t p = 0; p < (size_t)c->width * c->height; p++)
        if (c->first[p + 1] - c->first[p] >= 3 && c->depth[p] != 0.0f &&
            oracle_depth(&c->records[c->first[p] + 1]) == 0.75f)
            return p;
    fail_msg("there is no such pixel");
    return 0;
}

/* One thing wrong in one pixel of a frame without open questions must be found. */
static void test_power(void **state) {
    enum { NOTHING, KEY, ORDER, NUMBER, TWICE, DEPTH, KINDS };
    const oracle_case k = {ORACLE_FRAME("own:ties", 64, 64)};
    strata *s = oracle_open(state);
    if (!s)
        skip();
    strata_scene *sc = oracle_scene(s, k.scene);
    oracle_capture c;
    oracle_capture_frame(s, sc, &k, &c);
    assert_int_equal(wrongs(&c), 0); /* and sorts */
    const size_t p = find_pixel(&c);
    oracle_record *r = &c.records[c.first[p]];
    const oracle_record kept[3] = {r[0], r[1], r[2]};
    const float depth = c.depth[p];
    for (int kind = NOTHING; kind < KINDS; kind++) {
        r[1].key += kind == KEY ? 1 : 0;
        r[1].key -= kind == ORDER ? 0x00400000u : 0;
        r[1].order -= kind == NUMBER ? 1 : 0;
        r[1] = kind == TWICE ? r[0] : r[1];
        c.depth[p] = kind == DEPTH ? depth * 0.999999f : depth;
        if ((wrongs(&c) > 0) != (kind != NOTHING))
            fail_msg("kind %d of wrong records", kind);
        memcpy(r, kept, sizeof kept);
    }
    oracle_capture_free(&c);
    strata_scene_close(sc);
    strata_close(s);
}

#define ON_EACH(test)                                                                              \
    {#test "_vulkan", test, NULL, NULL, "vulkan"}, {                                               \
#test "_gl", test, NULL, NULL, "gl"                                                        \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        ON_EACH(test_perspective), ON_EACH(test_orthographic), ON_EACH(test_equal_depths),
        ON_EACH(test_geometry),    ON_EACH(test_numbers),      ON_EACH(test_edits),
        ON_EACH(test_power),
    };
    return cmocka_run_group_tests_name("oracle_ray", tests, NULL, NULL);
}
