/* SPDX-License-Identifier: MIT
 *
 * The driver's pipeline cache on disk, one file a driver: eight bytes of hash, then the driver's
 * blob. The hash keeps a damaged file from the driver, which checks its own header for the rest.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

#define CACHE_LIMIT ((size_t)256 << 20)
#define HASH_SIZE   sizeof(uint64_t)

/* The blob that a sound file holds, from HASH_SIZE on; NULL without one. */
static unsigned char *read_blob(const char *path, size_t *size, uint64_t *hash) {
    unsigned char *data = NULL;
    if (base_file_read(path, CACHE_LIMIT, &data, size, NULL) != STRATA_OK)
        return NULL;
    if (*size > HASH_SIZE) {
        memcpy(hash, data, HASH_SIZE);
        if (*hash == base_hash(0, data + HASH_SIZE, *size - HASH_SIZE))
            return data;
    }
    free(data);
    return NULL;
}

void vk_cache_open(vk *v, const char *folder, const uint8_t uuid[VK_UUID_SIZE]) {
    unsigned char *data = NULL;
    size_t size = 0;
    if (folder) {
        int length = snprintf(v->cache_path, sizeof v->cache_path, "%s/vulkan-%016llx.cache",
                              folder, (unsigned long long)base_hash(0, uuid, VK_UUID_SIZE));
        if (length < 0 || (size_t)length >= sizeof v->cache_path)
            v->cache_path[0] = 0;
    }
    if (v->cache_path[0])
        data = read_blob(v->cache_path, &size, &v->cache_hash);
    const VkPipelineCacheCreateInfo info = {.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                            .initialDataSize = data ? size - HASH_SIZE : 0,
                                            .pInitialData = data ? data + HASH_SIZE : NULL};
    if (vkCreatePipelineCache(v->device, &info, NULL, &v->cache) != VK_SUCCESS)
        v->cache = VK_NULL_HANDLE; /* works without */
    free(data);
}

/* Writes the cache where it differs from what was read. A cache that cannot be written is no error.
 */
static void store(vk *v) {
    base_output output;
    base_error ignored = {0};
    size_t size = 0;
    uint64_t hash;
    if (vkGetPipelineCacheData(v->device, v->cache, &size, NULL) != VK_SUCCESS || !size ||
        size > CACHE_LIMIT)
        return;
    unsigned char *data = base_calloc(1, size);
    if (!data)
        return;
    if (vkGetPipelineCacheData(v->device, v->cache, &size, data) != VK_SUCCESS)
        goto done;
    hash = base_hash(0, data, size);
    if (hash == v->cache_hash)
        goto done;
    if (base_output_open(&output, v->cache_path, &ignored) != STRATA_OK)
        goto done;
    if (base_output_write(&output, &hash, HASH_SIZE, &ignored) == STRATA_OK &&
        base_output_write(&output, data, size, &ignored) == STRATA_OK)
        base_output_commit(&output, &ignored);
    else
        base_output_abort(&output);
done:
    free(data);
}

void vk_cache_close(vk *v) {
    if (v->cache && v->cache_path[0] && !v->lost)
        store(v);
    vkDestroyPipelineCache(v->device, v->cache, NULL);
    v->cache = VK_NULL_HANDLE;
}
