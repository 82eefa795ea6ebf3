// SPDX-License-Identifier: MIT
//
// abuffer, contiguous, pass 3, one work group: block sums become offsets, and their total what the
// pool needs.
#include "strata/scan.glsl"

layout(std430) buffer Sums { uint sums[]; };
layout(std430) writeonly buffer StrataFragmentPool { uint strata_needed; };
STRATA_PARAMS { uint blocks; } params;

void main() {
    uint share = (params.blocks + STRATA_GROUP - 1u) / STRATA_GROUP;
    uint first = min(gl_LocalInvocationID.x * share, params.blocks);
    uint last = min(first + share, params.blocks);
    uint sum = 0u;
    for (uint i = first; i < last; ++i)
        sum = strata_add(sum, sums[i]);
    uint total;
    uint offset = strata_scan(sum, total);
    for (uint i = first; i < last; ++i) {
        uint block = sums[i];
        sums[i] = offset;
        offset = strata_add(offset, block);
    }
    if (gl_LocalInvocationID.x == 0u)
        strata_needed = total;
}
