/* SPDX-License-Identifier: MIT
 *
 * Host access to buffers and images, while the device is idle: straight through mapped memory where
 * there is some, else through one staging buffer, piece by piece.
 */
#include <string.h>

#include "gpu/vk/vk_internal.h"

#define STAGING_SIZE (UINT64_C(16) << 20)

static strata_result need_staging(vk *v, base_error *err) {
    if (v->staging.handle)
        return STRATA_OK;
    return vk_buffer_init(v, STAGING_SIZE, GPU_VK_STAGING, &v->staging, err);
}

/* ---- buffers ---------------------------------------------------------------------------- */

typedef enum vk_direction { GPU_VK_TO_HOST, GPU_VK_TO_DEVICE } vk_direction;

static strata_result copy_piece(vk *v, const vk_buffer *buffer, uint64_t offset, uint64_t size,
                                vk_direction direction, base_error *err) {
    VkCommandBuffer commands;
    strata_result result = vk_once_begin(v, &commands, err);
    if (result != STRATA_OK)
        return result;
    if (direction == GPU_VK_TO_HOST)
        vkCmdCopyBuffer(commands, buffer->handle, v->staging.handle, 1,
                        &(VkBufferCopy){.srcOffset = offset, .size = size});
    else
        vkCmdCopyBuffer(commands, v->staging.handle, buffer->handle, 1,
                        &(VkBufferCopy){.dstOffset = offset, .size = size});
    return vk_once_run(v, err);
}

strata_result vk_buffer_read(void *self, void *native, uint64_t offset, uint64_t size, void *data,
                             base_error *err) {
    vk *v = self;
    const vk_buffer *buffer = native;
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK && buffer->memory.map) {
        memcpy(data, buffer->memory.map + offset, size);
        return STRATA_OK;
    }
    if (result == STRATA_OK)
        result = need_staging(v, err);
    for (uint64_t done = 0; done < size && result == STRATA_OK;) {
        const uint64_t piece = size - done < STAGING_SIZE ? size - done : STAGING_SIZE;
        result = copy_piece(v, buffer, offset + done, piece, GPU_VK_TO_HOST, err);
        if (result == STRATA_OK)
            memcpy((unsigned char *)data + done, v->staging.memory.map, piece);
        done += piece;
    }
    return vk_report(v, result, err);
}

strata_result vk_buffer_write(void *self, void *native, uint64_t offset, uint64_t size,
                              const void *data, base_error *err) {
    vk *v = self;
    const vk_buffer *buffer = native;
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK && buffer->memory.map) {
        memcpy(buffer->memory.map + offset, data, size);
        return STRATA_OK;
    }
    if (result == STRATA_OK)
        result = need_staging(v, err);
    for (uint64_t done = 0; done < size && result == STRATA_OK;) {
        const uint64_t piece = size - done < STAGING_SIZE ? size - done : STAGING_SIZE;
        memcpy(v->staging.memory.map, (const unsigned char *)data + done, piece);
        result = copy_piece(v, buffer, offset + done, piece, GPU_VK_TO_DEVICE, err);
        done += piece;
    }
    return vk_report(v, result, err);
}

/* ---- images ----------------------------------------------------------------------------- */

typedef struct vk_rectangle {
    uint32_t layer, x, y, width, height;
} vk_rectangle;

/* The copies of one piece: one for each aspect, the stencil's bytes behind the depth's. */
static uint32_t piece_regions(const vk_image *image, const vk_rectangle *r,
                              VkBufferImageCopy regions[2]) {
    static const VkImageAspectFlags aspects[] = {
        VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_ASPECT_DEPTH_BIT, VK_IMAGE_ASPECT_STENCIL_BIT};
    uint32_t count = 0;
    for (size_t i = 0; i < BASE_COUNT(aspects); i++)
        if (image->aspects & aspects[i])
            regions[count++] = (VkBufferImageCopy){
                .bufferOffset =
                    aspects[i] == VK_IMAGE_ASPECT_STENCIL_BIT ? 4ull * r->width * r->height : 0,
                .imageSubresource = {aspects[i], 0, r->layer, 1},
                .imageOffset = {(int32_t)r->x, (int32_t)r->y, 0},
                .imageExtent = {r->width, r->height, 1}};
    return count;
}

static int has_stencil(const vk_image *image) {
    return (image->aspects & VK_IMAGE_ASPECT_STENCIL_BIT) != 0;
}

/* Depth with stencil on the host: a depth word, then a word with the stencil in its low byte. */
static void from_staging(const vk_image *image, const unsigned char *staging, size_t count,
                         unsigned char *texels) {
    if (!has_stencil(image)) {
        memcpy(texels, staging, count * image->texel);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const uint32_t stencil = staging[4 * count + i];
        memcpy(texels + 8 * i, staging + 4 * i, 4);
        memcpy(texels + 8 * i + 4, &stencil, 4);
    }
}

static void to_staging(const vk_image *image, unsigned char *staging, size_t count,
                       const unsigned char *texels) {
    if (!has_stencil(image)) {
        memcpy(staging, texels, count * image->texel);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t stencil;
        memcpy(staging + 4 * i, texels + 8 * i, 4);
        memcpy(&stencil, texels + 8 * i + 4, 4);
        staging[4 * count + i] = (unsigned char)stencil;
    }
}

/* One piece between image and staging buffer. */
static strata_result copy_texels(vk *v, const vk_image *image, const vk_rectangle *r,
                                 vk_direction direction, base_error *err) {
    VkBufferImageCopy regions[2];
    VkCommandBuffer commands;
    const uint32_t count = piece_regions(image, r, regions);
    strata_result result = vk_once_begin(v, &commands, err);
    if (result != STRATA_OK)
        return result;
    if (direction == GPU_VK_TO_HOST)
        vkCmdCopyImageToBuffer(commands, image->handle, VK_IMAGE_LAYOUT_GENERAL, v->staging.handle,
                               count, regions);
    else
        vkCmdCopyBufferToImage(commands, v->staging.handle, image->handle, VK_IMAGE_LAYOUT_GENERAL,
                               count, regions);
    return vk_once_run(v, err);
}

/* Rows that fit the staging buffer at a time. */
static vk_rectangle next_piece(const vk_image *image, const vk_rectangle *left) {
    const uint64_t rows = STAGING_SIZE / ((uint64_t)left->width * image->texel);
    vk_rectangle piece = *left;
    if (piece.height > rows)
        piece.height = (uint32_t)rows;
    return piece;
}

strata_result vk_image_read(void *self, void *native, uint32_t layer, void *texels, size_t size,
                            base_error *err) {
    vk *v = self;
    const vk_image *image = native;
    unsigned char *to = texels;
    vk_rectangle left = {layer, 0, 0, image->width, image->height};
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK && size != (size_t)image->texel * image->width * image->height)
        result = base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                           "vulkan: %zu bytes are not the size of one layer", size);
    if (result == STRATA_OK)
        result = need_staging(v, err);
    while (left.height && result == STRATA_OK) {
        const vk_rectangle piece = next_piece(image, &left);
        const size_t count = (size_t)piece.width * piece.height;
        result = copy_texels(v, image, &piece, GPU_VK_TO_HOST, err);
        if (result == STRATA_OK)
            from_staging(image, v->staging.memory.map, count, to);
        to += count * image->texel;
        left.y += piece.height;
        left.height -= piece.height;
    }
    return vk_report(v, result, err);
}

strata_result vk_image_write(void *self, void *native, uint32_t layer, uint32_t x, uint32_t y,
                             uint32_t width, uint32_t height, const void *texels, base_error *err) {
    vk *v = self;
    const vk_image *image = native;
    const unsigned char *from = texels;
    vk_rectangle left = {layer, x, y, width, height};
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK)
        result = need_staging(v, err);
    while (width && left.height && result == STRATA_OK) {
        const vk_rectangle piece = next_piece(image, &left);
        const size_t count = (size_t)piece.width * piece.height;
        to_staging(image, v->staging.memory.map, count, from);
        result = copy_texels(v, image, &piece, GPU_VK_TO_DEVICE, err);
        from += count * image->texel;
        left.y += piece.height;
        left.height -= piece.height;
    }
    return vk_report(v, result, err);
}
