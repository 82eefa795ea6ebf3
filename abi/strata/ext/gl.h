/* SPDX-License-Identifier: MIT
 *
 * strata/ext/gl.h - extension "strata.gl/1": native OpenGL objects for a technique that needs what
 * the passes of gpu.h cannot say. Absent (NULL) on other backends; keep a portable path beside it.
 */
#ifndef STRATA_EXT_GL_H
#define STRATA_EXT_GL_H

#include "../frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define STRATA_EXT_GL "strata.gl/1"

/* `gpu_self` is strata_gpu.self, `frame_self` strata_frame.self.
 *
 * Called by the host while it executes the declared pass, with the context current (OpenGL 4.5 core
 * or later). `framebuffer` is the name of an object with the pass's attachments in their order, or
 * without any and of the pass's size; it belongs to the host and stays as it is. The callback finds
 * it bound for drawing, the viewport over all of it, the scissor on the band's rectangle (on all
 * of it with whole_frame), masks open, tests, blending and culling off, depth from 0 to 1. It
 * leaves GL state as it found it, does not swap, flush or finish, and keeps what it draws inside the
 * scissor. A GL error that it causes fails the frame. */
typedef void (*strata_gl_fn)(void *user, uint32_t framebuffer);

typedef struct strata_ext_gl {
    uint32_t struct_size;
    uint32_t reserved;
    /* Address of a GL function; NULL when absent, but drivers may have one for what they lack: ask
     * for version and extensions, inside a pass. From create() on. */
    void *(*get_proc)(const char *name);
    /* GL names of objects; 0 for unknown handles. Valid as long as the handle. From create() on.
     * Storage is immutable: contents may change, nothing else of the object. */
    uint32_t (*buffer_name)(void *gpu_self, strata_buffer buffer);
    uint32_t (*image_name)(void *gpu_self, strata_image image);
    /* record() only: declares a pass whose binds and attachments order it among the others, and runs
     * `record` in its place. pass->program is ignored, as is all but label, binds, the attachments'
     * images, whole_frame, width and height: clears, blending and masks are the callback's. All that is bound or
     * attached counts as read and written; the names of binds appear in messages only, and the
     * callback touches no object of the host that is not there. The host has made what was written
     * before visible, and makes visible afterwards what `record` writes. `record` is called once,
     * on this thread, before the band is submitted, and not at all once the frame has failed; what
     * `user` points to lives until then: until verify(). */
    void (*pass)(void *frame_self, const strata_pass *pass, strata_gl_fn record, void *user);
    /* GL name of plane number `plane` of a pool; of its counter, the one after the last plane. Valid
     * during the record() in which it was asked for: pools grow. */
    uint32_t (*pool_name)(void *gpu_self, strata_pool pool, uint32_t plane);
} strata_ext_gl;

#ifdef __cplusplus
}
#endif
#endif
