// SPDX-License-Identifier: MIT
//
// fpc, radix sort, step 2: the sum of each block of counters.
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(readonly)
#include "counters.glsl"
layout(std430) readonly buffer Counters { uint counters[]; };
layout(std430) writeonly buffer BlockSums { uint block_sums[]; };

void main() {
    uint sum = 0u, total;
    for (uint i = counter_begin(); i < counter_end(); ++i)
        sum += counters[i];
    strata_scan(sum, total);
    if (gl_LocalInvocationID.x == 0u && counter_begin() < counter_count())
        block_sums[strata_item() / STRATA_GROUP] = total;
}
