// SPDX-License-Identifier: MIT
//
// fpc, radix sort, step 1, one invocation a stream: how often each digit occurs in it.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(readonly)
#include "sorting.glsl"
layout(std430) buffer Counters { uint counters[]; }; // [digit][stream]
STRATA_PARAMS { uint bit; } params;

void main() {
    uint stream = strata_item();
    if (stream >= streams)
        return;
    for (uint digit = 0u; digit < DIGITS; ++digit)
        counters[digit * streams + stream] = 0u;
    uint end = min((stream + 1u) * STREAM, elements);
    for (uint i = stream * STREAM; i < end; ++i)
        counters[digit_of(FROM_ELEMENTS[i], i, params.bit) * streams + stream] += 1u;
}
