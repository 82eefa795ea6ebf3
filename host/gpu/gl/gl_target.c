/* SPDX-License-Identifier: MIT
 *
 * Framebuffer objects of the OpenGL backend: one for each set of attachments that a pass has used,
 * kept until one of the images goes; and one without attachments, resized as needed.
 */
#include "gpu/gl/gl_internal.h"

#include <stdlib.h>
#include <string.h>

static int target_fits(const gl_target *target, const gpu_native_pass *pass) {
    for (uint32_t i = 0; i < GPU_GL_MAX_COLORS; i++) {
        const void *wanted = i < pass->pass->color_count ? pass->color[i] : NULL;
        if ((const void *)target->color[i] != wanted)
            return 0;
    }
    return (const void *)target->depth == pass->depth;
}

/* Arrays are layered attachments where all are arrays; beside a plain image, their layer 0 is. */
static void target_attach(gl *g, GLuint name, GLenum point, const gl_image *image, int layered) {
    if (image->layers && !layered)
        g->fn.NamedFramebufferTextureLayer(name, point, image->name, 0, 0);
    else
        g->fn.NamedFramebufferTexture(name, point, image->name, 0);
}

static GLuint target_build(gl *g, const gl_target *target) {
    GLenum buffers[GPU_GL_MAX_COLORS];
    GLuint name = 0;
    GLsizei count = 0;
    int layered = !target->depth || target->depth->layers;
    for (uint32_t i = 0; i < GPU_GL_MAX_COLORS; i++)
        layered = layered && (!target->color[i] || target->color[i]->layers);
    g->fn.CreateFramebuffers(1, &name);
    for (uint32_t i = 0; i < GPU_GL_MAX_COLORS; i++) {
        buffers[i] = GL_NONE;
        if (target->color[i]) {
            buffers[i] = GL_COLOR_ATTACHMENT0 + i;
            count = (GLsizei)i + 1;
            target_attach(g, name, buffers[i], target->color[i], layered);
        }
    }
    if (target->depth)
        target_attach(g, name,
                      target->depth->format->stencil ? GL_DEPTH_STENCIL_ATTACHMENT
                                                     : GL_DEPTH_ATTACHMENT,
                      target->depth, layered);
    g->fn.NamedFramebufferDrawBuffers(name, count, buffers);
    GLenum status = g->fn.CheckNamedFramebufferStatus(name, GL_DRAW_FRAMEBUFFER);
    if (status == GL_FRAMEBUFFER_COMPLETE)
        return name;
    g->fn.DeleteFramebuffers(1, &name);
    base_fail(&g->failure, STRATA_ERROR_UNSUPPORTED,
              "gl: pass %s: the driver refuses this set of attachments (status 0x%04x)", g->where,
              status);
    return 0;
}

static GLuint target_bare(gl *g, uint32_t width, uint32_t height) {
    if (!g->bare_target)
        g->fn.CreateFramebuffers(1, &g->bare_target);
    if (g->bare_width != width || g->bare_height != height) {
        g->fn.NamedFramebufferParameteri(g->bare_target, GL_FRAMEBUFFER_DEFAULT_WIDTH,
                                         (GLint)width);
        g->fn.NamedFramebufferParameteri(g->bare_target, GL_FRAMEBUFFER_DEFAULT_HEIGHT,
                                         (GLint)height);
        g->bare_width = width;
        g->bare_height = height;
    }
    return g->bare_target;
}

GLuint gl_target_get(gl *g, const gpu_native_pass *pass) {
    if (pass->pass->color_count == 0 && !pass->depth)
        return target_bare(g, pass->width, pass->height);
    for (size_t i = 0; i < g->target_count; i++)
        if (target_fits(&g->targets[i], pass))
            return g->targets[i].name;
    gl_target *targets =
        base_grow(g->targets, &g->target_capacity, g->target_count, sizeof *g->targets);
    if (!targets) {
        base_fail(&g->failure, STRATA_ERROR_OUT_OF_HOST_MEMORY, "gl: pass %s: out of memory",
                  g->where);
        return 0;
    }
    g->targets = targets;
    gl_target target = {.depth = pass->depth};
    for (uint32_t i = 0; i < pass->pass->color_count; i++)
        target.color[i] = pass->color[i];
    target.name = target_build(g, &target);
    if (target.name)
        g->targets[g->target_count++] = target;
    return target.name;
}

void gl_targets_forget(gl *g, const gl_image *image) {
    size_t kept = 0;
    for (size_t i = 0; i < g->target_count; i++) {
        const gl_target *target = &g->targets[i];
        int gone = target->depth == image;
        for (uint32_t k = 0; k < GPU_GL_MAX_COLORS; k++)
            gone = gone || target->color[k] == image;
        if (gone)
            g->fn.DeleteFramebuffers(1, &target->name);
        else
            g->targets[kept++] = *target;
    }
    g->target_count = kept;
}
