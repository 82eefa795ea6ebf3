/* SPDX-License-Identifier: MIT
 *
 * Buffers and images as techniques know them: created zeroed, in their one layout, with the views
 * that bindings and attachments need.
 */
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

/* ---- buffers ---------------------------------------------------------------------------- */

static strata_result fill_new(vk *v, vk_buffer *buffer, const void *data, base_error *err) {
    if (data)
        return vk_buffer_write(v, buffer, 0, buffer->size, data, err);
    if (buffer->memory.map) {
        memset(buffer->memory.map, 0, buffer->size);
        return STRATA_OK;
    }
    VkCommandBuffer commands;
    strata_result result = vk_once_begin(v, &commands, err);
    if (result != STRATA_OK)
        return result;
    vkCmdFillBuffer(commands, buffer->handle, 0, VK_WHOLE_SIZE, 0);
    return vk_once_run(v, err);
}

strata_result vk_buffer_create(void *self, const strata_buffer_desc *desc, void **native,
                               base_error *err) {
    vk *v = self;
    vk_buffer *buffer = NULL;
    strata_result result = vk_alive(v, err);
    if (result != STRATA_OK)
        return result;
    buffer = base_calloc(1, sizeof *buffer);
    if (!buffer)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
    result = vk_buffer_init(v, desc->size, GPU_VK_BUFFER, buffer, err);
    if (result == STRATA_OK) {
        vk_name(v, VK_OBJECT_TYPE_BUFFER, (uint64_t)buffer->handle, desc->label);
        result = fill_new(v, buffer, desc->data, err);
    }
    result = vk_report(v, result, err);
    if (result != STRATA_OK) {
        vk_buffer_destroy(v, buffer);
        return result;
    }
    *native = buffer;
    return STRATA_OK;
}

void vk_buffer_destroy(void *self, void *native) {
    vk_buffer *buffer = native;
    if (!buffer)
        return;
    if (buffer->handle)
        vk_buffer_release(self, buffer);
    free(buffer);
}

/* ---- images ----------------------------------------------------------------------------- */

typedef struct vk_format {
    VkFormat format;
    VkImageAspectFlags aspects;
    VkImageUsageFlags usage;
    uint32_t texel, integer;
} vk_format;

#define COLOR                                                                                      \
    (VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_INPUT_ATTACHMENT_BIT |                   \
     VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_SAMPLED_BIT)
#define DEPTH        (VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT)
#define ASPECT_COLOR VK_IMAGE_ASPECT_COLOR_BIT
#define ASPECT_DEPTH VK_IMAGE_ASPECT_DEPTH_BIT

static const vk_format formats[] = {
    [STRATA_FORMAT_RGBA32F] = {VK_FORMAT_R32G32B32A32_SFLOAT, ASPECT_COLOR, COLOR, 16, 0},
    [STRATA_FORMAT_RGBA16F] = {VK_FORMAT_R16G16B16A16_SFLOAT, ASPECT_COLOR, COLOR, 8, 0},
    [STRATA_FORMAT_RGBA8] = {VK_FORMAT_R8G8B8A8_UNORM, ASPECT_COLOR, COLOR, 4, 0},
    [STRATA_FORMAT_RGBA8_SRGB] = {VK_FORMAT_R8G8B8A8_SRGB, ASPECT_COLOR, VK_IMAGE_USAGE_SAMPLED_BIT,
                                  4, 0},
    [STRATA_FORMAT_R32F] = {VK_FORMAT_R32_SFLOAT, ASPECT_COLOR, COLOR, 4, 0},
    [STRATA_FORMAT_R32U] = {VK_FORMAT_R32_UINT, ASPECT_COLOR, COLOR, 4, 1},
    [STRATA_FORMAT_RG32U] = {VK_FORMAT_R32G32_UINT, ASPECT_COLOR, COLOR, 8, 1},
    [STRATA_FORMAT_RGBA32U] = {VK_FORMAT_R32G32B32A32_UINT, ASPECT_COLOR, COLOR, 16, 1},
    [STRATA_FORMAT_D32F] = {VK_FORMAT_D32_SFLOAT, ASPECT_DEPTH, DEPTH, 4, 0},
    [STRATA_FORMAT_D32F_S8] = {VK_FORMAT_D32_SFLOAT_S8_UINT,
                               ASPECT_DEPTH | VK_IMAGE_ASPECT_STENCIL_BIT, DEPTH, 8, 0},
};

/* Multisampled images are no storage images; of depth, they say that their samples will be placed.
 */
static VkImageCreateInfo describe(const vk *v, const vk_format *format,
                                  const strata_image_desc *desc) {
    const VkSampleCountFlagBits samples =
        desc->samples ? (VkSampleCountFlagBits)desc->samples : VK_SAMPLE_COUNT_1_BIT;
    const VkImageUsageFlags unwanted =
        samples > VK_SAMPLE_COUNT_1_BIT ? VK_IMAGE_USAGE_STORAGE_BIT : 0;
    const VkImageCreateFlags flags = (format->aspects & ASPECT_DEPTH) && (v->placed & samples)
                                         ? VK_IMAGE_CREATE_SAMPLE_LOCATIONS_COMPATIBLE_DEPTH_BIT_EXT
                                         : 0;
    return (VkImageCreateInfo){.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .flags = flags,
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = format->format,
                               .extent = {desc->width, desc->height, 1},
                               .mipLevels = 1,
                               .arrayLayers = desc->layers ? desc->layers : 1,
                               .samples = samples,
                               .tiling = VK_IMAGE_TILING_OPTIMAL,
                               .usage = (format->usage & ~unwanted) |
                                        VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                        VK_IMAGE_USAGE_TRANSFER_DST_BIT};
}

static strata_result check_support(vk *v, const VkImageCreateInfo *info, uint32_t texel,
                                   const char *label, base_error *err) {
    const VkExtent3D *size = &info->extent;
    VkImageFormatProperties most;
    VkResult code = vkGetPhysicalDeviceImageFormatProperties(
        v->physical, info->format, info->imageType, info->tiling, info->usage, info->flags, &most);
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, label);
    if (size->width > most.maxExtent.width || size->height > most.maxExtent.height ||
        info->arrayLayers > most.maxArrayLayers)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED,
                         "vulkan: image \"%.100s\": %u x %u, %u layers are more than the device's "
                         "%u x %u, %u layers",
                         label, size->width, size->height, info->arrayLayers, most.maxExtent.width,
                         most.maxExtent.height, most.maxArrayLayers);
    if (!(most.sampleCounts & info->samples))
        return base_fail(err, STRATA_ERROR_UNSUPPORTED,
                         "vulkan: image \"%.100s\": the device has no %u samples of this format",
                         label, (unsigned)info->samples);
    if ((uint64_t)size->width * size->height >
        most.maxResourceSize / texel / info->arrayLayers / (unsigned)info->samples)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                         "vulkan: image \"%.100s\" has more bytes than the device allows", label);
    return STRATA_OK;
}

static VkResult create_view(vk *v, const vk_image *image, VkImageViewType type,
                            VkImageAspectFlags aspects, VkImageView *out) {
    const VkImageViewCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
        .image = image->handle,
        .viewType = type,
        .format = image->format,
        .subresourceRange = {.aspectMask = aspects, .levelCount = 1, .layerCount = image->layers}};
    return vkCreateImageView(v->device, &info, NULL, out);
}

static strata_result create_image(vk *v, const VkImageCreateInfo *info, int array, vk_image *image,
                                  base_error *err) {
    const VkImageViewType type = array ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D;
    const VkImageAspectFlags depth = image->aspects & VK_IMAGE_ASPECT_DEPTH_BIT;
    VkMemoryRequirements needs;
    VkResult code = vkCreateImage(v->device, info, NULL, &image->handle);
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, "image");
    vkGetImageMemoryRequirements(v->device, image->handle, &needs);
    strata_result result = vk_memory_allocate(v, &needs, GPU_VK_IMAGE, &image->memory, err);
    if (result != STRATA_OK)
        return result;
    code = vkBindImageMemory(v->device, image->handle, image->memory.memory, image->memory.offset);
    if (code == VK_SUCCESS)
        code = create_view(v, image, type, depth ? depth : image->aspects, &image->view);
    if (code == VK_SUCCESS && depth && depth != image->aspects)
        code = create_view(v, image, type, image->aspects, &image->attachment);
    else
        image->attachment = image->view;
    return vk_fail(v, code, err, "image");
}

/* The one layout transition of an image's life, and its zeros. */
static strata_result clear_new(vk *v, const vk_image *image, base_error *err) {
    const VkImageSubresourceRange range = {
        .aspectMask = image->aspects, .levelCount = 1, .layerCount = image->layers};
    const VkImageMemoryBarrier2 transition = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                              .dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                              .dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT |
                                                               VK_ACCESS_2_MEMORY_WRITE_BIT,
                                              .oldLayout = VK_IMAGE_LAYOUT_UNDEFINED,
                                              .newLayout = VK_IMAGE_LAYOUT_GENERAL,
                                              .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                              .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                              .image = image->handle,
                                              .subresourceRange = range};
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                         .imageMemoryBarrierCount = 1,
                                         .pImageMemoryBarriers = &transition};
    const VkClearColorValue color = {.uint32 = {0, 0, 0, 0}};
    const VkClearDepthStencilValue depth = {0};
    VkCommandBuffer commands;
    strata_result result = vk_once_begin(v, &commands, err);
    if (result != STRATA_OK)
        return result;
    vkCmdPipelineBarrier2(commands, &dependency);
    if (image->aspects & VK_IMAGE_ASPECT_COLOR_BIT)
        vkCmdClearColorImage(commands, image->handle, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
    else
        vkCmdClearDepthStencilImage(commands, image->handle, VK_IMAGE_LAYOUT_GENERAL, &depth, 1,
                                    &range);
    return vk_once_run(v, err);
}

strata_result vk_image_create(void *self, const strata_image_desc *desc, void **native,
                              base_error *err) {
    vk *v = self;
    const char *label = desc->label ? desc->label : "image";
    strata_result result = vk_alive(v, err);
    if (result != STRATA_OK)
        return result;
    if (desc->format >= BASE_COUNT(formats) || !formats[desc->format].texel)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "vulkan: image \"%.100s\": format %u",
                         label, desc->format);
    const vk_format *format = &formats[desc->format];
    const VkImageCreateInfo info = describe(v, format, desc);
    result = check_support(v, &info, format->texel, label, err);
    if (result != STRATA_OK)
        return result;
    vk_image *image = base_calloc(1, sizeof *image);
    if (!image)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
    *image = (vk_image){.format = format->format,
                        .aspects = format->aspects,
                        .texel = format->texel,
                        .integer = format->integer,
                        .width = desc->width,
                        .height = desc->height,
                        .layers = info.arrayLayers,
                        .samples = (uint32_t)info.samples};
    result = create_image(v, &info, desc->layers > 0, image, err);
    if (result == STRATA_OK) {
        vk_name(v, VK_OBJECT_TYPE_IMAGE, (uint64_t)image->handle, label);
        result = clear_new(v, image, err);
    }
    result = vk_report(v, result, err);
    if (result != STRATA_OK) {
        vk_image_destroy(v, image);
        return result;
    }
    *native = image;
    return STRATA_OK;
}

void vk_image_destroy(void *self, void *native) {
    vk *v = self;
    vk_image *image = native;
    if (!image)
        return;
    vk_targets_forget(v, image);
    if (image->attachment != image->view)
        vkDestroyImageView(v->device, image->attachment, NULL);
    vkDestroyImageView(v->device, image->view, NULL);
    vkDestroyImage(v->device, image->handle, NULL);
    vk_memory_free(v, &image->memory);
    free(image);
}

uint32_t vk_clear_integer(float value) {
    if (!(value > 0.0f))
        return 0;
    return value >= 4294967296.0f ? UINT32_MAX : (uint32_t)value;
}

VkClearDepthStencilValue vk_clear_depth(const float value[4]) {
    return (VkClearDepthStencilValue){value[0], vk_clear_integer(value[1]) & 255u};
}

VkClearColorValue vk_clear_color(const vk_image *image, const float value[4]) {
    VkClearColorValue clear;
    for (int i = 0; i < 4; i++)
        if (image->integer)
            clear.uint32[i] = vk_clear_integer(value[i]);
        else
            clear.float32[i] = value[i];
    return clear;
}
