// SPDX-License-Identifier: MIT
//
// hiz: why an object was taken to be hidden. It claims that each pixel of first .. last holds a depth in
// front of `nearest`, which is true of all depths to come once it is true: depth only gets nearer.
#ifndef HIZ_CERTIFICATES_GLSL
#define HIZ_CERTIFICATES_GLSL

struct Certificate {
    uvec2 first, last; // pixels
    float nearest;     // of the object, from above
    float farthest;    // of the texels of the pyramid that it was tested against
    uint level;        // of these
    uint reserved;
};

layout(std430) HIZ_CERTIFICATES buffer Certificates { Certificate certificates[]; };

#endif
