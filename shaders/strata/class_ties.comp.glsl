// SPDX-License-Identifier: MIT
//
// Classes, one invocation: the indirect dispatch of class_tied.comp.glsl.
#include "strata/scan.glsl"
#include "strata/classes.glsl"

CLASS_TABLE(restrict)
layout(std430) readonly buffer TiedPool { uint tied_needed; uint tied_capacity; };

void main() {
    if (gl_LocalInvocationID.x == 0u)
        tied_groups = uvec4(strata_groups(min(tied_needed, tied_capacity)), 0u);
}
