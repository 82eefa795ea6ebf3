/* SPDX-License-Identifier: MIT
 *
 * Programs: the text is expanded when a program is created, compiled then or (LAZY) in the first
 * pass that uses it, reflected, cached on disk and handed to the backend. Equal texts share what
 * the backend made of them; of those that nothing uses any more the last MAX_IDLE are kept.
 */
#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

enum { MAX_IDLE = 256 };

static void free_sources(gpu_program_state *program) {
    gpu_source_free(&program->sources[0]);
    gpu_source_free(&program->sources[1]);
}

static void destroy(gpu *g, gpu_program_state *program) {
    if (program->native)
        g->backend->program_destroy(g->self, program->native);
    free_sources(program);
    free(program);
}

void gpu_program_release(gpu *g, gpu_program_state *program) {
    uint32_t idle = 0;
    if (!program)
        return;
    if (!program->built) { /* not shared yet */
        destroy(g, program);
        return;
    }
    program->users--;
    for (gpu_program_state **at = &g->programs; *at;) {
        gpu_program_state *p = *at;
        if (p->users > 0 || ++idle <= MAX_IDLE) {
            at = &p->next;
        } else {
            *at = p->next;
            destroy(g, p);
        }
    }
}

void gpu_programs_free(gpu *g) {
    for (gpu_program_state *p = g->programs, *next; p; p = next) {
        next = p->next;
        destroy(g, p);
    }
    g->programs = NULL;
}

/* The built program of these keys, moved to the front, or NULL. */
static gpu_program_state *find_built(gpu *g, const uint64_t keys[2]) {
    for (gpu_program_state **at = &g->programs; *at; at = &(*at)->next) {
        gpu_program_state *p = *at;
        if (p->keys[0] != keys[0] || p->keys[1] != keys[1])
            continue;
        *at = p->next;
        p->next = g->programs;
        g->programs = p;
        return p;
    }
    return NULL;
}

/* SPIR-V and reflection, from the cache or by compiling. */
static strata_result translate(gpu *g, const gpu_object *object, gpu_spirv *spirv,
                               gpu_reflection *reflection, base_error *err) {
    gpu_program_state *program = object->program;
    const int vulkan_target = g->caps.vulkan_target != 0;
    if (gpu_cache_load(g, program, spirv, reflection))
        return STRATA_OK;
    double start = base_now_ms();
    strata_result result =
        gpu_compile(object->label, program->kind, vulkan_target, program->sources, spirv, err);
    if (result == STRATA_OK)
        result = gpu_reflect(object->label, program->kind, vulkan_target, spirv, reflection, err);
    if (result == STRATA_OK)
        gpu_cache_store(g, program, spirv, reflection);
    base_log(BASE_LOG_DEBUG, "compiled '%s' in %.1f ms", object->label, base_now_ms() - start);
    return result;
}

/* Drivers are known to crash beyond the limit instead of refusing. */
static strata_result check_blocks(gpu *g, const gpu_object *object,
                                  const gpu_reflection *reflection, base_error *err) {
    for (uint32_t stage = GPU_STAGE_VERTEX; stage <= GPU_STAGE_COMPUTE; stage *= 2) {
        uint32_t blocks = 0;
        for (uint32_t i = 0; i < reflection->binding_count; i++)
            blocks += reflection->bindings[i].kind == GPU_BINDING_STORAGE &&
                      (reflection->bindings[i].stages & stage);
        if (blocks > g->caps.storage_blocks)
            return gpu_fail(g, err, GPU_ERROR_PROGRAM_BLOCKS, "program '%s': %u, of at most %u",
                            object->label, blocks, g->caps.storage_blocks);
    }
    return STRATA_OK;
}

strata_result gpu_program_build(gpu *g, gpu_object *object, base_error *err) {
    gpu_program_state *program = object->program;
    gpu_spirv spirv = {0};
    gpu_reflection reflection;
    if (program->built)
        return STRATA_OK;
    gpu_cache_keys(g, program, program->keys);
    gpu_program_state *same = find_built(g, program->keys);
    if (same) {
        same->users++;
        object->program = same;
        destroy(g, program);
        return STRATA_OK;
    }
    strata_result result = translate(g, object, &spirv, &reflection, err);
    if (result == STRATA_OK)
        result = check_blocks(g, object, &reflection, err);
    if (result == STRATA_OK && reflection.reads && !gpu_fact(g, "ordered_attachments"))
        result = gpu_fail(g, err, GPU_ERROR_ORDERED_MISSING, "program '%s'", object->label);
    if (result == STRATA_OK) {
        memcpy(program->bindings, reflection.bindings, sizeof program->bindings);
        memcpy(program->outputs, reflection.outputs, sizeof program->outputs);
        program->binding_count = reflection.binding_count;
        program->params_size = reflection.params_size;
        program->reads = reflection.reads;
        const gpu_program_info info = {
            .label = object->label,
            .kind = program->kind,
            .spirv = {spirv.words[0], spirv.words[1]},
            .words = {spirv.count[0], spirv.count[1]},
            .bindings = program->bindings,
            .binding_count = program->binding_count,
            .params_size = program->params_size,
            .reads = program->reads,
        };
        result = gpu_backend_result(
            g, err, g->backend->program_create(g->self, &info, &program->native, err));
    } else if (result == STRATA_ERROR_SHADER) {
        g->last_code = GPU_ERROR_PROGRAM_COMPILE;
    }
    gpu_spirv_free(&spirv);
    if (result == STRATA_OK) {
        program->built = 1;
        program->users = 1;
        program->next = g->programs;
        g->programs = program;
        free_sources(program);
    }
    return result;
}

static strata_result check_desc(gpu *g, const gpu_owner *owner, const strata_program_desc *desc,
                                base_error *err) {
    if (!desc->label || !desc->label[0])
        return gpu_fail(g, err, GPU_ERROR_LABEL_MISSING, "%s: a program without a label",
                        owner->name);
    if (desc->kind > STRATA_PROGRAM_COMPUTE)
        return gpu_fail(g, err, GPU_ERROR_PROGRAM_KIND, "%s: program '%s' of kind %u", owner->name,
                        desc->label, desc->kind);
    if (!desc->source || !desc->source->text || !desc->source->path ||
        (desc->define_count && !desc->defines) || desc->define_count > 256 ||
        (desc->flags & ~STRATA_PROGRAM_LAZY))
        return gpu_fail(g, err, GPU_ERROR_VALUE, "%s: program '%s': source, defines or flags",
                        owner->name, desc->label);
    return STRATA_OK;
}

static strata_result expand(gpu *g, const strata_program_desc *desc, gpu_program_state *program,
                            base_error *err) {
    uint32_t first = desc->kind == STRATA_PROGRAM_COMPUTE ? GPU_STAGE_COMPUTE : GPU_STAGE_VERTEX;
    strata_result result = gpu_shader_expand(g, desc, first, &program->sources[0], err);
    if (result == STRATA_OK && desc->kind != STRATA_PROGRAM_COMPUTE)
        result = gpu_shader_expand(g, desc, GPU_STAGE_FRAGMENT, &program->sources[1], err);
    if (result == STRATA_ERROR_SHADER)
        g->last_code = GPU_ERROR_PROGRAM_COMPILE;
    return result;
}

strata_result gpu_program_create(gpu_scope *scope, const strata_program_desc *given,
                                 strata_program *out, base_error *err) {
    gpu *g = scope->device;
    strata_program_desc desc;
    base_error failure = {0};
    *out = (strata_program){0};
    strata_result result = gpu_creation(g, "a program", err);
    if (result == STRATA_OK)
        result = gpu_take(g, err, given, &desc, sizeof desc, "strata_program_desc");
    if (result == STRATA_OK)
        result = check_desc(g, scope->owner, &desc, err);
    if (result != STRATA_OK)
        return result;
    gpu_object *object = gpu_object_new(scope, GPU_PROGRAM, desc.label);
    if (object)
        object->program = base_calloc(1, sizeof *object->program);
    if (!object || !object->program) {
        if (object)
            gpu_object_drop(g, object);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc.label);
    }
    object->program->kind = desc.kind;
    result = expand(g, &desc, object->program, &failure);
    if (result == STRATA_OK && !(desc.flags & STRATA_PROGRAM_LAZY))
        result = gpu_program_build(g, object, &failure);
    if (result != STRATA_OK) {
        base_fail(err, result, "%s", failure.text);
        gpu_object_drop(g, object);
        return result;
    }
    out->id = object->id;
    return STRATA_OK;
}
