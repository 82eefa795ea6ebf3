// SPDX-License-Identifier: MIT
//
// For techniques that keep the nearest fragments only: every other one is handed to one of
// strata_lose(), strata_lose_unseen() (never shaded) and strata_uncertified() (a fragment that may lie
// in front of a kept one, or of which nothing is known). Called unconditionally; without a
// certificate they cost nothing. bound.glsl reads what they sum up.
#ifndef STRATA_LOSS_GLSL
#define STRATA_LOSS_GLSL

#include "strata/certificate.glsl"
#include "strata/effects.glsl"

#ifdef STRATA_BOUND
// -ln (1 - h) for h in [0, 1): 1 - h = m 2^-e, m in (1/2, 1], z = (1 - m) / (1 + m); e ln 2 + 2 atanh z,
// the rest of its series as a geometric one.
float strata_thickness(float h) {
    float z = h / (2.0 - h), halvings = 0.0;
    if (h > 0.5) {
        uint bits = floatBitsToUint(1.0 - h);
        float m = uintBitsToFloat(bits & 0x7fffffu | 0x3f000000u);
        halvings = float(126u - (bits >> 23));
        z = (1.0 - m) / (1.0 + m);
    }
    float q = z * z;
    float series = 1.0 + q * (1.0 / 3.0 + q * (0.2 + q / (7.0 * (1.0 - q))));
    return (halvings * 0.69314724 + 2.0 * z * series) * STRATA_OUTWARD;
}

// Adds to a word; `full` where it has no room.
void strata_loss_add(uint word, float value, uint full, inout uint flags) {
    uint units = uint(min(ceil(value), 4.29e9));
    if (units > 0u && (value > 4.29e9 || atomicAdd(strata_loss[word], units) > ~units))
        flags |= full;
}

// One of r, g and b: how much is hidden lies between `low` and `high`.
void strata_lose_channel(uint at, uint channel, float size, float low, inout uint flags) {
    float share = size > 0.0 ? low > 0.0 ? min(size / low * STRATA_OUTWARD, 3e38) : 3e38 : 0.0;
    if (size > 0.0)
        atomicMax(strata_loss[at + 1u + channel], floatBitsToUint(share));
    strata_loss_add(at + 4u + channel, size * 65536.0 * STRATA_OUTWARD, STRATA_LOSS_HEAVY, flags);
}

void strata_lose_through(uint word, float high, inout uint flags) {
    if (high > 0.9999999)
        flags |= STRATA_LOSS_DARK;
    else
        strata_loss_add(word, strata_thickness(high) * 16777216.0, STRATA_LOSS_DARK, flags);
}
#endif

#ifdef STRATA_BOUND
void strata_lose_within(uint pixel, StrataElement e, StrataWithin within) {
    uint at = pixel * STRATA_BOUND, flags = 0u;
    vec4 size = max(e.color + e.color_error, -within.least) * STRATA_OUTWARD;
    // Exact transmittances are at most 1, whatever the precision of the payload.
    vec3 low = max(vec3(1.0 - (e.transmittance + e.transmittance_error)), 0.0),
         high = min(vec3(1.0 - (e.transmittance - e.transmittance_error)), 1.0);
    vec3 known = vec3(e.transmittance);
#if STRATA_CHANNELS == 1
    if (within.covers) { // alpha says it better where little is hidden
        low = vec3(max(within.least.a, low.r));
        high = vec3(min(size.a, high.r));
    }
#endif
    if (!(all(lessThan(size, vec4(3e38))) && all(greaterThanEqual(known, vec3(0.0))) &&
          all(lessThanEqual(known, vec3(1.0)))))
        flags |= STRATA_LOSS_UNKNOWN;
    if (!all(greaterThanEqual(within.least.rgb, vec3(0.0))))
        flags |= STRATA_LOSS_SIGNED;
#if STRATA_CHANNELS == 3
    if (!(within.least.a > -0.001 && size.a < 1.001))
        flags |= STRATA_LOSS_ODD;
    // An alpha that is more than the mean of what is hidden is hidden, too: see bound.glsl.
    float more = max(size.a - (high.r + high.g + high.b) * 0.3333333, 0.0) * STRATA_OUTWARD;
    for (uint c = 0u; c < 3u; ++c)
        strata_lose_through(at + 7u + c, high[c] + more, flags);
#else
    if (!within.covers)
        flags |= STRATA_LOSS_ODD;
    strata_lose_through(at + 7u, high.r, flags);
#endif
    for (uint c = 0u; c < 3u; ++c)
        strata_lose_channel(at, c, size[c], low[c], flags);
    if (flags != 0u)
        atomicOr(strata_loss[at], flags);
}
#endif

// A fragment that was dropped, behind all that are kept.
void strata_lose(uint pixel, StrataPayload payload) {
#ifdef STRATA_BOUND
    StrataWithin within;
    StrataElement element = strata_event_within(payload, within);
    strata_lose_within(pixel, element, within);
#endif
}

// Several of them, folded already.
void strata_lose_element(uint pixel, StrataElement element) {
#ifdef STRATA_BOUND
    strata_lose_within(pixel, element,
                       StrataWithin(element.color - element.color_error, STRATA_COVERS));
#endif
}

#endif
