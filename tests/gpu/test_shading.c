/* SPDX-License-Identifier: MIT
 *
 * shaders/strata, what a fragment of the scene is: texels and wrap modes, mip levels in linear
 * light, facing and mirroring, alpha tests, splats, normal maps, and that nothing non-finite leaves
 * it. Each case holds on every backend.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/stage.h"
#include "image/image.h"

/* Draws on each backend and hands the picture over. */
static void on_each(const scene *s, drawing_options options,
                    void (*check)(const drawing *d, const void *user), const void *user) {
    for (int b = 0; b < 2; b++) {
        gpu *g = stage_open(stage_backends[b]);
        if (!g)
            continue;
        drawing d = stage_draw(g, s, options);
        check(&d, user);
        drawing_free(&d);
        gpu_close(g);
    }
}

static void close_to(float value, double expected, double tolerance) {
    if (!(fabs((double)value - expected) <= tolerance))
        fail_msg("%.9g is not %.9g +- %g", (double)value, expected, tolerance);
}

/* ---- textures -------------------------------------------------------------------------------- */

static const unsigned char four[4][4] = {/* upper left, upper right, lower left, lower right */
                                         {255, 0, 0, 255},
                                         {0, 188, 0, 255},
                                         {0, 0, 64, 255},
                                         {255, 255, 255, 255}};

static scene *textured(scene_wrap u, scene_wrap v, scene_filter filter, float scale, float offset) {
    stage t = stage_new();
    uint32_t m = stage_material(&t, 1, 1, 1);
    scene_texture *texture = &t.s->materials[m].base_color_texture;
    texture->image = stage_image(&t, 2, 2, &four[0][0]);
    texture->magnify = texture->minify = filter;
    texture->mipmap = SCENE_MIP_NONE;
    texture->wrap_u = u;
    texture->wrap_v = v;
    texture->scale_rotate[0] = texture->scale_rotate[3] = scale;
    texture->offset[0] = texture->offset[1] = offset;
    stage_quad(&t, m, -1, -1, 1, 1, 0);
    stage_finish(&t);
    return t.s;
}

static void is_texel(const drawing *d, uint32_t x, uint32_t y, int texel) {
    for (int c = 0; c < 3; c++)
        close_to(stage_pixel(d, x, y)[c], (double)image_srgb_to_linear(four[texel][c]), 1e-3);
}

static void check_corners(const drawing *d, const void *user) {
    (void)user;
    is_texel(d, 0, 1, 0); /* y 0 is the bottom row */
    is_texel(d, 1, 1, 1);
    is_texel(d, 0, 0, 2);
    is_texel(d, 1, 0, 3);
}

static void texels_stand_upright(void **state) {
    (void)state;
    scene *s = textured(SCENE_REPEAT, SCENE_REPEAT, SCENE_NEAREST, 1, 0);
    on_each(s, (drawing_options){.width = 2, .height = 2}, check_corners, NULL);
    scene_free(s);
}

/* Six by six pixels show uv from -1 to 2: which column or row of the image each one has. */
static const int wrapped[3][6] = {{0, 1, 0, 1, 0, 1}, {1, 0, 0, 1, 1, 0}, {0, 0, 0, 1, 1, 1}};

static void check_wrap(const drawing *d, const void *user) {
    const int *modes = user;
    for (uint32_t y = 0; y < 6; y++)
        for (uint32_t x = 0; x < 6; x++)
            is_texel(d, x, 5 - y, wrapped[modes[0]][x] + 2 * wrapped[modes[1]][y]);
}

static void wrap_modes(void **state) {
    (void)state;
    for (int u = 0; u < 3; u++) {
        int modes[2] = {u, (u + 1) % 3};
        scene *s = textured((scene_wrap)modes[0], (scene_wrap)modes[1], SCENE_NEAREST, 3, -1);
        on_each(s, (drawing_options){.width = 6, .height = 6}, check_wrap, modes);
        scene_free(s);
    }
}

static void check_linear(const drawing *d, const void *user) {
    (void)user;
    double red = (double)image_srgb_to_linear(255), green = (double)image_srgb_to_linear(188);
    /* Row 6 of 8 is at v = 3/16: above the upper texels' centres, clamped; u = 5/16 and 7/16. */
    close_to(stage_pixel(d, 2, 6)[0], red * 0.875, 1e-3);
    close_to(stage_pixel(d, 2, 6)[1], green * 0.125, 1e-3);
    close_to(stage_pixel(d, 3, 6)[0], red * 0.625, 1e-3);
}

static void linear_filter(void **state) {
    (void)state;
    scene *s = textured(SCENE_CLAMP, SCENE_CLAMP, SCENE_LINEAR, 1, 0);
    on_each(s, (drawing_options){.width = 8, .height = 8}, check_linear, NULL);
    scene_free(s);
}

static void check_half(const drawing *d, const void *user) {
    const double *expected = user;
    for (uint32_t i = 0; i < d->width * d->height; i++)
        close_to(d->pixels[i * 4], *expected, 0.01);
}

/* A fine checkerboard seen from afar is as bright as half of it: 0.5, where averaging the codes
 * would give 0.21. */
static void levels_average_light(void **state) {
    (void)state;
    for (int size = 63; size <= 64; size++) {
        unsigned char *board = base_calloc((size_t)(size * size), 4);
        assert_non_null(board);
        for (int i = 0; i < size * size; i++)
            memset(board + i * 4, (i / size + i % size) % 2 ? 255 : 0, 3);
        for (int i = 0; i < size * size; i++)
            board[i * 4 + 3] = 255;
        stage t = stage_new();
        uint32_t m = stage_material(&t, 1, 1, 1);
        t.s->materials[m].base_color_texture.image =
            stage_image(&t, (uint32_t)size, (uint32_t)size, board);
        stage_quad(&t, m, -1, -1, 1, 1, 0);
        stage_finish(&t);
        double half = 0.5;
        on_each(t.s, (drawing_options){.width = 4, .height = 4}, check_half, &half);
        scene_free(t.s);
        free(board);
    }
}

static void check_covered(const drawing *d, const void *user) {
    const unsigned *expected = user; /* bit 0: lower left quarter is there ... 3: upper right */
    for (uint32_t i = 0; i < 4; i++) {
        uint32_t x = i % 2 ? d->width * 3 / 4 : d->width / 4;
        uint32_t y = i / 2 ? d->height * 3 / 4 : d->height / 4;
        assert_int_equal(d->depths[y * d->width + x] > 0.0f, *expected >> i & 1);
    }
}

static void alpha_tests_cut_holes(void **state) {
    (void)state;
    static const unsigned char alphas[4][4] = {
        {9, 9, 9, 255}, {9, 9, 9, 127}, {9, 9, 9, 0}, {9, 9, 9, 128}};
    for (uint32_t exact = 0; exact < 2; exact++) {
        stage t = stage_new();
        uint32_t m = stage_material(&t, 1, 1, 1);
        scene_texture *texture = &t.s->materials[m].base_color_texture;
        t.s->materials[m].alpha = SCENE_MASK;
        texture->image = stage_image(&t, 2, 2, &alphas[0][0]);
        texture->magnify = SCENE_NEAREST;
        stage_quad(&t, m, -1, -1, 1, 1, 0);
        stage_finish(&t);
        unsigned expected = 2u | 4u; /* 128 / 255 is above one half */
        on_each(t.s, (drawing_options){.width = 32, .height = 32, .exact = exact}, check_covered,
                &expected);
        scene_free(t.s);
    }
}

/* ---- facing ---------------------------------------------------------------------------------- */

/* Four quads: as it is, mirrored, turned around, turned and mirrored. */
static scene *four_facings(uint32_t double_sided, uint32_t unlit) {
    static const float centres[4][2] = {{-0.5f, -0.5f}, {0.5f, -0.5f}, {-0.5f, 0.5f}, {0.5f, 0.5f}};
    stage t = stage_new();
    uint32_t m = stage_material(&t, 0.5f, 0.5f, 0.5f);
    t.s->materials[m].double_sided = double_sided;
    t.s->materials[m].unlit = unlit;
    t.s->materials[m].metallic = 0;
    for (int i = 0; i < 4; i++) {
        uint32_t quad = stage_quad(&t, m, -0.4f, -0.4f, 0.4f, 0.4f, 0);
        float *world = t.s->instances[quad].world;
        world[0] = i == 1 || i == 2 ? -1.0f : 1.0f; /* turned about y: x and z */
        world[10] = i == 2 ? -1.0f : 1.0f;
        if (i == 3) /* turned, then mirrored in x */
            world[10] = -1.0f;
        world[12] = centres[i][0];
        world[13] = centres[i][1];
    }
    stage_finish(&t);
    return t.s;
}

static void faces_without_a_back(void **state) {
    (void)state;
    drawing_options options = {.width = 32, .height = 32};
    /* The third shows its back; so does the fourth, which is the first mirrored in z: its normal
     * and, by glTF's rule for negative determinants, its front face away. */
    unsigned expected = 1u | 2u;
    scene *s = four_facings(0, 1);
    on_each(s, options, check_covered, &expected);
    scene_free(s);
    s = four_facings(0, 0);
    on_each(s, options, check_covered, &expected);
    scene_free(s);
    expected = 15;
    s = four_facings(1, 1);
    on_each(s, options, check_covered, &expected);
    scene_free(s);
}

static void check_same_light(const drawing *d, const void *user) {
    (void)user;
    const float *first = stage_pixel(d, 8, 8);
    assert_true(first[0] > 0.05f && first[0] < 1.0f);
    for (uint32_t i = 1; i < 4; i++)
        assert_memory_equal(stage_pixel(d, i % 2 ? 24 : 8, i / 2 ? 24 : 8), first, 16);
}

/* Both sides of a double-sided face that faces the eye are lit alike, mirrored or not. */
static void both_sides_are_lit_alike(void **state) {
    (void)state;
    scene *s = four_facings(1, 0);
    on_each(s, (drawing_options){.width = 32, .height = 32}, check_same_light, NULL);
    scene_free(s);
}

/* ---- splats ---------------------------------------------------------------------------------- */

static void check_disc(const drawing *d, const void *user) {
    const double *radius = user; /* pixels */
    double count = 0.0;
    for (uint32_t y = 0; y < d->height; y++)
        for (uint32_t x = 0; x < d->width; x++) {
            double dx = x + 0.5 - d->width / 2.0, dy = y + 0.5 - d->height / 2.0;
            int inside = d->depths[y * d->width + x] > 0.0f;
            count += inside;
            if (fabs(sqrt(dx * dx + dy * dy) - *radius) > 0.1)
                assert_int_equal(inside, dx * dx + dy * dy < *radius * *radius);
        }
    assert_true(count > 0.0);
}

static void splats_are_discs(void **state) {
    (void)state;
    const float centre[3] = {0, 0, 0}, radius = 0.25f;
    for (uint32_t samples = 1; samples <= 4; samples += 3)
        for (int own = 0; own < 2; own++) {
            stage t = stage_new();
            stage_points(&t, stage_material(&t, 1, 1, 1), centre, own ? &radius : NULL, 1);
            stage_finish(&t);
            float *world = t.s->instances[0].world;
            world[0] = world[5] = world[10] = 2.0f; /* scales the radius too */
            double pixels = own ? 0.25 * 2.0 * 32.0 : samples == 4 ? 3.0 : 1.5;
            on_each(t.s, (drawing_options){.width = 64, .height = 64, .samples = samples},
                    check_disc, &pixels);
            scene_free(t.s);
        }
}

/* ---- light ----------------------------------------------------------------------------------- */

static void check_finite(const drawing *d, const void *user) {
    (void)user;
    for (uint32_t i = 0; i < d->width * d->height * 4; i++)
        assert_true(isfinite(d->pixels[i]));
}

static void nothing_non_finite_leaves(void **state) {
    (void)state;
    stage t = stage_new();
    uint32_t m = stage_material(&t, 3e38f, -3e38f, 1e-45f);
    scene_material *material = &t.s->materials[m];
    material->unlit = 0;
    material->emissive[0] = 3e38f;
    material->roughness = 0;
    t.s->lights = base_calloc(1, sizeof *t.s->lights);
    assert_non_null(t.s->lights);
    t.s->light_count = 1;
    t.s->lights[0] = (scene_light){.kind = SCENE_POINT, .node = SCENE_NONE, .color = {3e38f, 1, 1}};
    stage_quad(&t, m, -1, -1, 1, 1, 0); /* the light stands in its plane */
    stage_finish(&t);
    on_each(t.s, (drawing_options){.width = 16, .height = 16}, check_finite, NULL);
    scene_free(t.s);
}

/* A white matt wall under lamps of pi lux together shows 1, and what the sky adds. */
static void check_lambert(const drawing *d, const void *user) {
    const double *share = user;
    close_to(stage_pixel(d, 8, 8)[1], *share, 0.02);
}

static double wall(float cosine, uint32_t lamps) {
    stage t = stage_new();
    uint32_t m = stage_material(&t, 0.5f, 0.5f, 0.5f);
    scene_material *material = &t.s->materials[m];
    material->unlit = 0;
    material->metallic = 0;
    material->ior = 1; /* no mirror */
    t.s->lights = base_calloc(lamps, sizeof *t.s->lights);
    assert_non_null(t.s->lights);
    t.s->light_count = lamps;
    for (uint32_t i = 0; i < lamps; i++) { /* the last one is as bright as all others */
        const float lux = 3.14159265f / (lamps == 1       ? 1.0f
                                         : i + 1 == lamps ? 2.0f
                                                          : 2.0f * (float)(lamps - 1));
        t.s->lights[i] = (scene_light){.kind = SCENE_DIRECTIONAL,
                                       .node = SCENE_NONE,
                                       .color = {lux, lux, lux},
                                       .direction = {sqrtf(1 - cosine * cosine), 0, -cosine}};
    }
    stage_quad(&t, m, -1, -1, 1, 1, 0);
    stage_finish(&t);
    const double sky = 0.5 * 0.375; /* a wall sees as much of it as ground */
    double expected = 0.5 * (double)cosine + sky;
    on_each(t.s, (drawing_options){.width = 16, .height = 16}, check_lambert, &expected);
    scene_free(t.s);
    return expected;
}

static void light_falls_with_the_cosine(void **state) {
    (void)state;
    assert_true(wall(1.0f, 1) > wall(0.5f, 1));
    wall(1.0f, 4); /* as many as come flat */
    wall(1.0f, 5);
}

static void check_bump(const drawing *d, const void *user) {
    (void)user; /* left half leans to the left, towards the lamp */
    assert_true(stage_pixel(d, 4, 8)[0] > stage_pixel(d, 12, 8)[0] + 0.1f);
}

/* A normal map without tangents in the file: the axes come from the coordinates on screen. */
static void normal_maps_need_no_tangents(void **state) {
    (void)state;
    static const unsigned char lean[2][4] = {{37, 128, 218, 255}, {218, 128, 218, 255}};
    for (int given = 0; given < 2; given++) {
        stage t = stage_new();
        uint32_t m = stage_material(&t, 0.5f, 0.5f, 0.5f);
        scene_material *material = &t.s->materials[m];
        material->unlit = 0;
        material->metallic = 0;
        material->normal_texture.image = stage_image(&t, 2, 1, &lean[0][0]);
        material->normal_texture.magnify = SCENE_NEAREST;
        t.s->lights = base_calloc(1, sizeof *t.s->lights);
        assert_non_null(t.s->lights);
        t.s->light_count = 1;
        t.s->lights[0] = (scene_light){.kind = SCENE_DIRECTIONAL,
                                       .node = SCENE_NONE,
                                       .color = {3, 3, 3},
                                       .direction = {0.7071068f, 0, -0.7071068f}};
        stage_quad(&t, m, -1, -1, 1, 1, 0);
        if (given) {
            float *tangents = t.s->meshes[0].tangents = base_calloc(4, 4 * sizeof(float));
            assert_non_null(tangents);
            for (int i = 0; i < 4; i++)
                tangents[i * 4] = tangents[i * 4 + 3] = 1.0f;
        }
        stage_finish(&t);
        on_each(t.s, (drawing_options){.width = 16, .height = 16}, check_bump, NULL);
        scene_free(t.s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_stand_upright),
        cmocka_unit_test(wrap_modes),
        cmocka_unit_test(linear_filter),
        cmocka_unit_test(levels_average_light),
        cmocka_unit_test(alpha_tests_cut_holes),
        cmocka_unit_test(faces_without_a_back),
        cmocka_unit_test(both_sides_are_lit_alike),
        cmocka_unit_test(splats_are_discs),
        cmocka_unit_test(nothing_non_finite_leaves),
        cmocka_unit_test(light_falls_with_the_cosine),
        cmocka_unit_test(normal_maps_need_no_tangents),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
