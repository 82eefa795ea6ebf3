/* SPDX-License-Identifier: MIT
 *
 * Buffers, images and programs of the OpenGL backend. New storage is zero; programs arrive as
 * SPIR-V for the OpenGL target with an explicit binding for every resource.
 */
#include "gpu/gl/gl_internal.h"

#include <stdlib.h>
#include <string.h>

static const gl_format formats[] = {
    [STRATA_FORMAT_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16, 0, 0, 0},
    [STRATA_FORMAT_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_HALF_FLOAT, 8, 0, 0, 0},
    [STRATA_FORMAT_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 0, 0, 0},
    [STRATA_FORMAT_RGBA8_SRGB] = {GL_SRGB8_ALPHA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 0, 0, 0},
    [STRATA_FORMAT_R32F] = {GL_R32F, GL_RED, GL_FLOAT, 4, 0, 0, 0},
    [STRATA_FORMAT_R32U] = {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4, 1, 0, 0},
    [STRATA_FORMAT_RG32U] = {GL_RG32UI, GL_RG_INTEGER, GL_UNSIGNED_INT, 8, 1, 0, 0},
    [STRATA_FORMAT_RGBA32U] = {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 16, 1, 0, 0},
    [STRATA_FORMAT_D32F] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4, 0, 1, 0},
    [STRATA_FORMAT_D32F_S8] = {GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL,
                               GL_FLOAT_32_UNSIGNED_INT_24_8_REV, 8, 0, 1, 1},
};

/* ---- buffers ----------------------------------------------------------------------------------
 */
static void buffer_fill_storage(gl *g, gl_buffer *buffer, const strata_buffer_desc *desc) {
    const GLuint zero = 0;
    const uint64_t step = 1u << 30; /* drivers count bytes of one clear in 32 bits */
    g->fn.NamedBufferStorage(buffer->name, (GLsizeiptr)desc->size, desc->data,
                             GL_DYNAMIC_STORAGE_BIT);
    for (uint64_t at = 0; !desc->data && at < desc->size; at += step) {
        uint64_t size = desc->size - at < step ? desc->size - at : step;
        g->fn.ClearNamedBufferSubData(buffer->name, GL_R32UI, (GLintptr)at, (GLsizeiptr)size,
                                      GL_RED_INTEGER, GL_UNSIGNED_INT, &zero);
    }
}

strata_result gl_buffer_create(void *self, const strata_buffer_desc *desc, void **native,
                               base_error *err) {
    gl *g = self;
    const char *label = desc->label ? desc->label : "buffer";
    strata_result result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    gl_buffer *buffer = base_calloc(1, sizeof *buffer);
    if (!buffer) {
        gl_leave(g);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "gl: buffer %s: out of memory",
                         label);
    }
    buffer->size = desc->size;
    g->fn.CreateBuffers(1, &buffer->name);
    if (g->check)
        g->fn.ObjectLabel(GL_BUFFER, buffer->name, -1, label);
    buffer_fill_storage(g, buffer, desc);
    result = gl_report(g, STRATA_OK, label, err);
    if (result != STRATA_OK) {
        gl_buffer_destroy(g, buffer);
        buffer = NULL;
    }
    *native = buffer;
    gl_leave(g);
    return result;
}

void gl_buffer_destroy(void *self, void *native) {
    gl *g = self;
    gl_buffer *buffer = native;
    if (buffer && gl_enter(g, NULL) == STRATA_OK) {
        g->fn.DeleteTextures(1, &buffer->texels);
        g->fn.DeleteBuffers(1, &buffer->name);
        gl_leave(g);
    }
    free(buffer);
}

/* ---- images -----------------------------------------------------------------------------------
 */
void gl_clear_texel(const gl_format *format, const float value[4], uint32_t texel[4]) {
    for (uint32_t i = 0; i < 4; i++) {
        texel[i] = value[i] > 0 && value[i] < 4294967296.f ? (uint32_t)value[i] : 0;
        if (value[i] >= 4294967296.f)
            texel[i] = UINT32_MAX;
    }
    if (format->depth)
        memcpy(texel, value, sizeof *texel);
    else if (!format->integer)
        memcpy(texel, value, 4 * sizeof *texel);
}

static GLenum image_target(const gl_image *image) {
    return image->samples > 1 ? GL_TEXTURE_2D_MULTISAMPLE
           : image->layers    ? GL_TEXTURE_2D_ARRAY
                              : GL_TEXTURE_2D;
}

static void image_fill_storage(gl *g, const gl_image *image) {
    static const struct { /* multisampled textures have none */
        GLenum name;
        GLint value;
    } sampling[] = {{GL_TEXTURE_MIN_FILTER, GL_NEAREST},
                    {GL_TEXTURE_MAG_FILTER, GL_NEAREST},
                    {GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE},
                    {GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE}};
    const gl_format *format = image->format;
    GLsizei width = (GLsizei)image->width, height = (GLsizei)image->height;
    if (image->samples > 1)
        g->fn.TextureStorage2DMultisample(image->name, (GLsizei)image->samples, format->internal,
                                          width, height, GL_TRUE);
    else if (image->layers)
        g->fn.TextureStorage3D(image->name, 1, format->internal, width, height,
                               (GLsizei)image->layers);
    else
        g->fn.TextureStorage2D(image->name, 1, format->internal, width, height);
    for (size_t i = 0; i < BASE_COUNT(sampling) && image->samples <= 1; i++)
        g->fn.TextureParameteri(image->name, sampling[i].name, sampling[i].value);
    g->fn.ClearTexImage(image->name, 0, format->format, format->type, NULL);
}

strata_result gl_image_create(void *self, const strata_image_desc *desc, void **native,
                              base_error *err) {
    gl *g = self;
    const char *label = desc->label ? desc->label : "image";
    if (desc->format >= BASE_COUNT(formats) || formats[desc->format].texel == 0)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "gl: image %s: unknown format", label);
    strata_result result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    gl_image *image = base_calloc(1, sizeof *image);
    if (!image) {
        gl_leave(g);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "gl: image %s: out of memory",
                         label);
    }
    *image = (gl_image){.format = &formats[desc->format],
                        .width = desc->width,
                        .height = desc->height,
                        .layers = desc->layers,
                        .samples = desc->samples};
    g->fn.CreateTextures(image_target(image), 1, &image->name);
    if (g->check)
        g->fn.ObjectLabel(GL_TEXTURE, image->name, -1, label);
    image_fill_storage(g, image);
    result = gl_report(g, STRATA_OK, label, err);
    if (result != STRATA_OK) {
        gl_image_destroy(g, image);
        image = NULL;
    }
    *native = image;
    gl_leave(g);
    return result;
}

void gl_image_destroy(void *self, void *native) {
    gl *g = self;
    gl_image *image = native;
    if (image && gl_enter(g, NULL) == STRATA_OK) {
        gl_targets_forget(g, image);
        g->fn.DeleteTextures(1, &image->name);
        gl_leave(g);
    }
    free(image);
}

/* ---- programs ---------------------------------------------------------------------------------
 */
static GLuint shader_create(gl *g, GLenum stage, const uint32_t *spirv, size_t words,
                            const char *label, base_error *err) {
    GLint done = 0;
    GLuint shader = g->fn.CreateShader(stage);
    if (words > INT32_MAX / sizeof *spirv) {
        g->fn.DeleteShader(shader);
        base_fail(err, STRATA_ERROR_SHADER, "gl: program %s: the module is too long", label);
        return 0;
    }
    g->fn.ShaderBinary(1, &shader, GL_SHADER_BINARY_FORMAT_SPIR_V, spirv,
                       (GLsizei)(words * sizeof *spirv));
    g->fn.SpecializeShader(shader, "main", 0, NULL, NULL);
    g->fn.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
    if (!done) {
        char log[300] = "";
        g->fn.GetShaderInfoLog(shader, sizeof log, NULL, log);
        g->fn.DeleteShader(shader);
        base_fail(err, STRATA_ERROR_SHADER, "gl: program %s: the driver refuses it: %s", label,
                  log);
        return 0;
    }
    return shader;
}

GLuint gl_link(gl *g, const GLuint *shaders, uint32_t count, const char *label, base_error *err) {
    GLint done = 0;
    GLuint name = g->fn.CreateProgram();
    for (uint32_t i = 0; i < count; i++)
        g->fn.AttachShader(name, shaders[i]);
    g->fn.LinkProgram(name);
    for (uint32_t i = 0; i < count; i++) {
        g->fn.DetachShader(name, shaders[i]);
        g->fn.DeleteShader(shaders[i]);
    }
    g->fn.GetProgramiv(name, GL_LINK_STATUS, &done);
    if (!done) {
        char log[300] = "";
        g->fn.GetProgramInfoLog(name, sizeof log, NULL, log);
        g->fn.DeleteProgram(name);
        base_fail(err, STRATA_ERROR_SHADER, "gl: program %s does not link: %s", label, log);
        return 0;
    }
    return name;
}

static strata_result bindings_check(const gl *g, const gpu_program_info *info, base_error *err) {
    for (uint32_t i = 0; i < info->binding_count; i++) {
        const gpu_binding *binding = &info->bindings[i];
        const gpu_binding_kind kind = gpu_group(binding->kind);
        if (binding->binding >= (uint32_t)g->limits[kind])
            return base_fail(err, STRATA_ERROR_SHADER,
                             "gl: program %s: %s is one resource of its kind too many (limit %d)",
                             info->label, binding->name, g->limits[kind]);
    }
    return STRATA_OK;
}

static GLuint program_build(gl *g, const gpu_program_info *info, base_error *err) {
    static const GLenum draw_stages[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    GLuint shaders[2] = {0, 0};
    uint32_t count = info->kind == STRATA_PROGRAM_COMPUTE ? 1 : 2;
    for (uint32_t i = 0; i < count; i++) {
        GLenum stage = count == 1 ? GL_COMPUTE_SHADER : draw_stages[i];
        shaders[i] = shader_create(g, stage, info->spirv[i], info->words[i], info->label, err);
        if (!shaders[i]) {
            g->fn.DeleteShader(shaders[0]); /* ignores 0 */
            return 0;
        }
    }
    return gl_link(g, shaders, count, info->label, err);
}

strata_result gl_program_create(void *self, const gpu_program_info *info, void **native,
                                base_error *err) {
    gl *g = self;
    base_error first = {0};
    strata_result result = bindings_check(g, info, err);
    if (result == STRATA_OK)
        result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    gl_program *program = base_calloc(1, sizeof *program);
    if (!program) {
        gl_leave(g);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "gl: program %s: out of memory",
                         info->label);
    }
    program->kind = info->kind;
    for (uint32_t i = 0; i < info->binding_count; i++)
        if (info->bindings[i].kind == GPU_BINDING_PARAMS)
            program->params = &info->bindings[i];
    program->name = info->reads ? gl_text_build(g, info, &first) : program_build(g, info, &first);
    if (g->check && program->name)
        g->fn.ObjectLabel(GL_PROGRAM, program->name, -1, info->label);
    result = gl_report(g, first.result, info->label, &first);
    if (result != STRATA_OK) {
        base_fail(err, result, "%s", first.text);
        gl_program_destroy(g, program);
        program = NULL;
    }
    *native = program;
    gl_leave(g);
    return result;
}

void gl_program_destroy(void *self, void *native) {
    gl *g = self;
    gl_program *program = native;
    if (program && gl_enter(g, NULL) == STRATA_OK) {
        g->fn.DeleteProgram(program->name);
        gl_leave(g);
    }
    free(program);
}
