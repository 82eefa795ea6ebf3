/* SPDX-License-Identifier: MIT
 *
 * objects/1 as host/scene/upload.h makes it: every triangle is in one object, whose bounds are
 * those of its vertices, exactly; what is drawn does not change by it; edits arrive.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/stage.h"
#include "scene/upload_internal.h"

static scene *generated(const char *name, const char *knob) {
    scene *s = NULL;
    base_error err = {0};
    if (scene_generate(name, &knob, 1, &s, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return s;
}

static upload *make(gpu *g, const scene *s, uint32_t objects, uint32_t seed) {
    const upload_options options = {.objects = objects, .shuffle_seed = seed};
    upload *u = NULL;
    base_error err = {0};
    if (upload_create(g, s, &options, &u, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return u;
}

/* ---- what objects hold ----------------------------------------------------------------------- */

static void hold(const scene_mesh *mesh, const uint32_t *indices, const upload_object *object) {
    float lower[3], upper[3];
    for (uint32_t i = 0; i < object->index_count; i++)
        for (int axis = 0; axis < 3; axis++) {
            const float p = mesh->positions[indices[object->first_index + i] * 3 + (uint32_t)axis];
            lower[axis] = i == 0 || p < lower[axis] ? p : lower[axis];
            upper[axis] = i == 0 || p > upper[axis] ? p : upper[axis];
        }
    assert_memory_equal(object->lower, lower, sizeof lower);
    assert_memory_equal(object->upper, upper, sizeof upper);
}

/* One mesh, one instance: its objects follow each other in the indices, have 64 to 128 triangles,
 * and with the map each of the mesh's triangles appears once. */
static void clusters_hold_every_triangle(void **state) {
    (void)state;
    static const struct {
        const char *knob;
        uint32_t objects; /* of 8 * 4^n triangles */
    } rows[] = {
        {"subdivision=1", 1}, {"subdivision=2", 1}, {"subdivision=3", 4}, {"subdivision=5", 64}};
    gpu *g = stage_open("vulkan");
    if (!g)
        skip();
    for (size_t row = 0; row < BASE_COUNT(rows); row++)
        for (uint32_t seed = 0; seed < 2; seed++) {
            scene *s = generated("shells", rows[row].knob);
            for (uint32_t i = 0; i < s->instance_count; i++) /* one sphere is enough */
                s->instances[i].visible = i == 1;
            const scene_mesh *mesh = &s->meshes[s->instances[1].mesh];
            upload *u = make(g, s, 1, seed);
            base_error err = {0};
            uint32_t *indices = base_calloc(gpu_bytes(g, NULL) / 4, sizeof *indices);
            unsigned char *seen = base_calloc(mesh->index_count / 3, 1);
            const uint32_t last = rows[row].objects - 1;
            const uint64_t size =
                (uint64_t)(u->object[last].first_index + u->object[last].index_count) * 4;
            assert_int_equal(upload_count(u).objects, rows[row].objects);
            assert_int_equal(gpu_buffer_read(g, upload_indices(u), 0, size, indices, &err),
                             STRATA_OK);
            uint32_t triangles = 0;
            for (uint32_t i = 0; i <= last; i++) {
                const upload_object *o = &u->object[i];
                hold(mesh, indices, o);
                assert_int_equal(o->flags, i > 0 ? UPLOAD_OBJECT_CONTINUES : 0u);
                if (i > 0)
                    assert_int_equal(o->first_index,
                                     u->object[i - 1].first_index + u->object[i - 1].index_count);
                if (last > 0)
                    assert_in_range(o->index_count / 3, 64, 128);
                triangles += o->index_count / 3;
            }
            assert_int_equal(triangles, mesh->index_count / 3);
            for (uint32_t i = 0; i < triangles; i++) {
                const uint32_t *t = indices + u->object[0].first_index + i * 3;
                uint32_t k = 0;
                while (k < triangles && (seen[k] || memcmp(t, mesh->indices + k * 3, 12) != 0))
                    k++;
                assert_true(k < triangles);
                seen[k] = 1;
            }
            free(indices);
            free(seen);
            upload_free(u);
            scene_free(s);
        }
    gpu_close(g);
}

/* Instances of one mesh are told to be neighbours; whoever is hidden has no object. */
static void instances_are_objects(void **state) {
    (void)state;
    gpu *g = stage_open("null");
    assert_non_null(g);
    base_error err = {0};
    stage t = stage_new();
    stage_quad(&t, stage_material(&t, 1, 1, 1), -1, -1, 0, 0, 0);
    for (int i = 0; i < 3; i++)
        assert_non_null(scene_add_instance(t.s, &t.instances));
    stage_points(&t, 0, (const float[]){0, 0, 0}, NULL, 1);
    stage_finish(&t);
    upload *u = make(g, t.s, 1, 0);
    assert_int_equal(upload_count(u).objects, 5);
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(u->object[i].flags, i > 0 ? UPLOAD_OBJECT_NEXT : 0u);
    assert_int_equal(u->object[4].flags, UPLOAD_OBJECT_UNBOUNDED);
    assert_int_equal(scene_set_visible(t.s, 0, 0, &err), STRATA_OK);
    assert_int_equal(scene_set_visible(t.s, 2, 0, &err), STRATA_OK);
    assert_int_equal(upload_update(u, t.s, &err), STRATA_OK);
    assert_int_equal(upload_count(u).objects, 3);
    assert_int_equal(u->object[0].flags, 0);
    assert_int_equal(u->object[1].flags, UPLOAD_OBJECT_NEXT);
    upload_free(u);
    u = make(g, t.s, 0, 0); /* not asked for */
    assert_int_equal(upload_count(u).objects, 0);
    assert_null(u->object);
    upload_free(u);
    gpu_close(g);
    scene_free(t.s);
}

/* A mesh that deforms is one object, and its bounds follow the pose. */
static void poses_move_bounds(void **state) {
    (void)state;
    gpu *g = stage_open("null");
    assert_non_null(g);
    base_error err = {0};
    scene *s = generated("shells", "subdivision=4");
    scene_mesh *mesh = &s->meshes[s->instances[0].mesh];
    mesh->deform = base_calloc(1, sizeof *mesh->deform);
    assert_non_null(mesh->deform);
    upload *u = make(g, s, 1, 0);
    const uint32_t objects = upload_count(u).objects;
    assert_int_equal(u->object[0].index_count, mesh->index_count);
    mesh->lower[1] = -7.5f;
    mesh->upper[2] = 9.25f;
    assert_int_equal(upload_update(u, s, &err), STRATA_OK);
    assert_int_equal(upload_count(u).objects, objects);
    assert_true(u->object[0].lower[1] == -7.5f && u->object[0].upper[2] == 9.25f);
    upload_free(u);
    gpu_close(g);
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clusters_hold_every_triangle),
        cmocka_unit_test(instances_are_objects),
        cmocka_unit_test(poses_move_bounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
