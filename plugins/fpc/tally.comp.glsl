// SPDX-License-Identifier: MIT
//
// fpc, pass 1: for each work group's pixels, how many hold fragments, and their elements, chunks and
// joints.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"
#include "pixels.glsl"

FPC_TABLE(restrict)
layout(std430) writeonly buffer Sums { uvec4 sums[]; };
shared uint group_largest;

void main() {
    uint lane = gl_LocalInvocationID.x, most = 0u;
    uvec4 sum = uvec4(0u), total;
    if (lane == 0u)
        group_largest = 0u;
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i) {
        uint count = count_of(pixel_at(i));
        sum = add(sum, share_of(count));
        most = max(most, count);
    }
    barrier();
    if (most > 0u)
        atomicMax(group_largest, most);
    barrier();
    if (group_largest > 0u) // for all of the group alike
        scan(sum, total);
    else
        total = uvec4(0u);
    if (lane == 0u) {
        uint group = strata_item() / STRATA_GROUP;
        if (group < group_count())
            sums[group] = total;
        if (group_largest > 0u)
            atomicMax(deepest, group_largest);
    }
}
