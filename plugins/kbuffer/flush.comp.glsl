// SPDX-License-Identifier: MIT
//
// kbuffer, at the end of the stream: folds what the sorters still hold, ends the walks at color/1, and counts
// the fragments and the pixels whose order was lost.
#include "strata/certificate.glsl"
#include "strata/output.glsl"
#include "strata/scan.glsl"
#include "strata/totals.glsl"
#include "sorter.glsl"

layout(std430) buffer Lost { uint lost_pixels; };

#ifdef ATTACHMENTS
#if WORDS > 0
uniform usampler2D state0;
#endif
#if WORDS > 4
uniform usampler2D state1;
#endif
#if WORDS > 8
uniform usampler2D state2;
#endif
#if WORDS > 12
uniform usampler2D state3;
#endif
#if WORDS > 16
uniform usampler2D state4;
#endif
#if WORDS > 20
uniform usampler2D state5;
#endif
#if WORDS > 24
uniform usampler2D state6;
#endif
#if WORDS > 28
uniform usampler2D state7;
#endif

void state_load(uint pixel) {
    ivec2 at = ivec2(strata_position(pixel));
#if WORDS > 0
    WORDS_PUT(0, texelFetch(state0, at, 0))
#endif
#if WORDS > 4
    WORDS_PUT(4, texelFetch(state1, at, 0))
#endif
#if WORDS > 8
    WORDS_PUT(8, texelFetch(state2, at, 0))
#endif
#if WORDS > 12
    WORDS_PUT(12, texelFetch(state3, at, 0))
#endif
#if WORDS > 16
    WORDS_PUT(16, texelFetch(state4, at, 0))
#endif
#if WORDS > 20
    WORDS_PUT(20, texelFetch(state5, at, 0))
#endif
#if WORDS > 24
    WORDS_PUT(24, texelFetch(state6, at, 0))
#endif
#if WORDS > 28
    WORDS_PUT(28, texelFetch(state7, at, 0))
#endif
}
#else
layout(std430) readonly buffer State { uint state[]; };

void state_load(uint pixel) {
    for (int w = 0; w < WORDS; ++w)
        words[w] = state[pixel * uint(WORDS) + uint(w)];
}
#endif

// How many fragments the pixel had.
uint flush(uint pixel) {
    state_load(pixel);
    if (words[0] == 0u)
        return 0u;
    StrataElement walk = sorter_flush();
    if ((words[1] & LOST) != 0u) {
        atomicAdd(lost_pixels, 1u);
        strata_uncertified(pixel);
    }
    strata_output(pixel, walk);
    return words[0];
}

void main() {
    uint pixel = strata_item();
    uint count = pixel < strata_pixel_count() ? flush(pixel) : 0u, total;
    strata_totals_largest(count);
    strata_scan(count, total);
    if (gl_LocalInvocationID.x == 0u)
        strata_totals_add(total, total);
}
