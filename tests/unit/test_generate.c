/* SPDX-License-Identifier: MIT
 *
 * The procedural scenes: the same bits for the same seed, counts and depths as the knobs say,
 * solids that face outwards, and knob errors.
 */
#include "scene/camera.h"
#include "scene/generate.h"
#include "unit/generated.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static uint64_t hash_array(uint64_t hash, const void *data, size_t size) {
    return data ? base_hash(hash, data, size) : hash + 1;
}

/* Of all that is drawn: meshes, instances and materials' numbers. */
static uint64_t hash_scene(const scene *s) {
    uint64_t hash = s->primitive_count;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        const scene_mesh *m = &s->meshes[i];
        size_t n = m->vertex_count * sizeof(float);
        hash = hash_array(hash, m->positions, 3 * n);
        hash = hash_array(hash, m->normals, 3 * n);
        hash = hash_array(hash, m->uv0, 2 * n);
        hash = hash_array(hash, m->colors, 4 * n);
        hash = hash_array(hash, m->radii, n);
        hash = hash_array(hash, m->indices, m->index_count * sizeof(uint32_t));
    }
    for (uint32_t i = 0; i < s->instance_count; i++) {
        hash = hash_array(hash, s->instances[i].world, sizeof s->instances[i].world);
        hash = hash_array(hash, &s->instances[i].mesh, sizeof s->instances[i].mesh);
    }
    for (uint32_t i = 0; i < s->material_count; i++)
        hash = hash_array(hash, s->materials[i].base_color, sizeof s->materials[i].base_color);
    return hash;
}

/* ---- the generator's numbers ---------------------------------------------------------------- */

static void turns_agree_with_sin_and_cos(void **state) {
    (void)state;
    for (int i = -40000; i <= 40000; i++) {
        double turns = i / 7919.0 * 3, s, c;
        generate_turn(turns, &s, &c);
        assert_true(fabs(s - sin(turns * 6.283185307179586)) < 4e-15 * (1 + fabs(turns)));
        assert_true(fabs(c - cos(turns * 6.283185307179586)) < 4e-15 * (1 + fabs(turns)));
    }
    double s, c;
    generate_turn(0.25, &s, &c);
    assert_true(s == 1 && fabs(c) == 0);
    generate_turn(-0.5, &s, &c);
    assert_true(fabs(s) == 0 && c == -1);
}

static void random_numbers_are_even_and_depend_on_the_seed(void **state) {
    (void)state;
    generate_random random = generate_seed(1), other = generate_seed(2);
    unsigned bins[16] = {0}, same = 0;
    for (int i = 0; i < 160000; i++) {
        double u = generate_unit(&random);
        assert_true(u >= 0 && u < 1);
        bins[(int)(u * 16)]++;
        same += generate_bits(&other) == (uint32_t)(u * 4294967296.0);
    }
    for (int i = 0; i < 16; i++)
        assert_in_range(bins[i], 9600, 10400);
    assert_in_range(same, 0, 3);
}

/* ---- shapes --------------------------------------------------------------------------------- */

/* Six times the volume; asserts that each triangle faces the way its normals do. */
static double check_solid(const generate_mesh *mesh) {
    double volume = 0;
    for (size_t t = 0; t < mesh->index_count; t += 3) {
        double p[3][3], u[3], v[3], n[3], along = 0;
        for (size_t c = 0; c < 3; c++)
            for (size_t k = 0; k < 3; k++)
                p[c][k] = (double)mesh->positions[(size_t)mesh->indices[t + c] * 3 + k];
        for (int k = 0; k < 3; k++) {
            u[k] = p[1][k] - p[0][k];
            v[k] = p[2][k] - p[0][k];
        }
        generate_cross(u, v, n);
        for (size_t k = 0; k < 3; k++) {
            volume += p[0][k] * n[k];
            for (size_t c = 0; c < 3; c++)
                along += n[k] * (double)mesh->normals[(size_t)mesh->indices[t + c] * 3 + k];
        }
        assert_true(along >= -1e-9);
    }
    return volume;
}

static void free_mesh(generate_mesh *mesh) {
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->uv);
    free(mesh->indices);
}

static void solids_face_outwards(void **state) {
    (void)state;
    const double at[3] = {5, -3, 2}, pi = 3.14159265358979;
    const double cone[][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const double line[2][3] = {{0, 0, 0}, {0, 0, 2}}, side[2][3] = {{1, 0, 0}, {1, 0, 0}};
    generate_builder b = {0};
    generate_mesh mesh = generate_mesh_begin(&b, GENERATE_NORMALS);
    generate_sphere(&mesh, at, 1, 32);
    assert_int_equal(mesh.index_count, 8 * 32 * 32 * 3);
    assert_true(fabs(check_solid(&mesh) / 6 - 4 * pi / 3) < 0.01);
    free_mesh(&mesh);
    mesh = generate_mesh_begin(&b, GENERATE_NORMALS | GENERATE_UV);
    generate_box(&mesh, (const double[3]){1, 1, 1}, (const double[3]){2, 3, 4});
    assert_true(fabs(check_solid(&mesh) / 6 - 6) < 1e-9);
    free_mesh(&mesh);
    mesh = generate_mesh_begin(&b, GENERATE_NORMALS);
    generate_lathe(&mesh, at, cone, 4, 64);
    assert_true(fabs(check_solid(&mesh) / 6 - pi) < 0.02);
    free_mesh(&mesh);
    mesh = generate_mesh_begin(&b, GENERATE_NORMALS);
    generate_torus(&mesh, at, 2, 0.5, (const double[3]){1, 2, 3}, 128, 64);
    assert_true(fabs(check_solid(&mesh) / 6 - 2 * pi * 2 * pi * 0.25) < 0.05);
    free_mesh(&mesh);
    mesh = generate_mesh_begin(&b, GENERATE_NORMALS);
    generate_tube(&mesh, line, side, 2, 0.5, 1, 8);
    assert_true(check_solid(&mesh) > 0);
    free_mesh(&mesh);
}

/* Every edge of a sphere is met by exactly one edge the other way, position for position. */
static void sphere_seams_share_their_bits(void **state) {
    (void)state;
    generate_builder b = {0};
    generate_mesh mesh = generate_mesh_begin(&b, GENERATE_NORMALS);
    generate_sphere(&mesh, (const double[3]){0.1, 0.2, 0.3}, 0.7, 6);
    for (size_t i = 0; i < mesh.index_count; i++) {
        const float *p = mesh.positions + (size_t)mesh.indices[i] * 3;
        const float *q = mesh.positions + (size_t)mesh.indices[i / 3 * 3 + (i + 1) % 3] * 3;
        int partners = 0;
        for (size_t j = 0; j < mesh.index_count; j++) {
            const float *r = mesh.positions + (size_t)mesh.indices[j] * 3;
            const float *t = mesh.positions + (size_t)mesh.indices[j / 3 * 3 + (j + 1) % 3] * 3;
            partners += memcmp(p, t, 12) == 0 && memcmp(q, r, 12) == 0;
        }
        assert_int_equal(partners, 1);
    }
    free_mesh(&mesh);
}

/* ---- scenes --------------------------------------------------------------------------------- */

static void every_scene_generates_and_repeats_itself(void **state) {
    (void)state;
    uint32_t count;
    const scene_generator *kinds = scene_generators(&count);
    assert_int_equal(count, 10);
    for (uint32_t i = 0; i < count; i++) {
        char seeded[64];
        snprintf(seeded, sizeof seeded, "%s seed=42", kinds[i].name);
        assert_string_equal(kinds[i].knobs[0].name, "seed");
        scene *a = generated(kinds[i].name), *b = generated(kinds[i].name), *c = generated(seeded);
        assert_true(hash_scene(a) == hash_scene(b));
        assert_true(hash_scene(a) != hash_scene(c) || strcmp(kinds[i].name, "shells") == 0 ||
                    strcmp(kinds[i].name, "glass") == 0);
        assert_true(a->primitive_count > 0 && a->camera_count > 0);
        scene_free(a);
        scene_free(b);
        scene_free(c);
    }
}

static void hard_cases_generate_and_repeat_themselves(void **state) {
    (void)state;
    uint32_t count = 0;
    for (const scene_hard_case *hard; (hard = scene_hard_cases(count)); count++) {
        scene *a = NULL, *b = NULL;
        base_error err = {0};
        const int broken = strcmp(hard->name, "hard:infinite") == 0 ||
                           strcmp(hard->name, "hard:not-a-number") == 0;
        assert_int_equal(strncmp(hard->name, "hard:", 5), 0);
        assert_true(hard->title[0] && hard->width > 0 && hard->height > 0);
        assert_int_equal(scene_generate(hard->name, NULL, 0, &a, &err),
                         broken ? STRATA_ERROR_BAD_FILE : STRATA_OK);
        if (broken)
            continue;
        assert_int_equal(scene_generate(hard->name, NULL, 0, &b, &err), STRATA_OK);
        assert_string_equal(a->path, hard->name);
        assert_true(hash_scene(a) == hash_scene(b));
        assert_true(a->camera_count == 1);
        scene_free(a);
        scene_free(b);
    }
    assert_true(count > 30);
}

static void counts_are_what_the_knobs_say(void **state) {
    (void)state;
    static const struct {
        const char *text;
        uint64_t primitives;
        uint32_t instances, materials;
    } cases[] = {
        {"soup", 105000, 16, 16},
        {"soup small=7 medium=0 materials=4", 7, 4, 4},
        {"shells count=3 subdivision=2 core=0", 3 * 128, 3, 3},
        {"hairball strands=10 segments=5 sides=2 core=0", 100, 1, 1},
        {"hairball strands=10 segments=5 sides=3 core=0", 300, 1, 1},
        {"particles count=1000 core=0", 1000, 1, 1},
        {"stack count=5", 10, 5, 1},
        {"stack count=5 merged=1", 10, 1, 1},
        {"stack count=5 opaque=1", 10, 5, 2},
        {"layers count=12345", 24690, 1, 1},
        {"layers count=3 opaque=1", 8, 2, 2},
        {"glass smoke=0", 24228, 10, 10},
    };
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        scene *s = generated(cases[i].text);
        assert_int_equal(s->primitive_count, cases[i].primitives);
        assert_int_equal(s->instance_count, cases[i].instances);
        scene_free(s);
    }
    scene *s = generated("city count=500 glass=0");
    assert_int_equal(s->instance_count, 501);
    assert_in_range(s->mesh_count, 2, 8);
    scene_free(s);
    s = generated("needles");
    assert_in_range(s->primitive_count, 37800, 43000);
    scene_free(s);
    s = generated("glass");
    assert_in_range(s->primitive_count, 20000, 50000);
    scene_free(s);
}

static void wrong_knobs_are_named_with_the_list(void **state) {
    (void)state;
    static const struct {
        const char *name, *knob, *expected;
    } cases[] = {
        {"soup", "smal=3", "not a knob"},       {"soup", "small", "KNOB=VALUE"},
        {"soup", "small=-1", "out of range"},   {"soup", "small=1e99", "out of range"},
        {"soup", "small=1.5", "whole number"},  {"soup", "small=12x", "not a number"},
        {"soup", "small=", "not a number"},     {"soup", "depth=nan", "not a number"},
        {"soup", "depth=0x10", "not a number"}, {"soup", "=3", "not a knob"},
        {"layers", "where=half", "choices"},    {"layers", "where=1", "choices"},
    };
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        base_error err = {0};
        scene *s;
        assert_int_equal(scene_generate(cases[i].name, &cases[i].knob, 1, &s, &err),
                         STRATA_ERROR_INVALID_ARGUMENT);
        assert_null(s);
        assert_non_null(strstr(err.text, cases[i].expected));
        assert_non_null(strstr(err.text, cases[i].knob));
        assert_non_null(strstr(err.text, i < 10 ? "medium=" : "where=all|pixel"));
    }
    base_error err = {0};
    scene *s;
    assert_int_equal(scene_generate("sponza", NULL, 0, &s, &err), STRATA_ERROR_NOT_FOUND);
    assert_non_null(strstr(err.text, "hairball"));
}

/* ---- fragments ------------------------------------------------------------------------------ */

/* Fragments a pixel of all triangles, by the top-left rule on exact edge functions, as rasterisers
 * count them but for the 1/256 grid. */
typedef struct coverage {
    uint32_t size, *count;
    double mean;
    uint32_t max;
} coverage;

static int inside(const double a[2], const double b[2], double x, double y) {
    double dx = b[0] - a[0], dy = b[1] - a[1], e = dx * (y - a[1]) - dy * (x - a[0]);
    int top_left = dy < 0 || (dy == 0 && dx < 0);
    return e > 0 || (e == 0 && top_left);
}

static void cover_triangle(coverage *c, double p[3][2]) {
    double area =
        (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
    double *a = p[0], *b = area < 0 ? p[2] : p[1], *d = area < 0 ? p[1] : p[2];
    double top = c->size - 1, x0 = fmax(0, floor(fmin(a[0], fmin(b[0], d[0])) - 1));
    double x1 = fmin(top, ceil(fmax(a[0], fmax(b[0], d[0]))));
    double y0 = fmax(0, floor(fmin(a[1], fmin(b[1], d[1])) - 1));
    double y1 = fmin(top, ceil(fmax(a[1], fmax(b[1], d[1]))));
    for (double y = y0; y <= y1; y++)
        for (double x = x0; x <= x1; x++)
            if (inside(a, b, x + 0.5, y + 0.5) && inside(b, d, x + 0.5, y + 0.5) &&
                inside(d, a, x + 0.5, y + 0.5))
                c->count[(size_t)y * c->size + (size_t)x]++;
}

static coverage cover(const scene *s, uint32_t size) {
    coverage c = {.size = size, .count = calloc((size_t)size * size, sizeof(uint32_t))};
    scene_view view;
    base_error err = {0};
    assert_int_equal(scene_view_make(s, NULL, 0, size, size, &view, &err), STRATA_OK);
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_mesh *m = &s->meshes[s->instances[i].mesh];
        for (size_t t = 0; t < m->index_count; t += 3) {
            double p[3][2];
            for (size_t k = 0; k < 3; k++) {
                const float *v = m->positions + (size_t)m->indices[t + k] * 3;
                float h[4];
                for (size_t r = 0; r < 4; r++)
                    h[r] = view.world_to_clip[r] * v[0] + view.world_to_clip[4 + r] * v[1] +
                           view.world_to_clip[8 + r] * v[2] + view.world_to_clip[12 + r];
                assert_true(h[3] > 0 && h[2] >= 0 && h[2] <= h[3]); /* between the planes */
                for (size_t r = 0; r < 2; r++)
                    p[k][r] = ((double)h[r] / (double)h[3] * 0.5 + 0.5) * size;
            }
            cover_triangle(&c, p);
        }
    }
    for (size_t i = 0; i < (size_t)size * size; i++) {
        c.mean += (double)c.count[i] / ((double)size * size);
        c.max = c.count[i] > c.max ? c.count[i] : c.max;
    }
    return c;
}

static void soup_has_the_depth_it_is_asked_for(void **state) {
    (void)state;
    scene *s = generated("soup");
    coverage c = cover(s, 512);
    assert_true(c.mean > 41 && c.mean < 42.2);
    assert_in_range(c.max, 60, 78);
    free(c.count);
    scene_free(s);
    s = generated("soup small=20000 medium=0 depth=5");
    c = cover(s, 256);
    assert_true(c.mean > 4.7 && c.mean < 5.3);
    free(c.count);
    scene_free(s);
}

static void layers_cover_exactly_the_pixels_asked_for(void **state) {
    (void)state;
    static const unsigned sizes[] = {1, 2, 17, 64};
    for (size_t i = 0; i < BASE_COUNT(sizes); i++) {
        char text[96];
        snprintf(text, sizeof text, "layers count=70 width=%u height=%u", sizes[i], sizes[i]);
        scene *s = generated(text);
        coverage c = cover(s, sizes[i]);
        for (size_t p = 0; p < (size_t)sizes[i] * sizes[i]; p++)
            assert_int_equal(c.count[p], 70);
        free(c.count);
        scene_free(s);
        strcat(text, " where=pixel");
        s = generated(text);
        c = cover(s, sizes[i]);
        size_t middle = (size_t)(sizes[i] / 2) * sizes[i] + sizes[i] / 2;
        for (size_t p = 0; p < (size_t)sizes[i] * sizes[i]; p++)
            assert_int_equal(c.count[p], p == middle ? 70 : 0);
        free(c.count);
        scene_free(s);
    }
}

/* The number of fragments does not depend on how they are spread. */
static void bursts_have_as_many_fragments_as_asked_for(void **state) {
    (void)state;
    static const char *const spreads[] = {"0", "0.25", "0.5", "0.9", "1"};
    static const uint32_t deepest[] = {9, 37, 153, 1476, 2601};
    for (size_t i = 0; i < BASE_COUNT(spreads); i++) {
        char text[96];
        snprintf(text, sizeof text, "burst mean=9 width=17 height=17 spread=%s", spreads[i]);
        scene *s = generated(text);
        coverage c = cover(s, 17);
        uint64_t sum = 0;
        uint32_t most = 0;
        for (size_t p = 0; p < 17 * 17; p++) {
            sum += c.count[p];
            most = c.count[p] > most ? c.count[p] : most;
        }
        assert_int_equal(sum, 9 * 17 * 17);
        assert_int_equal(most, deepest[i]);
        free(c.count);
        scene_free(s);
    }
}

static int compare_floats(const void *a, const void *b) {
    float x, y;
    memcpy(&x, a, sizeof x);
    memcpy(&y, b, sizeof y);
    return (x > y) - (x < y);
}

/* A million layers still have a million depths in the depth buffer's own arithmetic. */
static void layers_have_distinct_depths(void **state) {
    (void)state;
    enum { N = 1000000 };
    scene *s = generated("layers count=1000000");
    scene_view view;
    base_error err = {0};
    assert_int_equal(scene_view_make(s, NULL, 0, 64, 64, &view, &err), STRATA_OK);
    float *depth = malloc(N * sizeof *depth);
    int ascending = 0;
    for (size_t i = 0; i < N; i++) {
        float z = s->meshes[0].positions[i * 12 + 2];
        depth[i] = view.world_to_clip[10] * z + view.world_to_clip[14];
        assert_true(depth[i] > 0 && depth[i] < 1);
        ascending += i > 0 && depth[i] > depth[i - 1];
    }
    assert_in_range(ascending, N / 3, 2 * N / 3); /* shuffled */
    qsort(depth, N, sizeof *depth, compare_floats);
    for (size_t i = 1; i < N; i++)
        assert_true(depth[i] > depth[i - 1]);
    free(depth);
    scene_free(s);
}

static void stack_lies_in_one_plane_to_the_bit(void **state) {
    (void)state;
    scene *s = generated("stack count=20 shift=0.3 split=1");
    for (uint32_t m = 0; m < s->mesh_count; m++)
        for (size_t v = 0; v < s->meshes[m].vertex_count; v++)
            assert_true(s->meshes[m].positions[v * 3 + 2] == -1);
    scene_free(s);
    s = generated("stack count=20 shift=0 tilt=33 merged=1");
    for (size_t v = 4; v < s->meshes[0].vertex_count; v++)
        assert_memory_equal(s->meshes[0].positions + v * 3, s->meshes[0].positions + v % 4 * 3, 12);
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns_agree_with_sin_and_cos),
        cmocka_unit_test(random_numbers_are_even_and_depend_on_the_seed),
        cmocka_unit_test(solids_face_outwards),
        cmocka_unit_test(sphere_seams_share_their_bits),
        cmocka_unit_test(every_scene_generates_and_repeats_itself),
        cmocka_unit_test(hard_cases_generate_and_repeat_themselves),
        cmocka_unit_test(counts_are_what_the_knobs_say),
        cmocka_unit_test(wrong_knobs_are_named_with_the_list),
        cmocka_unit_test(soup_has_the_depth_it_is_asked_for),
        cmocka_unit_test(layers_cover_exactly_the_pixels_asked_for),
        cmocka_unit_test(bursts_have_as_many_fragments_as_asked_for),
        cmocka_unit_test(layers_have_distinct_depths),
        cmocka_unit_test(stack_lies_in_one_plane_to_the_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
