/* SPDX-License-Identifier: MIT
 *
 * host/plan: facts and evidence of scenes made by hand, and the estimate of depth complexity
 * against areas worked out by hand and against counting pixel centres.
 */
#include "plan/demand.h"
#include "plan/estimate.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* ---- scenes ---------------------------------------------------------------------------------- */

#define MOST 8

/* A scene whose arrays live in the test: nothing to free but positions and indices. */
typedef struct stage {
    scene s;
    scene_mesh meshes[MOST];
    scene_instance instances[MOST];
    scene_material materials[MOST];
    unsigned char transparent[MOST];
} stage;

static void stage_open(stage *t) {
    memset(t, 0, sizeof *t);
    t->s.path = (char[]){"stage"};
    t->s.meshes = t->meshes;
    t->s.instances = t->instances;
    t->s.materials = t->materials;
}

static void stage_close(stage *t) {
    for (uint32_t i = 0; i < t->s.mesh_count; i++) {
        free(t->meshes[i].positions);
        free(t->meshes[i].indices);
        free(t->meshes[i].radii);
    }
}

static scene_material *add_material(stage *t, scene_alpha alpha) {
    scene_material *m = &t->materials[t->s.material_count];
    *m = (scene_material){.alpha = alpha, .double_sided = 1};
    m->base_color_texture.image = m->transmission_texture.image = SCENE_NONE;
    t->transparent[t->s.material_count++] = alpha == SCENE_BLEND;
    return m;
}

static scene_mesh *add_mesh(stage *t, scene_topology topology, uint32_t material, uint32_t count) {
    scene_mesh *mesh = &t->meshes[t->s.mesh_count++];
    *mesh = (scene_mesh){.topology = topology, .material = material};
    mesh->vertex_count = mesh->index_count = count;
    mesh->positions = calloc(count ? count : 1, 3 * sizeof *mesh->positions);
    mesh->indices = calloc(count ? count : 1, sizeof *mesh->indices);
    for (uint32_t i = 0; i < count; i++)
        mesh->indices[i] = i;
    return mesh;
}

static scene_instance *add_instance(stage *t, uint32_t mesh) {
    scene_instance *instance = &t->instances[t->s.instance_count++];
    *instance = (scene_instance){.mesh = mesh, .visible = 1};
    for (int i = 0; i < 16; i += 5)
        instance->world[i] = 1.0f;
    return instance;
}

static void set_triangle(scene_mesh *mesh, uint32_t triangle, const float p[9]) {
    memcpy(mesh->positions + (size_t)triangle * 9, p, 9 * sizeof *p);
}

/* Two triangles, counter-clockwise, at depth z. */
static void set_quad(scene_mesh *mesh, uint32_t quad, float x0, float y0, float x1, float y1,
                     float z) {
    set_triangle(mesh, quad * 2, (float[]){x0, y0, z, x1, y0, z, x1, y1, z});
    set_triangle(mesh, quad * 2 + 1, (float[]){x0, y0, z, x1, y1, z, x0, y1, z});
}

/* ---- facts ----------------------------------------------------------------------------------- */

static const demand_fact *fact_of(const demand *d, const char *id) {
    const demand_fact *fact = demand_find(d, id);
    if (!fact)
        fail_msg("no fact %s", id);
    return fact;
}

static void facts_count_what_is_visible(void **state) {
    (void)state;
    stage t;
    demand d;
    base_error err = {0};
    stage_open(&t);
    add_material(&t, SCENE_OPAQUE);
    add_material(&t, SCENE_MASK);
    add_material(&t, SCENE_BLEND);
    add_material(&t, SCENE_BLEND);
    add_material(&t, SCENE_BLEND)->unlit = 1; /* only an invisible instance uses it */
    add_material(&t, SCENE_OPAQUE)->transmission = 0.5f;
    t.materials[5].emissive[1] = 2.0f;
    for (uint32_t i = 0; i < 6; i++)
        add_mesh(&t, SCENE_TRIANGLES, i, 3 * (i + 1));
    add_mesh(&t, SCENE_TRIANGLES, 4, 0); /* visible, but nothing there */
    for (uint32_t i = 0; i < 7; i++)
        add_instance(&t, i)->visible = i != 4;
    add_instance(&t, 2); /* the same mesh again */
    t.s.light_count = 2;
    assert_int_equal(demand_make(&t.s, &d, &err), STRATA_OK);

    static const struct {
        const char *id;
        uint64_t value;
        const char *evidence;
    } rows[] = {
        {"materials.opaque", 1, "1 material with alphaMode OPAQUE, 1 triangle"},
        {"materials.mask", 1, "1 material with alphaMode MASK, 2 triangles"},
        {"materials.blend", 2, "2 materials with alphaMode BLEND, 10 triangles"},
        {"materials.transmission", 1, "1 material with KHR_materials_transmission, 6 triangles"},
        {"materials.unlit", 0, ""},
        {"materials.emissive", 1, "1 material with emission, 6 triangles"},
        {"instances", 6, "6 visible instances"},
        {"triangles", 19, "19 triangles"},
        {"points", 0, ""},
        {"lights", 2, "2 lights"},
        {"animated", 0, ""},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const demand_fact *fact = fact_of(&d, rows[i].id);
        assert_int_equal(fact->value, rows[i].value);
        assert_string_equal(fact->evidence, rows[i].evidence);
    }
    assert_int_equal(d.count, BASE_COUNT(rows));
    assert_null(demand_find(&d, "materials.nothing"));
    stage_close(&t);
}

static void evidence_reads_well(void **state) {
    (void)state;
    static const struct {
        uint32_t triangles, points;
        const char *evidence;
    } rows[] = {
        {2060, 0, "1 material with alphaMode BLEND, 2,060 triangles"},
        {0, 1, "1 material with alphaMode BLEND, 1 point"},
        {1, 1234567, "1 material with alphaMode BLEND, 1 triangle and 1,234,567 points"},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        stage t;
        demand d;
        base_error err = {0};
        stage_open(&t);
        add_material(&t, SCENE_BLEND);
        if (rows[i].triangles)
            add_mesh(&t, SCENE_TRIANGLES, 0, rows[i].triangles * 3);
        if (rows[i].points)
            add_mesh(&t, SCENE_POINTS, 0, rows[i].points);
        for (uint32_t k = 0; k < t.s.mesh_count; k++)
            add_instance(&t, k);
        assert_int_equal(demand_make(&t.s, &d, &err), STRATA_OK);
        assert_string_equal(fact_of(&d, "materials.blend")->evidence, rows[i].evidence);
        stage_close(&t);
    }
}

static void empty_scene_has_all_facts_at_zero(void **state) {
    (void)state;
    stage t;
    demand d;
    base_error err = {0};
    const char *id = NULL;
    stage_open(&t);
    assert_int_equal(demand_make(&t.s, &d, &err), STRATA_OK);
    for (uint32_t i = 0; i < d.count; i++) {
        assert_int_equal(d.facts[i].value, 0);
        assert_string_equal(d.facts[i].evidence, "");
        assert_non_null(demand_describe(i, &id));
        assert_string_equal(d.facts[i].id, id);
    }
    assert_null(demand_describe(d.count, &id));
}

static void facts_know_their_materials(void **state) {
    (void)state;
    scene_material glass = {.alpha = SCENE_OPAQUE, .transmission = 1.0f};
    scene_material veil = {.alpha = SCENE_BLEND};
    assert_true(demand_material_counts(&glass, "materials.transmission"));
    assert_false(demand_material_counts(&glass, "materials.blend"));
    assert_false(demand_material_counts(&glass, "materials.opaque"));
    assert_true(demand_material_counts(&veil, "materials.blend"));
    assert_false(demand_material_counts(&veil, "triangles"));
    assert_false(demand_material_counts(&veil, "nothing"));
}

/* ---- the estimate ---------------------------------------------------------------------------- */

static estimate_view flat_view(uint32_t width, uint32_t height) {
    estimate_view v = {.width = width, .height = height};
    for (int i = 0; i < 16; i += 5)
        v.world_to_clip[i] = 1.0f;
    return v;
}

static strata_scene_stats estimate(stage *t, const estimate_view *view) {
    strata_scene_stats stats;
    base_error err = {0};
    assert_int_equal(estimate_stats(&t->s, view, t->transparent, &stats, &err), STRATA_OK);
    assert_int_equal(stats.struct_size, sizeof stats);
    return stats;
}

static void assert_near(double value, double expected, double relative) {
    if (!(fabs(value - expected) <= relative * fabs(expected) + 1e-9))
        fail_msg("%.9g is not within %g of %.9g", value, relative, expected);
}

static void areas_of_quads(void **state) {
    (void)state;
    static const struct {
        float box[4];
        uint32_t width, height;
        double fragments, covered;
    } rows[] = {
        {{-1, -1, 1, 1}, 64, 64, 4096, 4096},
        {{-1, -1, 1, 1}, 7, 3, 21, 21},
        {{-1, -1, 1, 1}, 1, 1, 1, 1},
        {{-5, -5, 5, 5}, 800, 600, 480000, 480000}, /* clipped on all sides */
        {{0, 0, 9, 9}, 640, 480, 76800, 76800},     /* clipped on two */
        {{-0.5f, -0.25f, 0.25f, 0.5f}, 512, 512, 36864, 36864},
        {{2, 2, 3, 3}, 64, 64, 0, 0}, /* outside */
        {{0, 0, 0.001f, 0.001f}, 64, 64, 0.001024, 0.001024},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        const float *b = rows[i].box;
        estimate_view view = flat_view(rows[i].width, rows[i].height);
        stage t;
        stage_open(&t);
        add_material(&t, SCENE_BLEND);
        set_quad(add_mesh(&t, SCENE_TRIANGLES, 0, 6), 0, b[0], b[1], b[2], b[3], 0.5f);
        add_instance(&t, 0);
        strata_scene_stats stats = estimate(&t, &view);
        assert_near(stats.transparent_fragments, rows[i].fragments, 1e-5);
        assert_near(stats.covered_pixels, rows[i].covered, 1e-5);
        assert_near(stats.mean_depth, rows[i].fragments > 0 ? 1.0 : 0.0, 1e-5);
        assert_true(stats.largest_depth <= 2.0);
        assert_int_equal(stats.transparent_triangles, 2);
        stage_close(&t);
    }
}

static void stack_over_one_pixel_is_deep(void **state) {
    (void)state;
    stage t;
    estimate_view view = flat_view(800, 600);
    stage_open(&t);
    add_material(&t, SCENE_BLEND);
    scene_mesh *mesh = add_mesh(&t, SCENE_TRIANGLES, 0, 1000 * 6);
    float x = 3.0f / 400.0f, y = 5.0f / 300.0f;
    for (uint32_t i = 0; i < 1000; i++)
        set_quad(mesh, i, x, y, x + 1 / 400.0f, y + 1 / 300.0f, 0.5f);
    add_instance(&t, 0);
    strata_scene_stats stats = estimate(&t, &view);
    assert_near(stats.transparent_fragments, 1000, 1e-3);
    assert_near(stats.largest_depth, 1000, 0.01);
    assert_near(stats.covered_pixels, 1, 0.01);
    stage_close(&t);
}

static void counts_split_by_material(void **state) {
    (void)state;
    stage t;
    estimate_view view = flat_view(64, 64);
    stage_open(&t);
    add_material(&t, SCENE_OPAQUE);
    add_material(&t, SCENE_BLEND);
    set_quad(add_mesh(&t, SCENE_TRIANGLES, 0, 6), 0, -1, -1, 1, 1, 0.5f);
    set_quad(add_mesh(&t, SCENE_TRIANGLES, 1, 6), 0, -1, -1, 1, 1, 0.5f);
    add_mesh(&t, SCENE_POINTS, 1, 5);
    for (uint32_t i = 0; i < 3; i++)
        add_instance(&t, i);
    add_instance(&t, 1)->visible = 0;
    strata_scene_stats stats = estimate(&t, &view);
    assert_int_equal(stats.instances, 3);
    assert_int_equal(stats.materials, 2);
    assert_int_equal(stats.opaque_draws, 1);
    assert_int_equal(stats.transparent_draws, 2);
    assert_int_equal(stats.opaque_triangles, 2);
    assert_int_equal(stats.transparent_triangles, 2 + 10);
    stage_close(&t);
}

/* Columns of a matrix with w = -z, so that what has z > 0 lies behind the eye. */
static estimate_view perspective(uint32_t width, uint32_t height, float near) {
    estimate_view v = {.width = width, .height = height};
    v.world_to_clip[0] = v.world_to_clip[5] = 1.0f;
    v.world_to_clip[11] = -1.0f;
    v.world_to_clip[14] = near; /* depth = near / -z */
    return v;
}

static void triangles_around_the_eye(void **state) {
    (void)state;
    static const struct {
        float p[9];
        double fragments;
    } rows[] = {
        {{-9, -9, -1, 9, -9, -1, 0, 90, -1}, 10000},            /* in front, fills the image */
        {{-9, -9, 1, 9, -9, 1, 0, 90, 1}, 0},                   /* behind */
        {{-9, -9, 0, 9, -9, 0, 0, 9, 0}, 0},                    /* in the plane of the eye, w = 0 */
        {{-100, -1, -0.05f, 100, -1, -0.05f, 0, 9, -0.05f}, 0}, /* nearer than the near plane */
        {{-1, -1, -2, 1, -1, -2, 1, 1, -2}, 1250},              /* half a quad at distance 2 */
        {{-1e9f, -1, 1e9f, 1e9f, -1, 1e9f, 0, -1, -1e9f}, 5000}, /* the ground: lower half */
        {{1e30f, 1e30f, -1e30f, 3e38f, -3e38f, 3e38f, -3e38f, 1, 1e-30f}, -1}, /* no trap */
    };
    estimate_view view = perspective(100, 100, 0.1f);
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        stage t;
        stage_open(&t);
        add_material(&t, SCENE_BLEND);
        set_triangle(add_mesh(&t, SCENE_TRIANGLES, 0, 3), 0, rows[i].p);
        add_instance(&t, 0);
        strata_scene_stats stats = estimate(&t, &view);
        assert_true(isfinite(stats.transparent_fragments) && isfinite(stats.mean_depth));
        assert_true(stats.transparent_fragments <= 10000.001);
        if (rows[i].fragments >= 0)
            assert_near(stats.transparent_fragments, rows[i].fragments, 0.01);
        stage_close(&t);
    }
}

static void back_faces_are_not_drawn(void **state) {
    (void)state;
    static const struct {
        int double_sided, mirrored, flipped;
        double fragments;
    } rows[] = {{0, 0, 0, 4096}, {0, 0, 1, 0},    {0, 1, 0, 4096},
                {0, 1, 1, 0},    {1, 0, 1, 4096}, {1, 1, 0, 4096}};
    estimate_view view = flat_view(64, 64);
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        stage t;
        stage_open(&t);
        add_material(&t, SCENE_BLEND)->double_sided = (uint32_t)rows[i].double_sided;
        scene_mesh *mesh = add_mesh(&t, SCENE_TRIANGLES, 0, 6);
        set_quad(mesh, 0, -1, -1, 1, 1, 0.5f);
        for (uint32_t k = 0; rows[i].flipped && k < 6; k += 3) {
            mesh->indices[k] = k + 1;
            mesh->indices[k + 1] = k;
        }
        add_instance(&t, 0)->world[0] = rows[i].mirrored ? -1.0f : 1.0f;
        assert_near(estimate(&t, &view).transparent_fragments, rows[i].fragments, 1e-6);
        stage_close(&t);
    }
}

static void splats_are_discs(void **state) {
    (void)state;
    estimate_view view = flat_view(200, 100);
    stage t;
    stage_open(&t);
    add_material(&t, SCENE_BLEND);
    scene_mesh *mesh = add_mesh(&t, SCENE_POINTS, 0, 2);
    mesh->radii = calloc(2, sizeof *mesh->radii);
    mesh->radii[0] = 0.1f; /* 10 by 5 pixels half axes */
    mesh->positions[2] = 0.5f;
    mesh->positions[5] = 1.5f; /* nearer than the near plane */
    mesh->radii[1] = 0.5f;
    add_instance(&t, 0);
    assert_near(estimate(&t, &view).transparent_fragments, 3.14159265 * 50.0, 1e-4);
    t.instances[0].world[0] = t.instances[0].world[5] = t.instances[0].world[10] = 2.0f;
    mesh->positions[2] = 0.25f;
    assert_near(estimate(&t, &view).transparent_fragments, 3.14159265 * 200.0, 1e-4);
    stage_close(&t);
}

/* ---- against counting, and sampling ---------------------------------------------------------- */

static float unit(uint32_t *seed) {
    *seed = *seed * 1664525u + 1013904223u;
    return (float)(*seed >> 8) / 16777216.0f;
}

static void fill_soup(scene_mesh *mesh, float size, uint32_t seed) {
    for (uint32_t i = 0; i < mesh->index_count / 3; i++) {
        float p[9];
        float x = unit(&seed) * 2 - 1, y = unit(&seed) * 2 - 1;
        for (int k = 0; k < 9; k++)
            p[k] = k % 3 == 2 ? 0.5f : (k % 3 ? y : x) + (unit(&seed) - 0.5f) * size;
        set_triangle(mesh, i, p);
    }
}

/* Counts pixel centres inside each triangle: fragments, covered pixels, largest depth. */
static void count_centres(const scene_mesh *mesh, uint32_t size, double out[3]) {
    uint32_t *depth = calloc((size_t)size * size, sizeof *depth);
    out[0] = out[1] = out[2] = 0;
    for (uint32_t i = 0; i < mesh->index_count / 3; i++) {
        const float *p = mesh->positions + (size_t)i * 9;
        for (uint32_t y = 0; y < size; y++) {
            for (uint32_t x = 0; x < size; x++) {
                double cx = (x + 0.5) * 2 / size - 1, cy = (y + 0.5) * 2 / size - 1;
                int side = 0;
                for (int k = 0; k < 3; k++) {
                    const float *a = p + k * 3, *b = p + (k + 1) % 3 * 3;
                    double ax = (double)a[0], ay = (double)a[1];
                    side += ((double)b[0] - ax) * (cy - ay) - ((double)b[1] - ay) * (cx - ax) > 0
                                ? 1
                                : -1;
                }
                depth[y * size + x] += side == 3 || side == -3;
            }
        }
    }
    for (size_t i = 0; i < (size_t)size * size; i++) {
        out[0] += depth[i];
        out[1] += depth[i] > 0;
        out[2] = fmax(out[2], depth[i]);
    }
    free(depth);
}

static void soup_agrees_with_counting(void **state) {
    (void)state;
    static const struct {
        uint32_t triangles;
        float size;
    } rows[] = {{3000, 0.3f}, {3000, 0.05f}, {200, 2.5f}};
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        double counted[3];
        estimate_view view = flat_view(128, 128);
        stage t;
        stage_open(&t);
        add_material(&t, SCENE_BLEND);
        scene_mesh *mesh = add_mesh(&t, SCENE_TRIANGLES, 0, rows[i].triangles * 3);
        fill_soup(mesh, rows[i].size, 7);
        add_instance(&t, 0);
        count_centres(mesh, 128, counted);
        strata_scene_stats stats = estimate(&t, &view);
        assert_near(stats.transparent_fragments, counted[0], 0.02);
        assert_near(stats.covered_pixels, counted[1], 0.3);
        assert_true(fabs(stats.largest_depth - counted[2]) <= fmax(2.0, 0.3 * counted[2]));
        stage_close(&t);
    }
}

static void large_scenes_are_sampled(void **state) {
    (void)state;
    estimate_view view = flat_view(512, 512);
    stage t;
    stage_open(&t);
    add_material(&t, SCENE_BLEND);
    scene_mesh *mesh = add_mesh(&t, SCENE_TRIANGLES, 0, 1000000 * 3);
    fill_soup(mesh, 0.05f, 3);
    add_instance(&t, 0);
    double exact = 0.0;
    for (uint32_t i = 0; i < 1000000; i++) {
        const float *p = mesh->positions + (size_t)i * 9;
        double ax = (double)(p[3] - p[0]), ay = (double)(p[4] - p[1]);
        double bx = (double)(p[6] - p[0]), by = (double)(p[7] - p[1]);
        exact += 0.5 * fabs(ax * by - ay * bx) * 256 * 256;
    }
    strata_scene_stats stats = estimate(&t, &view), again = estimate(&t, &view);
    assert_near(stats.transparent_fragments, exact, 0.03); /* a little lies outside */
    assert_int_equal(stats.transparent_triangles, 1000000);
    assert_memory_equal(&stats, &again, sizeof stats);
    stage_close(&t);
}

/* Every other triangle is nothing: an even stride would see all or none. */
static void samples_fall_out_of_step(void **state) {
    (void)state;
    estimate_view view = flat_view(64, 64);
    stage t;
    stage_open(&t);
    add_material(&t, SCENE_BLEND);
    scene_mesh *mesh = add_mesh(&t, SCENE_TRIANGLES, 0, 700000 * 3);
    for (uint32_t i = 0; i < 700000; i += 2)
        set_triangle(mesh, i, (float[]){0, 0, 0.5f, 0.01f, 0, 0.5f, 0, 0.01f, 0.5f});
    add_instance(&t, 0);
    assert_near(estimate(&t, &view).transparent_fragments, 350000 * 0.0512, 0.01);
    stage_close(&t);
}

/* Of a square of this material, whose vertices have half the alpha or none of their own. */
static double optical_depth_of(const scene_material *material, int vertices) {
    static const unsigned char pixels[] = {255, 0, 0, 255, 127, 0, 0, 0}; /* alpha 1 and 0 */
    scene_image im = {.width = 2, .height = 1, .pixels = (unsigned char *)(uintptr_t)pixels};
    estimate_view view = flat_view(64, 64);
    stage t;
    stage_open(&t);
    *add_material(&t, SCENE_BLEND) = *material;
    t.s.images = &im;
    t.s.image_count = 1;
    scene_mesh *mesh = add_mesh(&t, SCENE_TRIANGLES, 0, 6);
    float colors[6 * 4];
    for (int i = 0; i < 24; i++)
        colors[i] = 0.5f;
    mesh->colors = vertices ? colors : NULL;
    set_quad(mesh, 0, -1, -1, 1, 1, 0.5f);
    add_instance(&t, 0);
    const double depth = estimate(&t, &view).mean_optical_depth;
    mesh->colors = NULL;
    t.s.images = NULL;
    stage_close(&t);
    return depth;
}

static void materials_hide_what_is_behind(void **state) {
    (void)state;
    static const struct {
        scene_alpha alpha;
        float color[4], transmission;
        int texture, vertices;
        double transmittance;
    } rows[] = {
        {SCENE_BLEND, {1, 1, 1, 0.25f}, 0, 0, 0, 0.75},
        {SCENE_BLEND, {1, 1, 1, 0.5f}, 0, 0, 1, 0.75},
        {SCENE_BLEND, {1, 1, 1, 0.5f}, 0, 1, 0, 0.75},
        {SCENE_BLEND, {1, 1, 1, 0}, 0, 0, 0, 1},
        {SCENE_BLEND, {1, 1, 1, 1}, 0, 0, 0, 0x1p-24},
        {SCENE_OPAQUE, {0.2f, 0.8f, 0.5f, 0.1f}, 1, 0, 0, 0.8}, /* alpha says nothing */
        {SCENE_OPAQUE, {1, 1, 1, 1}, 0.5f, 0, 1, 0.5},
        {SCENE_BLEND, {0.5f, 0.5f, 0.5f, 0.5f}, 1, 0, 0, 0.75},
    };
    for (size_t i = 0; i < BASE_COUNT(rows); i++) {
        scene_material m = {.alpha = rows[i].alpha, .transmission = rows[i].transmission};
        memcpy(m.base_color, rows[i].color, sizeof m.base_color);
        m.base_color_texture.image = rows[i].texture ? 0 : SCENE_NONE;
        m.transmission_texture.image = SCENE_NONE;
        m.double_sided = 1;
        const double depth = optical_depth_of(&m, rows[i].vertices);
        if (!(fabs(depth + log(rows[i].transmittance)) < 1e-6))
            fail_msg("row %zu: %g", i, depth);
    }
}

/* By area: a square of transmittance 3/4, and one of half its size that lets 1/4 through. */
static void optical_depths_are_weighed_by_area(void **state) {
    (void)state;
    estimate_view view = flat_view(64, 64);
    stage t;
    stage_open(&t);
    for (int i = 0; i < 2; i++) {
        add_material(&t, SCENE_BLEND)->base_color[3] = i ? 0.75f : 0.25f;
        set_quad(add_mesh(&t, SCENE_TRIANGLES, (uint32_t)i, 6), 0, -1, -1, i ? 0.0f : 1.0f, 1,
                 0.5f);
        add_instance(&t, (uint32_t)i);
    }
    assert_near(estimate(&t, &view).mean_optical_depth, -(2 * log(0.75) + log(0.25)) / 3, 1e-6);
    stage_close(&t);
}

static void nothing_and_no_image(void **state) {
    (void)state;
    stage t;
    base_error err = {0};
    strata_scene_stats stats;
    estimate_view view = flat_view(64, 64);
    stage_open(&t);
    stats = estimate(&t, &view);
    assert_int_equal(stats.transparent_draws + stats.opaque_draws, 0);
    assert_true(stats.mean_depth == 0.0 && stats.largest_depth == 0.0);
    assert_true(stats.mean_optical_depth == 0.0);
    view.height = 0;
    assert_int_equal(estimate_stats(&t.s, &view, t.transparent, &stats, &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(facts_count_what_is_visible),
        cmocka_unit_test(evidence_reads_well),
        cmocka_unit_test(empty_scene_has_all_facts_at_zero),
        cmocka_unit_test(facts_know_their_materials),
        cmocka_unit_test(areas_of_quads),
        cmocka_unit_test(stack_over_one_pixel_is_deep),
        cmocka_unit_test(counts_split_by_material),
        cmocka_unit_test(triangles_around_the_eye),
        cmocka_unit_test(back_faces_are_not_drawn),
        cmocka_unit_test(splats_are_discs),
        cmocka_unit_test(soup_agrees_with_counting),
        cmocka_unit_test(large_scenes_are_sampled),
        cmocka_unit_test(samples_fall_out_of_step),
        cmocka_unit_test(materials_hide_what_is_behind),
        cmocka_unit_test(optical_depths_are_weighed_by_area),
        cmocka_unit_test(nothing_and_no_image),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
