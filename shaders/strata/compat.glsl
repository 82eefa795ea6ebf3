// SPDX-License-Identifier: MIT
//
// What differs between Vulkan's GLSL and OpenGL's, said once. The host puts `#version 460` and this
// file in front of every source.
#ifndef STRATA_COMPAT_GLSL
#define STRATA_COMPAT_GLSL

// STRATA_PARAMS { uint first; float second; } params;  -- the pass's parameters, std140, <= 128 bytes
#ifdef VULKAN
#define STRATA_PARAMS layout(push_constant, std140) uniform StrataParams
#define STRATA_VERTEX uint(gl_VertexIndex)
#define STRATA_INSTANCE uint(gl_InstanceIndex)
#else
#define STRATA_PARAMS layout(std140) uniform StrataParams
#define STRATA_VERTEX uint(gl_VertexID)
#define STRATA_INSTANCE uint(gl_BaseInstance + gl_InstanceID)
#endif

#endif
