// SPDX-License-Identifier: MIT
//
// abuffer, contiguous, pass 4: the range of each pixel. Offsets are written as the range's end; the
// store pass counts them down, so that afterwards they are its beginning and no cursor is kept.
#define STRATA_RANGES writeonly
#include "strata/fragments.glsl"
#include "strata/scan.glsl"
#include "blocks.glsl"

uniform sampler2D count_image;
layout(std430) readonly buffer Sums { uint sums[]; };

uint count_at(uint pixel) {
    return uint(texelFetch(count_image, ivec2(strata_position(pixel)), 0).r);
}

void main() {
    uint sum = 0u, pixel;
    for (uint i = 0u; i < TILE; ++i)
        if (tile_pixel(i, pixel))
            sum += count_at(pixel);
    uint total;
    uint end = strata_scan(sum, total);
    if (!tile_exists())
        return;
    end = strata_add(sums[tile_index()], end);
    for (uint i = 0u; i < TILE; ++i)
        if (tile_pixel(i, pixel)) {
            uint count = count_at(pixel);
            end = strata_add(end, count);
            strata_ranges[pixel] = uvec2(end, count);
        }
}
