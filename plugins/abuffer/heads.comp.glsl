// SPDX-License-Identifier: MIT
//
// abuffer, linked: every list begins empty.
#define STRATA_RANGES writeonly
#include "strata/fragments.glsl"
#include "strata/scan.glsl"

void main() {
    uint pixel = strata_item();
    if (pixel < strata_pixel_count())
        strata_ranges[pixel] = uvec2(STRATA_END, 0u);
}
