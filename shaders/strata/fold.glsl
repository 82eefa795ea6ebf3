// SPDX-License-Identifier: MIT
//
// The walk from the eye: elements (C, T) composed front to back, C = C1 + T1 C2, T = T1 T2. `precise`
// keeps every technique on the same bits. StrataElement comes from the generated effect header; where a
// certificate is asked for it carries bounds of its errors, which compose in the same way, one after
// the other or as a tree.
#ifndef STRATA_FOLD_GLSL
#define STRATA_FOLD_GLSL

#include "strata/effects.glsl"

StrataElement strata_fold_begin() {
    return StrataElement(vec4(0.0), STRATA_TRANSMITTANCE(1.0)
#ifdef STRATA_BOUND
                         , vec4(0.0), STRATA_TRANSMITTANCE(0.0)
#endif
    );
}

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
#ifdef STRATA_BOUND
    vec4 error = strata_color_error(walk, element, strata_transmittance4(walk), color);
    walk.transmittance_error = strata_transmittance_error(walk, element);
    walk.color_error = error;
#endif
    walk.color = color;
    walk.transmittance = t;
}

// What the eye sees when the walk ends at an opaque surface or the background.
vec4 strata_fold_end(StrataElement walk, vec4 behind) {
    precise vec4 color = walk.color + strata_transmittance4(walk) * behind;
    return color;
}

#include "strata/bound.glsl"

// An element in memory, for folds that are interrupted: STRATA_ELEMENT_PARTS vectors of four floats.
#ifdef STRATA_BOUND
#define STRATA_ELEMENT_PARTS 4
#else
#define STRATA_ELEMENT_PARTS 2
#endif

void strata_element_split(StrataElement element, out vec4 parts[STRATA_ELEMENT_PARTS]) {
    parts[0] = element.color;
    parts[1] = strata_transmittance4(element);
#ifdef STRATA_BOUND
    parts[2] = element.color_error;
#if STRATA_CHANNELS == 3
    parts[3] = vec4(element.transmittance_error, 0.0);
#else
    parts[3] = vec4(element.transmittance_error);
#endif
#endif
}

StrataElement strata_element_join(vec4 parts[STRATA_ELEMENT_PARTS]) {
#if STRATA_CHANNELS == 3
#define STRATA_PART(i) parts[i].rgb
#else
#define STRATA_PART(i) parts[i].r
#endif
    return StrataElement(parts[0], STRATA_PART(1)
#ifdef STRATA_BOUND
                         , parts[2], STRATA_PART(3)
#endif
    );
#undef STRATA_PART
}

#endif
