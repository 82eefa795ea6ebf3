// SPDX-License-Identifier: MIT
//
// What all pixels of a band come to, for verify(): the largest count and the fragments that arrived, in 64
// bits. Mirrors struct counting_totals in plugins/shared/counting.h.
#ifndef STRATA_TOTALS_GLSL
#define STRATA_TOTALS_GLSL

layout(std430) buffer Totals {
    uint total_largest;
    uint total_arrived, total_arrived_high;
    uint total_kept, total_kept_high;
};

#define STRATA_ADD_WIDE(low, high, value)                                                          \
    {                                                                                              \
        uint before = atomicAdd(low, value);                                                       \
        if (before + (value) < before)                                                             \
            atomicAdd(high, 1u);                                                                   \
    }

void strata_totals_largest(uint count) {
    if (count > total_largest) // it only grows
        atomicMax(total_largest, count);
}

// Of at most 2^8 pixels at once: counts are below 2^24.
void strata_totals_add(uint arrived, uint kept) {
    if (arrived == 0u)
        return;
    STRATA_ADD_WIDE(total_arrived, total_arrived_high, arrived)
    STRATA_ADD_WIDE(total_kept, total_kept_high, kept)
}

#endif
