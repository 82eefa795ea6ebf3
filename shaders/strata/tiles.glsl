// SPDX-License-Identifier: MIT
//
// How the scans of counts share the pixels of a band out: a work group takes a tile of STRATA_TILE x
// STRATA_TILE pixels, an invocation one column of it. Storage follows this order, so that the records of
// a tile lie together, as rasterisers work.
#ifndef STRATA_TILES_GLSL
#define STRATA_TILES_GLSL

#include "strata/frame.glsl"
#include "strata/scan.glsl"

#define STRATA_TILE 64u

#ifdef STRATA_RANGE_CURSORS // the counts are replaced
layout(r32f) uniform image2D count_image;
#else
uniform sampler2D count_image;
#endif

uvec2 strata_tiles() { return (strata_band.zw + STRATA_TILE - 1u) / STRATA_TILE; }

// The work group's tile; beyond the last one in the last row of groups (strata_groups in strata/gpu.h).
uint strata_tile() { return gl_WorkGroupID.y * STRATA_GROUP_ROW + gl_WorkGroupID.x; }
bool strata_tile_exists() { return strata_tile() < strata_tiles().x * strata_tiles().y; }

// Index within the band of the invocation's i-th pixel; false beyond the band's edge.
bool strata_tile_pixel(uint i, out uint pixel) {
    uint tiles = strata_tiles().x;
    uvec2 p = uvec2(strata_tile() % tiles, strata_tile() / tiles) * STRATA_TILE +
              uvec2(gl_LocalInvocationID.x, i);
    pixel = p.y * strata_band.z + p.x;
    return p.x < strata_band.z && p.y < strata_band.w;
}

uint strata_count_at(uint pixel) {
#ifdef STRATA_RANGE_CURSORS
    return uint(imageLoad(count_image, ivec2(strata_position(pixel))).r);
#else
    return uint(texelFetch(count_image, ivec2(strata_position(pixel)), 0).r);
#endif
}

#endif
