/* SPDX-License-Identifier: MIT
 *
 * The transfer in OpenGL, through strata.gl/1 alone. It leaves some state behind, as a module
 * should not: the host's passes after it must not notice.
 */
#include <GL/glcorearb.h>
#include <string.h>

#include "native.h"

typedef void (*any_function)(void);

static any_function find(const native *n, const char *name) {
    void *address = n->gl->get_proc(name);
    any_function function;
    memcpy(&function, &address, sizeof function);
    return function;
}

static void transfer(void *user, uint32_t framebuffer) {
    const native *n = user;
    const uint32_t quarter = NATIVE_QUARTER, constant = NATIVE_POOL;
    const GLuint source = n->gl->buffer_name(n->gpu->self, n->source),
                 target = n->gl->buffer_name(n->gpu->self, n->target),
                 plane = n->gl->pool_name(n->gpu->self, n->pool, 0);
    const GLsizeiptr half = (GLsizeiptr)(n->bytes / 2);
    PFNGLCOPYNAMEDBUFFERSUBDATAPROC copy =
        (PFNGLCOPYNAMEDBUFFERSUBDATAPROC)find(n, "glCopyNamedBufferSubData");
    PFNGLCLEARNAMEDBUFFERSUBDATAPROC clear =
        (PFNGLCLEARNAMEDBUFFERSUBDATAPROC)find(n, "glClearNamedBufferSubData");
    copy(source, target, 0, 0, half);
    clear(target, GL_R32UI, half, half, GL_RED_INTEGER, GL_UNSIGNED_INT, &quarter);
    clear(plane, GL_R32UI, 0, 256, GL_RED_INTEGER, GL_UNSIGNED_INT, &constant);
    ((PFNGLENABLEPROC)find(n, "glEnable"))(GL_RASTERIZER_DISCARD);
    ((PFNGLFRONTFACEPROC)find(n, "glFrontFace"))(GL_CW);
    ((PFNGLUSEPROGRAMPROC)find(n, "glUseProgram"))(0);
    ((PFNGLBINDVERTEXARRAYPROC)find(n, "glBindVertexArray"))(0);
    ((PFNGLBINDFRAMEBUFFERPROC)find(n, "glBindFramebuffer"))(GL_FRAMEBUFFER, framebuffer);
    if (n->mistake)
        ((PFNGLENABLEPROC)find(n, "glEnable"))(0xffffu);
}

void native_pass_gl(native *n, void *frame_self, const strata_pass *pass) {
    n->gl->pass(frame_self, pass, transfer, n);
}
