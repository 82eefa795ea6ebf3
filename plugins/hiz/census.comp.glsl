// SPDX-License-Identifier: MIT
//
// hiz: how many objects are in each state, one invocation a chunk of them.
#include "strata/objects.glsl"
#include "strata/scan.glsl"
#include "marks.glsl"

layout(std430) buffer Census { uint census[]; };
STRATA_PARAMS { uint count; } params;

void main() {
    uint first = min(strata_item() * CHUNK, params.count), last = min(first + CHUNK, params.count);
    uint found[STRATA_OCCLUDED + 1u];
    for (uint s = 0u; s <= STRATA_OCCLUDED; ++s)
        found[s] = 0u;
    for (uint i = first; i < last; ++i)
        ++found[min(strata_object_states[i], STRATA_OCCLUDED)];
    for (uint s = 0u; s <= STRATA_OCCLUDED; ++s)
        if (found[s] > 0u)
            atomicAdd(census[s], found[s]);
}
