// SPDX-License-Identifier: MIT
//
// What a certificate of error rests on: the losses of each pixel of the band. Only where one is asked
// for (STRATA_BOUND, set by the host to the words a pixel has) is anything kept; else every call here
// is empty and free.
#ifndef STRATA_CERTIFICATE_GLSL
#define STRATA_CERTIFICATE_GLSL

#ifdef STRATA_BOUND
#include "strata/frame.glsl"

// The host zeroes it when a band starts. The words of a pixel, over its dropped fragments:
//   0     flags
//   1..3  the largest share C / (1 - T) in r, g, b, as the bits of a float
//   4..6  the sum of C in r, g, b, in units of 2^-16
//   7..   the sum of -ln T in units of 2^-24, one value or three
const uint STRATA_LOSS_UNKNOWN = 1u;
const uint STRATA_LOSS_UNSEEN = 2u; // some were never shaded
const uint STRATA_LOSS_SIGNED = 4u; // some have a negative colour
const uint STRATA_LOSS_ODD = 8u;    // alpha is not what the transmittance leaves
const uint STRATA_LOSS_HEAVY = 16u; // the sum of C exceeds its word
const uint STRATA_LOSS_DARK = 32u;  // the sum of -ln T exceeds its word, or nothing passes
layout(std430) buffer StrataLoss { uint strata_loss[]; };
#endif

// Nothing can be said about this pixel.
void strata_uncertified(uint pixel) {
#ifdef STRATA_BOUND
    atomicOr(strata_loss[pixel * STRATA_BOUND], STRATA_LOSS_UNKNOWN);
#endif
}

// Fragments that were dropped without being shaded, behind all that are kept.
void strata_lose_unseen(uint pixel) {
#ifdef STRATA_BOUND
    atomicOr(strata_loss[pixel * STRATA_BOUND], STRATA_LOSS_UNSEEN);
#endif
}

#endif
