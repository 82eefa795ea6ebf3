/* SPDX-License-Identifier: MIT
 *
 * strata/gpu.h - storage, programs and passes: what a technique asks of the device. One technique
 * is written once against this header and runs on every backend.
 *
 * Conventions on all backends: reversed depth (1 near, 0 far), row 0 of an image is the lowest row
 * of the picture, texel (x, y) covers gl_FragCoord.xy in [x, x+1) x [y, y+1), front faces wind
 * counter-clockwise, the first vertex is the provoking one.
 *
 * Lifetimes are scopes. What a technique creates in its create() lives until its destroy(); what it
 * creates in prepare() dies before its next prepare() or its destroy(); creation anywhere else, and
 * of pools in create(), is STRATA_ERROR_INVALID_STATE. Nothing is freed by hand. Handles are small integers, never reused
 * within an instance; id 0 is no object.
 *
 * Barriers are derived by the host from the qualifiers of the GLSL (readonly, writeonly) and from
 * attachments; a technique writes none, and never submits or waits.
 */
#ifndef STRATA_GPU_H
#define STRATA_GPU_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct strata_buffer { uint32_t id; } strata_buffer;
typedef struct strata_image { uint32_t id; } strata_image;
typedef struct strata_program { uint32_t id; } strata_program;
typedef struct strata_pool { uint32_t id; } strata_pool;   /* storage that grows, see below */
typedef struct strata_draws { uint32_t id; } strata_draws; /* the contents of a draws.* slot */

/* Image formats. All can be rendered to (depth formats: as depth) and read; all colour formats can
 * be storage images. */
#define STRATA_FORMAT_RGBA32F 1u
#define STRATA_FORMAT_RGBA16F 2u
#define STRATA_FORMAT_RGBA8 3u
#define STRATA_FORMAT_RGBA8_SRGB 4u /* sampled only */
#define STRATA_FORMAT_R32F 5u
#define STRATA_FORMAT_R32U 6u
#define STRATA_FORMAT_RG32U 7u
#define STRATA_FORMAT_RGBA32U 8u
#define STRATA_FORMAT_D32F 9u
#define STRATA_FORMAT_D32F_S8 10u

/* A GLSL text and the path that compile errors name. Both live as long as the module. */
typedef struct strata_glsl {
    const char *text;
    const char *path;
} strata_glsl;

typedef struct strata_buffer_desc {
    uint32_t struct_size;
    uint32_t reserved;
    const char *label;   /* for messages and accounts; copied */
    uint64_t size;       /* bytes, > 0, a multiple of 4 */
    const void *data;    /* initial contents, `size` bytes, or NULL = zeros; copied */
    const char *history; /* not NULL: contents outlive prepare() under this name while size holds */
} strata_buffer_desc;

typedef struct strata_image_desc {
    uint32_t struct_size;
    uint32_t format; /* STRATA_FORMAT_* */
    const char *label;
    uint32_t width, height; /* 0 = the frame's */
    uint32_t layers;        /* 0 = a plain 2D image; n >= 1 = a 2D array of n layers */
    uint32_t samples;       /* 0 or 1 = one a texel; else multisampled, see below */
    const char *history;    /* as above */
} strata_image_desc;

/* A multisampled image has 2, 4, 8 .. samples a texel, at most the fact "limit.samples", no layers,
 * and a format of depth or of floats (RGBA8 too). Passes draw into it and shaders read it, by
 * texelFetch of a sampler2DMS; it is no storage image.
 *
 * Its samples are many values of one pixel, not places in it: all lie at the centre, so that a
 * fragment reaches all of them or none, and each tests it against a depth and stencil of its own.
 * Where the fact "selftest.sample_routing" is 0 the device is not so: samples may miss fragments. */

/* A pool is a set of planes (arrays) of one common capacity that only the GPU learns. Its GLSL
 * counter block holds { uint needed; uint capacity; }: shaders add to `needed` and write slots below
 * `capacity` only. `needed` is zero when a band starts. After the frame the host compares the two;
 * where more was needed it grows the pool, or splits the frame into bands, and records again.
 * Contents are undefined when a frame starts. A technique has at most 16 of them. */
#define STRATA_MAX_PLANES 8
typedef struct strata_pool_desc {
    uint32_t struct_size;
    uint32_t plane_count;                        /* 1..STRATA_MAX_PLANES */
    const char *label;
    const char *counter_name;                    /* GLSL block name of the counter */
    const char *plane_names[STRATA_MAX_PLANES];  /* GLSL block names */
    uint32_t plane_strides[STRATA_MAX_PLANES];   /* bytes an element: 4 or 8 */
    uint64_t expected;                           /* elements to begin with; 0 = the host's guess */
} strata_pool_desc;

/* Draws of a technique's own making: tightly packed commands of 20 bytes each, as GL and Vulkan have
 * them: index_count, instance_count, first_index, vertex_offset (0), first_instance. Indices are those
 * of the scene, instances its records. */
typedef struct strata_draws_desc {
    uint32_t struct_size;
    uint32_t capacity;      /* commands that there is room for, > 0 */
    strata_buffer commands;
    strata_buffer count;    /* its first word: how many are drawn, at most `capacity` */
} strata_draws_desc;

/* What a program does. Fragment-only programs get their vertex stage from the host. */
#define STRATA_PROGRAM_FULLSCREEN 0u /* source is a fragment shader over the pass's rectangle */
#define STRATA_PROGRAM_SCENE 1u      /* source is a fragment shader after strata/vertex.glsl */
#define STRATA_PROGRAM_COMPUTE 2u    /* source is a compute shader */

#define STRATA_PROGRAM_LAZY 1u /* flags: compile at first use in record(), not now */

/* Sources are GLSL 4.60 without #version and without layout(binding); #include "strata/NAME.glsl"
 * finds the shared library, "NAME.glsl" the module's own sources. */
typedef struct strata_program_desc {
    uint32_t struct_size;
    uint32_t kind;  /* STRATA_PROGRAM_* */
    uint32_t flags;
    uint32_t define_count;
    const char *label;
    const strata_glsl *source;
    const char *const *defines; /* "NAME" or "NAME=VALUE"; copied */
    const strata_glsl *const *includes; /* NULL-terminated: the module's own includable sources, or NULL */
} strata_program_desc;

/* One resource of a pass, by the name it has in the GLSL: the block name of a buffer, the variable
 * name of a sampler or image. A buffer may also stand, as a whole, behind a usamplerBuffer, whose texels
 * are its 32-bit words: at most as many as the fact "limit.texels". A pool brings its planes and counter
 * under their own names (name is NULL). The host itself binds the Strata* blocks of shaders/strata. */
typedef struct strata_bind {
    uint32_t struct_size;
    uint32_t reserved;
    const char *name;
    strata_buffer buffer; /* exactly one of buffer, image and pool is set */
    strata_image image;
    strata_pool pool;
    uint32_t reserved2;
    uint64_t offset, size; /* of a buffer, bytes; size 0 = to the end; offset a multiple of 256 */
} strata_bind;

#define STRATA_LOAD_KEEP 0u
#define STRATA_LOAD_CLEAR 1u
#define STRATA_LOAD_DISCARD 2u /* contents become undefined */

#define STRATA_BLEND_NONE 0u
#define STRATA_BLEND_ADD 1u   /* d + s */
#define STRATA_BLEND_OVER 2u  /* s + (1 - s.a) d, premultiplied */
#define STRATA_BLEND_UNDER 3u /* d + (1 - d.a) s, premultiplied */
#define STRATA_BLEND_MULTIPLY 4u /* d * s */
#define STRATA_BLEND_MIN 5u
#define STRATA_BLEND_MAX 6u
#define STRATA_BLEND_FOLD 7u /* s.rgb + s.a d.rgb; alpha: d.a * s.a; (C, T) elements, far to near */

/* All attachments of a pass have one size, as many layers and as many samples. A clear reaches every
 * layer; fragments land in layer 0.
 *
 * Where the fact "ordered_attachments" is 1, a fragment shader may read and replace the texels of
 * colour attachments (strata/ordered.glsl), in primitive order at each pixel; exactly those have
 * `read`. They are plain 2D images and not blended. */
typedef struct strata_attachment {
    uint32_t struct_size;
    strata_image image;
    uint32_t load;      /* STRATA_LOAD_* */
    uint32_t blend;     /* STRATA_BLEND_*; colour only */
    uint32_t mask_off;  /* colour: bits r=1 g=2 b=4 a=8 that are not written */
    uint32_t read;      /* colour: 1 = the shader reads the texel that it replaces, see above */
    float clear[4];     /* colour; depth in [0], stencil in [1]; integer formats: the value as float */
} strata_attachment;

/* Comparisons, for depth (reversed: GREATER is nearer) and stencil. 0 = no test. */
#define STRATA_TEST_NONE 0u
#define STRATA_TEST_NEVER 1u
#define STRATA_TEST_LESS 2u
#define STRATA_TEST_EQUAL 3u
#define STRATA_TEST_LESS_EQUAL 4u
#define STRATA_TEST_GREATER 5u
#define STRATA_TEST_NOT_EQUAL 6u
#define STRATA_TEST_GREATER_EQUAL 7u
#define STRATA_TEST_ALWAYS 8u

#define STRATA_STENCIL_KEEP 0u
#define STRATA_STENCIL_ZERO 1u
#define STRATA_STENCIL_REPLACE 2u
#define STRATA_STENCIL_INCREMENT 3u /* saturating */
#define STRATA_STENCIL_DECREMENT 4u /* saturating */

/* One draw or dispatch with all its state. Zero is a sensible default everywhere. The host copies
 * everything during the call. */
typedef struct strata_pass {
    uint32_t struct_size;
    uint32_t groups[3];       /* compute: work groups; a zero y or z counts as one */
    const char *label;        /* also its timestamp; copied */
    strata_program program;
    uint32_t params_size;     /* bytes, <= 128, a multiple of 4 */
    const void *params;       /* the STRATA_PARAMS block of the program (std140) */
    const strata_bind *binds;
    uint32_t bind_count;
    uint32_t bind_stride;     /* bytes between binds; 0 = sizeof(strata_bind) in ABI 1.0 */
    const strata_attachment *color;
    uint32_t color_count;     /* <= 8 */
    uint32_t color_stride;    /* 0 = sizeof(strata_attachment) in ABI 1.0 */
    const strata_attachment *depth; /* or NULL */
    strata_draws draws;       /* scene programs: what to draw */
    strata_buffer indirect;   /* compute: three uints at indirect_offset replace groups */
    uint64_t indirect_offset; /* a multiple of 4 */
    uint32_t depth_test, depth_write; /* STRATA_TEST_*; 0 or 1 */
    uint32_t stencil_test, stencil_reference, stencil_pass, stencil_fail; /* fail: stencil or depth */
    uint32_t stencil_keep_mask; /* bits that are neither compared nor written */
    uint32_t cull;            /* 0 none (double-sided is decided in the vertex stage), 1 back, 2 front */
    uint32_t whole_frame;     /* 1: not limited to the band's rectangle */
    uint32_t width, height;   /* of the target when there is no attachment; 0 = the frame's */
    uint32_t sample_mask;     /* full-screen programs: bit i = sample i is reached; 0 = all */
} strata_pass;

/* Work groups of 64 invocations for `items`, in rows of 32,768, so that no device's limit on one
 * dimension is met. strata_item() in shaders/strata/scan.glsl is the other half. */
#define STRATA_GROUP_ROW 32768u
static inline void strata_groups(uint64_t items, uint32_t groups[3]) {
    const uint64_t count = (items + 63u) / 64u;
    groups[0] = count < STRATA_GROUP_ROW ? (uint32_t)count : STRATA_GROUP_ROW;
    groups[1] = (uint32_t)((count + STRATA_GROUP_ROW - 1u) / STRATA_GROUP_ROW);
    groups[2] = 1;
}

/* Facts, features and self-tests are asked for by string id, for example "limit.storage_range"
 * (bytes), "feature.int64_atomics", "selftest.ordered_rmw" (0 or 1). Unknown ids are 0. The list
 * is in the guide. */
typedef struct strata_gpu {
    uint32_t struct_size;
    uint32_t reserved;
    void *self; /* first argument of each function */

    /* Creation: in create() and prepare() only, pools in prepare(). On failure *out is the zero
     * handle and error() has one line. OUT_OF_DEVICE_MEMORY, OUT_OF_HOST_MEMORY, INVALID_ARGUMENT,
     * INVALID_STATE; pools also OVERFLOW, beyond 16; programs also SHADER, whose line names file and
     * line of the author's source. */
    strata_result (*buffer_create)(void *self, const strata_buffer_desc *desc, strata_buffer *out);
    strata_result (*image_create)(void *self, const strata_image_desc *desc, strata_image *out);
    strata_result (*pool_create)(void *self, const strata_pool_desc *desc, strata_pool *out);
    strata_result (*program_create)(void *self, const strata_program_desc *desc,
                                    strata_program *out);

    /* Value of a fact, any time. */
    uint64_t (*fact)(void *self, const char *id);

    /* Elements a pool holds now, any time; 0 for an unknown pool. */
    uint64_t (*pool_capacity)(void *self, strata_pool pool);

    /* The first error of a call into the host since create(), prepare(), record() or verify() began,
     * passes not counted, which are reported when the frame ends; "" if none.
     * Valid until the next call into the host. */
    const char *(*error)(void *self);
} strata_gpu;

#ifdef __cplusplus
}
#endif
#endif
