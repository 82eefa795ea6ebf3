// SPDX-License-Identifier: MIT
//
// peel, at the end: joins the walks, ends them at what color/1 holds, and sums what was taken and dropped.
#define PEEL_WALKS readonly
#include "state.glsl"
#include "strata/output.glsl"
#include "strata/scan.glsl"
#include "strata/totals.glsl"
#include "walks.glsl"

const uint PEEL_SHARE = 16u; // pixels an invocation

void peel_finish(uint pixel) {
    StrataElement walk = peel_walk[peel_slot(pixel, PEEL_FRONT)];
#if PEEL_SIDES == 2
    strata_fold_step(walk, peel_walk[peel_slot(pixel, PEEL_BACK)]);
#endif
    strata_output(pixel, walk);
}

void main() {
    uint first = strata_item() * PEEL_SHARE, largest = 0u;
    uint last = min(first + PEEL_SHARE, strata_pixel_count());
    uvec2 sum = uvec2(0u);
    for (uint pixel = first; pixel < last; ++pixel) {
        uvec2 count = peel_count[pixel];
        sum += count;
        largest = max(largest, count.x + count.y);
        if (count.x > 0u)
            peel_finish(pixel);
    }
    strata_totals_largest(largest);
    strata_totals_add(sum.x + sum.y, sum.x);
}
