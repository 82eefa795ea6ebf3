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
