// SPDX-License-Identifier: MIT
//
// How the passes that list pixels by class share a band out (plugins/shared/classes.c): a group takes a
// tile of 32 x 32 pixels, an invocation a block of 4 x 4. So lists follow blocks, as rasterisers
// do, and neighbours in a list have their records near each other.
#ifndef STRATA_CLASS_PIXELS_GLSL
#define STRATA_CLASS_PIXELS_GLSL

#include "strata/fragments.glsl"
#include "strata/scan.glsl"

#define CLASS_TILE 32u
#define CLASS_BLOCK 4u
#define CLASS_PIXELS 16u // of an invocation

// The invocation's first pixel in the band; blocks go by fours of fours.
uvec2 class_block() {
    uint lane = gl_LocalInvocationID.x, tile = strata_item() / STRATA_GROUP;
    uint tiles = (strata_band.z + CLASS_TILE - 1u) / CLASS_TILE;
    uvec2 block = uvec2((lane & 3u) | (lane >> 2 & 4u), (lane >> 2 & 3u) | (lane >> 3 & 4u));
    return uvec2(tile % tiles, tile / tiles) * CLASS_TILE + block * CLASS_BLOCK;
}

uint class_pixel(uvec2 block, uint i) {
    return (block.y + i / CLASS_BLOCK) * strata_band.z + block.x + i % CLASS_BLOCK;
}

// Fragments of the i-th pixel of a block; none beyond the band's edge.
uint class_count(uvec2 block, uint i) {
    bool inside = block.x + i % CLASS_BLOCK < strata_band.z &&
                  block.y + i / CLASS_BLOCK < strata_band.w;
    return inside ? strata_range_at(class_pixel(block, i)).y : 0u;
}

#endif
