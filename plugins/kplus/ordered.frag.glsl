// SPDX-License-Identifier: MIT
//
// kplus, ordered attachments, the geometry pass: a fragment nearer than the farthest of its pixel takes
// that one's place, and its payload that one's slot. Empty places are the farthest of all and are taken
// in turn. With LATE, where the order of attachments says nothing of storage, payloads are left to a
// pass of their own.
#ifndef LATE
#define STRATA_PAYLOAD_WRITE
#ifdef STRATA_BOUND // what is evicted is read again
#define STRATA_PAYLOAD_READ
#endif
#endif
#include "strata/shading.glsl"
#include "strata/effects.glsl"
#include "slots.glsl"
#include "attachments.glsl"
#include "strata/loss.glsl"
#include "strata/ordered.glsl"
#include "strata/pool.glsl"

layout(early_fragment_tests) in;
#ifndef COUNTED
layout(std430) buffer Dropped { uint dropped[]; };
#endif
STRATA_EACH(STRATA_ORDERED_UINT)

#define LOAD(n) uvec4 held_##n = STRATA_ORDERED_LOAD(n);
#define COMPARE(pair, at)                                                                          \
    {                                                                                              \
        bool less = pair.x < least.x || (pair.x == least.x && pair.y < least.y);                   \
        least = less ? pair : least;                                                               \
        place = less ? at : place;                                                                 \
    }
#ifdef EACH // places beyond the pixel's own k stay empty
#define IS_PLACE(at) ((at) < K && uint(at) < most)
#else
#define IS_PLACE(at) ((at) < K)
#endif
#define FIND(n)                                                                                    \
    if (IS_PLACE(2 * n))                                                                           \
        COMPARE(held_##n.xy, 2u * uint(n))                                                         \
    if (IS_PLACE(2 * n + 1))                                                                       \
        COMPARE(held_##n.zw, 2u * uint(n) + 1u)
#define REPLACE(n)                                                                                 \
    held_##n.xy = nearer && place == 2u * uint(n) ? pair : held_##n.xy;                               \
    held_##n.zw = nearer && place == 2u * uint(n) + 1u ? pair : held_##n.zw;
#define COUNT(n)                                                                                   \
    if (2 * n == K)                                                                                \
        ++held_##n.x;                                                                              \
    if (2 * n + 1 == K)                                                                            \
        ++held_##n.z;
#define STORE(n) STRATA_ORDERED_STORE(n, held_##n);

// Derivatives and the loss need every fragment shaded.
#if !defined(LATE) && (defined(STRATA_HAS_TEXTURES) || defined(STRATA_BOUND))
#define SHADE_FIRST
#endif

void main() {
#ifdef SHADE_FIRST
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
#else
    if (!strata_covered())
        discard;
#endif
    uvec2 position = uvec2(gl_FragCoord.xy);
    uint pixel = strata_pixel(position);
    uvec2 pair = ~uvec2(strata_key(gl_FragCoord.z), strata_order(strata_primitive()));
#ifdef EACH
    uint most = slots_of(position).y;
#endif
    STRATA_EACH(LOAD)
    uvec2 least = uvec2(0xffffffffu);
    uint place = 0u;
    STRATA_EACH(FIND)
    bool nearer = pair.x > least.x || (pair.x == least.x && pair.y > least.y);
    STRATA_EACH(REPLACE)
#ifdef COUNTED
    STRATA_EACH(COUNT)
#else
    if (!nearer || least != uvec2(0u))
        atomicAdd(dropped[pixel], 1u);
#endif
    STRATA_EACH(STORE)
#ifndef LATE
    if (strata_pool_short())
        return;
    uint slot = slots_of(position).x + place;
#ifdef SHADE_FIRST
    StrataPayload payload = strata_emit(surface);
    bool full = least != uvec2(0u);
    StrataPayload left_out = payload;
#ifdef STRATA_BOUND
    if (nearer && full)
        left_out = strata_payload_load(slot);
#endif
    if (nearer)
        strata_payload_store(slot, payload);
    if (!nearer || full)
        strata_lose(pixel, left_out);
#else
    if (nearer) {
        StrataSurface surface;
        strata_surface(surface);
        strata_payload_store(slot, strata_emit(surface));
    }
#endif
#endif
}
