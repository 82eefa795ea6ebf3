/* SPDX-License-Identifier: MIT
 *
 * Command buffers from begun to done. There are two: `frame`, which recording fills between begin
 * and submit, and `once`, for uploads, readbacks and first clears, which runs at once. Every
 * submission is waited for, and starts and ends with a barrier that orders it among all others.
 */
#include <stdlib.h>

#include "gpu/vk/vk_internal.h"

#define SETS_PER_POOL 256u

/* ---- one submission --------------------------------------------------------------------- */

static void memory_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 stage,
                           VkAccessFlags2 access) {
    const VkMemoryBarrier2 barrier = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                      .srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                                      .srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT,
                                      .dstStageMask = stage,
                                      .dstAccessMask = access};
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                         .memoryBarrierCount = 1,
                                         .pMemoryBarriers = &barrier};
    vkCmdPipelineBarrier2(commands, &dependency);
}

void vk_full_barrier(VkCommandBuffer commands) {
    memory_barrier(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                   VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT);
}

strata_result vk_commands_begin(vk *v, VkCommandBuffer commands, base_error *err) {
    const VkCommandBufferBeginInfo info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                           .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK)
        result = vk_fail(v, vkBeginCommandBuffer(commands, &info), err, "commands");
    if (result == STRATA_OK)
        vk_full_barrier(commands);
    return result;
}

strata_result vk_commands_run(vk *v, VkCommandBuffer commands, base_error *err) {
    const VkCommandBufferSubmitInfo buffer = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                              .commandBuffer = commands};
    const VkSubmitInfo2 info = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                                .commandBufferInfoCount = 1,
                                .pCommandBufferInfos = &buffer};
    memory_barrier(commands, VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
    VkResult code = vkEndCommandBuffer(commands);
    if (code == VK_SUCCESS)
        code = vkQueueSubmit2(v->queue, 1, &info, v->fence);
    if (code == VK_SUCCESS) {
        code = vkWaitForFences(v->device, 1, &v->fence, VK_TRUE, UINT64_MAX);
        vkResetFences(v->device, 1, &v->fence);
    }
    return vk_fail(v, code, err, "submit");
}

strata_result vk_once_begin(vk *v, VkCommandBuffer *commands, base_error *err) {
    *commands = v->once;
    return vk_commands_begin(v, v->once, err);
}

strata_result vk_once_run(vk *v, base_error *err) {
    strata_result result = vk_commands_run(v, v->once, err);
    vkResetCommandPool(v->device, v->once_pool, 0);
    return result;
}

/* ---- descriptors ------------------------------------------------------------------------ */

static VkResult grow_descriptors(vk *v) {
    const VkDescriptorPoolSize sizes[] = {
        {VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, 8 * SETS_PER_POOL},
        {VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER, 4 * SETS_PER_POOL},
        {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 4 * SETS_PER_POOL},
        {VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 4 * SETS_PER_POOL},
        {VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, 4 * SETS_PER_POOL}};
    const VkDescriptorPoolCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                             .maxSets = SETS_PER_POOL,
                                             .poolSizeCount = BASE_COUNT(sizes),
                                             .pPoolSizes = sizes};
    VkDescriptorPool *pools = base_grow(v->descriptor_pools, &v->descriptor_pool_capacity,
                                        v->descriptor_pool_count, sizeof *pools);
    if (!pools)
        return VK_ERROR_OUT_OF_HOST_MEMORY;
    v->descriptor_pools = pools;
    VkResult code =
        vkCreateDescriptorPool(v->device, &info, NULL, &pools[v->descriptor_pool_count]);
    if (code == VK_SUCCESS)
        v->descriptor_pool_count++;
    return code;
}

VkDescriptorSet vk_descriptor_set(vk *v, const vk_program *program, base_error *err) {
    VkDescriptorSet set = VK_NULL_HANDLE;
    VkResult code = VK_SUCCESS;
    while (code == VK_SUCCESS) {
        if (v->descriptor_pool_current == v->descriptor_pool_count) {
            code = grow_descriptors(v);
            continue;
        }
        const VkDescriptorSetAllocateInfo info = {
            .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
            .descriptorPool = v->descriptor_pools[v->descriptor_pool_current],
            .descriptorSetCount = 1,
            .pSetLayouts = &program->set_layout};
        code = vkAllocateDescriptorSets(v->device, &info, &set);
        if (code == VK_SUCCESS)
            return set;
        if (code == VK_ERROR_OUT_OF_POOL_MEMORY || code == VK_ERROR_FRAGMENTED_POOL) {
            v->descriptor_pool_current++;
            code = VK_SUCCESS;
        }
    }
    vk_fail(v, code, err, "descriptors");
    return VK_NULL_HANDLE;
}

/* ---- the frame -------------------------------------------------------------------------- */

/* Forgets what was recorded; its descriptors and queries are free again. */
static void forget(vk *v) {
    if (v->recording) {
        vkResetCommandPool(v->device, v->frame_pool, 0);
        for (size_t i = 0; i < v->descriptor_pool_count; i++)
            vkResetDescriptorPool(v->device, v->descriptor_pools[i], 0);
    }
    v->recording = 0;
    v->timed_count = 0;
    v->descriptor_pool_current = 0;
    v->failure = (base_error){0};
}

void vk_begin(void *self) {
    forget(self);
}

VkCommandBuffer vk_frame_commands(vk *v) {
    if (v->lost || v->failure.result != STRATA_OK)
        return VK_NULL_HANDLE;
    if (v->recording)
        return v->frame;
    if (vk_commands_begin(v, v->frame, &v->failure) != STRATA_OK)
        return VK_NULL_HANDLE;
    v->recording = 1;
    if (v->queries)
        vkCmdResetQueryPool(v->frame, v->queries, 0, 2 * GPU_VK_MAX_TIMED);
    return v->frame;
}

static void read_timings(vk *v, double *ms, uint32_t count) {
    uint64_t stamps[2];
    for (uint32_t i = 0; i < v->timed_count; i++) {
        VkResult code = vkGetQueryPoolResults(v->device, v->queries, 2 * i, 2, sizeof stamps,
                                              stamps, sizeof stamps[0],
                                              VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT);
        const uint64_t ticks = (stamps[1] - stamps[0]) & v->timestamp_mask;
        if (code == VK_SUCCESS && v->timed[i] < count)
            ms[v->timed[i]] = (double)ticks * (double)v->limits.timestampPeriod * 1e-6;
    }
}

strata_result vk_submit(void *self, double *ms, uint32_t timing_count, base_error *err) {
    vk *v = self;
    for (uint32_t i = 0; i < timing_count; i++)
        ms[i] = -1.0;
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK && v->failure.result != STRATA_OK)
        result = base_fail(err, v->failure.result, "%s", v->failure.text);
    if (result == STRATA_OK && v->recording) {
        result = vk_commands_run(v, v->frame, err);
        if (result == STRATA_OK)
            read_timings(v, ms, timing_count);
    }
    forget(v);
    return vk_report(v, result, err);
}
