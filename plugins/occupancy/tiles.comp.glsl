// SPDX-License-Identifier: MIT
//
// occupancy, pass 2, one invocation a tile: how the tile divides its keys. From the samples of the tile
// and its neighbours, and not beyond the farthest opaque surface of its pixels.
#define OCCUPANCY_DIVIDES
#include "strata/frame.glsl"
#include "strata/scan.glsl"
#include "buckets.glsl"

uniform sampler2D range_image;
uniform sampler2D depth_image;

vec2 sampled_range(ivec2 tile, ivec2 last) {
    vec2 range = vec2(-2.0); // as cleared: below every depth and every negated one
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            range = max(range, texelFetch(range_image, clamp(tile + ivec2(x, y), ivec2(0), last), 0).rg);
    return range;
}

float farthest_opaque(uvec2 tile) {
    uvec2 end = min((tile + 1u) * TILE, strata_frame_size.xy);
    float farthest = 1.0;
    for (uint y = tile.y * TILE; y < end.y; ++y)
        for (uint x = tile.x * TILE; x < end.x; ++x)
            farthest = min(farthest, texelFetch(depth_image, ivec2(x, y), 0).r);
    return farthest;
}

void main() {
    uvec2 count = tile_count();
    uint item = strata_item();
    if (item >= count.x * count.y)
        return;
    uvec2 tile = uvec2(item % count.x, item / count.x);
    vec2 range = sampled_range(ivec2(tile), ivec2(count) - 1);
    bool hit = range.x >= 0.0;
    uint far = min(hit ? strata_key(-range.y) : STRATA_FAR_KEY, strata_key(farthest_opaque(tile)));
    uint near = min(hit ? strata_key(range.x) : 0u, far);
    Division d = divide(near, far);
    imageStore(tiles, ivec2(tile), uvec4(d.near, d.far, d.shift, d.multiplier));
}
