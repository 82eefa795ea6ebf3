// SPDX-License-Identifier: MIT
//
// kplus, atomics: a pixel's slots as a chain in ascending order at every moment. A value goes down the
// chain by atomicMin, taking the place of a larger one that goes on. Words only fall, and what is pushed
// on from a slot is never smaller than what any slot before holds: hence the order, and a stale read can
// only see too much. Empty slots hold the largest value.
//   WIDE   one chain of 64 bits, key << 32 | order (int64 atomics; swap.comp.glsl puts words in order)
//   else   a chain of keys, each as often as it occurs; then, among the slots of one key, one of orders
#ifndef STRATA_RECORDS // read as what they are here, not as fragments/1 has them
#define STRATA_RECORDS readonly
#endif
#ifdef WIDE
#define STRATA_KEYS uint64_t
#define VALUE uint64_t
#define NO_VALUE packUint2x32(uvec2(0xffffffffu))
#define CHAIN(slot) strata_keys[slot]
#else
#define STRATA_KEYS uint
#define VALUE uint
#define NO_VALUE 0xffffffffu
#define CHAIN(slot) strata_keys[2u * (slot)]
#define ORDERS(slot) strata_keys[2u * (slot) + 1u]
#endif
#include "slots.glsl"

#ifdef WIDE
VALUE value_of(uvec2 record) { return packUint2x32(record.yx); }
#else
VALUE value_of(uvec2 record) { return record.x; }
#endif

// How many of the slots hold less than `value`.
uint chain_below(uvec2 slots, VALUE value) {
    uint low = 0u, high = slots.y;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (CHAIN(slots.x + middle) < value)
            low = middle + 1u;
        else
            high = middle;
    }
    return low;
}
