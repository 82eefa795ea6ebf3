// SPDX-License-Identifier: MIT
//
// The walk from the eye: elements (C, T) composed front to back, C = C1 + T1 C2, T = T1 T2. `precise`
// keeps every technique on the same bits. StrataElement comes from the generated effect header.
#ifndef STRATA_FOLD_GLSL
#define STRATA_FOLD_GLSL

#include "strata/effects.glsl"

StrataElement strata_fold_begin() { return StrataElement(vec4(0.0), STRATA_TRANSMITTANCE(1.0)); }

// A transmittance for each of r, g, b and alpha; alpha takes the mean of a coloured one.
#if STRATA_CHANNELS == 3
vec4 strata_transmittance4(vec3 t) {
    precise float mean = (t.r + t.g + t.b) * (1.0 / 3.0);
    return vec4(t, mean);
}
#else
vec4 strata_transmittance4(float t) { return vec4(t); }
#endif

void strata_fold_step(inout StrataElement walk, StrataElement element) {
    precise vec4 color = walk.color + strata_transmittance4(walk.transmittance) * element.color;
    precise STRATA_TRANSMITTANCE t = walk.transmittance * element.transmittance;
    walk.color = color;
    walk.transmittance = t;
}

// What the eye sees when the walk ends at an opaque surface or the background.
vec4 strata_fold_end(StrataElement walk, vec4 behind) {
    precise vec4 color = walk.color + strata_transmittance4(walk.transmittance) * behind;
    return color;
}

#endif
