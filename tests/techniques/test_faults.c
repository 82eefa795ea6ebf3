/* SPDX-License-Identifier: MIT
 *
 * Faults, injected one at a time through the public interface: every creation on the device fails
 * once, the device is lost at every submit once, memory is short. What can still be rendered is, to
 * the same bits; all else ends with one line, and the instance renders again afterwards.
 */
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/gpu_internal.h"
#include "render/render.h"

#define SCENE  "scene:soup?small=400&medium=30"
#define WIDTH  48u
#define HEIGHT 40u

static const char *const backends[] = {"vulkan", "gl"};

static strata *open_with(const char *backend, const char *inject, uint64_t memory) {
    const strata_open_options options = {.struct_size = sizeof options,
                                         .backend = backend,
                                         .inject = inject,
                                         .memory = memory,
                                         .check = 1};
    strata *s = NULL;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    return s;
}

static strata_scene *load(strata *s, const char *path) {
    strata_scene *sc = NULL;
    if (strata_scene_load(s, path, &sc) != STRATA_OK)
        fail_msg("%s: %s", path, strata_error(s));
    return sc;
}

static const char *used_mode; /* of abuffer, for render; NULL: the plan's own choice */

static strata_result render(strata *s, strata_scene *sc) {
    return strata_render(s, sc,
                         &(strata_render_options){.struct_size = sizeof(strata_render_options),
                                                  .width = WIDTH,
                                                  .height = HEIGHT,
                                                  .use = used_mode ? "abuffer,ppc" : NULL,
                                                  .settings = &used_mode,
                                                  .setting_count = used_mode != NULL,
                                                  .repeat = 2});
}

/* A failure is one line, and not an empty one. */
static void one_line(const strata *s, strata_result r, const char *what) {
    const char *line = strata_error(s);
    if (r >= 0 || !line[0] || strchr(line, '\n'))
        fail_msg("%s: result %d with the line '%s'", what, (int)r, line);
}

static picture taken(strata *s) {
    picture p = {
        .width = WIDTH, .height = HEIGHT, .pixels = malloc(sizeof(float[4]) * WIDTH * HEIGHT)};
    assert_non_null(p.pixels);
    assert_int_equal(
        strata_read(s, STRATA_OUTPUT_COLOR, p.pixels, sizeof(float[4]) * WIDTH * HEIGHT),
        STRATA_OK);
    return p;
}

static void same_picture(strata *s, const picture *expected, const char *what) {
    picture p = taken(s);
    picture_same(expected, &p, what);
    picture_free(&p);
}

/* The picture that nothing disturbed. */
static picture undisturbed(const char *backend) {
    strata *s = open_with(backend, NULL, 0);
    strata_scene *sc = load(s, SCENE);
    if (render(s, sc) != STRATA_OK)
        fail_msg("%s: %s", backend, strata_error(s));
    picture p = taken(s);
    strata_close(s);
    return p;
}

/* ---- creations ------------------------------------------------------------------------------- */

/* The N-th creation fails. Returns 0 when there are fewer. */
static int without_allocation(const char *backend, unsigned n, const picture *expected,
                              unsigned *survived) {
    char inject[32], what[64];
    snprintf(inject, sizeof inject, "allocation:%u", n);
    snprintf(what, sizeof what, "%s without creation %u", backend, n);
    strata *s = open_with(backend, inject, 0);
    strata_scene *sc = load(s, SCENE);
    strata_result r = render(s, sc);
    const int reached = !s->gpu || s->gpu->creations >= n;
    if (r != STRATA_OK)
        one_line(s, r, what);
    else
        same_picture(s, expected, what);
    *survived += reached && r == STRATA_OK;
    if (render(s, sc) != STRATA_OK) /* the fault has passed */
        fail_msg("%s: then %s", what, strata_error(s));
    same_picture(s, expected, what);
    strata_close(s);
    return reached;
}

static void every_creation_fails_once(const char *backend, unsigned step) {
    picture expected = undisturbed(backend);
    unsigned n = 1, survived = 0;
    while (without_allocation(backend, n, &expected, &survived))
        n += step;
    print_message("%s: %u creations, of which every %u. failed; %u renders survived\n", backend, n,
                  step, survived);
    assert_true(n > 20);
    assert_true(survived > 0);
    picture_free(&expected);
}

static void creations_fail_on_no_device(void **state) {
    (void)state;
    every_creation_fails_once("null", 1);
}

static void creations_fail_on_devices(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b)
        if (picture_instance(backends[b]))
            every_creation_fails_once(backends[b], 5);
}

/* ---- a lost device --------------------------------------------------------------------------- */

static int without_device(const char *backend, unsigned n, const picture *expected) {
    char inject[32], what[64];
    snprintf(inject, sizeof inject, "lost:%u", n);
    snprintf(what, sizeof what, "%s lost at submit %u", backend, n);
    strata *s = open_with(backend, inject, 0);
    strata_scene *sc = load(s, SCENE);
    if (render(s, sc) != STRATA_OK)
        fail_msg("%s: %s", what, strata_error(s));
    const int reached = s->losses > 0;
    assert_int_equal(s->result.warning_count, reached);
    assert_int_equal(s->exclusion_count, 0);
    same_picture(s, expected, what);
    strata_close(s);
    return reached;
}

static void a_lost_device_is_replaced(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        if (!picture_instance(backends[b]))
            continue;
        picture expected = undisturbed(backends[b]);
        unsigned n = 1;
        while (without_device(backends[b], n, &expected))
            ++n;
        print_message("%s: lost at each of %u submits\n", backends[b], n - 1);
        assert_true(n > 4); /* two frames, each with an opaque part and a band */
        picture_free(&expected);
    }
}

/* ---- memory ---------------------------------------------------------------------------------- */

/* Halves the memory until not one pixel's techniques fit. */
static void less_and_less_memory(const char *backend) {
    picture expected = undisturbed(backend);
    unsigned banded = 0, refused = 0;
    for (uint64_t memory = UINT64_C(1) << 21; memory > 0; memory /= 2) {
        char what[64];
        snprintf(what, sizeof what, "%s in %llu bytes", backend, (unsigned long long)memory);
        strata *s = open_with(backend, NULL, memory);
        strata_scene *sc = load(s, SCENE);
        strata_result r = render(s, sc);
        if (r == STRATA_OK) {
            assert_int_equal(refused, 0); /* less was enough before */
            const uint64_t used =
                gpu_bytes(s->gpu, NULL) - gpu_bytes(s->gpu, "scene") - gpu_bytes(s->gpu, "host");
            if (used > memory)
                fail_msg("%s: %llu are used", what, (unsigned long long)used);
            same_picture(s, &expected, what);
            banded += s->result.bands > 1;
        } else {
            one_line(s, r, what);
            assert_int_equal(r, STRATA_ERROR_OUT_OF_DEVICE_MEMORY);
            ++refused;
        }
        strata_close(s);
    }
    print_message("%s: %u times in bands, %u times refused\n", backend, banded, refused);
    assert_true(banded > 0);
    assert_true(refused > 0);
    picture_free(&expected);
}

static void short_memory_makes_bands(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b)
        if (picture_instance(backends[b]))
            less_and_less_memory(backends[b]);
}

/* ---- pools ----------------------------------------------------------------------------------- */

/* Renders with this capacity of one pool; how often it was recorded again. */
static uint32_t retries_with(strata *s, strata_scene *sc, strata_pool pool, uint64_t capacity,
                             const picture *expected, const char *what) {
    base_error err = {0};
    assert_int_equal(gpu_pool_grow(s->gpu, pool, capacity, &err), STRATA_OK);
    assert_int_equal(gpu_pool_capacity(s->gpu, pool), capacity);
    if (render(s, sc) != STRATA_OK)
        fail_msg("%s: %s", what, strata_error(s));
    same_picture(s, expected, what);
    assert_true(gpu_pool_capacity(s->gpu, pool) >= capacity);
    return s->result.retries;
}

/* Every pool in use: exactly full is enough, one element fewer is found out, and so is nearly none.
 * Returns how many pools were in use. */
static unsigned spoil_pools(strata *s, strata_scene *sc, const picture *expected,
                            const char *what) {
    unsigned used = 0;
    for (uint32_t i = 0; i < s->session->technique_count; ++i)
        for (uint32_t p = 0; p < s->session->techniques[i].pool_count; ++p) {
            const strata_pool pool = s->session->techniques[i].pools[p];
            base_error err = {0};
            uint64_t needed = 0;
            assert_int_equal(gpu_pool_needed(s->gpu, pool, &needed, &err), STRATA_OK);
            if (needed < 2)
                continue;
            assert_int_equal(retries_with(s, sc, pool, needed, expected, what), 0);
            assert_int_equal(retries_with(s, sc, pool, needed - 1, expected, what), 1);
            assert_true(retries_with(s, sc, pool, 1, expected, what) > 0);
            ++used;
        }
    return used;
}

static void pools_are_full_or_short_by_one(void **state) {
    static const char *const modes[] = {"abuffer.mode=contiguous", "abuffer.mode=linked"};
    (void)state;
    for (size_t b = 0; b < 2; ++b)
        for (size_t m = 0; m < 2 && picture_instance(backends[b]); ++m) {
            char what[64];
            snprintf(what, sizeof what, "%s, %s", backends[b], modes[m]);
            strata *s = open_with(backends[b], NULL, 0);
            strata_scene *sc = load(s, "scene:stack?count=70");
            used_mode = modes[m];
            if (render(s, sc) != STRATA_OK)
                fail_msg("%s: %s", what, strata_error(s));
            picture expected = taken(s);
            const unsigned used = spoil_pools(s, sc, &expected, what);
            print_message("%s: %u pools in use\n", what, used);
            assert_true(used >= 2); /* fragments, and what long pixels need */
            used_mode = NULL;
            picture_free(&expected);
            strata_close(s);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(creations_fail_on_no_device),
        cmocka_unit_test(creations_fail_on_devices),
        cmocka_unit_test(a_lost_device_is_replaced),
        cmocka_unit_test(short_memory_makes_bands),
        cmocka_unit_test(pools_are_full_or_short_by_one),
    };
    const int failed = cmocka_run_group_tests_name("faults", tests, NULL, NULL);
    picture_close();
    return failed;
}
