// SPDX-License-Identifier: MIT
//
// What differs between Vulkan's GLSL and OpenGL's, and between devices, said once. The host puts
// `#version 460` and this file in front of every source.
#ifndef STRATA_COMPAT_GLSL
#define STRATA_COMPAT_GLSL

// Two words that are read or written at once, where the device has 64-bit integers.
#ifdef STRATA_INT64
#extension GL_ARB_gpu_shader_int64 : require
#define STRATA_PAIR uint64_t
#define STRATA_TO_PAIR(words) packUint2x32(words)
#define STRATA_FROM_PAIR(pair) unpackUint2x32(pair)
#else
#define STRATA_PAIR uvec2
#define STRATA_TO_PAIR(words) (words)
#define STRATA_FROM_PAIR(pair) (pair)
#endif

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
