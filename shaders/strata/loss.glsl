// SPDX-License-Identifier: MIT
//
// For techniques that keep the nearest fragments only: every other one is handed to one of
// strata_lose(), strata_lose_unseen() (never shaded) and strata_uncertified() (a fragment that may lie
// in front of a kept one, or of which nothing is known). Called unconditionally; without a
// certificate they cost nothing.
#ifndef STRATA_LOSS_GLSL
#define STRATA_LOSS_GLSL

#include "strata/certificate.glsl"
#include "strata/effects.glsl"

// A fragment that was dropped, behind all that are kept.
void strata_lose(uint pixel, StrataPayload payload) {
#ifdef STRATA_BOUND
    atomicAdd(strata_loss[pixel * STRATA_BOUND], 1u);
    strata_lose_unseen(pixel);
#endif
}

#endif
