/* SPDX-License-Identifier: MIT
 *
 * fpc against the definition of its tree: folding the deep image's sorted samples in chunks of 64,
 * and these in nodes of 64, in float, gives its bits; folding them one by one in double stays
 * within the derived bound. Layouts, bands, orders of submission and backends give one image.
 */
#include "techniques/picture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"

#define FPC_CHUNK 64u
#define FRAGMENTS "fpc.mode=fragments"
#define HYBRID    "fpc.mode=hybrid"

static const char *const backends[] = {"vulkan", "gl"};

/* ---- one image for all ways ------------------------------------------------------------------ */

static void ways_of_a_scene(const test_scene *s) {
    static const way ways[] = {
        {.use = "abuffer,fpc", .settings = {FRAGMENTS}},
        {.use = "abuffer,fpc", .settings = {FRAGMENTS}, .bands = 7},
        {.use = "abuffer,fpc", .settings = {FRAGMENTS}, .shuffle = 5},
        {.use = "abuffer,fpc", .settings = {FRAGMENTS, "abuffer.mode=linked"}},
        {.use = "abuffer,fpc",
         .settings = {FRAGMENTS, "abuffer.mode=linked"},
         .bands = 7,
         .shuffle = 9},
        {.use = "abuffer,fpc"},
        {.use = "abuffer,fpc",
         .settings = {HYBRID, "abuffer.mode=linked"},
         .bands = 5,
         .shuffle = 3},
    };
    picture reference = {0};
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, s->path);
        for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
            char what[256];
            snprintf(what, sizeof what, "%s on %s, way %zu", s->path, backends[b], i);
            picture p = picture_render(sc, instance, &ways[i], s->width, s->height);
            if (reference.pixels)
                picture_same(&reference, &p, what);
            else
                reference = p;
            if (reference.pixels != p.pixels)
                picture_free(&p);
        }
        strata_scene_close(sc);
    }
    if (!reference.pixels)
        skip();
    picture_free(&reference);
}

static void every_way_gives_the_same_bits(void **state) {
    (void)state;
    for (size_t i = 0; i < picture_scene_count; ++i)
        ways_of_a_scene(&picture_scenes[i]);
}

/* ---- the tree, term by term ------------------------------------------------------------------ */

typedef struct node {
    float color[4], through;
} node;

static void step(node *walk, const node *next) {
    for (int c = 0; c < 4; ++c)
        walk->color[c] = walk->color[c] + walk->through * next->color[c];
    walk->through = walk->through * next->through;
}

/* Folds nodes in place, FPC_CHUNK of them into one, until one is left. */
static node fold_tree(node *nodes, size_t count) {
    if (count == 0)
        return (node){.through = 1};
    do {
        size_t out = 0;
        for (size_t i = 0; i < count; i += FPC_CHUNK) {
            node walk = {.through = 1};
            for (size_t k = i; k < count && k < i + FPC_CHUNK; ++k)
                step(&walk, &nodes[k]);
            nodes[out++] = walk;
        }
        count = out;
    } while (count > 1);
    return nodes[0];
}

static double gamma_of(double m) {
    const double mu = m * 0x1p-24;
    return mu / (1 - mu);
}

/* The exact colour of sorted samples, and what README.md derives for fpc's. */
static void fold_exact(const float *samples, size_t count, const float behind[4], double color[4],
                       double bound[4]) {
    double through = 1;
    size_t levels = 1;
    for (size_t n = (count + FPC_CHUNK - 1) / FPC_CHUNK; n > 1; n = (n + FPC_CHUNK - 1) / FPC_CHUNK)
        ++levels;
    for (int c = 0; c < 4; ++c)
        color[c] = bound[c] = 0;
    for (size_t i = 0; i <= count; ++i) {
        const float *sample = i < count ? samples + 4 * i : behind;
        const double m = 2.0 * (double)i + (double)(FPC_CHUNK * levels) + 2;
        for (int c = 0; c < 4; ++c) {
            color[c] += through * (double)sample[c];
            bound[c] += gamma_of(m) * through * fabs((double)sample[c]);
        }
        through *= 1.0 - (double)sample[3];
    }
}

static void check_pixel(const image_deep *deep, size_t pixel, const float *shown,
                        const char *what) {
    static const float background[4] = {0.2f, 0.2f, 0.2f, 1};
    const size_t count = deep->count[pixel];
    const float *samples = deep->color + 4 * deep->offset[pixel];
    node *nodes = calloc(count + 1, sizeof *nodes);
    double exact[4], bound[4];
    float expected[4];
    assert_non_null(nodes);
    for (size_t i = 0; i < count; ++i) {
        memcpy(nodes[i].color, samples + 4 * i, sizeof nodes[i].color);
        nodes[i].through = 1.0f - samples[4 * i + 3];
    }
    const node walk = fold_tree(nodes, count);
    fold_exact(samples, count, background, exact, bound);
    free(nodes);
    for (int c = 0; c < 4; ++c) {
        expected[c] = walk.color[c] + walk.through * background[c];
        if (!(fabs((double)shown[c] - exact[c]) <= bound[c]))
            fail_msg("%s: pixel %zu of %zu samples, channel %d: %a is %g off, bound %g", what,
                     pixel, count, c, (double)shown[c], fabs((double)shown[c] - exact[c]),
                     bound[c]);
    }
    if (memcmp(expected, shown, sizeof expected) != 0)
        fail_msg("%s: pixel %zu of %zu samples is not the fold of their tree", what, pixel, count);
}

/* Plain transparency without an opaque surface, whose samples carry no coverage of their own. */
static void check_tree(strata *instance, const char *path, const char *mode, const char *layout,
                       uint32_t size) {
    const char *const settings[] = {mode, layout};
    strata_scene *sc = picture_scene(instance, path);
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = size,
                                           .height = size,
                                           .use = "abuffer,fpc",
                                           .outputs = STRATA_OUTPUT_DEEP,
                                           .settings = settings,
                                           .setting_count = 2};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s: %s", path, strata_error(instance));
    const render_result *result = &instance->result;
    for (size_t i = 0; i < (size_t)size * size; ++i)
        check_pixel(&result->deep, i, result->color.pixels + 4 * i, path);
    strata_scene_close(sc);
}

/* Opacities are small, so that the last fragment counts; counts lie about the sizes of the tree. */
static void folds_are_those_of_the_tree(void **state) {
    static const struct {
        const char *path;
        uint32_t size;
    } cases[] = {
        {"scene:layers?count=63&alpha=0.02", 16},
        {"scene:layers?count=64&alpha=0.02", 16},
        {"scene:layers?count=65&alpha=0.02", 16},
        {"scene:layers?count=128&alpha=0.01", 16},
        {"scene:layers?count=129&alpha=0.01", 16},
        {"scene:layers?count=2048&alpha=0.001&where=pixel&width=16&height=16", 16},
        {"scene:layers?count=2049&alpha=0.001&where=pixel&width=16&height=16", 16},
        {"scene:layers?count=4096&alpha=0.0005&where=pixel&width=16&height=16", 16},
        {"scene:layers?count=4097&alpha=0.0005&where=pixel&width=16&height=16", 16},
        {"scene:layers?count=20000&alpha=0.0001&where=pixel&width=16&height=16", 16},
        {"scene:layers?count=100000&alpha=0.00002&where=pixel&width=16&height=16", 16},
        {"scene:soup?small=3000&medium=150&alpha=0.05", 64},
        {"scene:burst?mean=20&spread=0.6&width=32&height=32", 32},
        {"scene:burst?mean=20&spread=0.95&width=32&height=32", 32},
    };
    static const char *const modes[][2] = {{FRAGMENTS, "abuffer.mode=contiguous"},
                                           {FRAGMENTS, "abuffer.mode=linked"},
                                           {HYBRID, "abuffer.mode=contiguous"}};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        for (size_t m = 0; instance && m < 3; ++m)
            for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
                check_tree(instance, cases[i].path, modes[m][0], modes[m][1], cases[i].size);
    }
}

/* Coplanar stacks about the longest run that is mended, and far beyond it. */
static void equal_keys_are_sorted_by_order(void **state) {
    static const char *const counts[] = {"2", "31", "32", "33", "34", "100", "2000"};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        for (size_t i = 0; instance && i < sizeof counts / sizeof *counts; ++i) {
            char path[128];
            snprintf(path, sizeof path, "scene:stack?count=%s&alpha=0.01&merged=1", counts[i]);
            check_tree(instance, path, FRAGMENTS, "abuffer.mode=contiguous", 16);
            check_tree(instance, path, FRAGMENTS, "abuffer.mode=linked", 16);
            check_tree(instance, path, HYBRID, "abuffer.mode=contiguous", 16);
        }
    }
}

static void check_hybrid(strata_scene *sc, strata *instance, const char *setting,
                         const picture *expected) {
    const way w = {.use = "abuffer,fpc", .settings = {HYBRID, setting}};
    picture p = picture_render(sc, instance, &w, expected->width, expected->height);
    picture_same(expected, &p, setting);
    picture_free(&p);
}

/* A walk that ends early hides less than the threshold of what is behind, whose radiance is at most
 * 1 here. */
static void a_threshold_keeps_its_word(void **state) {
    static const char *const path = "scene:burst?mean=60&spread=0.4&alpha=0.03&width=16&height=16";
    static const char *const settings[] = {"fpc.threshold=0.001", "fpc.threshold=0.05",
                                           "fpc.threshold=0.9"};
    static const double thresholds[] = {0.001, 0.05, 0.9};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, path);
        const way all = {.use = "abuffer,fpc", .settings = {FRAGMENTS}};
        picture exact = picture_render(sc, instance, &all, 16, 16);
        for (size_t i = 0; i < 3; ++i) {
            const way w = {.use = "abuffer,fpc", .settings = {FRAGMENTS, settings[i]}};
            picture p = picture_render(sc, instance, &w, 16, 16);
            double largest = 0;
            for (size_t k = 0; k < 16 * 16 * 4; ++k)
                largest = fmax(largest, fabs((double)p.pixels[k] - (double)exact.pixels[k]));
            assert_true(largest > 0);
            assert_true(largest <= thresholds[i]);
            check_hybrid(sc, instance, settings[i], &p);
            picture_free(&p);
        }
        picture_free(&exact);
        strata_scene_close(sc);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_gives_the_same_bits),
        cmocka_unit_test(folds_are_those_of_the_tree),
        cmocka_unit_test(equal_keys_are_sorted_by_order),
        cmocka_unit_test(a_threshold_keeps_its_word),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
