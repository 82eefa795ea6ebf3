/* SPDX-License-Identifier: MIT
 *
 * FLIP against what its definition says of pictures that can be worked out by hand, and against the
 * definition written down once more. (The authors' value for their reference pair, a mean of
 * 0.159691, needs their pictures, which no package has.)
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
    assert_true(there.weighted_median < there.max);
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

/* ---- the definition once more ---------------------------------------------------------------- */

/* FLIP as the paper writes it, in double, with two-dimensional kernels, other digits of the matrix
 * and its printed inverse; nothing in common with the code under test. */
enum { SIDE_X = 17, SIDE_Y = 12, PIXELS = SIDE_X * SIDE_Y };
typedef double plane[PIXELS];
static const double matrix[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                    {0.2126729, 0.7151522, 0.0721750},
                                    {0.0193339, 0.1191920, 0.9503041}};
static const double inverse[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                     {-0.9692660, 1.8760108, 0.0415560},
                                     {0.0556434, -0.2040259, 1.0572252}};

static double white(int i) {
    return matrix[i][0] + matrix[i][1] + matrix[i][2];
}

static void oracle_lab(const double rgb[3], double lab[3]) {
    double f[3];
    for (int i = 0; i < 3; ++i) {
        const double t =
            (matrix[i][0] * rgb[0] + matrix[i][1] * rgb[1] + matrix[i][2] * rgb[2]) / white(i);
        f[i] = t > 216.0 / 24389 ? pow(t, 1.0 / 3) : (24389.0 / 27 * t + 16) / 116;
    }
    lab[0] = 116 * f[1] - 16;
    lab[1] = lab[0] / 100 * 500 * (f[0] - f[1]);
    lab[2] = lab[0] / 100 * 200 * (f[1] - f[2]);
}

static double csf(int channel, double x, double y, double ppd) {
    static const double a[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}};
    static const double b[3][2] = {{0.0047, 1e-5}, {0.0053, 1e-5}, {0.04, 0.025}};
    const double pi = acos(-1), d = (x * x + y * y) / (ppd * ppd);
    return a[channel][0] * sqrt(pi / b[channel][0]) * exp(-pi * pi * d / b[channel][0]) +
           a[channel][1] * sqrt(pi / b[channel][1]) * exp(-pi * pi * d / b[channel][1]);
}

/* which: 0 to 2 contrast sensitivity, 3 and 4 edges, 5 and 6 points, along x and y. */
static double kernel_at(int which, int x, int y, double ppd) {
    const double s = 0.5 * 0.082 * ppd, t = which % 2 ? x : y,
                 g = exp(-(x * x + y * y) / (2 * s * s));
    return which < 3 ? csf(which, x, y, ppd) : which < 5 ? -t * g : (t * t / (s * s) - 1) * g;
}

static double clamped(const plane in, int x, int y) {
    x = x < 0 ? 0 : x >= SIDE_X ? SIDE_X - 1 : x;
    y = y < 0 ? 0 : y >= SIDE_Y ? SIDE_Y - 1 : y;
    return in[y * SIDE_X + x];
}

static void oracle_filter(int which, double ppd, const plane in, plane out) {
    const double pi = acos(-1);
    const int r = (int)ceil(which < 3 ? 3 * sqrt(0.04 / (2 * pi * pi)) * ppd : 1.5 * 0.082 * ppd);
    double positive = 0, negative = 0;
    for (int y = -r; y <= r; ++y)
        for (int x = -r; x <= r; ++x) {
            const double k = kernel_at(which, x, y, ppd);
            *(k > 0 ? &positive : &negative) += fabs(k);
        }
    for (int p = 0; p < PIXELS; ++p) {
        out[p] = 0;
        for (int y = -r; y <= r; ++y)
            for (int x = -r; x <= r; ++x) {
                const double k = kernel_at(which, x, y, ppd);
                out[p] +=
                    k / (k > 0 ? positive : negative) * clamped(in, p % SIDE_X + x, p / SIDE_X + y);
            }
    }
}

typedef struct oracle_seen {
    double lab[PIXELS][3];
    plane edges, points;
} oracle_seen;

static void oracle_length(int which, double ppd, const plane in, plane out) {
    static plane along_x, along_y;
    oracle_filter(which, ppd, in, along_x);
    oracle_filter(which + 1, ppd, in, along_y);
    for (int p = 0; p < PIXELS; ++p)
        out[p] = sqrt(along_x[p] * along_x[p] + along_y[p] * along_y[p]);
}

static void oracle_look(const image *im, double ppd, oracle_seen *out) {
    static plane opponent[3], filtered[3], luminance;
    for (int p = 0; p < PIXELS; ++p) {
        double share[3] = {0};
        for (int i = 0; i < 3; ++i)
            for (int c = 0; c < 3; ++c)
                share[i] += matrix[i][c] * (double)im->pixels[4 * p + c] / white(i);
        opponent[0][p] = 116 * share[1] - 16;
        opponent[1][p] = 500 * (share[0] - share[1]);
        opponent[2][p] = 200 * (share[1] - share[2]);
        luminance[p] = share[1];
    }
    for (int c = 0; c < 3; ++c)
        oracle_filter(c, ppd, opponent[c], filtered[c]);
    for (int p = 0; p < PIXELS; ++p) {
        const double y = (filtered[0][p] + 16) / 116;
        const double xyz[3] = {(y + filtered[1][p] / 500) * white(0), y * white(1),
                               (y - filtered[2][p] / 200) * white(2)};
        double rgb[3];
        for (int i = 0; i < 3; ++i)
            rgb[i] = fmin(
                fmax(inverse[i][0] * xyz[0] + inverse[i][1] * xyz[1] + inverse[i][2] * xyz[2], 0),
                1);
        oracle_lab(rgb, out->lab[p]);
    }
    oracle_length(3, ppd, luminance, out->edges);
    oracle_length(5, ppd, luminance, out->points);
}

static double oracle_hyab(const double a[3], const double b[3]) {
    return fabs(a[0] - b[0]) + sqrt((a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static double oracle_mean(const image *a, const image *b, double ppd) {
    static oracle_seen left, right;
    double green[3], blue[3], sum = 0;
    oracle_lab((const double[]){0, 1, 0}, green);
    oracle_lab((const double[]){0, 0, 1}, blue);
    const double most = pow(oracle_hyab(green, blue), 0.7);
    oracle_look(a, ppd, &left);
    oracle_look(b, ppd, &right);
    for (int p = 0; p < PIXELS; ++p) {
        const double d = pow(oracle_hyab(left.lab[p], right.lab[p]), 0.7) / most;
        const double color = d < 0.4 ? 0.95 / 0.4 * d : 0.95 + 0.05 * (d - 0.4) / 0.6;
        const double edges = fabs(left.edges[p] - right.edges[p]),
                     points = fabs(left.points[p] - right.points[p]);
        sum += pow(color, 1 - sqrt((edges > points ? edges : points) / sqrt(2)));
    }
    return sum / PIXELS;
}

/* The matrices agree in 6 digits; a power of .7 or .5 at most doubles what that makes. */
static void is_what_the_paper_defines(void **state) {
    (void)state;
    static const double distances[] = {10, 30, 67};
    image a = noise(SIDE_X, SIDE_Y, 11), b = noise(SIDE_X, SIDE_Y, 12);
    for (size_t p = 0; p < PIXELS; ++p) /* some of it near, as pictures of one scene are */
        for (size_t c = 0; c < 3 && p % 3; ++c)
            b.pixels[4 * p + c] = 0.9f * a.pixels[4 * p + c] + 0.1f * b.pixels[4 * p + c];
    for (size_t i = 0; i < 3; ++i)
        assert_true(fabs(compare(&a, &b, distances[i]).mean - oracle_mean(&a, &b, distances[i])) <
                    1e-5);
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
    image_free(&b);
    b = plain(4, 4, 0, 0, 0);
    a.pixels[0] = NAN; /* what is broken reads as 0 */
    a.pixels[4] = INFINITY;
    assert_true(compare(&a, &b, 67).mean == 0);
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
        cmocka_unit_test(is_what_the_paper_defines),
        cmocka_unit_test(refuses),
        cmocka_unit_test(takes_every_width),
        cmocka_unit_test(shrinks_by_area),
    };
    return cmocka_run_group_tests_name("flip", tests, NULL, NULL);
}
