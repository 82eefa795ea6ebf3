// SPDX-License-Identifier: MIT
//
// Exact allocation, pass 3, one work group: sums of tiles become offsets, and their total what the pool
// needs.
#include "strata/scan.glsl"

layout(std430) buffer Sums { uint sums[]; };
layout(std430) writeonly buffer StrataFragmentPool { uint strata_needed; };
STRATA_PARAMS { uint tiles; } params;

void main() {
    uint share = (params.tiles + STRATA_GROUP - 1u) / STRATA_GROUP;
    uint first = min(gl_LocalInvocationID.x * share, params.tiles);
    uint last = min(first + share, params.tiles);
    uint sum = 0u;
    for (uint i = first; i < last; ++i)
        sum = strata_add(sum, sums[i]);
    uint total;
    uint offset = strata_scan(sum, total);
    for (uint i = first; i < last; ++i) {
        uint tile = sums[i];
        sums[i] = offset;
        offset = strata_add(offset, tile);
    }
    if (gl_LocalInvocationID.x == 0u)
        strata_needed = total;
}
