// SPDX-License-Identifier: MIT
//
// cullcheck: the verdict, one invocation a chunk of objects.
#include "strata/objects.glsl"
#include "strata/scan.glsl"

const uint CHUNK = 32u, SEEN = 1u, OVERSHOT = 2u; // cullcheck.c, object.glsl

layout(std430) readonly buffer Seen { uint seen[]; };
layout(std430) buffer Verdict { uint visible, wrong, first, overshot; };
STRATA_PARAMS { uint count; } params;

void main() {
    uint begin = min(strata_item() * CHUNK, params.count), end = min(begin + CHUNK, params.count);
    uint found = 0u, bad = 0u, beyond = 0u;
    for (uint i = begin; i < end; ++i) {
        bool culled = strata_object_states[i] >= STRATA_OUTSIDE, is_seen = (seen[i] & SEEN) != 0u;
        found += uint(is_seen);
        if (culled && is_seen) {
            ++bad;
            atomicMin(first, i);
        } else if (culled && seen[i] != 0u) {
            ++beyond;
        }
    }
    if (found > 0u)
        atomicAdd(visible, found);
    if (bad > 0u)
        atomicAdd(wrong, bad);
    if (beyond > 0u)
        atomicAdd(overshot, beyond);
}
