// SPDX-License-Identifier: MIT
//
// A section of a fragment shader that the fragments of a pixel go through one after the other, in
// primitive order (the fragment interlock): what one leaves in storage the next finds.
//     layout(std430) STRATA_INTERLOCKED buffer State { uint state[]; };
// and in main(), once, outside of any control flow, behind what discards and before any return:
//     STRATA_INTERLOCK_BEGIN
//     ..
//     STRATA_INTERLOCK_END
// A program asks for it with STRATA_INTERLOCK, where the fact `selftest.interlock` is 1. Without, for devices
// that keep such accesses in order by themselves (`selftest.ordered_rmw`), a section is plain code.
#ifndef STRATA_INTERLOCK_GLSL
#define STRATA_INTERLOCK_GLSL

#ifdef STRATA_INTERLOCK
#define STRATA_INTERLOCKED coherent
#else
#define STRATA_INTERLOCKED
#endif

#if defined(STRATA_INTERLOCK) && defined(STRATA_HAS_INTERLOCK) // the host's word: the extension is there
#extension GL_ARB_fragment_shader_interlock : require
layout(pixel_interlock_ordered) in;
#define STRATA_INTERLOCK_BEGIN beginInvocationInterlockARB();
#define STRATA_INTERLOCK_END endInvocationInterlockARB();
#else
#define STRATA_INTERLOCK_BEGIN
#define STRATA_INTERLOCK_END
#endif

#endif
