// SPDX-License-Identifier: MIT
//
// A fragment of the scene after shading: what shading.glsl fills and the effects' emit() reads.
#ifndef STRATA_SURFACE_GLSL
#define STRATA_SURFACE_GLSL

struct StrataSurface {
    vec3 color;         // radiance that leaves the surface towards the eye, not premultiplied
    float alpha;        // coverage; 1 unless the material blends
    float transmission; // share of the light that enters which is not scattered, 0..1
    vec3 tint;          // share of the light from behind that passes through the surface
    uint primitive;     // number in the whole scene
    uint material;
    vec3 position;      // world
    vec3 normal;        // world, unit, on the side that is seen; zero where there is none
};

#endif
