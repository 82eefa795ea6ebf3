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

/* Called by the host while it executes the declared pass, with the context current. The callback
 * leaves GL state as it found it and does not swap, flush or finish. */
typedef void (*strata_gl_fn)(void *user, uint32_t framebuffer);

typedef struct strata_ext_gl {
    uint32_t struct_size;
    uint32_t reserved;
    /* Address of a GL function, NULL when absent. Any time after create(). */
    void *(*get_proc)(const char *name);
    /* GL names of objects; 0 for unknown handles. Valid as long as the handle. */
    uint32_t (*buffer_name)(void *gpu_self, strata_buffer buffer);
    uint32_t (*image_name)(void *gpu_self, strata_image image);
    /* record() only: declares a pass whose binds and attachments order it among the others, and runs
     * `record` in its place. pass->program is ignored. */
    void (*pass)(void *frame_self, const strata_pass *pass, strata_gl_fn record, void *user);
} strata_ext_gl;

#ifdef __cplusplus
}
#endif
#endif
