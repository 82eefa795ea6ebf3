/* SPDX-License-Identifier: MIT
 *
 * The logical device: which features and extensions are asked of it, which of them a device must
 * have to be used at all, and what the rest turn into as facts for techniques.
 */
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

/* Every feature struct of the device, chained; used once to ask and once to enable. */
typedef struct vk_features {
    VkPhysicalDeviceFeatures2 core;
    VkPhysicalDeviceVulkan11Features v11;
    VkPhysicalDeviceVulkan12Features v12;
    VkPhysicalDeviceVulkan13Features v13;
    VkPhysicalDeviceFragmentShaderInterlockFeaturesEXT interlock;
    VkPhysicalDeviceRasterizationOrderAttachmentAccessFeaturesEXT raster_order;
} vk_features;

typedef struct vk_optional { /* extensions that the device has */
    int interlock, raster_order, stencil_export, sample_locations;
} vk_optional;

static void chain(vk_features *f, const vk_optional *has) {
    memset(f, 0, sizeof *f);
    f->core.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
    f->v11.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES;
    f->v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
    f->v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
    f->interlock.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FRAGMENT_SHADER_INTERLOCK_FEATURES_EXT;
    f->raster_order.sType =
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_FEATURES_EXT;
    f->core.pNext = &f->v11;
    f->v11.pNext = &f->v12;
    f->v12.pNext = &f->v13;
    void **tail = &f->v13.pNext;
    if (has->interlock) {
        *tail = &f->interlock;
        tail = &f->interlock.pNext;
    }
    if (has->raster_order)
        *tail = &f->raster_order;
}

static strata_result find_extensions(const vk *v, vk_optional *has, base_error *err) {
    uint32_t count = 0;
    VkExtensionProperties *list = NULL;
    memset(has, 0, sizeof *has);
    if (vkEnumerateDeviceExtensionProperties(v->physical, NULL, &count, NULL) != VK_SUCCESS ||
        !count)
        return STRATA_OK;
    list = base_calloc(count, sizeof *list);
    if (!list)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    if (vkEnumerateDeviceExtensionProperties(v->physical, NULL, &count, list) < VK_SUCCESS)
        count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const char *name = list[i].extensionName;
        has->interlock |= !strcmp(name, VK_EXT_FRAGMENT_SHADER_INTERLOCK_EXTENSION_NAME);
        has->stencil_export |= !strcmp(name, VK_EXT_SHADER_STENCIL_EXPORT_EXTENSION_NAME);
        has->sample_locations |= !strcmp(name, VK_EXT_SAMPLE_LOCATIONS_EXTENSION_NAME);
        has->raster_order |=
            !strcmp(name, VK_EXT_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXTENSION_NAME);
    }
    free(list);
    return STRATA_OK;
}

typedef struct vk_need {
    const char *name;
    VkBool32 has;
    VkBool32 *enable;
} vk_need;

/* Enables what every shader and pass may rely on; names the first that is missing. */
static strata_result enable_required(const vk_features *has, vk_features *f, base_error *err) {
    const VkPhysicalDeviceFeatures *a = &has->core.features;
    VkPhysicalDeviceFeatures *b = &f->core.features;
    const vk_need needs[] = {
        {"robustBufferAccess", a->robustBufferAccess, &b->robustBufferAccess},
        {"independentBlend", a->independentBlend, &b->independentBlend},
        {"multiDrawIndirect", a->multiDrawIndirect, &b->multiDrawIndirect},
        {"drawIndirectFirstInstance", a->drawIndirectFirstInstance, &b->drawIndirectFirstInstance},
        {"fragmentStoresAndAtomics", a->fragmentStoresAndAtomics, &b->fragmentStoresAndAtomics},
        {"geometryShader (for gl_PrimitiveID)", a->geometryShader, &b->geometryShader},
        {"shaderStorageImageExtendedFormats", a->shaderStorageImageExtendedFormats,
         &b->shaderStorageImageExtendedFormats},
        {"drawIndirectCount", has->v12.drawIndirectCount, &f->v12.drawIndirectCount},
        {"dynamicRendering", has->v13.dynamicRendering, &f->v13.dynamicRendering},
        {"synchronization2", has->v13.synchronization2, &f->v13.synchronization2},
        {"maintenance4", has->v13.maintenance4, &f->v13.maintenance4},
    };
    for (size_t i = 0; i < BASE_COUNT(needs); i++) {
        if (!needs[i].has)
            return base_fail(err, STRATA_ERROR_UNSUPPORTED, "the device lacks the feature %s",
                             needs[i].name);
        *needs[i].enable = VK_TRUE;
    }
    return STRATA_OK;
}

static void enable_optional(const vk_features *has, vk_features *f) {
    const VkPhysicalDeviceFeatures *a = &has->core.features;
    VkPhysicalDeviceFeatures *b = &f->core.features;
    b->vertexPipelineStoresAndAtomics = a->vertexPipelineStoresAndAtomics;
    b->shaderStorageImageWriteWithoutFormat = a->shaderStorageImageWriteWithoutFormat;
    b->shaderInt64 = a->shaderInt64;
    b->shaderFloat64 = a->shaderFloat64;
    b->fullDrawIndexUint32 = a->fullDrawIndexUint32;
    b->shaderClipDistance = a->shaderClipDistance;
    f->v11.shaderDrawParameters = has->v11.shaderDrawParameters;
    f->v12.shaderOutputLayer = has->v12.shaderOutputLayer;
    f->v12.scalarBlockLayout = has->v12.scalarBlockLayout;
    f->v12.shaderBufferInt64Atomics = a->shaderInt64 && has->v12.shaderBufferInt64Atomics;
    f->v13.shaderDemoteToHelperInvocation = has->v13.shaderDemoteToHelperInvocation;
    f->v13.shaderTerminateInvocation = has->v13.shaderTerminateInvocation;
    f->interlock.fragmentShaderPixelInterlock = has->interlock.fragmentShaderPixelInterlock;
    f->raster_order.rasterizationOrderColorAttachmentAccess =
        has->raster_order.rasterizationOrderColorAttachmentAccess;
}

/* How many samples an image can have, in a mask's 32 bits; which numbers of them can be placed. */
static void find_samples(vk *v, const vk_optional *has, gpu_backend_caps *caps) {
    VkPhysicalDeviceSampleLocationsPropertiesEXT locations = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SAMPLE_LOCATIONS_PROPERTIES_EXT};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                       .pNext = has->sample_locations ? &locations : NULL};
    vkGetPhysicalDeviceProperties2(v->physical, &all);
    const VkPhysicalDeviceLimits *l = &all.properties.limits;
    const VkSampleCountFlags any =
        l->framebufferColorSampleCounts & l->framebufferDepthSampleCounts &
        l->framebufferStencilSampleCounts & l->sampledImageColorSampleCounts &
        l->sampledImageDepthSampleCounts;
    v->placed = locations.sampleLocationSampleCounts & ~(VkFlags)VK_SAMPLE_COUNT_1_BIT;
    caps->samples = VK_SAMPLE_COUNT_32_BIT;
    while (caps->samples > VK_SAMPLE_COUNT_1_BIT && !(any & caps->samples))
        caps->samples >>= 1;
}

static void fill_caps(const vk *v, const vk_features *f, const vk_optional *has,
                      gpu_backend_caps *caps) {
    VkPhysicalDeviceSubgroupProperties subgroup = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 all = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2,
                                       .pNext = &subgroup};
    vkGetPhysicalDeviceProperties2(v->physical, &all);
    const VkShaderStageFlags stages = VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    caps->storage_blocks = all.properties.limits.maxPerStageDescriptorStorageBuffers;
    caps->subgroup = subgroup.subgroupSize;
    caps->subgroup_ballot = (subgroup.supportedOperations & VK_SUBGROUP_FEATURE_BALLOT_BIT) &&
                            (subgroup.supportedStages & stages) == stages;
    caps->int64 = f->core.features.shaderInt64;
    caps->int64_atomics = f->v12.shaderBufferInt64Atomics;
    caps->fragment_interlock = f->interlock.fragmentShaderPixelInterlock;
    caps->raster_order_attachments = f->raster_order.rasterizationOrderColorAttachmentAccess;
    caps->stencil_export = has->stencil_export != 0;
}

/* A queue that draws and computes; its timestamps, if any. */
static strata_result find_queue(vk *v, base_error *err) {
    VkQueueFamilyProperties families[16];
    uint32_t count = BASE_COUNT(families);
    const VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
    vkGetPhysicalDeviceQueueFamilyProperties(v->physical, &count, families);
    for (uint32_t i = 0; i < count; i++)
        if ((families[i].queueFlags & wanted) == wanted) {
            uint32_t bits = families[i].timestampValidBits;
            v->family = i;
            v->timestamp_mask = bits >= 64 ? UINT64_MAX : (UINT64_C(1) << bits) - 1;
            return STRATA_OK;
        }
    return base_fail(err, STRATA_ERROR_UNSUPPORTED,
                     "the device has no queue for both graphics and compute");
}

strata_result vk_device_create(vk *v, gpu_backend_caps *caps, base_error *err) {
    vk_features has, use;
    vk_optional optional;
    const char *extensions[4];
    uint32_t extension_count = 0;
    const float priority = 1.0f;
    strata_result result = find_queue(v, err);
    if (result == STRATA_OK)
        result = find_extensions(v, &optional, err);
    if (result != STRATA_OK)
        return result;
    chain(&has, &optional);
    vkGetPhysicalDeviceFeatures2(v->physical, &has.core);
    chain(&use, &optional);
    result = enable_required(&has, &use, err);
    if (result != STRATA_OK)
        return result;
    enable_optional(&has, &use);
    if (optional.interlock)
        extensions[extension_count++] = VK_EXT_FRAGMENT_SHADER_INTERLOCK_EXTENSION_NAME;
    if (optional.raster_order)
        extensions[extension_count++] = VK_EXT_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_EXTENSION_NAME;
    if (optional.stencil_export)
        extensions[extension_count++] = VK_EXT_SHADER_STENCIL_EXPORT_EXTENSION_NAME;
    if (optional.sample_locations)
        extensions[extension_count++] = VK_EXT_SAMPLE_LOCATIONS_EXTENSION_NAME;
    const VkDeviceQueueCreateInfo queue = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                           .queueFamilyIndex = v->family,
                                           .queueCount = 1,
                                           .pQueuePriorities = &priority};
    const VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                     .pNext = &use.core,
                                     .queueCreateInfoCount = 1,
                                     .pQueueCreateInfos = &queue,
                                     .enabledExtensionCount = extension_count,
                                     .ppEnabledExtensionNames = extensions};
    VkResult code = vkCreateDevice(v->physical, &info, NULL, &v->device);
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, "device");
    vkGetDeviceQueue(v->device, v->family, 0, &v->queue);
    fill_caps(v, &use, &optional, caps);
    find_samples(v, &optional, caps);
    return STRATA_OK;
}
