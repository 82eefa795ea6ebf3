/* SPDX-License-Identifier: MIT
 *
 * Scenes that move: channels of every interpolation, skins, morph targets, what follows the nodes,
 * and the edits of single instances. Expected values are worked out by hand.
 */
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "unit/scene_fixture.h"

static void set_time(scene *s, double seconds) {
    base_error err = {0};
    if (scene_set_time(s, seconds, &err) != STRATA_OK)
        fail_msg("%s", err.text);
}

/* ---- channels -------------------------------------------------------------------------------- */

/* A point at a node whose translation follows x = `values` (3 floats a value) at `times`. */
static scene *moving_point(const char *interpolation, uint32_t keys, const float *times,
                           uint32_t values, const float *data) {
    test_glb g = {0};
    test_glb_floats(&g, "VEC3", 3, 1, (const float[]){0, 0, 0});
    test_glb_floats(&g, "SCALAR", 1, keys, times);
    test_glb_floats(&g, "VEC3", 3, values, data);
    test_glb_json(&g,
                  "\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2%s}],\"channels\":"
                  "[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}]",
                  interpolation);
    test_glb_json(&g,
                  "\"nodes\":[{\"mesh\":0,\"translation\":[-7,0,0]}],\"meshes\":[{\"primitives\":"
                  "[{\"mode\":0,\"attributes\":{\"POSITION\":0}}]}]");
    scene *s = load_glb(&g);
    assert_non_null(s->animations);
    expect_floats(s->instances[0].world + 12, (const float[]){-7, 0, 0}, 3); /* the rest pose */
    return s;
}

static void expect_x(scene *s, double time, float x) {
    uint64_t revision = s->revision;
    set_time(s, time);
    expect_floats(s->instances[0].world + 12, &x, 1);
    expect_floats(s->lower, &x, 1); /* the bounds came along */
    assert_true(s->revision > revision);
}

static void linear_keys(void **state) {
    static const float times[3] = {1, 2, 4}, values[9] = {10, 0, 0, 20, 0, 0, 0, 0, 0};
    (void)state;
    scene *s = moving_point("", 3, times, 3, values);
    expect_x(s, -5, 10);
    expect_x(s, 1, 10);
    expect_x(s, 1.25, 12.5f);
    expect_x(s, 2, 20);
    expect_x(s, 3.5, 5);
    expect_x(s, 1e30, 0);
    expect_x(s, 1.25, 12.5f); /* no trace of other times */
    scene_free(s);
}

static void stepped_keys(void **state) {
    static const float times[3] = {1, 2, 2}, values[9] = {10, 0, 0, 20, 0, 0, 30, 0, 0};
    (void)state;
    scene *s = moving_point(",\"interpolation\":\"STEP\"", 3, times, 3, values);
    expect_x(s, 0, 10);
    expect_x(s, 1.999, 10);
    expect_x(s, 2, 30);
    expect_x(s, 3, 30);
    scene_free(s);
}

static void cubic_keys(void **state) {
    /* In-tangent, value, out-tangent of each key; two seconds apart. */
    static const float times[2] = {1, 3};
    static const float values[18] = {99, 0, 0, 1, 0, 0, 2, 0, 0, -1, 0, 0, 5, 0, 0, 99, 0, 0};
    (void)state;
    scene *s = moving_point(",\"interpolation\":\"CUBICSPLINE\"", 2, times, 6, values);
    expect_x(s, 0, 1);
    expect_x(s, 1, 1);
    /* u = 1/2: (v0 + v1) / 2 + span * (out0 - in1) / 8 */
    expect_x(s, 2, 3.75f);
    /* u = 1/4: .84375 v0 + .140625 * 2 out0 + .15625 v1 - .046875 * 2 in1 */
    expect_x(s, 1.5, 0.84375f + 0.5625f + 0.78125f + 0.09375f);
    expect_x(s, 3, 5);
    expect_x(s, 4, 5);
    scene_free(s);
}

static void rotations_take_the_shorter_way(void **state) {
    const float half = 0.70710678f;
    const float times[2] = {0, 1}, turns[8] = {0, 0, 0, 1, 0, 0, -half, -half}; /* 90 degrees */
    (void)state;
    test_glb g = {0};
    test_glb_floats(&g, "SCALAR", 1, 2, times);
    test_glb_floats(&g, "VEC4", 4, 2, turns);
    test_glb_floats(&g, "VEC3", 3, 1, (const float[]){0, 0, 0});
    test_glb_json(
        &g, "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":"
            "[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}}]}],"
            "\"nodes\":[{\"children\":[1]},{\"camera\":0,\"mesh\":0,\"translation\":[1,0,0],"
            "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
            "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":1}}],"
            "\"meshes\":[{\"primitives\":[{\"mode\":0,\"attributes\":{\"POSITION\":2}}]}],"
            "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}}");
    scene *s = load_glb(&g);
    const struct {
        double time;
        float angle;
    } steps[] = {{0, 0}, {1.0 / 3, 0.52359878f}, {0.5, 0.78539816f}, {1, 1.57079633f}};
    for (size_t i = 0; i < BASE_COUNT(steps); i++) {
        set_time(s, steps[i].time);
        float at[3] = {cosf(steps[i].angle), sinf(steps[i].angle), 0};
        expect_floats(s->instances[0].world + 12, at, 3);
        expect_floats(s->cameras[0].world + 12, at, 3);
        expect_floats(s->cameras[0].world, at, 3); /* its x axis points away from the centre */
        expect_floats(s->lights[0].position, at, 3);
    }
    scene_free(s);
}

static void channels_that_move_nothing_are_warned_of(void **state) {
    static const float times[1] = {0}, values[3] = {1, 1, 1};
    (void)state;
    test_glb g = {0};
    test_glb_floats(&g, "SCALAR", 1, 1, times);
    test_glb_floats(&g, "VEC3", 3, 1, values);
    test_glb_json(&g, "\"nodes\":[{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],\"animations\":"
                      "[{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":["
                      "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}},"
                      "{\"sampler\":0,\"target\":{\"path\":\"scale\"}},"
                      "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"weights\"}}]}]");
    scene *s = load_glb(&g);
    assert_null(s->animations);
    expect_warning(s, "channels[0]: nodes[0] has a matrix: not moved");
    expect_warning(s, "nodes[0] has no morph targets: ignored");
    uint64_t revision = s->revision;
    set_time(s, 1);
    assert_true(s->revision == revision);
    assert_int_equal(scene_set_time(s, NAN, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    scene_free(s);
}

static void a_pose_that_overflows_changes_nothing(void **state) {
    static const float times[2] = {0, 1}, values[6] = {1, 1, 1, 3e38f, 1, 1};
    (void)state;
    test_glb g = {0};
    test_glb_floats(&g, "SCALAR", 1, 2, times);
    test_glb_floats(&g, "VEC3", 3, 2, values);
    test_glb_json(&g,
                  "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1}],\"channels\":"
                  "[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}]}],"
                  "\"nodes\":[{\"mesh\":0,\"children\":[1]},{\"scale\":[10,1,1],\"mesh\":0}],"
                  "\"meshes\":[{\"primitives\":[{\"mode\":0,\"attributes\":{\"POSITION\":1}}]}]");
    scene *s = load_glb(&g);
    base_error err = {0};
    set_time(s, 0.0);
    assert_int_equal(scene_set_time(s, 1.0, &err), STRATA_ERROR_BAD_FILE);
    assert_non_null(strstr(err.text, "nodes[1]: its transform to the world is not finite"));
    expect_floats(s->instances[0].world, (const float[]){1}, 1);
    expect_floats(s->instances[1].world, (const float[]){10}, 1);
    scene_free(s);
}

/* ---- deformation ----------------------------------------------------------------------------- */

/* The square as a strip, its two upper corners on joint 1, which moves up by t and turns; normals
 * given or left to the loader. */
static scene *skinned_square(const char *normals, int still) {
    static const unsigned char joints[16] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    static const float weights[16] = {2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, .5f, .5f, 0, 0};
    static const float inverse[32] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                      1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};
    static const float times[2] = {0, 1}, moves[6] = {0, 1, 0, 0, 3, 0};
    test_glb g = {0};
    add_square(&g);
    test_glb_accessor(&g, test_glb_view(&g, joints, 16, 0), TEST_GLB_U8, "VEC4", 4, "");
    test_glb_floats(&g, "VEC4", 4, 4, weights);
    test_glb_floats(&g, "MAT4", 16, 2, inverse);
    test_glb_floats(&g, "SCALAR", 1, 2, times);
    test_glb_floats(&g, "VEC3", 3, 2, moves);
    test_glb_floats(&g, "VEC3", 3, 4, (const float[]){0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    test_glb_json(&g,
                  "\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{\"mesh\":0,\"skin\":0,"
                  "\"translation\":[100,0,0]},{\"children\":[2]},{\"translation\":[0,2,0],"
                  "\"scale\":[1,1,2]}],\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":3}],"
                  "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0,"
                  "\"JOINTS_0\":1,\"WEIGHTS_0\":2%s}}]}]",
                  normals);
    if (!still)
        test_glb_json(&g, "\"animations\":[{\"samplers\":[{\"input\":4,\"output\":5}],\"channels\":"
                          "[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"translation\"}}]}]");
    return load_glb(&g);
}

static void skins_follow_their_joints(void **state) {
    (void)state;
    scene *s = skinned_square(",\"NORMAL\":6", 0);
    scene_mesh *mesh = &s->meshes[0];
    float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    expect_floats(s->instances[0].world, identity, 16);
    assert_non_null(mesh->deform);
    assert_int_equal(mesh->deform->influences, 4);
    expect_floats(mesh->positions, (const float[]){0, 0, 0, 1, 0, 0, 0, 2, 0, 1, 1.5f, 0}, 12);
    set_time(s, 0.5);
    expect_floats(mesh->positions, (const float[]){0, 0, 0, 1, 0, 0, 0, 2, 0, 1, 1.5f, 0}, 12);
    set_time(s, 1.0);
    expect_floats(mesh->positions, (const float[]){0, 0, 0, 1, 0, 0, 0, 3, 0, 1, 2, 0}, 12);
    expect_floats(mesh->upper, (const float[]){1, 3, 0}, 3);
    expect_floats(s->upper, (const float[]){1, 3, 0}, 3);
    expect_floats(mesh->normals + 6, (const float[]){0, 0, 1}, 3);
    set_time(s, 0.0);
    expect_floats(mesh->positions, (const float[]){0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, 12);
    scene_free(s);
}

static void a_still_skin_is_baked(void **state) {
    (void)state;
    scene *s = skinned_square("", 1);
    assert_null(s->animations);
    assert_null(s->meshes[0].deform);
    assert_int_equal(s->meshes[0].vertex_count, 6); /* flat */
    expect_floats(s->meshes[0].positions,
                  (const float[]){0, 0, 0, 1, 0, 0, 0, 2, 0, 1, 0, 0, 1, 1.5f, 0, 0, 2, 0}, 18);
    scene_free(s);
}

static void flat_normals_follow_the_deformation(void **state) {
    static const float lift[12] = {0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1};
    static const float times[2] = {0, 1}, amounts[4] = {0, 0, 1, 0.5f};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "VEC3", 3, 4, lift);
    test_glb_floats(&g, "SCALAR", 1, 2, times);
    test_glb_floats(&g, "SCALAR", 1, 4, amounts);
    test_glb_json(&g,
                  "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"weights\":[0.25]}],\"meshes\":"
                  "[{\"weights\":[0,2],\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0},"
                  "\"targets\":[{\"POSITION\":1},{\"NORMAL\":1}]}]}],\"animations\":[{\"samplers\":"
                  "[{\"input\":2,\"output\":3}],\"channels\":[{\"sampler\":0,\"target\":"
                  "{\"node\":0,\"path\":\"weights\"}}]}]");
    scene *s = load_glb(&g);
    assert_int_equal(s->mesh_count, 2); /* one for each node: their weights differ */
    expect_floats(s->meshes[0].positions + 6, (const float[]){0, 1, 0}, 3);
    expect_floats(s->meshes[1].positions + 6, (const float[]){0, 1, 0.25f}, 3);
    set_time(s, 1.0);
    const float half = 0.70710678f;
    expect_floats(s->meshes[0].positions + 6, (const float[]){0, 1, 1}, 3);
    for (size_t v = 0; v < 6; v++)
        expect_floats(s->meshes[0].normals + v * 3, (const float[]){0, -half, half}, 3);
    expect_floats(s->meshes[1].positions + 6, (const float[]){0, 1, 0.25f}, 3);
    expect_floats(s->meshes[0].upper, (const float[]){1, 1, 1}, 3);
    scene_free(s);
}

static void targets_move_normals_and_tangents(void **state) {
    static const float up[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    static const float tangents[16] = {1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1};
    static const float turned[12] = {3, 0, 0, 3, 0, 0, 3, 0, 0, 3, 0, 0};
    static const float back[12] = {-1, 2, 0, -1, 2, 0, -1, 2, 0, -1, 2, 0};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "VEC3", 3, 4, up);
    test_glb_floats(&g, "VEC4", 4, 4, tangents);
    test_glb_floats(&g, "VEC3", 3, 4, turned);
    test_glb_floats(&g, "VEC3", 3, 4, back);
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0,\"weights\":[0.25]}],\"meshes\":[{\"primitives\":"
                      "[{\"mode\":5,\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2},"
                      "\"targets\":[{\"NORMAL\":3,\"TANGENT\":4}]}]}]");
    scene *s = load_glb(&g);
    expect_floats(s->meshes[0].normals, (const float[]){0.6f, 0, 0.8f}, 3);
    float length = sqrtf(0.75f * 0.75f + 0.5f * 0.5f);
    expect_floats(s->meshes[0].tangents, (const float[]){0.75f / length, 0.5f / length, 0, -1}, 4);
    scene_free(s);
}

/* ---- edits ----------------------------------------------------------------------------------- */

static void edits_keep_numbers_and_move_bounds(void **state) {
    static const float elsewhere[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 10, 0, 0, 1};
    static const float times[2] = {0, 1}, values[6] = {1, 1, 1, 4, 4, 4};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "SCALAR", 1, 2, times);
    test_glb_floats(&g, "VEC3", 3, 2, values);
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[5,0,0]}],\"meshes\":"
                      "[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0}}]}],"
                      "\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":"
                      "[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}]}]");
    scene *s = load_glb(&g);
    base_error err = {0};
    assert_int_equal(scene_set_transform(s, 0, elsewhere, &err), STRATA_OK);
    assert_true(s->revision == 1);
    expect_floats(s->upper, (const float[]){12, 2, 0}, 3);
    set_time(s, 1.0);
    expect_floats(s->instances[0].world, elsewhere, 16); /* its node no longer moves it */
    assert_int_equal(scene_set_visible(s, 0, 0, &err), STRATA_OK);
    expect_floats(s->upper, (const float[]){6, 1, 0}, 3);
    assert_int_equal(s->instances[1].primitive_base, 2);
    assert_int_equal(s->primitive_count, 4);
    assert_int_equal(scene_set_visible(s, 1, 0, &err), STRATA_OK);
    assert_true(s->lower[0] > s->upper[0]);
    assert_int_equal(scene_set_visible(s, 0, 77, &err), STRATA_OK);
    assert_int_equal(s->instances[0].visible, 1);
    expect_floats(s->lower, (const float[]){10, 0, 0}, 3);

    uint64_t revision = s->revision;
    float broken[16] = {0};
    broken[7] = INFINITY;
    assert_int_equal(scene_set_transform(s, 0, broken, &err), STRATA_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(err.text, "instance 0: matrix[7] is not finite"));
    assert_int_equal(scene_set_transform(s, 2, elsewhere, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(scene_set_visible(s, 2, 1, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    assert_true(s->revision == revision);
    expect_floats(s->instances[0].world, elsewhere, 16);
    scene_free(s);
}

static void huge_bounds_stay_finite(void **state) {
    (void)state;
    test_glb g = {0};
    test_glb_floats(&g, "VEC3", 3, 3, (const float[]){-3e38f, 0, 0, 3e38f, 0, 0, 0, 3e38f, 1e-30f});
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0,\"scale\":[10,1,1]}],\"meshes\":[{\"primitives\":"
                      "[{\"attributes\":{\"POSITION\":0}}]}]");
    scene *s = load_glb(&g);
    expect_floats(s->lower, (const float[]){-FLT_MAX, 0, 0}, 3);
    expect_floats(s->upper, (const float[]){FLT_MAX, 3e38f, 1e-30f}, 3);
    for (size_t i = 0; i < 9; i++)
        assert_true(isfinite(s->meshes[0].normals[i]));
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(linear_keys),
        cmocka_unit_test(stepped_keys),
        cmocka_unit_test(cubic_keys),
        cmocka_unit_test(rotations_take_the_shorter_way),
        cmocka_unit_test(channels_that_move_nothing_are_warned_of),
        cmocka_unit_test(a_pose_that_overflows_changes_nothing),
        cmocka_unit_test(skins_follow_their_joints),
        cmocka_unit_test(a_still_skin_is_baked),
        cmocka_unit_test(flat_normals_follow_the_deformation),
        cmocka_unit_test(targets_move_normals_and_tangents),
        cmocka_unit_test(edits_keep_numbers_and_move_bounds),
        cmocka_unit_test(huge_bounds_stay_finite),
    };
    return cmocka_run_group_tests_name("scene time", tests, NULL, NULL);
}
