/* SPDX-License-Identifier: MIT
 *
 * Recording: a validated pass becomes commands. Failures stick to v->failure, which submit returns.
 */
#include "gpu/vk/vk_internal.h"

/* ---- barriers --------------------------------------------------------------------------- */

typedef struct vk_scope {
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
} vk_scope;

static VkPipelineStageFlags2 shader_stages(uint32_t stages) {
    VkPipelineStageFlags2 flags = 0;
    if (stages & GPU_STAGE_VERTEX)
        flags |= VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT;
    if (stages & GPU_STAGE_FRAGMENT)
        flags |= VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
    if (stages & GPU_STAGE_COMPUTE)
        flags |= VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT;
    return flags;
}

static vk_scope scope_of(uint32_t access, uint32_t stages) {
    const VkPipelineStageFlags2 shaders = shader_stages(stages);
    const struct {
        uint32_t access;
        vk_scope scope;
    } rows[] = {
        {GPU_ACCESS_NATIVE,
         {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
          VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT}},
        {GPU_ACCESS_INDIRECT,
         {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT}},
        {GPU_ACCESS_INDEX, {VK_PIPELINE_STAGE_2_INDEX_INPUT_BIT, VK_ACCESS_2_INDEX_READ_BIT}},
        {GPU_ACCESS_UNIFORM, {shaders, VK_ACCESS_2_UNIFORM_READ_BIT}},
        {GPU_ACCESS_SAMPLED, {shaders, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT}},
        {GPU_ACCESS_STORAGE_READ, {shaders, VK_ACCESS_2_SHADER_STORAGE_READ_BIT}},
        {GPU_ACCESS_STORAGE_WRITE, {shaders, VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT}},
        {GPU_ACCESS_COLOR,
         {VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
          VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT}},
        {GPU_ACCESS_COLOR_READ,
         {VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT, VK_ACCESS_2_INPUT_ATTACHMENT_READ_BIT}},
        {GPU_ACCESS_DEPTH,
         {VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT |
              VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
          VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT |
              VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT}},
        {GPU_ACCESS_COPY_READ,
         {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_READ_BIT}},
        {GPU_ACCESS_COPY_WRITE,
         {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT}},
    };
    vk_scope scope = {0};
    for (size_t i = 0; i < BASE_COUNT(rows); i++)
        if (access & rows[i].access) {
            scope.stages |= rows[i].scope.stages;
            scope.access |= rows[i].scope.access;
        }
    return scope;
}

/* All barriers of a command as one global one: layouts never change, and drivers flush whole caches
 * whatever the object. */
static void record_barriers(VkCommandBuffer commands, const gpu_barrier *barriers, uint32_t count) {
    VkMemoryBarrier2 all = {.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                         .memoryBarrierCount = 1,
                                         .pMemoryBarriers = &all};
    for (uint32_t i = 0; i < count; i++) {
        const vk_scope before = scope_of(barriers[i].before, barriers[i].stages_before);
        const vk_scope after = scope_of(barriers[i].after, barriers[i].stages_after);
        if (!before.stages)
            continue;
        all.srcStageMask |= before.stages;
        all.srcAccessMask |= before.access;
        all.dstStageMask |= after.stages;
        all.dstAccessMask |= after.access;
    }
    if (all.srcStageMask)
        vkCmdPipelineBarrier2(commands, &dependency);
}

/* ---- what a pass binds ------------------------------------------------------------------ */

static VkResult texels_of(vk *v, vk_buffer *buffer) {
    const VkBufferViewCreateInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                         .buffer = buffer->handle,
                                         .format = VK_FORMAT_R32_UINT,
                                         .range = VK_WHOLE_SIZE};
    return buffer->texels ? VK_SUCCESS
                          : vkCreateBufferView(v->device, &info, NULL, &buffer->texels);
}

static strata_result bind_resources(vk *v, const vk_program *program, const gpu_native_pass *pass,
                                    VkDescriptorSet *out, base_error *err) {
    VkWriteDescriptorSet writes[GPU_VK_MAX_BINDINGS];
    VkDescriptorBufferInfo buffers[GPU_VK_MAX_BINDINGS];
    VkDescriptorImageInfo images[GPU_VK_MAX_BINDINGS];
    uint32_t count = 0;
    *out = VK_NULL_HANDLE;
    if (!program->binding_count)
        return STRATA_OK;
    *out = vk_descriptor_set(v, program, err);
    if (!*out)
        return err->result;
    for (uint32_t i = 0; i < pass->bind_count && count < GPU_VK_MAX_BINDINGS; i++) {
        const gpu_native_bind *bind = &pass->binds[i];
        VkWriteDescriptorSet *write = &writes[count];
        if (bind->binding->kind == GPU_BINDING_PARAMS)
            continue;
        *write = (VkWriteDescriptorSet){.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                        .dstSet = *out,
                                        .dstBinding = bind->binding->binding,
                                        .descriptorCount = 1,
                                        .descriptorType = vk_descriptor_type(bind->binding->kind),
                                        .pImageInfo = &images[count],
                                        .pBufferInfo = &buffers[count]};
        if (bind->binding->kind == GPU_BINDING_TEXELS) {
            vk_buffer *buffer = bind->native;
            strata_result result = vk_fail(v, texels_of(v, buffer), err, "a buffer's texels");
            if (result != STRATA_OK)
                return result;
            write->pTexelBufferView = &buffer->texels;
            count++;
            continue;
        }
        if (bind->binding->kind == GPU_BINDING_UNIFORM ||
            bind->binding->kind == GPU_BINDING_STORAGE)
            buffers[count] = (VkDescriptorBufferInfo){((const vk_buffer *)bind->native)->handle,
                                                      bind->offset, bind->size};
        else
            images[count] = (VkDescriptorImageInfo){
                VK_NULL_HANDLE, ((const vk_image *)bind->native)->view, VK_IMAGE_LAYOUT_GENERAL};
        count++;
    }
    vkUpdateDescriptorSets(v->device, count, writes, 0, NULL);
    return STRATA_OK;
}

/* Pipeline, descriptors and parameters of the pass. */
static strata_result bind_program(vk *v, VkCommandBuffer commands, const gpu_native_pass *pass,
                                  base_error *err) {
    vk_program *program = pass->program;
    const int compute = program->kind == STRATA_PROGRAM_COMPUTE;
    const VkPipelineBindPoint point =
        compute ? VK_PIPELINE_BIND_POINT_COMPUTE : VK_PIPELINE_BIND_POINT_GRAPHICS;
    VkPipeline pipeline = program->compute;
    VkDescriptorSet set;
    strata_result result = bind_resources(v, program, pass, &set, err);
    if (result == STRATA_OK && !compute)
        result = vk_pipeline_get(v, program, pass, &pipeline, err);
    if (result != STRATA_OK)
        return result;
    vkCmdBindPipeline(commands, point, pipeline);
    if (set)
        vkCmdBindDescriptorSets(commands, point, program->layout, 0, 1, &set, 0, NULL);
    if (program->params_size)
        vkCmdPushConstants(commands, program->layout, program->stages, 0, program->params_size,
                           pass->pass->params);
    return STRATA_OK;
}

/* ---- drawing ---------------------------------------------------------------------------- */

static VkCompareOp compare_op(uint32_t test) {
    static const VkCompareOp ops[] = {
        [STRATA_TEST_NONE] = VK_COMPARE_OP_ALWAYS,
        [STRATA_TEST_NEVER] = VK_COMPARE_OP_NEVER,
        [STRATA_TEST_LESS] = VK_COMPARE_OP_LESS,
        [STRATA_TEST_EQUAL] = VK_COMPARE_OP_EQUAL,
        [STRATA_TEST_LESS_EQUAL] = VK_COMPARE_OP_LESS_OR_EQUAL,
        [STRATA_TEST_GREATER] = VK_COMPARE_OP_GREATER,
        [STRATA_TEST_NOT_EQUAL] = VK_COMPARE_OP_NOT_EQUAL,
        [STRATA_TEST_GREATER_EQUAL] = VK_COMPARE_OP_GREATER_OR_EQUAL,
        [STRATA_TEST_ALWAYS] = VK_COMPARE_OP_ALWAYS,
    };
    return ops[test];
}

static VkStencilOp stencil_op(uint32_t operation) {
    static const VkStencilOp ops[] = {
        [STRATA_STENCIL_KEEP] = VK_STENCIL_OP_KEEP,
        [STRATA_STENCIL_ZERO] = VK_STENCIL_OP_ZERO,
        [STRATA_STENCIL_REPLACE] = VK_STENCIL_OP_REPLACE,
        [STRATA_STENCIL_INCREMENT] = VK_STENCIL_OP_INCREMENT_AND_CLAMP,
        [STRATA_STENCIL_DECREMENT] = VK_STENCIL_OP_DECREMENT_AND_CLAMP,
    };
    return ops[operation];
}

static void set_state(VkCommandBuffer commands, const gpu_native_pass *pass) {
    static const VkCullModeFlags culls[] = {VK_CULL_MODE_NONE, VK_CULL_MODE_BACK_BIT,
                                            VK_CULL_MODE_FRONT_BIT};
    const strata_pass *p = pass->pass;
    const VkViewport viewport = {
        .width = (float)pass->width, .height = (float)pass->height, .maxDepth = 1.0f};
    const VkRect2D scissor = {{(int32_t)pass->scissor[0], (int32_t)pass->scissor[1]},
                              {pass->scissor[2], pass->scissor[3]}};
    const VkStencilFaceFlags faces = VK_STENCIL_FACE_FRONT_AND_BACK;
    const uint32_t mask = ~p->stencil_keep_mask & 255u;
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdSetCullMode(commands, culls[p->cull]);
    vkCmdSetDepthTestEnable(commands, p->depth_test != STRATA_TEST_NONE || p->depth_write);
    vkCmdSetDepthWriteEnable(commands, p->depth_write != 0);
    vkCmdSetDepthCompareOp(commands, compare_op(p->depth_test));
    vkCmdSetStencilTestEnable(commands, p->stencil_test != STRATA_TEST_NONE);
    vkCmdSetStencilOp(commands, faces, stencil_op(p->stencil_fail), stencil_op(p->stencil_pass),
                      stencil_op(p->stencil_fail), compare_op(p->stencil_test));
    vkCmdSetStencilCompareMask(commands, faces, mask);
    vkCmdSetStencilWriteMask(commands, faces, mask);
    vkCmdSetStencilReference(commands, faces, p->stencil_reference);
}

VkAttachmentLoadOp vk_load_op(uint32_t load) {
    static const VkAttachmentLoadOp loads[] = {[STRATA_LOAD_KEEP] = VK_ATTACHMENT_LOAD_OP_LOAD,
                                               [STRATA_LOAD_CLEAR] = VK_ATTACHMENT_LOAD_OP_CLEAR,
                                               [STRATA_LOAD_DISCARD] =
                                                   VK_ATTACHMENT_LOAD_OP_DONT_CARE};
    return loads[load];
}

static VkRenderingAttachmentInfo attachment(const vk_image *image, uint32_t load) {
    return (VkRenderingAttachmentInfo){.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                       .imageView = image->attachment,
                                       .imageLayout = VK_IMAGE_LAYOUT_GENERAL,
                                       .loadOp = vk_load_op(load),
                                       .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
}

/* Loads and clears cover the whole target, whatever the scissor. */
static void begin_rendering(VkCommandBuffer commands, const gpu_native_pass *pass) {
    const strata_pass *p = pass->pass;
    VkRenderingAttachmentInfo colors[GPU_VK_MAX_COLORS], depth;
    uint32_t layers = UINT32_MAX;
    int stencil = 0;
    for (uint32_t i = 0; i < p->color_count; i++) {
        const vk_image *image = pass->color[i];
        colors[i] = attachment(image, p->color[i].load);
        colors[i].clearValue.color = vk_clear_color(image, p->color[i].clear);
        layers = image->layers < layers ? image->layers : layers;
    }
    if (pass->depth) {
        const vk_image *image = pass->depth;
        depth = attachment(image, p->depth->load);
        depth.clearValue.depthStencil = vk_clear_depth(p->depth->clear);
        stencil = (image->aspects & VK_IMAGE_ASPECT_STENCIL_BIT) != 0;
        layers = image->layers < layers ? image->layers : layers;
    }
    const VkRenderingInfo info = {.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                  .renderArea = {{0, 0}, {pass->width, pass->height}},
                                  .layerCount = layers == UINT32_MAX ? 1 : layers,
                                  .colorAttachmentCount = p->color_count,
                                  .pColorAttachments = colors,
                                  .pDepthAttachment = pass->depth ? &depth : NULL,
                                  .pStencilAttachment = stencil ? &depth : NULL};
    vkCmdBeginRendering(commands, &info);
}

static void draw_scene(vk *v, VkCommandBuffer commands, const gpu_native_pass *pass) {
    const VkBuffer draws = ((const vk_buffer *)pass->commands)->handle;
    const uint32_t stride = sizeof(VkDrawIndexedIndirectCommand);
    const uint32_t most = v->limits.maxDrawIndirectCount;
    vkCmdBindIndexBuffer(commands, ((const vk_buffer *)pass->indices)->handle, 0,
                         VK_INDEX_TYPE_UINT32);
    if (pass->counted && pass->draw_capacity > most) {
        base_fail(&v->failure, STRATA_ERROR_UNSUPPORTED,
                  "vulkan: %u counted draws are more than the device's %u", pass->draw_capacity,
                  most);
        return;
    }
    for (uint32_t first = 0; first < pass->draw_capacity;) {
        const uint32_t left = pass->draw_capacity - first, now = left < most ? left : most;
        vkCmdDrawIndexedIndirectCount(commands, draws, (VkDeviceSize)first * stride,
                                      ((const vk_buffer *)pass->count)->handle, 0, now, stride);
        first += now;
    }
}

static void draw(vk *v, VkCommandBuffer commands, const gpu_native_pass *pass) {
    const vk_target *target = NULL;
    if (vk_reads(pass)) {
        target = vk_target_get(v, pass, &v->failure);
        if (!target)
            return;
        vk_target_begin(commands, target, pass);
    } else {
        begin_rendering(commands, pass);
    }
    set_state(commands, pass);
    if (pass->commands)
        draw_scene(v, commands, pass);
    else
        vkCmdDraw(commands, 3, 1, 0, 0);
    if (target)
        vkCmdEndRenderPass(commands);
    else
        vkCmdEndRendering(commands);
}

static void dispatch(VkCommandBuffer commands, const gpu_native_pass *pass) {
    const uint32_t *groups = pass->pass->groups;
    if (pass->indirect)
        vkCmdDispatchIndirect(commands, ((const vk_buffer *)pass->indirect)->handle,
                              pass->pass->indirect_offset);
    else
        vkCmdDispatch(commands, groups[0], groups[1] ? groups[1] : 1, groups[2] ? groups[2] : 1);
}

/* ---- recording -------------------------------------------------------------------------- */

/* A timestamp between barriers. Without the one before, drivers write it while earlier work still
 * runs; without the one after, they have been seen to write it late, inside the work it precedes.
 */
static void stamp(vk *v, VkCommandBuffer commands, uint32_t query) {
    vk_full_barrier(commands);
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, v->queries, query);
    vk_full_barrier(commands);
}

void vk_pass(void *self, const gpu_native_pass *pass) {
    vk *v = self;
    const vk_program *program = pass->program;
    VkCommandBuffer commands = vk_frame_commands(v);
    if (!commands || (program && bind_program(v, commands, pass, &v->failure) != STRATA_OK))
        return;
    const VkDebugUtilsLabelEXT label = {.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT,
                                        .pLabelName = pass->pass->label};
    const int timed = pass->timed && v->queries && v->timed_count < GPU_VK_MAX_TIMED;
    if (v->begin_label)
        v->begin_label(commands, &label);
    record_barriers(commands, pass->barriers, pass->barrier_count);
    if (timed)
        stamp(v, commands, 2 * v->timed_count);
    if (!program)
        pass->call(pass->user, (uint64_t)(uintptr_t)commands);
    else if (program->kind == STRATA_PROGRAM_COMPUTE)
        dispatch(commands, pass);
    else
        draw(v, commands, pass);
    if (timed) {
        stamp(v, commands, 2 * v->timed_count + 1);
        v->timed[v->timed_count++] = pass->timed - 1;
    }
    if (v->end_label)
        v->end_label(commands);
}

void vk_fill(void *self, void *buffer, uint64_t offset, uint64_t size, uint32_t value,
             const gpu_barrier *barriers, uint32_t barrier_count) {
    VkCommandBuffer commands = vk_frame_commands(self);
    if (!commands || !size)
        return;
    record_barriers(commands, barriers, barrier_count);
    vkCmdFillBuffer(commands, ((const vk_buffer *)buffer)->handle, offset, size, value);
}

void vk_copy(void *self, void *to, uint64_t to_offset, void *from, uint64_t from_offset,
             uint64_t size, const gpu_barrier *barriers, uint32_t barrier_count) {
    const VkBufferCopy region = {.srcOffset = from_offset, .dstOffset = to_offset, .size = size};
    VkCommandBuffer commands = vk_frame_commands(self);
    if (!commands || !size)
        return;
    record_barriers(commands, barriers, barrier_count);
    vkCmdCopyBuffer(commands, ((const vk_buffer *)from)->handle, ((const vk_buffer *)to)->handle, 1,
                    &region);
}

void vk_clear_image(void *self, void *native, const float value[4], const gpu_barrier *barriers,
                    uint32_t barrier_count) {
    const vk_image *image = native;
    const VkImageSubresourceRange range = {
        .aspectMask = image->aspects, .levelCount = 1, .layerCount = image->layers};
    VkCommandBuffer commands = vk_frame_commands(self);
    if (!commands)
        return;
    record_barriers(commands, barriers, barrier_count);
    if (image->aspects & VK_IMAGE_ASPECT_COLOR_BIT) {
        const VkClearColorValue color = vk_clear_color(image, value);
        vkCmdClearColorImage(commands, image->handle, VK_IMAGE_LAYOUT_GENERAL, &color, 1, &range);
    } else {
        const VkClearDepthStencilValue depth = vk_clear_depth(value);
        vkCmdClearDepthStencilImage(commands, image->handle, VK_IMAGE_LAYOUT_GENERAL, &depth, 1,
                                    &range);
    }
}
