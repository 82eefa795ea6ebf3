/* SPDX-License-Identifier: MIT
 *
 * strata/host.h: how far two pictures are apart, as numbers and as maps, and pictures from pixels.
 */
#include "render/render.h"

#include <string.h>

typedef struct difference {
    image_difference linear;
    image_flip flip;
} difference;

static strata_result take(const strata_compare_options *given, strata_compare_options *options,
                          base_error *err) {
    *options = (strata_compare_options){.struct_size = sizeof *options};
    if (given && !base_take(options, sizeof *options, given))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "compare: struct_size is not set, or options are of a later version");
    if (options->pixels_per_degree == 0)
        options->pixels_per_degree = IMAGE_FLIP_PIXELS_PER_DEGREE;
    return STRATA_OK;
}

static strata_result write_small(const image *im, uint32_t longest, const char *path,
                                 base_error *err) {
    image small = {0};
    strata_result r = image_shrink(im, longest, &small, err);
    if (r == STRATA_OK)
        r = image_write_png(&small, path, err);
    image_free(&small);
    return r;
}

static strata_result differ(const image *a, const image *b, const strata_compare_options *options,
                            difference *out, base_error *err) {
    image map = {0}, flips = {0};
    strata_result r = image_compare(a, b, &out->linear, err);
    if (r == STRATA_OK)
        r = image_flip_compare(a, b, options->pixels_per_degree, &out->flip,
                               options->flip ? &flips : NULL, err);
    if (r == STRATA_OK && options->flip)
        r = write_small(&flips, options->longest, options->flip, err);
    if (r == STRATA_OK && options->heat)
        r = image_heat_map(a, b, &map, err);
    if (r == STRATA_OK && options->heat)
        r = write_small(&map, options->longest, options->heat, err);
    image_free(&map);
    image_free(&flips);
    return r;
}

static json_t *finite_json(double value) {
    return value - value == 0 ? json_real(value) : json_null();
}

static json_t *difference_json(const difference *d, const strata_compare_options *options) {
    const image_difference *l = &d->linear;
    return json_pack("{s:o, s:o, s:o, s:I, s:I, s:{s:f, s:f, s:f, s:f}}", "max",
                     finite_json(l->max), "rmse", finite_json(l->rmse), "psnr",
                     finite_json(l->psnr), "differing", (json_int_t)l->differing, "broken",
                     (json_int_t)l->broken, "flip", "mean", d->flip.mean, "weighted_median",
                     d->flip.weighted_median, "max", d->flip.max, "pixels_per_degree",
                     options->pixels_per_degree);
}

strata_result strata_compare(strata *s, const char *a, const char *b,
                             const strata_compare_options *given, strata_write_fn write,
                             void *user) {
    strata_compare_options options;
    difference d = {0};
    image left = {0}, right = {0};
    s->error = (base_error){0};
    strata_result r = take(given, &options, &s->error);
    if (r == STRATA_OK)
        r = image_read(a, &left, &s->error);
    if (r == STRATA_OK)
        r = image_read(b, &right, &s->error);
    if (r == STRATA_OK)
        r = differ(&left, &right, &options, &d, &s->error);
    image_free(&left);
    image_free(&right);
    return r == STRATA_OK ? render_write_json(s, difference_json(&d, &options), write, user) : r;
}

/* Pixels as strata_read gives them have their top row first, images their bottom row. */
static strata_result from_pixels(uint32_t width, uint32_t height, const float *pixels, image *out,
                                 base_error *err) {
    strata_result r = image_create(width, height, out, err);
    const size_t row = (size_t)width * 4;
    for (uint32_t y = 0; y < height && r == STRATA_OK; ++y)
        memcpy(out->pixels + row * y, pixels + row * (height - 1 - y), row * sizeof(float));
    return r;
}

strata_result strata_compare_pixels(strata *s, uint32_t width, uint32_t height, const float *a,
                                    const float *b, const strata_compare_options *given,
                                    strata_write_fn write, void *user) {
    strata_compare_options options;
    difference d = {0};
    image left = {0}, right = {0};
    s->error = (base_error){0};
    strata_result r = take(given, &options, &s->error);
    if (r == STRATA_OK)
        r = from_pixels(width, height, a, &left, &s->error);
    if (r == STRATA_OK)
        r = from_pixels(width, height, b, &right, &s->error);
    if (r == STRATA_OK)
        r = differ(&left, &right, &options, &d, &s->error);
    image_free(&left);
    image_free(&right);
    return r == STRATA_OK ? render_write_json(s, difference_json(&d, &options), write, user) : r;
}

strata_result strata_save_pixels(strata *s, uint32_t width, uint32_t height, const float *pixels,
                                 uint32_t longest, const char *path) {
    image im = {0};
    s->error = (base_error){0};
    strata_result r = from_pixels(width, height, pixels, &im, &s->error);
    if (r == STRATA_OK)
        r = write_small(&im, longest, path, &s->error);
    image_free(&im);
    return r;
}
