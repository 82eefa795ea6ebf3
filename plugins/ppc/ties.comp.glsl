// SPDX-License-Identifier: MIT
//
// ppc, one invocation: the indirect dispatch of tied.comp.glsl.
#include "strata/scan.glsl"
#include "classes.glsl"

CLASS_TABLE(restrict)
layout(std430) readonly buffer TiedPool { uint tied_needed; uint tied_capacity; };

void main() {
    if (gl_LocalInvocationID.x == 0u)
        tied_groups = uvec4(strata_groups(min(tied_needed, tied_capacity)), 0u);
}
