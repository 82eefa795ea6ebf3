// SPDX-License-Identifier: MIT
//
// fpc: the extent of keys and orders over all elements, by which the sort knows how many digits there
// are to look at.
shared uint group_extent[4];

void begin_extent() {
    if (gl_LocalInvocationID.x < 4u)
        group_extent[gl_LocalInvocationID.x] = 0u;
    barrier();
}

uvec4 extent_of(uvec2 key) { return uvec4(~key.x, key.x, ~key.y, key.y); }

// Called in uniform control flow with the componentwise maximum of what the invocation met.
void end_extent(uvec4 extent) {
    for (int i = 0; i < 4; ++i)
        atomicMax(group_extent[i], extent[i]);
    barrier();
    if (gl_LocalInvocationID.x != 0u)
        return;
    atomicMax(inverse_nearest, group_extent[0]);
    atomicMax(farthest, group_extent[1]);
    atomicMax(inverse_first, group_extent[2]);
    atomicMax(last, group_extent[3]);
}
