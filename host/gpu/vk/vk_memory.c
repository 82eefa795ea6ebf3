/* SPDX-License-Identifier: MIT
 *
 * Device memory. Large objects get an allocation of their own; small ones share blocks of equal,
 * power-of-two slots, so that thousands of them stay far below maxMemoryAllocationCount. Buffers
 * and images never share a block, which keeps bufferImageGranularity out of the question.
 */
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

#define SMALLEST_SLOT UINT64_C(4096)
#define LARGEST_SLOT  (UINT64_C(1) << 20) /* above: a dedicated allocation */
#define LARGEST_BLOCK (UINT64_C(16) << 20)

struct vk_block {
    vk_block *next;
    VkDeviceMemory memory;
    unsigned char *map;
    VkDeviceSize slot_size;
    uint64_t used; /* bit i: slot i is taken */
    uint32_t slots, type, image;
};

/* ---- memory types ----------------------------------------------------------------------- */

#define DEVICE  VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT
#define VISIBLE (VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT)
#define CACHED  VK_MEMORY_PROPERTY_HOST_CACHED_BIT

/* First type with all of `with` and none of `without`; UINT32_MAX if there is none. */
static uint32_t find_type(const vk *v, uint32_t bits, VkMemoryPropertyFlags with,
                          VkMemoryPropertyFlags without) {
    for (uint32_t i = 0; i < v->memory.memoryTypeCount; i++) {
        VkMemoryPropertyFlags flags = v->memory.memoryTypes[i].propertyFlags;
        if (((bits >> i) & 1) && (flags & with) == with && !(flags & without))
            return i;
    }
    return UINT32_MAX;
}

/* Where the host reads device memory at full speed (software drivers, integrated chips) buffers are
 * mapped; elsewhere they live in memory that the host does not see, and are staged. */
static uint32_t choose_type(const vk *v, uint32_t bits, vk_memory_use use) {
    static const VkMemoryPropertyFlags wishes[3][4][2] = {
        [GPU_VK_BUFFER] = {{DEVICE | VISIBLE | CACHED, 0}, {DEVICE, VISIBLE}, {DEVICE, 0}, {0, 0}},
        [GPU_VK_IMAGE] = {{DEVICE, VISIBLE}, {DEVICE, 0}, {0, 0}, {0, 0}},
        [GPU_VK_STAGING] = {
            {VISIBLE | CACHED, DEVICE}, {VISIBLE | CACHED, 0}, {VISIBLE, 0}, {VISIBLE, 0}}};
    uint32_t type = UINT32_MAX;
    for (size_t i = 0; i < 4 && type == UINT32_MAX; i++)
        type = find_type(v, bits, wishes[use][i][0], wishes[use][i][1]);
    return type;
}

/* ---- allocations ------------------------------------------------------------------------ */

static strata_result allocate(vk *v, VkDeviceSize size, uint32_t type, VkDeviceMemory *memory,
                              unsigned char **map, base_error *err) {
    const VkMemoryType *info = &v->memory.memoryTypes[type];
    void *address = NULL;
    if (size > v->allocation_limit || size > v->memory.memoryHeaps[info->heapIndex].size)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                         "vulkan: %llu bytes are more than the device can allocate at once",
                         (unsigned long long)size);
    const VkMemoryAllocateInfo allocation = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                             .allocationSize = size,
                                             .memoryTypeIndex = type};
    VkResult code = vkAllocateMemory(v->device, &allocation, NULL, memory);
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, "memory");
    if ((info->propertyFlags & VISIBLE) == VISIBLE)
        code = vkMapMemory(v->device, *memory, 0, VK_WHOLE_SIZE, 0, &address);
    if (code != VK_SUCCESS) {
        vkFreeMemory(v->device, *memory, NULL);
        return vk_fail(v, code, err, "memory");
    }
    *map = address;
    return STRATA_OK;
}

static uint64_t all_slots(const vk_block *block) {
    return block->slots == 64 ? UINT64_MAX : (UINT64_C(1) << block->slots) - 1;
}

static vk_block *block_with_room(vk *v, VkDeviceSize slot, uint32_t type, uint32_t image) {
    for (vk_block *b = v->blocks; b; b = b->next)
        if (b->slot_size == slot && b->type == type && b->image == image && b->used != all_slots(b))
            return b;
    return NULL;
}

static strata_result block_create(vk *v, VkDeviceSize slot, uint32_t type, uint32_t image,
                                  vk_block **out, base_error *err) {
    vk_block *block = base_calloc(1, sizeof *block);
    if (!block)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
    block->slot_size = slot;
    block->slots = (uint32_t)(LARGEST_BLOCK / slot < 64 ? LARGEST_BLOCK / slot : 64);
    block->type = type;
    block->image = image;
    strata_result result = allocate(v, slot * block->slots, type, &block->memory, &block->map, err);
    if (result != STRATA_OK) {
        free(block);
        return result;
    }
    block->next = v->blocks;
    v->blocks = block;
    *out = block;
    return STRATA_OK;
}

strata_result vk_memory_allocate(vk *v, const VkMemoryRequirements *needs, vk_memory_use use,
                                 vk_memory *out, base_error *err) {
    const uint32_t type = choose_type(v, needs->memoryTypeBits, use);
    const uint32_t image = use == GPU_VK_IMAGE;
    VkDeviceSize slot = SMALLEST_SLOT;
    *out = (vk_memory){0};
    if (type == UINT32_MAX)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "vulkan: no fitting type of memory");
    while (slot <= LARGEST_SLOT && (slot < needs->size || slot < needs->alignment))
        slot *= 2;
    if (slot > LARGEST_SLOT)
        return allocate(v, needs->size, type, &out->memory, &out->map, err);
    vk_block *block = block_with_room(v, slot, type, image);
    if (!block) {
        strata_result result = block_create(v, slot, type, image, &block, err);
        if (result != STRATA_OK)
            return result;
    }
    while ((block->used >> out->slot) & 1)
        out->slot++;
    block->used |= UINT64_C(1) << out->slot;
    out->block = block;
    out->memory = block->memory;
    out->offset = slot * out->slot;
    out->map = block->map ? block->map + out->offset : NULL;
    return STRATA_OK;
}

void vk_memory_free(vk *v, vk_memory *memory) {
    vk_block *block = memory->block;
    if (!block) {
        vkFreeMemory(v->device, memory->memory, NULL);
    } else {
        block->used &= ~(UINT64_C(1) << memory->slot);
        if (!block->used) {
            vk_block **link = &v->blocks;
            while (*link != block)
                link = &(*link)->next;
            *link = block->next;
            vkFreeMemory(v->device, block->memory, NULL);
            free(block);
        }
    }
    *memory = (vk_memory){0};
}

/* ---- buffers ---------------------------------------------------------------------------- */

strata_result vk_buffer_init(vk *v, VkDeviceSize size, vk_memory_use use, vk_buffer *out,
                             base_error *err) {
    const VkBufferCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                 VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
                 VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
                 VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    VkMemoryRequirements needs;
    *out = (vk_buffer){.size = size};
    if (size > v->allocation_limit)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                         "vulkan: a buffer of %llu bytes is more than the device allows",
                         (unsigned long long)size);
    VkResult code = vkCreateBuffer(v->device, &info, NULL, &out->handle);
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, "buffer");
    vkGetBufferMemoryRequirements(v->device, out->handle, &needs);
    strata_result result = vk_memory_allocate(v, &needs, use, &out->memory, err);
    if (result == STRATA_OK)
        result = vk_fail(
            v, vkBindBufferMemory(v->device, out->handle, out->memory.memory, out->memory.offset),
            err, "buffer");
    if (result != STRATA_OK)
        vk_buffer_release(v, out);
    return result;
}

void vk_buffer_release(vk *v, vk_buffer *buffer) {
    vkDestroyBufferView(v->device, buffer->texels, NULL);
    vkDestroyBuffer(v->device, buffer->handle, NULL);
    vk_memory_free(v, &buffer->memory);
    *buffer = (vk_buffer){0};
}
