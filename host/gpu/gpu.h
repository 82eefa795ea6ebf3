/* SPDX-License-Identifier: MIT
 *
 * The device as the rest of the host sees it: handles, scopes, validation, derived barriers,
 * run-time GLSL and pass timings, written once in front of the backends (backend.h). Knows nothing
 * about scenes or techniques; `owner` is a technique's id, for messages and accounts.
 *
 * Errors: creation calls return a result and fill err. Recording calls return nothing; the first
 * failure sticks to the frame (gpu_frame_error), is worded with owner, pass and binding, and later
 * recording calls do nothing until gpu_begin.
 */
#ifndef STRATA_HOST_GPU_H
#define STRATA_HOST_GPU_H

#include "base/base.h"
#include "strata/gpu.h"

typedef struct gpu gpu;
typedef struct gpu_scope gpu_scope;

/* ---- errors the validation layer can report: enum and text; the line says owner, pass and name in
 * front of it. Tests assert the enum through gpu_last_code(). */
#define GPU_ERRORS(X)                                                                              \
    X(NONE, "no error")                                                                            \
    X(STATE, "called in a state that does not allow it")                                           \
    X(HANDLE_UNKNOWN, "unknown handle")                                                            \
    X(HANDLE_DEAD, "the object's scope has ended")                                                 \
    X(VALUE, "a value is missing or out of its range")                                             \
    X(STRUCT_SIZE, "struct_size is too small or its unknown tail is not zero")                     \
    X(BUFFER_SIZE, "buffer size must be positive and a multiple of 4")                             \
    X(BUFFER_RANGE, "offset or size lies outside the buffer")                                      \
    X(BUFFER_LIMIT, "storage range exceeds the device's limit")                                    \
    X(IMAGE_SIZE, "image size is zero or exceeds the device's limit")                              \
    X(IMAGE_FORMAT, "image format does not fit this use")                                          \
    X(IMAGE_SAMPLES, "the number of samples does not fit the device or this use")                  \
    X(POOL_PLANES, "pool planes are missing, too many, or of a bad stride")                        \
    X(PROGRAM_KIND, "program kind and pass do not fit")                                            \
    X(PROGRAM_COMPILE, "program did not compile")                                                  \
    X(PROGRAM_BLOCKS, "a stage uses more storage blocks than the device allows")                   \
    X(BIND_MISSING, "a resource of the program is not bound")                                      \
    X(BIND_UNKNOWN, "the program has no resource of this name")                                    \
    X(BIND_KIND, "bound object does not fit the resource's kind")                                  \
    X(BIND_TWICE, "a name is bound twice")                                                         \
    X(PARAMS_SIZE, "params_size differs from the program's parameter block")                       \
    X(ATTACHMENT_MISSING, "a pass that draws needs an attachment or a size")                       \
    X(ATTACHMENT_SIZE, "attachments differ in size, layers or samples")                            \
    X(ATTACHMENT_HAZARD, "an attachment is also bound for reading or writing")                     \
    X(OUTPUT_TYPE, "the program writes no output of this attachment's type")                       \
    X(SAMPLE_MASK, "samples are masked in full-screen passes on multisampled attachments only")    \
    X(ATTACHMENT_READ, "the program reads other attachments than the pass says")                   \
    X(ORDERED_MISSING, "the device has no ordered attachments that can be read")                   \
    X(OPAQUE_WRITES, "storage is written beside an opaque colour output")                          \
    X(DRAWS_MISSING, "a scene program needs draws")                                                \
    X(GROUPS_LIMIT, "work groups exceed the device's limit")                                       \
    X(INDIRECT_ALIGNMENT, "indirect offset must be a multiple of 4")                               \
    X(LABEL_MISSING, "a pass needs a label")                                                       \
    X(MEMORY, "out of device memory")                                                              \
    X(LOST, "device lost")
typedef enum gpu_code {
#define X(name, text) GPU_ERROR_##name,
    GPU_ERRORS(X)
#undef X
} gpu_code;
const char *gpu_code_text(gpu_code code);

/* ---- device -----------------------------------------------------------------------------------
 */
typedef struct gpu_open_info {
    const char *backend;   /* "vulkan", "gl", "null"; NULL = vulkan, else gl */
    const char *device;    /* index or a part of the name; NULL = first */
    const char *cache_dir; /* SPIR-V and self-test cache; NULL = none */
    int check;             /* driver validation; its messages fail the frame */
    int profile;           /* time each pass */
    /* "allocation:N": the N-th creation fails; "lost:N": the N-th submit; "lacks:FACT" and
     * "claims:FACT": that fact is 0 or 1, whatever the device, several with commas between; or NULL
     */
    const char *inject;
} gpu_open_info;

typedef struct gpu_device_info {
    char backend[16], name[256], driver[256];
} gpu_device_info;

strata_result gpu_open(const gpu_open_info *info, gpu **out, base_error *err);
void gpu_close(gpu *g); /* NULL is fine; destroys what is left in any scope */
void gpu_describe(const gpu *g, gpu_device_info *info);

/* Calls back for each device of each backend that can be opened, without opening an instance. */
void gpu_enumerate(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                   void *user);

/* Facts by string id; unknown = 0. Limits: limit.storage_range, limit.image_size, limit.groups,
 * limit.storage_blocks (of one shader stage),
 * limit.texels (words of a buffer that a usamplerBuffer reads),
 * limit.memory (bytes of device memory, 0 unknown), limit.subgroup (size), limit.samples (of an
 * image, 1 = none is multisampled). Features:
 * feature.int64_atomics, feature.fragment_interlock, feature.raster_order_attachments,
 * feature.framebuffer_fetch, feature.subgroup_ballot, feature.stencil_export. device.software: it
 * computes on the host's processor. Self-tests (run when first asked, cached per driver):
 * selftest.timestamps, selftest.ordered_rmw, selftest.interlock (0 without the feature),
 * selftest.ordered_attachments, selftest.sample_routing. ordered_attachments: one of the features
 * for it, and its self-test. ordered_access: that, selftest.ordered_rmw or selftest.interlock. */
uint64_t gpu_fact(gpu *g, const char *id);

/* ---- scopes and objects -----------------------------------------------------------------------
 */
gpu_scope *gpu_scope_create(gpu *g, const char *owner); /* NULL when out of memory */
void gpu_scope_end(
    gpu_scope *scope); /* destroys its objects; history stays until the owner's last scope ends */

strata_result gpu_buffer_create(gpu_scope *scope, const strata_buffer_desc *desc,
                                strata_buffer *out, base_error *err);
strata_result gpu_image_create(gpu_scope *scope, const strata_image_desc *desc, strata_image *out,
                               base_error *err); /* width and height must be set */
strata_result gpu_pool_create(gpu_scope *scope, const strata_pool_desc *desc, strata_pool *out,
                              base_error *err);
strata_result gpu_program_create(gpu_scope *scope, const strata_program_desc *desc,
                                 strata_program *out, base_error *err);

typedef struct gpu_draws_desc {
    strata_buffer commands; /* VkDrawIndexedIndirectCommand, 20 bytes each, tightly packed */
    strata_buffer count;    /* a uint, or the zero handle: all `capacity` commands are drawn */
    strata_buffer indices;  /* uint32 */
    uint32_t capacity;
} gpu_draws_desc;
strata_result gpu_draws_create(gpu_scope *scope, const gpu_draws_desc *desc, strata_draws *out,
                               base_error *err);

/* Bytes of device memory held by scopes of this owner; owner NULL = all. Peak: most at any time. */
uint64_t gpu_bytes(const gpu *g, const char *owner);
uint64_t gpu_bytes_peak(const gpu *g, const char *owner);

/* Text that #include "NAME" finds beside shaders/strata (the generated effect header), and defines
 * that every program created from now on gets. Both copied; NULL text removes. */
strata_result gpu_set_include(gpu *g, const char *name, const char *text, base_error *err);
strata_result gpu_set_define(gpu *g, const char *name, const char *value, base_error *err);

/* A source of shaders/strata by its path ("strata/elements.glsl"), NULL when there is none. */
const strata_glsl *gpu_library_find(const char *path);

/* Resources that a pass uses by name without binding them (the host's Strata* blocks). Replaces an
 * earlier one of that name; bind NULL removes. A pass's own binds come first. */
strata_result gpu_set_global(gpu *g, const char *name, const strata_bind *bind, base_error *err);

/* ---- recording --------------------------------------------------------------------------------
 */

/* Starts a frame (a band of one). Pools: `needed` becomes 0. Rectangle: the scissor of every pass
 * that does not set whole_frame, and the frame size for full-screen passes without attachments. */
void gpu_begin(gpu *g, uint32_t frame_width, uint32_t frame_height);
void gpu_rectangle(gpu *g, uint32_t x, uint32_t y, uint32_t width, uint32_t height);
void gpu_pass(gpu *g, const char *owner, const strata_pass *pass);
void gpu_fill(gpu *g, const char *owner, strata_buffer buffer, uint64_t offset, uint64_t size,
              uint32_t value);
void gpu_copy(gpu *g, const char *owner, strata_buffer to, uint64_t to_offset, strata_buffer from,
              uint64_t from_offset, uint64_t size);
/* Clears a colour or depth image as a whole (depth in value[0]). */
void gpu_clear_image(gpu *g, const char *owner, strata_image image, const float value[4]);
/* Submits what was recorded and waits. Returns the frame's first error. Recording may go on after.
 */
strata_result gpu_submit(gpu *g, base_error *err);
gpu_code gpu_last_code(const gpu *g);
/* The frame's first error so far; result STRATA_OK when none. */
const base_error *gpu_frame_error(const gpu *g);
/* A technique's own failure, worded by it. */
void gpu_frame_fail(gpu *g, const char *owner, strata_result result, const char *text);

/* Host access, outside recording or after gpu_submit. */
strata_result gpu_buffer_read(gpu *g, strata_buffer buffer, uint64_t offset, uint64_t size,
                              void *data, base_error *err);
strata_result gpu_buffer_write(gpu *g, strata_buffer buffer, uint64_t offset, uint64_t size,
                               const void *data, base_error *err);
/* Tightly packed texels of one layer, row 0 first. */
strata_result gpu_image_read(gpu *g, strata_image image, uint32_t layer, void *texels, size_t size,
                             base_error *err);
strata_result gpu_image_write(gpu *g, strata_image image, uint32_t layer, uint32_t x, uint32_t y,
                              uint32_t width, uint32_t height, const void *texels, base_error *err);
uint32_t gpu_format_bytes(uint32_t format); /* bytes a texel, 0 for unknown */
strata_result gpu_image_size(const gpu *g, strata_image image, uint32_t *width, uint32_t *height);

/* ---- native passes and objects: what stands behind strata/ext/ ----------------------------------
 */
typedef enum gpu_native_kind {
    GPU_NATIVE_INSTANCE, /* Vulkan: of the device; the others of an object */
    GPU_NATIVE_PHYSICAL_DEVICE,
    GPU_NATIVE_DEVICE,
    GPU_NATIVE_BUFFER,
    GPU_NATIVE_IMAGE,
    GPU_NATIVE_VIEW /* of an image: Vulkan only */
} gpu_native_kind;

/* `handle`: OpenGL: the name of a framebuffer object; Vulkan: the VkCommandBuffer; null: 0. */
typedef void (*gpu_native_fn)(void *user, uint64_t handle);

/* Of the pass, label, binds, attachments' images, whole_frame, width and height count. Everything
 * bound or attached is taken as read and written by any stage; pools bring their planes and
 * counter. `call` is made once, before this returns, unless the frame has failed. */
void gpu_pass_native(gpu *g, const char *owner, const strata_pass *pass, gpu_native_fn call,
                     void *user);
/* 0 for unknown handles, and for what the backend does not have. */
uint64_t gpu_native_object(const gpu *g, gpu_native_kind kind);
uint64_t gpu_native_buffer(const gpu *g, strata_buffer buffer);
uint64_t gpu_native_image(const gpu *g, strata_image image, gpu_native_kind kind);
/* Plane number `plane`; the counter is the one after the last. */
uint64_t gpu_native_pool(const gpu *g, strata_pool pool, uint32_t plane);
/* A function of the backend's API, NULL where there is none. */
void *gpu_native_proc(const gpu *g, const char *name);
void *gpu_native_proc_gl(const char *name); /* OpenGL's, of no particular device */

/* ---- pools ------------------------------------------------------------------------------------
 */
uint64_t gpu_pool_capacity(const gpu *g, strata_pool pool);
/* After gpu_submit: elements that the frame's last band asked for (saturated at 2^32 - 1). */
strata_result gpu_pool_needed(gpu *g, strata_pool pool, uint64_t *needed, base_error *err);
/* Most elements that the pool could have: storage range over its widest plane. */
uint64_t gpu_pool_limit(const gpu *g, strata_pool pool);
uint64_t gpu_pool_element_bytes(const gpu *g, strata_pool pool); /* over all planes */
/* Contents are lost. Frees before it allocates. On failure the pool has the minimum capacity. */
strata_result gpu_pool_grow(gpu *g, strata_pool pool, uint64_t capacity, base_error *err);
strata_buffer gpu_pool_plane(const gpu *g, strata_pool pool, uint32_t plane); /* for reading back */

/* ---- what it cost -----------------------------------------------------------------------------
 */
typedef struct gpu_timing {
    char label[64], owner[64];
    double gpu_ms; /* < 0: not measured */
    double cpu_ms; /* recording */
} gpu_timing;
/* Of everything since gpu_begin, in order; valid until the next gpu_begin. */
const gpu_timing *gpu_timings(const gpu *g, uint32_t *count);

/* The null backend's log: one line for each call, for tests. NULL on other backends. */
const char *gpu_null_log(const gpu *g);

#endif
