// SPDX-License-Identifier: MIT
//
// kplus, ordered attachments, after them: records from texels to slots; with memory=fixed also the ranges
// and the totals. With LATE, sorted, so that the payload pass finds its slots.
#define STRATA_RECORDS writeonly
#define STRATA_KEYS STRATA_PAIR
#include "slots.glsl"
#include "attachments.glsl"
#include "strata/pool.glsl"
#include "strata/scan.glsl"
#include "strata/totals.glsl"
#ifdef LATE
#define STRATA_EXCHANGE(i, j)                                                                      \
    {                                                                                              \
        uvec2 a = r[i], b = r[j];                                                                  \
        bool swap = strata_before(b, a);                                                           \
        r[i] = swap ? b : a;                                                                       \
        r[j] = swap ? a : b;                                                                       \
    }
#include "strata/sort.glsl"
#endif

#ifndef COUNTED
layout(std430) readonly buffer Dropped { uint dropped[]; };
#endif
#define DECLARE(n) uniform usampler2D held_##n;
STRATA_EACH(DECLARE)

#define FETCH(n)                                                                                   \
    {                                                                                              \
        uvec4 held = texelFetch(held_##n, at, 0);                                                  \
        if (2 * n < K)                                                                             \
            r[2 * n] = ~held.xy;                                                                   \
        if (2 * n + 1 < K)                                                                         \
            r[2 * n + 1] = ~held.zw;                                                               \
        if (2 * n == K)                                                                            \
            arrived = held.x;                                                                      \
        if (2 * n + 1 == K)                                                                        \
            arrived = held.z;                                                                      \
    }

void main() {
    uint pixel = strata_item();
    if (pixel >= strata_pixel_count())
        return;
    uvec2 position = strata_position(pixel);
    ivec2 at = ivec2(position);
    uvec2 r[16], slots = slots_of(position);
    uint arrived = 0u, kept = 0u;
    for (uint i = 0u; i < 16u; ++i)
        r[i] = uvec2(0xffffffffu);
    STRATA_EACH(FETCH)
#ifdef LATE
    STRATA_SORT_16(0)
#endif
    bool fits = !strata_pool_short();
    for (uint i = 0u; i < K; ++i) {
        bool held = r[i].x != STRATA_NO_KEY;
        kept += uint(fits && held);
#ifdef LATE // the search for a slot needs an end
        held = i < slots.y;
#endif
        if (fits && held)
            strata_keys[slots.x + i] = STRATA_TO_PAIR(r[i]);
    }
#ifndef EXACT
#ifndef COUNTED
    arrived = kept + dropped[pixel];
#endif
    strata_ranges[pixel] = uvec2(slots.x, kept);
    strata_totals_largest(arrived);
    strata_totals_add(arrived, kept);
#endif
}
