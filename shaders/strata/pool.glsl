// SPDX-License-Identifier: MIT
//
// How much of the pool of fragments/1 was needed and how much there is, for who does not take of it.
#ifndef STRATA_POOL_GLSL
#define STRATA_POOL_GLSL

STRATA_READ(StrataFragmentPool, uint)

uint strata_pool_needed() { return STRATA_AT_UINT(StrataFragmentPool, 0u); }
uint strata_pool_capacity() { return STRATA_AT_UINT(StrataFragmentPool, 1u); }

// Then this attempt is in vain: the frame is recorded again, with more room or in bands.
bool strata_pool_short() { return strata_pool_needed() > strata_pool_capacity(); }

#endif
