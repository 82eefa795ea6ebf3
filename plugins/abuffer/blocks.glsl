// SPDX-License-Identifier: MIT
//
// How the scans share the pixels of a band out: a work group takes a tile of TILE x TILE pixels, an
// invocation one column of it. Storage follows this order, so that the records of a tile lie together,
// as rasterisers work.
#define TILE 64u

uvec2 tile_count() { return (strata_band.zw + TILE - 1u) / TILE; }

// The work group's tile; beyond the last one in the last row of groups (strata_groups in strata/gpu.h).
uint tile_index() { return gl_WorkGroupID.y * STRATA_GROUP_ROW + gl_WorkGroupID.x; }
bool tile_exists() { return tile_index() < tile_count().x * tile_count().y; }

// Index within the band of the invocation's i-th pixel; false beyond the band's edge.
bool tile_pixel(uint i, out uint pixel) {
    uint tiles = tile_count().x;
    uvec2 p = uvec2(tile_index() % tiles, tile_index() / tiles) * TILE +
              uvec2(gl_LocalInvocationID.x, i);
    pixel = p.y * strata_band.z + p.x;
    return p.x < strata_band.z && p.y < strata_band.w;
}
