// SPDX-License-Identifier: MIT
//
// wboit, composite: the mean colour, covering as much as all fragments together, over what lies behind.
#include "strata/fold.glsl"
#include "strata/output.glsl"
#include "strata/scan.glsl"

uniform sampler2D accumulation;
uniform sampler2D revealage;

// A sum that overflowed (HDR colours in 16 bits) is white as bright as it is dense, as in the paper's code.
vec4 wboit_sum(ivec2 at) {
    vec4 sum = texelFetch(accumulation, at, 0);
    return any(isinf(sum.rgb)) ? vec4(sum.a) : sum;
}

void main() {
    uint pixel = strata_item();
    if (pixel >= strata_pixel_count())
        return;
    ivec2 at = ivec2(strata_position(pixel));
    vec4 revealed = texelFetch(revealage, at, 0);
#if STRATA_CHANNELS == 1
    revealed = revealed.rrrr;
#endif
#ifndef STRATA_BOUND // else what cannot be certified is still to be said
    if (revealed == vec4(1.0))
        return; // no fragment, or none that covers anything
#endif
    vec4 sum = wboit_sum(at);
    precise float covered = 1.0 - revealed.a;
    precise vec3 mean = sum.a > 0.0 ? sum.rgb / sum.a * covered : vec3(0.0);
    StrataElement all = strata_fold_begin();
    all.color = vec4(mean, covered);
    all.transmittance = STRATA_TRANSMITTANCE(revealed);
    strata_output(pixel, all);
}
