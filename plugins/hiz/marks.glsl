// SPDX-License-Identifier: MIT
//
// hiz: marks of objects, from which the commands of a round are made. Neighbours that are drawn and
// join share a command, within a chunk of CHUNK objects, which is one invocation's.
#ifndef HIZ_MARKS_GLSL
#define HIZ_MARKS_GLSL

const uint DRAWN = 1u;
const uint JOINS = 2u; // can be drawn by the command of the object before it
const uint CHUNK = 32u; // hiz.c has it too

#endif
