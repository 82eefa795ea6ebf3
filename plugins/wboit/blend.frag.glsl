// SPDX-License-Identifier: MIT
//
// wboit, the one geometry pass: the weighted sum of colours and coverages, by additive blending, and what
// the background keeps, by multiplication (McGuire and Bavoil 2013, equations 6 to 10).
//
// WEIGHT is the paper's equation, 0 for weight 1 (Bavoil and Myers's weighted average with equation 5's
// coverage).
#define STRATA_PAYLOAD_WRITE
#include "strata/shading.glsl"
#include "strata/certificate.glsl"
#include "strata/fold.glsl"

layout(early_fragment_tests) in;
layout(location = 0) out vec4 accumulated;
#if STRATA_CHANNELS == 3
layout(location = 1) out vec4 revealed; // of each channel, and the coverage's
#else
layout(location = 1) out float revealed;
#endif
STRATA_PARAMS { float scale; float unused0; float unused1; float unused2; } params;

// Distance from the eye along its axis, in the units that the paper's constants are made for.
float wboit_distance() {
    precise float z = strata_world_to_eye[0].z * strata_in_position.x +
                      strata_world_to_eye[1].z * strata_in_position.y +
                      strata_world_to_eye[2].z * strata_in_position.z + strata_world_to_eye[3].z;
    return abs(z) * params.scale;
}

// The weight without its factor alpha, clamped as in the paper.
float wboit_weight() {
    float z = wboit_distance();
#if WEIGHT == 7
    float a = z / 5.0, b = z / 200.0;
    precise float w = 10.0 / (1e-5 + a * a + b * b * b * b * b * b);
#elif WEIGHT == 8
    float a = z / 10.0, b = z / 200.0;
    precise float w = 10.0 / (1e-5 + a * a * a + b * b * b * b * b * b);
#elif WEIGHT == 9
    float a = z / 200.0;
    precise float w = 0.03 / (1e-5 + a * a * a * a);
#elif WEIGHT == 10 // depth is reversed here: z is the paper's 1 - d
    float a = gl_FragCoord.z;
    precise float w = 3e3 * (a * a * a);
#else
    float w = 1.0;
#endif
    return clamp(w, 1e-2, 3e3);
}

void main() {
    StrataSurface surface;
    if (!strata_surface(surface))
        discard;
    StrataElement element = strata_event(strata_emit(surface));
    precise float weight = wboit_weight();
#if WEIGHT != 0
    weight *= element.color.a;
#endif
    precise vec4 sum = element.color * weight;
    accumulated = sum;
#if STRATA_CHANNELS == 3
    revealed = strata_transmittance4(element);
#else
    revealed = element.transmittance;
#endif
    strata_uncertified(strata_pixel(uvec2(gl_FragCoord.xy)));
}
