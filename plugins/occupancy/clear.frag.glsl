// SPDX-License-Identifier: MIT
//
// occupancy, before pass 3: the attachment's load clears all words, this the first of them once more.

layout(location = 0) out uint word;

void main() { word = 0u; }
