// SPDX-License-Identifier: MIT
//
// cullcheck: marks the objects of fragments that pass the final depth, ties included. What the
// rasteriser's interpolation put in front of the object itself no test of its bounds can foresee; of
// objects that are said to be hidden it is marked apart.
#include "object.glsl"

layout(early_fragment_tests) in;
layout(std430) buffer Seen { uint seen[]; };

void main() {
    if (!strata_covered())
        discard;
    uint object = fragment_object(), mark = SEEN;
    if (strata_object_states[object] == STRATA_OCCLUDED && gl_FragCoord.z > nearest_depth(object))
        mark = OVERSHOT;
    if ((seen[object] & mark) == 0u)
        atomicOr(seen[object], mark);
}
