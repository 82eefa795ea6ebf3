// SPDX-License-Identifier: MIT
//
// kplus, k per pixel, last: the pool is told what the next recording needs, so that it grows at once.
#include "strata/scan.glsl"

layout(std430) buffer StrataFragmentPool { uint strata_needed; };
layout(std430) readonly buffer Grown { uint grown_pixels; uint grown_records; };

void main() {
    if (strata_item() == 0u)
        strata_needed = strata_add(strata_needed, grown_records);
}
