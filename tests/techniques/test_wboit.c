/* SPDX-License-Identifier: MIT
 *
 * Weighted blended transparency against the paper's equation, evaluated in double from the samples
 * of the deep image; one layer is right; the order of submission only rounds; and opaque pixels
 * hide all that lies behind.
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

static const char *const backends[] = {"vulkan", "gl"};
static const char *const weights[] = {"one", "eq7", "eq8", "eq9", "eq10"};

#define EACH_BACKEND(instance)                                                                     \
    for (size_t b = 0; b < 2; ++b)                                                                 \
        if ((instance = picture_instance(backends[b])) != NULL)

/* What the depth buffer held at this distance: depths fall as distances grow. */
static double depth_at(const scene_view *view, double distance) {
    double low = 0, high = 1;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        *(scene_view_distance(view, middle) > distance ? &low : &high) = middle;
    }
    return low;
}

/* Equations 7 to 10 of the paper, with their factor alpha. */
static double weight_of(const char *weight, const scene_view *view, double distance, double alpha,
                        double scale) {
    const double z = distance * scale;
    double w = 1;
    if (strcmp(weight, "one") == 0)
        return 1;
    if (strcmp(weight, "eq7") == 0)
        w = 10 / (1e-5 + pow(z / 5, 2) + pow(z / 200, 6));
    if (strcmp(weight, "eq8") == 0)
        w = 10 / (1e-5 + pow(z / 10, 3) + pow(z / 200, 6));
    if (strcmp(weight, "eq9") == 0)
        w = 0.03 / (1e-5 + pow(z / 200, 4));
    if (strcmp(weight, "eq10") == 0)
        w = 3e3 * pow(depth_at(view, distance), 3);
    return alpha * fmax(1e-2, fmin(3e3, w));
}

/* Equation 6 for a pixel of the deep image over the background. */
static void equation(const strata *instance, size_t pixel, const char *weight, double scale,
                     double out[4]) {
    const image_deep *deep = &instance->result.deep;
    double sum[4] = {0, 0, 0, 0}, revealed = 1;
    for (uint32_t i = 0; i < deep->count[pixel]; ++i) {
        const size_t at = deep->offset[pixel] + i;
        const double alpha = (double)deep->color[4 * at + 3],
                     w = weight_of(weight, &instance->result.view, (double)deep->depth[at], alpha,
                                   scale);
        for (size_t c = 0; c < 4; ++c)
            sum[c] += w * (double)deep->color[4 * at + c];
        revealed *= 1 - alpha;
    }
    for (size_t c = 0; c < 4; ++c) {
        const double mean = sum[3] > 0 ? sum[c] / sum[3] : 0;
        out[c] = mean * (1 - revealed) + revealed * (c < 3 ? (double)0.2f : 1);
    }
}

static void render(strata *instance, strata_scene *sc, const char *use, uint32_t outputs,
                   const char *const *settings, uint32_t count) {
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = 48,
                                           .height = 32,
                                           .outputs = outputs,
                                           .use = use,
                                           .settings = settings,
                                           .setting_count = count};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s", strata_error(instance));
}

static void check_scene(strata *instance, const char *path) {
    enum { VALUES = 48 * 32 * 4 };
    static double expected[VALUES];
    strata_scene *sc = picture_scene(instance, path);
    for (size_t k = 0; k < sizeof weights / sizeof *weights; ++k)
        for (int wide = 0; wide < 2; ++wide) {
            char weight[32], what[128];
            const char *const settings[] = {
                weight, "wboit.scale=0.5", wide ? "wboit.precision=float" : "wboit.precision=half"};
            snprintf(weight, sizeof weight, "wboit.weight=%s", weights[k]);
            snprintf(what, sizeof what, "%s, %s, %s", path, weights[k], settings[2]);
            render(instance, sc, "abuffer,ppc", STRATA_OUTPUT_DEEP, NULL, 0);
            for (size_t i = 0; i < VALUES / 4; ++i)
                equation(instance, i, weights[k], 0.5, &expected[4 * i]);
            render(instance, sc, "wboit", 0, settings, 3);
            /* Some tens of roundings of the sums; weights by depths that were rounded before. */
            const double tolerance = wide ? 2e-5 : 3e-2;
            for (size_t i = 0; i < VALUES; ++i) {
                const double got = (double)instance->result.color.pixels[i];
                if (!(fabs(got - expected[i]) <= tolerance))
                    fail_msg("%s: value %zu is %g, not %g", what, i, got, expected[i]);
            }
        }
    strata_scene_close(sc);
}

static void pictures_are_the_papers_equation(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        check_scene(instance, "scene:soup?small=600&medium=30");
        check_scene(instance, "scene:stack?count=3");
        check_scene(instance, "scene:layers?count=5&alpha=0.1");
        check_scene(instance, "scene:layers?count=4&alpha=1");
        check_scene(instance, "scene:layers?count=0");
    }
}

/* One fragment a pixel, also of coloured glass, is what the exact fold makes of it. */
static void one_layer_is_right(void **state) {
    static const char *const paths[] = {"scene:layers?count=1", "scene:layers?count=1&alpha=1",
                                        "scene:stack?count=1&alpha=0.01"};
    strata *instance;
    (void)state;
    EACH_BACKEND(instance)
    for (size_t s = 0; s < sizeof paths / sizeof *paths; ++s) {
        strata_scene *sc = picture_scene(instance, paths[s]);
        picture exact = picture_render(sc, instance, &(way){.use = "abuffer,ppc"}, 24, 16);
        for (size_t k = 0; k < sizeof weights / sizeof *weights; ++k) {
            char weight[32];
            snprintf(weight, sizeof weight, "wboit.weight=%s", weights[k]);
            picture p =
                picture_render(sc, instance, &(way){.use = "wboit", .settings = {weight}}, 24, 16);
            for (size_t i = 0; i < (size_t)4 * 24 * 16; ++i) /* six roundings of values below 1 */
                assert_true(fabsf(p.pixels[i] - exact.pixels[i]) <= 6 * 0x1p-24f);
            picture_free(&p);
        }
        picture_free(&exact);
        strata_scene_close(sc);
    }
}

/* The sums are of the same terms in another order: gamma of as many roundings, in sums of which
 * each is a share of a pixel's value (Higham 3.1). And without a change of order the bits are the
 * same. */
static void order_only_rounds(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        strata_scene *sc = picture_scene(instance, "scene:soup?small=3000&medium=150");
        picture first = picture_render(sc, instance, &(way){.use = "wboit"}, 64, 64);
        picture again = picture_render(sc, instance, &(way){.use = "wboit", .bands = 5}, 64, 64);
        picture_same(&first, &again, "wboit in bands");
        size_t differing = 0;
        for (uint32_t shuffle = 1; shuffle <= 3; ++shuffle) {
            picture p =
                picture_render(sc, instance, &(way){.use = "wboit", .shuffle = shuffle}, 64, 64);
            for (size_t i = 0; i < (size_t)4 * 64 * 64; ++i) {
                differing += p.pixels[i] != first.pixels[i];
                assert_true(fabsf(p.pixels[i] - first.pixels[i]) <= 4 * 54 * 0x1p-24f);
            }
            picture_free(&p);
        }
        assert_true(differing > 0); /* or the order was not changed */
        picture_free(&first);
        picture_free(&again);
        strata_scene_close(sc);
    }
}

/* Where nothing transparent is, and behind opaque fragments alone, nothing changes. */
static void the_background_keeps_its_share(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        strata_scene *sc = picture_scene(instance, "scene:glass");
        picture exact = picture_render(sc, instance, &(way){.use = "abuffer,ppc"}, 64, 48);
        picture p = picture_render(sc, instance, &(way){.use = "wboit"}, 64, 48);
        render(instance, sc, "abuffer,ppc", 0, NULL, 0);
        size_t same = 0;
        for (size_t i = 0; i < (size_t)64 * 48; ++i) {
            same += memcmp(&exact.pixels[4 * i], &p.pixels[4 * i], 16) == 0;
            for (size_t c = 0; c < 4; ++c)
                assert_true(isfinite(p.pixels[4 * i + c]));
            /* coverage does not depend on order: 123 fragments at most, four roundings each */
            assert_true(fabsf(exact.pixels[4 * i + 3] - p.pixels[4 * i + 3]) <= 4 * 123 * 0x1p-24f);
        }
        assert_true(same > 64 * 48 / 4);
        picture_free(&exact);
        picture_free(&p);
        strata_scene_close(sc);
    }
}

/* A certificate says nothing where anything is blended, and that nothing is wrong elsewhere. */
static void what_is_blended_is_uncertified(void **state) {
    strata *instance;
    (void)state;
    EACH_BACKEND(instance) {
        strata_scene *sc = picture_scene(instance, "scene:stack?count=3");
        render(instance, sc, "wboit", STRATA_OUTPUT_BOUND, NULL, 0);
        size_t blended = 0;
        for (size_t i = 0; i < (size_t)48 * 32; ++i) {
            const float bound = instance->result.bound.map.pixels[4 * i];
            const int shows = instance->result.color.pixels[4 * i] != 0.2f;
            blended += (size_t)shows;
            if (shows ? !isinf(bound) : bound > 0x1p-20f)
                fail_msg("pixel %zu: bound %g", i, (double)bound);
        }
        assert_true(blended > 0 && blended < 48 * 32);
        strata_scene_close(sc);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pictures_are_the_papers_equation),
        cmocka_unit_test(one_layer_is_right),
        cmocka_unit_test(order_only_rounds),
        cmocka_unit_test(the_background_keeps_its_share),
        cmocka_unit_test(what_is_blended_is_uncertified),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
