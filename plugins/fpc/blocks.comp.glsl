// SPDX-License-Identifier: MIT
//
// fpc, radix sort, step 3, one work group: block sums become offsets.
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(readonly)
layout(std430) buffer BlockSums { uint block_sums[]; };

void main() {
    uint a_block = COUNTERS_PER_INVOCATION * STRATA_GROUP;
    uint blocks = fits == 0u ? 0u : (streams * DIGITS + a_block - 1u) / a_block;
    uint share = (blocks + STRATA_GROUP - 1u) / STRATA_GROUP, sum = 0u, total;
    uint begin = min(gl_LocalInvocationID.x * share, blocks), end = min(begin + share, blocks);
    for (uint i = begin; i < end; ++i)
        sum += block_sums[i];
    uint offset = strata_scan(sum, total);
    for (uint i = begin; i < end; ++i) {
        uint block = block_sums[i];
        block_sums[i] = offset;
        offset += block;
    }
}
