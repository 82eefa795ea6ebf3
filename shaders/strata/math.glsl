// SPDX-License-Identifier: MIT
//
// Vector algebra in one written order of operations. The built-in dot(), cross(), mix() and matrix
// products may be rearranged by each compiler, and then two backends differ in the last bit.
#ifndef STRATA_MATH_GLSL
#define STRATA_MATH_GLSL

precise float strata_dot(vec2 a, vec2 b) { return a.x * b.x + a.y * b.y; }
precise float strata_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

precise vec3 strata_cross(vec3 a, vec3 b) {
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

precise float strata_mix(float a, float b, float t) { return a + (b - a) * t; }
precise vec2 strata_mix(vec2 a, vec2 b, float t) { return a + (b - a) * t; }
precise vec3 strata_mix(vec3 a, vec3 b, float t) { return a + (b - a) * t; }
precise vec4 strata_mix(vec4 a, vec4 b, float t) { return a + (b - a) * t; }

// Unit length. Zero and non-finite vectors become zero; no square leaves the range of floats, for the
// vector is scaled by a power of two first, which is exact.
precise vec3 strata_unit(vec3 v) {
    float largest = max(abs(v.x), max(abs(v.y), abs(v.z)));
    if (!(largest > 0.0 && largest <= 3.4e38))
        return vec3(0.0);
    uint exponent = min(floatBitsToUint(largest) >> 23, 252u);
    vec3 scaled = v * uintBitsToFloat((253u - exponent) << 23);
    return scaled * (1.0 / sqrt(strata_dot(scaled, scaled)));
}

// strata_unit() of what is known to be at most 1e18 long; what is shorter than 1e-19 becomes zero.
precise vec3 strata_direction(vec3 v) {
    float square = strata_dot(v, v);
    return square > 0.0 ? v * (1.0 / sqrt(square)) : vec3(0.0);
}

#endif
