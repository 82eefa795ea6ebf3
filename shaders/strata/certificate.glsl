// SPDX-License-Identifier: MIT
//
// What a certificate of error rests on: the losses of each pixel of the band. Only where one is asked
// for (STRATA_BOUND, set by the host) is anything kept; else every call here is empty and free.
#ifndef STRATA_CERTIFICATE_GLSL
#define STRATA_CERTIFICATE_GLSL

#ifdef STRATA_BOUND
#include "strata/frame.glsl"

// The host zeroes it when a band starts. A pixel's words: flags and the number of dropped fragments,
// then what loss.glsl sums up.
const uint STRATA_LOSS_COUNT = 0x0fffffffu; // beyond it the count runs into a flag: uncertified
const uint STRATA_LOSS_UNKNOWN = 0x10000000u;
const uint STRATA_LOSS_UNSEEN = 0x20000000u;
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
