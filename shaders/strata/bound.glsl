// SPDX-License-Identifier: MIT
//
// The certificate of a pixel: how far the colour that a fold shows may be off the exact fold of all
// fragments, from the errors that the walk carries and from what was dropped. Part of fold.glsl.
//
// Truncation: with T_k what passes the kept fragments, C_D and T_D the element of the dropped ones in
// their order, and B what lies behind, the shown C_k + T_k B differs from C_k + T_k (C_D + T_D B) by
// T_k (C_D - (1 - T_D) B). Of C_D the sum of the dropped colours is an upper bound, and so is the largest
// share q = C / (1 - T) of one times all that they hide: q (1 - T_D).
#ifndef STRATA_BOUND_GLSL
#define STRATA_BOUND_GLSL

#ifdef STRATA_BOUND
layout(rgba32f) writeonly uniform image2D strata_bound; // bound/1; bound by the host

// 1 - exp(-x) for x >= 0, from above: the alternating series at x / 256, then 1 - (1 - h)^2 eight times.
float strata_hidden(float x) {
    float r = min(x, 128.0) * (1.0 / 256.0);
    float h = r * (1.0 - r * (0.5 - r * (1.0 / 6.0))) * STRATA_OUTWARD;
    for (int i = 0; i < 8; ++i)
        h = min(h * (2.0 - h) * STRATA_OUTWARD, 1.0);
    return h;
}

// At most |C - hidden * behind| for a C that is at most share * hidden and at most sum.
float strata_lost_channel(float share, float sum, float hidden, float behind, bool signed_) {
    if (signed_ || behind < 0.0)
        return (share < 1e38 ? min(share * hidden, sum) : sum) + hidden * abs(behind);
    float above = share < 1e38 ? min(max(share - behind, 0.0) * hidden, sum) : sum;
    return max(above, hidden * behind);
}

// Of |C_D - (1 - T_D) B|.
vec4 strata_lost(uint pixel, vec4 behind) {
    uint at = pixel * STRATA_BOUND, flags = strata_loss[at];
    if ((flags & STRATA_LOSS_UNKNOWN) != 0u)
        return vec4(STRATA_INFINITY);
    bool unseen = (flags & STRATA_LOSS_UNSEEN) != 0u;
    bool dark = unseen || (flags & STRATA_LOSS_DARK) != 0u;
    vec3 thick;
    for (uint c = 0u; c < 3u; ++c)
        thick[c] = float(strata_loss[at + 7u + (STRATA_CHANNELS == 3 ? c : 0u)]) *
                   (STRATA_OUTWARD / 16777216.0);
    vec4 hidden = vec4(1.0), lost;
    if (!dark) { // alpha under three transmittances: -ln of their mean is at most the mean of theirs
        float mean = (thick.r + thick.g + thick.b) * (1.0 / 3.0) * STRATA_OUTWARD;
        hidden = vec4(strata_hidden(thick.r), strata_hidden(thick.g), strata_hidden(thick.b),
                      strata_hidden(mean));
    }
    for (uint c = 0u; c < 3u; ++c) {
        float share = uintBitsToFloat(strata_loss[at + 1u + c]);
        float sum = float(strata_loss[at + 4u + c]) * (STRATA_OUTWARD / 65536.0);
        if (unseen)
            share = max(share, STRATA_RADIANCE);
        if (unseen || (flags & STRATA_LOSS_HEAVY) != 0u)
            sum = STRATA_INFINITY;
        lost[c] = strata_lost_channel(share, sum, hidden[c], behind[c],
                                      (flags & STRATA_LOSS_SIGNED) != 0u);
    }
    lost.a = hidden.a * abs(1.0 - behind.a);
    if ((flags & STRATA_LOSS_ODD) != 0u || (unseen && STRATA_RADIANCE > 1e38))
        lost.a = STRATA_INFINITY;
    return lost;
}

vec4 strata_fold_bound(uint pixel, StrataElement walk, vec4 behind) {
    vec4 t = strata_transmittance4(walk);
    StrataElement last = StrataElement(behind, STRATA_TRANSMITTANCE(0.0), vec4(0.0),
                                       STRATA_TRANSMITTANCE(0.0));
    vec4 error = strata_color_error(walk, last, t, strata_fold_end(walk, behind));
    vec4 lost = strata_lost(pixel, behind);
#if STRATA_CHANNELS == 3
    vec4 passes = vec4(walk.transmittance + walk.transmittance_error,
                       t.a * STRATA_OUTWARD + walk.color_error.a);
#else
    vec4 passes = vec4(walk.transmittance + walk.transmittance_error);
#endif
    return error + mix(max(passes, 0.0) * lost, vec4(0.0), equal(lost, vec4(0.0))) * STRATA_OUTWARD;
}
#endif

// Called beside strata_fold_end() with the same walk and background, once a pixel.
void strata_certify(uint pixel, StrataElement walk, vec4 behind) {
#ifdef STRATA_BOUND
    imageStore(strata_bound, ivec2(strata_position(pixel)),
               strata_fold_bound(pixel, walk, behind) * STRATA_OUTWARD);
#endif
}

#endif
