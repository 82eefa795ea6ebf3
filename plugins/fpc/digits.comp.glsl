// SPDX-License-Identifier: MIT
//
// fpc, pass 5, one invocation: how many bits of order, key and rank tell the elements apart. order
// counts only when params.by_order is set: short runs of equal keys are mended after the sort.
#include "strata/scan.glsl"
#include "table.glsl"

FPC_TABLE(restrict)
STRATA_PARAMS { uint by_order; } params;

uint bits_of(uint value) { return uint(findMSB(value) + 1); }

void main() {
    if (gl_LocalInvocationID.x != 0u || fits == 0u || elements == 0u)
        return;
    order_bits = params.by_order != 0u ? bits_of(last - ~inverse_first) : 0u;
    key_bits = bits_of(farthest - ~inverse_nearest);
    rank_bits = bits_of(pixels - 1u);
}
