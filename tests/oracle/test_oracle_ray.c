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

static void cast_all(void **state, const ray_case *cases, size_t count) {
    strata *s = oracle_open(state);
    if (!s)
        skip();
    for (size_t i = 0; i < count; i++) {
        strata_scene *sc = oracle_scene(s, cases[i].render.scene);
        oracle_capture c;
        oracle_verdict v;
        oracle_capture_frame(s, sc, &cases[i].render, &c);
        oracle_judge(&c, &v);
        check_verdict(&cases[i], &v);
        if (cases[i].each)
            check_each(&c, cases[i].each);
        oracle_capture_free(&c);
        strata_scene_close(sc);
    }
    strata_close(s);
}

/* ---- cases ----------------------------------------------------------------------------------- */

static void test_perspective(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("scene:soup?small=1500&medium=150&depth=14", 96, 80)}, .open = 2},
        {.render = {ORACLE_FRAME("scene:shells?count=4&subdivision=2", 96, 96)},
         .open = 8,
         .needs = "seams"},
        {.render = {ORACLE_FRAME("scene:glass?detail=1&smoke=300", 96, 72)}, .open = 18},
        {.render = {ORACLE_FRAME("scene:particles?count=400&radius=0.08", 80, 80)}, .open = 4},
        {.render = {ORACLE_FRAME("scene:city?count=30&glass=0.6", 96, 64), .camera = "aerial"},
         .open = 12},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

static void test_orthographic(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("scene:layers?count=1&width=31&height=23", 31, 23)},
         .open = 20,
         .each = 1},
        {.render = {ORACLE_FRAME("scene:layers?count=65&width=32&height=32", 32, 32)},
         .open = 20,
         .each = 65,
         .needs = "seams"},
        {.render = {ORACLE_FRAME("scene:layers?count=1500&width=12&height=8&opaque=1", 12, 8)},
         .open = 40,
         .each = 1500},
        {.render = {ORACLE_FRAME("scene:stack?count=3&tilt=30", 64, 64)}, .open = 60},
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
        {.render = {ORACLE_FRAME("own:opaque", 48, 48)}, .open = 100},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

static void test_linked(void **state) {
    static const ray_case cases[] = {
        {.render = {ORACLE_FRAME("own:crossing", 96, 96), .setting = {"abuffer.mode=linked"}},
         .open = 4},
        {.render = {ORACLE_FRAME("own:ties", 64, 64), .setting = {"abuffer.mode=linked"}},
         .open = 2,
         .needs = "ties"},
    };
    cast_all(state, cases, BASE_COUNT(cases));
}

#define ON_EACH(test)                                                                              \
    {#test "_vulkan", test, NULL, NULL, "vulkan"}, {                                               \
#test "_gl", test, NULL, NULL, "gl"                                                        \
    }

int main(void) {
    const struct CMUnitTest tests[] = {
        ON_EACH(test_perspective), ON_EACH(test_orthographic), ON_EACH(test_equal_depths),
        ON_EACH(test_geometry),    ON_EACH(test_linked),
    };
    return cmocka_run_group_tests_name("oracle_ray", tests, NULL, NULL);
}
