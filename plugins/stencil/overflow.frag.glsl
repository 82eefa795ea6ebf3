// SPDX-License-Identifier: MIT
//
// stencil, after the last layer, over the pixels whose stencil has come down to 0: more fragments were
// routed there than there are layers.
layout(early_fragment_tests) in;
layout(std430) buffer Routing { uint misrouted; uint overflowed; };

void main() { atomicAdd(overflowed, 1u); }
