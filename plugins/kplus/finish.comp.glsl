// SPDX-License-Identifier: MIT
//
// kplus, memory=fixed, last: the range of each pixel, and the totals.
#ifdef CHAIN_COUNTS
#include "chain.glsl"
#else
#include "slots.glsl"
#include "cells.glsl"
#endif
#include "strata/tiles.glsl"
#include "strata/totals.glsl"

layout(std430) readonly buffer StrataFragmentPool { uint strata_needed; uint strata_capacity; };

#ifdef CHAIN_COUNTS
uint count_of(uint pixel) { return chain_below(slots_of(pixel), NO_VALUE); }
#else
layout(std430) readonly buffer Cells { uvec2 cells[]; };
uint count_of(uint pixel) { return cells[pixel].y & CELL_COUNT; }
#endif

void main() {
    uint pixel = strata_item(), arrived = 0u, kept = 0u;
    if (pixel < strata_pixel_count()) {
        arrived = strata_count_at(pixel);
        if (strata_needed <= strata_capacity)
            kept = count_of(pixel);
        strata_ranges[pixel] = uvec2(slots_of(pixel).x, kept);
    }
    uint total_a, total_k;
    strata_scan(arrived, total_a);
    strata_scan(kept, total_k);
    strata_totals_largest(arrived);
    if (gl_LocalInvocationID.x == 0u)
        strata_totals_add(total_a, total_k);
}
