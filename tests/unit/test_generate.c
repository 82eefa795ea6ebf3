/* SPDX-License-Identifier: MIT
 *
 * The procedural scenes and the GLB writer: the same bits for the same seed, counts and depths as
 * the knobs say, solids that face outwards, knob errors, and files that the loader reads back.
 */
#define _POSIX_C_SOURCE 200809L
#include "image/image.h"
#include "scene/camera.h"
#include "scene/generate.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/strata-generate-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

/* Generates a scene from "name knob=value ...". */
static scene *generate(const char *text) {
    char copy[256], *words[16], *rest = NULL;
    uint32_t count = 0;
    scene *s = NULL;
    base_error err = {0};
    snprintf(copy, sizeof copy, "%s", text);
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest))
        words[count++] = word;
    strata_result result =
        scene_generate(words[0], (const char *const *)words + 1, count - 1, &s, &err);
    if (result != STRATA_OK)
        fail_msg("%s: %s", text, err.text);
    return s;
}

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
    assert_int_equal(count, 9);
    for (uint32_t i = 0; i < count; i++) {
        char seeded[64];
        snprintf(seeded, sizeof seeded, "%s seed=42", kinds[i].name);
        assert_string_equal(kinds[i].knobs[0].name, "seed");
        scene *a = generate(kinds[i].name), *b = generate(kinds[i].name), *c = generate(seeded);
        assert_true(hash_scene(a) == hash_scene(b));
        assert_true(hash_scene(a) != hash_scene(c) || strcmp(kinds[i].name, "shells") == 0 ||
                    strcmp(kinds[i].name, "glass") == 0);
        assert_true(a->primitive_count > 0 && a->camera_count > 0);
        scene_free(a);
        scene_free(b);
        scene_free(c);
    }
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
        scene *s = generate(cases[i].text);
        assert_int_equal(s->primitive_count, cases[i].primitives);
        assert_int_equal(s->instance_count, cases[i].instances);
        scene_free(s);
    }
    scene *s = generate("city count=500 glass=0");
    assert_int_equal(s->instance_count, 501);
    assert_in_range(s->mesh_count, 2, 8);
    scene_free(s);
    s = generate("needles");
    assert_in_range(s->primitive_count, 37800, 43000);
    scene_free(s);
    s = generate("glass");
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
    scene *s = generate("soup");
    coverage c = cover(s, 512);
    assert_true(c.mean > 41 && c.mean < 42.2);
    assert_in_range(c.max, 60, 78);
    free(c.count);
    scene_free(s);
    s = generate("soup small=20000 medium=0 depth=5");
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
        scene *s = generate(text);
        coverage c = cover(s, sizes[i]);
        for (size_t p = 0; p < (size_t)sizes[i] * sizes[i]; p++)
            assert_int_equal(c.count[p], 70);
        free(c.count);
        scene_free(s);
        strcat(text, " where=pixel");
        s = generate(text);
        c = cover(s, sizes[i]);
        size_t middle = (size_t)(sizes[i] / 2) * sizes[i] + sizes[i] / 2;
        for (size_t p = 0; p < (size_t)sizes[i] * sizes[i]; p++)
            assert_int_equal(c.count[p], p == middle ? 70 : 0);
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
    scene *s = generate("layers count=1000000");
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
    scene *s = generate("stack count=20 shift=0.3 split=1");
    for (uint32_t m = 0; m < s->mesh_count; m++)
        for (size_t v = 0; v < s->meshes[m].vertex_count; v++)
            assert_true(s->meshes[m].positions[v * 3 + 2] == -1);
    scene_free(s);
    s = generate("stack count=20 shift=0 tilt=33 merged=1");
    for (size_t v = 4; v < s->meshes[0].vertex_count; v++)
        assert_memory_equal(s->meshes[0].positions + v * 3, s->meshes[0].positions + v % 4 * 3, 12);
    scene_free(s);
}

/* ---- GLB ------------------------------------------------------------------------------------ */

static void assert_near(const float *a, const float *b, size_t count, double tolerance) {
    assert_true(!a == !b);
    for (size_t i = 0; a && i < count; i++)
        if (!(fabs((double)a[i] - (double)b[i]) <= tolerance * fmax(1, fabs((double)a[i]))))
            fail_msg("value %zu: %.9g became %.9g", i, (double)a[i], (double)b[i]);
}

static void assert_same_mesh(const scene_mesh *a, const scene_mesh *b) {
    assert_int_equal(a->topology, b->topology);
    assert_int_equal(a->material, b->material);
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->index_count, b->index_count);
    assert_memory_equal(a->indices, b->indices, a->index_count * sizeof(uint32_t));
    size_t n = a->vertex_count;
    assert_near(a->positions, b->positions, n * 3, 0);
    assert_near(a->normals, b->normals, n * 3, 1e-6); /* the loader normalises once more */
    assert_near(a->uv0, b->uv0, n * 2, 0);
    assert_near(a->colors, b->colors, n * 4, 0);
    assert_near(a->radii, b->radii, n, 0);
}

static void assert_same_texture(const scene *sa, const scene_texture *a, const scene *sb,
                                const scene_texture *b) {
    assert_int_equal(a->image == SCENE_NONE, b->image == SCENE_NONE);
    if (a->image == SCENE_NONE)
        return;
    const scene_image *x = &sa->images[a->image], *y = &sb->images[b->image];
    assert_int_equal(x->width, y->width);
    assert_int_equal(x->height, y->height);
    assert_memory_equal(x->pixels, y->pixels, (size_t)x->width * x->height * 4);
    assert_near(a->scale_rotate, b->scale_rotate, 4, 1e-6);
    assert_near(a->offset, b->offset, 2, 1e-6);
    assert_int_equal(a->uv, b->uv);
    assert_int_equal(a->magnify, b->magnify);
    assert_int_equal(a->minify, b->minify);
    assert_int_equal(a->mipmap, b->mipmap);
    assert_int_equal(a->wrap_u, b->wrap_u);
    assert_int_equal(a->wrap_v, b->wrap_v);
}

static void assert_same_material(const scene *sa, const scene_material *a, const scene *sb,
                                 const scene_material *b) {
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->alpha, b->alpha);
    assert_int_equal(a->double_sided, b->double_sided);
    assert_int_equal(a->unlit, b->unlit);
    assert_near(a->base_color, b->base_color, 4, 0);
    assert_near(a->emissive, b->emissive, 3, 1e-6);
    const float x[] = {a->metallic,     a->roughness,          a->ior,         a->transmission,
                       a->normal_scale, a->occlusion_strength, a->alpha_cutoff};
    const float y[] = {b->metallic,     b->roughness,          b->ior,         b->transmission,
                       b->normal_scale, b->occlusion_strength, b->alpha_cutoff};
    assert_near(x, y, BASE_COUNT(x), 0);
    assert_same_texture(sa, &a->base_color_texture, sb, &b->base_color_texture);
    assert_same_texture(sa, &a->metallic_roughness_texture, sb, &b->metallic_roughness_texture);
    assert_same_texture(sa, &a->normal_texture, sb, &b->normal_texture);
    assert_same_texture(sa, &a->occlusion_texture, sb, &b->occlusion_texture);
    assert_same_texture(sa, &a->emissive_texture, sb, &b->emissive_texture);
    assert_same_texture(sa, &a->transmission_texture, sb, &b->transmission_texture);
}

static void assert_same_scene(const scene *a, const scene *b) {
    assert_int_equal(a->mesh_count, b->mesh_count);
    assert_int_equal(a->instance_count, b->instance_count);
    assert_int_equal(a->material_count, b->material_count);
    assert_int_equal(a->light_count, b->light_count);
    assert_int_equal(a->camera_count, b->camera_count);
    assert_int_equal(a->primitive_count, b->primitive_count);
    for (uint32_t i = 0; i < a->mesh_count; i++)
        assert_same_mesh(&a->meshes[i], &b->meshes[i]);
    for (uint32_t i = 0; i < a->instance_count; i++) {
        assert_int_equal(a->instances[i].mesh, b->instances[i].mesh);
        assert_int_equal(a->instances[i].primitive_base, b->instances[i].primitive_base);
        assert_near(a->instances[i].world, b->instances[i].world, 16, 2e-6);
    }
    for (uint32_t i = 0; i < a->material_count; i++)
        assert_same_material(a, &a->materials[i], b, &b->materials[i]);
    for (uint32_t i = 0; i < a->light_count; i++) {
        const scene_light *x = &a->lights[i], *y = &b->lights[i];
        assert_int_equal(x->kind, y->kind);
        assert_near(x->color, y->color, 3, 1e-6);
        if (x->kind != SCENE_DIRECTIONAL)
            assert_near(x->position, y->position, 3, 1e-6);
        if (x->kind != SCENE_POINT)
            assert_near(x->direction, y->direction, 3, 1e-6);
        const float range[2] = {x->range, y->range};
        assert_near(range, range + 1, 1, 0);
        if (x->kind == SCENE_SPOT) {
            assert_near(&x->inner_cos, &y->inner_cos, 1, 1e-6);
            assert_near(&x->outer_cos, &y->outer_cos, 1, 1e-6);
        }
    }
    for (uint32_t i = 0; i < a->camera_count; i++) {
        const scene_camera *x = &a->cameras[i], *y = &b->cameras[i];
        assert_string_equal(x->name, y->name);
        assert_int_equal(x->projection, y->projection);
        const float p[] = {x->yfov, x->aspect, x->znear, x->zfar, x->xmag, x->ymag};
        const float q[] = {y->yfov, y->aspect, y->znear, y->zfar, y->xmag, y->ymag};
        assert_near(p, q, BASE_COUNT(p), 0);
        assert_near(x->world, y->world, 16, 1e-6);
    }
}

static void round_trip(const scene *s) {
    char path[128];
    base_error err = {0};
    scene *back = NULL;
    snprintf(path, sizeof path, "%s/scene.glb", folder);
    if (scene_write_glb(s, path, &err) != STRATA_OK || scene_load(path, &back, &err) != STRATA_OK)
        fail_msg("%s: %s", s->path, err.text);
    for (uint32_t i = 0; i < back->warning_count; i++)
        fail_msg("%s: warning: %s", s->path, back->warnings[i]);
    assert_same_scene(s, back);
    scene_free(back);
}

static void every_scene_survives_the_file(void **state) {
    (void)state;
    static const char *const texts[] = {"shells",
                                        "shells transmission=0.9",
                                        "soup small=500 medium=20",
                                        "hairball",
                                        "needles",
                                        "particles",
                                        "stack opaque=1 tilt=20",
                                        "city count=300",
                                        "city view=aerial count=20",
                                        "layers opaque=1 where=pixel",
                                        "glass"};
    for (size_t i = 0; i < BASE_COUNT(texts); i++) {
        scene *s = generate(texts[i]);
        round_trip(s);
        scene_free(s);
    }
}

/* All that no generator makes: turned, mirrored and sheared instances of one mesh, odd names,
 * every texture slot and filter, emission above 1, a spot light, an invisible instance. */
static void odd_scenes_survive_the_file(void **state) {
    (void)state;
    scene *s = generate("city count=12 glass=1 seed=3");
    free(s->materials[0].name);
    s->materials[0].name = base_strdup("a \"quoted\" \\ name\twith \xc3\xa9");
    scene_material *m = &s->materials[1];
    scene_texture *slots[] = {&m->metallic_roughness_texture, &m->normal_texture,
                              &m->occlusion_texture, &m->emissive_texture,
                              &m->transmission_texture};
    for (size_t i = 0; i < BASE_COUNT(slots); i++) {
        double angle = 0.3 + (double)i, c = cos(angle), n = sin(angle);
        *slots[i] = (scene_texture){
            .image = 0,
            .scale_rotate = {(float)(2 * c), (float)(-0.5 * -n), (float)(-2 * n), (float)(0.5 * c)},
            .offset = {0.25f, (float)i},
            .magnify = i % 2 ? SCENE_LINEAR : SCENE_NEAREST,
            .minify = i % 2 ? SCENE_NEAREST : SCENE_LINEAR,
            .mipmap = (scene_mipmap)(i % 3),
            .wrap_u = (scene_wrap)(i % 3),
            .wrap_v = (scene_wrap)((i + 1) % 3)};
    }
    m->emissive[0] = 7.5f;
    m->emissive[1] = 0.25f;
    m->ior = 1.33f;
    m->transmission = 0.5f;
    m->alpha = SCENE_MASK;
    m->alpha_cutoff = 0.3f;
    m->normal_scale = 0.7f;
    m->occlusion_strength = 0.6f;
    s->lights[1] = (scene_light){.name = s->lights[1].name,
                                 .kind = SCENE_SPOT,
                                 .node = SCENE_NONE,
                                 .color = {3, 2, 1},
                                 .range = 50,
                                 .inner_cos = 0.9f,
                                 .outer_cos = 0.6f,
                                 .position = {1, 2, 3},
                                 .direction = {0, 0.6f, 0.8f}};
    for (uint32_t i = 2; i < s->instance_count; i++) {
        float *w = s->instances[i].world, angle = 0.7f * (float)i;
        const float c = cosf(angle), n = sinf(angle);
        memcpy(w, (const float[12]){2 * c, 0, -2 * n, 0, 0, i % 3 ? 3.0f : -3.0f, 0, 0, n, 0, c, 0},
               12 * sizeof(float));
        if (i % 5 == 0)
            w[4] = 0.5f; /* shear */
    }
    round_trip(s);
    s->instances[s->instance_count - 1].visible = 0;
    char path[128];
    base_error err = {0};
    scene *back;
    snprintf(path, sizeof path, "%s/hidden.glb", folder);
    assert_int_equal(scene_write_glb(s, path, &err), STRATA_OK);
    assert_int_equal(scene_load(path, &back, &err), STRATA_OK);
    assert_int_equal(back->instance_count, s->instance_count - 1);
    scene_free(back);
    err = (base_error){0};
    assert_int_equal(scene_write_glb(s, "/no/such/folder/x.glb", &err), STRATA_ERROR_NOT_FOUND);
    scene_free(s);
}

/* Hundreds of houses are a few nodes, not hundreds. */
static void repeated_meshes_are_instanced(void **state) {
    (void)state;
    char path[128];
    base_error err = {0};
    unsigned char *data;
    size_t size, nodes = 0;
    scene *s = generate("city count=900");
    snprintf(path, sizeof path, "%s/city.glb", folder);
    assert_int_equal(scene_write_glb(s, path, &err), STRATA_OK);
    assert_int_equal(base_file_read(path, 1 << 24, &data, &size, &err), STRATA_OK);
    for (const char *at = (char *)data + 20; (at = strstr(at, "\"mesh\":")); at++)
        nodes++;
    assert_in_range(nodes, 2, 8);
    assert_non_null(
        strstr((char *)data + 20, "\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"]"));
    free(data);
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(turns_agree_with_sin_and_cos),
        cmocka_unit_test(random_numbers_are_even_and_depend_on_the_seed),
        cmocka_unit_test(solids_face_outwards),
        cmocka_unit_test(sphere_seams_share_their_bits),
        cmocka_unit_test(every_scene_generates_and_repeats_itself),
        cmocka_unit_test(counts_are_what_the_knobs_say),
        cmocka_unit_test(wrong_knobs_are_named_with_the_list),
        cmocka_unit_test(soup_has_the_depth_it_is_asked_for),
        cmocka_unit_test(layers_cover_exactly_the_pixels_asked_for),
        cmocka_unit_test(layers_have_distinct_depths),
        cmocka_unit_test(stack_lies_in_one_plane_to_the_bit),
        cmocka_unit_test(every_scene_survives_the_file),
        cmocka_unit_test(odd_scenes_survive_the_file),
        cmocka_unit_test(repeated_meshes_are_instanced),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
