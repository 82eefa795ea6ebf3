/* SPDX-License-Identifier: MIT
 *
 * Barriers, derived from what passes do to objects: read after write, write after read, write after
 * write. One storage remembers its last write, the reads since, and where the write is visible
 * already, so that a second reader of the same kind waits for nothing.
 */
#include "gpu/gpu_internal.h"

#define SHADER_ACCESS                                                                              \
    (GPU_ACCESS_UNIFORM | GPU_ACCESS_SAMPLED | GPU_ACCESS_STORAGE_READ | GPU_ACCESS_STORAGE_WRITE)

void gpu_uses_add(gpu_uses *uses, gpu_storage *storage, uint32_t access, uint32_t stages) {
    for (uint32_t i = 0; i < uses->count; i++) {
        if (uses->items[i].storage == storage) {
            uses->items[i].access |= access;
            uses->items[i].stages |= stages;
            return;
        }
    }
    if (uses->count < GPU_MAX_USES)
        uses->items[uses->count++] =
            (gpu_use){.storage = storage, .access = access, .stages = stages};
}

void gpu_hazards_uploaded(gpu_storage *storage) {
    storage->write_access = GPU_ACCESS_COPY_WRITE;
    storage->write_stages = 0;
    storage->read_access = storage->read_stages = 0;
    for (int i = 0; i < 4; i++)
        storage->seen[i] = 0;
}

/* Whether the last write is visible to all of this access already. */
static int is_visible(const gpu_storage *storage, uint32_t access, uint32_t stages) {
    uint32_t fixed = access & ~SHADER_ACCESS, shader = access & SHADER_ACCESS;
    if (fixed & ~storage->seen[0])
        return 0;
    for (uint32_t i = 0; i < 3; i++)
        if ((stages >> i & 1u) && (shader & ~storage->seen[i + 1]))
            return 0;
    return 1;
}

static void mark_visible(gpu_storage *storage, uint32_t access, uint32_t stages) {
    storage->seen[0] |= access & ~SHADER_ACCESS;
    for (uint32_t i = 0; i < 3; i++)
        if (stages >> i & 1u)
            storage->seen[i + 1] |= access & SHADER_ACCESS;
}

static int derive_one(const gpu_use *use, gpu_barrier *barrier) {
    gpu_storage *storage = use->storage;
    uint32_t writes = use->access & GPU_ACCESS_WRITES;
    *barrier = (gpu_barrier){.native = storage->native,
                             .is_image = storage->is_image,
                             .before = storage->write_access,
                             .stages_before = storage->write_stages,
                             .after = use->access,
                             .stages_after = use->stages};
    if (writes) {
        barrier->before |= storage->read_access;
        barrier->stages_before |= storage->read_stages;
        storage->write_access = use->access; /* reads of this pass are behind its writes */
        storage->write_stages = use->stages;
        storage->read_access = storage->read_stages = 0;
        for (int i = 0; i < 4; i++)
            storage->seen[i] = 0;
        return 1; /* new storage too was written: with zeros */
    }
    storage->read_access |= use->access;
    storage->read_stages |= use->stages;
    if (!storage->write_access || is_visible(storage, use->access, use->stages))
        return 0;
    mark_visible(storage, use->access, use->stages);
    return 1;
}

uint32_t gpu_hazards_derive(const gpu_uses *uses, gpu_barrier *barriers) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < uses->count; i++)
        count += (uint32_t)derive_one(&uses->items[i], &barriers[count]);
    return count;
}
