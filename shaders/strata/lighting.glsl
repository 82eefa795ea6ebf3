// SPDX-License-Identifier: MIT
//
// glTF's metallic-roughness model: GGX (Walter 2007) with height-correlated Smith shadowing and
// Schlick's Fresnel, punctual lights, and ambient light that grows with height, its reflection through
// the fit of the environment BRDF by Lazarov (2013) and Karis (2014). Part of shading.glsl.
#ifndef STRATA_LIGHTING_GLSL
#define STRATA_LIGHTING_GLSL

#include "strata/lights.glsl"
#include "strata/math.glsl"

const float STRATA_PI = 3.14159265358979;
// Ambient radiance: the mean of all directions, and what it gains straight up and loses straight down.
const vec3 STRATA_AMBIENT = vec3(0.36, 0.375, 0.4);
const vec3 STRATA_AMBIENT_GAIN = vec3(0.14, 0.175, 0.22);

const float STRATA_SMALLEST_ROUGHNESS = 0.045; // its fourth power is still above a float's rounding

#ifdef STRATA_HAS_TEXTURES
// Turns a normal from a texture into the world. The axes are tangent, bitangent (against v, since
// textures are stored from the top) and normal; tangents as given, else the gradients of the
// coordinates across the screen.
precise vec3 strata_bend(StrataTexture t, StrataSlopes slopes, vec3 normal, vec3 bump) {
#ifdef STRATA_HAS_TANGENTS
    if (strata_is(STRATA_RECORD_TANGENTS)) {
        vec3 tangent = strata_unit(strata_in_tangent.xyz);
        vec3 bitangent = strata_cross(normal, tangent) * strata_in_tangent.w;
        return tangent * bump.x + bitangent * bump.y + normal * bump.z;
    }
#endif
    bool second = (t.flags & 1u) != 0u;
    vec2 uv_dx = strata_transform(t, second ? slopes.uv.dx.zw : slopes.uv.dx.xy);
    vec2 uv_dy = strata_transform(t, second ? slopes.uv.dy.zw : slopes.uv.dy.xy);
    vec3 across = strata_cross(slopes.dy, normal), along = strata_cross(normal, slopes.dx);
    float side = strata_dot(strata_cross(slopes.dx, slopes.dy), normal) < 0.0 ? -1.0 : 1.0;
    vec3 tangent = strata_unit(across * uv_dx.x + along * uv_dy.x) * side;
    vec3 bitangent = strata_unit(across * uv_dx.y + along * uv_dy.y) * -side;
    return tangent * bump.x + bitangent * bump.y + normal * bump.z;
}
#endif

precise vec3 strata_towards_eye() {
    vec4 eye = strata_frame_eye();
    return eye.w != 0.0 ? strata_unit(eye.xyz - strata_in_position) : eye.xyz;
}

// On the side that is seen. Towards the eye where interpolated normals cancel out.
precise vec3 strata_shading_normal(StrataSlopes slopes, vec3 view) {
    vec3 normal = strata_direction(strata_in_normal);
    if (normal == vec3(0.0))
        return view;
#ifdef STRATA_HAS_TEXTURES
    uint map = strata_in_textures.z;
    if (map != STRATA_NO_INDEX) {
        vec3 bump = strata_sample(map, STRATA_LINEAR, slopes.uv).xyz * 2.0 - 1.0;
        bump.xy *= uintBitsToFloat(strata_in_more_textures.z);
        vec3 bent = strata_unit(strata_bend(strata_texture_at(map), slopes, normal, bump));
        normal = bent == vec3(0.0) ? normal : bent;
    }
#endif
    return strata_front() ? normal : -normal;
}

// What light meets at a fragment.
struct StrataReflector {
    vec3 normal, view;
    vec3 diffuse; // albedo of what scatters below the surface
    vec3 f0;
    float alpha;  // roughness squared
    float n_v;
};

precise vec3 strata_schlick(vec3 f0, float cosine) {
    float rest = 1.0 - cosine, square = rest * rest;
    return f0 + (1.0 - f0) * (square * square * rest);
}

// BRDF times the cosine at the surface, for light from `light` (unit).
precise vec3 strata_reflect(StrataReflector r, vec3 light) {
    float n_l = strata_dot(r.normal, light);
    if (!(n_l > 0.0))
        return vec3(0.0);
    vec3 halfway = strata_direction(light + r.view);
    float n_h = clamp(strata_dot(r.normal, halfway), 0.0, 1.0);
    float v_h = clamp(strata_dot(r.view, halfway), 0.0, 1.0);
    float a2 = r.alpha * r.alpha;
    float spread = n_h * n_h * (a2 - 1.0) + 1.0;
    float masked = n_l * sqrt(r.n_v * r.n_v * (1.0 - a2) + a2) +
                   r.n_v * sqrt(n_l * n_l * (1.0 - a2) + a2);
    float d_v = a2 * (0.5 / STRATA_PI) / (spread * spread * masked);
    vec3 f = strata_schlick(r.f0, v_h);
    return ((1.0 - f) * r.diffuse * (1.0 / STRATA_PI) + f * d_v) * n_l;
}

// Direction to a light and what arrives from it (KHR_lights_punctual).
precise vec3 strata_arriving(StrataLight light, out vec3 direction) {
    direction = -light.direction.xyz;
#ifdef STRATA_HAS_LOCAL_LIGHTS
    if (light.position.w == 0.0)
        return light.color.rgb;
    vec3 away = light.position.xyz - strata_in_position;
    direction = strata_unit(away);
    float square = max(strata_dot(away, away), 1e-12);
    float power = 1.0 / square;
    if (light.direction.w > 0.0) {
        float share = square / (light.direction.w * light.direction.w);
        power *= clamp(1.0 - share * share, 0.0, 1.0);
    }
    if (light.position.w == 2.0) {
        float cosine = -strata_dot(light.direction.xyz, direction);
        float t = clamp((cosine - light.cone.y) / max(light.cone.x - light.cone.y, 1e-4), 0.0, 1.0);
        power *= t * t;
    }
    return light.color.rgb * power;
#else
    return light.color.rgb;
#endif
}

// Ambient radiance from around a direction of this height (-1..1): its lobe keeps `share` of what grows
// with height.
precise vec3 strata_ambient_light(float height, float share) {
    return STRATA_AMBIENT + STRATA_AMBIENT_GAIN * (height * share);
}

// Share of uniform light from all sides that is mirrored: f0 * x + y.
precise vec2 strata_environment_brdf(float roughness, float n_v) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    return vec2(-1.04, 1.04) * a + r.zw;
}

precise vec3 strata_ambient_reflection(StrataReflector r, float roughness) {
    float mirrored = 2.0 * strata_dot(r.normal, r.view) * r.normal.y - r.view.y; // its height
    vec2 brdf = strata_environment_brdf(roughness, r.n_v);
    vec3 specular = r.f0 * brdf.x + brdf.y;
    return r.diffuse * (1.0 - specular) * strata_ambient_light(r.normal.y, 2.0 / 3.0) +
           specular * strata_ambient_light(mirrored, strata_mix(2.0 / 3.0, 1.0, 1.0 - r.alpha));
}

// Fills colour (without emission), transmission and tint from base colour and surface.normal.
void strata_shade(vec3 base, StrataUv uv, vec3 view, inout StrataSurface surface) {
    vec4 rough = strata_textured(strata_in_textures.y, STRATA_LINEAR, uv);
    float metallic = clamp(strata_in_reflection.x * rough.b, 0.0, 1.0);
    float roughness = clamp(strata_in_reflection.y * rough.g, STRATA_SMALLEST_ROUGHNESS, 1.0);
    float occlusion = 1.0;
    if (strata_in_textures.w != STRATA_NO_INDEX)
        occlusion += uintBitsToFloat(strata_in_more_textures.w) *
                     (strata_textured(strata_in_textures.w, STRATA_LINEAR, uv).r - 1.0);
    vec3 dielectric = vec3(strata_in_reflection.z);
    precise StrataReflector r;
    r.normal = surface.normal;
    r.view = view;
    r.n_v = clamp(abs(strata_dot(r.normal, r.view)), 1e-4, 1.0);
    r.alpha = roughness * roughness;
    r.f0 = strata_mix(dielectric, base, metallic);
    r.diffuse = base * (1.0 - metallic);
#ifdef STRATA_HAS_TRANSMISSION
    float enters = clamp(strata_in_reflection.w *
                             strata_textured(strata_in_more_textures.y, STRATA_LINEAR, uv).r,
                         0.0, 1.0);
    precise float share = enters * (1.0 - metallic);
    precise vec3 tint = clamp(base, 0.0, 1.0) * share * (1.0 - strata_schlick(dielectric, r.n_v));
    surface.transmission = share;
    surface.tint = tint;
    r.diffuse *= 1.0 - enters;
#endif
    precise vec3 color = strata_ambient_reflection(r, roughness) * occlusion;
    for (int i = 0; i < STRATA_LIGHT_COUNT; ++i) {
        vec3 direction;
        vec3 arriving = strata_arriving(strata_light_at(i), direction);
        color += strata_reflect(r, direction) * arriving;
    }
    surface.color = color;
}

#endif
