// SPDX-License-Identifier: MIT
//
// peel, between steps, full screen: folds what the last step took and gets the next one ready. Step 0
// empties everything. Front to back it also writes the depth that pass 1 starts from: the limit, or
// where nothing is left to take the near plane, which nothing passes.
#define STRATA_PAYLOAD_READ
#define PEEL_LAST
#define PEEL_WALKS
#define PEEL_COUNTS
#include "state.glsl"
#include "walks.glsl"

layout(std430) buffer PeelProgress { uint peel_reached; };
STRATA_PARAMS { uint step; uint layers; } params;

#if PEEL_SIDES == 1
uniform sampler2D limit;
#endif

void peel_empty(uint pixel) {
    for (uint side = 0u; side < PEEL_SIDES; ++side) {
        uint slot = peel_slot(pixel, side);
        peel_last[slot] = uvec2(side == PEEL_FRONT ? 0u : STRATA_NO_KEY);
        peel_walk[slot] = strata_fold_begin();
        peel_found[slot] = PeelFound(0u, 0u, 0u, 0u);
    }
    peel_count[pixel] = uvec2(0u);
}

void peel_take(uint pixel, uint slot, uint side, PeelFound found) {
    StrataElement element = strata_event(strata_payload_load(slot)), walk = peel_walk[slot];
    if (side == PEEL_FRONT) {
        strata_fold_step(walk, element);
        peel_walk[slot] = walk;
    } else {
        strata_fold_step(element, walk);
        peel_walk[slot] = element;
    }
    peel_last[slot] = uvec2(found.key, strata_order(peel_primitive(found.rank, side)));
    peel_count[pixel].x += 1u;
}

bool peel_full(uint pixel) {
    return params.layers != 0u && peel_count[pixel].x >= params.layers;
}

// Whether the slot's side may have more to take.
bool peel_advance(uint pixel, uint side) {
    uint slot = peel_slot(pixel, side);
    PeelFound found = peel_found[slot];
    if (found.rank == 0u || peel_full(pixel))
        return false;
    uint wanted = found.tied != 0u ? found.rank : 0u;
    if (wanted == 0u)
        peel_take(pixel, slot, side, found);
    peel_found[slot] = PeelFound(0u, 0u, 0u, wanted);
    return !peel_full(pixel);
}

void main() {
    uint pixel = strata_pixel(uvec2(gl_FragCoord.xy));
    bool more = true;
    if (params.step == 0u) {
        peel_empty(pixel);
    } else {
        more = peel_advance(pixel, PEEL_FRONT);
#if PEEL_SIDES == 2
        more = peel_advance(pixel, PEEL_BACK) || more;
#endif
        if (more && peel_reached < params.step)
            atomicMax(peel_reached, params.step);
    }
#if PEEL_SIDES == 1
    gl_FragDepth = more ? texelFetch(limit, ivec2(gl_FragCoord.xy), 0).r : 1.0;
#endif
}
