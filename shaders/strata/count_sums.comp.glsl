// SPDX-License-Identifier: MIT
//
// Exact allocation, pass 2: records in each tile, of which a pixel gets count_kept(); and the
// totals. A count of 2^24 cannot be told from more; verify() refuses it.
#include "strata/count_kept.glsl"
#include "strata/totals.glsl"

layout(std430) writeonly buffer Sums { uint sums[]; };

void main() {
    uint kept = 0u, arrived = 0u, largest = 0u;
    for (uint i = 0u; i < STRATA_TILE; ++i) {
        uint pixel;
        if (!strata_tile_pixel(i, pixel))
            continue;
        uint count = strata_count_at(pixel);
        arrived += count;
        kept += count_kept(pixel, count);
        largest = max(largest, count);
    }
    uint total;
    strata_scan(kept, total);
    strata_totals_largest(largest);
    strata_totals_add(arrived, kept);
    if (gl_LocalInvocationID.x == 0u && strata_tile_exists())
        sums[strata_tile()] = total;
}
