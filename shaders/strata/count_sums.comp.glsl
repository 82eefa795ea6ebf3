// SPDX-License-Identifier: MIT
//
// Exact allocation, pass 2: records in each tile, of which a pixel gets at most params.most; and the
// totals. A count of 2^24 cannot be told from more; verify() refuses it.
#include "strata/tiles.glsl"
#include "strata/totals.glsl"

layout(std430) writeonly buffer Sums { uint sums[]; };
STRATA_PARAMS { uint most; } params;

void main() {
    uint kept = 0u, arrived = 0u, largest = 0u;
    for (uint i = 0u; i < STRATA_TILE; ++i) {
        uint pixel;
        uint count = strata_tile_pixel(i, pixel) ? strata_count_at(pixel) : 0u;
        arrived += count;
        kept += min(count, params.most);
        largest = max(largest, count);
    }
    uint total;
    strata_scan(kept, total);
    strata_totals_largest(largest);
    strata_totals_add(arrived, kept);
    if (gl_LocalInvocationID.x == 0u && strata_tile_exists())
        sums[strata_tile()] = total;
}
