// SPDX-License-Identifier: MIT
//
// The layers of one batch: each holds the fragment that was routed to it in each pixel, as its
// primitive's number + 1; 0 where it is empty. A channel is a layer, so that few texels are read.
#define BATCH 8u

uniform usampler2D layers0, layers4;

uint[BATCH] layers_at(uvec2 position) {
    uvec4 a = texelFetch(layers0, ivec2(position), 0), b = texelFetch(layers4, ivec2(position), 0);
    return uint[BATCH](a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
}
