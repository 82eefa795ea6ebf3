/* SPDX-License-Identifier: MIT
 *
 * PNG through libpng's simplified interface, which needs no setjmp: linear premultiplied floats to
 * 8-bit sRGB with straight alpha and back, and plain RGBA bytes for textures.
 */
#include "image/image_internal.h"

#include <math.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

/* IEC 61966-2-1, both ways. */
static double srgb_to_linear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

float image_srgb_to_linear(unsigned char code) {
    return (float)srgb_to_linear(code / 255.0);
}

/* threshold[i]: the linear value half way, on the encoded scale, between the codes i and i + 1.
 * Comparing with these rounds correctly without ever evaluating the inverse curve. */
static void make_thresholds(double threshold[255]) {
    for (int i = 0; i < 255; ++i)
        threshold[i] = srgb_to_linear((i + 0.5) / 255.0);
}

static unsigned char encode(const double threshold[255], double linear) {
    if (!(linear > 0)) /* NaN too */
        return 0;
    int low = 0, high = 255; /* the code lies in [low, high] */
    while (low < high) {
        int middle = (low + high) / 2;
        if (linear >= threshold[middle])
            low = middle + 1;
        else
            high = middle;
    }
    return (unsigned char)low;
}

static void encode_pixel(const double threshold[255], const float in[4], unsigned char out[4]) {
    double alpha = in[3];
    if (!(alpha > 0)) {
        memset(out, 0, 4);
        return;
    }
    alpha = alpha < 1 ? alpha : 1;
    for (int c = 0; c < 3; ++c)
        out[c] = encode(threshold, in[c] / alpha);
    out[3] = (unsigned char)floor(alpha * 255 + 0.5);
}

strata_result image_encode_png(const char *name, const unsigned char *rgba, uint32_t width,
                               uint32_t height, unsigned char **data, size_t *size,
                               base_error *err) {
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = width,
                     .height = height,
                     .format = PNG_FORMAT_RGBA,
                     .flags = PNG_IMAGE_FLAG_FAST};
    *data = NULL;
    *size = 0;
    if (width == 0 || height == 0 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE ||
        (uint64_t)width * height > IMAGE_MAX_PIXELS)
        return base_fail(err, STRATA_ERROR_OVERFLOW, "%s: a PNG of %u x %u", name, width, height);
    png_alloc_size_t capacity = PNG_IMAGE_PNG_SIZE_MAX(png);
    unsigned char *bytes = base_calloc(capacity, 1);
    if (!bytes) {
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to encode a PNG",
                         name);
    }
    png_alloc_size_t used = capacity;
    if (!png_image_write_to_memory(&png, bytes, &used, 0, rgba, 0, NULL)) {
        free(bytes);
        return base_fail(err, STRATA_ERROR_INTERNAL, "%s: libpng: %s", name, png.message);
    }
    unsigned char *shrunk = base_realloc(bytes, used, 1);
    *data = shrunk ? shrunk : bytes;
    *size = used;
    return STRATA_OK;
}

static strata_result write_file(const char *path, const void *data, size_t size, base_error *err) {
    base_output output;
    strata_result result = base_output_open(&output, path, err);
    if (result != STRATA_OK)
        return result;
    result = base_output_write(&output, data, size, err);
    if (result == STRATA_OK)
        result = base_output_commit(&output, err);
    base_output_abort(&output);
    return result;
}

strata_result image_write_png(const image *im, const char *path, base_error *err) {
    size_t row_values = (size_t)im->width * 4, size = 0;
    unsigned char *rgba = base_calloc(row_values, im->height), *data = NULL;
    if (!rgba) {
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to encode a PNG",
                         path);
    }
    double threshold[255];
    make_thresholds(threshold);
    for (uint32_t y = 0; y < im->height; ++y) {
        const float *in = im->pixels + row_values * (im->height - 1 - y);
        unsigned char *out = rgba + row_values * y;
        for (size_t x = 0; x < row_values; x += 4)
            encode_pixel(threshold, in + x, out + x);
    }
    strata_result result = image_encode_png(path, rgba, im->width, im->height, &data, &size, err);
    if (result == STRATA_OK)
        result = write_file(path, data, size, err);
    free(data);
    free(rgba);
    return result;
}

/* Straight sRGB bytes, first row on top, to premultiplied linear floats, first row at the bottom.
 */
static void decode_pixels(const unsigned char *rgba, image *out) {
    double linear[256];
    for (int i = 0; i < 256; ++i)
        linear[i] = srgb_to_linear(i / 255.0);
    size_t row_values = (size_t)out->width * 4;
    for (uint32_t y = 0; y < out->height; ++y) {
        const unsigned char *in = rgba + row_values * (out->height - 1 - y);
        float *to = out->pixels + row_values * y;
        for (size_t x = 0; x < row_values; x += 4) {
            double alpha = in[x + 3] / 255.0;
            for (size_t c = 0; c < 3; ++c)
                to[x + c] = (float)(linear[in[x + c]] * alpha);
            to[x + 3] = (float)alpha;
        }
    }
}

strata_result image_decode_png(const char *name, const void *data, size_t size, image *out,
                               base_error *err) {
    png_image png = {.version = PNG_IMAGE_VERSION};
    unsigned char *rgba = NULL;
    *out = (image){0};
    if (!png_image_begin_read_from_memory(&png, data, size))
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: libpng: %s", name, png.message);
    png.format = PNG_FORMAT_RGBA;
    strata_result result = STRATA_OK;
    /* Deflate makes at most 1032 bytes of one: what claims more pixels than that is refused before
     * memory is asked for. The least pixel has one bit. */
    if ((uint64_t)png.width * png.height / 8 > (uint64_t)size * 1032) {
        result = base_fail(err, STRATA_ERROR_BAD_FILE, "%s: %u x %u pixels cannot be in %zu bytes",
                           name, png.width, png.height, size);
        goto cleanup;
    }
    base_error limit = {0};
    if (image_create(png.width, png.height, out, &limit) != STRATA_OK) {
        result = base_fail(err, limit.result, "%s: %s", name, limit.text);
        goto cleanup;
    }
    rgba = base_calloc((size_t)png.width * png.height, 4);
    if (!rgba) {
        result =
            base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to decode it", name);
        goto cleanup;
    }
    if (!png_image_finish_read(&png, NULL, rgba, 0, NULL)) {
        result = base_fail(err, STRATA_ERROR_BAD_FILE, "%s: libpng: %s", name, png.message);
        goto cleanup;
    }
    decode_pixels(rgba, out);
cleanup:
    png_image_free(&png);
    free(rgba);
    if (result != STRATA_OK)
        image_free(out);
    return result;
}
