/* SPDX-License-Identifier: MIT
 *
 * The table that a backend fills: gl/, vk/ and null/ stand behind it. Everything that arrives here
 * is validated, handles are resolved to native objects, barriers are derived. The enumerations are
 * those of strata/gpu.h, so that backend and public interface cannot drift apart.
 */
#ifndef STRATA_HOST_GPU_BACKEND_H
#define STRATA_HOST_GPU_BACKEND_H

#include "gpu/gpu.h"

/* How a resource is touched; the union of these is what a barrier waits for or makes visible. */
#define GPU_ACCESS_INDIRECT      1u
#define GPU_ACCESS_INDEX         2u
#define GPU_ACCESS_UNIFORM       4u
#define GPU_ACCESS_SAMPLED       8u
#define GPU_ACCESS_STORAGE_READ  16u
#define GPU_ACCESS_STORAGE_WRITE 32u
#define GPU_ACCESS_COLOR         64u  /* attachment, read by blending and written */
#define GPU_ACCESS_DEPTH         128u /* attachment, tested and written */
#define GPU_ACCESS_COPY_READ     256u
#define GPU_ACCESS_COPY_WRITE    512u
#define GPU_ACCESS_NATIVE        1024u /* a native pass: any access, in any stage */
#define GPU_ACCESS_COLOR_READ    2048u /* attachment, read by the fragment shader too */
#define GPU_ACCESS_WRITES                                                                          \
    (GPU_ACCESS_STORAGE_WRITE | GPU_ACCESS_COLOR | GPU_ACCESS_DEPTH | GPU_ACCESS_COPY_WRITE |      \
     GPU_ACCESS_NATIVE)

#define GPU_STAGE_VERTEX   1u
#define GPU_STAGE_FRAGMENT 2u
#define GPU_STAGE_COMPUTE  4u

typedef struct gpu_barrier { /* memory dependency on one object, before the coming command */
    void *native;
    uint32_t is_image;
    uint32_t before, after;               /* GPU_ACCESS_* */
    uint32_t stages_before, stages_after; /* GPU_STAGE_* for shader accesses */
} gpu_barrier;

typedef enum gpu_binding_kind {
    GPU_BINDING_UNIFORM,
    GPU_BINDING_STORAGE,
    GPU_BINDING_SAMPLED, /* combined image sampler: nearest, clamp to edge; texelFetch mostly */
    GPU_BINDING_STORAGE_IMAGE,
    GPU_BINDING_TEXELS,    /* the words of a buffer, from its first, as texels of R32U */
    GPU_BINDING_PARAMS,    /* Vulkan: push constants; GL: a uniform buffer */
    GPU_BINDING_ATTACHMENT /* Vulkan: an input attachment, that colour attachment of the pass */
} gpu_binding_kind;

typedef struct gpu_binding { /* reflected from SPIR-V; `binding` is unique within its gpu_group (GL)
                                or set 0 (Vulkan) */
    char name[64];
    gpu_binding_kind kind;
    uint32_t binding;
    uint32_t stages; /* GPU_STAGE_* */
    uint32_t access; /* GPU_ACCESS_* that its qualifiers allow */
    uint32_t size;   /* of a block, bytes, an unsized array at its end left out; images: 0 */
    uint32_t format; /* of a storage image: STRATA_FORMAT_*, 0 when the shader names none */
    uint32_t arrayed, is_unsigned; /* images: 2D array; uimage or usampler */
    uint32_t multisampled;         /* samplers */
    uint32_t attachment;           /* of GPU_BINDING_ATTACHMENT: its number */
} gpu_binding;

/* OpenGL counts by these: parameters are uniform blocks there, and texels take a texture unit. */
static inline gpu_binding_kind gpu_group(gpu_binding_kind kind) {
    return kind == GPU_BINDING_PARAMS   ? GPU_BINDING_UNIFORM
           : kind == GPU_BINDING_TEXELS ? GPU_BINDING_SAMPLED
                                        : kind;
}

typedef struct gpu_program_info {
    const char *label;
    uint32_t kind;            /* STRATA_PROGRAM_* */
    const uint32_t *spirv[2]; /* compute: [0]; else vertex, fragment */
    size_t words[2];
    const gpu_binding *bindings; /* lives as long as the program */
    uint32_t binding_count;
    uint32_t params_size;
    uint32_t reads; /* bit i: the fragment stage reads colour attachment i */
} gpu_program_info;

typedef struct gpu_native_bind {
    const gpu_binding *binding;
    void *native;          /* buffer or image */
    uint64_t offset, size; /* of buffers */
} gpu_native_bind;

typedef struct gpu_native_pass {
    const strata_pass *pass; /* params, groups, tests, blend, attachments' load, clear, masks */
    void *program; /* NULL: a native pass, whose call stands in place of draw or dispatch */
    gpu_native_fn call;
    void *user; /* first argument of call */
    const gpu_native_bind *binds;
    uint32_t bind_count;
    const gpu_barrier *barriers;
    uint32_t barrier_count;
    void *color[8]; /* native images of pass->color */
    void *depth;
    uint32_t width, height; /* of the target */
    uint32_t scissor[4]; /* x, y, width, height; may be empty. Loads clear the whole attachment */
    void *commands, *count, *indices; /* draws; min(count, draw_capacity) of the commands */
    uint32_t draw_capacity;
    uint32_t counted; /* 1: by the GPU; 0: count is draw_capacity */
    void *indirect;   /* dispatch */
    uint32_t timed;   /* index of its timing + 1, or 0 */
} gpu_native_pass;

typedef struct gpu_backend_caps {
    char name[256], driver[256];
    uint64_t storage_range, memory; /* bytes; memory 0 = unknown */
    uint64_t texels;                /* of a GPU_BINDING_TEXELS */
    uint32_t software;              /* 1: it computes on the host's processor */
    uint32_t image_size, groups, subgroup;
    uint32_t samples;        /* the most of an image; 1: none is multisampled */
    uint32_t storage_blocks; /* that one shader stage can use */
    uint32_t int64, int64_atomics, fragment_interlock, raster_order_attachments, framebuffer_fetch,
        subgroup_ballot, stencil_export;
    uint32_t vulkan_target; /* 1: wants SPIR-V for Vulkan; 0: SPIR-V for OpenGL */
} gpu_backend_caps;

/* Results are STRATA_OK, OUT_OF_DEVICE_MEMORY, OUT_OF_HOST_MEMORY, DEVICE_LOST, UNSUPPORTED,
 * SHADER. After DEVICE_LOST every call but destroy and close returns DEVICE_LOST or does nothing.
 */
typedef struct gpu_backend {
    const char *name;
    strata_result (*open)(const gpu_open_info *info, void **self, gpu_backend_caps *caps,
                          base_error *err);
    void (*close)(void *self);
    void (*enumerate)(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                      void *user);

    /* New buffers and images are zero. */
    strata_result (*buffer_create)(void *self, const strata_buffer_desc *desc, void **native,
                                   base_error *err);
    void (*buffer_destroy)(void *self, void *native);
    strata_result (*image_create)(void *self, const strata_image_desc *desc, void **native,
                                  base_error *err);
    void (*image_destroy)(void *self, void *native);
    strata_result (*program_create)(void *self, const gpu_program_info *info, void **native,
                                    base_error *err);
    void (*program_destroy)(void *self, void *native);

    /* Host access; the device is idle. D32F_S8 reads as a float and a uint32 (stencil) a texel. */
    strata_result (*buffer_read)(void *self, void *native, uint64_t offset, uint64_t size,
                                 void *data, base_error *err);
    strata_result (*buffer_write)(void *self, void *native, uint64_t offset, uint64_t size,
                                  const void *data, base_error *err);
    strata_result (*image_read)(void *self, void *native, uint32_t layer, void *texels, size_t size,
                                base_error *err);
    strata_result (*image_write)(void *self, void *native, uint32_t layer, uint32_t x, uint32_t y,
                                 uint32_t width, uint32_t height, const void *texels,
                                 base_error *err);

    /* Recording: begin .. submit. Failures are kept and returned by submit. */
    void (*begin)(void *self);
    void (*pass)(void *self, const gpu_native_pass *pass);
    void (*fill)(void *self, void *buffer, uint64_t offset, uint64_t size, uint32_t value,
                 const gpu_barrier *barriers, uint32_t barrier_count);
    void (*copy)(void *self, void *to, uint64_t to_offset, void *from, uint64_t from_offset,
                 uint64_t size, const gpu_barrier *barriers, uint32_t barrier_count);
    void (*clear_image)(void *self, void *image, const float value[4], const gpu_barrier *barriers,
                        uint32_t barrier_count);
    /* Submits and waits. ms[i] of the pass with timed == i + 1, < 0 when unmeasured. */
    strata_result (*submit)(void *self, double *ms, uint32_t timing_count, base_error *err);

    /* What a native pass works on: a handle of the backend's API, 0 where it has none of this kind.
     * `native` is the buffer or image; NULL for the device's own objects. */
    uint64_t (*native_handle)(void *self, void *native, gpu_native_kind kind);
    /* A function of that API, or NULL. `self` may be NULL on OpenGL. */
    void *(*get_proc)(void *self, const char *name);

    /* NULL-terminated text; null backend only, else NULL. */
    const char *(*log)(void *self);
} gpu_backend;

extern const gpu_backend gpu_backend_vulkan, gpu_backend_gl, gpu_backend_null;

#endif
