// SPDX-License-Identifier: MIT
//
// stencil, end of a batch: each fragment that a layer of the batch holds is shaded and stored, in the
// slot of its layer. The stencil lets those pixels through that have fragments in the batch. No colour
// output: a later triangle's opaque output may make a driver drop a tile's storage writes.
#define STRATA_RECORDS writeonly
#define STRATA_KEYS STRATA_PAIR
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/fragments.glsl"
#include "strata/effects.glsl"
#include "layers.glsl"
#include "strata/pool.glsl"

layout(early_fragment_tests) in;
STRATA_PARAMS { uint first; } params; // the batch's first layer

// Which layer of the batch holds the primitive here, the first; BATCH: none. It covers a pixel once at
// most. Layers beyond the frame's last are plain ones of the batch before, or samples that no layer is
// left for: no range reaches so far.
uint find_layer(uint primitive) {
    uint layers[BATCH] = layers_at(uvec2(gl_FragCoord.xy));
    uint found = BATCH;
    for (uint i = BATCH; i-- > 0u;)
        found = layers[i] == primitive + 1u ? i : found;
    return found;
}

void main() {
    StrataSlopes slopes = strata_slopes();
    uint primitive = strata_primitive();
    uint layer = find_layer(primitive);
    if (layer == BATCH)
        return;
    uvec2 range = strata_range_at(strata_pixel(uvec2(gl_FragCoord.xy)));
    uint slot = range.x + params.first + layer;
    if (params.first + layer >= range.y || slot >= strata_pool_capacity())
        return;
    StrataSurface surface;
    strata_surface(slopes, surface);
    strata_keys[slot] = STRATA_TO_PAIR(uvec2(strata_key(gl_FragCoord.z), strata_order(primitive)));
    strata_payload_store(slot, strata_emit(surface));
}
