/* SPDX-License-Identifier: MIT
 *
 * host/plan/estimate.h: how many opaque triangles others hide, or the view does not hold.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/stage.h"
#include "plan/estimate.h"
#include "scene/camera.h"

enum { QUADS = 100 };

/* A hundred quads of a tenth of the image's side in a grid, at depth z, moved by x. */
static void add_grid(stage *t, uint32_t material, float z, float x) {
    stage_quad(t, material, -0.05f, -0.05f, 0.05f, 0.05f, z);
    const uint32_t mesh = t->s->instances[t->s->instance_count - 1].mesh;
    for (uint32_t i = 0; i < QUADS; i++) {
        scene_instance *instance = &t->s->instances[t->s->instance_count - 1];
        if (i > 0)
            instance = scene_add_instance(t->s, &t->instances);
        assert_non_null(instance);
        instance->mesh = mesh;
        instance->world[12] = (float)(i % 10) * 0.2f - 0.9f + x;
        instance->world[13] = (float)(i / 10) * 0.2f - 0.9f;
    }
}

static strata_scene_stats ask(const scene *s, const unsigned char *transparent) {
    strata_scene_stats stats;
    scene_view seen;
    estimate_view view = {.width = 200, .height = 200};
    base_error err = {0};
    assert_int_equal(scene_view_make(s, NULL, 0, 200, 200, &seen, &err), STRATA_OK);
    memcpy(view.world_to_clip, seen.world_to_clip, sizeof view.world_to_clip);
    assert_int_equal(estimate_stats(s, &view, transparent, &stats, &err), STRATA_OK);
    return stats;
}

static void assert_about(double value, double expected, double slack) {
    if (!(fabs(value - expected) <= slack))
        fail_msg("%g is not within %g of %g", value, slack, expected);
}

/* walls: how many times the image is covered in front of the grid, or behind it. A cover of n at
 * random leaves exp(-n) open; a quad is a 200th of half a wall, which makes 1.146 pieces of it. */
static void a_wall_hides(void **state) {
    (void)state;
    static const struct {
        uint32_t walls;
        float wall, x;
        double hidden, outside; /* triangles; the walls hide each other, too */
    } rows[] = {
        {0, 0, 0, 0, 0},      {1, 0.5f, 0, 200 * 0.591, 0}, {4, 0.5f, 0, 200 * 0.979, 0},
        {4, -0.8f, 0, 0, 0},  /* behind */
        {4, 0.5f, 5, 0, 200}, /* the grid is not in the view */
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const unsigned char transparent[2] = {0, 0};
        stage t = stage_new();
        const uint32_t material = stage_material(&t, 1, 1, 1);
        add_grid(&t, material, -0.5f, rows[i].x);
        for (uint32_t k = 0; k < rows[i].walls; k++)
            stage_quad(&t, material, -1, -1, 1, 1, rows[i].wall + 0.001f * (float)k);
        stage_finish(&t);
        const strata_scene_stats stats = ask(t.s, transparent);
        assert_int_equal(stats.opaque_objects, QUADS + rows[i].walls);
        assert_about(stats.hidden_triangles, rows[i].hidden, 2.0 * rows[i].walls + 1.0);
        assert_about(stats.outside_triangles, rows[i].outside, 0.5);
        scene_free(t.s);
    }
}

/* What is transparent hides nothing and is not counted; few objects are not asked about. */
static void others_do_not_count(void **state) {
    (void)state;
    stage t = stage_new();
    const uint32_t solid = stage_material(&t, 1, 1, 1), glass = stage_material(&t, 1, 1, 1);
    add_grid(&t, solid, -0.5f, 0);
    stage_quad(&t, glass, -1, -1, 1, 1, 0.5f);
    stage_finish(&t);
    unsigned char transparent[3] = {0, 1, 0};
    strata_scene_stats stats = ask(t.s, transparent);
    assert_int_equal(stats.opaque_objects, QUADS);
    assert_about(stats.hidden_triangles, 0, 0.5);
    transparent[0] = 1;
    transparent[1] = 0;
    stats = ask(t.s, transparent);
    assert_int_equal(stats.opaque_objects, 1);
    assert_about(stats.hidden_triangles + stats.outside_triangles + stats.opaque_overdraw, 0, 0);
    scene_free(t.s);
}

/* Of what cannot be seen in these views: culling finds 0.989 and 0.392 of the objects. */
static void cities(void **state) {
    (void)state;
    static const struct {
        const char *view;
        double least, most;
    } rows[] = {{"view=street", 0.9, 1.0}, {"view=aerial", 0.3, 0.45}};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const char *knobs[] = {"count=20000", "glass=0", rows[i].view};
        unsigned char transparent[16] = {0};
        scene *s = NULL;
        base_error err = {0};
        assert_int_equal(scene_generate("city", knobs, 3, &s, &err), STRATA_OK);
        const strata_scene_stats stats = ask(s, transparent), again = ask(s, transparent);
        const double share =
            (stats.hidden_triangles + stats.outside_triangles) / (double)stats.opaque_triangles;
        assert_memory_equal(&stats, &again, sizeof stats);
        if (!(share >= rows[i].least && share <= rows[i].most))
            fail_msg("%s: %g of the triangles are hidden or outside", rows[i].view, share);
        scene_free(s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_hides),
        cmocka_unit_test(others_do_not_count),
        cmocka_unit_test(cities),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
