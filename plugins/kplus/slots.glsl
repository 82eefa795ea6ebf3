// SPDX-License-Identifier: MIT
//
// kplus: where a pixel's slots lie. memory=exact gave each pixel a range of its own capacity, min(count,
// its k), in StrataRanges; memory=fixed gives each k slots, block by block of pixels, and finish.comp.glsl
// writes the ranges.
#ifndef EXACT
#define STRATA_RANGES writeonly
#endif
#include "strata/fragments.glsl"

#ifndef MORE_PARAMS
#define MORE_PARAMS
#endif
STRATA_PARAMS { uint k; uint tries; MORE_PARAMS } params;

// The band's pixels in blocks of 4 by 4, smaller ones at the edges: what a triangle covers lies together, and
// rows that are a power of two apart do not compete for the same lines of a cache.
struct Block {
    uint first, pixels; // pixels before the block, and in it
    uint inner;         // index in the block
};
Block block_of(uvec2 position) {
    uvec4 band = strata_frame_band();
    uvec2 p = position - band.xy, corner = p & ~3u, at = p & 3u;
    uvec2 size = min(band.zw - corner, uvec2(4u));
    return Block(corner.y * band.z + corner.x * size.y, size.x * size.y, at.y * size.x + at.x);
}
uint block_index(uvec2 position) {
    Block block = block_of(position);
    return block.first + block.inner;
}

#ifdef EXACT
uvec2 slots_of(uvec2 position) { return strata_range_at(strata_pixel(position)); } // first, capacity
#else
uvec2 slots_of(uvec2 position) { return uvec2(block_index(position) * params.k, params.k); }

// Of the pool; what 32 bits cannot hold asks for bands.
uint slots_needed() {
    uint pixels = strata_pixel_count();
    return pixels > 0xffffffffu / params.k ? 0xffffffffu : pixels * params.k;
}
#endif
