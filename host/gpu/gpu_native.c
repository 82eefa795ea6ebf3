/* SPDX-License-Identifier: MIT
 *
 * Handles of the backend's own API for the host's objects, and its functions: what the native
 * extensions hand out. The passes in which they are used are in gpu_pass.c.
 */
#include "gpu/gpu_internal.h"

uint64_t gpu_native_object(const gpu *g, gpu_native_kind kind) {
    return kind < GPU_NATIVE_BUFFER ? g->backend->native_handle(g->self, NULL, kind) : 0;
}

static uint64_t buffer_handle(const gpu *g, const gpu_object *object) {
    if (!object || !object->buffer.storage)
        return 0;
    return g->backend->native_handle(g->self, object->buffer.storage->native, GPU_NATIVE_BUFFER);
}

uint64_t gpu_native_buffer(const gpu *g, strata_buffer buffer) {
    gpu_code code;
    return buffer_handle(g, gpu_object_find(g, buffer.id, GPU_BUFFER, &code));
}

uint64_t gpu_native_image(const gpu *g, strata_image image, gpu_native_kind kind) {
    gpu_code code;
    const gpu_object *object = gpu_object_find(g, image.id, GPU_IMAGE, &code);
    if (!object || (kind != GPU_NATIVE_IMAGE && kind != GPU_NATIVE_VIEW))
        return 0;
    return g->backend->native_handle(g->self, object->image.storage->native, kind);
}

uint64_t gpu_native_pool(const gpu *g, strata_pool pool, uint32_t plane) {
    gpu_code code;
    const gpu_object *object = gpu_object_find(g, pool.id, GPU_POOL, &code);
    if (!object || plane > object->pool.plane_count)
        return 0;
    return buffer_handle(g, plane == object->pool.plane_count ? object->pool.counter
                                                              : object->pool.planes[plane]);
}

void *gpu_native_proc(const gpu *g, const char *name) {
    return name ? g->backend->get_proc(g->self, name) : NULL;
}

void *gpu_native_proc_gl(const char *name) {
    return name ? gpu_backend_gl.get_proc(NULL, name) : NULL;
}
