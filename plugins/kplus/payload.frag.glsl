// SPDX-License-Identifier: MIT
//
// kplus, atomics, last geometry pass: a fragment that has a slot writes its payload there; the others are
// lost. With TAKE_ORDERS (32 bits, no orders pass before) it also enters its order; where several
// fragments may claim the slot, the frame is recorded again with the orders pass.
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/effects.glsl"
#ifdef TAKE_ORDERS
#include "descend.glsl"
#else
#include "chain.glsl"
#endif
#include "strata/loss.glsl"
#include "strata/pool.glsl"

layout(early_fragment_tests) in;
#ifdef TAKE_ORDERS
layout(std430) buffer Ties { uint ties; };
#endif

const uint NO_SLOT = 0xffffffffu;

#if defined(TAKE_ORDERS)
uint slot_of(uvec2 slots, uvec2 record) {
    uint i = chain_below(slots, record.x), last = slots.y - 1u;
    if (i == slots.y || CHAIN(slots.x + i) != record.x)
        return NO_SLOT;
    uint slot = slots.x + i;
    // One slot of the key, or fewer than its fragments: only the last key of a full pixel.
    bool tied = i < last && CHAIN(slot + 1u) == record.x;
    uint held = atomicMin(ORDERS(slot), record.y);
    if (i == last) // the order of primitive 0 looks like none
        tied = held != 0xffffffffu || record.y == 0xffffffffu;
    if (tied)
        atomicOr(ties, 1u);
    return slot;
}
#elif defined(WIDE)
uint slot_of(uvec2 slots, uvec2 record) {
    uint i = chain_below(slots, value_of(record));
    return i < slots.y && CHAIN(slots.x + i) == value_of(record) ? slots.x + i : NO_SLOT;
}
#else
uint slot_of(uvec2 slots, uvec2 record) {
    uint low = 0u, high = slots.y;
    while (low < high) {
        uint middle = (low + high) / 2u, slot = slots.x + middle;
        if (strata_before(uvec2(CHAIN(slot), ORDERS(slot)), record))
            low = middle + 1u;
        else
            high = middle;
    }
    uint slot = slots.x + low;
    return low < slots.y && CHAIN(slot) == record.x && ORDERS(slot) == record.y ? slot : NO_SLOT;
}
#endif

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    if (strata_pool_short())
        return;
    uvec2 position = uvec2(gl_FragCoord.xy), slots = slots_of(position);
    uint slot = slot_of(slots, uvec2(strata_key(gl_FragCoord.z), strata_order(surface.primitive)));
    StrataPayload payload = strata_emit(surface);
    if (slot == NO_SLOT)
        strata_lose(strata_pixel(position), payload);
    else
        strata_payload_store(slot, payload);
}
