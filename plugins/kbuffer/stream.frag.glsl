// SPDX-License-Identifier: MIT
//
// kbuffer, the one geometry pass: each fragment goes through its pixel's sorter. The pixel's words are
// colour attachments that are read and replaced in primitive order (ATTACHMENTS), or storage, where the
// device's self-test has shown the same of it.
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/frame.glsl"
#include "sorter.glsl"

layout(early_fragment_tests) in;
#ifdef ATTACHMENTS
#include "strata/ordered.glsl"
#if WORDS > 0
STRATA_ORDERED_UINT(0)
#endif
#if WORDS > 4
STRATA_ORDERED_UINT(1)
#endif
#if WORDS > 8
STRATA_ORDERED_UINT(2)
#endif
#if WORDS > 12
STRATA_ORDERED_UINT(3)
#endif
#if WORDS > 16
STRATA_ORDERED_UINT(4)
#endif
#if WORDS > 20
STRATA_ORDERED_UINT(5)
#endif
#if WORDS > 24
STRATA_ORDERED_UINT(6)
#endif
#if WORDS > 28
STRATA_ORDERED_UINT(7)
#endif

#define WORD(i) ((i) < WORDS ? words[min(i, WORDS - 1)] : 0u)
#define WORDS_GET(first) uvec4(WORD(first), WORD(first + 1), WORD(first + 2), WORD(first + 3))

void state_load(uint pixel) {
#if WORDS > 0
    WORDS_PUT(0, STRATA_ORDERED_LOAD(0))
#endif
#if WORDS > 4
    WORDS_PUT(4, STRATA_ORDERED_LOAD(1))
#endif
#if WORDS > 8
    WORDS_PUT(8, STRATA_ORDERED_LOAD(2))
#endif
#if WORDS > 12
    WORDS_PUT(12, STRATA_ORDERED_LOAD(3))
#endif
#if WORDS > 16
    WORDS_PUT(16, STRATA_ORDERED_LOAD(4))
#endif
#if WORDS > 20
    WORDS_PUT(20, STRATA_ORDERED_LOAD(5))
#endif
#if WORDS > 24
    WORDS_PUT(24, STRATA_ORDERED_LOAD(6))
#endif
#if WORDS > 28
    WORDS_PUT(28, STRATA_ORDERED_LOAD(7))
#endif
}

void state_store(uint pixel) {
#if WORDS > 0
    STRATA_ORDERED_STORE(0, WORDS_GET(0));
#endif
#if WORDS > 4
    STRATA_ORDERED_STORE(1, WORDS_GET(4));
#endif
#if WORDS > 8
    STRATA_ORDERED_STORE(2, WORDS_GET(8));
#endif
#if WORDS > 12
    STRATA_ORDERED_STORE(3, WORDS_GET(12));
#endif
#if WORDS > 16
    STRATA_ORDERED_STORE(4, WORDS_GET(16));
#endif
#if WORDS > 20
    STRATA_ORDERED_STORE(5, WORDS_GET(20));
#endif
#if WORDS > 24
    STRATA_ORDERED_STORE(6, WORDS_GET(24));
#endif
#if WORDS > 28
    STRATA_ORDERED_STORE(7, WORDS_GET(28));
#endif
}
#else
layout(std430) buffer State { uint state[]; };

void state_load(uint pixel) {
    for (int w = 0; w < WORDS; ++w)
        words[w] = state[pixel * uint(WORDS) + uint(w)];
}

void state_store(uint pixel) {
    for (int w = 0; w < WORDS; ++w)
        state[pixel * uint(WORDS) + uint(w)] = words[w];
}
#endif

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    uint pixel = strata_pixel(uvec2(gl_FragCoord.xy));
    uint payload[STRATA_PAYLOAD_WORDS];
    strata_payload_encode(strata_emit(surface), payload);
    state_load(pixel);
    sorter_insert(uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive)), payload);
    state_store(pixel);
}
