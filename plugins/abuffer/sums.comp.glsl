// SPDX-License-Identifier: MIT
//
// abuffer, contiguous, pass 2: fragments in each tile, and the largest
// count. A count of 2^24 cannot be told from more; verify() refuses it.
#include "strata/frame.glsl"
#include "strata/scan.glsl"
#include "blocks.glsl"

uniform sampler2D count_image;
layout(std430) writeonly buffer Sums { uint sums[]; };
layout(std430) buffer Largest { uint largest_count; };

void main() {
    uint sum = 0u, largest = 0u;
    for (uint i = 0u; i < TILE; ++i) {
        uint pixel;
        uint count = tile_pixel(i, pixel)
                         ? uint(texelFetch(count_image, ivec2(strata_position(pixel)), 0).r)
                         : 0u;
        sum += count;
        largest = max(largest, count);
    }
    uint total;
    strata_scan(sum, total);
    atomicMax(largest_count, largest);
    if (gl_LocalInvocationID.x == 0u && tile_exists())
        sums[tile_index()] = total;
}
