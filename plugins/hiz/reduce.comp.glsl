// SPDX-License-Identifier: MIT
//
// hiz: one level of the pyramid from the one before it, one invocation a texel.
#define HIZ_BUILD
#include "strata/scan.glsl"
#include "pyramid.glsl"

STRATA_PARAMS {
    int level; // to write, 1 ..
    uint from, to;
} params;

void main() {
    ivec2 size = level_size(params.level);
    uint item = strata_item();
    if (item >= uint(size.x * size.y))
        return;
    ivec2 p = 2 * ivec2(item % uint(size.x), item / uint(size.x));
    int below = params.level - 1;
    float a = depth_at(below, params.from, p), b = depth_at(below, params.from, p + ivec2(1, 0)),
          c = depth_at(below, params.from, p + ivec2(0, 1)),
          d = depth_at(below, params.from, p + ivec2(1, 1));
    pyramid[params.to + item] = min(min(a, b), min(c, d));
}
