// SPDX-License-Identifier: MIT
//
// fragments/1, the exchange format between capture and resolve: key and order of a fragment, ranges
// of a pixel, records in planes. Stages that read do so by the functions below; STRATA_RANGES and
// STRATA_RECORDS are the qualifiers (writeonly, coherent or empty) of those that write, to strata_ranges,
// strata_keys and strata_links, or that read keys in a type of their own, STRATA_KEYS. The payload planes,
// StrataPayload and its packing come from the generated effect header.
#ifndef STRATA_FRAGMENTS_GLSL
#define STRATA_FRAGMENTS_GLSL

#include "strata/frame.glsl"
#include "strata/key.glsl"

const uint STRATA_END = 0xffffffffu; // no next record

#ifdef STRATA_RANGES
layout(std430) STRATA_RANGES buffer StrataRanges { uvec2 strata_ranges[]; };
#else
STRATA_READ(StrataRanges, uvec2)
uvec2 strata_range_at(uint pixel) { return STRATA_AT_UVEC2(StrataRanges, pixel); } // offset, count
#endif

#ifdef STRATA_RECORDS
#ifndef STRATA_KEYS
#define STRATA_KEYS uvec2 // or STRATA_PAIR, where both words are always touched together
#endif
layout(std430) STRATA_RECORDS buffer StrataKeys { STRATA_KEYS strata_keys[]; };
#if STRATA_LAYOUT == 1
#ifndef STRATA_LINKS
#define STRATA_LINKS uvec2 // likewise
#endif
layout(std430) STRATA_RECORDS buffer StrataLinks { STRATA_LINKS strata_links[]; };
#endif
#else
STRATA_READ(StrataKeys, uvec2)
uvec2 strata_key_at(uint slot) { return STRATA_AT_UVEC2(StrataKeys, slot); } // key, order
#if STRATA_LAYOUT == 1
STRATA_READ(StrataLinks, uvec2)
uvec2 strata_link_at(uint slot) { return STRATA_AT_UVEC2(StrataLinks, slot); } // next, pixel
#endif
#endif

#endif
