// SPDX-License-Identifier: MIT
//
// Buckets of keys, in integers alone. A tile of TILE x TILE pixels says how its pixels divide the
// keys near .. far into at most OCCUPANCY_WORDS * 32 buckets of equal width:
//
//     bucket(key) = ((clamp(key, near, far) - near) >> shift) * multiplier >> 16
//
// never falls as the key grows, whatever the four numbers are; so the keys of the buckets 0 .. b are
// those up to an edge, and the edge is exact. far - near >> shift is below 2^16 and the product below
// OCCUPANCY_WORDS * 2^21.
#ifndef OCCUPANCY_BUCKETS_GLSL
#define OCCUPANCY_BUCKETS_GLSL

#include "strata/key.glsl"

const uint TILE = 8u; // pixels; occupancy.c has it too

struct Division {
    uint near, far; // keys, near <= far
    uint shift, multiplier;
};

Division divide(uint near, uint far) {
    int bits = findMSB(far - near) + 1;
    uint shift = uint(max(bits - 16, 0));
    uint values = (far - near >> shift) + 1u;
    return Division(near, far, shift, (OCCUPANCY_WORDS << 21) / values);
}

uint bucket_of(Division d, uint key) {
    return (clamp(key, d.near, d.far) - d.near >> d.shift) * d.multiplier >> 16;
}

// The last key of a bucket: every fragment of the buckets up to it has that key or a smaller one. The
// last bucket takes whatever lies beyond.
uint far_edge(Division d, uint bucket) {
    uint value = ((bucket + 1u << 16) - 1u) / d.multiplier;
    return value >= d.far - d.near >> d.shift ? STRATA_FAR_KEY
                                              : d.near + (value + 1u << d.shift) - 1u;
}

uvec2 tile_count() { return (strata_frame_size.xy + TILE - 1u) / TILE; }

#ifdef OCCUPANCY_DIVIDES // the one pass that writes them
layout(rgba32ui) uniform writeonly uimage2D tiles;
#else
layout(rgba32ui) uniform readonly uimage2D tiles; // no level to be found, as a sampler's

Division division_at(uvec2 position) {
    uvec4 t = imageLoad(tiles, ivec2(position / TILE));
    return Division(t.x, t.y, t.z, t.w);
}
#endif

#endif
