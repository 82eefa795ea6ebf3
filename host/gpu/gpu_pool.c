/* SPDX-License-Identifier: MIT
 *
 * Pools: planes of one capacity and a counter block {needed, capacity}. Shaders add to `needed` and
 * write below `capacity` only; after the frame the host compares the two and grows. Planes and
 * counter are ordinary buffers of the pool's scope, whose storage is exchanged when it grows.
 */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <string.h>

#define COUNTER_BYTES 8u /* uint needed, capacity */

static uint32_t widest_plane(const gpu_pool_state *pool) {
    uint32_t widest = 4;
    for (uint32_t i = 0; i < pool->plane_count; i++)
        if (pool->strides[i] > widest)
            widest = pool->strides[i];
    return widest;
}

/* Slots are counted in 32 bits, and 0xffffffff ends a list. */
static uint64_t most_elements(const gpu *g, const gpu_pool_state *pool) {
    uint64_t most = g->caps.storage_range / widest_plane(pool);
    return most < UINT32_MAX - 1 ? most : UINT32_MAX - 1;
}

static void release_planes(gpu *g, gpu_pool_state *pool) {
    for (uint32_t i = 0; i < pool->plane_count; i++) {
        gpu_storage_release(g, pool->planes[i]->buffer.storage);
        pool->planes[i]->buffer = (gpu_buffer_state){0};
    }
    pool->capacity = 0;
}

/* All planes or none. The counter learns the capacity. */
static strata_result allocate_planes(gpu *g, gpu_object *object, uint64_t capacity,
                                     base_error *err) {
    gpu_pool_state *pool = &object->pool;
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < pool->plane_count && result == STRATA_OK; i++) {
        const strata_buffer_desc desc = {.struct_size = sizeof desc,
                                         .label = pool->planes[i]->label,
                                         .size = capacity * pool->strides[i]};
        gpu_storage *storage = NULL;
        result = gpu_storage_buffer(g, object->scope->owner, &desc, &storage, err);
        pool->planes[i]->buffer =
            (gpu_buffer_state){.storage = storage, .size = storage ? desc.size : 0};
    }
    if (result == STRATA_OK) {
        const uint32_t counter[2] = {0, (uint32_t)capacity};
        gpu_storage *storage = pool->counter->buffer.storage;
        result = gpu_backend_result(
            g, err,
            g->backend->buffer_write(g->self, storage->native, 0, sizeof counter, counter, err));
        gpu_hazards_uploaded(storage);
    }
    if (result != STRATA_OK) {
        release_planes(g, pool);
        return result;
    }
    pool->capacity = capacity;
    pool->fresh = 0;
    return STRATA_OK;
}

static strata_result check_desc(gpu *g, const gpu_owner *owner, const strata_pool_desc *desc,
                                base_error *err) {
    const size_t longest = sizeof((gpu_pool_state *)0)->counter_name;
    if (!desc->label || !desc->label[0])
        return gpu_fail(g, err, GPU_ERROR_LABEL_MISSING, "%s: a pool without a label", owner->name);
    if (desc->plane_count == 0 || desc->plane_count > STRATA_MAX_PLANES)
        return gpu_fail(g, err, GPU_ERROR_POOL_PLANES, "%s: pool '%s' with %u planes", owner->name,
                        desc->label, desc->plane_count);
    if (!desc->counter_name || !desc->counter_name[0] || strlen(desc->counter_name) >= longest)
        return gpu_fail(g, err, GPU_ERROR_VALUE, "%s: pool '%s': the counter's name", owner->name,
                        desc->label);
    for (uint32_t i = 0; i < desc->plane_count; i++) {
        const char *name = desc->plane_names[i];
        if (desc->plane_strides[i] != 4 && desc->plane_strides[i] != 8)
            return gpu_fail(g, err, GPU_ERROR_POOL_PLANES, "%s: pool '%s': plane %u of stride %u",
                            owner->name, desc->label, i, desc->plane_strides[i]);
        if (!name || !name[0] || strlen(name) >= longest)
            return gpu_fail(g, err, GPU_ERROR_POOL_PLANES, "%s: pool '%s': the name of plane %u",
                            owner->name, desc->label, i);
    }
    return STRATA_OK;
}

/* The buffers' objects, as yet without planes' storage; younger than the pool's own object. */
static strata_result make_buffers(gpu *g, gpu_object *object, base_error *err) {
    gpu_pool_state *pool = &object->pool;
    char label[128];
    for (uint32_t i = 0; i < pool->plane_count; i++) {
        snprintf(label, sizeof label, "%.40s.%.20s", object->label, pool->names[i]);
        pool->planes[i] = gpu_object_new(object->scope, GPU_BUFFER, label);
        if (!pool->planes[i])
            return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", label);
    }
    snprintf(label, sizeof label, "%.40s.%.20s", object->label, pool->counter_name);
    pool->counter = gpu_object_new(object->scope, GPU_BUFFER, label);
    if (!pool->counter)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", label);
    const strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = pool->counter->label, .size = COUNTER_BYTES};
    pool->counter->buffer.size = COUNTER_BYTES;
    return gpu_storage_buffer(g, object->scope->owner, &desc, &pool->counter->buffer.storage, err);
}

/* Drops what a failed creation made; the youngest first. */
static void undo_create(gpu *g, gpu_object *object) {
    gpu_scope *scope = object->scope;
    while (scope->objects != object)
        gpu_object_drop(g, scope->objects);
    gpu_object_drop(g, object);
}

strata_result gpu_pool_create(gpu_scope *scope, const strata_pool_desc *given, strata_pool *out,
                              base_error *err) {
    gpu *g = scope->device;
    strata_pool_desc desc;
    *out = (strata_pool){0};
    strata_result result = gpu_creation(g, "a pool", err);
    if (result == STRATA_OK)
        result = gpu_take(g, err, given, &desc, sizeof desc, "strata_pool_desc");
    if (result == STRATA_OK)
        result = check_desc(g, scope->owner, &desc, err);
    if (result != STRATA_OK)
        return result;
    gpu_object *object = gpu_object_new(scope, GPU_POOL, desc.label);
    if (!object)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc.label);
    gpu_pool_state *pool = &object->pool;
    pool->plane_count = desc.plane_count;
    snprintf(pool->counter_name, sizeof pool->counter_name, "%s", desc.counter_name);
    for (uint32_t i = 0; i < desc.plane_count; i++) {
        pool->strides[i] = desc.plane_strides[i];
        snprintf(pool->names[i], sizeof pool->names[i], "%s", desc.plane_names[i]);
    }
    uint64_t capacity = desc.expected ? desc.expected : GPU_POOL_MINIMUM;
    if (capacity > most_elements(g, pool))
        capacity = most_elements(g, pool);
    result = make_buffers(g, object, err);
    if (result == STRATA_OK)
        result = allocate_planes(g, object, capacity, err);
    if (result != STRATA_OK) {
        undo_create(g, object);
        return result;
    }
    out->id = object->id;
    return STRATA_OK;
}

/* ---- what the host asks and does ------------------------------------------------------------- */

static gpu_object *find_pool(const gpu *g, strata_pool pool) {
    gpu_code code;
    return gpu_object_find(g, pool.id, GPU_POOL, &code);
}

uint64_t gpu_pool_capacity(const gpu *g, strata_pool pool) {
    const gpu_object *object = find_pool(g, pool);
    return object ? object->pool.capacity : 0;
}

uint64_t gpu_pool_limit(const gpu *g, strata_pool pool) {
    const gpu_object *object = find_pool(g, pool);
    return object ? most_elements(g, &object->pool) : 0;
}

uint64_t gpu_pool_element_bytes(const gpu *g, strata_pool pool) {
    const gpu_object *object = find_pool(g, pool);
    uint64_t sum = 0;
    for (uint32_t i = 0; object && i < object->pool.plane_count; i++)
        sum += object->pool.strides[i];
    return sum;
}

strata_buffer gpu_pool_plane(const gpu *g, strata_pool pool, uint32_t plane) {
    const gpu_object *object = find_pool(g, pool);
    if (!object || plane >= object->pool.plane_count)
        return (strata_buffer){0};
    return (strata_buffer){object->pool.planes[plane]->id};
}

strata_result gpu_pool_needed(gpu *g, strata_pool pool, uint64_t *needed, base_error *err) {
    gpu_code code;
    const gpu_object *object = gpu_object_find(g, pool.id, GPU_POOL, &code);
    uint32_t count = 0;
    *needed = 0;
    if (!object)
        return gpu_fail(g, err, code, "pool %u", pool.id);
    if (object->pool.fresh) /* no pass of this band has bound it */
        return STRATA_OK;
    const strata_buffer counter = {object->pool.counter->id};
    strata_result result = gpu_buffer_read(g, counter, 0, sizeof count, &count, err);
    *needed = count;
    return result;
}

strata_result gpu_pool_grow(gpu *g, strata_pool pool, uint64_t capacity, base_error *err) {
    gpu_code code;
    base_error ignored = {0};
    gpu_object *object = gpu_object_find(g, pool.id, GPU_POOL, &code);
    if (!object)
        return gpu_fail(g, err, code, "pool %u", pool.id);
    if (g->open)
        return gpu_fail(g, err, GPU_ERROR_STATE, "pool '%s' grows while recording", object->label);
    uint64_t most = most_elements(g, &object->pool);
    if (capacity == 0 || capacity > most)
        return gpu_fail(g, err, GPU_ERROR_BUFFER_LIMIT, "pool '%s' of %llu elements", object->label,
                        (unsigned long long)capacity);
    strata_result result = gpu_creation(g, object->label, err);
    release_planes(g, &object->pool);
    if (result == STRATA_OK)
        result = allocate_planes(g, object, capacity, err);
    if (result != STRATA_OK && !g->lost)
        allocate_planes(g, object, most < GPU_POOL_MINIMUM ? most : GPU_POOL_MINIMUM, &ignored);
    return result;
}

/* ---- frames --------------------------------------------------------------------------------- */

void gpu_pools_begin(gpu *g) {
    for (size_t i = 0; i < g->slot_count; i++)
        if (g->slots[i].object && g->slots[i].object->kind == GPU_POOL)
            g->slots[i].object->pool.fresh = 1;
}

void gpu_pool_refresh(gpu *g, gpu_object *object) {
    gpu_pool_state *pool = &object->pool;
    gpu_barrier barriers[GPU_MAX_USES];
    gpu_uses uses = {0};
    if (!pool->fresh)
        return;
    pool->fresh = 0;
    gpu_storage *storage = pool->counter->buffer.storage;
    gpu_uses_add(&uses, storage, GPU_ACCESS_COPY_WRITE, 0);
    uint32_t count = gpu_hazards_derive(&uses, barriers);
    gpu_open_commands(g);
    g->backend->fill(g->self, storage->native, 0, 4, 0, barriers, count);
}
