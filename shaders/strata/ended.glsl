// SPDX-License-Identifier: MIT
//
// Where a walk ends early, for folds with an opacity threshold.
#ifndef STRATA_ENDED_GLSL
#define STRATA_ENDED_GLSL

#include "strata/fold.glsl"

// Whether what lies behind is hidden but for less than `threshold` of each channel. 0: never.
bool strata_ended(StrataElement walk, float threshold) {
    vec4 t = strata_transmittance4(walk);
    return max(max(t.r, t.g), max(t.b, t.a)) < threshold;
}

#endif
