// SPDX-License-Identifier: MIT
//
// hiz: sums of work groups become offsets, one work group; and how many commands there are.
#include "strata/scan.glsl"

layout(std430) buffer Sums { uint sums[]; };
layout(std430) writeonly buffer Count { uint draw_count; };
STRATA_PARAMS { uint groups; } params;

void main() {
    uint share = (params.groups + STRATA_GROUP - 1u) / STRATA_GROUP;
    uint first = min(gl_LocalInvocationID.x * share, params.groups);
    uint last = min(first + share, params.groups), sum = 0u;
    for (uint i = first; i < last; ++i)
        sum += sums[i];
    uint total, offset = strata_scan(sum, total);
    for (uint i = first; i < last; ++i) {
        uint group = sums[i];
        sums[i] = offset;
        offset += group;
    }
    if (gl_LocalInvocationID.x == 0u)
        draw_count = total;
}
