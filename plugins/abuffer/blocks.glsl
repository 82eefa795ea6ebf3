// SPDX-License-Identifier: MIT
//
// How the scans share the pixels of a band out: a work group takes a block, neighbouring invocations
// neighbouring pixels.
#define PIXELS_PER_INVOCATION 64u
#define PIXELS_PER_GROUP (PIXELS_PER_INVOCATION * STRATA_GROUP)

uint block_pixel(uint i) {
    return gl_WorkGroupID.x * PIXELS_PER_GROUP + i * STRATA_GROUP + gl_LocalInvocationID.x;
}
