// SPDX-License-Identifier: MIT
//
// Running error analysis, part of the generated effect header where a certificate is asked for: by how
// much an element may be off its exact value, given the precision of its payload, and how such errors
// compose. Everything is rounded outward.
//
// One operation in float gives its exact result times 1 + d, |d| <= 2^-23 however the device rounds, and
// may lose what underflows. The bounds are evaluated in float themselves, by sums and products of
// numbers that are not negative, at most sixteen in a row; STRATA_OUTWARD makes up for that.
#ifndef STRATA_ERROR_GLSL
#define STRATA_ERROR_GLSL

const float STRATA_ROUNDING = 1.0 / 8388608.0;        // 2^-23
const float STRATA_OUTWARD = 1.0 + 1.0 / 524288.0;    // 1 + 2^-19
const float STRATA_UNDERFLOW = 1e-30;                 // more than a few 2^-126
#define STRATA_INFINITY uintBitsToFloat(0x7f800000u)

// Half a quantum of a channel as it was decoded: how far what was stored may be off.
float strata_quantum_half(float value) { return max(abs(value) * 4.8877e-4, 2.99e-8); }
float strata_quantum_unorm8(float value) { return 0.0019628; }
// Whether a value is within what its encoding rounds instead of cutting off.
bool strata_fits_half(float value) { return abs(value) < 65520.0; }
bool strata_fits_unorm8(float value) { return value >= 0.0 && value <= 1.000001; }

// What is known of an event that is affine in its payload: its terms, channel by channel.
struct StrataSpread {
    vec4 color_error, color_size, color_roundings, color_least;
    STRATA_TRANSMITTANCE error, size, roundings;
    bool covers;
};

// Beside an element: what its exact colour is not below, and whether its alpha is 1 - T (one
// transmittance alone has an alpha that this says something about).
struct StrataWithin {
    vec4 least;
    bool covers;
};

bool strata_opposite(float alpha, float transmittance) { return alpha == -transmittance; }
bool strata_opposite(float alpha, vec3 transmittance) { return true; }

// Roundings that a term may bring: one to add it, two more for a factor that is not 1 or -1.
float strata_roundings(float factor) {
    return factor == 0.0 ? 0.0 : abs(factor) == 1.0 ? 1.0 : 3.0;
}
vec3 strata_roundings(vec3 f) {
    return vec3(strata_roundings(f.x), strata_roundings(f.y), strata_roundings(f.z));
}
vec4 strata_roundings(vec4 f) { return vec4(strata_roundings(f.xyz), strata_roundings(f.w)); }

// From the event of a payload of zeros.
StrataSpread strata_spread_begin(StrataEvent zero) {
    return StrataSpread(vec4(0.0), abs(zero.color), min(strata_roundings(zero.color), 1.0),
                        zero.color, STRATA_TRANSMITTANCE(0.0), abs(zero.transmittance),
                        min(strata_roundings(zero.transmittance), 1.0),
                        strata_opposite(zero.color.a - 1.0, zero.transmittance));
}

// Adds a channel: `one` is the event of a payload with 1 in it and zeros elsewhere.
void strata_spread_add(inout StrataSpread s, StrataEvent zero, StrataEvent one, float value,
                       float quantum) {
    vec4 factor = one.color - zero.color;
    STRATA_TRANSMITTANCE through = one.transmittance - zero.transmittance;
    float low = value - quantum, high = value + quantum; // rounding keeps the sign, that of 0 too
    if (floatBitsToUint(value) >> 31 == 0u)
        low = max(low, 0.0);
    s.color_error += abs(factor) * quantum;
    s.color_size += abs(factor) * (abs(value) + quantum);
    s.color_roundings += strata_roundings(factor);
    s.color_least += factor * mix(vec4(high), vec4(low), greaterThan(factor, vec4(0.0)));
    s.error += abs(through) * quantum;
    s.size += abs(through) * (abs(value) + quantum);
    s.roundings += strata_roundings(through);
    s.covers = s.covers && strata_opposite(factor.a, through);
}

// The event with its errors. The first term is not added to anything:
// a channel that is copied is exact.
StrataElement strata_spread_end(StrataSpread s, StrataEvent event, out StrataWithin within) {
    vec4 rounded = max(s.color_roundings - 1.0, 0.0) * (s.color_size + STRATA_UNDERFLOW);
    STRATA_TRANSMITTANCE lost = max(s.roundings - 1.0, 0.0) * (s.size + STRATA_UNDERFLOW);
    within = StrataWithin(s.color_least - 2.0 * STRATA_ROUNDING * rounded, s.covers);
    return StrataElement(event.color, event.transmittance,
                         (s.color_error + STRATA_ROUNDING * rounded) * STRATA_OUTWARD,
                         (s.error + STRATA_ROUNDING * lost) * STRATA_OUTWARD);
}

// An event of which nothing is known: it is taken at its word, or not at all.
StrataElement strata_spread_opaque(StrataEvent event, bool exact, out StrataWithin within) {
    float error = exact ? 0.0 : STRATA_INFINITY;
    within = StrataWithin(exact ? event.color : vec4(-STRATA_INFINITY), false);
    return StrataElement(event.color, event.transmittance, vec4(error),
                         STRATA_TRANSMITTANCE(error));
}

// Error of color = a.color + T a.. b.color, as strata_fold_step computes it. Alpha under three
// transmittances composes by itself, R = 1 - (1 - R1) (1 - R2): an error of R1 enters twice and nearly
// cancels.
vec4 strata_color_error(StrataElement a, StrataElement b, vec4 t, vec4 color) {
    vec4 size = abs(b.color) + b.color_error;
#if STRATA_CHANNELS == 3
    vec4 through_error = vec4(a.transmittance_error, 0.0), roundings = vec4(1.0, 1.0, 1.0, 2.0);
#else
    vec4 through_error = vec4(a.transmittance_error), roundings = vec4(1.0);
#endif
    vec4 error = a.color_error;
#if STRATA_CHANNELS == 3
    error.a *= min(abs(1.0 - b.color.a) + b.color_error.a, 1.0);
#endif
    error += abs(t) * b.color_error + through_error * size;
    error += STRATA_ROUNDING * (roundings * abs(t) * size + abs(color)) + STRATA_UNDERFLOW;
    return error * STRATA_OUTWARD;
}

// Exact transmittances are at most 1, so that errors add up and do not multiply.
STRATA_TRANSMITTANCE strata_transmittance_error(StrataElement a, StrataElement b) {
    STRATA_TRANSMITTANCE size = min(abs(b.transmittance) + b.transmittance_error, 1.0);
    return (abs(a.transmittance) * (b.transmittance_error + STRATA_ROUNDING * size) +
            a.transmittance_error * size + STRATA_UNDERFLOW) * STRATA_OUTWARD;
}

#endif
