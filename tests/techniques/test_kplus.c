/* SPDX-License-Identifier: MIT
 *
 * kplus keeps the nearest k, or as many as each pixel needs: at every pixel, on every path and both
 * backends, the image is the fold of the first k samples of the deep image, bit for bit, whatever
 * the order of submission; what it drops is counted; its pool may be exactly full or short by one.
 */
#define _GNU_SOURCE

#include "techniques/deep.h"
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "named.h"
#include "render/render.h"

/* With an interlock, as far as picture_fact counts it. */
static const char *const backends[] = {"vulkan claims:selftest.interlock",
                                       "gl claims:selftest.interlock"};
static const char *const plain_backends[] = {"vulkan", "gl"};

/* Every path: how fragments are kept apart, the structure, the memory. */
typedef struct variant {
    const char *settings[4];
    const char *fact; /* that it needs of the device */
    uint32_t cheap;   /* 1: also where a pixel has very many layers */
    uint32_t k_most;  /* the largest k that it takes; 0 = any */
} variant;

static const variant variants[] = {
    {.settings = {"kplus.exclusion=auto"}, .cheap = 1},
    {.settings = {"kplus.exclusion=unlocked", "kplus.structure=array"},
     .fact = "selftest.ordered_rmw",
     .cheap = 1},
    {.settings = {"kplus.exclusion=unlocked", "kplus.structure=heap"},
     .fact = "selftest.ordered_rmw",
     .cheap = 1},
    {.settings = {"kplus.exclusion=unlocked", "kplus.structure=heap", "kplus.memory=exact"},
     .fact = "selftest.ordered_rmw",
     .cheap = 1},
    {.settings = {"kplus.exclusion=interlock", "kplus.structure=array"},
     .fact = "selftest.interlock",
     .cheap = 1},
    {.settings = {"kplus.exclusion=interlock", "kplus.structure=heap", "kplus.memory=exact"},
     .fact = "selftest.interlock",
     .cheap = 1},
    {.settings = {"kplus.exclusion=ordered"},
     .fact = "ordered_attachments",
     .cheap = 1,
     .k_most = 16},
    {.settings = {"kplus.exclusion=ordered", "kplus.memory=exact"},
     .fact = "ordered_attachments",
     .cheap = 1,
     .k_most = 16},
    {.settings = {"kplus.exclusion=lock", "kplus.structure=array"}, .cheap = 1},
    {.settings = {"kplus.exclusion=lock", "kplus.structure=heap", "kplus.memory=exact"},
     .cheap = 1},
    {.settings = {"kplus.exclusion=lock", "kplus.tries=0"}},
    {.settings = {"kplus.exclusion=atomic32"}, .cheap = 1},
    {.settings = {"kplus.exclusion=atomic32", "kplus.memory=exact"}},
    {.settings = {"kplus.exclusion=atomic64"}, .fact = "feature.int64_atomics", .cheap = 1},
    {.settings = {"kplus.exclusion=atomic64", "kplus.memory=exact"},
     .fact = "feature.int64_atomics"},
};

/* Transparent surfaces alone, so that samples fold onto the background. */
typedef struct kept_case {
    const char *path;
    uint32_t width, height;
    uint32_t ks[8]; /* up to the first 0 */
    uint32_t shuffles[4];
} kept_case;

static const kept_case cases[] = {
    {"scene:soup?small=1500&medium=80", 47, 45, {1, 2, 7, 15, 16, 17, 40}, {0, 11}},
    {"scene:layers?count=17", 16, 16, {15, 16, 17, 18}, {0, 5}},
    {"scene:layers?count=9", 16, 16, {8, 9, 10}, {0}},
    {"scene:stack?count=40", 24, 24, {1, 3, 17, 39, 40, 41}, {0, 2, 3}},
    {"scene:stack?count=40&tilt=50&shift=0.05", 24, 24, {7, 20}, {0, 6}}, /* nearly equal depths */
    {"scene:stack?count=100&split=1", 24, 24, {16, 33}, {4, 5}},
};

/* ---- renders --------------------------------------------------------------------------------- */

static strata_render_options with(const variant *v, const char *settings[8], char number[32],
                                  uint32_t k) {
    strata_render_options options = {.struct_size = sizeof options, .use = "kplus,ppc"};
    snprintf(number, 32, "kplus.k=%u", k);
    settings[options.setting_count++] = number;
    for (size_t i = 0; i < 4 && v->settings[i]; ++i)
        settings[options.setting_count++] = v->settings[i];
    options.settings = settings;
    return options;
}

/* One render against the fold of the nearest k. */
static void check_kept(strata *instance, strata_scene *sc, const deep_copy *d, const variant *v,
                       uint32_t k, uint32_t shuffle, uint32_t width, uint32_t height,
                       const char *name) {
    const char *settings[8];
    char number[32], what[256];
    strata_render_options options = with(v, settings, number, k);
    options.width = width;
    options.height = height;
    options.shuffle = shuffle;
    snprintf(what, sizeof what, "%s, k %u, %s %s %s, shuffle %u", name, k, v->settings[0],
             v->settings[1] ? v->settings[1] : "",
             v->settings[1] && v->settings[2] ? v->settings[2] : "", shuffle);
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s: %s", what, strata_error(instance));
    for (size_t i = 0; i < d->pixels; ++i) {
        float expected[4];
        fold_nearest(d, i, k, expected);
        if (memcmp(expected, instance->result.color.pixels + 4 * i, sizeof expected) != 0)
            fail_msg("%s: pixel %zu of %u samples is not the fold of its nearest", what, i,
                     d->count[i]);
    }
    deep_check_report(instance, d, k, what);
}

static int runs(const strata *instance, const variant *v, uint32_t k) {
    return (!v->fact || picture_fact(instance, v->fact)) && (v->k_most == 0 || k <= v->k_most);
}

static void check_case(const kept_case *c, const char *backend) {
    strata *instance = picture_instance(backend);
    char name[160];
    if (!instance)
        return;
    snprintf(name, sizeof name, "%s on %s", c->path, backend);
    strata_scene *sc = picture_scene(instance, c->path);
    deep_copy d = deep_of(backend, instance, sc, c->width, c->height);
    for (size_t v = 0; v < BASE_COUNT(variants); ++v)
        for (size_t k = 0; k < 8 && c->ks[k]; ++k)
            for (size_t s = 0;
                 s < 4 && (s == 0 || c->shuffles[s]) && runs(instance, &variants[v], c->ks[k]); ++s)
                check_kept(instance, sc, &d, &variants[v], c->ks[k], c->shuffles[s], c->width,
                           c->height, name);
    deep_free(&d);
    strata_scene_close(sc);
}

static void the_nearest_are_kept(void **state) {
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); ++i)
        for (size_t b = 0; b < 2; ++b)
            check_case(&cases[i], backends[b]);
}

static void long_pixels_keep_the_nearest(void **state) {
    static const char path[] = "scene:layers?count=20000&where=pixel&width=16&height=16";
    static const uint32_t ks[] = {8, 100};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, path);
        deep_copy d = deep_of(backends[b], instance, sc, 16, 16);
        for (size_t v = 0; v < BASE_COUNT(variants); ++v)
            for (size_t k = 0; k < 2; ++k)
                if (variants[v].cheap && runs(instance, &variants[v], ks[k]))
                    check_kept(instance, sc, &d, &variants[v], ks[k], 3, 16, 16, path);
        check_kept(instance, sc, &d, &(variant){.settings = {"kplus.memory=exact"}}, 16384, 0, 16,
                   16, path);
        check_kept(instance, sc, &d, &(variant){.settings = {"kplus.memory=exact"}}, 0, 0, 16, 16,
                   path);
        deep_free(&d);
        strata_scene_close(sc);
    }
}

/* ---- a lock that is given up, ties that are seen --------------------------------------------- */

static uint32_t retries(strata *instance, strata_scene *sc, const char *exclusion,
                        const char *tries) {
    const char *const settings[] = {"kplus.k=4", exclusion, tries};
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = 24,
                                           .height = 24,
                                           .use = "kplus,ppc",
                                           .settings = settings,
                                           .setting_count = 3};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s %s: %s", exclusion, tries, strata_error(instance));
    const uint32_t first = instance->result.retries;
    assert_int_equal(strata_render(instance, sc, &options), STRATA_OK);
    assert_int_equal(instance->result.retries, 0); /* it was learned */
    return first;
}

/* What ppc learns of a scene costs retries too: those of a path that never repeats are the least.
 */
static void what_is_learned_is_recorded_again(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, "scene:layers?count=12");
        const uint32_t plain = retries(instance, sc, "kplus.exclusion=lock", "kplus.tries=4096");
        assert_int_equal(retries(instance, sc, "kplus.exclusion=lock", "kplus.tries=0"), plain + 1);
        assert_int_equal(retries(instance, sc, "kplus.exclusion=atomic32", "kplus.tries=1"), plain);
        strata_scene_close(sc);
    }
}

/* ---- the pool -------------------------------------------------------------------------------- */

static strata_pool pool_of(const strata *instance) {
    for (uint32_t i = 0; i < instance->session->technique_count; ++i)
        if (strcmp(instance->session->techniques[i].planned->technique->id, "kplus") == 0)
            return instance->session->techniques[i].pools[0];
    fail_msg("kplus does not run");
    return (strata_pool){0};
}

/* Exactly full is enough; one record less is found out. */
static void spoil_pool(strata *instance, strata_scene *sc, const deep_copy *d, const variant *v,
                       uint32_t k, const char *name) {
    check_kept(instance, sc, d, v, k, 0, 24, 24, name);
    for (uint64_t less = 0; less < 2; ++less) {
        base_error err = {0};
        uint64_t needed = 0;
        const strata_pool pool = pool_of(instance);
        assert_int_equal(gpu_pool_needed(instance->gpu, pool, &needed, &err), STRATA_OK);
        assert_int_equal(gpu_pool_grow(instance->gpu, pool, needed - less, &err), STRATA_OK);
        check_kept(instance, sc, d, v, k, 0, 24, 24, name);
        assert_int_equal(instance->result.retries, less);
    }
}

static void the_pool_is_full_or_short_by_one(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, cases[0].path);
        deep_copy d = deep_of(backends[b], instance, sc, 24, 24);
        for (size_t v = 0; v < BASE_COUNT(variants); ++v)
            if (runs(instance, &variants[v], 6))
                spoil_pool(instance, sc, &d, &variants[v], 6, backends[b]);
        deep_free(&d);
        strata_scene_close(sc);
    }
}

/* ---- k per pixel ----------------------------------------------------------------------------- */

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

static strata_render_options growing(const grown_case *c, const variant *v,
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
                     const variant *v, grown_frame *first) {
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
    if (v != variants)
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
    for (size_t v = 0; v < BASE_COUNT(variants); ++v)
        if (runs(instance, &variants[v], k) && (k <= 16 || variants[v].cheap))
            grow_way(instance, sc, c, &d, &variants[v], &first);
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
            grow_case(&grown_cases[i], backends[b]);
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
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, c.path);
        deep_copy d = deep_of(backends[b], instance, sc, c.width, c.height);
        strata_render_options options = growing(&c, &variants[0], settings);
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

/* ---- what a device cannot do is refused ------------------------------------------------------ */

static void what_a_device_lacks_is_refused(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(plain_backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, cases[1].path);
        for (size_t v = 0; v < BASE_COUNT(variants); ++v) {
            const char *settings[8];
            char number[32];
            strata_render_options options = with(&variants[v], settings, number, 4);
            options.width = options.height = 8;
            const strata_result r = strata_render(instance, sc, &options);
            assert_int_equal(r, runs(instance, &variants[v], 4) ? STRATA_OK
                                                                : STRATA_ERROR_UNSUPPORTED);
        }
        strata_scene_close(sc);
    }
}

/* What `auto` takes on devices without what it takes first here: the same pixels. */
typedef struct lesser_device {
    const char *inject, *path; /* the label of a pass that only this path has */
    uint32_t claims;
} lesser_device;

static const lesser_device lesser[] = {
    {"lacks:selftest.ordered_rmw,claims:selftest.interlock", "store", 1},
    {"lacks:selftest.ordered_rmw", "gather", 0},
    {"lacks:ordered_attachments", "store", 0},
    {"lacks:feature.int64_atomics", "store", 0},
    {"lacks:device.software", "store", 0},
    {"lacks:selftest.ordered_rmw,lacks:ordered_attachments", "chain", 0},
};

static int passed(const strata *s, const char *label) {
    uint32_t count = 0;
    const gpu_timing *timings = gpu_timings(s->gpu, &count);
    for (uint32_t i = 0; i < count; ++i)
        if (strcmp(timings[i].owner, "kplus") == 0 && strcmp(timings[i].label, label) == 0)
            return 1;
    return 0;
}

static void check_lesser(const char *backend, const lesser_device *device) {
    static const variant fixed = {.settings = {"kplus.exclusion=auto"}};
    static const variant exact = {.settings = {"kplus.memory=exact"}};
    const strata_open_options open = {
        .struct_size = sizeof open, .check = 1, .backend = backend, .inject = device->inject};
    strata *s = NULL;
    assert_int_equal(strata_open(&open, &s), STRATA_OK);
    strata_scene *sc = picture_scene(s, cases[0].path);
    deep_copy d = deep_of(backend, s, sc, 32, 32);
    for (uint32_t k = 5; k < 20; k += 11) {
        check_kept(s, sc, &d, &fixed, k, 0, 32, 32, device->inject);
        assert_true(passed(s, device->path));
        check_kept(s, sc, &d, &exact, k, 7, 32, 32, device->inject);
    }
    deep_free(&d);
    strata_scene_close(sc);
    strata_close(s);
}

static void devices_with_less_keep_the_same(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b)
        for (size_t i = 0; i < BASE_COUNT(lesser); ++i) {
            const strata *whole = picture_instance(backends[b]);
            if (whole && (!lesser[i].claims || picture_fact(whole, "selftest.interlock")))
                check_lesser(plain_backends[b], &lesser[i]);
        }
}

/* Where the user leaves k and begin open every path takes what the plan sets them to; ordered holds
 * 16, and what is planned for soup is more. */
static void a_tolerance_is_enough_to_ask_for(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, grown_cases[0].path);
        for (size_t v = 0; v < BASE_COUNT(variants); ++v) {
            const variant *taken = &variants[v];
            strata_render_options options = {.struct_size = sizeof options,
                                             .width = 48,
                                             .height = 48,
                                             .use = "kplus,ppc",
                                             .settings = taken->settings,
                                             .tolerance = 0.02};
            while (options.setting_count < 4 && taken->settings[options.setting_count])
                ++options.setting_count;
            if (!runs(instance, taken, 1))
                continue;
            const strata_result r = strata_render(instance, sc, &options);
            if (r != STRATA_OK && !(r == STRATA_PARTIAL && taken->k_most > 0))
                fail_msg("%s, %s: %s", backends[b], taken->settings[0], strata_error(instance));
            assert_true(r != STRATA_OK || instance->result.bound.max <= 0.02);
        }
        strata_scene_close(sc);
    }
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_nearest_are_kept),
        cmocka_unit_test(long_pixels_keep_the_nearest),
        cmocka_unit_test(what_is_learned_is_recorded_again),
        cmocka_unit_test(the_pool_is_full_or_short_by_one),
        cmocka_unit_test(pixels_keep_what_they_need),
        cmocka_unit_test(one_pixel_grows),
        cmocka_unit_test(a_tolerance_is_enough_to_ask_for),
        cmocka_unit_test(what_a_device_lacks_is_refused),
        cmocka_unit_test(devices_with_less_keep_the_same),
    };
    const int failed = named_run("kplus", argc > 1 ? argv[1] : NULL, tests, BASE_COUNT(tests));
    picture_close();
    return failed;
}
