// SPDX-License-Identifier: MIT
//
// Exact allocation, pass 4: the range of each pixel. With STRATA_RANGE_ENDS, offsets are written as the
// range's end; a store pass that counts them down leaves its beginning there and keeps no cursor. With
// STRATA_RANGE_CURSORS, the count makes room for the cursor of such a pass, at the range's beginning.
#define STRATA_RANGES writeonly
#include "strata/fragments.glsl"
#include "strata/count_kept.glsl"
#include "strata/cursor.glsl"

layout(std430) readonly buffer Sums { uint sums[]; };

void main() {
    uint sum = 0u, pixel;
    for (uint i = 0u; i < STRATA_TILE; ++i)
        if (strata_tile_pixel(i, pixel))
            sum += count_kept(pixel, strata_count_at(pixel));
    uint total;
    uint offset = strata_scan(sum, total);
    if (!strata_tile_exists())
        return;
    offset = strata_add(sums[strata_tile()], offset);
    for (uint i = 0u; i < STRATA_TILE; ++i)
        if (strata_tile_pixel(i, pixel)) {
            uint count = count_kept(pixel, strata_count_at(pixel));
            uint end = strata_add(offset, count);
#ifdef STRATA_RANGE_ENDS
            strata_ranges[pixel] = uvec2(end, count);
#else
            strata_ranges[pixel] = uvec2(offset, count);
#endif
#ifdef STRATA_RANGE_CURSORS
            imageStore(count_image, ivec2(strata_position(pixel)),
                       vec4(strata_cursor(min(offset, STRATA_NO_SLOT))));
#endif
            offset = end;
        }
}
