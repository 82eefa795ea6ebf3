// SPDX-License-Identifier: MIT
//
// kplus, atomics: a value's way down the chain. No lock: whatever the interleaving, the slots end with the
// smallest values of all that were sent down, in order.
#define STRATA_RECORDS coherent
#include "chain.glsl"

void descend(uvec2 slots, VALUE value) {
    if (slots.y == 0u || value > CHAIN(slots.x + slots.y - 1u))
        return;
    // Slots that hold no more than the value are not touched; they never rise above it again.
    for (uint i = chain_below(slots, value); i < slots.y && value != NO_VALUE; ++i) {
        VALUE held = atomicMin(CHAIN(slots.x + i), value);
        value = max(held, value);
    }
}

#ifndef WIDE
// The slots of one key.
uvec2 slots_of_key(uvec2 slots, uint key) {
    uint first = chain_below(slots, key), last = chain_below(slots, key + 1u);
    return uvec2(slots.x + first, last - first);
}

// Among fragments of one key: the orders, in the slots of that key.
void descend_orders(uvec2 slots, uint order) {
    for (uint i = 0u; i < slots.y; ++i)
        order = max(atomicMin(ORDERS(slots.x + i), order), order);
}
#endif
