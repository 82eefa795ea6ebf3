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
#define DECLARE(n) uniform usampler2D state##n;
STRATA_EACH(DECLARE)
#define LOAD(n) WORDS_PUT(4 * n, texelFetch(state##n, ivec2(strata_position(pixel)), 0))

void state_load(uint pixel) { STRATA_EACH(LOAD) }
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
