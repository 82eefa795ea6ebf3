// SPDX-License-Identifier: MIT
//
// cullcheck, show=pyramid: the blocks as greys, white the nearest depth of the image, dark grey the
// farthest, black where a pixel of the block is empty.
#include "strata/frame.glsl"

layout(std430) readonly buffer Blocks { uint lowest, highest, blocks[]; };
STRATA_PARAMS { uint level, width; } params;
layout(location = 0) out vec4 color;

void main() {
    uvec2 p = uvec2(gl_FragCoord.xy) >> params.level;
    uint depth = blocks[p.y * params.width + p.x];
    float grey = 0.0;
    if (depth > 0u)
        grey = 0.03 + 0.97 * float(depth - lowest) / float(max(highest - lowest, 1u));
    color = vec4(vec3(grey), 1.0);
}
