/* SPDX-License-Identifier: MIT
 *
 * The native extensions, strata/ext/gl.h and strata/ext/vulkan.h: constant tables, handed to the
 * techniques of a device of that kind. Their `gpu_self` and `frame_self` are the render_technique.
 */
#include "render/render.h"

#include <string.h>

#include "strata/ext/gl.h"
#include "strata/ext/vulkan.h"

static const gpu *device(void *self) {
    return ((const render_technique *)self)->session->owner->gpu;
}

static void *object(void *self, gpu_native_kind kind) {
    return (void *)(uintptr_t)gpu_native_object(device(self), kind);
}

/* A callback of either extension on its way through the device. */
typedef struct native_call {
    strata_gl_fn gl;
    strata_vulkan_fn vulkan;
    void *user;
} native_call;

static void make_call(void *user, uint64_t handle) {
    const native_call *call = user;
    if (call->gl)
        call->gl(call->user, (uint32_t)handle);
    else
        call->vulkan(call->user, (void *)(uintptr_t)handle);
}

static void native_pass(render_technique *t, const strata_pass *pass, native_call call) {
    const char *id = t->planned->technique->id;
    if (!t->recording) {
        base_fail(&t->error, STRATA_ERROR_INVALID_STATE, "%s: a native pass outside record()", id);
        base_log(BASE_LOG_ERROR, "%s", t->error.text);
        return;
    }
    gpu_pass_native(t->session->owner->gpu, id, pass, call.gl || call.vulkan ? make_call : NULL,
                    &call);
}

/* ---- strata.gl/1 ----------------------------------------------------------------------------- */

static uint32_t gl_buffer(void *self, strata_buffer handle) {
    return (uint32_t)gpu_native_buffer(device(self), handle);
}

static uint32_t gl_image(void *self, strata_image handle) {
    return (uint32_t)gpu_native_image(device(self), handle, GPU_NATIVE_IMAGE);
}

static uint32_t gl_pool(void *self, strata_pool pool, uint32_t plane) {
    return (uint32_t)gpu_native_pool(device(self), pool, plane);
}

static void gl_pass(void *self, const strata_pass *pass, strata_gl_fn record, void *user) {
    native_pass(self, pass, (native_call){.gl = record, .user = user});
}

static const strata_ext_gl table_gl = {.struct_size = sizeof table_gl,
                                       .get_proc = gpu_native_proc_gl,
                                       .buffer_name = gl_buffer,
                                       .image_name = gl_image,
                                       .pass = gl_pass,
                                       .pool_name = gl_pool};

/* ---- strata.vulkan/1 ------------------------------------------------------------------------- */

static void *vulkan_proc(void *self, const char *name) {
    return gpu_native_proc(device(self), name);
}

static void *vulkan_instance(void *self) {
    return object(self, GPU_NATIVE_INSTANCE);
}

static void *vulkan_physical_device(void *self) {
    return object(self, GPU_NATIVE_PHYSICAL_DEVICE);
}

static void *vulkan_device(void *self) {
    return object(self, GPU_NATIVE_DEVICE);
}

static uint64_t vulkan_buffer(void *self, strata_buffer handle) {
    return gpu_native_buffer(device(self), handle);
}

static uint64_t vulkan_image(void *self, strata_image handle) {
    return gpu_native_image(device(self), handle, GPU_NATIVE_IMAGE);
}

static uint64_t vulkan_view(void *self, strata_image handle) {
    return gpu_native_image(device(self), handle, GPU_NATIVE_VIEW);
}

static uint64_t vulkan_pool(void *self, strata_pool pool, uint32_t plane) {
    return gpu_native_pool(device(self), pool, plane);
}

static void vulkan_pass(void *self, const strata_pass *pass, strata_vulkan_fn record, void *user) {
    native_pass(self, pass, (native_call){.vulkan = record, .user = user});
}

static const strata_ext_vulkan table_vulkan = {.struct_size = sizeof table_vulkan,
                                               .get_instance_proc = vulkan_proc,
                                               .instance = vulkan_instance,
                                               .physical_device = vulkan_physical_device,
                                               .device = vulkan_device,
                                               .buffer_handle = vulkan_buffer,
                                               .image_handle = vulkan_image,
                                               .view_handle = vulkan_view,
                                               .pass = vulkan_pass,
                                               .pool_handle = vulkan_pool};

const void *render_extension(const gpu *g, const char *id) {
    gpu_device_info info;
    gpu_describe(g, &info);
    if (id && strcmp(id, STRATA_EXT_GL) == 0 && strcmp(info.backend, "gl") == 0)
        return &table_gl;
    if (id && strcmp(id, STRATA_EXT_VULKAN) == 0 && strcmp(info.backend, "vulkan") == 0)
        return &table_vulkan;
    return NULL;
}
