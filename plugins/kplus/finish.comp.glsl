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
#include "strata/pool.glsl"

#ifdef CHAIN_COUNTS
uint count_of(uvec2 position) { return chain_below(slots_of(position), NO_VALUE); }
#else
uint count_of(uvec2 position) { return cell_at(position).y & CELL_COUNT; }
#endif

#define PIXELS_PER_INVOCATION 16u

void main() {
    uint arrived = 0u, kept = 0u, largest = 0u, lane = gl_LocalInvocationID.x;
    uint first = (strata_item() - lane) * PIXELS_PER_INVOCATION + lane;
    for (uint i = 0u; i < PIXELS_PER_INVOCATION; ++i) {
        uint pixel = first + i * STRATA_GROUP;
        if (pixel >= strata_pixel_count())
            break;
        uvec2 position = strata_position(pixel);
        uint here = strata_count_at(pixel), count = 0u;
        if (!strata_pool_short())
            count = count_of(position);
        strata_ranges[pixel] = uvec2(slots_of(position).x, count);
        arrived += here;
        kept += count;
        largest = max(largest, here);
    }
    strata_totals_largest(largest);
    strata_totals_add(arrived, kept);
}
