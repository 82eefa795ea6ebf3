/* SPDX-License-Identifier: MIT
 *
 * Sequences through strata/host.h: a frame that continues keeps the plan, the session and what its
 * techniques hold, whatever the camera does; its picture is that of the frame alone; and what may
 * not be kept is made anew.
 */
#define _GNU_SOURCE

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "render/render.h"
#include "scenes/glb.h"

enum { WIDTH = 64, HEIGHT = 48, FRAMES = 5 };

static const char *const backends[] = {"vulkan", "gl"};
/* The plan goes by the camera: three layers from the front are captured, from the side peeled. */
static const char layers[] = "scene:layers?count=3";

static char lit_path[] = "/tmp/strata-sequence-XXXXXX.glb";

/* Two crossed squares of glass, one inside the other's bounds, that no light of the scene shines
 * on. */
static int write_lit(void **state) {
    static const float one[12] = {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0};
    static const float other[12] = {0, -1, -1, 0, -1, 1, 0, 1, -1, 0, 1, 1};
    test_glb g = {0};
    size_t size;
    (void)state;
    test_glb_floats(&g, "VEC3", 3, 4, one);
    test_glb_floats(&g, "VEC3", 3, 4, other);
    test_glb_json(
        &g, "\"nodes\":[{\"mesh\":0},{\"mesh\":1}],\"materials\":[{\"doubleSided\":true,"
            "\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.2,"
            "0.4]}}],\"meshes\":["
            "{\"primitives\":[{\"mode\":5,\"material\":0,\"attributes\":{\"POSITION\":0}}]},"
            "{\"primitives\":[{\"mode\":5,\"material\":0,\"attributes\":{\"POSITION\":1}}]}]");
    unsigned char *file = test_glb_finish(&g, &size);
    const int fd = mkstemps(lit_path, 4);
    if (fd < 0)
        return -1;
    const ssize_t wrote = write(fd, file, size);
    free(file);
    return close(fd) != 0 || wrote != (ssize_t)size;
}

static int remove_lit(void **state) {
    (void)state;
    return unlink(lit_path);
}

static strata *open_on(const char *backend) {
    const strata_open_options options = {.struct_size = sizeof options, .backend = backend};
    strata *s = NULL;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    return s;
}

static strata_scene *load(strata *s, const char *path) {
    strata_scene *sc = NULL;
    if (strata_scene_load(s, path, &sc) != STRATA_OK)
        fail_msg("%s: %s", path, strata_error(s));
    return sc;
}

static strata_render_options options_of(const char *camera, uint32_t continues) {
    return (strata_render_options){.struct_size = sizeof(strata_render_options),
                                   .width = WIDTH,
                                   .height = HEIGHT,
                                   .camera = camera,
                                   .continues = continues};
}

static void render(strata *s, strata_scene *sc, const strata_render_options *options) {
    if (strata_render(s, sc, options) != STRATA_OK)
        fail_msg("%s", strata_error(s));
}

static void render_named(strata *s, strata_scene *sc, const char *camera, uint32_t continues) {
    const strata_render_options options = options_of(camera, continues);
    render(s, sc, &options);
}

static const char *first_technique(const strata *s) {
    return s->session->plan->techniques[0].technique->id;
}

/* ---- what is kept ---------------------------------------------------------------------------- */

static void plan_and_session_stay(void **state) {
    (void)state;
    strata *s = open_on("null");
    strata_scene *sc = load(s, layers);
    render_named(s, sc, "orbit:90,0", 0);
    assert_string_equal(first_technique(s), "peel"); /* so this camera, alone, has another plan */
    render_named(s, sc, "orbit:0,0", 0);
    assert_string_equal(first_technique(s), "abuffer");
    assert_true(s->result.frames[0].prepared > 0);
    const render_session *session = s->session;
    const upload *uploaded = session->upload;
    const void *technique = session->techniques[0].state;
    const uint64_t begun = session->frame_index;
    static const char *const cameras[FRAMES] = {"orbit:90,0", "orbit:0,90", "orbit:0,0",
                                                "orbit:91,0", "orbit:12,-34"};
    for (uint32_t i = 0; i < FRAMES; ++i) {
        render_named(s, sc, cameras[i], 1);
        assert_ptr_equal(s->session, session);
        assert_ptr_equal(s->session->upload, uploaded);
        assert_ptr_equal(s->session->techniques[0].state, technique);
        assert_string_equal(first_technique(s), "abuffer");
        assert_int_equal(s->session->frame_index, begun + 1 + i);
        assert_int_equal(s->result.frame_count, 1);
        assert_int_equal(s->result.frames[0].prepared, 0);
    }
    render_named(s, sc, "orbit:90,0", 0); /* another sequence */
    assert_string_equal(first_technique(s), "peel");
    strata_close(s);
}

/* Another size, other settings, or a scene that calls for less: a plan for this frame. */
static void what_differs_is_planned(void **state) {
    (void)state;
    static const char *const settings[] = {"abuffer.mode=linked"};
    strata *s = open_on("null");
    strata_scene *sc = load(s, layers);
    for (int kind = 0; kind < 5; ++kind) {
        strata_render_options options = options_of("orbit:90,0", 1);
        render_named(s, sc, "orbit:0,0", 0);
        if (kind == 0)
            options.width++;
        else if (kind == 1)
            options.settings = settings;
        options.setting_count = kind == 1;
        if (kind == 2)
            options.use = "peel";
        if (kind == 3)
            options.effects = "over";
        if (kind == 4)
            assert_int_equal(strata_scene_set_visible(sc, 0, 0), STRATA_OK);
        render(s, sc, &options);
        assert_true(s->session->technique_count == 0 || strcmp(first_technique(s), "abuffer") != 0);
    }
    strata_close(s);
}

static void another_scene_is_another_sequence(void **state) {
    (void)state;
    strata *s = open_on("null");
    strata_scene *first = load(s, layers), *second = load(s, layers);
    render_named(s, first, "orbit:0,0", 1); /* nothing to continue: it begins one */
    assert_string_equal(first_technique(s), "abuffer");
    render_named(s, second, "orbit:90,0", 1);
    assert_string_equal(first_technique(s), "peel");
    assert_ptr_equal(s->start.scene, second->scene);
    strata_scene_close(second);
    strata_scene *third = load(s, layers); /* may stand where the second stood */
    render_named(s, third, "orbit:0,0", 1);
    assert_string_equal(first_technique(s), "abuffer");
    strata_close(s);
}

/* ---- pictures -------------------------------------------------------------------------------- */

typedef struct shot {
    float pixels[HEIGHT * WIDTH * 4];
} shot;

static strata_camera_pose pose_at(uint32_t frame) {
    strata_camera_pose pose = {.struct_size = sizeof pose, .target = {0.1, 0, -0.2}, .yfov = 50};
    pose.eye[0] = frame == 3 ? -3.0 : 0.4 * frame; /* the third is a cut */
    pose.eye[1] = 0.3;
    pose.eye[2] = 3.0 - 0.2 * frame;
    return pose;
}

static void shoot(strata *s, strata_scene *sc, uint32_t frame, uint32_t continues, shot *out) {
    const strata_camera_pose pose = pose_at(frame);
    strata_render_options options = options_of(NULL, continues);
    options.pose = &pose;
    options.use = "abuffer,ppc";
    render(s, sc, &options);
    assert_int_equal(strata_read(s, STRATA_OUTPUT_COLOR, out->pixels, sizeof out->pixels),
                     STRATA_OK);
}

/* The key light, which stands in for lights of the scene, is that of the first frame. */
static void frames_are_those_rendered_alone(void **state) {
    (void)state;
    static shot together[FRAMES], alone, lit;
    for (size_t b = 0; b < BASE_COUNT(backends); ++b) {
        strata *s = open_on(backends[b]);
        strata_scene *sc = load(s, lit_path);
        for (uint32_t i = 0; i < FRAMES; ++i) {
            shoot(s, sc, i, i > 0, &together[i]);
            assert_true(i == 0 || s->result.frames[0].prepared <= s->result.frames[0].retries);
        }
        strata_close(s);
        int differs = 0;
        for (uint32_t i = 1; i < FRAMES; ++i) {
            s = open_on(backends[b]);
            sc = load(s, lit_path);
            shoot(s, sc, i, 0, &lit); /* its own key light */
            shoot(s, sc, 0, 0, &alone);
            assert_memory_equal(&alone, &together[0], sizeof alone);
            shoot(s, sc, i, 1, &alone);
            assert_memory_equal(&alone, &together[i], sizeof alone);
            assert_memory_not_equal(&alone, &together[i - 1], sizeof alone);
            differs |= memcmp(&alone, &lit, sizeof alone) != 0;
            strata_close(s);
        }
        assert_true(differs);
    }
}

/* What an orbit frames does not follow what moves. */
static void an_orbit_frames_the_first(void **state) {
    (void)state;
    float away[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 50, 0, 0, 1};
    strata *s = open_on("null");
    strata_scene *sc = load(s, layers);
    render_named(s, sc, "orbit:0,0", 0);
    const scene_view first = s->result.view;
    assert_int_equal(strata_scene_set_transform(sc, 0, away), STRATA_OK);
    render_named(s, sc, "orbit:0,0", 1);
    assert_memory_equal(&s->result.view, &first, sizeof first);
    render_named(s, sc, "orbit:0,0", 0);
    assert_memory_not_equal(&s->result.view, &first, sizeof first);
    strata_close(s);
}

/* ---- the account ----------------------------------------------------------------------------- */

static strata_result collect(void *user, const char *bytes, size_t size) {
    base_text_append(user, bytes, size);
    return STRATA_OK;
}

static json_t *account_of(strata *s) {
    base_text text = {0};
    assert_int_equal(strata_account(s, collect, &text), STRATA_OK);
    json_t *account = json_loads(text.data, 0, NULL);
    assert_non_null(account);
    base_text_free(&text);
    return account;
}

static void every_frame_is_accounted(void **state) {
    (void)state;
    strata *s = open_on("vulkan");
    strata_scene *sc = load(s, layers);
    strata_render_options options = options_of("orbit:0,0", 0);
    options.repeat = 3;
    options.turn = 30;
    render(s, sc, &options);
    json_t *account = account_of(s), *frames = json_object_get(account, "frames");
    assert_int_equal(json_array_size(frames), 3);
    json_int_t totals[3];
    for (size_t i = 0; i < 3; ++i) {
        const json_t *frame = json_array_get(frames, i);
        totals[i] =
            json_integer_value(json_object_get(json_object_get(frame, "fragments"), "total"));
        assert_true(totals[i] > 0);
        assert_true(json_real_value(json_object_get(frame, "ms")) > 0);
        assert_int_equal(json_integer_value(json_object_get(frame, "prepared")) > 0,
                         i == 0 || json_integer_value(json_object_get(frame, "retries")) > 0);
    }
    assert_true(totals[0] != totals[1] && totals[1] != totals[2]);
    assert_true(json_equal(json_object_get(json_array_get(frames, 2), "fragments"),
                           json_object_get(account, "fragments")));
    json_decref(account);
    strata_close(s);
}

/* ---- room ------------------------------------------------------------------------------------ */

/* Bytes of the device's memory that all of it takes. */
static uint64_t bytes_of(const strata *s) {
    return gpu_bytes(s->gpu, NULL);
}

/* A degree a frame brings more and deeper pixels: pools grow before they are short. Fragments of a
 * number that no pixel had before are still learnt by recording again, once here. */
static void what_moves_is_recorded_once(void **state) {
    (void)state;
    for (size_t b = 0; b < BASE_COUNT(backends); ++b) {
        strata *s = open_on(backends[b]);
        strata_scene *sc = load(s, "scene:soup");
        strata_render_options options = options_of(NULL, 0);
        options.width = 48;
        options.height = 36;
        options.use = "abuffer,ppc";
        render_named(s, sc, "orbit:90,0", 0);
        render(s, sc, &options); /* other stills are no motion */
        assert_int_equal(s->start.moving, 0);
        const uint64_t exact = bytes_of(s);
        options.continues = 1;
        for (int i = 0; i < 3; i++)
            render(s, sc, &options);
        assert_true(bytes_of(s) == exact); /* no reserve where nothing moves */
        options.repeat = 20;
        options.turn = 1;
        render(s, sc, &options);
        uint32_t again = 0;
        for (uint32_t i = 0; i < options.repeat; ++i)
            again += s->result.frames[i].retries;
        assert_in_range(again, 0, 1);
        assert_true(bytes_of(s) > exact);
        strata_close(s);
    }
}

/* ---- poses ----------------------------------------------------------------------------------- */

static void bad_poses_are_refused(void **state) {
    (void)state;
    strata *s = open_on("null");
    strata_scene *sc = load(s, layers);
    for (int kind = 0; kind < 10; ++kind) {
        strata_camera_pose pose = pose_at(0);
        strata_render_options options = options_of(NULL, 0);
        static const char *const said[] = {"struct_size", "finite",     "finite",   "eye is at",
                                           "yfov",        "yfov",       "negative", "negative",
                                           "far",         "struct_size"};
        options.pose = &pose;
        pose.struct_size = kind == 0 ? 0 : pose.struct_size;
        pose.eye[2] = kind == 1 ? (double)NAN : kind == 2 ? 1e31 : pose.eye[2];
        if (kind == 3)
            memcpy(pose.eye, pose.target, sizeof pose.eye);
        pose.yfov = kind == 4 ? 180 : kind == 5 ? -1 : pose.yfov;
        pose.height = kind == 6 ? -1 : 0;
        pose.near = kind == 7 ? -1 : kind == 8 ? 2 : 0;
        pose.far = kind == 8 ? 2 : 0;
        pose.reserved = kind == 9;
        assert_int_equal(strata_render(s, sc, &options), STRATA_ERROR_INVALID_ARGUMENT);
        assert_non_null(strstr(strata_error(s), said[kind]));
    }
    strata_render_options options = options_of(NULL, 2);
    assert_int_equal(strata_render(s, sc, &options), STRATA_ERROR_INVALID_ARGUMENT);
    strata_close(s);
}

static void cameras_have_poses(void **state) {
    (void)state;
    strata *s = open_on("null");
    strata_scene *sc = load(s, layers);
    strata_camera_pose pose = {.struct_size = sizeof pose};
    assert_int_equal(strata_scene_camera(sc, "orbit:30,20", WIDTH, HEIGHT, &pose), STRATA_OK);
    assert_int_equal(pose.struct_size, sizeof pose);
    assert_true(fabs(pose.up[1] - cos(acos(-1.0) / 9)) < 1e-12); /* 20 degrees from upright */
    render_named(s, sc, "orbit:30,20", 0);
    const scene_view named = s->result.view;
    strata_render_options options = options_of(NULL, 0);
    options.pose = &pose;
    render(s, sc, &options);
    for (int i = 0; i < 16; ++i) /* both from doubles: they differ by a rounding to float */
        assert_true(fabsf(named.world_to_clip[i] - s->result.view.world_to_clip[i]) <=
                    2.4e-7f * fmaxf(1.0f, fabsf(named.world_to_clip[i])));
    pose = (strata_camera_pose){0};
    assert_int_equal(strata_scene_camera(sc, NULL, 4, 4, &pose), STRATA_ERROR_INVALID_ARGUMENT);
    pose.struct_size = 32; /* an earlier version: no more than that is written */
    assert_int_equal(strata_scene_camera(sc, "orbit:30,20", 4, 4, &pose), STRATA_OK);
    assert_true(pose.struct_size == 32 && pose.eye[2] != 0 && pose.up[1] == 0 && pose.yfov == 0);
    assert_int_equal(strata_scene_camera(sc, "nowhere", 4, 4, &pose), STRATA_ERROR_NOT_FOUND);
    strata_close(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plan_and_session_stay),
        cmocka_unit_test(what_differs_is_planned),
        cmocka_unit_test(another_scene_is_another_sequence),
        cmocka_unit_test(frames_are_those_rendered_alone),
        cmocka_unit_test(an_orbit_frames_the_first),
        cmocka_unit_test(every_frame_is_accounted),
        cmocka_unit_test(what_moves_is_recorded_once),
        cmocka_unit_test(bad_poses_are_refused),
        cmocka_unit_test(cameras_have_poses),
    };
    return cmocka_run_group_tests(tests, write_lit, remove_lit);
}
