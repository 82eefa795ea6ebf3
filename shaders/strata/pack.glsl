// SPDX-License-Identifier: MIT
//
// Payload channels in 16 and 8 bits, the same on every device: rounding is written out, not left to the
// driver. Decoding is exact (half) or one correctly rounded product (unorm8).
#ifndef STRATA_PACK_GLSL
#define STRATA_PACK_GLSL

// Round to nearest even; beyond the range the largest finite half. NaN is not expected.
uint strata_half(float value) {
    uint bits = floatBitsToUint(value);
    uint sign = bits >> 16 & 0x8000u;
    bits &= 0x7fffffffu;
    if (bits >= 0x477ff000u) // rounds to 65536 or more
        return sign | 0x7bffu;
    if (bits < 0x38800000u) { // subnormal: multiples of 2^-24; the sum rounds to even
        precise float shifted = uintBitsToFloat(bits) + 0.5;
        return sign | floatBitsToUint(shifted) - 0x3f000000u;
    }
    return sign | (bits + 0xfffu + (bits >> 13 & 1u)) - 0x38000000u >> 13;
}

float strata_from_half(uint half_bits) {
    uint sign = (half_bits & 0x8000u) << 16, exponent = half_bits >> 10 & 31u,
         mantissa = half_bits & 0x3ffu;
    if (exponent == 0u) {
        precise float tiny = float(mantissa) * (1.0 / 16777216.0);
        return uintBitsToFloat(sign | floatBitsToUint(tiny));
    }
    return uintBitsToFloat(sign | exponent + 112u << 23 | mantissa << 13);
}

uint strata_unorm8(float value) {
    precise float scaled = clamp(value, 0.0, 1.0) * 255.0 + 0.5;
    return uint(scaled);
}

float strata_from_unorm8(uint bits) {
    precise float value = float(bits) * (1.0 / 255.0);
    return value;
}

#endif
