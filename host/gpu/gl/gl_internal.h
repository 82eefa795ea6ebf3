/* SPDX-License-Identifier: MIT
 *
 * What the files of the OpenGL backend share: the device, its objects, and the helpers that every
 * one of them leans on. Stands behind host/gpu/backend.h: calls are validated, barriers derived.
 *
 * Decisions that hold everywhere: the context is current only between gl_enter and gl_leave, which
 * nest and give back what the embedding program had current; all objects are used by name (direct
 * state access); a submission is finished before the call that made it returns.
 */
#ifndef STRATA_HOST_GPU_GL_INTERNAL_H
#define STRATA_HOST_GPU_GL_INTERNAL_H

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "gpu/backend.h"
#include "gpu/gl/gl_functions.h"

#define GPU_GL_MAX_COLORS  8u
#define GPU_GL_MAX_DEVICES 32u

typedef struct gl_format {
    GLenum internal, format, type; /* storage; pixel transfer of the host's texels */
    uint32_t texel; /* bytes a texel on the host; D32F_S8: depth word, stencil word */
    uint32_t integer, depth, stencil;
} gl_format;

typedef struct gl_buffer {
    GLuint name;
    GLuint texels; /* a texture of its words; made when first bound as such */
    uint64_t size;
} gl_buffer;

typedef struct gl_image {
    GLuint name;
    const gl_format *format;
    uint32_t width, height, layers; /* layers 0: a plain 2D texture */
    uint32_t samples;
} gl_image;

typedef struct gl_program {
    GLuint name;
    uint32_t kind;             /* STRATA_PROGRAM_* */
    const gpu_binding *params; /* its parameter block, or NULL */
} gl_program;

/* A framebuffer object and the attachments that it was made for. */
typedef struct gl_target {
    GLuint name;
    const gl_image *color[GPU_GL_MAX_COLORS], *depth;
} gl_target;

/* What the embedding program had current. */
typedef struct gl_saved {
    EGLenum api;
    EGLDisplay display;
    EGLContext context;
    EGLSurface draw, read;
} gl_saved;

/* Whether the driver's timer queries agree with the monotonic clock. */
typedef enum gl_timer_trust {
    GPU_GL_TIMER_UNTESTED,
    GPU_GL_TIMER_SOUND,
    GPU_GL_TIMER_UNSOUND
} gl_timer_trust;

typedef struct gl_sample { /* one measured pass of the submission */
    uint32_t timed;        /* gpu_native_pass.timed */
    GLuint query;          /* 0: `ms` holds the time */
    double ms;
} gl_sample;

typedef struct gl {
    gl_functions fn;
    EGLDisplay display;
    EGLContext context;
    gl_saved saved;
    uint32_t entered;

    int check, lost, recording;
    base_error failure; /* of recording; returned by submit */
    char message[400];  /* the driver's first complaint since the last report */
    const char *where;  /* what is being executed, for the driver's messages */
    GLint limits[GPU_BINDING_STORAGE_IMAGE + 1]; /* binding points by gpu_group */

    GLuint vertex_array, bare_target; /* a draw needs one; framebuffer without attachments */
    uint32_t bare_width, bare_height;
    gl_target *targets;
    size_t target_count, target_capacity;
    GLuint writing_target; /* fragments of the pass before this wrote storage, into this target */

    GLuint ring; /* parameter blocks of the submission */
    unsigned char *ring_map;
    uint32_t ring_used, ring_alignment;

    gl_timer_trust timer;
    int timing; /* between gl_timer_begin and gl_timer_end of a measured pass */
    gl_sample *samples;
    size_t sample_count, sample_capacity;
    GLuint *queries; /* reused from submission to submission */
    size_t query_count, query_capacity, query_used;
} gl;

/* gl_context.c: displays, the context, and its being current. */

/* Displays that an instance could live on, in order of preference; returns how many. */
uint32_t gl_displays(EGLDisplay displays[GPU_GL_MAX_DEVICES]);
int gl_is_software(const gl *g); /* whether its display's device is the host's processor */
/* Makes the context on `display` and loads the functions. On success the caller is inside gl_enter.
 */
strata_result gl_context_create(gl *g, EGLDisplay display, base_error *err);
void gl_context_destroy(gl *g); /* ends the caller's gl_enter */
/* Makes the context current. Every success wants its gl_leave; after a failure there is none. */
strata_result gl_enter(gl *g, base_error *err);
void gl_leave(gl *g);
int gl_has(const gl *g, const char *extension);
int gl_has_spirv(const gl *g, const char *extension);

/* gl_device.c: what can be known of the device, and whether it is well. */

/* Ends a call: GL errors, driver messages and a reset since the last report turn `result`, where it
 * is a success, into OUT_OF_DEVICE_MEMORY, DEVICE_LOST or INTERNAL, worded with `what`. */
strata_result gl_report(gl *g, strata_result result, const char *what, base_error *err);

/* gl_objects.c */
strata_result gl_buffer_create(void *self, const strata_buffer_desc *desc, void **native,
                               base_error *err);
void gl_buffer_destroy(void *self, void *native);
strata_result gl_image_create(void *self, const strata_image_desc *desc, void **native,
                              base_error *err);
void gl_image_destroy(void *self, void *native);
strata_result gl_program_create(void *self, const gpu_program_info *info, void **native,
                                base_error *err);
void gl_program_destroy(void *self, void *native);
/* `value` of a clear as the format's own host texel: 16 bytes at most. */
void gl_clear_texel(const gl_format *format, const float value[4], uint32_t texel[4]);
/* Links shaders into a program and deletes them; 0 after a failure. */
GLuint gl_link(gl *g, const GLuint *shaders, uint32_t count, const char *label, base_error *err);

/* gl_text.c: programs that read attachments, which SPIR-V cannot say; 0 after a failure. */
GLuint gl_text_build(gl *g, const gpu_program_info *info, base_error *err);

/* gl_transfer.c */
strata_result gl_buffer_read(void *self, void *native, uint64_t offset, uint64_t size, void *data,
                             base_error *err);
strata_result gl_buffer_write(void *self, void *native, uint64_t offset, uint64_t size,
                              const void *data, base_error *err);
strata_result gl_image_read(void *self, void *native, uint32_t layer, void *texels, size_t size,
                            base_error *err);
strata_result gl_image_write(void *self, void *native, uint32_t layer, uint32_t x, uint32_t y,
                             uint32_t width, uint32_t height, const void *texels, base_error *err);

/* gl_target.c: framebuffer objects, one for each set of attachments, kept until an image goes. */

/* The framebuffer of a pass; 0 after a failure, which is kept. */
GLuint gl_target_get(gl *g, const gpu_native_pass *pass);
void gl_targets_forget(gl *g, const gl_image *image);

/* gl_record.c */
void gl_pass(void *self, const gpu_native_pass *pass);
void gl_fill(void *self, void *buffer, uint64_t offset, uint64_t size, uint32_t value,
             const gpu_barrier *barriers, uint32_t barrier_count);
void gl_copy(void *self, void *to, uint64_t to_offset, void *from, uint64_t from_offset,
             uint64_t size, const gpu_barrier *barriers, uint32_t barrier_count);
void gl_clear_image(void *self, void *image, const float value[4], const gpu_barrier *barriers,
                    uint32_t barrier_count);

/* gl_native.c: native passes and objects. */

/* The state that passes do not set themselves, whatever it was before. */
void gl_state_set(gl *g);
void gl_native_run(gl *g, const gpu_native_pass *pass);
uint64_t gl_native_handle(void *self, void *native, gpu_native_kind kind);
void *gl_get_proc(void *self, const char *name);

/* gl_submit.c: from begin to submit. */
void gl_begin(void *self);
/* Whether recording may go on: begins it where it has not begun; 0 after a failure. */
int gl_recording(gl *g);
strata_result gl_submit(void *self, double *ms, uint32_t timing_count, base_error *err);

/* gl_timer.c: the time between the two calls, where `timed` is not 0. */
void gl_timer_begin(gl *g, uint32_t timed);
void gl_timer_end(gl *g);
/* After the device has finished: hands out the submission's times and forgets them. */
void gl_timers_collect(gl *g, double *ms, uint32_t count);

#endif
