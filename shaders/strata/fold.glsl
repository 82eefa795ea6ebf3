// SPDX-License-Identifier: MIT
//
// The walk from the eye: elements (C, T) composed front to back, C = C1 + T1 C2, T = T1 T2. `precise`
// keeps every technique on the same bits. StrataElement comes from the generated effect header.
#ifndef STRATA_FOLD_GLSL
#define STRATA_FOLD_GLSL

#include "strata/effects.glsl"

StrataElement strata_fold_begin() { return StrataElement(vec4(0.0), STRATA_TRANSMITTANCE(1.0)); }

// A transmittance for each of r, g, b and alpha. Where transmission is coloured, alpha has one of its own:
// coverages compose by themselves, as they do without colour.
vec4 strata_transmittance4(StrataElement element) {
#if STRATA_CHANNELS == 3
    precise float uncovered = 1.0 - element.color.a;
    return vec4(element.transmittance, uncovered);
#else
    return vec4(element.transmittance);
#endif
}

void strata_fold_step(inout StrataElement walk, StrataElement element) {
    precise vec4 color = walk.color + strata_transmittance4(walk) * element.color;
    precise STRATA_TRANSMITTANCE t = walk.transmittance * element.transmittance;
    walk.color = color;
    walk.transmittance = t;
}

// What the eye sees when the walk ends at an opaque surface or the background.
vec4 strata_fold_end(StrataElement walk, vec4 behind) {
    precise vec4 color = walk.color + strata_transmittance4(walk) * behind;
    return color;
}

#endif
