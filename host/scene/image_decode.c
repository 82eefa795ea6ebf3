/* SPDX-License-Identifier: MIT
 *
 * Image decoding through stb_image, PNG and JPEG only. Its memory comes from a budget that follows
 * from the picture's size, since a PNG's compressed data may unfold to far more than its pixels.
 */
#include "scene/image_decode.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

static _Thread_local size_t decode_budget; /* of one allocation */

static void *decode_alloc(size_t size) {
    return size <= decode_budget ? malloc(size) : NULL;
}

static void *decode_realloc(void *old, size_t size) {
    return size <= decode_budget ? realloc(old, size) : NULL;
}

#define STBI_MALLOC(size)       decode_alloc(size)
#define STBI_REALLOC(old, size) decode_realloc(old, size)
#define STBI_FREE(old)          free(old)
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_LINEAR
#define STBI_NO_HDR
#define STBI_NO_FAILURE_STRINGS
#pragma GCC diagnostic ignored "-Wunused-function" /* judged at the end of the file */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wpedantic"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

/* stb_image copies to NULL when a PNG's first IDAT chunk is empty: legal in a PNG, undefined in C.
 */
static int begins_with_empty_data(const unsigned char *bytes, size_t size) {
    if (size < 8 || memcmp(bytes, "\x89PNG\r\n\x1a\n", 8) != 0)
        return 0;
    for (size_t at = 8; size - at >= 12;) {
        size_t length = (size_t)bytes[at] << 24 | (size_t)bytes[at + 1] << 16 |
                        (size_t)bytes[at + 2] << 8 | (size_t)bytes[at + 3];
        if (memcmp(bytes + at + 4, "IDAT", 4) == 0)
            return length == 0;
        if (length > size - at - 12)
            return 0;
        at += 12 + length;
    }
    return 0;
}

strata_result scene_decode_image(const unsigned char *bytes, size_t size, scene_image *out,
                                 base_error *err) {
    int width = 0, height = 0, channels = 0;
    decode_budget = 1u << 20;
    if (size == 0 || size > INT_MAX)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%zu bytes are not an image", size);
    if (begins_with_empty_data(bytes, size) ||
        !stbi_info_from_memory(bytes, (int)size, &width, &height, &channels))
        return base_fail(err, STRATA_ERROR_BAD_FILE, "is neither PNG nor JPEG, or damaged");
    if (width < 1 || height < 1 || width > (int)SCENE_MAX_IMAGE || height > (int)SCENE_MAX_IMAGE)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "is %dx%d pixels, the limit is %ux%u", width,
                         height, SCENE_MAX_IMAGE, SCENE_MAX_IMAGE);
    /* 16-bit RGBA, doubled by a growing buffer, filter bytes and tables. */
    decode_budget = (size_t)width * (size_t)height * 16u + (size_t)height * 16u + (1u << 20);
    int decoded_width = 0, decoded_height = 0;
    unsigned char *pixels =
        stbi_load_from_memory(bytes, (int)size, &decoded_width, &decoded_height, &channels, 4);
    if (!pixels || decoded_width != width || decoded_height != height) {
        free(pixels);
        return base_fail(err, STRATA_ERROR_BAD_FILE, "is damaged, or there is no memory for it");
    }
    out->width = (uint32_t)decoded_width;
    out->height = (uint32_t)decoded_height;
    out->pixels = pixels;
    return STRATA_OK;
}
