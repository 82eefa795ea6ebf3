// SPDX-License-Identifier: MIT
//
// fpc: counters of the radix sort in blocks, one a work group.
uint counter_count() { return streams * DIGITS; }
uint counter_begin() {
    return min(strata_item() * COUNTERS_PER_INVOCATION, counter_count());
}
uint counter_end() {
    return min((strata_item() + 1u) * COUNTERS_PER_INVOCATION, counter_count());
}
