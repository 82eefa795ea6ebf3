// SPDX-License-Identifier: MIT
//
// A pixel as the weighted mean of the sub-pixels around its centre, one invocation a pixel; run by
// plugins/shared/filtering.c.
// The sum runs row by row from the lowest, whatever the device; weights beyond the image do not count.
// With FILTER_BOUND the sub-pixels are bounds, and the rounding of the colours' mean joins them.
#include "strata/frame.glsl"
#include "strata/scan.glsl"

layout(rgba32f) uniform readonly image2D sub_pixels;
layout(rgba32f) uniform writeonly image2D pixels;
layout(std430) readonly buffer Weights { float weights[]; }; // along one axis, all above 0
STRATA_PARAMS {
    int side;  // sub-pixels along one side of a pixel
    int first; // of the weights, counted from the pixel's lowest sub-pixel
    int count; // of weights
    float rounding; // of a mean, relative to that of the magnitudes, at most
} params;
#ifdef FILTER_BOUND
layout(rgba32f) uniform readonly image2D colors;
#endif

void main() {
    uvec2 size = strata_frame_size.xy / uint(params.side);
    uint item = strata_item();
    if (item >= size.x * size.y)
        return;
    ivec2 pixel = ivec2(item % size.x, item / size.x);
    ivec2 origin = pixel * params.side + params.first;
    ivec2 begin = max(-origin, ivec2(0));
    ivec2 end = min(ivec2(strata_frame_size.xy) - origin, ivec2(params.count));

    precise vec4 sum = vec4(0.0);
    precise float total = 0.0;
#ifdef FILTER_BOUND
    precise vec4 magnitude = vec4(0.0);
#endif
    vec4 low = imageLoad(sub_pixels, origin + begin), high = low;
    for (int y = begin.y; y < end.y; ++y)
        for (int x = begin.x; x < end.x; ++x) {
            vec4 value = imageLoad(sub_pixels, origin + ivec2(x, y));
            precise float weight = weights[y] * weights[x];
            sum += weight * value;
            total += weight;
            low = min(low, value);
            high = max(high, value);
#ifdef FILTER_BOUND
            magnitude += weight * abs(imageLoad(colors, origin + ivec2(x, y)));
#endif
        }
    // A mean lies between its terms; rounding must not move it out, least of all where all are equal.
    precise vec4 mean = sum / total;
    mean = clamp(mean, low, high);
#ifdef FILTER_BOUND
    mean = (mean + params.rounding * (magnitude / total)) * (1.0 + params.rounding);
#endif
    imageStore(pixels, pixel, mean);
}
