// SPDX-License-Identifier: MIT
//
// fpc, after the sort by rank and key: sorts short runs of equal keys by order, in place, by the
// invocation that meets their first element. A longer run is reported: then order is sorted by, too.
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(restrict)
layout(std430) readonly buffer Elements0 { uvec2 elements0[]; };
layout(std430) buffer Slots0 { uint slots0[]; };

#define TIE_LIMIT 32u

// Insertion sort: with its own loops at most TIE_LIMIT^2 / 2 turns.
void mend(uint begin, uint end) {
    for (uint i = begin + 1u; i < end; ++i) {
        uint slot = slots0[i], order = strata_key_at(slot).y, j = i;
        for (; j > begin; --j) {
            uint before = slots0[j - 1u];
            if (strata_key_at(before).y < order)
                break;
            slots0[j] = before;
        }
        slots0[j] = slot;
    }
}

void main() {
    uint begin = strata_item() * ELEMENTS_PER_INVOCATION;
    uint end = min(begin + ELEMENTS_PER_INVOCATION, elements);
    if (begin >= end)
        return;
    uvec2 before = begin > 0u ? elements0[begin - 1u] : uvec2(STRATA_NO_KEY);
    uvec2 here = elements0[begin];
    for (uint i = begin; i < end; ++i) {
        uvec2 next = i + 1u < elements ? elements0[i + 1u] : uvec2(STRATA_NO_KEY);
        if (here == next && here != before) {
            uint behind = i + 2u;
            while (behind < elements && behind - i <= TIE_LIMIT && elements0[behind] == here)
                ++behind;
            if (behind - i > TIE_LIMIT)
                long_ties = 1u;
            else
                mend(i, behind);
        }
        before = here;
        here = next;
    }
}
