// SPDX-License-Identifier: MIT
//
// A slot in a texel of R32F, which counted fragments before by blending: bits of a float that is never
// denormal, infinite or NaN, so that nothing on its way changes them. The count of a pixel is below
// 2^24, and no storage range holds 2^29 records.
#ifndef STRATA_CURSOR_GLSL
#define STRATA_CURSOR_GLSL

const uint STRATA_NO_SLOT = 0x3e000000u; // beyond every capacity, and so is what follows

float strata_cursor(uint slot) { return uintBitsToFloat(0x40000000u | slot); }
uint strata_cursor_slot(float cursor) { return floatBitsToUint(cursor) & 0x3fffffffu; }

#endif
