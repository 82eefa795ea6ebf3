/* SPDX-License-Identifier: MIT
 *
 * The transfer in Vulkan, through strata.vulkan/1 alone: device functions come from the device's
 * own vkGetDeviceProcAddr.
 */
#define VK_NO_PROTOTYPES
#include <string.h>
#include <vulkan/vulkan.h>

#include "native.h"

static PFN_vkVoidFunction find(const native *n, const char *name) {
    void *address = n->vulkan->get_instance_proc(n->gpu->self, "vkGetDeviceProcAddr");
    PFN_vkGetDeviceProcAddr of_device;
    memcpy(&of_device, &address, sizeof of_device);
    return of_device((VkDevice)n->vulkan->device(n->gpu->self), name);
}

static void transfer(void *user, void *command_buffer) {
    const native *n = user;
    const VkCommandBuffer commands = (VkCommandBuffer)command_buffer;
    const VkBuffer source = (VkBuffer)n->vulkan->buffer_handle(n->gpu->self, n->source),
                   target = (VkBuffer)n->vulkan->buffer_handle(n->gpu->self, n->target),
                   plane = (VkBuffer)n->vulkan->pool_handle(n->gpu->self, n->pool, 0);
    const VkBufferCopy half = {.size = n->bytes / 2};
    PFN_vkCmdCopyBuffer copy = (PFN_vkCmdCopyBuffer)find(n, "vkCmdCopyBuffer");
    PFN_vkCmdFillBuffer fill = (PFN_vkCmdFillBuffer)find(n, "vkCmdFillBuffer");
    copy(commands, source, target, 1, &half);
    fill(commands, target, half.size, half.size, NATIVE_QUARTER);
    fill(commands, plane, 0, 256, NATIVE_POOL);
    if (n->mistake)
        fill(commands, plane, 2, 4, 0); /* not a multiple of 4: the validation layers object */
}

void native_pass_vulkan(native *n, void *frame_self, const strata_pass *pass) {
    n->vulkan->pass(frame_self, pass, transfer, n);
}
