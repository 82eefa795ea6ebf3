// SPDX-License-Identifier: MIT
//
// kplus, array and heap, the geometry pass: culls, shades and inserts each fragment. The attachment counts
// by blending what arrived (memory=fixed; else it was counted before).
#if defined(LOCK) || defined(STRATA_INTERLOCK)
#define STRATA_PAYLOAD_ACCESS coherent
#endif
#define STRATA_PAYLOAD_WRITE
#ifdef STRATA_BOUND // what is evicted is read again
#define STRATA_PAYLOAD_READ
#endif
#include "strata/shading.glsl"
#include "strata/effects.glsl"
#include "insert.glsl"

layout(early_fragment_tests) in;
#ifndef EXACT
layout(location = 0) out float arrived;
#endif

// Derivatives and the loss need every fragment shaded; else the culled are spared it.
#if defined(STRATA_HAS_TEXTURES) || defined(STRATA_BOUND)
#define SHADE_FIRST
#endif

void main() {
#ifdef SHADE_FIRST
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
#else
    if (!strata_covered())
        discard;
#endif
#ifndef EXACT
    arrived = 1.0;
#endif
    uvec2 position = uvec2(gl_FragCoord.xy);
    uvec2 record = uvec2(strata_key(gl_FragCoord.z), strata_order(strata_primitive()));
    uvec2 cell = cell_at(position);
    bool behind = culled(cell, record);
#ifdef SHADE_FIRST
    StrataPayload payload = strata_emit(surface);
#else
    StrataPayload payload;
    if (!behind) {
        StrataSurface surface;
        strata_surface(surface);
        payload = strata_emit(surface);
    }
#endif
    bool drops = behind;
    STRATA_INTERLOCK_BEGIN
    if (!behind)
        drops = insert(position, cell, record, payload);
    STRATA_INTERLOCK_END
    if (drops) // in one place: software devices run both sides of a branch
        strata_lose(strata_pixel(position), payload);
}
