// SPDX-License-Identifier: MIT
//
// Classes, pixels of at most 64 fragments among which keys are equal: insertion sort by (key, order). Few
// pixels as a rule; at most 2,016 moves each.
#define STRATA_PAYLOAD_READ
#include "strata/fragments.glsl"
#include "strata/fold.glsl"
#include "strata/scan.glsl"
#include "strata/class_fold.glsl"

#define SIZE 64

layout(std430) readonly buffer TiedPool { uint tied_needed; uint tied_capacity; };
layout(std430) readonly buffer TiedPixels { uint tied_pixels[]; };

void main() {
    uint item = strata_item();
    if (item >= min(tied_needed, tied_capacity))
        return;
    uint pixel = tied_pixels[item];
    uvec2 range = strata_range_at(pixel);
    uvec2 k[SIZE];
    uint s[SIZE];
    uint next = range.x;
    for (uint i = 0u; i < range.y; ++i) {
#if STRATA_LAYOUT == 1
        uint slot = next;
        next = strata_link_at(slot).x;
#else
        uint slot = range.x + i;
#endif
        uvec2 key = strata_key_at(slot);
        uint j = i;
        while (j > 0u && strata_before(key, k[j - 1u])) {
            k[j] = k[j - 1u];
            s[j] = s[j - 1u];
            --j;
        }
        k[j] = key;
        s[j] = slot;
    }
    CLASS_FOLD(pixel, s, range.y)
}
