// SPDX-License-Identifier: MIT
//
// A part of a merge: of a list of `count` slots that begins at `base` and consists of sorted runs of `run`,
// neighbouring runs are merged into runs twice as long, and of the result one invocation puts out
// `begin` to `end`, or to the end of the run in which `begin` lies. Where that begins in the two runs is
// found by bisection along the merge path (Green, McColl, Bader 2012). The includer says where slots
// come from and go to: STRATA_MERGE_FROM(at) and STRATA_MERGE_TO(at, slot).
#ifndef STRATA_MERGE_GLSL
#define STRATA_MERGE_GLSL

#include "strata/fragments.glsl"

void strata_merge(uint base, uint count, uint run, uint begin, uint end) {
    uint left = begin / (2u * run) * (2u * run);
    uint middle = min(left + run, count), right = min(left + 2u * run, count);
    uint skip = begin - left; // elements of the two runs that lie before `begin`

    uint low = skip > right - middle ? skip - (right - middle) : 0u;
    uint high = min(skip, middle - left);
    while (low < high) {
        uint a = (low + high) / 2u;
        uvec2 key_a = strata_key_at(STRATA_MERGE_FROM(base + left + a));
        uvec2 key_b = strata_key_at(STRATA_MERGE_FROM(base + middle + skip - 1u - a));
        if (strata_before(key_a, key_b))
            low = a + 1u;
        else
            high = a;
    }
    uint a = left + low, b = middle + skip - low;
    uint slot_a = a < middle ? STRATA_MERGE_FROM(base + a) : 0u;
    uint slot_b = b < right ? STRATA_MERGE_FROM(base + b) : 0u;
    uvec2 key_a = a < middle ? strata_key_at(slot_a) : uvec2(STRATA_NO_KEY);
    uvec2 key_b = b < right ? strata_key_at(slot_b) : uvec2(STRATA_NO_KEY);
    for (uint i = begin; i < min(end, right); ++i) {
        if (b >= right || (a < middle && strata_before(key_a, key_b))) {
            STRATA_MERGE_TO(base + i, slot_a);
            if (++a < middle) {
                slot_a = STRATA_MERGE_FROM(base + a);
                key_a = strata_key_at(slot_a);
            }
        } else {
            STRATA_MERGE_TO(base + i, slot_b);
            if (++b < right) {
                slot_b = STRATA_MERGE_FROM(base + b);
                key_b = strata_key_at(slot_b);
            }
        }
    }
}

#endif
