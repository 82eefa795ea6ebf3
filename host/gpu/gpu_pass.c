/* SPDX-License-Identifier: MIT
 *
 * One pass: everything in it is checked here, once for all backends, then its objects are resolved,
 * its barriers derived, and the backend records it. A native pass runs a callback in place of a
 * program.
 */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <string.h>

/* A pass on its way to the backend. */
typedef struct pass_context {
    gpu *g;
    const gpu_object *program;
    strata_pass pass;
    strata_attachment color[GPU_MAX_COLOR], depth;
    char label[64];
    gpu_native_pass native;
    gpu_resolved resolved;
    gpu_uses attachments;
    uint32_t layers, samples; /* of every attachment; 0: none yet */
} pass_context;

/* ---- attachments ---------------------------------------------------------------------------- */

static int fail(pass_context *c, gpu_code code, const char *what) {
    gpu_record_fail(c->g, code, "%s", what);
    return 0;
}

/* All attachments have one size, as many layers and as many samples. */
static int fits(pass_context *c, const gpu_object *object, const char *name) {
    const gpu_image_state *image = &object->image;
    const uint32_t layers = image->layers ? image->layers : 1;
    if (!c->layers || (c->native.width == image->width && c->native.height == image->height &&
                       c->layers == layers && c->samples == image->samples)) {
        c->native.width = image->width;
        c->native.height = image->height;
        c->layers = layers;
        c->samples = image->samples;
        return 1;
    }
    gpu_record_fail(c->g, GPU_ERROR_ATTACHMENT_SIZE,
                    "%s: image '%s' of %ux%u, %u layers, %u samples beside %ux%u, %u, %u", name,
                    object->label, image->width, image->height, layers, image->samples,
                    c->native.width, c->native.height, c->layers, c->samples);
    return 0;
}

/* Finds the image, which fits those before it and is none of them. */
static gpu_object *attach(pass_context *c, const strata_attachment *attachment, const char *name,
                          uint32_t access) {
    gpu_code code;
    gpu_object *object = gpu_object_find(c->g, attachment->image.id, GPU_IMAGE, &code);
    if (!object) {
        gpu_record_fail(c->g, code, "%s", name);
        return NULL;
    }
    const gpu_image_state *image = &object->image;
    if (attachment->load > STRATA_LOAD_DISCARD || attachment->blend > STRATA_BLEND_FOLD ||
        attachment->mask_off > 15) {
        gpu_record_fail(c->g, GPU_ERROR_VALUE, "%s: image '%s'", name, object->label);
        return NULL;
    }
    if (!fits(c, object, name))
        return NULL;
    for (uint32_t i = 0; i < c->attachments.count; i++)
        if (c->attachments.items[i].storage == image->storage) {
            gpu_record_fail(c->g, GPU_ERROR_ATTACHMENT_HAZARD, "%s: image '%s'", name,
                            object->label);
            return NULL;
        }
    if (attachment->read &&
        (access != GPU_ACCESS_COLOR || c->native.call || image->layers || image->samples > 1 ||
         attachment->read > 1 || attachment->blend != STRATA_BLEND_NONE)) {
        gpu_record_fail(c->g, GPU_ERROR_VALUE, "%s: image '%s' cannot be read", name,
                        object->label);
        return NULL;
    }
    if (attachment->read)
        access |= GPU_ACCESS_COLOR_READ;
    gpu_uses_add(&c->attachments, image->storage, c->native.call ? GPU_ACCESS_NATIVE : access, 0);
    return object;
}

/* What the program reads is what the pass says it reads, and stands behind its input attachments.
 */
static int take_reads(pass_context *c) {
    const gpu_program_state *program = c->program->program;
    gpu_resolved *out = &c->resolved;
    uint32_t reads = 0;
    for (uint32_t i = 0; i < c->pass.color_count; i++)
        reads |= c->color[i].read << i;
    if (reads != program->reads)
        return fail(c, GPU_ERROR_ATTACHMENT_READ, c->program->label);
    for (uint32_t i = 0; i < program->binding_count; i++) {
        const gpu_binding *binding = &program->bindings[i];
        if (binding->kind == GPU_BINDING_ATTACHMENT)
            out->binds[out->count++] = (gpu_native_bind){
                .binding = binding, .native = c->native.color[binding->attachment]};
    }
    return 1;
}

static int take_color(pass_context *c) {
    const strata_pass *pass = &c->pass;
    size_t stride = pass->color_stride ? pass->color_stride : sizeof(strata_attachment);
    if (pass->color_count > GPU_MAX_COLOR || (pass->color_count && !pass->color) ||
        stride < sizeof(strata_attachment))
        return fail(c, GPU_ERROR_VALUE, "colour attachments");
    for (uint32_t i = 0; i < pass->color_count; i++) {
        base_error failure = {0};
        char name[32];
        snprintf(name, sizeof name, "colour attachment %u", i);
        if (gpu_take(c->g, &failure, (const char *)pass->color + i * stride, &c->color[i],
                     sizeof c->color[i], name) != STRATA_OK)
            return fail(c, c->g->last_code, name);
        const gpu_object *object = attach(c, &c->color[i], name, GPU_ACCESS_COLOR);
        if (!object)
            return 0;
        uint32_t format = object->image.format;
        if (gpu_format_is_depth(format) || format == STRATA_FORMAT_RGBA8_SRGB ||
            (gpu_format_is_integer(format) && c->color[i].blend != STRATA_BLEND_NONE))
            return fail(c, GPU_ERROR_IMAGE_FORMAT, name);
        gpu_output wanted = gpu_format_is_integer(format) ? GPU_OUTPUT_UINT : GPU_OUTPUT_FLOAT;
        if (c->program && c->color[i].mask_off != 15 && c->program->program->outputs[i] != wanted)
            return fail(c, GPU_ERROR_OUTPUT_TYPE, name);
        c->native.color[i] = object->image.storage->native;
    }
    c->pass.color = pass->color_count ? c->color : NULL;
    c->pass.color_stride = sizeof(strata_attachment);
    return 1;
}

static int take_depth(pass_context *c) {
    base_error failure = {0};
    strata_pass *pass = &c->pass;
    if (pass->depth_test > STRATA_TEST_ALWAYS || pass->stencil_test > STRATA_TEST_ALWAYS ||
        pass->depth_write > 1 || pass->stencil_pass > STRATA_STENCIL_DECREMENT ||
        pass->stencil_fail > STRATA_STENCIL_DECREMENT || pass->stencil_reference > 255 ||
        pass->stencil_keep_mask > 255 || pass->cull > 2)
        return fail(c, GPU_ERROR_VALUE, "depth, stencil or cull state");
    if (!pass->depth) {
        if (pass->depth_test || pass->depth_write || pass->stencil_test)
            return fail(c, GPU_ERROR_ATTACHMENT_MISSING, "depth or stencil test");
        return 1;
    }
    if (gpu_take(c->g, &failure, pass->depth, &c->depth, sizeof c->depth, "depth attachment") !=
        STRATA_OK)
        return fail(c, c->g->last_code, "depth attachment");
    const gpu_object *object = attach(c, &c->depth, "depth attachment", GPU_ACCESS_DEPTH);
    if (!object)
        return 0;
    if (!gpu_format_is_depth(object->image.format) ||
        (pass->stencil_test && object->image.format != STRATA_FORMAT_D32F_S8))
        return fail(c, GPU_ERROR_IMAGE_FORMAT, "depth attachment");
    c->native.depth = object->image.storage->native;
    pass->depth = &c->depth;
    return 1;
}

/* ---- program, target, work ------------------------------------------------------------------ */

static int check_kind(pass_context *c) {
    const strata_pass *pass = &c->pass;
    uint32_t kind = c->program->program->kind;
    int groups = pass->groups[0] || pass->groups[1] || pass->groups[2] || pass->indirect.id;
    int target = pass->color_count || pass->depth;
    if (kind == STRATA_PROGRAM_COMPUTE ? (target || pass->draws.id) : groups)
        return fail(c, GPU_ERROR_PROGRAM_KIND, c->program->label);
    if (kind == STRATA_PROGRAM_FULLSCREEN && pass->draws.id && !c->g->selftest_running)
        return fail(c, GPU_ERROR_PROGRAM_KIND, c->program->label);
    if (kind == STRATA_PROGRAM_SCENE && !pass->draws.id)
        return fail(c, GPU_ERROR_DRAWS_MISSING, c->program->label);
    return 1;
}

static int build_program(pass_context *c, gpu_object *object) {
    base_error failure = {0};
    if (gpu_program_build(c->g, object, &failure) != STRATA_OK) {
        if (c->g->frame_error.result == STRATA_OK) { /* a lazy program's own words say more */
            c->g->frame_code = c->g->last_code;
            base_fail(&c->g->frame_error, failure.result, "%s: pass '%s': %s", c->g->where_owner,
                      c->label, failure.text);
        }
        return 0;
    }
    c->native.program = object->program->native;
    return 1;
}

static int take_program(pass_context *c) {
    gpu_code code;
    gpu_object *object = gpu_object_find(c->g, c->pass.program.id, GPU_PROGRAM, &code);
    if (!object)
        return fail(c, code, "program");
    c->program = object;
    return check_kind(c) && build_program(c, object);
}

static int check_params(pass_context *c) {
    const strata_pass *pass = &c->pass;
    uint32_t wanted = c->program->program->params_size;
    if (pass->params_size != wanted || (wanted && !pass->params)) {
        gpu_record_fail(c->g, GPU_ERROR_PARAMS_SIZE, "%u bytes, program '%s' has %u",
                        pass->params_size, c->program->label, wanted);
        return 0;
    }
    return 1;
}

static uint32_t smaller(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

static int take_target(pass_context *c) {
    const strata_pass *pass = &c->pass;
    gpu_native_pass *native = &c->native;
    const uint32_t *rectangle = c->g->rectangle;
    if (!native->width) {
        native->width = pass->width ? pass->width : c->g->frame_width;
        native->height = pass->height ? pass->height : c->g->frame_height;
    }
    if (!native->width || !native->height)
        return fail(c, GPU_ERROR_ATTACHMENT_MISSING, "target");
    if (native->width > c->g->caps.image_size || native->height > c->g->caps.image_size)
        return fail(c, GPU_ERROR_IMAGE_SIZE, "target");
    native->scissor[2] = native->width;
    native->scissor[3] = native->height;
    if (!pass->whole_frame) {
        native->scissor[0] = smaller(rectangle[0], native->width);
        native->scissor[1] = smaller(rectangle[1], native->height);
        native->scissor[2] = smaller(rectangle[2], native->width - native->scissor[0]);
        native->scissor[3] = smaller(rectangle[3], native->height - native->scissor[1]);
    }
    return 1;
}

static gpu_object *use_buffer(pass_context *c, strata_buffer buffer, const char *name,
                              uint32_t access) {
    gpu_code code;
    gpu_object *object = gpu_object_find(c->g, buffer.id, GPU_BUFFER, &code);
    if (!object || !object->buffer.storage) {
        gpu_record_fail(c->g, object ? GPU_ERROR_MEMORY : code, "%s", name);
        return NULL;
    }
    gpu_uses_add(&c->resolved.uses, object->buffer.storage, access, 0);
    return object;
}

static int take_draws(pass_context *c) {
    gpu_code code;
    if (!c->pass.draws.id)
        return 1;
    const gpu_object *draws = gpu_object_find(c->g, c->pass.draws.id, GPU_DRAWS, &code);
    if (!draws)
        return fail(c, code, "draws");
    const gpu_draws_state *state = &draws->draws;
    const gpu_object *commands =
        use_buffer(c, state->commands, "commands of draws", GPU_ACCESS_INDIRECT);
    const gpu_object *indices =
        commands ? use_buffer(c, state->indices, "indices of draws", GPU_ACCESS_INDEX) : NULL;
    if (!indices)
        return 0;
    c->native.commands = commands->buffer.storage->native;
    c->native.indices = indices->buffer.storage->native;
    c->native.draw_capacity = state->capacity;
    c->native.counted = state->counted;
    const gpu_object *count = use_buffer(c, state->count, "count of draws", GPU_ACCESS_INDIRECT);
    if (!count)
        return 0;
    c->native.count = count->buffer.storage->native;
    return 1;
}

static int take_groups(pass_context *c) {
    strata_pass *pass = &c->pass;
    for (int i = 1; i < 3; i++)
        pass->groups[i] = pass->groups[i] ? pass->groups[i] : 1;
    for (int i = 0; i < 3; i++)
        if (pass->groups[i] > c->g->caps.groups) {
            gpu_record_fail(c->g, GPU_ERROR_GROUPS_LIMIT, "%u groups, limit %u", pass->groups[i],
                            c->g->caps.groups);
            return 0;
        }
    if (!pass->indirect.id)
        return 1;
    if (pass->indirect_offset % 4)
        return fail(c, GPU_ERROR_INDIRECT_ALIGNMENT, "indirect groups");
    const gpu_object *object =
        use_buffer(c, pass->indirect, "indirect groups", GPU_ACCESS_INDIRECT);
    if (!object)
        return 0;
    if (object->buffer.size < 12 || pass->indirect_offset > object->buffer.size - 12)
        return fail(c, GPU_ERROR_BUFFER_RANGE, "indirect groups");
    c->native.indirect = object->buffer.storage->native;
    return 1;
}

/* Not of draws: OpenGL masks samples only where it multisamples, and there a fragment need not
 * reach all of them. */
static int check_sample_mask(pass_context *c) {
    const uint64_t mask = c->pass.sample_mask;
    if (mask && (c->pass.draws.id || c->samples < 2 || mask >> c->samples)) {
        gpu_record_fail(c->g, GPU_ERROR_SAMPLE_MASK, "mask 0x%x of %u samples", c->pass.sample_mask,
                        c->samples);
        return 0;
    }
    return 1;
}

/* ---- between resources ---------------------------------------------------------------------- */

static int check_feedback(pass_context *c) {
    for (uint32_t i = 0; i < c->attachments.count; i++)
        for (uint32_t k = 0; k < c->resolved.count; k++)
            if (c->attachments.items[i].storage == c->resolved.storages[k]) {
                gpu_record_fail(c->g, GPU_ERROR_ATTACHMENT_HAZARD, "'%s'",
                                c->resolved.binds[k].binding->name);
                return 0;
            }
    return 1;
}

/* llvmpipe drops a tile's earlier storage writes when an opaque triangle covers it later. Where the
 * shader reads an attachment nothing is opaque. */
static int check_opaque_writes(pass_context *c) {
    int opaque = 0;
    for (uint32_t i = 0; i < c->pass.color_count; i++)
        opaque |= c->color[i].blend == STRATA_BLEND_NONE && c->color[i].mask_off != 15;
    for (uint32_t i = 0; i < c->pass.color_count; i++)
        opaque &= !c->color[i].read;
    for (uint32_t i = 0; opaque && i < c->resolved.count; i++) {
        const gpu_binding *binding = c->resolved.binds[i].binding;
        if ((binding->stages & GPU_STAGE_FRAGMENT) &&
            (binding->access & GPU_ACCESS_STORAGE_WRITE)) {
            gpu_record_fail(c->g, GPU_ERROR_OPAQUE_WRITES, "'%s'", binding->name);
            return 0;
        }
    }
    return 1;
}

static uint32_t begin_timing(pass_context *c) {
    gpu *g = c->g;
    gpu_timing *timings =
        base_grow(g->timings, &g->timing_capacity, g->timing_count, sizeof *timings);
    if (!timings) {
        base_fail(&g->frame_error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for timings");
        return 0;
    }
    g->timings = timings;
    gpu_timing *timing = &timings[g->timing_count++];
    *timing = (gpu_timing){.gpu_ms = -1.0};
    snprintf(timing->label, sizeof timing->label, "%s", c->label);
    snprintf(timing->owner, sizeof timing->owner, "%s", g->where_owner);
    return (uint32_t)(g->timing_count - g->timing_submitted);
}

/* The callback decides what is drawn and how: only what orders the pass is kept of it. */
static int take_native(pass_context *c) {
    const strata_pass given = c->pass;
    c->pass = (strata_pass){.struct_size = sizeof c->pass,
                            .label = c->label,
                            .binds = given.binds,
                            .bind_count = given.bind_count,
                            .bind_stride = given.bind_stride,
                            .color = given.color,
                            .color_count = given.color_count,
                            .color_stride = given.color_stride,
                            .depth = given.depth,
                            .whole_frame = given.whole_frame,
                            .width = given.width,
                            .height = given.height};
    return gpu_bind_native(c->g, &c->pass, &c->resolved) && take_color(c) && take_depth(c) &&
           take_target(c);
}

static int take_pass(pass_context *c, const strata_pass *given) {
    base_error failure = {0};
    if (gpu_take(c->g, &failure, given, &c->pass, sizeof c->pass, "strata_pass") != STRATA_OK)
        return fail(c, c->g->last_code, "strata_pass");
    if (!c->pass.label || !c->pass.label[0])
        return fail(c, GPU_ERROR_LABEL_MISSING, "strata_pass");
    snprintf(c->label, sizeof c->label, "%s", c->pass.label);
    c->g->where_label = c->pass.label = c->label;
    if (c->native.call)
        return take_native(c);
    if (!take_program(c) || !check_params(c))
        return 0;
    if (!gpu_bind_resolve(c->g, &c->pass, c->program, &c->resolved))
        return 0;
    if (c->program->program->kind == STRATA_PROGRAM_COMPUTE)
        return check_sample_mask(c) && take_groups(c);
    return take_color(c) && take_depth(c) && check_sample_mask(c) && take_target(c) &&
           take_draws(c) && check_feedback(c) && check_opaque_writes(c) && take_reads(c);
}

static void record(pass_context *c) {
    gpu *g = c->g;
    gpu_barrier barriers[GPU_MAX_USES];
    gpu_native_pass *native = &c->native;
    for (uint32_t i = 0; i < c->resolved.pool_count; i++)
        gpu_pool_refresh(g, c->resolved.pools[i]);
    for (uint32_t i = 0; i < c->attachments.count; i++) {
        const gpu_use *use = &c->attachments.items[i];
        gpu_uses_add(&c->resolved.uses, use->storage, use->access, use->stages);
    }
    native->pass = &c->pass;
    native->binds = c->resolved.binds;
    native->bind_count = c->resolved.count;
    native->barrier_count = gpu_hazards_derive(&c->resolved.uses, barriers);
    native->barriers = barriers;
    gpu_open_commands(g);
    g->backend->pass(g->self, native);
}

/* Where the driver's timer is not sound: the pass alone between two waits, by the clock. */
static void record_by_clock(pass_context *c) {
    gpu *g = c->g;
    gpu_flush(g);
    double start = base_now_ms();
    record(c);
    gpu_flush(g);
    g->timings[g->timing_count - 1].gpu_ms = base_now_ms() - start;
}

static void make_pass(gpu *g, const char *owner, const strata_pass *given, gpu_native_fn call,
                      void *user) {
    double start = base_now_ms();
    pass_context c = {.g = g, .native = {.call = call, .user = user}};
    if (!gpu_recording(g, owner, given && given->struct_size >= sizeof *given ? given->label : ""))
        return;
    if (!take_pass(&c, given)) {
        g->where_label = "";
        return;
    }
    uint32_t number = begin_timing(&c);
    int is_compute = c.program && c.program->program->kind == STRATA_PROGRAM_COMPUTE;
    int works = number && (!is_compute || c.pass.groups[0] || c.native.indirect);
    c.native.timed = g->profile && !g->clock_passes ? number : 0;
    if (works && g->clock_passes)
        record_by_clock(&c);
    else if (works)
        record(&c);
    if (number)
        g->timings[g->timing_count - 1].cpu_ms = base_now_ms() - start;
    g->where_label = "";
}

void gpu_pass(gpu *g, const char *owner, const strata_pass *given) {
    make_pass(g, owner, given, NULL, NULL);
}

void gpu_pass_native(gpu *g, const char *owner, const strata_pass *given, gpu_native_fn call,
                     void *user) {
    if (call)
        make_pass(g, owner, given, call, user);
    else if (gpu_recording(g, owner, "native"))
        gpu_record_fail(g, GPU_ERROR_VALUE, "no callback");
}
