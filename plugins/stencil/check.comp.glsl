// SPDX-License-Identifier: MIT
//
// stencil, end of a batch: where routing is exact, a pixel's fragments fill its layers one by one, as many
// as were counted. Counts the pixels where that is not so.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "layers.glsl"

layout(std430) buffer Routing { uint misrouted; uint overflowed; };
STRATA_PARAMS { uint first; uint count; } params; // the batch's layers, of those of the frame

void main() {
    uint pixel = strata_item();
    if (pixel >= strata_pixel_count())
        return;
    uint held = strata_range_at(pixel).y;
    uint layers[BATCH] = layers_at(strata_position(pixel));
    bool exact = true;
    for (uint i = 0u; i < BATCH; ++i)
        exact = exact && (i >= params.count || (layers[i] != 0u) == (params.first + i < held));
    if (!exact)
        atomicAdd(misrouted, 1u);
}
