/* SPDX-License-Identifier: MIT
 *
 * Depth peeling at its edges: a limited number of layers, also where the last one is among several
 * of one depth; pixels that are too deep; depths that change from frame to frame; and the dual mode
 * within its bound. That all layers give the bits of abuffer and ppc is test_agree's.
 */
#include "techniques/deep.h"
#include "techniques/picture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"

static const char *const backends[] = {"vulkan", "gl"};

#define EACH_BACKEND(instance)                                                                     \
    for (size_t b = 0; b < 2; ++b)                                                                 \
        if ((instance = picture_instance(backends[b])) != NULL)

/* ---- layers ---------------------------------------------------------------------------------- */

static void check_layers(strata *instance, const char *backend, const char *path, uint32_t size,
                         uint32_t layers) {
    char setting[64], what[256];
    strata_scene *sc = picture_scene(instance, path);
    deep_copy d = deep_of(backend, instance, sc, size, size);
    picture expected = {.width = size, .height = size};
    expected.pixels = malloc(d.pixels * 4 * sizeof(float));
    assert_non_null(expected.pixels);
    for (size_t i = 0; i < d.pixels; ++i)
        fold_nearest(&d, i, layers, expected.pixels + 4 * i);
    snprintf(setting, sizeof setting, "peel.layers=%u", layers);
    snprintf(what, sizeof what, "%s on %s, %s", path, backend, setting);
    picture p = picture_render(
        sc, instance, &(way){.backend = backend, .use = "peel", .settings = {setting}}, size, size);
    /* in the row order of the deep image */
    memcpy(p.pixels, instance->result.color.pixels, (size_t)size * size * 4 * sizeof(float));
    picture_same(&expected, &p, what);
    deep_check_report(instance, &d, layers, what);
    picture_free(&expected);
    picture_free(&p);
    deep_free(&d);
    strata_scene_close(sc);
}

static void the_nearest_layers_are_kept(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        static const uint32_t layers[] = {1, 2, 8, 32, 33, 34, 1024};
        for (size_t i = 0; i < sizeof layers / sizeof *layers; ++i)
            check_layers(instance, backends[b], "scene:layers?count=33&width=16&height=16", 16,
                         layers[i]);
        for (uint32_t n = 1; n <= 7; ++n) /* all at one depth */
            check_layers(instance, backends[b], "scene:stack?count=6", 24, n);
        for (uint32_t n = 1; n <= 16; n *= 2)
            check_layers(instance, backends[b], "scene:soup?small=600&medium=30", 32, n);
    }
}

/* ---- too deep -------------------------------------------------------------------------------- */

/* 2,047 layers and the step that finds nothing are as many as there may be. */
static void too_many_layers_are_refused(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance)
    check_layers(instance, backends[b], "scene:layers?count=20000&where=pixel&width=16&height=16",
                 16, 8);
    if ((instance = picture_instance(backends[0])) == NULL)
        skip();
    const strata_render_options options = {
        .struct_size = sizeof options, .width = 16, .height = 16, .use = "peel"};
    strata_scene *sc =
        picture_scene(instance, "scene:layers?count=2048&where=pixel&width=16&height=16");
    assert_int_equal(strata_render(instance, sc, &options), STRATA_ERROR_OVERFLOW);
    assert_non_null(strstr(strata_error(instance), "after 2048 steps"));
    strata_scene_close(sc);
    check_layers(instance, backends[0], "scene:layers?count=2047&where=pixel&width=16&height=16",
                 16, 0);
}

static void dual_has_no_limit_of_layers(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        strata_scene *sc = picture_scene(instance, "scene:layers?count=3");
        const char *const settings[] = {"peel.mode=dual", "peel.layers=2"};
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = 8,
                                               .height = 8,
                                               .use = "peel",
                                               .settings = settings,
                                               .setting_count = 2};
        assert_int_equal(strata_render(instance, sc, &options), STRATA_ERROR_UNSUPPORTED);
        assert_non_null(strstr(strata_error(instance), "peel.mode=dual cannot"));
        strata_scene_close(sc);
    }
}

/* ---- steps are learned ----------------------------------------------------------------------- */

/* The same session with the camera turned: depths grow and shrink, and no layer is left out. */
static void depths_change_from_frame_to_frame(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        enum { FRAMES = 6 };
        picture expected[FRAMES];
        static const char *const uses[] = {"abuffer,ppc", "peel"};
        strata_scene *sc = picture_scene(instance, "scene:shells");
        for (int pass = 0; pass < 2; ++pass)
            for (int i = 0; i < FRAMES; ++i) {
                picture p = {.width = 40, .height = 30};
                const size_t size = sizeof(float) * 4 * 40 * 30;
                const strata_render_options options = {.struct_size = sizeof options,
                                                       .width = 40,
                                                       .height = 30,
                                                       .use = uses[pass],
                                                       .angle = 60.0 * (i % 3)};
                assert_int_equal(strata_render(instance, sc, &options), STRATA_OK);
                p.pixels = malloc(size);
                assert_non_null(p.pixels);
                assert_int_equal(strata_read(instance, STRATA_OUTPUT_COLOR, p.pixels, size),
                                 STRATA_OK);
                if (pass == 0) {
                    expected[i] = p;
                    continue;
                }
                picture_same(&expected[i], &p, "turned shells");
                picture_free(&p);
                picture_free(&expected[i]);
            }
        strata_scene_close(sc);
    }
}

/* A frame as deep as the last one waits once for each band, and records nothing in vain. */
static void a_still_frame_waits_once(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        strata_scene *sc = picture_scene(instance, "scene:layers?count=33");
        for (int i = 0; i < 3; ++i) {
            picture p = picture_render(sc, instance, &(way){.use = "peel", .bands = 2}, 17, 13);
            picture_free(&p);
            if (i > 0)
                assert_int_equal(instance->result.stalls, 2);
        }
        strata_scene_close(sc);
    }
}

/* ---- dual ------------------------------------------------------------------------------------ */

/* Each of n fragments meets at most four roundings on its way into the sum (its complement, the
 * product of transmittances, its product with that, the sum), whatever is joined first; so both
 * folds are off by gamma of 4 (n + 2) and less, Higham 3.1, in values of at most `largest`. */
static void check_dual(const picture *exact, const picture *dual, uint64_t depth,
                       const char *what) {
    const double m = 4.0 * ((double)depth + 2.0) * 0x1p-24, gamma = m / (1.0 - m);
    double largest = 1;
    for (size_t i = 0; i < (size_t)4 * exact->width * exact->height; ++i)
        largest = fmax(largest, fabs((double)exact->pixels[i]));
    for (size_t i = 0; i < (size_t)4 * exact->width * exact->height; ++i)
        if (!(fabs((double)exact->pixels[i] - (double)dual->pixels[i]) <= 2 * gamma * largest))
            fail_msg("%s: value %zu: %a and %a", what, i, (double)exact->pixels[i],
                     (double)dual->pixels[i]);
}

static void dual_is_within_its_bound(void **state) {
    strata *instance;
    (void)state;
    for (size_t i = 0; i < picture_scene_count; ++i) {
        const test_scene *s = &picture_scenes[i];
        picture first = {0};
        if (s->depth > 200) /* the same again, many more times */
            continue;
        EACH_BACKEND(instance) {
            static const way ways[] = {
                {.use = "peel", .settings = {"peel.mode=dual"}},
                {.use = "peel", .settings = {"peel.mode=dual"}, .bands = 5, .shuffle = 3}};
            strata_scene *sc = picture_scene(instance, s->path);
            picture exact =
                picture_render(sc, instance, &(way){.use = "abuffer,ppc"}, s->width, s->height);
            picture p = picture_render(sc, instance, &ways[b], s->width, s->height);
            check_dual(&exact, &p, instance->session->report.largest, s->path);
            if (first.pixels) { /* the same bits whatever the order, the bands and the backend */
                picture_same(&first, &p, s->path);
                picture_free(&p);
            } else {
                first = p;
            }
            picture_free(&exact);
            strata_scene_close(sc);
        }
        picture_free(&first);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_nearest_layers_are_kept),
        cmocka_unit_test(too_many_layers_are_refused),
        cmocka_unit_test(dual_has_no_limit_of_layers),
        cmocka_unit_test(depths_change_from_frame_to_frame),
        cmocka_unit_test(a_still_frame_waits_once),
        cmocka_unit_test(dual_is_within_its_bound),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
