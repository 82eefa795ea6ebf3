/* SPDX-License-Identifier: MIT
 *
 * FLIP for pictures of low dynamic range: Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom and
 * Fairchild, "FLIP: A Difference Evaluator for Alternating Images", 2020; sections are the paper's.
 * Written from its text, with the authors' erratum (luminance is divided by 116 in 4.2.1).
 *
 *     picture -> YCxCz -> contrast sensitivity -> Hunt-adjusted L*a*b* -> colour difference
 *                  \--> edges and points of luminance -----------------> feature difference
 *
 * All kernels are sums of products of one for each axis, so pictures are filtered an axis at a
 * time.
 */
#include "image/image_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI            3.14159265358979323846
#define COLOR_POWER   0.7   /* q_c */
#define CUT_AT        0.4   /* p_c: share of the largest difference .. */
#define CUT_TO        0.95  /* p_t: .. that this share of the range is for */
#define FEATURE_WIDTH 0.082 /* w, degrees */
#define FEATURE_POWER 0.5   /* q_f */
enum { MAX_RADIUS = 136 };  /* at 1000 pixels a degree */

typedef struct kernel {
    int radius;
    double at[2 * MAX_RADIUS + 1];
} kernel;

/* What a picture is compared by, each [height][width]. */
typedef struct seen {
    uint32_t width, height;
    float *lab[3], *edges, *points;
} seen;

static size_t count_of(const seen *s) {
    return (size_t)s->width * s->height;
}

/* ---- colour spaces --------------------------------------------------------------------------- */

/* Linear sRGB to XYZ, whose white (D65) is the sum of each row. */
static const double to_xyz[3][3] = {
    {10135552 / 24577794.0, 8788810 / 24577794.0, 4435075 / 24577794.0},
    {2613072 / 12288897.0, 8788810 / 12288897.0, 887015 / 12288897.0},
    {1425312 / 73733382.0, 8788810 / 73733382.0, 70074185 / 73733382.0}};

/* XYZ as shares of the white. */
static void white_share(const double rgb[3], double out[3]) {
    for (int i = 0; i < 3; ++i)
        out[i] = (to_xyz[i][0] * rgb[0] + to_xyz[i][1] * rgb[1] + to_xyz[i][2] * rgb[2]) /
                 (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
}

static double determinant(double m[3][3]) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/* The inverse of white_share, by Cramer's rule. */
static void rgb_of(const double share[3], double rgb[3]) {
    double m[3][3];
    for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
            m[i][k] = to_xyz[i][k] / (to_xyz[i][0] + to_xyz[i][1] + to_xyz[i][2]);
    const double whole = determinant(m);
    for (int k = 0; k < 3; ++k) {
        double replaced[3][3];
        memcpy(replaced, m, sizeof m);
        for (int i = 0; i < 3; ++i)
            replaced[i][k] = share[i];
        rgb[k] = determinant(replaced) / whole;
    }
}

static void to_opponent(const double rgb[3], double ycc[3]) {
    double w[3];
    white_share(rgb, w);
    ycc[0] = 116 * w[1] - 16;
    ycc[1] = 500 * (w[0] - w[1]);
    ycc[2] = 200 * (w[1] - w[2]);
}

static double lab_curve(double t) {
    const double d = 6.0 / 29;
    return t > d * d * d ? cbrt(t) : t / (3 * d * d) + 4.0 / 29;
}

/* L*a*b* with less colour where it is dark (4.1.2, after Hunt). */
static void to_hunt(const double rgb[3], double lab[3]) {
    double w[3];
    white_share(rgb, w);
    const double x = lab_curve(w[0]), y = lab_curve(w[1]), z = lab_curve(w[2]);
    lab[0] = 116 * y - 16;
    lab[1] = 0.01 * lab[0] * 500 * (x - y);
    lab[2] = 0.01 * lab[0] * 200 * (y - z);
}

/* Back to linear RGB, within its cube (4.1.1), and on to L*a*b*. */
static void opponent_to_hunt(const double ycc[3], double lab[3]) {
    const double y = (ycc[0] + 16) / 116;
    const double share[3] = {y + ycc[1] / 500, y, y - ycc[2] / 200};
    double rgb[3];
    rgb_of(share, rgb);
    for (int c = 0; c < 3; ++c)
        rgb[c] = fmin(fmax(rgb[c], 0), 1);
    to_hunt(rgb, lab);
}

/* HyAB (4.1.2): city-block in lightness, Euclidean in colour. */
static double hyab(const double a[3], const double b[3]) {
    return fabs(a[0] - b[0]) + hypot(a[1] - b[1], a[2] - b[2]);
}

/* ---- filters --------------------------------------------------------------------------------- */

/* exp(-x^2 * falloff), x in pixels; returns the sum, by which it is divided. */
static double gaussian(double falloff, int radius, kernel *out) {
    double sum = 0;
    out->radius = radius;
    for (int x = -radius; x <= radius; ++x)
        sum += out->at[x + radius] = exp(-falloff * x * x);
    for (int i = 0; i <= 2 * radius; ++i)
        out->at[i] /= sum;
    return sum;
}

/* Positive values sum up to 1 and negative ones to -1. */
static void balance(kernel *k) {
    double positive = 0, negative = 0;
    for (int i = 0; i <= 2 * k->radius; ++i)
        *(k->at[i] > 0 ? &positive : &negative) += fabs(k->at[i]);
    for (int i = 0; i <= 2 * k->radius; ++i)
        k->at[i] /= k->at[i] > 0 ? positive : negative > 0 ? negative : 1;
}

/* One axis: across 1 along x, 0 along y. Beyond the border the border's pixel goes on. */
static void convolve(const kernel *k, int across, uint32_t width, uint32_t height, const float *in,
                     float *out) {
    const int last = (int)(across ? width : height) - 1;
    const size_t step = across ? 1 : width;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const int at = (int)(across ? x : y);
            const float *line = across ? in + (size_t)y * width : in + x;
            double sum = 0;
            for (int i = -k->radius; i <= k->radius; ++i) {
                const int from = at + i < 0 ? 0 : at + i > last ? last : at + i;
                sum += k->at[i + k->radius] * (double)line[(size_t)from * step];
            }
            out[(size_t)y * width + x] = (float)sum;
        }
}

/* x and y: the kernel along each; between: room for the half-way picture. */
static void filter(const kernel *x, const kernel *y, const seen *s, const float *in, float *between,
                   float *out) {
    convolve(x, 1, s->width, s->height, in, between);
    convolve(y, 0, s->width, s->height, between, out);
}

/* Contrast sensitivity (4.1.1, table 1): of a channel at most two Gaussians, a and b. */
static void sensitivity(seen *s, int channel, double ppd, const float *in, float *room[2]) {
    static const double a[3][2] = {{1, 0}, {1, 0}, {34.1, 13.5}};
    static const double b[3][2] = {{0.0047, 1}, {0.0053, 1}, {0.04, 0.025}};
    const int radius = (int)ceil(3 * sqrt(0.04 / (2 * PI * PI)) * ppd);
    double weight[2] = {0, 0};
    float *out = s->lab[channel];
    for (int i = 0; i < 2 && a[channel][i] > 0; ++i) {
        kernel k;
        const double sum = gaussian(PI * PI / (b[channel][i] * ppd * ppd), radius, &k);
        weight[i] = a[channel][i] * sqrt(PI / b[channel][i]) * sum * sum;
        filter(&k, &k, s, in, room[0], i == 0 ? out : room[1]);
    }
    for (size_t p = 0; p < count_of(s) && weight[1] > 0; ++p)
        out[p] = (float)((weight[0] * (double)out[p] + weight[1] * (double)room[1][p]) /
                         (weight[0] + weight[1]));
}

/* Length of (along x, along y) of one feature (4.2.1): order 1 edges, 2 points. */
static void feature(const seen *s, int order, double ppd, const float *luminance, float *room[2],
                    float *out) {
    const double deviation = 0.5 * FEATURE_WIDTH * ppd, variance = deviation * deviation;
    const int radius = (int)ceil(3 * deviation);
    kernel smooth, shape;
    gaussian(1 / (2 * variance), radius, &smooth);
    shape = smooth;
    for (int x = -radius; x <= radius; ++x)
        shape.at[x + radius] *= order == 1 ? -(double)x : x * x / variance - 1;
    balance(&shape);
    filter(&shape, &smooth, s, luminance, room[0], out);
    filter(&smooth, &shape, s, luminance, room[0], room[1]);
    for (size_t p = 0; p < count_of(s); ++p)
        out[p] = (float)hypot((double)out[p], (double)room[1][p]);
}

/* ---- a picture ------------------------------------------------------------------------------- */

static double displayed(float value) {
    return isfinite(value) ? fmin(fmax((double)value, 0), 1) : 0;
}

static void free_seen(seen *s) {
    for (int c = 0; c < 3; ++c)
        free(s->lab[c]);
    free(s->edges);
    free(s->points);
    *s = (seen){0};
}

static void opponents(const image *im, float *plane[3]) {
    for (size_t p = 0; p < (size_t)im->width * im->height; ++p) {
        const float *from = im->pixels + 4 * p;
        const double rgb[3] = {displayed(from[0]), displayed(from[1]), displayed(from[2])};
        double ycc[3];
        to_opponent(rgb, ycc);
        for (int c = 0; c < 3; ++c)
            plane[c][p] = (float)ycc[c];
    }
}

static void hunt_all(seen *s) {
    for (size_t p = 0; p < count_of(s); ++p) {
        const double ycc[3] = {(double)s->lab[0][p], (double)s->lab[1][p], (double)s->lab[2][p]};
        double lab[3];
        opponent_to_hunt(ycc, lab);
        for (int c = 0; c < 3; ++c)
            s->lab[c][p] = (float)lab[c];
    }
}

/* plane: three pictures of room, the opponent channels; room: two more. */
static void look(const image *im, double ppd, seen *s, float *plane[3], float *room[2]) {
    opponents(im, plane);
    for (int c = 0; c < 3; ++c)
        sensitivity(s, c, ppd, plane[c], room);
    hunt_all(s);
    for (size_t p = 0; p < count_of(s); ++p)
        plane[0][p] = (plane[0][p] + 16) / 116;
    feature(s, 1, ppd, plane[0], room, s->edges);
    feature(s, 2, ppd, plane[0], room, s->points);
}

static strata_result see(const image *im, double ppd, seen *s, base_error *err) {
    const size_t pixels = (size_t)im->width * im->height;
    float *room[5] = {0};
    float **all[] = {&s->lab[0], &s->lab[1], &s->lab[2], &s->edges, &s->points,
                     &room[0],   &room[1],   &room[2],   &room[3],  &room[4]};
    int enough = 1;
    *s = (seen){.width = im->width, .height = im->height};
    for (size_t i = 0; i < sizeof all / sizeof *all; ++i)
        enough &= (*all[i] = base_calloc(pixels, sizeof(float))) != NULL;
    if (enough)
        look(im, ppd, s, room, room + 3);
    for (int i = 0; i < 5; ++i)
        free(room[i]);
    return enough ? STRATA_OK : base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "FLIP: no memory");
}

/* ---- the difference -------------------------------------------------------------------------- */

/* Of green and blue, the farthest apart that a display can show (4.1.3). */
static double largest_color(void) {
    double green[3], blue[3];
    to_hunt((const double[]){0, 1, 0}, green);
    to_hunt((const double[]){0, 0, 1}, blue);
    return pow(hyab(green, blue), COLOR_POWER);
}

static double color_difference(const seen *a, const seen *b, size_t p, double largest) {
    const double left[3] = {(double)a->lab[0][p], (double)a->lab[1][p], (double)a->lab[2][p]};
    const double right[3] = {(double)b->lab[0][p], (double)b->lab[1][p], (double)b->lab[2][p]};
    const double d = pow(hyab(left, right), COLOR_POWER), cut = CUT_AT * largest;
    return d < cut ? CUT_TO / cut * d : CUT_TO + (d - cut) / (largest - cut) * (1 - CUT_TO);
}

static double feature_difference(const seen *a, const seen *b, size_t p) {
    const double edges = fabs((double)a->edges[p] - (double)b->edges[p]);
    const double points = fabs((double)a->points[p] - (double)b->points[p]);
    return fmin(pow(fmax(edges, points) / sqrt(2), FEATURE_POWER), 1);
}

static int ascending(const void *a, const void *b) {
    const float left = *(const float *)a, right = *(const float *)b;
    return left < right ? -1 : left > right;
}

/* Sorts the values. */
static image_flip pool(float *values, size_t count) {
    image_flip out = {0};
    double sum = 0, below = 0;
    qsort(values, count, sizeof *values, ascending);
    for (size_t p = 0; p < count; ++p)
        sum += (double)values[p];
    out.mean = sum / (double)count;
    out.max = (double)values[count - 1];
    for (size_t p = 0; p < count && sum > 0; ++p) {
        below += (double)values[p];
        out.weighted_median = (double)values[p];
        if (below >= sum / 2)
            break;
    }
    return out;
}

static strata_result differ(const seen *a, const seen *b, image_flip *out, image *map,
                            base_error *err) {
    const double largest = largest_color();
    float *values = base_calloc(count_of(a), sizeof *values);
    strata_result r =
        values ? STRATA_OK : base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "FLIP: no memory");
    if (r == STRATA_OK && map)
        r = image_create(a->width, a->height, map, err);
    for (size_t p = 0; p < count_of(a) && r == STRATA_OK; ++p) {
        const double value =
            pow(fmin(color_difference(a, b, p, largest), 1), 1 - feature_difference(a, b, p));
        values[p] = (float)value;
        if (map)
            image_ramp(value, map->pixels + 4 * p);
    }
    if (r == STRATA_OK)
        *out = pool(values, count_of(a));
    free(values);
    return r;
}

strata_result image_flip_compare(const image *reference, const image *test,
                                 double pixels_per_degree, image_flip *out, image *map,
                                 base_error *err) {
    seen a = {0}, b = {0};
    *out = (image_flip){0};
    if (map)
        *map = (image){0};
    if (!(pixels_per_degree >= 1 && pixels_per_degree <= 1000))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "%g pixels per degree: FLIP takes 1 to 1000", pixels_per_degree);
    strata_result r = image_same_size(reference, test, err);
    if (r == STRATA_OK)
        r = see(reference, pixels_per_degree, &a, err);
    if (r == STRATA_OK)
        r = see(test, pixels_per_degree, &b, err);
    if (r == STRATA_OK)
        r = differ(&a, &b, out, map, err);
    free_seen(&a);
    free_seen(&b);
    return r;
}
