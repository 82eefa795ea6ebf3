/* SPDX-License-Identifier: MIT
 *
 * FLIP against what its definition says of pictures that can be worked out by hand. (The authors'
 * value for their reference pair, a mean of 0.159691, needs their pictures, which no package has.)
 */
#include "image/image.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <cmocka.h>

/* Rounding of sums of floats: YCxCz up to 116 keeps 24 bits, and differences enter by powers of .7
 * and .5. */
#define NEAR 2e-3

static image plain(uint32_t width, uint32_t height, float r, float g, float b) {
    image im;
    base_error err = {0};
    assert_int_equal(image_create(width, height, &im, &err), STRATA_OK);
    for (size_t p = 0; p < (size_t)width * height; ++p) {
        const float color[4] = {r, g, b, 1};
        for (size_t c = 0; c < 4; ++c)
            im.pixels[4 * p + c] = color[c];
    }
    return im;
}

/* Pixels of a picture without pattern, the same for the same seed. */
static image noise(uint32_t width, uint32_t height, uint32_t seed) {
    image im = plain(width, height, 0, 0, 0);
    for (size_t i = 0; i < (size_t)width * height * 4; ++i) {
        seed = seed * 1664525u + 1013904223u;
        im.pixels[i] = i % 4 == 3 ? 1 : (float)(seed >> 8) / 16777216.0f;
    }
    return im;
}

static image_flip compare(const image *a, const image *b, double ppd) {
    image_flip out;
    base_error err = {0};
    if (image_flip_compare(a, b, ppd, &out, NULL, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return out;
}

static image_flip compare_plain(float r, float g, float b, float s, float t, float u) {
    image left = plain(24, 17, r, g, b), right = plain(24, 17, s, t, u);
    const image_flip out = compare(&left, &right, 67);
    image_free(&left);
    image_free(&right);
    return out;
}

static void of_equal_pictures_is_zero(void **state) {
    (void)state;
    image a = noise(40, 31, 1);
    const image_flip out = compare(&a, &a, 67);
    assert_true(out.mean == 0 && out.max == 0 && out.weighted_median == 0);
    image_free(&a);
}

/* The farthest apart that colours can be is 1 by construction. */
static void of_green_and_blue_is_one(void **state) {
    (void)state;
    const image_flip out = compare_plain(0, 1, 0, 0, 0, 1);
    assert_true(fabs(out.mean - 1) < NEAR && fabs(out.max - 1) < NEAR);
    assert_true(fabs(out.weighted_median - 1) < NEAR);
}

/* Black to white is 100 apart in L* and in nothing else: 100^0.7 = 25.1189. Green (L* 87.7370,
 * a* -86.1846, b* 83.1812) and blue (32.3026, 79.1967, -107.8637), as tables of CIELAB list them,
 * are HyAB 203.3065 apart with a* and b* times L* / 100; to the power of 0.7: 41.2813. Above 0.4 of
 * it the rest of the range is a straight line from 0.95 to 1. */
static void of_black_and_white(void **state) {
    (void)state;
    const double green[3] = {87.7370, -86.1846, 83.1812}, blue[3] = {32.3026, 79.1967, -107.8637};
    const double a = green[1] * green[0] / 100 - blue[1] * blue[0] / 100,
                 b = green[2] * green[0] / 100 - blue[2] * blue[0] / 100;
    const double most = pow(green[0] - blue[0] + sqrt(a * a + b * b), 0.7);
    const double wanted = 0.95 + 0.05 * (pow(100, 0.7) - 0.4 * most) / (0.6 * most);
    const image_flip out = compare_plain(0, 0, 0, 1, 1, 1);
    assert_true(fabs(out.mean - wanted) < 1e-4);
    assert_true(wanted > 0.96 && wanted < 0.98);
}

/* Greys: L* of 18.4 % is 50; of no pattern nothing but lightness counts, below the cut a straight
 * line through 0. */
static void of_two_greys(void **state) {
    (void)state;
    const double light[2] = {116 * cbrt(0.184) - 16, 116 * cbrt(0.2) - 16};
    const image_flip greys = compare_plain(0.184f, 0.184f, 0.184f, 0.2f, 0.2f, 0.2f),
                     whole = compare_plain(0, 0, 0, 1, 1, 1);
    const double most = pow(100, 0.7) / (0.4 + (whole.mean - 0.95) / 0.05 * 0.6);
    assert_true(fabs(greys.mean - 0.95 / (0.4 * most) * pow(light[1] - light[0], 0.7)) < 1e-3);
}

static void is_symmetric(void **state) {
    (void)state;
    image a = noise(33, 20, 1), b = noise(33, 20, 2);
    const image_flip there = compare(&a, &b, 67), back = compare(&b, &a, 67);
    assert_true(there.mean == back.mean && there.max == back.max);
    assert_true(there.mean > 0 && there.max <= 1 && there.weighted_median >= there.mean);
    image_free(&a);
    image_free(&b);
}

static image turned(const image *im) {
    image out = plain(im->height, im->width, 0, 0, 0);
    for (uint32_t y = 0; y < im->height; ++y)
        for (uint32_t x = 0; x < im->width; ++x)
            for (uint32_t c = 0; c < 4; ++c)
                out.pixels[4 * ((size_t)x * im->height + y) + c] =
                    im->pixels[4 * ((size_t)y * im->width + x) + c];
    return out;
}

/* Rows and columns are alike: axes are filtered one after the other, within rounding. */
static void has_no_direction(void **state) {
    (void)state;
    image a = noise(40, 22, 3), b = noise(40, 22, 4), at = turned(&a), bt = turned(&b);
    assert_true(fabs(compare(&a, &b, 67).mean - compare(&at, &bt, 67).mean) < 1e-5);
    image_free(&a);
    image_free(&b);
    image_free(&at);
    image_free(&bt);
}

static image stripes(uint32_t period, int shifted) {
    image im = plain(64, 64, 0, 0, 0);
    for (uint32_t y = 0; y < 64; ++y)
        for (uint32_t x = 0; x < 64; ++x)
            for (uint32_t c = 0; c < 3; ++c)
                im.pixels[4 * ((size_t)y * 64 + x) + c] =
                    (x / period + (uint32_t)shifted) % 2 ? 1.0f : 0.0f;
    return im;
}

/* What the eye cannot resolve counts less: fine stripes exchanged against coarse ones, and the same
 * picture from afar. */
static void sees_less_of_what_is_fine(void **state) {
    (void)state;
    image fine = stripes(1, 0), moved = stripes(1, 1), coarse = stripes(16, 0),
          coarse_moved = stripes(16, 1);
    const double near = compare(&fine, &moved, 20).mean, far = compare(&fine, &moved, 200).mean;
    assert_true(far < near);
    assert_true(compare(&fine, &moved, 67).mean < compare(&coarse, &coarse_moved, 67).mean);
    image_free(&fine);
    image_free(&moved);
    image_free(&coarse);
    image_free(&coarse_moved);
}

/* A point against its picture without it: the colours differ little once filtered, but a feature is
 * there or is not, which raises the difference where it stands. */
static void sees_a_single_point(void **state) {
    (void)state;
    image a = plain(41, 41, 0.2f, 0.2f, 0.2f), b = plain(41, 41, 0.2f, 0.2f, 0.2f), map;
    base_error err = {0};
    image_flip out;
    for (size_t c = 0; c < 3; ++c)
        b.pixels[4 * (20 * 41 + 20) + c] = 1;
    assert_int_equal(image_flip_compare(&a, &b, 67, &out, &map, &err), STRATA_OK);
    assert_true(out.max > 0.2 && out.mean < 0.2 * out.max);
    for (size_t p = 0; p < 41 * 41; ++p) /* beyond radii of 10 and 9 nothing is seen */
        if (p % 41 < 9 || p % 41 > 31)
            assert_true(map.pixels[4 * p] == 0 && map.pixels[4 * p + 1] == 0);
    assert_true(map.pixels[4 * (20 * 41 + 20)] > 0);
    image_free(&map);
    image_free(&a);
    image_free(&b);
}

static void refuses(void **state) {
    (void)state;
    image a = plain(4, 4, 0, 0, 0), b = plain(4, 5, 0, 0, 0);
    image_flip out;
    base_error err = {0};
    assert_int_equal(image_flip_compare(&a, &b, 67, &out, NULL, &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(image_flip_compare(&a, &a, 0, &out, NULL, &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(image_flip_compare(&a, &a, NAN, &out, NULL, &err),
                     STRATA_ERROR_INVALID_ARGUMENT);
    a.pixels[0] = NAN;
    b.pixels[0] = INFINITY;
    assert_true(compare(&a, &a, 67).mean == 0);
    image_free(&a);
    image_free(&b);
}

/* The largest kernels that pixels per degree can ask for, on a picture smaller than they are. */
static void takes_every_width(void **state) {
    (void)state;
    image a = noise(3, 1, 5), b = noise(3, 1, 6);
    assert_true(compare(&a, &b, 1000).mean <= 1);
    assert_true(compare(&a, &b, 1).mean <= 1);
    image_free(&a);
    image_free(&b);
}

static void shrinks_by_area(void **state) {
    (void)state;
    image im = plain(5, 2, 0, 0, 0), out;
    base_error err = {0};
    for (size_t p = 0; p < 10; ++p)
        im.pixels[4 * p] = (float)p;
    assert_int_equal(image_shrink(&im, 2, &out, &err), STRATA_OK);
    assert_int_equal(out.width, 2);
    assert_int_equal(out.height, 1);
    assert_true(out.pixels[0] == 3 && out.pixels[4] == 5.5f); /* (0 1 5 6), (2 3 4 7 8 9) */
    image_free(&out);
    assert_int_equal(image_shrink(&im, 0, &out, &err), STRATA_OK);
    assert_true(out.width == 5 && out.height == 2 && out.pixels[36] == 9);
    image_free(&out);
    image_free(&im);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(of_equal_pictures_is_zero),
        cmocka_unit_test(of_green_and_blue_is_one),
        cmocka_unit_test(of_black_and_white),
        cmocka_unit_test(of_two_greys),
        cmocka_unit_test(is_symmetric),
        cmocka_unit_test(has_no_direction),
        cmocka_unit_test(sees_less_of_what_is_fine),
        cmocka_unit_test(sees_a_single_point),
        cmocka_unit_test(refuses),
        cmocka_unit_test(takes_every_width),
        cmocka_unit_test(shrinks_by_area),
    };
    return cmocka_run_group_tests_name("flip", tests, NULL, NULL);
}
