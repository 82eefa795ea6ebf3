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
    uint item = strata_item();
    if (item >= streams)
        return;
    for (uint digit = 0u; digit < DIGITS; ++digit)
        counters[digit * streams + item] = 0u;
    uint end = min((item + 1u) * stream, elements);
    for (uint i = item * stream; i < end; ++i)
        counters[digit_of(FROM_ELEMENTS[i], i, params.bit) * streams + item] += 1u;
}
