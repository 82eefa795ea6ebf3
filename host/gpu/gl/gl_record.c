/* SPDX-License-Identifier: MIT
 *
 * Passes, fills, copies and clears of the OpenGL backend. OpenGL keeps what one command wrote
 * visible to the next by itself, except what shaders wrote to storage; there a barrier is made.
 */
#include "gpu/gl/gl_internal.h"

#include <string.h>

#define STORAGE_ACCESS (GPU_ACCESS_STORAGE_READ | GPU_ACCESS_STORAGE_WRITE)

/* ---- barriers ---------------------------------------------------------------------------------
 */
static GLbitfield access_bits(uint32_t access, uint32_t is_image) {
    GLbitfield bits = 0;
    if (access & GPU_ACCESS_NATIVE)
        return GL_ALL_BARRIER_BITS;
    if (access & GPU_ACCESS_INDIRECT)
        bits |= GL_COMMAND_BARRIER_BIT;
    if (access & GPU_ACCESS_INDEX)
        bits |= GL_ELEMENT_ARRAY_BARRIER_BIT;
    if (access & GPU_ACCESS_UNIFORM)
        bits |= GL_UNIFORM_BARRIER_BIT;
    if (access & GPU_ACCESS_SAMPLED)
        bits |= GL_TEXTURE_FETCH_BARRIER_BIT;
    if (access & STORAGE_ACCESS)
        bits |= is_image ? GL_SHADER_IMAGE_ACCESS_BARRIER_BIT : GL_SHADER_STORAGE_BARRIER_BIT;
    if (access & (GPU_ACCESS_COLOR | GPU_ACCESS_DEPTH))
        bits |= GL_FRAMEBUFFER_BARRIER_BIT;
    if (access & (GPU_ACCESS_COPY_READ | GPU_ACCESS_COPY_WRITE))
        bits |= is_image ? GL_TEXTURE_UPDATE_BARRIER_BIT : GL_BUFFER_UPDATE_BARRIER_BIT;
    return bits;
}

/* A dependency needs a barrier when one of its sides is a shader's access to storage, as a native
 * pass's may be: what such writes wrote is to be seen, or what is about to be overwritten is to
 * have been read. */
static void barriers_make(gl *g, const gpu_barrier *barriers, uint32_t count) {
    const uint32_t copies = GPU_ACCESS_COPY_READ | GPU_ACCESS_COPY_WRITE;
    const uint32_t shaders = STORAGE_ACCESS | GPU_ACCESS_NATIVE;
    GLbitfield bits = 0;
    for (uint32_t i = 0; i < count; i++) {
        const gpu_barrier *barrier = &barriers[i];
        if ((barrier->before & shaders) ||
            ((barrier->after & shaders) && (barrier->before & ~copies)))
            bits |= access_bits(barrier->after, barrier->is_image);
    }
    if (bits)
        g->fn.MemoryBarrier(bits);
}

/* ---- bindings ---------------------------------------------------------------------------------
 */
static void params_bind(gl *g, const gl_program *program, const strata_pass *pass) {
    const uint32_t capacity = 1u << 20;
    const GLbitfield flags = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    if (!program->params || pass->params_size == 0)
        return;
    if (!g->ring) {
        g->fn.CreateBuffers(1, &g->ring);
        g->fn.NamedBufferStorage(g->ring, (GLsizeiptr)capacity, NULL, flags);
        g->ring_map = g->fn.MapNamedBufferRange(g->ring, 0, (GLsizeiptr)capacity, flags);
    }
    if (!g->ring_map) {
        base_fail(&g->failure, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                  "gl: pass %s: no memory for parameters", g->where);
        return;
    }
    uint32_t size = (program->params->size + 15u) & ~15u; /* std140 blocks end on 16 bytes */
    if (size < pass->params_size)
        size = pass->params_size;
    if (g->ring_used + size > capacity) {
        g->fn.Finish();
        g->ring_used = 0;
    }
    memcpy(g->ring_map + g->ring_used, pass->params, pass->params_size);
    g->fn.BindBufferRange(GL_UNIFORM_BUFFER, program->params->binding, g->ring,
                          (GLintptr)g->ring_used, (GLsizeiptr)size);
    g->ring_used += (size + g->ring_alignment - 1) / g->ring_alignment * g->ring_alignment;
}

static void resource_bind(gl *g, const gpu_native_bind *bind) {
    const gpu_binding *binding = bind->binding;
    gl_buffer *buffer = bind->native;
    const gl_image *image = bind->native;
    GLenum access = GL_READ_WRITE;
    switch (binding->kind) {
    case GPU_BINDING_UNIFORM:
    case GPU_BINDING_STORAGE:
        g->fn.BindBufferRange(
            binding->kind == GPU_BINDING_UNIFORM ? GL_UNIFORM_BUFFER : GL_SHADER_STORAGE_BUFFER,
            binding->binding, buffer->name, (GLintptr)bind->offset, (GLsizeiptr)bind->size);
        break;
    case GPU_BINDING_SAMPLED:
        g->fn.BindTextureUnit(binding->binding, image->name);
        break;
    case GPU_BINDING_TEXELS:
        if (!buffer->texels) {
            g->fn.CreateTextures(GL_TEXTURE_BUFFER, 1, &buffer->texels);
            g->fn.TextureBuffer(buffer->texels, GL_R32UI, buffer->name);
        }
        g->fn.BindTextureUnit(binding->binding, buffer->texels);
        break;
    case GPU_BINDING_STORAGE_IMAGE:
        if (!(binding->access & GPU_ACCESS_STORAGE_WRITE))
            access = GL_READ_ONLY;
        else if (!(binding->access & GPU_ACCESS_STORAGE_READ))
            access = GL_WRITE_ONLY;
        g->fn.BindImageTexture(binding->binding, image->name, 0, image->layers ? GL_TRUE : GL_FALSE,
                               0, access, image->format->internal);
        break;
    case GPU_BINDING_PARAMS:
    case GPU_BINDING_ATTACHMENT: /* framebuffer fetch binds nothing */
        break;
    }
}

/* ---- state of a draw --------------------------------------------------------------------------
 */
typedef struct blend_state {
    GLenum equation, source, destination, source_alpha, destination_alpha;
} blend_state;

static const blend_state blends[] = {
    [STRATA_BLEND_NONE] = {GL_FUNC_ADD, GL_ONE, GL_ZERO, GL_ONE, GL_ZERO},
    [STRATA_BLEND_ADD] = {GL_FUNC_ADD, GL_ONE, GL_ONE, GL_ONE, GL_ONE},
    [STRATA_BLEND_OVER] = {GL_FUNC_ADD, GL_ONE, GL_ONE_MINUS_SRC_ALPHA, GL_ONE,
                           GL_ONE_MINUS_SRC_ALPHA},
    [STRATA_BLEND_UNDER] = {GL_FUNC_ADD, GL_ONE_MINUS_DST_ALPHA, GL_ONE, GL_ONE_MINUS_DST_ALPHA,
                            GL_ONE},
    [STRATA_BLEND_MULTIPLY] = {GL_FUNC_ADD, GL_DST_COLOR, GL_ZERO, GL_DST_ALPHA, GL_ZERO},
    [STRATA_BLEND_MIN] = {GL_MIN, GL_ONE, GL_ONE, GL_ONE, GL_ONE},
    [STRATA_BLEND_MAX] = {GL_MAX, GL_ONE, GL_ONE, GL_ONE, GL_ONE},
    [STRATA_BLEND_FOLD] = {GL_FUNC_ADD, GL_ONE, GL_SRC_ALPHA, GL_DST_ALPHA, GL_ZERO},
};

static GLenum test_function(uint32_t test) { /* STRATA_TEST_NEVER.. are OpenGL's in order */
    return test == STRATA_TEST_NONE ? GL_ALWAYS : GL_NEVER + (test - STRATA_TEST_NEVER);
}

static void enable(gl *g, GLenum what, int on) {
    if (on)
        g->fn.Enable(what);
    else
        g->fn.Disable(what);
}

/* The attachments of a strata_pass stand color_stride bytes apart. */
static const strata_attachment *color_of(const strata_pass *pass, uint32_t index) {
    size_t stride = pass->color_stride ? pass->color_stride : sizeof(strata_attachment);
    return (const strata_attachment *)((const char *)pass->color + index * stride);
}

static void attachment_clear(gl *g, GLuint target, GLint index, const gl_image *image,
                             const strata_attachment *attachment) {
    uint32_t texel[4];
    if (attachment->load != STRATA_LOAD_CLEAR)
        return;
    gl_clear_texel(image->format, attachment->clear, texel);
    if (image->format->stencil)
        g->fn.ClearNamedFramebufferfi(target, GL_DEPTH_STENCIL, 0, attachment->clear[0],
                                      (GLint)texel[1]);
    else if (image->format->depth)
        g->fn.ClearNamedFramebufferfv(target, GL_DEPTH, 0, attachment->clear);
    else if (image->format->integer)
        g->fn.ClearNamedFramebufferuiv(target, GL_COLOR, index, texel);
    else
        g->fn.ClearNamedFramebufferfv(target, GL_COLOR, index, attachment->clear);
}

/* Loads clear the whole attachment, and clears obey scissor and write masks: open them first. */
static void attachments_load(gl *g, GLuint target, const gpu_native_pass *native) {
    const strata_pass *pass = native->pass;
    g->fn.Scissor(0, 0, (GLsizei)native->width, (GLsizei)native->height);
    g->fn.DepthMask(GL_TRUE);
    g->fn.StencilMask(0xffu);
    for (uint32_t i = 0; i < pass->color_count; i++) {
        g->fn.ColorMaski(i, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        attachment_clear(g, target, (GLint)i, native->color[i], color_of(pass, i));
    }
    if (native->depth && pass->depth)
        attachment_clear(g, target, 0, native->depth, pass->depth);
}

static void color_state_set(gl *g, const gpu_native_pass *native) {
    const strata_pass *pass = native->pass;
    for (uint32_t i = 0; i < pass->color_count; i++) {
        const strata_attachment *color = color_of(pass, i);
        const gl_image *image = native->color[i];
        const blend_state *blend = &blends[color->blend];
        uint32_t off = color->mask_off;
        if (color->blend == STRATA_BLEND_NONE || image->format->integer)
            g->fn.Disablei(GL_BLEND, i);
        else
            g->fn.Enablei(GL_BLEND, i);
        g->fn.BlendEquationi(i, blend->equation);
        g->fn.BlendFuncSeparatei(i, blend->source, blend->destination, blend->source_alpha,
                                 blend->destination_alpha);
        g->fn.ColorMaski(i, !(off & 1u), !(off & 2u), !(off & 4u), !(off & 8u));
    }
}

static void depth_state_set(gl *g, const gpu_native_pass *native) {
    static const GLenum operations[] = {
        [STRATA_STENCIL_KEEP] = GL_KEEP,       [STRATA_STENCIL_ZERO] = GL_ZERO,
        [STRATA_STENCIL_REPLACE] = GL_REPLACE, [STRATA_STENCIL_INCREMENT] = GL_INCR,
        [STRATA_STENCIL_DECREMENT] = GL_DECR,
    };
    const strata_pass *pass = native->pass;
    GLuint mask = ~pass->stencil_keep_mask & 0xffu;
    GLenum fail = operations[pass->stencil_fail];
    enable(g, GL_DEPTH_TEST, native->depth && (pass->depth_test || pass->depth_write));
    g->fn.DepthFunc(test_function(pass->depth_test));
    g->fn.DepthMask(pass->depth_write ? GL_TRUE : GL_FALSE);
    enable(g, GL_STENCIL_TEST, native->depth && pass->stencil_test);
    g->fn.StencilFunc(test_function(pass->stencil_test), (GLint)pass->stencil_reference, mask);
    g->fn.StencilOp(fail, fail, operations[pass->stencil_pass]);
    g->fn.StencilMask(mask);
    enable(g, GL_CULL_FACE, pass->cull != 0);
    if (pass->cull)
        g->fn.CullFace(pass->cull == 1 ? GL_BACK : GL_FRONT);
}

/* Without multisampling each fragment reaches all samples of its pixel, or none. A mask takes
 * effect only with it; such passes cover pixels whole. */
static void sample_state_set(gl *g, uint32_t mask) {
    enable(g, GL_MULTISAMPLE, mask != 0);
    enable(g, GL_SAMPLE_MASK, mask != 0);
    if (mask)
        g->fn.SampleMaski(0, mask);
}

/* ---- passes -----------------------------------------------------------------------------------
 */

/* Whether fragments of the pass write storage. */
static int fragments_write(const gpu_native_pass *native) {
    for (uint32_t i = 0; i < native->bind_count; i++) {
        const gpu_binding *binding = native->binds[i].binding;
        if ((binding->stages & GPU_STAGE_FRAGMENT) && (binding->access & GPU_ACCESS_STORAGE_WRITE))
            return 1;
    }
    return 0;
}

static void draw(gl *g, const gpu_native_pass *native) {
    const gl_buffer *indices = native->indices, *commands = native->commands;
    const gl_buffer *count = native->count;
    const GLsizei stride = 20; /* a VkDrawIndexedIndirectCommand, which is OpenGL's too */
    if (!commands) {
        g->fn.DrawArrays(GL_TRIANGLES, 0, 3);
        return;
    }
    g->fn.VertexArrayElementBuffer(g->vertex_array, indices->name);
    g->fn.BindBuffer(GL_DRAW_INDIRECT_BUFFER, commands->name);
    g->fn.BindBuffer(GL_PARAMETER_BUFFER, count->name);
    g->fn.MultiDrawElementsIndirectCount(GL_TRIANGLES, GL_UNSIGNED_INT, NULL, 0,
                                         (GLsizei)native->draw_capacity, stride);
}

/* llvmpipe forgets what fragments wrote to storage when, before its scene is flushed, an opaque
 * draw or clear covers their tile in the same target. A barrier flushes the scene. */
static void writes_keep(gl *g, GLuint target, const gpu_native_pass *native) {
    if (g->writing_target == target)
        g->fn.MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    g->writing_target = fragments_write(native) ? target : 0;
}

static void raster_pass(gl *g, const gpu_native_pass *native) {
    GLuint target = gl_target_get(g, native);
    if (!target)
        return;
    writes_keep(g, target, native);
    g->fn.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
    g->fn.Viewport(0, 0, (GLsizei)native->width, (GLsizei)native->height);
    attachments_load(g, target, native);
    g->fn.Scissor((GLint)native->scissor[0], (GLint)native->scissor[1], (GLsizei)native->scissor[2],
                  (GLsizei)native->scissor[3]);
    color_state_set(g, native);
    depth_state_set(g, native);
    sample_state_set(g, native->pass->sample_mask);
    draw(g, native);
}

static void compute_pass(gl *g, const gpu_native_pass *native) {
    const strata_pass *pass = native->pass;
    const gl_buffer *indirect = native->indirect;
    if (indirect) {
        g->fn.BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, indirect->name);
        g->fn.DispatchComputeIndirect((GLintptr)pass->indirect_offset);
    } else {
        g->fn.DispatchCompute(pass->groups[0], pass->groups[1] ? pass->groups[1] : 1,
                              pass->groups[2] ? pass->groups[2] : 1);
    }
}

static void program_run(gl *g, const gpu_native_pass *native) {
    const gl_program *program = native->program;
    g->fn.UseProgram(program->name);
    params_bind(g, program, native->pass);
    for (uint32_t i = 0; i < native->bind_count; i++)
        resource_bind(g, &native->binds[i]);
    if (g->failure.result == STRATA_OK && program->kind == STRATA_PROGRAM_COMPUTE)
        compute_pass(g, native);
    else if (g->failure.result == STRATA_OK)
        raster_pass(g, native);
}

void gl_pass(void *self, const gpu_native_pass *native) {
    gl *g = self;
    if (!gl_recording(g))
        return;
    g->where = native->pass->label;
    barriers_make(g, native->barriers, native->barrier_count);
    gl_timer_begin(g, native->timed);
    if (native->call)
        gl_native_run(g, native);
    else
        program_run(g, native);
    gl_timer_end(g);
    g->where = NULL;
}

/* ---- transfers --------------------------------------------------------------------------------
 */
void gl_fill(void *self, void *native, uint64_t offset, uint64_t size, uint32_t value,
             const gpu_barrier *barriers, uint32_t barrier_count) {
    gl *g = self;
    const gl_buffer *buffer = native;
    const uint64_t step = 1u << 30; /* drivers count bytes of one clear in 32 bits */
    if (!gl_recording(g))
        return;
    barriers_make(g, barriers, barrier_count);
    for (uint64_t at = 0; at < size; at += step)
        g->fn.ClearNamedBufferSubData(buffer->name, GL_R32UI, (GLintptr)(offset + at),
                                      (GLsizeiptr)(size - at < step ? size - at : step),
                                      GL_RED_INTEGER, GL_UNSIGNED_INT, &value);
}

void gl_copy(void *self, void *to, uint64_t to_offset, void *from, uint64_t from_offset,
             uint64_t size, const gpu_barrier *barriers, uint32_t barrier_count) {
    gl *g = self;
    const gl_buffer *target = to, *source = from;
    if (!gl_recording(g))
        return;
    barriers_make(g, barriers, barrier_count);
    g->fn.CopyNamedBufferSubData(source->name, target->name, (GLintptr)from_offset,
                                 (GLintptr)to_offset, (GLsizeiptr)size);
}

void gl_clear_image(void *self, void *native, const float value[4], const gpu_barrier *barriers,
                    uint32_t barrier_count) {
    gl *g = self;
    const gl_image *image = native;
    uint32_t texel[4];
    if (!gl_recording(g))
        return;
    barriers_make(g, barriers, barrier_count);
    gl_clear_texel(image->format, value, texel);
    /* Colours that are not integers go in as floats, whatever they are stored as. */
    int as_float = !image->format->integer && !image->format->depth;
    g->fn.ClearTexImage(image->name, 0, image->format->format,
                        as_float ? GL_FLOAT : image->format->type, texel);
}
