/* SPDX-License-Identifier: MIT
 *
 * What the files of the GPU core share: objects and the storage behind them, owners and scopes,
 * the frame being recorded, programs and their reflection. Private to host/gpu/gpu*.c; the rest of
 * the host sees gpu.h, backends see backend.h.
 */
#ifndef STRATA_HOST_GPU_INTERNAL_H
#define STRATA_HOST_GPU_INTERNAL_H

#include "gpu/backend.h"
#include "gpu/gpu.h"

#define GPU_MAX_BINDINGS 64u /* resources of one program */
#define GPU_MAX_COLOR    8u  /* attachments */
#define GPU_MAX_USES     (GPU_MAX_BINDINGS + GPU_MAX_COLOR + 8u)
#define GPU_MAX_UNIFORM  65536u /* bytes of a uniform block that every supported driver takes */
#define GPU_MAX_PARAMS   128u
#define GPU_SELFTESTS    5
#define GPU_POOL_MINIMUM 1024u /* elements of a pool whose maker expected nothing */

/* ---- storage, owners, scopes ------------------------------------------------------------------
 */

typedef struct gpu_owner gpu_owner;

/* One native buffer or image with what touched it last. Shared by an object and its history. */
typedef struct gpu_storage {
    void *native;
    uint64_t bytes;
    gpu_owner *owner;
    uint32_t references, is_image;
    uint32_t write_access, write_stages; /* the last write */
    uint32_t read_access, read_stages;   /* all reads since */
    uint32_t
        seen[4]; /* accesses that the last write is visible to: not by a shader, by each stage */
} gpu_storage;

typedef struct gpu_history { /* contents that outlive a scope, by name */
    struct gpu_history *next;
    gpu_storage *storage;
    uint32_t format, width, height, layers, samples; /* images */
    char name[64];
} gpu_history;

struct gpu_owner {
    gpu_owner *next;
    gpu_history *history;
    uint64_t bytes, peak;
    uint32_t scopes;
    char name[32];
};

typedef enum gpu_kind { GPU_BUFFER, GPU_IMAGE, GPU_POOL, GPU_PROGRAM, GPU_DRAWS } gpu_kind;

typedef struct gpu_object gpu_object;

typedef struct gpu_buffer_state {
    gpu_storage *storage; /* NULL: a pool's plane that could not be allocated */
    uint64_t size;
} gpu_buffer_state;

typedef struct gpu_image_state {
    gpu_storage *storage;
    uint32_t format, width, height, layers, samples;
} gpu_image_state;

typedef struct gpu_pool_state {
    uint32_t plane_count, fresh; /* fresh: `needed` has not been cleared since gpu_begin */
    uint32_t strides[STRATA_MAX_PLANES];
    char counter_name[64], names[STRATA_MAX_PLANES][64];
    gpu_object *counter, *planes[STRATA_MAX_PLANES]; /* buffers of the same scope */
    uint64_t capacity;
} gpu_pool_state;

/* GLSL with everything pasted in. paths[i] is what source number i stands for in #line. */
typedef struct gpu_source {
    base_text text;
    char **paths;
    size_t path_count, path_capacity;
} gpu_source;

static inline int gpu_format_is_depth(uint32_t format) {
    return format == STRATA_FORMAT_D32F || format == STRATA_FORMAT_D32F_S8;
}

static inline int gpu_format_is_integer(uint32_t format) {
    return format == STRATA_FORMAT_R32U || format == STRATA_FORMAT_RG32U ||
           format == STRATA_FORMAT_RGBA32U;
}

typedef enum gpu_output { GPU_OUTPUT_NONE, GPU_OUTPUT_FLOAT, GPU_OUTPUT_UINT } gpu_output;

/* Programs of equal text are one: built states are shared, and some are kept when nothing uses them
 * any more, since techniques that prepare again ask for the same ones. */
typedef struct gpu_program_state {
    struct gpu_program_state *next; /* of the device's built ones, last used first */
    uint64_t keys[2];               /* of the text and its target */
    uint32_t users;
    uint32_t kind, binding_count, params_size, built;
    void *native;
    uint32_t reads;                 /* bit i: the fragment stage reads colour attachment i */
    uint8_t outputs[GPU_MAX_COLOR]; /* gpu_output of the fragment stage, by location */
    gpu_source sources[2];          /* until it is built; [0] compute or vertex, [1] fragment */
    gpu_binding bindings[GPU_MAX_BINDINGS];
} gpu_program_state;

typedef struct gpu_draws_state {
    strata_buffer commands, count, indices;
    uint32_t capacity, counted;
} gpu_draws_state;

struct gpu_object {
    gpu_kind kind;
    uint32_t id;
    gpu_scope *scope;
    gpu_object *next; /* in its scope, youngest first */
    char label[64];
    union {
        gpu_buffer_state buffer;
        gpu_image_state image;
        gpu_pool_state pool;
        gpu_program_state *program;
        gpu_draws_state draws;
    };
};

struct gpu_scope {
    gpu *device;
    gpu_owner *owner;
    gpu_object *objects;
    gpu_scope *next, *previous;
};

/* ---- the device -------------------------------------------------------------------------------
 */

typedef struct gpu_text { /* a runtime include or define */
    struct gpu_text *next;
    char *name, *text;
} gpu_text;

typedef struct gpu_global {
    struct gpu_global *next;
    char name[64];
    strata_bind bind;
} gpu_global;

/* An id is a slot's number, from 1, below the count of the objects that the slot has held. */
typedef struct gpu_slot {
    gpu_object *object; /* NULL when the last one is gone */
    uint32_t generation, next_free;
} gpu_slot;

typedef enum gpu_inject { GPU_INJECT_NONE, GPU_INJECT_ALLOCATION, GPU_INJECT_LOST } gpu_inject;

struct gpu {
    const gpu_backend *backend;
    void *self;
    gpu_backend_caps caps;
    char *cache_dir, *device_name; /* as given to gpu_open, or NULL */
    int profile, clock_passes;     /* clock: the driver's own times are not sound */

    gpu_slot *slots; /* of objects, see gpu_objects.c */
    size_t slot_count, slot_capacity;
    uint32_t free_slot; /* its number, 0 = none */
    gpu_owner *owners;
    uint64_t bytes, peak; /* of all owners */
    gpu_scope *scopes;
    gpu_text *includes, *defines;
    gpu_global *globals;
    gpu_program_state *programs;

    gpu_inject inject;
    char injected_facts[192]; /* "lacks:FACT" and "claims:FACT", with commas between */
    uint64_t inject_at, creations, submits;
    int lost;

    /* The frame. `open`: the backend holds commands that were not submitted. */
    int begun, open;
    uint32_t frame_width, frame_height, rectangle[4];
    base_error frame_error;
    gpu_code frame_code, last_code;
    const char *where_owner, *where_label; /* of the recording call in progress, for messages */

    gpu_timing *timings;
    size_t timing_count, timing_capacity, timing_submitted;

    int selftest_running;                 /* this device exists for a self-test */
    signed char selftests[GPU_SELFTESTS]; /* -1 unknown */
};

/* ---- gpu.c: errors ----------------------------------------------------------------------------
 */

strata_result gpu_code_result(gpu_code code);
/* Words "<detail>: <text of code>", remembers the code, returns its result. */
strata_result gpu_fail(gpu *g, base_error *err, gpu_code code, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
/* As gpu_fail, into the frame's error, with owner and pass in front. Keeps the first. */
void gpu_record_fail(gpu *g, gpu_code code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* What a backend returned: its own words are in err already. Remembers MEMORY or LOST. */
strata_result gpu_backend_result(gpu *g, base_error *err, strata_result result);
/* Copies a struct of the ABI. Fails on NULL, on a struct_size below that of ABI 1.0 and on an
 * unknown tail that is not zero. */
strata_result gpu_take(gpu *g, base_error *err, const void *from, void *to, size_t size,
                       const char *name);

/* Whether programs read buffers as texels where they can (STRATA_TEXELS in strata/compat.glsl): on
 * software rasterisers, when any buffer that can be bound has room. */
int gpu_reads_texels(gpu *g);

/* ---- gpu_objects.c ----------------------------------------------------------------------------
 */

/* Guard of creation calls: lost device, injected failure. */
strata_result gpu_creation(gpu *g, const char *label, base_error *err);
gpu_object *gpu_object_new(gpu_scope *scope, gpu_kind kind, const char *label);
void gpu_object_drop(gpu *g,
                     gpu_object *object); /* the youngest of its scope; undoes gpu_object_new */
/* NULL and *code when the handle is unknown or its object dead. */
gpu_object *gpu_object_find(const gpu *g, uint32_t id, gpu_kind kind, gpu_code *code);
strata_result gpu_storage_buffer(gpu *g, gpu_owner *owner, const strata_buffer_desc *desc,
                                 gpu_storage **out, base_error *err);
void gpu_storage_release(gpu *g, gpu_storage *storage); /* NULL is fine */
gpu_owner *gpu_owner_find(const gpu *g, const char *name);

/* ---- gpu_pool.c -------------------------------------------------------------------------------
 */

/* Before a pass that binds the pool: clears `needed` once a frame. */
void gpu_pool_refresh(gpu *g, gpu_object *pool);
void gpu_pools_begin(gpu *g);

/* ---- gpu_hazards.c ----------------------------------------------------------------------------
 */

typedef struct gpu_use {
    gpu_storage *storage;
    uint32_t access, stages;
} gpu_use;
typedef struct gpu_uses {
    uint32_t count;
    gpu_use items[GPU_MAX_USES];
} gpu_uses;

/* Adds a use, merged with an earlier one of the same storage. */
void gpu_uses_add(gpu_uses *uses, gpu_storage *storage, uint32_t access, uint32_t stages);
/* Fills `barriers` (GPU_MAX_USES) with what must come before these uses; remembers them. */
uint32_t gpu_hazards_derive(const gpu_uses *uses, gpu_barrier *barriers);
/* The storage was written by the backend itself (zeros, uploads). */
void gpu_hazards_uploaded(gpu_storage *storage);

/* ---- gpu_bind.c -------------------------------------------------------------------------------
 */

typedef struct gpu_resolved { /* the binds of a pass */
    uint32_t count;
    gpu_native_bind binds[GPU_MAX_BINDINGS];
    gpu_storage *storages[GPU_MAX_BINDINGS];
    gpu_uses uses;
    gpu_object *pools[GPU_MAX_BINDINGS];
    uint32_t pool_count;
} gpu_resolved;

/* Resolves the pass's binds against the program; reports into the frame, returns 0 on failure. */
int gpu_bind_resolve(gpu *g, const strata_pass *pass, const gpu_object *program, gpu_resolved *out);
/* The same for a native pass: no program, so only uses and pools are filled. */
int gpu_bind_native(gpu *g, const strata_pass *pass, gpu_resolved *out);

/* ---- gpu_record.c -----------------------------------------------------------------------------
 */

/* Whether a recording call may go on; names owner and label for messages. */
int gpu_recording(gpu *g, const char *owner, const char *label);
void gpu_open_commands(gpu *g);
void gpu_flush(gpu *g); /* submits and waits; failures stick to the frame */

/* ---- gpu_program.c, gpu_shader.c, gpu_compile.c, gpu_reflect.c, gpu_spirv.c, gpu_cache.c --------
 */

strata_result gpu_program_build(gpu *g, gpu_object *program, base_error *err);
void gpu_program_release(gpu *g, gpu_program_state *program); /* NULL is fine */
void gpu_programs_free(gpu *g);                               /* all that are kept */

/* The library under shaders/strata, NULL-terminated. */
const strata_glsl *const *gpu_library(void);

/* Stage: GPU_STAGE_*. The vertex stage is the host's own for this kind of program. */
strata_result gpu_shader_expand(gpu *g, const strata_program_desc *desc, uint32_t stage,
                                gpu_source *out, base_error *err);
void gpu_source_free(gpu_source *source);

typedef struct gpu_spirv {
    uint32_t *words[2];
    size_t count[2];
} gpu_spirv;
void gpu_spirv_free(gpu_spirv *spirv);

/* glslang: text to SPIR-V, all stages linked together, bindings still arbitrary. Errors name the
 * author's file and line. */
strata_result gpu_compile(const char *label, uint32_t kind, int vulkan_target,
                          const gpu_source sources[2], gpu_spirv *out, base_error *err);
uint32_t gpu_compiler_version(void);

/* What the program uses, its bindings numbered for the target and the numbers written into the
 * SPIR-V; resources that nothing uses are removed from it. */
typedef struct gpu_reflection {
    uint32_t binding_count, params_size;
    uint32_t reads; /* as in gpu_program_state */
    uint8_t outputs[GPU_MAX_COLOR];
    gpu_binding bindings[GPU_MAX_BINDINGS];
} gpu_reflection;
strata_result gpu_reflect(const char *label, uint32_t kind, int vulkan_target, gpu_spirv *spirv,
                          gpu_reflection *out, base_error *err);

/* Gives the variables their bindings (set 0 when `sets`) and locations, and removes every other
 * uniform, buffer or push-constant variable that nothing refers to. Replaces *words. */
typedef struct gpu_spirv_binding {
    uint32_t id, number;
    uint32_t location; /* GPU_NO_LOCATION, or of what OpenGL counts by locations, not by blocks */
} gpu_spirv_binding;
#define GPU_NO_LOCATION UINT32_MAX
strata_result gpu_spirv_rewrite(uint32_t **words, size_t *count, const gpu_spirv_binding *bindings,
                                uint32_t binding_count, int sets, base_error *err);

/* Of the expanded text, the target and the compiler. */
void gpu_cache_keys(const gpu *g, const gpu_program_state *program, uint64_t keys[2]);
/* 1 and both results filled when a sound entry is there. */
int gpu_cache_load(const gpu *g, const gpu_program_state *program, gpu_spirv *spirv,
                   gpu_reflection *reflection);
void gpu_cache_store(const gpu *g, const gpu_program_state *program, const gpu_spirv *spirv,
                     const gpu_reflection *reflection);

/* ---- gpu_selftest.c ---------------------------------------------------------------------------
 */
int gpu_selftest(gpu *g, const char *id); /* 0 or 1; unknown: 0 */

#define GPU_SELFTEST_TRIANGLES 96u
/* One draw of so many triangles, at most those, for full-screen programs of self-tests: vertex i is
 * STRATA_CORNER(i), see strata/fullscreen.glsl. */
strata_result gpu_selftest_draws(gpu_scope *scope, uint32_t triangles, strata_draws *draws);

/* gpu_selftest_samples.c */
int gpu_selftest_sample_routing(gpu *g, gpu_scope *scope);
int gpu_selftest_routing(gpu *g, gpu_scope *scope, const char *corner); /* a define of it */

#endif
