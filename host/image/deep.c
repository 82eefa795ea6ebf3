/* SPDX-License-Identifier: MIT
 *
 * Deep scan-line EXR: every fragment of every pixel, for compositing elsewhere and for checking our
 * own folds against other people's. OpenEXRCore's encoder does not pack deep data in its early
 * versions, so the rows are packed here and handed over as finished, uncompressed chunks.
 */
#include "image/image_internal.h"

#include <stdlib.h>
#include <string.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "chunks are packed in memory order, and EXR is little-endian"
#endif

typedef struct deep_channel {
    const char *name;
    const float *values; /* of sample 0 */
    uint32_t stride;     /* floats from sample to sample */
} deep_channel;

/* In the order of the file: sorted by name. Returns how many there are. */
static uint32_t list_channels(const image_deep *deep, deep_channel channels[8]) {
    const float *color = deep->color, *alpha = deep->color_alpha;
    uint32_t n = 0;
    channels[n++] = (deep_channel){"A", color + 3, 4};
    if (alpha) {
        channels[n++] = (deep_channel){"AB", alpha + 2, 3};
        channels[n++] = (deep_channel){"AG", alpha + 1, 3};
        channels[n++] = (deep_channel){"AR", alpha, 3};
    }
    channels[n++] = (deep_channel){"B", color + 2, 4};
    channels[n++] = (deep_channel){"G", color + 1, 4};
    channels[n++] = (deep_channel){"R", color, 4};
    channels[n++] = (deep_channel){"Z", deep->depth, 1};
    return n;
}

static strata_result check(const image_deep *deep, const char *path, base_error *err) {
    if (deep->width == 0 || deep->height == 0 || deep->width > IMAGE_MAX_SIDE ||
        deep->height > IMAGE_MAX_SIDE) {
        return base_fail(err, STRATA_ERROR_OVERFLOW, "%s: a deep image of %u x %u", path,
                         deep->width, deep->height);
    }
    for (uint32_t y = 0; y < deep->height; ++y) {
        uint64_t row = 0;
        for (uint32_t x = 0; x < deep->width; ++x) {
            size_t pixel = (size_t)y * deep->width + x;
            uint64_t count = deep->count[pixel];
            if (count > deep->sample_count || deep->offset[pixel] > deep->sample_count - count) {
                return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                                 "%s: pixel (%u, %u): its samples lie outside the list", path, x,
                                 y);
            }
            row += count;
        }
        if (row > INT32_MAX / (8 * sizeof(float))) {
            return base_fail(err, STRATA_ERROR_OVERFLOW,
                             "%s: row %u has %llu samples, more than a chunk of an EXR holds", path,
                             y, (unsigned long long)row);
        }
    }
    return STRATA_OK;
}

/* One row's cumulative counts and its samples, channel by channel. Returns the samples' bytes. */
static size_t pack_row(const image_deep *deep, uint32_t row, const deep_channel *channels,
                       uint32_t channel_count, int32_t *table, float *packed) {
    const uint64_t *offset = deep->offset + (size_t)row * deep->width;
    const uint32_t *count = deep->count + (size_t)row * deep->width;
    float *to = packed;
    for (uint32_t c = 0; c < channel_count; ++c) {
        for (uint32_t x = 0; x < deep->width; ++x)
            for (uint64_t s = offset[x]; s < offset[x] + count[x]; ++s)
                *to++ = channels[c].values[s * channels[c].stride];
    }
    int32_t total = 0;
    for (uint32_t x = 0; x < deep->width; ++x) {
        total += (int32_t)count[x];
        table[x] = total;
    }
    return (size_t)(to - packed) * sizeof(float);
}

/* The largest number of samples that a row has. */
static size_t largest_row(const image_deep *deep) {
    size_t largest = 0;
    for (uint32_t y = 0; y < deep->height; ++y) {
        size_t row = 0;
        for (uint32_t x = 0; x < deep->width; ++x)
            row += deep->count[(size_t)y * deep->width + x];
        largest = row > largest ? row : largest;
    }
    return largest;
}

strata_result image_write_deep_exr(const image_deep *deep, const char *path, base_error *err) {
    image_exr_writer writer;
    deep_channel channels[8];
    strata_result result = check(deep, path, err);
    if (result == STRATA_OK) {
        result = image_exr_open(&writer, path, EXR_STORAGE_DEEP_SCANLINE, EXR_COMPRESSION_NONE,
                                deep->width, deep->height, err);
    }
    if (result != STRATA_OK)
        return result;
    uint32_t channel_count = list_channels(deep, channels);
    int32_t *table = base_calloc(deep->width, sizeof *table);
    float *packed = base_calloc(largest_row(deep) + 1, channel_count * sizeof(float));
    exr_result_t code = table && packed ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
    for (uint32_t c = 0; c < channel_count && code == EXR_ERR_SUCCESS; ++c) {
        code = exr_add_channel(writer.context, 0, channels[c].name, EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    if (code == EXR_ERR_SUCCESS)
        code = exr_write_header(writer.context);
    for (uint32_t y = 0; y < deep->height && code == EXR_ERR_SUCCESS; ++y) {
        size_t bytes = pack_row(deep, deep->height - 1 - y, channels, channel_count, table, packed);
        code = exr_write_deep_scanline_chunk(writer.context, 0, (int)y, packed, bytes, bytes, table,
                                             deep->width * sizeof *table);
    }
    free(packed);
    free(table);
    return image_exr_close(&writer, image_exr_check(&writer, code, err), err);
}
