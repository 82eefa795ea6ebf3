/* SPDX-License-Identifier: MIT
 *
 * strata/ext/vulkan.h - extension "strata.vulkan/1": native Vulkan objects for a technique that
 * needs what the passes of gpu.h cannot say. Absent (NULL) on other backends; keep a portable path
 * beside it. Handles cross as integers and pointers, so this header needs no Vulkan header.
 */
#ifndef STRATA_EXT_VULKAN_H
#define STRATA_EXT_VULKAN_H

#include "../frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define STRATA_EXT_VULKAN "strata.vulkan/1"

/* Called by the host while it records the declared pass, outside a rendering scope, after the barriers
 * that the pass's binds and attachments call for. It records into the VkCommandBuffer only, makes the
 * barriers between its own commands itself, ends what rendering it begins, and keeps what it draws
 * inside the band's rectangle. What it binds and sets need not be put back. */
typedef void (*strata_vulkan_fn)(void *user, void *command_buffer);

typedef struct strata_ext_vulkan {
    uint32_t struct_size;
    uint32_t reserved;
    /* vkGetInstanceProcAddr and the objects of the instance; opaque Vulkan handles (Vulkan 1.3).
     * From create() on. `gpu_self` is strata_gpu.self throughout. */
    void *(*get_instance_proc)(void *gpu_self, const char *name);
    void *(*instance)(void *gpu_self);
    void *(*physical_device)(void *gpu_self);
    void *(*device)(void *gpu_self);
    /* VkBuffer, VkImage and VkImageView as 64-bit handles; 0 for unknown ones. All images stay in
     * VK_IMAGE_LAYOUT_GENERAL. Valid as long as the handle. Buffers can be storage, uniform, index
     * and indirect buffers and both ends of transfers; images sampled, both ends of transfers,
     * attachments, and storage where their format allows. The view has all layers; of a depth image,
     * the depth aspect. */
    uint64_t (*buffer_handle)(void *gpu_self, strata_buffer buffer);
    uint64_t (*image_handle)(void *gpu_self, strata_image image);
    uint64_t (*view_handle)(void *gpu_self, strata_image image);
    /* record() only: as strata_ext_gl.pass. */
    void (*pass)(void *frame_self, const strata_pass *pass, strata_vulkan_fn record, void *user);
    /* VkBuffer of plane number `plane` of a pool: as strata_ext_gl.pool_name. */
    uint64_t (*pool_handle)(void *gpu_self, strata_pool pool, uint32_t plane);
} strata_ext_vulkan;

#ifdef __cplusplus
}
#endif
#endif
