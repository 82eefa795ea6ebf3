/* SPDX-License-Identifier: MIT
 *
 * Programs: shader modules, the one descriptor set, push constants, and pipelines. A compute
 * program has one pipeline, made with it; one that draws gets a pipeline for each combination of
 * attachment formats and blending that passes ask for. What the driver compiled is kept on disk
 * between runs.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/vk/vk_internal.h"

/* ---- creation --------------------------------------------------------------------------- */

VkDescriptorType vk_descriptor_type(gpu_binding_kind kind) {
    switch (kind) {
    case GPU_BINDING_UNIFORM:
        return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    case GPU_BINDING_SAMPLED:
        return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    case GPU_BINDING_STORAGE_IMAGE:
        return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
    case GPU_BINDING_TEXELS:
        return VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    case GPU_BINDING_ATTACHMENT:
        return VK_DESCRIPTOR_TYPE_INPUT_ATTACHMENT;
    case GPU_BINDING_STORAGE:
    case GPU_BINDING_PARAMS: /* never asked: push constants */
        break;
    }
    return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
}

static strata_result fail_count(const gpu_program_info *info, uint32_t most, const char *name,
                                base_error *err) {
    return base_fail(err, STRATA_ERROR_UNSUPPORTED,
                     "vulkan: program \"%.100s\" has more than the device's %u %s", info->label,
                     most, name);
}

static strata_result check_counts(const vk *v, const gpu_program_info *info, base_error *err) {
    uint32_t counts[GPU_BINDING_ATTACHMENT + 1] = {0};
    const struct {
        uint32_t most;
        const char *name;
    } limits[GPU_BINDING_ATTACHMENT + 1] = {
        [GPU_BINDING_UNIFORM] = {v->limits.maxPerStageDescriptorUniformBuffers, "uniform blocks"},
        [GPU_BINDING_STORAGE] = {v->limits.maxPerStageDescriptorStorageBuffers, "storage blocks"},
        [GPU_BINDING_SAMPLED] = {v->limits.maxPerStageDescriptorSamplers, "samplers"},
        [GPU_BINDING_STORAGE_IMAGE] = {v->limits.maxPerStageDescriptorStorageImages,
                                       "storage images"},
        [GPU_BINDING_TEXELS] = {v->limits.maxPerStageDescriptorSampledImages, "buffers of texels"},
        [GPU_BINDING_PARAMS] = {1, "parameter blocks"},
        [GPU_BINDING_ATTACHMENT] = {v->limits.maxPerStageDescriptorInputAttachments,
                                    "attachments that are read"}};
    for (uint32_t i = 0; i < info->binding_count; i++) {
        const gpu_binding_kind kind = info->bindings[i].kind;
        if (++counts[kind] > limits[kind].most)
            return fail_count(info, limits[kind].most, limits[kind].name, err);
    }
    const uint32_t images = v->limits.maxPerStageDescriptorSampledImages;
    if (counts[GPU_BINDING_SAMPLED] + counts[GPU_BINDING_TEXELS] > images)
        return fail_count(info, images, "samplers and buffers of texels", err);
    if (info->binding_count > GPU_VK_MAX_BINDINGS ||
        info->params_size > v->limits.maxPushConstantsSize)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED,
                         "vulkan: program \"%.100s\" has %u bindings and %u bytes of parameters",
                         info->label, info->binding_count, info->params_size);
    return STRATA_OK;
}

static VkResult create_layout(vk *v, const gpu_program_info *info, vk_program *program) {
    VkDescriptorSetLayoutBinding bindings[GPU_VK_MAX_BINDINGS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < info->binding_count; i++)
        if (info->bindings[i].kind != GPU_BINDING_PARAMS)
            bindings[count++] = (VkDescriptorSetLayoutBinding){
                .binding = info->bindings[i].binding,
                .descriptorType = vk_descriptor_type(info->bindings[i].kind),
                .descriptorCount = 1,
                .stageFlags = info->bindings[i].kind == GPU_BINDING_ATTACHMENT
                                  ? VK_SHADER_STAGE_FRAGMENT_BIT
                                  : program->stages,
                .pImmutableSamplers =
                    info->bindings[i].kind == GPU_BINDING_SAMPLED ? &v->sampler : NULL};
    const VkDescriptorSetLayoutCreateInfo set = {
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = count,
        .pBindings = bindings};
    program->binding_count = count;
    VkResult code = vkCreateDescriptorSetLayout(v->device, &set, NULL, &program->set_layout);
    if (code != VK_SUCCESS)
        return code;
    const VkPushConstantRange push = {.stageFlags = program->stages, .size = info->params_size};
    const VkPipelineLayoutCreateInfo layout = {.sType =
                                                   VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                               .setLayoutCount = 1,
                                               .pSetLayouts = &program->set_layout,
                                               .pushConstantRangeCount = info->params_size > 0,
                                               .pPushConstantRanges = &push};
    return vkCreatePipelineLayout(v->device, &layout, NULL, &program->layout);
}

static VkResult create_modules(vk *v, const gpu_program_info *info, vk_program *program) {
    VkResult code = VK_SUCCESS;
    for (int i = 0; i < 2 && code == VK_SUCCESS; i++) {
        const VkShaderModuleCreateInfo module = {.sType =
                                                     VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                                 .codeSize = info->words[i] * 4,
                                                 .pCode = info->spirv[i]};
        if (info->spirv[i])
            code = vkCreateShaderModule(v->device, &module, NULL, &program->modules[i]);
    }
    return code;
}

static VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits bit, VkShaderModule module) {
    return (VkPipelineShaderStageCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = bit,
        .module = module,
        .pName = "main"};
}

static VkResult create_compute(vk *v, vk_program *program) {
    const VkComputePipelineCreateInfo info = {
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = stage(VK_SHADER_STAGE_COMPUTE_BIT, program->modules[0]),
        .layout = program->layout};
    return vkCreateComputePipelines(v->device, v->cache, 1, &info, NULL, &program->compute);
}

strata_result vk_program_create(void *self, const gpu_program_info *info, void **native,
                                base_error *err) {
    vk *v = self;
    strata_result result = vk_alive(v, err);
    if (result == STRATA_OK)
        result = check_counts(v, info, err);
    if (result != STRATA_OK)
        return result;
    vk_program *program = base_calloc(1, sizeof *program);
    if (!program)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
    program->kind = info->kind;
    program->params_size = info->params_size;
    program->stages = info->kind == STRATA_PROGRAM_COMPUTE
                          ? VK_SHADER_STAGE_COMPUTE_BIT
                          : VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    VkResult code = create_layout(v, info, program);
    if (code == VK_SUCCESS)
        code = create_modules(v, info, program);
    if (code == VK_SUCCESS && info->kind == STRATA_PROGRAM_COMPUTE)
        code = create_compute(v, program);
    result = vk_report(v, vk_fail(v, code, err, info->label), err);
    if (result != STRATA_OK) {
        vk_program_destroy(v, program);
        return result;
    }
    *native = program;
    return STRATA_OK;
}

void vk_program_destroy(void *self, void *native) {
    vk *v = self;
    vk_program *program = native;
    if (!program)
        return;
    for (size_t i = 0; i < program->pipeline_count; i++)
        vkDestroyPipeline(v->device, program->pipelines[i].handle, NULL);
    free(program->pipelines);
    vkDestroyPipeline(v->device, program->compute, NULL);
    vkDestroyPipelineLayout(v->device, program->layout, NULL);
    vkDestroyDescriptorSetLayout(v->device, program->set_layout, NULL);
    for (int i = 0; i < 2; i++)
        vkDestroyShaderModule(v->device, program->modules[i], NULL);
    free(program);
}

/* ---- graphics pipelines ----------------------------------------------------------------- */

#define EQUATION(source, destination, operation, source_alpha, destination_alpha)                  \
    {                                                                                              \
        .blendEnable = VK_TRUE, .srcColorBlendFactor = VK_BLEND_FACTOR_##source,                   \
        .dstColorBlendFactor = VK_BLEND_FACTOR_##destination,                                      \
        .colorBlendOp = VK_BLEND_OP_##operation,                                                   \
        .srcAlphaBlendFactor = VK_BLEND_FACTOR_##source_alpha,                                     \
        .dstAlphaBlendFactor = VK_BLEND_FACTOR_##destination_alpha,                                \
        .alphaBlendOp = VK_BLEND_OP_##operation                                                    \
    }

static const VkPipelineColorBlendAttachmentState equations[] = {
    [STRATA_BLEND_NONE] = {.blendEnable = VK_FALSE},
    [STRATA_BLEND_ADD] = EQUATION(ONE, ONE, ADD, ONE, ONE),
    [STRATA_BLEND_OVER] = EQUATION(ONE, ONE_MINUS_SRC_ALPHA, ADD, ONE, ONE_MINUS_SRC_ALPHA),
    [STRATA_BLEND_UNDER] = EQUATION(ONE_MINUS_DST_ALPHA, ONE, ADD, ONE_MINUS_DST_ALPHA, ONE),
    [STRATA_BLEND_MULTIPLY] = EQUATION(DST_COLOR, ZERO, ADD, DST_ALPHA, ZERO),
    [STRATA_BLEND_MIN] = EQUATION(ONE, ONE, MIN, ONE, ONE),
    [STRATA_BLEND_MAX] = EQUATION(ONE, ONE, MAX, ONE, ONE),
    [STRATA_BLEND_FOLD] = EQUATION(ONE, SRC_ALPHA, ADD, DST_ALPHA, ZERO),
};

static vk_pipeline_key make_key(const gpu_native_pass *pass) {
    const strata_pass *p = pass->pass;
    vk_pipeline_key key;
    memset(&key, 0, sizeof key);
    key.color_count = p->color_count;
    for (uint32_t i = 0; i < p->color_count; i++) {
        key.formats[i] = ((const vk_image *)pass->color[i])->format;
        key.blends[i] = p->color[i].blend;
        key.mask_off[i] = p->color[i].mask_off & 15u;
    }
    key.reads = vk_reads(pass);
    if (pass->depth)
        key.depth_format = ((const vk_image *)pass->depth)->format;
    const vk_image *any = pass->depth ? pass->depth : pass->color[0];
    key.samples = any ? any->samples : VK_SAMPLE_COUNT_1_BIT;
    key.sample_mask = p->sample_mask ? p->sample_mask : UINT32_MAX;
    return key;
}

/* What all pipelines share. Geometry is pulled by the vertex stage, so there is no vertex input. */
static const VkPipelineVertexInputStateCreateInfo no_input = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
static const VkPipelineInputAssemblyStateCreateInfo triangles = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
    .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
static const VkPipelineViewportStateCreateInfo one_viewport = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
    .viewportCount = 1,
    .scissorCount = 1};
/* Row 0 is the lowest row of the picture, so y is not flipped against OpenGL and a triangle that is
 * counter-clockwise there is what Vulkan's formula, made for y down, calls clockwise. */
static const VkPipelineRasterizationStateCreateInfo filled = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
    .frontFace = VK_FRONT_FACE_CLOCKWISE,
    .lineWidth = 1.0f};
static const VkPipelineDepthStencilStateCreateInfo depth_stencil = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO};
static const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT,
                                                VK_DYNAMIC_STATE_SCISSOR,
                                                VK_DYNAMIC_STATE_CULL_MODE,
                                                VK_DYNAMIC_STATE_DEPTH_TEST_ENABLE,
                                                VK_DYNAMIC_STATE_DEPTH_WRITE_ENABLE,
                                                VK_DYNAMIC_STATE_DEPTH_COMPARE_OP,
                                                VK_DYNAMIC_STATE_STENCIL_TEST_ENABLE,
                                                VK_DYNAMIC_STATE_STENCIL_OP,
                                                VK_DYNAMIC_STATE_STENCIL_COMPARE_MASK,
                                                VK_DYNAMIC_STATE_STENCIL_WRITE_MASK,
                                                VK_DYNAMIC_STATE_STENCIL_REFERENCE};
static const VkPipelineDynamicStateCreateInfo dynamic = {
    .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
    .dynamicStateCount = BASE_COUNT(dynamic_states),
    .pDynamicStates = dynamic_states};

typedef struct vk_multisample {
    VkPipelineMultisampleStateCreateInfo state;
    VkPipelineSampleLocationsStateCreateInfoEXT places;
    VkSampleLocationEXT centres[VK_SAMPLE_COUNT_32_BIT];
} vk_multisample;

/* Samples lie at the pixel's centre where the device can place them, else where it likes. */
static void describe_samples(const vk *v, const vk_pipeline_key *key, vk_multisample *out) {
    const VkSampleCountFlagBits samples = (VkSampleCountFlagBits)key->samples;
    for (uint32_t i = 0; i < key->samples; i++)
        out->centres[i] = (VkSampleLocationEXT){0.5f, 0.5f};
    out->places = (VkPipelineSampleLocationsStateCreateInfoEXT){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SAMPLE_LOCATIONS_STATE_CREATE_INFO_EXT,
        .sampleLocationsEnable = VK_TRUE,
        .sampleLocationsInfo = {.sType = VK_STRUCTURE_TYPE_SAMPLE_LOCATIONS_INFO_EXT,
                                .sampleLocationsPerPixel = samples,
                                .sampleLocationGridSize = {1, 1},
                                .sampleLocationsCount = key->samples,
                                .pSampleLocations = out->centres}};
    out->state = (VkPipelineMultisampleStateCreateInfo){
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .pNext = v->placed & samples ? &out->places : NULL,
        .rasterizationSamples = samples,
        .pSampleMask = &key->sample_mask};
}

/* `ordered`: the render pass of passes that read attachments, else none. */
static VkResult create_graphics(vk *v, const vk_program *program, const vk_pipeline_key *key,
                                VkRenderPass ordered, VkPipeline *out) {
    VkPipelineColorBlendAttachmentState blends[GPU_VK_MAX_COLORS];
    VkFormat formats[GPU_VK_MAX_COLORS];
    vk_multisample multisample;
    describe_samples(v, key, &multisample);
    for (uint32_t i = 0; i < key->color_count; i++) {
        blends[i] = equations[key->blends[i]];
        blends[i].colorWriteMask = ~key->mask_off[i] & 15u;
        formats[i] = (VkFormat)key->formats[i];
    }
    const VkFormat depth = (VkFormat)key->depth_format;
    const VkPipelineRenderingCreateInfo rendering = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = key->color_count,
        .pColorAttachmentFormats = formats,
        .depthAttachmentFormat = depth,
        .stencilAttachmentFormat =
            depth == VK_FORMAT_D32_SFLOAT_S8_UINT ? depth : VK_FORMAT_UNDEFINED};
    const VkPipelineShaderStageCreateInfo stages[] = {
        stage(VK_SHADER_STAGE_VERTEX_BIT, program->modules[0]),
        stage(VK_SHADER_STAGE_FRAGMENT_BIT, program->modules[1])};
    const VkPipelineColorBlendStateCreateInfo blend = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .flags =
            ordered
                ? VK_PIPELINE_COLOR_BLEND_STATE_CREATE_RASTERIZATION_ORDER_ATTACHMENT_ACCESS_BIT_EXT
                : 0,
        .attachmentCount = key->color_count,
        .pAttachments = blends};
    const VkGraphicsPipelineCreateInfo info = {.sType =
                                                   VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                               .pNext = ordered ? NULL : &rendering,
                                               .stageCount = BASE_COUNT(stages),
                                               .pStages = stages,
                                               .pVertexInputState = &no_input,
                                               .pInputAssemblyState = &triangles,
                                               .pViewportState = &one_viewport,
                                               .pRasterizationState = &filled,
                                               .pMultisampleState = &multisample.state,
                                               .pDepthStencilState = &depth_stencil,
                                               .pColorBlendState = &blend,
                                               .pDynamicState = &dynamic,
                                               .layout = program->layout,
                                               .renderPass = ordered};
    return vkCreateGraphicsPipelines(v->device, v->cache, 1, &info, NULL, out);
}

strata_result vk_pipeline_get(vk *v, vk_program *program, const gpu_native_pass *pass,
                              VkPipeline *out, base_error *err) {
    const vk_pipeline_key key = make_key(pass);
    for (size_t i = 0; i < program->pipeline_count; i++)
        if (!memcmp(&program->pipelines[i].key, &key, sizeof key)) {
            *out = program->pipelines[i].handle;
            return STRATA_OK;
        }
    vk_pipeline *list = base_grow(program->pipelines, &program->pipeline_capacity,
                                  program->pipeline_count, sizeof *list);
    if (!list)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "vulkan: out of memory");
    program->pipelines = list;
    const vk_target *target = key.reads ? vk_target_get(v, pass, err) : NULL;
    if (key.reads && !target)
        return err->result;
    VkResult code =
        create_graphics(v, program, &key, target ? vk_target_pass(target) : VK_NULL_HANDLE, out);
    if (code != VK_SUCCESS)
        return vk_fail(v, code, err, pass->pass->label);
    list[program->pipeline_count++] = (vk_pipeline){.key = key, .handle = *out};
    return STRATA_OK;
}
