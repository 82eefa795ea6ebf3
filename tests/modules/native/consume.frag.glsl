// SPDX-License-Identifier: MIT
//
// Shows what the native pass left: a pixel's float, the pool's constant, and where it is.
STRATA_PARAMS {
    uint width;
} params;

layout(std430) readonly buffer Target {
    float target[];
};
layout(std430) readonly buffer PoolValues {
    uint pool_values[];
};

layout(location = 0) out vec4 color;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    uint i = at.y * params.width + at.x;
    color = vec4(target[i], float(pool_values[i % 64u]), float(i), 1.0);
}
