// SPDX-License-Identifier: MIT
//
// kbuffer, the one geometry pass: each fragment goes through its pixel's sorter. The pixel's words are
// colour attachments that are read and replaced in primitive order (ATTACHMENTS), or storage, where an
// interlock (STRATA_INTERLOCK) or the device itself orders the accesses; self-tests have shown which.
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/frame.glsl"
#include "strata/interlock.glsl"
#include "sorter.glsl"

layout(early_fragment_tests) in;
#ifdef ATTACHMENTS
#include "strata/ordered.glsl"
STRATA_EACH(STRATA_ORDERED_UINT)

#define WORD(i) ((i) < WORDS ? words[min(i, WORDS - 1)] : 0u)
#define LOAD(n) WORDS_PUT(4 * n, STRATA_ORDERED_LOAD(n))
#define STORE(n)                                                                                   \
    STRATA_ORDERED_STORE(n, uvec4(WORD(4 * n), WORD(4 * n + 1), WORD(4 * n + 2), WORD(4 * n + 3)));

void state_load(uint pixel) { STRATA_EACH(LOAD) }
void state_store(uint pixel) { STRATA_EACH(STORE) }
#else
layout(std430) STRATA_INTERLOCKED buffer State { uint state[]; };

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
    uvec2 id = uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive));
    STRATA_INTERLOCK_BEGIN
    state_load(pixel);
    sorter_insert(id, payload);
    state_store(pixel);
    STRATA_INTERLOCK_END
}
