// SPDX-License-Identifier: MIT
//
// fragments/1, the exchange format between capture and resolve: key and order of a fragment, ranges
// of a pixel, records in planes. STRATA_RANGES and STRATA_RECORDS are the qualifiers (readonly,
// writeonly or empty) with which a stage touches them; the payload planes, StrataPayload and its
// packing come from the generated effect header.
#ifndef STRATA_FRAGMENTS_GLSL
#define STRATA_FRAGMENTS_GLSL

#include "strata/frame.glsl"
#include "strata/key.glsl"

#ifndef STRATA_RANGES
#define STRATA_RANGES readonly
#endif
#ifndef STRATA_RECORDS
#define STRATA_RECORDS readonly
#endif

const uint STRATA_END = 0xffffffffu; // no next record

layout(std430) STRATA_RANGES buffer StrataRanges { uvec2 strata_ranges[]; };
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

#endif
