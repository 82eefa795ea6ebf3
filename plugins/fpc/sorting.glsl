// SPDX-License-Identifier: MIT
//
// fpc: elements in two copies between which the radix sort alternates: a pass reads copy SIDE and writes
// the other. The number that is sorted by is rank, key - nearest, order - first, from high to low, each
// as wide as the frame needs it. What a pass does not use is left out by #if: some drivers execute both
// branches of an `if`.
layout(std430) buffer Elements0 { uvec2 elements0[]; };
layout(std430) buffer Elements1 { uvec2 elements1[]; };
layout(std430) buffer Slots0 { uint slots0[]; };
layout(std430) buffer Slots1 { uint slots1[]; };

#if SIDE == 0
#define FROM_ELEMENTS elements0
#define FROM_SLOTS slots0
#define TO_ELEMENTS elements1
#define TO_SLOTS slots1
#else
#define FROM_ELEMENTS elements1
#define FROM_SLOTS slots1
#define TO_ELEMENTS elements0
#define TO_SLOTS slots0
#endif

// value * 2^by, cut to 32 bits, for any by
uint shifted(uint value, int by) {
    return by <= -32 || by >= 32 ? 0u : by < 0 ? value >> -by : value << by;
}

// The digit of the element at `at` that begins at `bit`.
uint digit_of(uvec2 element, uint at, uint bit) {
    int to = int(order_bits) - int(bit);
    uint digit =
        shifted(element.y - ~inverse_nearest, to) | shifted(element.x, to + int(key_bits));
#if BY_ORDER
    if (to > 0)
        digit |= shifted(strata_key_at(FROM_SLOTS[at]).y - ~inverse_first, -int(bit));
#endif
    return digit & (DIGITS - 1u);
}
