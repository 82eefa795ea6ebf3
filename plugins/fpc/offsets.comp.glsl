// SPDX-License-Identifier: MIT
//
// fpc, radix sort, step 4: counters become the places of their first elements.
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(readonly)
#include "counters.glsl"
layout(std430) buffer Counters { uint counters[]; };
layout(std430) readonly buffer BlockSums { uint block_sums[]; };

void main() {
    uint sum = 0u, total;
    for (uint i = counter_begin(); i < counter_end(); ++i)
        sum += counters[i];
    uint offset = strata_scan(sum, total);
    if (counter_begin() >= counter_count())
        return;
    offset += block_sums[strata_item() / STRATA_GROUP];
    for (uint i = counter_begin(); i < counter_end(); ++i) {
        uint count = counters[i];
        counters[i] = offset;
        offset += count;
    }
}
