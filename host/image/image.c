/* SPDX-License-Identifier: MIT
 *
 * The image type itself, and the choice of file format by name (writing) or content (reading).
 */
#include "image/image_internal.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

strata_result image_create(uint32_t width, uint32_t height, image *out, base_error *err) {
    *out = (image){0};
    if (width == 0 || height == 0 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE ||
        (uint64_t)width * height > IMAGE_MAX_PIXELS) {
        return base_fail(err, STRATA_ERROR_OVERFLOW,
                         "an image of %u x %u: sides are 1 to %u, and %llu pixels are the most",
                         width, height, IMAGE_MAX_SIDE, (unsigned long long)IMAGE_MAX_PIXELS);
    }
    float *pixels = base_calloc((size_t)width * height, 4 * sizeof(float));
    if (!pixels) {
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for an image of %u x %u",
                         width, height);
    }
    *out = (image){.width = width, .height = height, .pixels = pixels};
    return STRATA_OK;
}

void image_free(image *im) {
    if (im) {
        free(im->pixels);
        *im = (image){0};
    }
}

/* The mean of the source pixels [x0, x1) x [y0, y1). */
static void average(const image *im, const uint32_t x[2], const uint32_t y[2], float out[4]) {
    double sum[4] = {0};
    for (uint32_t v = y[0]; v < y[1]; ++v)
        for (uint32_t u = x[0]; u < x[1]; ++u)
            for (size_t c = 0; c < 4; ++c)
                sum[c] += (double)im->pixels[((size_t)v * im->width + u) * 4 + c];
    for (size_t c = 0; c < 4; ++c)
        out[c] = (float)(sum[c] / ((double)(x[1] - x[0]) * (y[1] - y[0])));
}

/* Where pixel i of `to` begins among `from`. */
static uint32_t begin(uint32_t i, uint32_t from, uint32_t to) {
    return (uint32_t)((uint64_t)i * from / to);
}

strata_result image_shrink(const image *im, uint32_t longest, image *out, base_error *err) {
    const uint32_t side = im->width > im->height ? im->width : im->height;
    const uint32_t to = longest && longest < side ? longest : side;
    const uint32_t width = (uint32_t)((uint64_t)im->width * to / side),
                   height = (uint32_t)((uint64_t)im->height * to / side);
    strata_result r = image_create(width ? width : 1, height ? height : 1, out, err);
    for (uint32_t v = 0; r == STRATA_OK && v < out->height; ++v)
        for (uint32_t u = 0; u < out->width; ++u) {
            const uint32_t x[2] = {begin(u, im->width, out->width),
                                   begin(u + 1, im->width, out->width)};
            const uint32_t y[2] = {begin(v, im->height, out->height),
                                   begin(v + 1, im->height, out->height)};
            average(im, x, y, out->pixels + ((size_t)v * out->width + u) * 4);
        }
    return r;
}

static int ends_in(const char *path, const char *ending) {
    size_t length = strlen(path), tail = strlen(ending);
    return length > tail && strcasecmp(path + length - tail, ending) == 0;
}

strata_result image_write(const image *im, const char *path, base_error *err) {
    if (ends_in(path, ".png"))
        return image_write_png(im, path, err);
    if (ends_in(path, ".exr"))
        return image_write_exr(im, path, err);
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: an image's name ends in .png or .exr",
                     path);
}

strata_result image_read_memory(const char *name, const void *data, size_t size, image *out,
                                base_error *err) {
    static const unsigned char png[4] = {0x89, 'P', 'N', 'G'}, exr[4] = {0x76, 0x2f, 0x31, 0x01};
    *out = (image){0};
    if (size >= sizeof png && memcmp(data, png, sizeof png) == 0)
        return image_decode_png(name, data, size, out, err);
    if (size >= sizeof exr && memcmp(data, exr, sizeof exr) == 0)
        return image_decode_exr(name, data, size, out, err);
    return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: neither a PNG nor an EXR file", name);
}

strata_result image_read(const char *path, image *out, base_error *err) {
    unsigned char *data = NULL;
    size_t size = 0;
    *out = (image){0};
    strata_result result = base_file_read(path, IMAGE_MAX_FILE_BYTES, &data, &size, err);
    if (result == STRATA_OK)
        result = image_read_memory(path, data, size, out, err);
    free(data);
    return result;
}
