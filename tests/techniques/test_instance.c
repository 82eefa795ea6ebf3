/* SPDX-License-Identifier: MIT
 *
 * An instance over its life: edits of the scene, other sizes, other scenes and many frames leave no
 * trace in the picture or in memory; instances on two threads do not disturb each other.
 */
#define _GNU_SOURCE

#include "techniques/picture.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "gpu/gpu_internal.h"
#include "render/render.h"
#include "scenes/glb.h"

static const char *const backends[] = {"vulkan", "gl"};
static char path[] = "/tmp/strata-instance-XXXXXX.glb";

/* An opaque square that moves, one of glass that opens (a morph target), one of glass that stands
 * still; a camera of their own, so that nothing but the edit changes the picture. */
static int write_scene(void **state) {
    static const float square[12] = {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0};
    static const float opened[12] = {0.5f, 0, 0, 0, 0, 0, 0, 0, 0.5f, 0, 0.5f, 0};
    static const float times[2] = {0, 1}, moved[6] = {-1, 0, 0, 1, 0.5f, -1}, weights[2] = {0, 1};
    test_glb g = {0};
    size_t size;
    (void)state;
    test_glb_floats(&g, "VEC3", 3, 4, square);
    test_glb_floats(&g, "VEC3", 3, 4, opened);
    test_glb_floats(&g, "SCALAR", 1, 2, times);
    test_glb_floats(&g, "VEC3", 3, 2, moved);
    test_glb_floats(&g, "SCALAR", 1, 2, weights);
    test_glb_json(
        &g, "\"nodes\":[{\"mesh\":0},{\"mesh\":1,\"translation\":[0.2,0.1,0.4]},"
            "{\"mesh\":2,\"translation\":[-0.3,0,0.8]},{\"camera\":0,\"translation\":[0,0,5]}],"
            "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.6,\"znear\":0.1}}],"
            "\"materials\":[{\"doubleSided\":true},"
            "{\"doubleSided\":true,\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":"
            "{\"baseColorFactor\":[1,0.5,0.2,0.4]}},{\"doubleSided\":true,\"alphaMode\":\"BLEND\","
            "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.5,1,0.6]}}],"
            "\"meshes\":[{\"primitives\":[{\"mode\":5,\"material\":0,\"attributes\":{\"POSITION\":"
            "0}}]},"
            "{\"weights\":[0],\"primitives\":[{\"mode\":5,\"material\":1,\"attributes\":{"
            "\"POSITION\":0},"
            "\"targets\":[{\"POSITION\":1}]}]},"
            "{\"primitives\":[{\"mode\":5,\"material\":2,\"attributes\":{\"POSITION\":0}}]}]");
    test_glb_json(
        &g, "\"animations\":[{\"samplers\":[{\"input\":2,\"output\":3},{\"input\":2,"
            "\"output\":4}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":"
            "\"translation\"}},{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"weights\"}}]}]");
    unsigned char *file = test_glb_finish(&g, &size);
    const int fd = mkstemps(path, 4);
    if (fd < 0)
        return -1;
    const ssize_t wrote = write(fd, file, size);
    free(file);
    return close(fd) != 0 || wrote != (ssize_t)size;
}

static int remove_scene(void **state) {
    (void)state;
    return unlink(path);
}

static strata *open_on(const char *backend) {
    const strata_open_options options = {.struct_size = sizeof options, .backend = backend};
    strata *s = NULL;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    return s;
}

static strata_scene *load(strata *s, const char *name) {
    strata_scene *sc = NULL;
    if (strata_scene_load(s, name, &sc) != STRATA_OK)
        fail_msg("%s: %s", name, strata_error(s));
    return sc;
}

/* ---- edits and sizes ------------------------------------------------------------------------- */

typedef enum edit_kind { TIME, MATRIX, VISIBLE, SIZE, OTHER_SCENE } edit_kind;

typedef struct edit {
    edit_kind kind;
    uint32_t instance, value; /* visible; or the width */
    uint32_t shows;           /* the picture is another */
    double time;
    float world[16];
} edit;

static const edit edits[] = {
    {.kind = TIME, .time = 0.25, .shows = 1},
    {.kind = MATRIX,
     .instance = 2,
     .shows = 1,
     .world = {0.5f, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0, 0, -0.5f, 1}},
    {.kind = SIZE, .value = 33},
    {.kind = VISIBLE, .instance = 1, .value = 0, .shows = 1},
    {.kind = TIME, .time = 0.75, .shows = 1},
    {.kind = SIZE, .value = 90},
    {.kind = VISIBLE, .instance = 1, .value = 1, .shows = 1},
    {.kind = OTHER_SCENE},
    {.kind = MATRIX, .instance = 1, .world = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 1}},
    {.kind = VISIBLE, .instance = 2, .value = 0},
    {.kind = VISIBLE, .instance = 1, .value = 0, .shows = 1},
    {.kind = TIME, .time = 0.5},
    {.kind = VISIBLE, .instance = 0, .value = 0},
    {.kind = VISIBLE, .instance = 2, .value = 1},
    {.kind = MATRIX, .instance = 2, .world = {[15] = 1}}, /* no extent left */
    {.kind = TIME, .time = 0},
};

static void apply(strata_scene *sc, const edit *e, uint32_t *width) {
    strata_result r = STRATA_OK;
    if (e->kind == TIME)
        r = strata_scene_set_time(sc, e->time);
    else if (e->kind == MATRIX)
        r = strata_scene_set_transform(sc, e->instance, e->world);
    else if (e->kind == VISIBLE)
        r = strata_scene_set_visible(sc, e->instance, e->value);
    else if (e->kind == SIZE)
        *width = e->value;
    assert_int_equal(r, STRATA_OK);
}

static picture render_edited(strata *s, strata_scene *sc, uint32_t width) {
    return picture_render(sc, s, &(way){0}, width, 50);
}

/* The picture of an instance that loads the scene and makes the first `count` edits before it
 * renders at all. */
static picture made_anew(strata *fresh, size_t count) {
    strata_scene *sc = load(fresh, path);
    uint32_t width = 64;
    for (size_t i = 0; i < count; ++i)
        apply(sc, &edits[i], &width);
    picture p = render_edited(fresh, sc, width);
    strata_scene_close(sc);
    return p;
}

static void render_other(strata *s) {
    strata_scene *other = load(s, "scene:layers?count=3");
    picture p = render_edited(s, other, 20);
    picture_free(&p);
    strata_scene_close(other);
}

static void edit_on(const char *backend, strata *s) {
    strata *fresh = open_on(backend);
    strata_scene *sc = load(s, path);
    uint32_t width = 64;
    picture before = render_edited(s, sc, width);
    for (size_t i = 0; i < BASE_COUNT(edits); ++i) {
        char what[64];
        snprintf(what, sizeof what, "%s, edit %zu", backend, i);
        apply(sc, &edits[i], &width);
        if (edits[i].kind == OTHER_SCENE)
            render_other(s);
        picture edited = render_edited(s, sc, width), expected = made_anew(fresh, i + 1);
        picture_same(&expected, &edited, what);
        if (edits[i].shows)
            assert_true(picture_hash(&before) != picture_hash(&edited));
        picture_free(&before);
        picture_free(&expected);
        before = edited;
    }
    picture_free(&before);
    strata_close(fresh);
    strata_scene_close(sc);
}

static void edits_leave_no_trace(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *s = picture_instance(backends[b]);
        if (s)
            edit_on(backends[b], s);
    }
}

/* ---- many frames ----------------------------------------------------------------------------- */

/* Renders, moving the scene and the camera in a circle of ten frames. */
static void frames(strata *s, strata_scene *sc, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) {
        const strata_render_options options = {
            .struct_size = sizeof options, .width = 32, .height = 32, .angle = 36.0 * (i % 10)};
        assert_int_equal(strata_scene_set_time(sc, 0.1 * (i % 10)), STRATA_OK);
        assert_int_equal(strata_scene_set_visible(sc, 2, i % 10 != 7), STRATA_OK);
        if (strata_render(s, sc, &options) != STRATA_OK)
            fail_msg("frame %u: %s", i, strata_error(s));
    }
}

static size_t live_objects(const gpu *g) {
    size_t live = 0;
    for (size_t i = 0; i < g->slot_count; ++i)
        live += g->slots[i].object != NULL;
    return live;
}

static void frames_take_no_more_memory(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *s = picture_instance(backends[b]);
        if (!s)
            continue;
        strata_scene *sc = load(s, path);
        frames(s, sc, 20);
        const uint64_t bytes = gpu_bytes(s->gpu, NULL);
        const size_t objects = live_objects(s->gpu), slots = s->gpu->slot_count;
        frames(s, sc, 200);
        assert_int_equal(gpu_bytes(s->gpu, NULL), bytes);
        assert_int_equal(live_objects(s->gpu), objects);
        assert_int_equal(s->gpu->slot_count, slots);
        strata_scene_close(sc);
        assert_int_equal(gpu_bytes(s->gpu, "scene"), 0);
        assert_int_equal(gpu_bytes(s->gpu, "host"), 0);
        assert_int_equal(gpu_bytes(s->gpu, NULL), 0);
    }
}

/* ---- threads --------------------------------------------------------------------------------- */

static const char *const thread_scenes[] = {"scene:soup?small=300&medium=20", "scene:glass",
                                            "scene:layers?count=33"};

typedef struct job {
    const char *backend;
    uint64_t hashes[BASE_COUNT(thread_scenes)];
    char failure[256];
} job;

/* Opens an instance of its own and renders every scene; no cmocka here, which knows one thread. */
static void *work(void *user) {
    job *j = user;
    const strata_open_options options = {.struct_size = sizeof options, .backend = j->backend};
    const strata_render_options render = {.struct_size = sizeof render, .width = 40, .height = 40};
    float pixels[40 * 40 * 4];
    const picture p = {.width = 40, .height = 40, .pixels = pixels};
    strata *s = NULL;
    if (strata_open(&options, &s) != STRATA_OK)
        return NULL;
    for (size_t i = 0; i < BASE_COUNT(thread_scenes) && !j->failure[0]; ++i) {
        strata_scene *sc = NULL;
        strata_result r = strata_scene_load(s, thread_scenes[i], &sc);
        if (r == STRATA_OK)
            r = strata_render(s, sc, &render);
        if (r == STRATA_OK)
            r = strata_read(s, STRATA_OUTPUT_COLOR, pixels, sizeof pixels);
        if (r != STRATA_OK)
            snprintf(j->failure, sizeof j->failure, "%s: %s", j->backend, strata_error(s));
        j->hashes[i] = picture_hash(&p);
        strata_scene_close(sc);
    }
    strata_close(s);
    return NULL;
}

static void instances_on_threads_are_apart(void **state) {
    job alone = {.backend = NULL}, jobs[4] = {{0}};
    pthread_t threads[4];
    size_t count = 0;
    (void)state;
    for (size_t b = 0; b < 2; ++b)
        for (size_t i = 0; i < 2 && picture_instance(backends[b]); ++i)
            jobs[count++].backend = backends[b];
    if (count == 0)
        skip();
    work(&alone);
    assert_string_equal(alone.failure, "");
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(pthread_create(&threads[i], NULL, work, &jobs[i]), 0);
    for (size_t i = 0; i < count; ++i)
        assert_int_equal(pthread_join(threads[i], NULL), 0);
    for (size_t i = 0; i < count; ++i) {
        assert_string_equal(jobs[i].failure, "");
        assert_memory_equal(jobs[i].hashes, alone.hashes, sizeof alone.hashes);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(edits_leave_no_trace),
        cmocka_unit_test(frames_take_no_more_memory),
        cmocka_unit_test(instances_on_threads_are_apart),
    };
    const int failed = cmocka_run_group_tests_name("instances", tests, write_scene, remove_scene);
    picture_close();
    return failed;
}
