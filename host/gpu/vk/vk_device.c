/* SPDX-License-Identifier: MIT
 *
 * The Vulkan backend as the device seam sees it: the table, opening and closing, what the device
 * can do, and how a VkResult or a validation message becomes the host's one line of error.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

/* ---- errors ----------------------------------------------------------------------------- */

typedef struct vk_code {
    VkResult code;
    strata_result result;
    const char *text;
} vk_code;

static const vk_code codes[] = {
    {VK_ERROR_OUT_OF_HOST_MEMORY, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of host memory"},
    {VK_ERROR_OUT_OF_DEVICE_MEMORY, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "out of device memory"},
    {VK_ERROR_OUT_OF_POOL_MEMORY, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "out of descriptors"},
    {VK_ERROR_FRAGMENTED_POOL, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "out of descriptors"},
    {VK_ERROR_TOO_MANY_OBJECTS, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "too many objects"},
    {VK_ERROR_MEMORY_MAP_FAILED, STRATA_ERROR_OUT_OF_HOST_MEMORY, "memory cannot be mapped"},
    {VK_ERROR_DEVICE_LOST, STRATA_ERROR_DEVICE_LOST, "device lost"},
    {VK_ERROR_INITIALIZATION_FAILED, STRATA_ERROR_UNSUPPORTED, "the driver did not start"},
    {VK_ERROR_LAYER_NOT_PRESENT, STRATA_ERROR_UNSUPPORTED, "a layer is missing"},
    {VK_ERROR_EXTENSION_NOT_PRESENT, STRATA_ERROR_UNSUPPORTED, "an extension is missing"},
    {VK_ERROR_FEATURE_NOT_PRESENT, STRATA_ERROR_UNSUPPORTED, "a feature is missing"},
    {VK_ERROR_INCOMPATIBLE_DRIVER, STRATA_ERROR_UNSUPPORTED, "no fitting driver"},
    {VK_ERROR_FORMAT_NOT_SUPPORTED, STRATA_ERROR_UNSUPPORTED, "the format is not supported"},
};

strata_result vk_fail(vk *v, VkResult code, base_error *err, const char *what) {
    const char *who = v && v->device ? "vulkan: " : ""; /* who opens a backend names it */
    if (code == VK_SUCCESS)
        return STRATA_OK;
    if (v && code == VK_ERROR_DEVICE_LOST)
        v->lost = 1;
    for (size_t i = 0; i < BASE_COUNT(codes); i++)
        if (codes[i].code == code)
            return base_fail(err, codes[i].result, "%s%.200s: %s", who, what, codes[i].text);
    return base_fail(err, STRATA_ERROR_INTERNAL, "%s%.200s: error %d", who, what, (int)code);
}

strata_result vk_report(vk *v, strata_result result, base_error *err) {
    if (!v->check)
        return result;
    char text[sizeof v->message];
    pthread_mutex_lock(&v->message_lock);
    memcpy(text, v->message, sizeof text);
    v->message[0] = 0;
    pthread_mutex_unlock(&v->message_lock);
    if (result != STRATA_OK || !text[0])
        return result;
    return base_fail(err, STRATA_ERROR_INTERNAL, "vulkan validation: %s", text);
}

strata_result vk_alive(const vk *v, base_error *err) {
    return v->lost ? base_fail(err, STRATA_ERROR_DEVICE_LOST, "vulkan: device lost") : STRATA_OK;
}

void vk_name(vk *v, VkObjectType type, uint64_t handle, const char *name) {
    const VkDebugUtilsObjectNameInfoEXT info = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT,
        .objectType = type,
        .objectHandle = handle,
        .pObjectName = name};
    if (v->set_name && name)
        v->set_name(v->device, &info);
}

/* ---- opening ---------------------------------------------------------------------------- */

static uint64_t smaller(uint64_t a, uint64_t b) {
    return a < b ? a : b;
}

/* Limits of the device, and what is needed of them later. */
static void read_limits(vk *v, gpu_backend_caps *caps, uint8_t uuid[VK_UUID_SIZE]) {
    VkPhysicalDeviceMaintenance4Properties four = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES};
    VkPhysicalDeviceMaintenance3Properties three = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES, .pNext = &four};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                       .pNext = &three};
    vkGetPhysicalDeviceProperties2(v->physical, &all);
    vkGetPhysicalDeviceMemoryProperties(v->physical, &v->memory);
    const VkPhysicalDeviceLimits *limits = &all.properties.limits;
    v->limits = *limits;
    v->allocation_limit = smaller(three.maxMemoryAllocationSize, four.maxBufferSize);
    memcpy(uuid, all.properties.pipelineCacheUUID, VK_UUID_SIZE);

    snprintf(caps->name, sizeof caps->name, "%s", all.properties.deviceName);
    vk_driver_text(v->physical, caps->driver, sizeof caps->driver);
    caps->storage_range = smaller(limits->maxStorageBufferRange, v->allocation_limit);
    caps->texels = limits->maxTexelBufferElements;
    caps->software = all.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU;
    for (uint32_t i = 0; i < v->memory.memoryHeapCount; i++)
        if ((v->memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) &&
            v->memory.memoryHeaps[i].size > caps->memory)
            caps->memory = v->memory.memoryHeaps[i].size;
    uint64_t side = smaller(limits->maxImageDimension2D, limits->maxFramebufferWidth);
    side = smaller(side, limits->maxFramebufferHeight);
    side =
        smaller(side, smaller(limits->maxViewportDimensions[0], limits->maxViewportDimensions[1]));
    caps->image_size = (uint32_t)side;
    caps->groups = (uint32_t)smaller(
        limits->maxComputeWorkGroupCount[0],
        smaller(limits->maxComputeWorkGroupCount[1], limits->maxComputeWorkGroupCount[2]));
    caps->vulkan_target = 1;
}

static void load_debug_functions(vk *v) {
    if (!v->check)
        return;
    v->begin_label = (PFN_vkCmdBeginDebugUtilsLabelEXT)vkGetInstanceProcAddr(
        v->instance, "vkCmdBeginDebugUtilsLabelEXT");
    v->end_label = (PFN_vkCmdEndDebugUtilsLabelEXT)vkGetInstanceProcAddr(
        v->instance, "vkCmdEndDebugUtilsLabelEXT");
    v->set_name = (PFN_vkSetDebugUtilsObjectNameEXT)vkGetInstanceProcAddr(
        v->instance, "vkSetDebugUtilsObjectNameEXT");
}

static VkResult create_commands(vk *v, VkCommandPool *pool, VkCommandBuffer *commands) {
    const VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                               .flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT,
                                               .queueFamilyIndex = v->family};
    VkResult code = vkCreateCommandPool(v->device, &pool_info, NULL, pool);
    if (code != VK_SUCCESS)
        return code;
    const VkCommandBufferAllocateInfo info = {.sType =
                                                  VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                              .commandPool = *pool,
                                              .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                              .commandBufferCount = 1};
    return vkAllocateCommandBuffers(v->device, &info, commands);
}

/* What every frame uses: command buffers, fence, timestamps and the one sampler. */
static strata_result create_shared(vk *v, int profile, base_error *err) {
    const VkFenceCreateInfo fence = {.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    const VkQueryPoolCreateInfo queries = {.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                           .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                           .queryCount = 2 * GPU_VK_MAX_TIMED};
    const VkSamplerCreateInfo sampler = {.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                         .magFilter = VK_FILTER_NEAREST,
                                         .minFilter = VK_FILTER_NEAREST,
                                         .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
                                         .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    VkResult code = create_commands(v, &v->frame_pool, &v->frame);
    if (code == VK_SUCCESS)
        code = create_commands(v, &v->once_pool, &v->once);
    if (code == VK_SUCCESS)
        code = vkCreateFence(v->device, &fence, NULL, &v->fence);
    if (code == VK_SUCCESS)
        code = vkCreateSampler(v->device, &sampler, NULL, &v->sampler);
    if (code == VK_SUCCESS && profile && v->timestamp_mask)
        code = vkCreateQueryPool(v->device, &queries, NULL, &v->queries);
    return vk_fail(v, code, err, "device objects");
}

strata_result vk_open(const gpu_open_info *info, void **self, gpu_backend_caps *caps,
                      base_error *err) {
    uint8_t uuid[VK_UUID_SIZE];
    vk *v = base_calloc(1, sizeof *v);
    if (!v)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
    memset(caps, 0, sizeof *caps);
    v->check = info->check != 0;
    pthread_mutex_init(&v->message_lock, NULL);
    strata_result result = vk_instance_create(v, err);
    if (result == STRATA_OK)
        result = vk_physical_choose(v, info->device, err);
    if (result == STRATA_OK)
        result = vk_device_create(v, caps, err);
    if (result == STRATA_OK) {
        read_limits(v, caps, uuid);
        load_debug_functions(v);
        result = create_shared(v, info->profile, err);
    }
    if (result == STRATA_OK)
        vk_cache_open(v, info->cache_dir, uuid);
    result = vk_report(v, result, err);
    if (result != STRATA_OK) {
        vk_close(v);
        return result;
    }
    *self = v;
    return STRATA_OK;
}

static void close_device(vk *v) {
    vkDeviceWaitIdle(v->device);
    vk_cache_close(v);
    vk_targets_forget(v, NULL);
    free(v->targets);
    vk_buffer_release(v, &v->staging);
    for (size_t i = 0; i < v->descriptor_pool_count; i++)
        vkDestroyDescriptorPool(v->device, v->descriptor_pools[i], NULL);
    free(v->descriptor_pools);
    vkDestroyQueryPool(v->device, v->queries, NULL);
    vkDestroySampler(v->device, v->sampler, NULL);
    vkDestroyFence(v->device, v->fence, NULL);
    vkDestroyCommandPool(v->device, v->once_pool, NULL);
    vkDestroyCommandPool(v->device, v->frame_pool, NULL);
    vkDestroyDevice(v->device, NULL);
}

void vk_close(void *self) {
    vk *v = self;
    if (!v)
        return;
    if (v->device)
        close_device(v);
    if (v->message[0])
        base_log(BASE_LOG_ERROR, "vulkan validation: %s", v->message);
    if (v->messenger) {
        PFN_vkDestroyDebugUtilsMessengerEXT destroy =
            (PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
                v->instance, "vkDestroyDebugUtilsMessengerEXT");
        destroy(v->instance, v->messenger, NULL);
    }
    if (v->instance)
        vkDestroyInstance(v->instance, NULL);
    pthread_mutex_destroy(&v->message_lock);
    free(v);
}

/* ---- the table -------------------------------------------------------------------------- */

static const char *no_log(void *self) {
    (void)self;
    return NULL;
}

const gpu_backend gpu_backend_vulkan = {.name = "vulkan",
                                        .open = vk_open,
                                        .close = vk_close,
                                        .enumerate = vk_enumerate,
                                        .buffer_create = vk_buffer_create,
                                        .buffer_destroy = vk_buffer_destroy,
                                        .image_create = vk_image_create,
                                        .image_destroy = vk_image_destroy,
                                        .program_create = vk_program_create,
                                        .program_destroy = vk_program_destroy,
                                        .buffer_read = vk_buffer_read,
                                        .buffer_write = vk_buffer_write,
                                        .image_read = vk_image_read,
                                        .image_write = vk_image_write,
                                        .begin = vk_begin,
                                        .pass = vk_pass,
                                        .fill = vk_fill,
                                        .copy = vk_copy,
                                        .clear_image = vk_clear_image,
                                        .submit = vk_submit,
                                        .native_handle = vk_native_handle,
                                        .get_proc = vk_get_proc,
                                        .log = no_log};
