// SPDX-License-Identifier: MIT
//
// fpc, radix sort, step 5, one invocation a stream: its elements, in order, to their places in the
// other copy. Elements of one digit keep their order, within the stream and between streams.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(readonly)
#include "sorting.glsl"
layout(std430) buffer Counters { uint counters[]; };
STRATA_PARAMS { uint bit; } params;

void main() {
    uint item = strata_item();
    if (item >= streams)
        return;
    uint end = min((item + 1u) * stream, elements);
    for (uint i = item * stream; i < end; ++i) {
        uvec2 element = FROM_ELEMENTS[i];
        uint counter = digit_of(element, i, params.bit) * streams + item;
        uint at = counters[counter];
        counters[counter] = at + 1u;
        TO_ELEMENTS[at] = element;
        TO_SLOTS[at] = FROM_SLOTS[i];
    }
}
