/* SPDX-License-Identifier: MIT
 *
 * Sub-pixels and their filter: a picture of several samples is, bit for bit, the weighted mean of
 * the picture rendered at the size of the sub-pixel grid; within a derived bound it is the mean as
 * computed in double from the definition of the weights; and what is even stays even.
 */
#define _GNU_SOURCE

#include "scenes/glb.h"
#include "techniques/picture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "render/render.h"

static const char *const backends[] = {"vulkan", "gl"};
static const char *const filters[] = {"box", "tent", "gaussian"};

static strata_render_options options_of(uint32_t width, uint32_t height, uint32_t samples,
                                        const char *filter) {
    return (strata_render_options){.struct_size = sizeof(strata_render_options),
                                   .width = width,
                                   .height = height,
                                   .samples = samples,
                                   .filter = filter};
}

static picture read_output(strata *instance, uint32_t output, uint32_t width, uint32_t height) {
    picture p = {.width = width, .height = height};
    const size_t size = (size_t)width * height * 4 * sizeof(float);
    p.pixels = malloc(size);
    assert_non_null(p.pixels);
    if (strata_read(instance, output, p.pixels, size) != STRATA_OK)
        fail_msg("%s", strata_error(instance));
    return p;
}

static picture render_output(strata *instance, strata_scene *sc, strata_render_options options,
                             uint32_t output) {
    options.outputs |= output;
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%u samples, %s: %s", options.samples, options.filter ? options.filter : "",
                 strata_error(instance));
    return read_output(instance, output, options.width, options.height);
}

/* ---- references ------------------------------------------------------------------------------ */

static double weight(const char *filter, double distance) {
    if (strcmp(filter, "tent") == 0)
        return distance < 1 ? 1 - distance : 0;
    if (strcmp(filter, "gaussian") == 0)
        return distance < 1.5 ? exp(-2 * distance * distance) : 0;
    return distance < 0.5 ? 1 : 0;
}

/* Of sub-pixel `sub` for pixel `pixel` on one axis. */
static double weight_at(const char *filter, uint32_t side, uint32_t pixel, uint32_t sub) {
    return weight(filter, fabs((sub + 0.5) / side - (pixel + 0.5)));
}

static int opposite_row(const picture *p, uint32_t y) {
    return (int)(p->height - 1 - y); /* pictures begin at the top, sums at the lowest row */
}

/* In float and in the order of the module, every sub-pixel of weight above 0. */
static void mean_float(const picture *subs, const char *filter, uint32_t side, uint32_t x,
                       uint32_t y, float out[4]) {
    float sum[4] = {0}, low[4], high[4], total = 0;
    for (int c = 0; c < 4; ++c) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
    }
    for (uint32_t j = 0; j < subs->height; ++j)
        for (uint32_t i = 0; i < subs->width; ++i) {
            const float v = (float)weight_at(filter, side, y, j),
                        h = (float)weight_at(filter, side, x, i), w = v * h;
            if (!(v > 0) || !(h > 0))
                continue;
            const float *value =
                subs->pixels + 4 * ((size_t)opposite_row(subs, j) * subs->width + i);
            for (int c = 0; c < 4; ++c) {
                const float term = w * value[c];
                sum[c] = sum[c] + term;
                low[c] = fminf(low[c], value[c]);
                high[c] = fmaxf(high[c], value[c]);
            }
            total = total + w;
        }
    for (int c = 0; c < 4; ++c)
        out[c] = fminf(fmaxf(sum[c] / total, low[c]), high[c]);
}

/* From the definition, in double; *terms: how many sub-pixels count, magnitude: the mean of
 * |value|. */
static void mean_double(const picture *subs, const char *filter, uint32_t side, uint32_t x,
                        uint32_t y, double out[4], double magnitude[4], double *terms) {
    double total = 0;
    *terms = 0;
    for (int c = 0; c < 4; ++c)
        out[c] = magnitude[c] = 0;
    for (uint32_t j = 0; j < subs->height; ++j)
        for (uint32_t i = 0; i < subs->width; ++i) {
            const double w = weight_at(filter, side, x, i) *
                             weight_at(filter, side, y, (uint32_t)opposite_row(subs, j));
            const float *value = subs->pixels + 4 * ((size_t)j * subs->width + i);
            if (w == 0)
                continue;
            for (int c = 0; c < 4; ++c) {
                out[c] += w * (double)value[c];
                magnitude[c] += w * fabs((double)value[c]);
            }
            total += w;
            *terms += 1;
        }
    for (int c = 0; c < 4; ++c) {
        out[c] /= total;
        magnitude[c] /= total;
    }
}

/* The sums of m terms and their division: gamma(2 m + 6) of the mean of magnitudes. */
static double rounding(double terms) {
    const double u = ldexp(1, -24), m = 2 * terms + 6;
    return m * u / (1 - m * u);
}

/* ---- pictures -------------------------------------------------------------------------------- */

static void check_picture(const picture *p, const picture *subs, const char *filter, uint32_t side,
                          const char *what) {
    for (uint32_t y = 0; y < p->height; ++y)
        for (uint32_t x = 0; x < p->width; ++x) {
            const float *seen = p->pixels + 4 * ((size_t)opposite_row(p, y) * p->width + x);
            float same[4];
            double exact[4], magnitude[4], terms;
            mean_float(subs, filter, side, x, y, same);
            if (memcmp(same, seen, sizeof same) != 0)
                fail_msg("%s, %s, side %u: pixel (%u, %u) is %a, not %a", what, filter, side, x, y,
                         (double)seen[0], (double)same[0]);
            mean_double(subs, filter, side, x, y, exact, magnitude, &terms);
            for (int c = 0; c < 4; ++c)
                if (fabs((double)seen[c] - exact[c]) > rounding(terms) * magnitude[c])
                    fail_msg("%s, %s, side %u: pixel (%u, %u) is farther than rounding from %a",
                             what, filter, side, x, y, exact[c]);
        }
}

/* Every filter of a scene against the scene at the size of its sub-pixel grid, both backends. */
static void check_scene(const char *path, uint32_t width, uint32_t height, uint32_t side) {
    picture subs = {0};
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, path);
        const way large = {.backend = backends[b]};
        if (!subs.pixels)
            subs = picture_render(sc, instance, &large, width * side, height * side);
        for (size_t f = 0; f < 3; ++f) {
            way w = {.backend = backends[b], .samples = side * side, .filter = filters[f]};
            picture p = picture_render(sc, instance, &w, width, height);
            check_picture(&p, &subs, filters[f], side, path);
            w.bands = 7;
            picture banded = picture_render(sc, instance, &w, width, height);
            picture_same(&p, &banded, "seven bands");
            picture_free(&banded);
            picture_free(&p);
        }
        strata_scene_close(sc);
    }
    picture_free(&subs);
}

static void pixels_are_means_of_sub_pixels(void **state) {
    (void)state;
    check_scene("scene:soup?small=1000&medium=60", 24, 20, 2);
    check_scene("scene:soup?small=1000&medium=60", 17, 13, 3);
    check_scene("scene:glass?smoke=0", 20, 15, 2);
    check_scene("scene:city?count=100", 11, 7, 4);
    check_scene("scene:needles", 1, 1, 4);
    check_scene("scene:soup?small=1000&medium=60", 1, 9, 3);
    check_scene("scene:soup?small=1000&medium=60", 7, 1, 5);
    check_scene("scene:layers?count=70", 3, 2, 2);
}

/* Nothing but a background, and layers over all of it: even, so even it stays, up to the border. */
static void even_stays_even(void **state) {
    static const uint32_t sizes[][2] = {{1, 1}, {5, 3}, {16, 16}}, sides[] = {2, 3, 5, 32};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, "scene:layers?count=0");
        for (size_t i = 0; i < 3 * 4 * 3; ++i) {
            const uint32_t side = sides[i / 3 % 4], *size = sizes[i % 3];
            strata_render_options o =
                options_of(size[0], size[1], side * side, filters[i / 12 % 3]);
            const float background[4] = {0.1f, 1.0f / 3.0f, 12345.678f, 1e-30f};
            memcpy(o.background, background, sizeof background);
            o.has_background = 1;
            picture p = render_output(instance, sc, o, STRATA_OUTPUT_COLOR);
            for (size_t k = 0; k < (size_t)size[0] * size[1]; ++k)
                assert_memory_equal(p.pixels + 4 * k, background, sizeof background);
            picture_free(&p);
        }
        strata_scene_close(sc);
    }
}

/* Exact techniques stay exact on the sub-pixel grid, points included, on both backends. */
static void every_way_gives_the_same_bits(void **state) {
    static const char *const scenes[] = {"scene:glass", "scene:particles?count=500",
                                         "scene:shells"};
    static const char *const modes[] = {"abuffer.mode=contiguous", "abuffer.mode=linked"};
    (void)state;
    for (size_t s = 0; s < 3; ++s) {
        picture first = {0};
        for (size_t i = 0; i < 4; ++i) {
            strata *instance = picture_instance(backends[i / 2]);
            if (!instance)
                continue;
            strata_scene *sc = picture_scene(instance, scenes[s]);
            const way w = {.backend = backends[i / 2],
                           .settings = {modes[i % 2]},
                           .shuffle = (uint32_t)i,
                           .samples = 4,
                           .filter = "gaussian"};
            picture p = picture_render(sc, instance, &w, 30, 23);
            strata_scene_close(sc);
            if (first.pixels) {
                picture_same(&first, &p, scenes[s]);
                picture_free(&p);
            } else {
                first = p;
            }
        }
        picture_free(&first);
    }
}

/* A splat without a radius of its own has one in pixels, however many samples a pixel has. */
static void splats_keep_their_size(void **state) {
    static const float centre[3] = {0, 0, 0};
    enum { SIZE = 9 };
    char path[] = "/tmp/strata-splat-XXXXXX.glb";
    test_glb g = {0};
    size_t size;
    (void)state;
    test_glb_floats(&g, "VEC3", 3, 1, centre);
    test_glb_json(&g, "\"extensionsUsed\":[\"KHR_materials_unlit\"],"
                      "\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0,0,5]}],"
                      "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.6,"
                      "\"znear\":0.1}}],"
                      "\"materials\":[{\"extensions\":{\"KHR_materials_unlit\":{}}}],"
                      "\"meshes\":[{\"primitives\":[{\"mode\":0,\"material\":0,"
                      "\"attributes\":{\"POSITION\":0}}]}]");
    unsigned char *file = test_glb_finish(&g, &size);
    const int fd = mkstemps(path, 4);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, file, size), size);
    assert_int_equal(close(fd), 0);
    free(file);
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, path);
        for (uint32_t side = 4; side <= 8; side += 4) {
            strata_render_options o = options_of(SIZE, SIZE, side * side, "box");
            o.has_background = 1; /* black */
            picture p = render_output(instance, sc, o, STRATA_OUTPUT_COLOR);
            double area = 0;
            for (size_t i = 0; i < SIZE * SIZE; ++i)
                area += (double)p.pixels[4 * i];
            assert_true(fabs(area - 3.14159265 * 1.5 * 1.5) < 0.3);
            picture_free(&p);
        }
        strata_scene_close(sc);
    }
    unlink(path);
}

/* ---- beside the colours ---------------------------------------------------------------------- */

static void depth_is_the_nearest(void **state) {
    enum { WIDTH = 20, HEIGHT = 15, SIDE = 3 };
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, "scene:city?count=100");
        picture p = render_output(instance, sc, options_of(WIDTH, HEIGHT, SIDE * SIDE, "tent"),
                                  STRATA_OUTPUT_DEPTH);
        picture subs = render_output(instance, sc, options_of(WIDTH * SIDE, HEIGHT * SIDE, 1, NULL),
                                     STRATA_OUTPUT_DEPTH);
        for (uint32_t i = 0; i < WIDTH * HEIGHT; ++i) {
            float nearest = INFINITY;
            for (uint32_t k = 0; k < SIDE * SIDE; ++k) {
                const uint32_t x = i % WIDTH * SIDE + k % SIDE, y = i / WIDTH * SIDE + k / SIDE;
                nearest = fminf(nearest, subs.pixels[4 * (y * subs.width + x)]);
            }
            assert_memory_equal(&p.pixels[4 * (size_t)i], &nearest, sizeof nearest);
        }
        picture_free(&p);
        picture_free(&subs);
        strata_scene_close(sc);
    }
}

/* The bound of the mean holds the mean of the bounds and the filter's own rounding, and is of its
 * size where nothing else adds to it. */
static void bounds_are_filtered(void **state) {
    static const char *const scenes[] = {"scene:city?count=100&glass=0",
                                         "scene:soup?small=500&medium=40"};
    enum { WIDTH = 16, HEIGHT = 12, SIDE = 2 };
    static const double most[] = {4, 16, 36}; /* terms, away from the border */
    (void)state;
    for (size_t i = 0; i < 2 * 2 * 3; ++i) {
        const char *filter = filters[i % 3];
        strata *instance = picture_instance(backends[i / 3 % 2]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, scenes[i / 6]);
        picture bound = render_output(instance, sc, options_of(WIDTH, HEIGHT, SIDE * SIDE, filter),
                                      STRATA_OUTPUT_BOUND);
        picture p = read_output(instance, STRATA_OUTPUT_COLOR, WIDTH, HEIGHT);
        picture sub_bounds = render_output(
            instance, sc, options_of(WIDTH * SIDE, HEIGHT * SIDE, 1, NULL), STRATA_OUTPUT_BOUND);
        picture subs = read_output(instance, STRATA_OUTPUT_COLOR, WIDTH * SIDE, HEIGHT * SIDE);
        for (uint32_t y = 0; y < HEIGHT; ++y)
            for (uint32_t x = 0; x < WIDTH; ++x) {
                const size_t at = 4 * ((size_t)opposite_row(&p, y) * WIDTH + x);
                double exact[4], magnitude[4], inherited[4], ignored[4], terms;
                mean_double(&subs, filter, SIDE, x, y, exact, magnitude, &terms);
                mean_double(&sub_bounds, filter, SIDE, x, y, inherited, ignored, &terms);
                for (int c = 0; c < 4; ++c) {
                    const double said = (double)bound.pixels[at + (size_t)c];
                    const double own = fabs((double)p.pixels[at + (size_t)c] - exact[c]);
                    assert_true(said >= inherited[c] + own);
                    assert_true(isinf(inherited[c]) ||
                                said <= inherited[c] * (1 + 1e-4) +
                                            2.01 * rounding(most[i % 3]) * magnitude[c]);
                }
            }
        picture_free(&bound);
        picture_free(&p);
        picture_free(&sub_bounds);
        picture_free(&subs);
        strata_scene_close(sc);
    }
}

/* ---- folds that filter ----------------------------------------------------------------------- */

/* Who ran the pass that filled image/1. */
static const char *filtered_by(const strata *instance) {
    const char *who = "nobody";
    for (uint32_t i = 0; i < instance->result.pass_count; ++i)
        if (strcmp(instance->result.passes[i].label, "filter") == 0)
            who = instance->result.passes[i].owner;
    return who;
}

/* Picture and bound, fused and by the module, bit for bit. */
static void check_fused(strata *instance, strata_scene *sc, const char *setting, const char *filter,
                        uint32_t bands) {
    enum { WIDTH = 19, HEIGHT = 13, SIDE = 3 };
    strata_render_options o = options_of(WIDTH, HEIGHT, SIDE * SIDE, filter);
    picture p[2], bound[2];
    o.settings = &setting;
    o.setting_count = 1;
    o.bands = bands;
    for (int i = 0; i < 2; ++i) {
        o.use = i ? "abuffer,fpc,filter" : "abuffer,fpc";
        bound[i] = render_output(instance, sc, o, STRATA_OUTPUT_BOUND);
        p[i] = read_output(instance, STRATA_OUTPUT_COLOR, WIDTH, HEIGHT);
        assert_string_equal(filtered_by(instance), i ? "filter" : "fpc");
    }
    picture_same(&p[1], &p[0], "fused");
    picture_same(&bound[1], &bound[0], "fused, its bound");
    for (size_t i = 0; i < (size_t)WIDTH * HEIGHT * 4; ++i)
        assert_true(isfinite(bound[0].pixels[i]));
    for (int i = 0; i < 2; ++i) {
        picture_free(&p[i]);
        picture_free(&bound[i]);
    }
}

/* fpc fills image/1 itself, unless --use names the module; opaque pixels and empty ones as well. */
static void a_fused_filter_gives_the_same_bits(void **state) {
    static const char *const scenes[] = {"scene:city?count=100", "scene:soup?small=500&medium=40",
                                         "scene:layers?count=70"};
    static const char *const settings[] = {"fpc.mode=fragments", "fpc.mode=hybrid",
                                           "abuffer.mode=linked"};
    (void)state;
    for (size_t i = 0; i < 2 * 3; ++i) {
        strata *instance = picture_instance(backends[i / 3]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, scenes[i % 3]);
        for (size_t k = 0; k < 3; ++k) {
            check_fused(instance, sc, settings[k], filters[k], 1);
            check_fused(instance, sc, settings[k], filters[(k + 1) % 3], 5);
        }
        strata_scene_close(sc);
    }
}

/* A scene without a transparent surface has no fold that could filter. */
static void an_opaque_scene_is_filtered_by_the_module(void **state) {
    strata *instance = picture_instance(backends[0]);
    (void)state;
    if (!instance)
        skip();
    strata_scene *sc = picture_scene(instance, "scene:city?count=20&glass=0");
    strata_render_options o = options_of(8, 8, 4, "box");
    o.use = "abuffer,fpc";
    picture p = render_output(instance, sc, o, STRATA_OUTPUT_COLOR);
    assert_string_equal(filtered_by(instance), "filter");
    picture_free(&p);
    strata_scene_close(sc);
}

/* ---- the session and its options ------------------------------------------------------------- */

/* One instance, one scene: the grid and the weights are followed from render to render. */
static void the_session_follows(void **state) {
    static const struct {
        uint32_t samples;
        const char *filter;
    } rows[] = {{4, "box"}, {4, "tent"}, {9, "tent"}, {1, NULL}, {4, "box"}, {0, "gaussian"}};
    uint64_t hashes[6];
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, "scene:soup?small=500&medium=40");
        for (size_t i = 0; i < 6; ++i) {
            const way w = {
                .backend = backends[b], .samples = rows[i].samples, .filter = rows[i].filter};
            picture p = picture_render(sc, instance, &w, 12, 12);
            hashes[i] = picture_hash(&p);
            picture_free(&p);
        }
        for (size_t i = 1; i < 4; ++i)
            assert_true(hashes[i] != hashes[i - 1]);
        assert_true(hashes[4] == hashes[0]);
        assert_true(hashes[5] == hashes[3]); /* one sample is not filtered */
        strata_scene_close(sc);
    }
}

static void senseless_options_are_refused(void **state) {
    static const struct {
        uint32_t samples, width, outputs;
        const char *filter, *text;
    } rows[] = {
        {2, 8, 0, NULL, "1, 4, 9, 16, .. 1024"},       {8, 8, 0, "box", "1, 4, 9, 16, .. 1024"},
        {1025, 8, 0, NULL, "1, 4, 9, 16, .. 1024"},    {1089, 8, 0, NULL, "1, 4, 9, 16, .. 1024"},
        {UINT32_MAX, 8, 0, NULL, "1, 4, 9"},           {4, 40000, 0, NULL, "with 4 samples"},
        {1, 8, 0, "lanczos", "box, tent or gaussian"}, {4, 8, STRATA_OUTPUT_DEEP, NULL, "deep"},
    };
    (void)state;
    const strata_open_options open = {.struct_size = sizeof open, .backend = "null"};
    strata *s = NULL;
    assert_int_equal(strata_open(&open, &s), STRATA_OK);
    strata_scene *sc = picture_scene(s, "scene:layers?count=1");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        strata_render_options o = options_of(rows[i].width, 8, rows[i].samples, rows[i].filter);
        o.outputs = rows[i].outputs;
        assert_int_equal(strata_render(s, sc, &o), STRATA_ERROR_INVALID_ARGUMENT);
        if (!strstr(strata_error(s), rows[i].text))
            fail_msg("row %zu: %s", i, strata_error(s));
    }
    strata_scene_close(sc);
    strata_close(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_are_means_of_sub_pixels),
        cmocka_unit_test(even_stays_even),
        cmocka_unit_test(every_way_gives_the_same_bits),
        cmocka_unit_test(splats_keep_their_size),
        cmocka_unit_test(depth_is_the_nearest),
        cmocka_unit_test(bounds_are_filtered),
        cmocka_unit_test(a_fused_filter_gives_the_same_bits),
        cmocka_unit_test(an_opaque_scene_is_filtered_by_the_module),
        cmocka_unit_test(the_session_follows),
        cmocka_unit_test(senseless_options_are_refused),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
