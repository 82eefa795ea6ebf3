// SPDX-License-Identifier: MIT
//
// The layers of one batch: each holds the fragment that was routed to it in each pixel, as its
// primitive's number + 1; 0 where it is empty. A layer is a sample, or a channel of a plain image, so
// that few texels are read. Samples hold the number's four bytes: integers are the least multisampled.
#ifdef SAMPLES
#define BATCH SAMPLES

uniform sampler2DMS samples;

uint[BATCH] layers_at(uvec2 position) {
    uint layers[BATCH];
    for (uint i = 0u; i < BATCH; ++i)
        layers[i] = packUnorm4x8(texelFetch(samples, ivec2(position), int(i)));
    return layers;
}
#else
#define BATCH 8u

uniform usampler2D layers0, layers4;

uint[BATCH] layers_at(uvec2 position) {
    uvec4 a = texelFetch(layers0, ivec2(position), 0), b = texelFetch(layers4, ivec2(position), 0);
    return uint[BATCH](a.x, a.y, a.z, a.w, b.x, b.y, b.z, b.w);
}
#endif
