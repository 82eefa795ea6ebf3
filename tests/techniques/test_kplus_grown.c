/* SPDX-License-Identifier: MIT
 *
 * kplus with k per pixel: under a tolerance each pixel keeps as many as it needs, on every path and
 * both kplus_backends; the image is the fold of so many of the deep image, bit for bit, and
 * certified.
 */
#define _GNU_SOURCE

#include "techniques/deep.h"
#include "techniques/kplus_variants.h"
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "named.h"
#include "render/render.h"

/* Under a tolerance each pixel keeps a number of its own, up to k. */
typedef struct grown_case {
    const char *path;
    uint32_t width, height;
    const char *k, *begin;
    double tolerance;
    uint32_t own;      /* 1: pixels differ in what they keep */
    uint32_t coloured; /* 1: fold_nearest knows nothing of it */
} grown_case;

/* 16 is the most that every path takes; there the tolerance may be missed. */
static const grown_case grown_cases[] = {
    {"scene:soup?small=1500&medium=80", 48, 48, "kplus.k=16", "kplus.begin=2", 0.02, 1, 0},
    {"scene:soup?small=1500&medium=80", 48, 48, "kplus.k=500", "kplus.begin=5", 0.003, 1, 0},
    {"scene:shells?count=40&subdivision=1&transmission=0.6&core=0", 24, 24, "kplus.k=60",
     "kplus.begin=1", 0.05, 0, 1},
    {"scene:stack?count=40&alpha=0.1", 24, 24, "kplus.k=16", "kplus.begin=6", 0.2, 0, 0}, /* ties */
};

static strata_render_options growing(const grown_case *c, const kplus_variant *v,
                                     const char *settings[8]) {
    strata_render_options options = {.struct_size = sizeof options,
                                     .width = c->width,
                                     .height = c->height,
                                     .use = "kplus,ppc",
                                     .settings = settings,
                                     .tolerance = c->tolerance};
    settings[options.setting_count++] = c->k;
    settings[options.setting_count++] = c->begin;
    settings[options.setting_count++] = "kplus.payload=float";
    for (size_t i = 0; i < 4 && v->settings[i]; ++i)
        settings[options.setting_count++] = v->settings[i];
    return options;
}

/* Of a frame in one band. */
static uint32_t *kept_of(const strata *instance, size_t pixels) {
    base_error err = {0};
    uint32_t(*ranges)[2] = malloc(pixels * sizeof *ranges), *kept = malloc(pixels * sizeof *kept);
    assert_true(ranges && kept && instance->result.bands == 1);
    assert_int_equal(gpu_buffer_read(instance->gpu, instance->session->fragments.ranges, 0,
                                     pixels * sizeof *ranges, ranges, &err),
                     STRATA_OK);
    for (size_t i = 0; i < pixels; ++i)
        kept[i] = ranges[i][1];
    free(ranges);
    return kept;
}

/* How many fragments each pixel kept; each is the fold of so many of its nearest. */
static uint32_t *check_grown(strata *instance, strata_scene *sc, const deep_copy *d,
                             const strata_render_options *options, int coloured, const char *what) {
    const strata_result r = strata_render(instance, sc, options);
    const float *bound = instance->result.bound.map.pixels;
    uint64_t sum = 0, more = 0;
    if (r != STRATA_OK && r != STRATA_PARTIAL)
        fail_msg("%s: %s", what, strata_error(instance));
    uint32_t *kept = kept_of(instance, d->pixels);
    const uint32_t most = (uint32_t)atoi(strchr(options->settings[0], '=') + 1);
    for (size_t i = 0; i < d->pixels; ++i) {
        float expected[4];
        sum += kept[i];
        fold_nearest(d, i, kept[i] ? kept[i] : 1, expected);
        if (!coloured &&
            memcmp(expected, instance->result.color.pixels + 4 * i, sizeof expected) != 0)
            fail_msg("%s: pixel %zu is not the fold of its %u nearest of %u", what, i, kept[i],
                     d->count[i]);
        const uint32_t full = d->count[i] < most ? d->count[i] : most;
        assert_in_range(kept[i], 0, full);
        for (size_t c = 0; c < 4 && kept[i] < full; ++c)
            if (!((double)bound[4 * i + c] <= options->tolerance))
                fail_msg("%s: pixel %zu keeps %u of %u and is certified for %g only", what, i,
                         kept[i], d->count[i], (double)bound[4 * i + c]);
        more += kept[i] < d->count[i];
    }
    assert_int_equal(instance->result.report.kept, sum);
    assert_true(more > 0);
    return kept;
}

static float worst_of(const float *bound) {
    float worst = 0;
    for (size_t c = 0; c < 4; ++c)
        worst = bound[c] > worst ? bound[c] : worst;
    return worst;
}

/* Against all pixels with the same k: the bits are those of the k that a pixel has, and it would
 * not have grown to so many had half of them sufficed. */
static void check_uniform(strata *instance, strata_scene *sc, const grown_case *c,
                          const uint32_t *kept, uint32_t begin, const float *grown) {
    uint32_t most = 0;
    for (size_t i = 0; i < (size_t)c->width * c->height; ++i)
        most = kept[i] > most ? kept[i] : most;
    for (uint32_t k = 1; k <= most; ++k) {
        char number[32];
        const char *const settings[] = {number};
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = c->width,
                                               .height = c->height,
                                               .use = "kplus,ppc",
                                               .settings = settings,
                                               .setting_count = 1,
                                               .outputs = STRATA_OUTPUT_BOUND};
        snprintf(number, sizeof number, "kplus.k=%u", k);
        assert_int_equal(strata_render(instance, sc, &options), STRATA_OK);
        const render_result *result = &instance->result;
        for (size_t i = 0; i < (size_t)c->width * c->height; ++i) {
            if (kept[i] == k)
                assert_memory_equal(grown + 4 * i, result->color.pixels + 4 * i, 16);
            if (kept[i] > begin && (kept[i] + 1) / 2 == k && /* 15/16, and what rounds */
                !((double)worst_of(result->bound.map.pixels + 4 * i) > 0.93 * c->tolerance))
                fail_msg("%s: pixel %zu grew to %u and %u suffice", c->path, i, kept[i], k);
        }
    }
}

/* Pixels beside each other keep different numbers; of those that keep the same number, some have
 * exactly so many fragments and some have one more. */
static void check_own(const grown_case *c, const deep_copy *d, const uint32_t *kept) {
    uint32_t differ = 0, exact[64] = {0}, over[64] = {0}, both = 0;
    for (size_t i = 0; i < d->pixels; ++i) {
        differ += (i + 1) % c->width != 0 && kept[i] != kept[i + 1] && kept[i] < d->count[i] &&
                  kept[i + 1] < d->count[i + 1];
        if (kept[i] < 64) {
            exact[kept[i]] |= d->count[i] == kept[i];
            over[kept[i]] |= d->count[i] == kept[i] + 1;
        }
    }
    for (size_t k = 1; k < 64; ++k)
        both += exact[k] && over[k];
    if (c->own && (differ < 10 || both < 2))
        fail_msg("%s: %u neighbours differ, %u numbers meet k and k + 1 fragments", c->path, differ,
                 both);
}

/* What the first way left: all others must leave the same. */
typedef struct grown_frame {
    uint32_t *kept;
    float *color;
    uint64_t sum;
} grown_frame;

static void grow_way(strata *instance, strata_scene *sc, const grown_case *c, const deep_copy *d,
                     const kplus_variant *v, grown_frame *first) {
    static const uint32_t orders[] = {0, 3};
    const char *settings[8];
    char what[160];
    strata_render_options options = growing(c, v, settings);
    for (size_t o = 0; o < BASE_COUNT(orders); ++o) {
        options.shuffle = orders[o];
        snprintf(what, sizeof what, "%s, %s %s, shuffle %u", c->path, v->settings[0],
                 v->settings[1] ? v->settings[1] : "", options.shuffle);
        uint32_t *kept = check_grown(instance, sc, d, &options, (int)c->coloured, what);
        if (first->kept) {
            if (memcmp(first->kept, kept, d->pixels * sizeof *kept) != 0)
                fail_msg("%s: pixels keep other numbers", what);
            free(kept);
            continue;
        }
        *first = (grown_frame){
            .kept = kept, .color = malloc(d->pixels * 16), .sum = instance->result.report.kept};
        assert_non_null(first->color);
        memcpy(first->color, instance->result.color.pixels, d->pixels * 16);
    }
    if (v != kplus_variants)
        return;
    options.bands = 3;
    const strata_result r = strata_render(instance, sc, &options);
    assert_true(r == STRATA_OK || r == STRATA_PARTIAL);
    assert_int_equal(instance->result.report.kept, first->sum);
    assert_memory_equal(first->color, instance->result.color.pixels, d->pixels * 16);
}

static void grow_case(const grown_case *c, const char *backend) {
    strata *instance = picture_instance(backend);
    grown_frame first = {0};
    if (!instance)
        return;
    strata_scene *sc = picture_scene(instance, c->path);
    deep_copy d = deep_of(backend, instance, sc, c->width, c->height);
    const uint32_t k = (uint32_t)atoi(strchr(c->k, '=') + 1);
    for (size_t v = 0; v < BASE_COUNT(kplus_variants); ++v)
        if (kplus_runs(instance, &kplus_variants[v], k) && (k <= 16 || kplus_variants[v].cheap))
            grow_way(instance, sc, c, &d, &kplus_variants[v], &first);
    check_own(c, &d, first.kept);
    check_uniform(instance, sc, c, first.kept, (uint32_t)atoi(strchr(c->begin, '=') + 1),
                  first.color);
    free(first.kept);
    free(first.color);
    deep_free(&d);
    strata_scene_close(sc);
}

static void pixels_keep_what_they_need(void **state) {
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(grown_cases); ++i)
        for (size_t b = 0; b < 2; ++b)
            grow_case(&grown_cases[i], kplus_backends[b]);
}

/* From 4 to some thousands, in one pixel of 20,000. What was found stays while the view does, and
 * says nothing about another one. */
static void one_pixel_grows(void **state) {
    static const grown_case c = {
        .path = "scene:layers?count=20000&where=pixel&width=16&height=16&alpha=0.001",
        .width = 16,
        .height = 16,
        .k = "kplus.k=16384",
        .begin = "kplus.begin=4",
        .tolerance = 0.05};
    const char *settings[8];
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(kplus_backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, c.path);
        deep_copy d = deep_of(kplus_backends[b], instance, sc, c.width, c.height);
        strata_render_options options = growing(&c, &kplus_variants[0], settings);
        uint32_t *kept = check_grown(instance, sc, &d, &options, 0, c.path);
        assert_true(instance->result.retries >= 9);
        const uint64_t sum = instance->result.report.kept;
        assert_in_range(sum, 2000, 6000);
        free(kept);
        free(check_grown(instance, sc, &d, &options, 0, c.path));
        assert_int_equal(instance->result.retries, 0);
        options.background[0] = 0.201f; /* another background, another bound */
        options.background[1] = options.background[2] = 0.2f;
        options.background[3] = 1;
        options.has_background = 1;
        assert_int_equal(strata_render(instance, sc, &options), STRATA_OK);
        assert_true(instance->result.retries >= 9);
        options.has_background = 0;
        free(check_grown(instance, sc, &d, &options, 0, c.path));
        assert_int_equal(instance->result.report.kept, sum);
        deep_free(&d);
        strata_scene_close(sc);
    }
}

/* Where the user leaves k and begin open every path takes what the plan sets them to; ordered holds
 * 16, and what is planned for soup is more. */
static void a_tolerance_is_enough_to_ask_for(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(kplus_backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, grown_cases[0].path);
        for (size_t v = 0; v < BASE_COUNT(kplus_variants); ++v) {
            const kplus_variant *taken = &kplus_variants[v];
            strata_render_options options = {.struct_size = sizeof options,
                                             .width = 48,
                                             .height = 48,
                                             .use = "kplus,ppc",
                                             .settings = taken->settings,
                                             .tolerance = 0.02};
            while (options.setting_count < 4 && taken->settings[options.setting_count])
                ++options.setting_count;
            if (!kplus_runs(instance, taken, 1))
                continue;
            const strata_result r = strata_render(instance, sc, &options);
            if (r != STRATA_OK && !(r == STRATA_PARTIAL && taken->k_most > 0))
                fail_msg("%s, %s: %s", kplus_backends[b], taken->settings[0],
                         strata_error(instance));
            assert_true(r != STRATA_OK || instance->result.bound.max <= 0.02);
        }
        strata_scene_close(sc);
    }
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pixels_keep_what_they_need),
        cmocka_unit_test(one_pixel_grows),
        cmocka_unit_test(a_tolerance_is_enough_to_ask_for),
    };
    const int failed =
        named_run("kplus, k per pixel", argc > 1 ? argv[1] : NULL, tests, BASE_COUNT(tests));
    picture_close();
    return failed;
}
