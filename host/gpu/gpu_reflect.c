/* SPDX-License-Identifier: MIT
 *
 * What a program binds, read from its SPIR-V by SPIRV-Cross: only what the entry points really use.
 * Numbers the bindings for the target (Vulkan: one sequence in set 0; OpenGL: one for each kind)
 * and has them written into the SPIR-V. One name in two stages is one resource.
 */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <string.h>

#include <spirv_cross/spirv_cross_c.h>

/* One variable of one stage, and the binding it became. */
typedef struct variable {
    uint32_t id, binding;
} variable;

typedef struct reflection_context {
    const char *label;
    int vulkan_target;
    gpu_reflection *out;
    spvc_compiler compiler;
    uint32_t stage;
    variable variables[2][GPU_MAX_BINDINGS];
    uint32_t variable_count[2], stage_index;
    base_error *err;
} reflection_context;

static strata_result fail_spvc(reflection_context *c, const char *what) {
    return base_fail(c->err, STRATA_ERROR_SHADER, "%s: reflection failed at %s", c->label, what);
}

/* ---- one resource --------------------------------------------------------------------------- */

static uint32_t storage_access(reflection_context *c, spvc_variable_id id, int is_block) {
    int readable = 1, writable = 1;
    const SpvDecoration *decorations = NULL;
    size_t count = 0;
    if (!is_block) {
        writable = !spvc_compiler_has_decoration(c->compiler, id, SpvDecorationNonWritable);
        readable = !spvc_compiler_has_decoration(c->compiler, id, SpvDecorationNonReadable);
    } else if (spvc_compiler_get_buffer_block_decorations(c->compiler, id, &decorations, &count) ==
               SPVC_SUCCESS) {
        for (size_t i = 0; i < count; i++) {
            writable &= decorations[i] != SpvDecorationNonWritable;
            readable &= decorations[i] != SpvDecorationNonReadable;
        }
    }
    return (readable ? GPU_ACCESS_STORAGE_READ : 0) | (writable ? GPU_ACCESS_STORAGE_WRITE : 0);
}

static uint32_t image_format(SpvImageFormat format) {
    switch (format) {
    case SpvImageFormatRgba32f:
        return STRATA_FORMAT_RGBA32F;
    case SpvImageFormatRgba16f:
        return STRATA_FORMAT_RGBA16F;
    case SpvImageFormatRgba8:
        return STRATA_FORMAT_RGBA8;
    case SpvImageFormatR32f:
        return STRATA_FORMAT_R32F;
    case SpvImageFormatR32ui:
        return STRATA_FORMAT_R32U;
    case SpvImageFormatRg32ui:
        return STRATA_FORMAT_RG32U;
    case SpvImageFormatRgba32ui:
        return STRATA_FORMAT_RGBA32U;
    default:
        return 0;
    }
}

static strata_result describe_image(reflection_context *c, const spvc_reflected_resource *resource,
                                    gpu_binding *binding) {
    spvc_type type = spvc_compiler_get_type_handle(c->compiler, resource->type_id);
    spvc_type sampled =
        spvc_compiler_get_type_handle(c->compiler, spvc_type_get_image_sampled_type(type));
    spvc_basetype base = sampled ? spvc_type_get_basetype(sampled) : SPVC_BASETYPE_UNKNOWN;
    if (binding->kind == GPU_BINDING_SAMPLED &&
        spvc_type_get_image_dimension(type) == SpvDimBuffer && base == SPVC_BASETYPE_UINT32 &&
        !spvc_type_get_num_array_dimensions(type)) {
        binding->kind = GPU_BINDING_TEXELS;
        return STRATA_OK;
    }
    binding->arrayed = spvc_type_get_image_arrayed(type) ? 1 : 0;
    binding->multisampled = spvc_type_get_image_multisampled(type) ? 1 : 0;
    if (spvc_type_get_num_array_dimensions(type) ||
        (binding->multisampled && (binding->arrayed || binding->kind != GPU_BINDING_SAMPLED)) ||
        spvc_type_get_image_dimension(type) != SpvDim2D || base == SPVC_BASETYPE_INT32)
        return base_fail(c->err, STRATA_ERROR_SHADER,
                         "%s: '%s' is neither a 2D image or array of floats or unsigned integers "
                         "nor a usamplerBuffer",
                         c->label, binding->name);
    binding->is_unsigned = base == SPVC_BASETYPE_UINT32;
    if (binding->kind == GPU_BINDING_STORAGE_IMAGE)
        binding->format = image_format(spvc_type_get_image_storage_format(type));
    return STRATA_OK;
}

static strata_result describe_block(reflection_context *c, const spvc_reflected_resource *resource,
                                    gpu_binding *binding) {
    spvc_type type = spvc_compiler_get_type_handle(c->compiler, resource->type_id);
    spvc_type base = spvc_compiler_get_type_handle(c->compiler, resource->base_type_id);
    size_t size = 0;
    if (spvc_type_get_num_array_dimensions(type))
        return base_fail(c->err, STRATA_ERROR_SHADER, "%s: '%s' is an array of blocks", c->label,
                         binding->name);
    if (spvc_compiler_get_declared_struct_size_runtime_array(c->compiler, base, 0, &size) !=
        SPVC_SUCCESS)
        return fail_spvc(c, binding->name);
    binding->size = (uint32_t)((size + 3) & ~(size_t)3);
    return STRATA_OK;
}

static strata_result describe(reflection_context *c, const spvc_reflected_resource *resource,
                              gpu_binding_kind kind, gpu_binding *binding) {
    const int is_image = kind == GPU_BINDING_SAMPLED || kind == GPU_BINDING_STORAGE_IMAGE ||
                         kind == GPU_BINDING_ATTACHMENT;
    const char *name = resource->name;
    if (!is_image) /* blocks are bound by the block's name, not the instance's */
        name = spvc_compiler_get_name(c->compiler, resource->base_type_id);
    *binding = (gpu_binding){.kind = kind, .stages = c->stage};
    if (!name || !name[0] || strlen(name) >= sizeof binding->name)
        return base_fail(c->err, STRATA_ERROR_SHADER, "%s: the name '%s' is empty or too long",
                         c->label, name ? name : "");
    snprintf(binding->name, sizeof binding->name, "%s", name);
    switch (kind) {
    case GPU_BINDING_UNIFORM:
    case GPU_BINDING_PARAMS:
        binding->access = GPU_ACCESS_UNIFORM;
        break;
    case GPU_BINDING_SAMPLED:
    case GPU_BINDING_TEXELS:
        binding->access = GPU_ACCESS_SAMPLED;
        break;
    case GPU_BINDING_ATTACHMENT:
        binding->access = GPU_ACCESS_COLOR_READ;
        binding->attachment = spvc_compiler_get_decoration(c->compiler, resource->id,
                                                           SpvDecorationInputAttachmentIndex);
        if (binding->attachment >= GPU_MAX_COLOR)
            return base_fail(c->err, STRATA_ERROR_SHADER, "%s: '%s' is attachment %u", c->label,
                             binding->name, binding->attachment);
        c->out->reads |= 1u << binding->attachment;
        return STRATA_OK;
    case GPU_BINDING_STORAGE:
    case GPU_BINDING_STORAGE_IMAGE:
        binding->access = storage_access(c, resource->id, kind == GPU_BINDING_STORAGE);
        break;
    }
    return is_image ? describe_image(c, resource, binding) : describe_block(c, resource, binding);
}

/* ---- merging stages ------------------------------------------------------------------------- */

static strata_result merge(reflection_context *c, const gpu_binding *found, uint32_t id) {
    gpu_reflection *out = c->out;
    uint32_t index = 0;
    while (index < out->binding_count && strcmp(out->bindings[index].name, found->name) != 0)
        index++;
    if (index == GPU_MAX_BINDINGS)
        return base_fail(c->err, STRATA_ERROR_SHADER, "%s: more than %u resources", c->label,
                         GPU_MAX_BINDINGS);
    gpu_binding *binding = &out->bindings[index];
    if (index == out->binding_count) {
        *binding = *found;
        out->binding_count++;
    } else if (binding->kind != found->kind || binding->format != found->format ||
               binding->arrayed != found->arrayed || binding->multisampled != found->multisampled ||
               binding->size != found->size || (binding->stages & found->stages)) {
        return base_fail(c->err, STRATA_ERROR_SHADER, "%s: '%s' is declared in two ways", c->label,
                         found->name);
    } else {
        binding->stages |= found->stages;
        binding->access |= found->access;
    }
    c->variables[c->stage_index][c->variable_count[c->stage_index]++] =
        (variable){.id = id, .binding = index};
    return STRATA_OK;
}

/* OpenGL has no push constants: there the params block is the uniform block of this name. */
static gpu_binding_kind block_kind(const reflection_context *c, spvc_resource_type type,
                                   const spvc_reflected_resource *resource) {
    const char *name = spvc_compiler_get_name(c->compiler, resource->base_type_id);
    if (type == SPVC_RESOURCE_TYPE_STORAGE_BUFFER)
        return GPU_BINDING_STORAGE;
    if (type == SPVC_RESOURCE_TYPE_PUSH_CONSTANT)
        return GPU_BINDING_PARAMS;
    return !c->vulkan_target && name && strcmp(name, "StrataParams") == 0 ? GPU_BINDING_PARAMS
                                                                          : GPU_BINDING_UNIFORM;
}

static strata_result reflect_type(reflection_context *c, spvc_resources resources,
                                  spvc_resource_type type) {
    const spvc_reflected_resource *list = NULL;
    size_t count = 0;
    if (spvc_resources_get_resource_list_for_type(resources, type, &list, &count) != SPVC_SUCCESS)
        return fail_spvc(c, "a resource list");
    for (size_t i = 0; i < count; i++) {
        gpu_binding binding;
        gpu_binding_kind kind = GPU_BINDING_SAMPLED;
        if (type == SPVC_RESOURCE_TYPE_STORAGE_IMAGE)
            kind = GPU_BINDING_STORAGE_IMAGE;
        else if (type == SPVC_RESOURCE_TYPE_SUBPASS_INPUT)
            kind = GPU_BINDING_ATTACHMENT;
        else if (type != SPVC_RESOURCE_TYPE_SAMPLED_IMAGE)
            kind = block_kind(c, type, &list[i]);
        strata_result result = describe(c, &list[i], kind, &binding);
        if (result == STRATA_OK)
            result = merge(c, &binding, list[i].id);
        if (result != STRATA_OK)
            return result;
    }
    return STRATA_OK;
}

/* Which colour attachments the fragment stage writes, and as what; which of them it reads too:
 * those that strata/ordered.glsl declares. */
static strata_result reflect_outputs(reflection_context *c, spvc_resources resources) {
    static const char ordered[] = "strata_ordered_";
    const spvc_reflected_resource *list = NULL;
    size_t count = 0;
    if (spvc_resources_get_resource_list_for_type(resources, SPVC_RESOURCE_TYPE_STAGE_OUTPUT, &list,
                                                  &count) != SPVC_SUCCESS)
        return fail_spvc(c, "the outputs");
    for (size_t i = 0; i < count; i++) {
        spvc_type type = spvc_compiler_get_type_handle(c->compiler, list[i].type_id);
        spvc_basetype base = spvc_type_get_basetype(type);
        uint32_t first =
            spvc_compiler_get_decoration(c->compiler, list[i].id, SpvDecorationLocation);
        if (first < GPU_MAX_COLOR && strncmp(list[i].name, ordered, sizeof ordered - 1) == 0)
            c->out->reads |= 1u << first;
        uint32_t length =
            spvc_type_get_num_array_dimensions(type) ? spvc_type_get_array_dimension(type, 0) : 1;
        for (uint32_t k = 0; k < length && k < GPU_MAX_COLOR && first + k < GPU_MAX_COLOR; k++)
            c->out->outputs[first + k] = base == SPVC_BASETYPE_FP32     ? GPU_OUTPUT_FLOAT
                                         : base == SPVC_BASETYPE_UINT32 ? GPU_OUTPUT_UINT
                                                                        : GPU_OUTPUT_NONE;
    }
    return STRATA_OK;
}

static strata_result reflect_stage(reflection_context *c, spvc_context context,
                                   const uint32_t *words, size_t count) {
    static const spvc_resource_type types[] = {
        SPVC_RESOURCE_TYPE_UNIFORM_BUFFER, SPVC_RESOURCE_TYPE_PUSH_CONSTANT,
        SPVC_RESOURCE_TYPE_STORAGE_BUFFER, SPVC_RESOURCE_TYPE_SAMPLED_IMAGE,
        SPVC_RESOURCE_TYPE_STORAGE_IMAGE,  SPVC_RESOURCE_TYPE_SUBPASS_INPUT,
    };
    spvc_parsed_ir ir;
    spvc_set active;
    spvc_resources resources;
    strata_result result = STRATA_OK;
    if (spvc_context_parse_spirv(context, words, count, &ir) != SPVC_SUCCESS ||
        spvc_context_create_compiler(context, SPVC_BACKEND_NONE, ir,
                                     SPVC_CAPTURE_MODE_TAKE_OWNERSHIP,
                                     &c->compiler) != SPVC_SUCCESS ||
        spvc_compiler_get_active_interface_variables(c->compiler, &active) != SPVC_SUCCESS ||
        spvc_compiler_create_shader_resources_for_active_variables(c->compiler, &resources,
                                                                   active) != SPVC_SUCCESS)
        return fail_spvc(c, spvc_context_get_last_error_string(context));
    for (size_t i = 0; i < BASE_COUNT(types) && result == STRATA_OK; i++)
        result = reflect_type(c, resources, types[i]);
    if (result == STRATA_OK && c->stage == GPU_STAGE_FRAGMENT)
        result = reflect_outputs(c, resources);
    return result;
}

/* ---- numbers -------------------------------------------------------------------------------- */

static void number_bindings(reflection_context *c) {
    uint32_t next[GPU_BINDING_ATTACHMENT + 1] = {0}, next_vulkan = 0;
    for (uint32_t i = 0; i < c->out->binding_count; i++) {
        gpu_binding *binding = &c->out->bindings[i];
        int is_params = binding->kind == GPU_BINDING_PARAMS;
        if (is_params)
            c->out->params_size = binding->size;
        if (c->vulkan_target)
            binding->binding = is_params ? 0 : next_vulkan++;
        else
            binding->binding = next[gpu_group(binding->kind)]++;
    }
}

static strata_result write_numbers(reflection_context *c, gpu_spirv *spirv, uint32_t stage) {
    gpu_spirv_binding list[GPU_MAX_BINDINGS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->variable_count[stage]; i++) {
        const gpu_binding *binding = &c->out->bindings[c->variables[stage][i].binding];
        if (c->vulkan_target && binding->kind == GPU_BINDING_PARAMS)
            continue; /* push constants have no binding */
        /* The compiler counts locations stage by stage; linked stages must not share one. What two
         * stages have in common gets one in each: Mesa 22.3 binds the texels of a buffer to the
         * first stage alone where they share it. */
        const int located = !c->vulkan_target && (binding->kind == GPU_BINDING_SAMPLED ||
                                                  binding->kind == GPU_BINDING_TEXELS ||
                                                  binding->kind == GPU_BINDING_STORAGE_IMAGE);
        list[count++] = (gpu_spirv_binding){.id = c->variables[stage][i].id,
                                            .number = binding->binding,
                                            .location = located ? stage * GPU_MAX_BINDINGS +
                                                                      c->variables[stage][i].binding
                                                                : GPU_NO_LOCATION};
    }
    return gpu_spirv_rewrite(&spirv->words[stage], &spirv->count[stage], list, count,
                             c->vulkan_target, c->err);
}

strata_result gpu_reflect(const char *label, uint32_t kind, int vulkan_target, gpu_spirv *spirv,
                          gpu_reflection *out, base_error *err) {
    const uint32_t stage_count = kind == STRATA_PROGRAM_COMPUTE ? 1 : 2;
    reflection_context c = {.label = label, .vulkan_target = vulkan_target, .out = out, .err = err};
    spvc_context context;
    strata_result result = STRATA_OK;
    *out = (gpu_reflection){0};
    if (spvc_context_create(&context) != SPVC_SUCCESS)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", label);
    for (uint32_t i = 0; i < stage_count && result == STRATA_OK; i++) {
        c.stage_index = i;
        c.stage = kind == STRATA_PROGRAM_COMPUTE ? GPU_STAGE_COMPUTE
                  : i == 0                       ? GPU_STAGE_VERTEX
                                                 : GPU_STAGE_FRAGMENT;
        result = reflect_stage(&c, context, spirv->words[i], spirv->count[i]);
    }
    spvc_context_destroy(context);
    if (result != STRATA_OK)
        return result;
    number_bindings(&c);
    for (uint32_t i = 0; i < stage_count && result == STRATA_OK; i++)
        result = write_numbers(&c, spirv, i);
    if (result == STRATA_OK && out->params_size > GPU_MAX_PARAMS)
        return base_fail(err, STRATA_ERROR_SHADER,
                         "%s: the params block has %u bytes, more than %u", label, out->params_size,
                         GPU_MAX_PARAMS);
    return result;
}
