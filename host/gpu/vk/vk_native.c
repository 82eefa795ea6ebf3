/* SPDX-License-Identifier: MIT
 *
 * What a technique's own Vulkan calls work with: the handles behind the host's objects, and the
 * loader's functions. The passes that use them are recorded in vk_record.c.
 */
#include <string.h>

#include "gpu/vk/vk_internal.h"

/* Dispatchable handles are pointers, all others 64 bits wide: pointers too, or integers. */
uint64_t vk_native_handle(void *self, void *native, gpu_native_kind kind) {
    const vk *v = self;
    switch (kind) {
    case GPU_NATIVE_INSTANCE:
        return (uint64_t)(uintptr_t)v->instance;
    case GPU_NATIVE_PHYSICAL_DEVICE:
        return (uint64_t)(uintptr_t)v->physical;
    case GPU_NATIVE_DEVICE:
        return (uint64_t)(uintptr_t)v->device;
    case GPU_NATIVE_BUFFER:
        return native ? (uint64_t)((const vk_buffer *)native)->handle : 0;
    case GPU_NATIVE_IMAGE:
        return native ? (uint64_t)((const vk_image *)native)->handle : 0;
    case GPU_NATIVE_VIEW:
        return native ? (uint64_t)((const vk_image *)native)->view : 0;
    }
    return 0;
}

void *vk_get_proc(void *self, const char *name) {
    const vk *v = self;
    PFN_vkVoidFunction function = vkGetInstanceProcAddr(v->instance, name);
    void *address = NULL;
    memcpy(&address, &function, sizeof address);
    return address;
}
