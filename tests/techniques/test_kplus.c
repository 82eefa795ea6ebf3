/* SPDX-License-Identifier: MIT
 *
 * kplus keeps the nearest k: at every pixel, on every path and both
 * kplus_backends, the image is the fold of the first k samples of the deep image, bit for bit,
 * whatever the order of submission; what it drops is counted; its pool may be exactly full or short
 * by one.
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

static const char *const plain_backends[] = {"vulkan", "gl"};

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

static strata_render_options with(const kplus_variant *v, const char *settings[8], char number[32],
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
static void check_kept(strata *instance, strata_scene *sc, const deep_copy *d,
                       const kplus_variant *v, uint32_t k, uint32_t shuffle, uint32_t width,
                       uint32_t height, const char *name) {
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

static void check_case(const kept_case *c, const char *backend) {
    strata *instance = picture_instance(backend);
    char name[160];
    if (!instance)
        return;
    snprintf(name, sizeof name, "%s on %s", c->path, backend);
    strata_scene *sc = picture_scene(instance, c->path);
    deep_copy d = deep_of(backend, instance, sc, c->width, c->height);
    for (size_t v = 0; v < BASE_COUNT(kplus_variants); ++v)
        for (size_t k = 0; k < 8 && c->ks[k]; ++k)
            for (size_t s = 0; s < 4 && (s == 0 || c->shuffles[s]) &&
                               kplus_runs(instance, &kplus_variants[v], c->ks[k]);
                 ++s)
                check_kept(instance, sc, &d, &kplus_variants[v], c->ks[k], c->shuffles[s], c->width,
                           c->height, name);
    deep_free(&d);
    strata_scene_close(sc);
}

static void the_nearest_are_kept(void **state) {
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); ++i)
        for (size_t b = 0; b < 2; ++b)
            check_case(&cases[i], kplus_backends[b]);
}

static void long_pixels_keep_the_nearest(void **state) {
    static const char path[] = "scene:layers?count=20000&where=pixel&width=16&height=16";
    static const uint32_t ks[] = {8, 100};
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        strata *instance = picture_instance(kplus_backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, path);
        deep_copy d = deep_of(kplus_backends[b], instance, sc, 16, 16);
        for (size_t v = 0; v < BASE_COUNT(kplus_variants); ++v)
            for (size_t k = 0; k < 2; ++k)
                if (kplus_variants[v].cheap && kplus_runs(instance, &kplus_variants[v], ks[k]))
                    check_kept(instance, sc, &d, &kplus_variants[v], ks[k], 3, 16, 16, path);
        check_kept(instance, sc, &d, &(kplus_variant){.settings = {"kplus.memory=exact"}}, 16384, 0,
                   16, 16, path);
        check_kept(instance, sc, &d, &(kplus_variant){.settings = {"kplus.memory=exact"}}, 0, 0, 16,
                   16, path);
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
        strata *instance = picture_instance(kplus_backends[b]);
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
static void spoil_pool(strata *instance, strata_scene *sc, const deep_copy *d,
                       const kplus_variant *v, uint32_t k, const char *name) {
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
        strata *instance = picture_instance(kplus_backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, cases[0].path);
        deep_copy d = deep_of(kplus_backends[b], instance, sc, 24, 24);
        for (size_t v = 0; v < BASE_COUNT(kplus_variants); ++v)
            if (kplus_runs(instance, &kplus_variants[v], 6))
                spoil_pool(instance, sc, &d, &kplus_variants[v], 6, kplus_backends[b]);
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
        for (size_t v = 0; v < BASE_COUNT(kplus_variants); ++v) {
            const char *settings[8];
            char number[32];
            strata_render_options options = with(&kplus_variants[v], settings, number, 4);
            options.width = options.height = 8;
            const strata_result r = strata_render(instance, sc, &options);
            assert_int_equal(r, kplus_runs(instance, &kplus_variants[v], 4)
                                    ? STRATA_OK
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
    static const kplus_variant fixed = {.settings = {"kplus.exclusion=auto"}};
    static const kplus_variant exact = {.settings = {"kplus.memory=exact"}};
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
            const strata *whole = picture_instance(kplus_backends[b]);
            if (whole && (!lesser[i].claims || picture_fact(whole, "selftest.interlock")))
                check_lesser(plain_backends[b], &lesser[i]);
        }
}

int main(int argc, char **argv) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_nearest_are_kept),
        cmocka_unit_test(long_pixels_keep_the_nearest),
        cmocka_unit_test(what_is_learned_is_recorded_again),
        cmocka_unit_test(the_pool_is_full_or_short_by_one),
        cmocka_unit_test(what_a_device_lacks_is_refused),
        cmocka_unit_test(devices_with_less_keep_the_same),
    };
    const int failed = named_run("kplus", argc > 1 ? argv[1] : NULL, tests, BASE_COUNT(tests));
    picture_close();
    return failed;
}
