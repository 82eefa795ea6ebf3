/* SPDX-License-Identifier: MIT
 *
 * How far two images are apart: maximum, RMSE and PSNR in linear float, and a map of where.
 * Sums are in double, row by row in file order, so that a result is the same everywhere.
 */
#include "image/image_internal.h"

#include <math.h>

/* |a - b| over the channels, its maximum in *max and sum of squares in *squares; 0 for a broken
 * pixel (see image_difference), which has neither. */
static int pixel_difference(const float *a, const float *b, double *max, double *squares) {
    *max = *squares = 0;
    for (int c = 0; c < 4; ++c) {
        if (isfinite(a[c]) && isfinite(b[c])) {
            double d = fabs((double)a[c] - (double)b[c]);
            *max = d > *max ? d : *max;
            *squares += d * d;
        } else if (isnan(a[c]) || isnan(b[c]) || a[c] < b[c] || a[c] > b[c]) {
            return 0;
        }
    }
    return 1;
}

strata_result image_same_size(const image *a, const image *b, base_error *err) {
    if (a->width != b->width || a->height != b->height) {
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "the images differ in size: %u x %u and %u x %u", a->width, a->height,
                         b->width, b->height);
    }
    return STRATA_OK;
}

strata_result image_compare(const image *a, const image *b, image_difference *out,
                            base_error *err) {
    *out = (image_difference){0};
    strata_result result = image_same_size(a, b, err);
    if (result != STRATA_OK)
        return result;
    double total = 0;
    for (uint32_t y = 0; y < a->height; ++y) {
        double row = 0;
        for (uint32_t x = 0; x < a->width; ++x) {
            size_t at = ((size_t)y * a->width + x) * 4;
            double max, squares;
            if (!pixel_difference(a->pixels + at, b->pixels + at, &max, &squares)) {
                out->broken++;
                max = INFINITY;
            }
            out->differing += max > 0;
            if (max > out->max) {
                out->max = max;
                out->x = x;
                out->y = y;
            }
            row += squares;
        }
        total += row;
    }
    out->rmse = out->broken ? INFINITY : sqrt(total / (4.0 * a->width * a->height));
    out->psnr = -20 * log10(out->rmse);
    return STRATA_OK;
}

/* The ramp, t in 0..1: lightness t, hue and chroma as the header tells, in Oklab (Ottosson 2020),
 * whose L is built so that equal steps look equal. Out-of-gamut values are clamped. */
void image_ramp(double t, float out[4]) {
    double angle = (265 + 210 * t) * (3.14159265358979323846 / 180);
    double chroma = 0.75 * t * (1 - t); /* none at black and white */
    double a = chroma * cos(angle), b = chroma * sin(angle);
    double l = t + 0.3963377774 * a + 0.2158037573 * b;
    double m = t - 0.1055613458 * a - 0.0638541728 * b;
    double s = t - 0.0894841775 * a - 1.2914855480 * b;
    l = l * l * l;
    m = m * m * m;
    s = s * s * s;
    double rgb[3] = {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
                     -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
                     -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
    for (int c = 0; c < 3; ++c)
        out[c] = (float)fmin(fmax(rgb[c], 0), 1);
    out[3] = 1;
}

strata_result image_heat_map(const image *a, const image *b, image *out, base_error *err) {
    *out = (image){0};
    strata_result result = image_same_size(a, b, err);
    if (result == STRATA_OK)
        result = image_create(a->width, a->height, out, err);
    if (result != STRATA_OK)
        return result;
    for (size_t i = 0; i < (size_t)a->width * a->height; ++i) {
        double max, squares;
        float *to = out->pixels + i * 4;
        if (!pixel_difference(a->pixels + i * 4, b->pixels + i * 4, &max, &squares)) {
            to[1] = to[3] = 1;
            continue;
        }
        double t = max > IMAGE_HEAT_FLOOR ? 1 - log10(max) / log10(IMAGE_HEAT_FLOOR) : 0;
        image_ramp(fmin(t, 1), to);
    }
    return STRATA_OK;
}
