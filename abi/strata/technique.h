/* SPDX-License-Identifier: MIT
 *
 * strata/technique.h - what a module exports: its descriptor, its techniques and their slots,
 * knobs, promises and costs.
 *
 * A module is a shared object that exports one constant data symbol, `strata_module_v1`, and carries
 * the same facts as JSON in an ELF note (written by the SDK's CMake function strata_add_module), so
 * that hosts can list it and plan with it without opening it.
 *
 * States of a technique's instance, and what may be called in each:
 *
 *     (memory of state_size zero bytes) --create OK--> created --prepare OK--> ready
 *     ready --record--> recorded --verify--> ready          (record once for each round of each band)
 *     created | ready --prepare--> ready | created (failed: prepare may be called again)
 *     any but the first --destroy--> gone                   (also after a failed create)
 *
 * After DEVICE_LOST the host calls destroy (its GPU calls do nothing), then create on a new device.
 */
#ifndef STRATA_TECHNIQUE_H
#define STRATA_TECHNIQUE_H

#include "effect.h"
#include "frame.h"

#ifdef __cplusplus
extern "C" {
#endif

#define STRATA_SLOT_CONSUMES 1u
#define STRATA_SLOT_PRODUCES 2u /* one technique of a frame produces a slot */
#define STRATA_SLOT_UPDATES 3u

/* Alternatives: a technique that folds fragments/1 consumes it; the list says layouts it accepts. */
typedef struct strata_slot_use {
    uint32_t struct_size;
    uint32_t use;       /* STRATA_SLOT_* */
    const char *slot;   /* "fragments/1" */
    uint32_t layouts;   /* fragments/1: bit STRATA_FRAGMENTS_* for each layout read or written; else 0 */
    uint32_t optional;  /* consumes: 1 = works without (a default stands in) */
} strata_slot_use;

#define STRATA_ORDER_EXACT 0u       /* all fragments, in order */
#define STRATA_ORDER_NEAREST 1u     /* the nearest k in order, the rest dropped and bounded */
#define STRATA_ORDER_APPROXIMATE 2u /* no bound */
#define STRATA_DETERMINISM_BIT 0u     /* same bits each run, thread count and submission order */
#define STRATA_DETERMINISM_BOUNDED 1u /* within the certified bound */

/* What a technique promises; a sweep checks it against the exact image. Promises hold at the presets
 * of knobs that trade accuracy. Where such a knob is not at its preset, an INT keeps so many of the nearest fragments
 * (STRATA_ORDER_NEAREST instead of EXACT), the CHOICE `mode` folds in another order
 * (STRATA_DETERMINISM_BOUNDED), and `payload` stores at another precision. */
typedef struct strata_promises {
    uint32_t struct_size;
    uint32_t order;         /* STRATA_ORDER_* */
    uint32_t determinism;   /* STRATA_DETERMINISM_* */
    uint32_t largest_depth; /* fragments in one pixel that it can hold; 0 = memory alone limits */
    const char *memory;     /* formula for a reader, bytes in terms of fragments, pixels and knobs */
} strata_promises;

/* Cost before anything was measured, in units of blending one fragment (the floor). The plan adds
 * frame + per_pixel * pixels + per_fragment * fragments + per_fragment_log2_depth * fragments *
 * log2(1 + mean depth) + per_triangle * triangles, and for techniques that draw once for each layer of
 * the deepest pixel
 * depth * (per_depth + per_depth_pixel * pixels + per_depth_fragment * fragments +
 * per_depth_triangle * triangles); and per_object * opaque objects for those that name objects/1.
 * Pixels are those that fragments cover, for the stages clip, capture, resolve and stream; for all
 * others they are the frame's, and fragments are 0: there per_fragment is the price of what opaque
 * draws overdraw, where culling is weighed. Triangles are those of the draws that its slots name. The
 * depth is the largest, and no more than the k that is kept. */
typedef struct strata_cost_model {
    uint32_t struct_size;
    uint32_t reserved;
    double frame;          /* passes and dispatches */
    double per_pixel;
    double per_fragment;
    double per_fragment_log2_depth; /* times log2(1 + mean depth), for sorting */
    double per_triangle;
    double per_depth;
    double per_depth_pixel;
    double per_depth_fragment;
    double per_depth_triangle;
    double per_object;
} strata_cost_model;

/* Knobs whose names have a meaning to the host, which sets them where the user did not: of a capture
 * `mode`, a CHOICE of contiguous, linked, as STRATA_FRAGMENTS_* count them; `payload`, a CHOICE of float,
 * half, unorm8, or the first of them, as STRATA_PAYLOAD_* do. An INT that trades accuracy is how many
 * fragments of a pixel are kept, 0 = all. */

/* estimate(): memory with these settings. */
typedef struct strata_cost {
    uint32_t struct_size;
    uint32_t reserved;
    uint64_t bytes_per_pixel;    /* of the band */
    uint64_t bytes_per_fragment; /* default payload included */
    uint64_t bytes_fixed;
} strata_cost;

typedef struct strata_technique strata_technique;
struct strata_host;

/* The host as a technique sees it. Lives as long as the instance. */
typedef struct strata_host {
    uint32_t struct_size;
    uint32_t abi_version; /* of the host */
    void *self;
    /* A line for the log; level 0 error .. 3 debug. Any thread. */
    void (*log)(void *self, uint32_t level, const char *text);
    /* A table of extra functions ("strata.gl/1", "strata.vulkan/1"), NULL when absent; lives as long
     * as the instance. */
    const void *(*extension)(void *self, const char *id);
} strata_host;

struct strata_technique {
    uint32_t struct_size;
    uint32_t state_size;  /* bytes the host allocates, zeroed, for each instance; aligned for any type */
    const char *id;       /* [a-z][a-z0-9_]*, at most 63, unique among installed techniques, not host,
                             scene or frame; the CLI's name */
    const char *title;
    const char *reference; /* the paper */
    const char *stage;     /* draws, surface, clip, capture, resolve, stream, filter, certificate */
    const strata_slot_use *const *slots;
    uint32_t slot_count;
    uint32_t knob_count;
    const strata_knob *const *knobs;
    const strata_promises *promises;
    const strata_cost_model *cost;
    const char *const *needs;   /* NULL-terminated fact ids that must not be 0, or NULL */
    const char *const *prefers; /* fact ids that open faster paths, or NULL */
    /* Pure; any state, any thread. For tools that reckon with memory before there is a device; this
     * host plans from the note alone. NULL: unknown. */
    strata_result (*estimate)(const strata_scene_stats *stats, const strata_settings *settings,
                              strata_cost *cost);
    strata_result (*create)(void *state, const strata_host *host, const strata_gpu *gpu);
    /* OK or an error. OUT_OF_DEVICE_MEMORY, also for a buffer that a "limit.storage_range" cannot
     * hold: the host splits the frame into more bands and prepares again. After another error, of this
     * or any other call, the technique is left out and the frame planned without it, unless the user
     * named it; OUT_OF_HOST_MEMORY, OVERFLOW and CANCELLED end the render. What is returned decides,
     * not an error of a call into the host that the technique made do without. */
    strata_result (*prepare)(void *state, const strata_view *view);
    void (*record)(void *state, const strata_frame *frame);
    /* OK, RETRY (something learned or grown: record again) or an error. NULL = always OK. Pools are
     * compared by the host before this is called. */
    strata_result (*verify)(void *state, const strata_frame *frame);
    void (*destroy)(void *state);
};

#define STRATA_MODULE_SYMBOL "strata_module_v1"

typedef struct strata_module {
    uint32_t struct_size;
    uint32_t abi_version;      /* STRATA_ABI_VERSION of the headers it was built with */
    uint32_t min_host_version; /* lowest host ABI it works with */
    uint32_t flags;            /* 0 */
    const char *id, *title, *version, *licence;
    const strata_technique *const *techniques;
    const strata_effect *const *effects;
    uint32_t technique_count, effect_count;
} strata_module;

/* In the module's one C file: `STRATA_EXPORT extern const strata_module strata_module_v1;` */

#ifdef __cplusplus
}
#endif
#endif
