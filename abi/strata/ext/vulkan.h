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
 * that the pass's binds and attachments call for. It records into the VkCommandBuffer only. */
typedef void (*strata_vulkan_fn)(void *user, void *command_buffer);

typedef struct strata_ext_vulkan {
    uint32_t struct_size;
    uint32_t reserved;
    /* vkGetInstanceProcAddr and the objects of the instance; opaque Vulkan handles. */
    void *(*get_instance_proc)(void *gpu_self, const char *name);
    void *(*instance)(void *gpu_self);
    void *(*physical_device)(void *gpu_self);
    void *(*device)(void *gpu_self);
    /* VkBuffer, VkImage and VkImageView as 64-bit handles; 0 for unknown ones. All images stay in
     * VK_IMAGE_LAYOUT_GENERAL. Valid as long as the handle. */
    uint64_t (*buffer_handle)(void *gpu_self, strata_buffer buffer);
    uint64_t (*image_handle)(void *gpu_self, strata_image image);
    uint64_t (*view_handle)(void *gpu_self, strata_image image);
    /* record() only: as strata_ext_gl.pass. */
    void (*pass)(void *frame_self, const strata_pass *pass, strata_vulkan_fn record, void *user);
} strata_ext_vulkan;

#ifdef __cplusplus
}
#endif
#endif
