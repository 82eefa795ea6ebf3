/* SPDX-License-Identifier: MIT
 *
 * host/scene/camera: which camera is meant, that it shows the bounds, that depth is reversed, that
 * matrices are inverse to each other, and that absurd bounds still give finite numbers.
 */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/camera.h"
#include "scene/scene_internal.h"

static scene *with_bounds(float lower, float upper) {
    scene *s = scene_new("bounds");
    assert_non_null(s);
    for (int i = 0; i < 3; i++) {
        s->lower[i] = lower;
        s->upper[i] = upper;
    }
    return s;
}

static scene *with_cameras(void) {
    scene *s = with_bounds(-1, 1);
    s->cameras = base_calloc(3, sizeof *s->cameras);
    assert_non_null(s->cameras);
    s->camera_count = 3;
    static const char *const names[] = {"front", "0", "flat"};
    for (int i = 0; i < 3; i++) {
        s->cameras[i] = (scene_camera){.name = base_strdup(names[i]),
                                       .node = SCENE_NONE,
                                       .yfov = 1.0f,
                                       .aspect = 3.0f,
                                       .znear = 0.5f,
                                       .zfar = i == 1 ? 100.0f : 0.0f};
        scene_identity(s->cameras[i].world);
        s->cameras[i].world[14] = 10.0f + (float)i;
    }
    s->cameras[2].projection = SCENE_ORTHOGRAPHIC;
    s->cameras[2].ymag = 2.0f;
    s->cameras[2].xmag = 9.0f;
    s->cameras[2].zfar = 20.5f;
    return s;
}

static scene_view view_of(const scene *s, const char *name, double turn, uint32_t w, uint32_t h) {
    scene_view view;
    base_error err = {0};
    if (scene_view_make(s, name, turn, w, h, &view, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return view;
}

static void transform(const float m[16], const double v[4], double out[4]) {
    for (int row = 0; row < 4; row++) {
        out[row] = 0;
        for (int k = 0; k < 4; k++)
            out[row] += (double)m[k * 4 + row] * v[k];
    }
}

static void close_to(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance * fmax(1.0, fabs(expected))))
        fail_msg("%.12g is not %.12g", value, expected);
}

static void all_finite(const scene_view *view) {
    const float *matrices[] = {view->world_to_eye, view->eye_to_clip, view->world_to_clip,
                               view->clip_to_world};
    for (int m = 0; m < 4; m++)
        for (int i = 0; i < 16; i++)
            assert_true(isfinite(matrices[m][i]));
    for (int i = 0; i < 4; i++)
        assert_true(isfinite(view->eye[i]));
}

/* ---- choice ---------------------------------------------------------------------------------- */

static void names_before_indices(void **state) {
    (void)state;
    scene *s = with_cameras();
    close_to((double)view_of(s, NULL, 0, 4, 4).eye[2], 10, 0);
    close_to((double)view_of(s, "front", 0, 4, 4).eye[2], 10, 0);
    close_to((double)view_of(s, "0", 0, 4, 4).eye[2], 11, 0); /* the one of that name */
    close_to((double)view_of(s, "1", 0, 4, 4).eye[2], 11, 0);
    assert_int_equal(view_of(s, "2", 0, 4, 4).orthographic, 1);
    assert_int_equal(view_of(s, "orbit:0,0", 0, 4, 4).from_scene, 0);
    scene_free(s);
}

static void unknown_ones_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *name, *says;
        strata_result result;
    } cases[] = {
        {"back", "front", STRATA_ERROR_NOT_FOUND},
        {"3", "flat", STRATA_ERROR_NOT_FOUND},
        {"99999999999999999999", "flat", STRATA_ERROR_NOT_FOUND},
        {"orbit:", "degrees", STRATA_ERROR_INVALID_ARGUMENT},
        {"orbit:1", "degrees", STRATA_ERROR_INVALID_ARGUMENT},
        {"orbit:1,2,3", "degrees", STRATA_ERROR_INVALID_ARGUMENT},
        {"orbit:nan,0", "degrees", STRATA_ERROR_INVALID_ARGUMENT},
        {"orbit:1e9,0", "degrees", STRATA_ERROR_INVALID_ARGUMENT},
        {"orbit:99999999999,0", "degrees", STRATA_ERROR_INVALID_ARGUMENT},
    };
    scene *s = with_cameras();
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        scene_view view;
        base_error err = {0};
        assert_int_equal(scene_view_make(s, cases[i].name, 0, 4, 4, &view, &err), cases[i].result);
        assert_non_null(strstr(err.text, cases[i].says));
    }
    scene_view view;
    assert_int_equal(scene_view_make(s, NULL, 0, 0, 4, &view, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(scene_view_make(s, NULL, (double)NAN, 4, 4, &view, NULL),
                     STRATA_ERROR_INVALID_ARGUMENT);
    scene_free(s);
}

/* ---- geometry -------------------------------------------------------------------------------- */

static void orbits_show_the_bounds(void **state) {
    (void)state;
    static const char *const orbits[] = {"orbit:0,0",   "orbit:30,20",     "orbit:90,-90",
                                         "orbit:45,90", "orbit:-137.5,61", "orbit:720,-45"};
    static const uint32_t sizes[][2] = {{100, 100}, {640, 480}, {7, 300}, {300, 7}};
    scene *s = with_bounds(-3, 5);
    s->upper[1] = -2.5f;
    for (size_t i = 0; i < BASE_COUNT(orbits); i++)
        for (size_t j = 0; j < BASE_COUNT(sizes); j++) {
            scene_view view = view_of(s, orbits[i], 0, sizes[j][0], sizes[j][1]);
            double largest = 0;
            for (int corner = 0; corner < 8; corner++) {
                double p[4] = {0, 0, 0, 1}, clip[4];
                for (int k = 0; k < 3; k++)
                    p[k] = (double)(corner >> k & 1 ? s->upper[k] : s->lower[k]);
                transform(view.world_to_clip, p, clip);
                assert_true(clip[3] > 0 && clip[2] > 0 && clip[2] < clip[3]);
                largest = fmax(largest, fmax(fabs(clip[0]), fabs(clip[1])) / clip[3]);
            }
            assert_true(largest < 0.96);
            assert_true(largest > 0.93); /* and fills the image */
        }
    scene_free(s);
}

static void depth_is_reversed(void **state) {
    (void)state;
    scene *s = with_cameras();
    for (uint32_t i = 0; i < 3; i++) {
        static const char *const names[] = {"front", "1", "flat"};
        scene_view view = view_of(s, names[i], 0, 200, 100);
        double ends[2] = {view.near, view.far > 0 ? view.far : 1e6};
        for (int end = 0; end < 2; end++) {
            double p[4] = {0, 0, -ends[end], 1}, clip[4];
            transform(view.eye_to_clip, p, clip);
            close_to(clip[2] / clip[3], end ? 0 : 1, 1e-6);
        }
        for (double distance = 1; distance < 20; distance *= 1.7) {
            double p[4] = {0, 0, -distance, 1}, clip[4];
            transform(view.eye_to_clip, p, clip);
            close_to(scene_view_distance(&view, clip[2] / clip[3]), distance, 1e-5);
        }
    }
    assert_true(isinf(scene_view_distance(&(scene_view){.near = 1}, 0.0)));
    scene_free(s);
}

/* The image's aspect counts, the camera's own does not; the vertical field of view is kept. */
static void aspect_is_that_of_the_image(void **state) {
    (void)state;
    scene *s = with_cameras();
    scene_view wide = view_of(s, "front", 0, 200, 100), tall = view_of(s, "front", 0, 100, 200);
    close_to(wide.half_height, tan(0.5), 1e-7);
    close_to(wide.half_width, 2 * tan(0.5), 1e-7);
    close_to(tall.half_height, tan(0.5), 1e-7);
    close_to(tall.half_width, 0.5 * tan(0.5), 1e-7);
    scene_view flat = view_of(s, "flat", 0, 300, 100);
    close_to(flat.half_height, 2, 0);
    close_to(flat.half_width, 6, 1e-12);
    close_to((double)flat.eye[3], 0, 0);
    close_to((double)flat.eye[2], 1, 0);
    scene_free(s);
}

static void matrices_are_inverse(void **state) {
    (void)state;
    scene *s = with_cameras();
    static const char *const names[] = {"front", "1", "flat", "orbit:200,-33"};
    for (int i = 0; i < 4; i++) {
        scene_view view = view_of(s, names[i], 17, 300, 200);
        for (int n = 0; n < 27; n++) {
            double p[4] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1, 1}, clip[4], back[4];
            transform(view.world_to_clip, p, clip);
            transform(view.clip_to_world, clip, back);
            for (int k = 0; k < 3; k++)
                close_to(back[k] / back[3], p[k], 1e-4);
        }
    }
    scene_free(s);
}

static void turns_go_around_the_centre(void **state) {
    (void)state;
    scene *s = with_bounds(2, 4);
    scene_view still = view_of(s, "orbit:0,10", 0, 64, 64);
    scene_view turned = view_of(s, "orbit:0,10", 90, 64, 64);
    scene_view orbit = view_of(s, "orbit:90,10", 0, 64, 64);
    for (int i = 0; i < 16; i++)
        close_to((double)turned.world_to_clip[i], (double)orbit.world_to_clip[i], 1e-6);
    close_to((double)still.eye[1], (double)turned.eye[1], 0);
    scene_view full = view_of(s, "orbit:0,10", 360, 64, 64);
    assert_memory_equal(full.world_to_clip, still.world_to_clip, sizeof still.world_to_clip);
    scene_free(s);
}

static void absurd_scenes_stay_finite(void **state) {
    (void)state;
    static const float bounds[][2] = {
        {FLT_MAX, -FLT_MAX}, {0, 0},           {-1e30f, 1e30f}, {-FLT_MAX, FLT_MAX},
        {-1e-30f, 1e-30f},   {1e-45f, 2e-45f}, {1e30f, 1e30f},  {-1e-38f, 1e38f}};
    static const char *const cameras[] = {NULL, "orbit:0,0", "orbit:12,-34"};
    for (size_t i = 0; i < BASE_COUNT(bounds); i++)
        for (size_t j = 0; j < BASE_COUNT(cameras); j++) {
            scene *s = with_bounds(bounds[i][0], bounds[i][1]);
            scene_view view = view_of(s, cameras[j], 5, 16384, 1);
            all_finite(&view);
            assert_true(view.near > 0);
            scene_free(s);
        }
}

/* A node whose axes vanish or are not finite numbers of unit length still gives a rigid camera. */
static void degenerate_nodes_stay_rigid(void **state) {
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        scene *s = with_cameras();
        float *world = s->cameras[0].world;
        for (int i = 0; i < 12; i++)
            world[i] *= kind == 0 ? 0.0f : kind == 1 ? 1e-20f : 1e18f;
        if (kind == 3) /* up along the view */
            memcpy(world + 4, world + 8, 3 * sizeof *world);
        if (kind == 2)
            s->cameras[0].yfov = s->cameras[0].znear = -1.0f;
        scene_view view = view_of(s, "front", 0, 8, 8);
        all_finite(&view);
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) {
                double sum = 0;
                for (int k = 0; k < 3; k++)
                    sum +=
                        (double)view.world_to_eye[k * 4 + a] * (double)view.world_to_eye[k * 4 + b];
                close_to(sum, a == b, 1e-6);
            }
        scene_free(s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_before_indices),        cmocka_unit_test(unknown_ones_are_refused),
        cmocka_unit_test(orbits_show_the_bounds),      cmocka_unit_test(depth_is_reversed),
        cmocka_unit_test(aspect_is_that_of_the_image), cmocka_unit_test(matrices_are_inverse),
        cmocka_unit_test(turns_go_around_the_centre),  cmocka_unit_test(absurd_scenes_stay_finite),
        cmocka_unit_test(degenerate_nodes_stay_rigid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
