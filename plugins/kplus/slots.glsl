// SPDX-License-Identifier: MIT
//
// kplus: where a pixel's slots lie. memory=exact gave each pixel a range of its own capacity, min(count,
// its k), in StrataRanges; memory=fixed gives each k slots, and finish.comp.glsl writes the ranges.
#ifndef EXACT
#define STRATA_RANGES writeonly
#endif
#include "strata/fragments.glsl"

#ifndef MORE_PARAMS
#define MORE_PARAMS
#endif
STRATA_PARAMS { uint k; uint tries; MORE_PARAMS } params;

#ifdef EXACT
uvec2 slots_of(uint pixel) { return strata_range_at(pixel); } // first, capacity
#else
uvec2 slots_of(uint pixel) { return uvec2(pixel * params.k, params.k); }

// Of the pool; what 32 bits cannot hold asks for bands.
uint slots_needed() {
    uint pixels = strata_pixel_count();
    return pixels > 0xffffffffu / params.k ? 0xffffffffu : pixels * params.k;
}
#endif
