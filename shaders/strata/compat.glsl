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

// Buffers that are only read: STRATA_READ(Name, TYPE) declares one of that type by index, STRATA_AT_TYPE(Name, i)
// reads it. Software rasterisers gather texels as vectors, and take words of storage one by one.
#ifdef STRATA_TEXELS
#define STRATA_READ(Name, TYPE) uniform usamplerBuffer Name;
#define STRATA_AT_UINT(Name, i) texelFetch(Name, int(i)).x
#define STRATA_AT_UVEC2(Name, i)                                                                   \
    uvec2(STRATA_AT_UINT(Name, 2u * (i)), STRATA_AT_UINT(Name, 2u * (i) + 1u))
#define STRATA_AT_FLOAT(Name, i) uintBitsToFloat(STRATA_AT_UINT(Name, i))
#define STRATA_AT_VEC2(Name, i) uintBitsToFloat(STRATA_AT_UVEC2(Name, i))
#define STRATA_AT_VEC4(Name, i)                                                                    \
    vec4(STRATA_AT_VEC2(Name, 2u * (i)), STRATA_AT_VEC2(Name, 2u * (i) + 1u))
#else
#define STRATA_READ(Name, TYPE) layout(std430) readonly buffer Name { TYPE Name##_at[]; };
#define STRATA_AT_UINT(Name, i) Name##_at[i]
#define STRATA_AT_UVEC2(Name, i) Name##_at[i]
#define STRATA_AT_FLOAT(Name, i) Name##_at[i]
#define STRATA_AT_VEC2(Name, i) Name##_at[i]
#define STRATA_AT_VEC4(Name, i) Name##_at[i]
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
