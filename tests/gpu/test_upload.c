/* SPDX-License-Identifier: MIT
 *
 * host/scene/upload: what is drawn does not depend on backend or order of submission, edits arrive,
 * ties are decided by primitive number, nothing is paid for what a scene does not have.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/stage.h"

static const drawing_options small = {.width = 64, .height = 64};

static scene *generated(const char *name) {
    scene *s = NULL;
    base_error err = {0};
    if (scene_generate(name, NULL, 0, &s, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return s;
}

static size_t covered(const drawing *d) {
    size_t count = 0;
    for (size_t i = 0; i < (size_t)d->width * d->height; i++)
        count += d->depths[i] > 0.0f;
    return count;
}

/* ---- the same bits everywhere ---------------------------------------------------------------- */

/* Every backend, submitted in order and in two others, with ties decided. */
static void draw_everywhere(const scene *s, const char *slot) {
    drawing first = {0};
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        for (uint32_t seed = 0; seed < 3 && g; seed++) {
            drawing d =
                stage_draw(g, s,
                           (drawing_options){
                               .width = 97, .height = 61, .seed = seed, .exact = 1, .slot = slot});
            assert_true(covered(&d) > 300);
            if (!first.pixels) {
                first = d;
                first.pixels = base_calloc(97 * 61, 16);
                first.depths = base_calloc(97 * 61, 4);
                assert_true(first.pixels && first.depths);
                memcpy(first.pixels, d.pixels, 97 * 61 * 16);
                memcpy(first.depths, d.depths, 97 * 61 * 4);
            } else if (!stage_same(&first, &d)) {
                fail_msg("%s, seed %u: other bits (%s)", stage_backends[b], seed, s->path);
            }
            drawing_free(&d);
        }
        gpu_close(g);
    }
    free(first.pixels);
    free(first.depths);
}

static void same_bits_glass(void **state) { /* lights, textures, splats, transmission */
    (void)state;
    scene *s = generated("glass");
    draw_everywhere(s, "draws.opaque/1");
    draw_everywhere(s, "draws.transparent/1");
    scene_free(s);
}

static void same_bits_city(void **state) { /* instances, textures */
    (void)state;
    scene *s = generated("city");
    draw_everywhere(s, "draws.opaque/1");
    scene_free(s);
}

static void same_bits_particles(void **state) {
    (void)state;
    scene *s = generated("particles");
    draw_everywhere(s, "draws.transparent/1");
    scene_free(s);
}

/* ---- ties ------------------------------------------------------------------------------------ */

static scene *coplanar(uint32_t count) {
    stage t = stage_new();
    for (uint32_t i = 0; i < count; i++)
        stage_quad(&t, stage_material(&t, (float)(i + 1) / 8.0f, 0, 0), -1, -1, 1, 1, 0);
    stage_finish(&t);
    return t.s;
}

static void ties_go_to_the_highest_primitive(void **state) {
    (void)state;
    scene *s = coplanar(7);
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        uint32_t others = 0;
        for (uint32_t seed = 0; seed < 4 && g; seed++) {
            drawing_options o = small;
            o.seed = seed;
            drawing any = stage_draw(g, s, o);
            others += stage_pixel(&any, 20, 20)[0] != 0.125f; /* the first in file order */
            drawing_free(&any);
            o.exact = 1;
            drawing exact = stage_draw(g, s, o);
            for (uint32_t i = 0; i < 64 * 64; i++)
                assert_true(exact.pixels[i * 4] == 0.875f);
            drawing_free(&exact);
        }
        if (g)
            assert_true(others > 0); /* else the shuffle proves nothing */
        gpu_close(g);
    }
    scene_free(s);
}

static void ties_within_one_mesh(void **state) {
    (void)state;
    stage t = stage_new();
    uint32_t m = stage_material(&t, 1, 1, 1);
    stage_quad(&t, m, -1, -1, 1, 1, 0);
    scene_mesh *mesh = &t.s->meshes[0];
    mesh->colors = base_calloc(12, 4 * sizeof(float));
    float *positions = base_calloc(12, 3 * sizeof(float));
    uint32_t *indices = base_calloc(18, sizeof *indices);
    assert_true(mesh->colors && positions && indices);
    for (uint32_t i = 0; i < 12; i++) { /* three coplanar quads in one mesh */
        memcpy(positions + i * 3, mesh->positions + i % 4 * 3, 3 * sizeof(float));
        mesh->colors[i * 4] = (float)(i / 4 + 1) / 4.0f;
        mesh->colors[i * 4 + 3] = 1.0f;
    }
    for (uint32_t i = 0; i < 18; i++)
        indices[i] = mesh->indices[i % 6] + i / 6 * 4;
    free(mesh->positions);
    free(mesh->indices);
    free(mesh->uv0);
    mesh->uv0 = NULL;
    mesh->positions = positions;
    mesh->indices = indices;
    mesh->vertex_count = 12;
    mesh->index_count = 18;
    stage_finish(&t);
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        for (uint32_t seed = 0; seed < 4 && g; seed++) {
            drawing d = stage_draw(
                g, t.s, (drawing_options){.width = 64, .height = 64, .seed = seed, .exact = 1});
            for (uint32_t i = 0; i < 64 * 64; i++)
                assert_true(d.pixels[i * 4] > 0.74f && d.pixels[i * 4] < 0.76f);
            drawing_free(&d);
        }
        gpu_close(g);
    }
    scene_free(t.s);
}

/* Two rounds, the second over the first, in every way to share four surfaces out: the picture is
 * that of one round. Three lie at one depth, the third of them in all is nearer in the right half.
 */
static void ties_across_rounds(void **state) {
    (void)state;
    base_error err = {0};
    stage t = stage_new();
    for (uint32_t i = 0; i < 4; i++)
        stage_quad(&t, stage_material(&t, (float)(i + 1) / 4.0f, 0, 0), i == 2 ? 0.0f : -1.0f, -1,
                   1, 1, i == 2 ? 1.0f : 0.0f);
    stage_finish(&t);
    drawing_options o = {.width = 64, .height = 64, .exact = 1};
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        for (uint32_t first = 0; first < 16 && g; first++) {
            for (uint32_t i = 0; i < 4; i++)
                assert_int_equal(scene_set_visible(t.s, i, first >> i & 1, &err), STRATA_OK);
            drawing d = stage_draw(g, t.s, o);
            for (uint32_t i = 0; i < 4; i++)
                assert_int_equal(scene_set_visible(t.s, i, !(first >> i & 1), &err), STRATA_OK);
            drawing_options again = o;
            again.round = 1;
            assert_int_equal(upload_update(d.u, t.s, &err), STRATA_OK);
            assert_true(drawing_draw(&d, t.s, &again, &err));
            for (uint32_t i = 0; i < 64 * 64; i++)
                assert_true(d.pixels[i * 4] == (i % 64 < 32 ? 1.0f : 0.75f));
            drawing_free(&d);
        }
        gpu_close(g);
    }
    scene_free(t.s);
}

/* ---- edits ----------------------------------------------------------------------------------- */

static void move_and_hide(scene *s, base_error *err) {
    float world[16];
    scene_identity(world);
    world[12] = 0.5f;
    assert_int_equal(scene_set_transform(s, 0, world, err), STRATA_OK);
    assert_int_equal(scene_set_visible(s, 2, 0, err), STRATA_OK);
}

static scene *three_instances(void) {
    stage t = stage_new();
    uint32_t m = stage_material(&t, 1, 0.5f, 0.25f);
    stage_quad(&t, m, -0.9f, -0.9f, -0.5f, -0.5f, 0);
    for (int i = 0; i < 2; i++) {
        scene_instance *instance = scene_add_instance(t.s, &t.instances);
        assert_non_null(instance);
        instance->mesh = 0;
        instance->world[13] = 0.6f * (float)(i + 1);
    }
    stage_finish(&t);
    return t.s;
}

static void edits_arrive(void **state) {
    (void)state;
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        if (!g)
            continue;
        base_error err = {0};
        scene *s = three_instances();
        drawing d = stage_draw(g, s, small);
        assert_int_equal(upload_count(d.u).opaque_draws, 1); /* three records, one command */
        assert_int_equal(upload_count(d.u).records, 3);
        assert_int_equal(upload_count(d.u).opaque_triangles, 6);
        size_t before = covered(&d);
        assert_int_equal(scene_set_visible(s, 1, 0, &err), STRATA_OK);
        assert_int_equal(upload_update(d.u, s, &err), STRATA_OK);
        assert_int_equal(upload_count(d.u).records, 2);
        assert_true(drawing_draw(&d, s, &small, &err));
        assert_in_range(covered(&d), before * 2 / 3 - 30, before * 2 / 3 + 30);
        assert_int_equal(scene_set_visible(s, 1, 1, &err), STRATA_OK);
        move_and_hide(s, &err);
        assert_int_equal(upload_update(d.u, s, &err), STRATA_OK);
        assert_true(drawing_draw(&d, s, &small, &err));
        drawing kept = d;
        kept.pixels = base_calloc(64 * 64, 16);
        kept.depths = base_calloc(64 * 64, 4);
        assert_true(kept.pixels && kept.depths);
        memcpy(kept.pixels, d.pixels, 64 * 64 * 16);
        memcpy(kept.depths, d.depths, 64 * 64 * 4);
        drawing_free(&d);
        drawing fresh = stage_draw(g, s, small);
        assert_true(stage_same(&kept, &fresh));
        assert_true(stage_pixel(&fresh, 28, 10)[0] == 1.0f);
        drawing_free(&fresh);
        free(kept.pixels);
        free(kept.depths);
        gpu_close(g);
        scene_free(s);
    }
}

static void all_hidden_draws_nothing(void **state) {
    (void)state;
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        if (!g)
            continue;
        base_error err = {0};
        scene *s = three_instances();
        drawing d = stage_draw(g, s, small);
        for (uint32_t i = 0; i < 3; i++)
            assert_int_equal(scene_set_visible(s, i, 0, &err), STRATA_OK);
        assert_int_equal(upload_update(d.u, s, &err), STRATA_OK);
        assert_true(drawing_draw(&d, s, &small, &err));
        assert_int_equal(covered(&d), 0);
        drawing_options transparent = small;
        transparent.slot = "draws.transparent/1"; /* never had any */
        assert_true(drawing_draw(&d, s, &transparent, &err));
        assert_int_equal(upload_draws(d.u, "draws.other/1").id, 0);
        drawing_free(&d);
        gpu_close(g);
        scene_free(s);
    }
}

static void deformed_vertices_arrive(void **state) {
    (void)state;
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        if (!g)
            continue;
        base_error err = {0};
        scene *s = three_instances();
        s->meshes[0].deform = base_calloc(1, sizeof *s->meshes[0].deform);
        assert_non_null(s->meshes[0].deform);
        drawing d = stage_draw(g, s, small);
        size_t before = covered(&d);
        for (uint32_t i = 0; i < s->meshes[0].vertex_count; i++) /* twice as wide */
            s->meshes[0].positions[i * 3] = s->meshes[0].positions[i * 3] * 2.0f + 0.9f;
        assert_int_equal(upload_update(d.u, s, &err), STRATA_OK);
        assert_true(drawing_draw(&d, s, &small, &err));
        assert_in_range(covered(&d), before * 2 - 80, before * 2 + 80);
        drawing_free(&d);
        gpu_close(g);
        scene_free(s);
    }
}

/* ---- what it costs --------------------------------------------------------------------------- */

static void absent_streams_cost_nothing(void **state) {
    (void)state;
    gpu *g = stage_open("vulkan");
    if (!g)
        skip();
    scene *s = three_instances(); /* unlit, with normals and uv that nothing reads */
    drawing d = stage_draw(g, s, small);
    uint64_t vertices = s->meshes[0].vertex_count;
    uint64_t expected = vertices * 12 + 6 * 4 + 3 * 96 + 80 + 20 + 4;
    assert_int_equal(upload_bytes(d.u), expected);
    assert_int_equal(gpu_bytes(g, "scene"), expected);
    drawing_free(&d);
    assert_int_equal(gpu_bytes(g, "scene"), 0);
    gpu_close(g);
    scene_free(s);
}

static void a_stream_beyond_the_limit_is_refused(void **state) {
    (void)state;
    gpu *g = stage_open("vulkan");
    uint64_t limit = g ? gpu_fact(g, "limit.storage_range") : 0;
    if (limit == 0 || limit > (1u << 28)) {
        gpu_close(g);
        skip();
    }
    stage t = stage_new();
    stage_quad(&t, stage_material(&t, 1, 1, 1), -1, -1, 1, 1, 0);
    stage_finish(&t);
    scene_mesh *mesh = &t.s->meshes[0];
    mesh->vertex_count = (uint32_t)(limit / 12) + 1;
    free(mesh->positions);
    mesh->positions = base_calloc(mesh->vertex_count, 12);
    assert_non_null(mesh->positions);
    base_error err = {0};
    upload *u = NULL;
    assert_int_equal(upload_create(g, t.s, &(upload_options){0}, &u, &err), STRATA_ERROR_OVERFLOW);
    assert_null(u);
    assert_non_null(strstr(err.text, "positions"));
    assert_int_equal(gpu_bytes(g, "scene"), 0);
    gpu_close(g);
    scene_free(t.s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_bits_glass),
        cmocka_unit_test(same_bits_city),
        cmocka_unit_test(same_bits_particles),
        cmocka_unit_test(ties_go_to_the_highest_primitive),
        cmocka_unit_test(ties_within_one_mesh),
        cmocka_unit_test(ties_across_rounds),
        cmocka_unit_test(edits_arrive),
        cmocka_unit_test(all_hidden_draws_nothing),
        cmocka_unit_test(deformed_vertices_arrive),
        cmocka_unit_test(absent_streams_cost_nothing),
        cmocka_unit_test(a_stream_beyond_the_limit_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
