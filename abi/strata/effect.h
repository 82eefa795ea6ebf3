/* SPDX-License-Identifier: MIT
 *
 * strata/effect.h - an effect: what happens to light at a fragment. A small GLSL fold that every
 * resolve runs unchanged: sequentially, on eviction, or as a parallel scan.
 *
 * A pixel's fragments, front to back, compose elements (C, T): C = C1 + T1 * C2, T = T1 * T2, with C
 * premultiplied RGBA and T the transmittance, one value or three. The effect's GLSL defines, for the
 * effect id NAME,
 *
 *     void NAME_emit(StrataSurface surface, inout StrataPayload payload);
 *     StrataElement NAME_event(StrataPayload payload);
 *
 * emit() writes the fields that the effect declares (payload.FIELD, a float or vecN) at capture;
 * event() turns them into an element at resolve. StrataElement is { vec4 color; STRATA_TRANSMITTANCE
 * transmittance; } where STRATA_TRANSMITTANCE is float or vec3 for the frame. All arithmetic that
 * reaches the element is `precise`, so that every technique computes the same bits. Transmittances
 * and alphas lie in [0, 1].
 *
 * Certificates of error evaluate event() at payloads of zeros and ones to learn how what rounds a
 * payload reaches the element. That is sound for events that are affine (STRATA_EFFECT_AFFINE); any other
 * is taken at its word where the payload is exact, and uncertified where it is not.
 */
#ifndef STRATA_EFFECT_H
#define STRATA_EFFECT_H

#include "gpu.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A field of the payload. Effects that name the same field share it. */
typedef struct strata_field {
    uint32_t struct_size;
    uint32_t channels; /* 1..4 */
    const char *name;  /* GLSL identifier */
    uint32_t exact;    /* 1: always 32 bits; 0: stored at the payload's precision */
    uint32_t reserved;
} strata_field;

/* The effect is called for when `fact` of the scene is at least `threshold`. Facts: see the guide;
 * for example "materials.blend", "materials.transmission" count materials in use. It is also how an
 * effect gets materials to emit for: those that such a fact counts. One that is called for by nothing
 * of the materials may be switched on, and draws nothing. */
typedef struct strata_need {
    uint32_t struct_size;
    uint32_t reserved;
    const char *fact;
    double threshold;
} strata_need;

/* Flags. */
#define STRATA_EFFECT_SEQUENTIAL 1u /* its walk has no associative form */
/* event(): each output is a constant plus channels of the payload, each times a constant of magnitude
 * 1e-3 to 1e3 or zero, evaluated with no more roundings than that form has. */
#define STRATA_EFFECT_AFFINE 2u
/* What emit() and event() make of a surface that transmits nothing (tint zero) has alpha 1 - T and
 * colours of at most surface.color (1 - T). */
#define STRATA_EFFECT_COVERS 4u

typedef struct strata_effect {
    uint32_t struct_size;
    uint32_t flags;
    const char *id; /* [a-z][a-z0-9_]* */
    const char *title;
    const char *reference;
    uint32_t transmittance_channels; /* 1 or 3 */
    uint32_t field_count;
    const strata_field *const *payload;
    const strata_need *const *called_for_by; /* any one suffices */
    uint32_t need_count;
    uint32_t priority; /* of several effects a material calls for, the highest emits */
    const strata_glsl *glsl;
} strata_effect;

#ifdef __cplusplus
}
#endif
#endif
