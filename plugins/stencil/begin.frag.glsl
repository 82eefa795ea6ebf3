// SPDX-License-Identifier: MIT
//
// stencil, before the samples of a batch are routed: the pass sets the stencil of one of them.
void main() {}
