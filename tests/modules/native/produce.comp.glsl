// SPDX-License-Identifier: MIT
//
// Writes what the native pass copies: a float of its own for every pixel, and an element of the
// pool, which a native pass fills with one value later.
layout(local_size_x = 64) in;

layout(std430) writeonly buffer Source {
    float source[];
};

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(source.length()))
        source[i] = float(i * 7919u % 4096u) / 4096.0;
}
