/* SPDX-License-Identifier: MIT
 *
 * The OpenGL functions that the GL backend calls, once each: X(PFN suffix, name). From this list
 * come the struct of pointers and the loader (gl_context.c). Everything is OpenGL 4.5 core, except
 * the second list, which 4.6 took over from extensions under the same name without ARB.
 */
#ifndef STRATA_HOST_GPU_GL_FUNCTIONS_H
#define STRATA_HOST_GPU_GL_FUNCTIONS_H

#include <GL/glcorearb.h>

#define GPU_GL_FUNCTIONS(X)                                                                        \
    X(ATTACHSHADER, AttachShader)                                                                  \
    X(BEGINQUERY, BeginQuery)                                                                      \
    X(BINDBUFFER, BindBuffer)                                                                      \
    X(BINDBUFFERRANGE, BindBufferRange)                                                            \
    X(BINDFRAMEBUFFER, BindFramebuffer)                                                            \
    X(BINDIMAGETEXTURE, BindImageTexture)                                                          \
    X(BINDSAMPLERS, BindSamplers)                                                                  \
    X(BINDTEXTUREUNIT, BindTextureUnit)                                                            \
    X(BINDVERTEXARRAY, BindVertexArray)                                                            \
    X(BLENDEQUATIONI, BlendEquationi)                                                              \
    X(BLENDFUNCSEPARATEI, BlendFuncSeparatei)                                                      \
    X(CHECKNAMEDFRAMEBUFFERSTATUS, CheckNamedFramebufferStatus)                                    \
    X(CLEARNAMEDBUFFERSUBDATA, ClearNamedBufferSubData)                                            \
    X(CLEARNAMEDFRAMEBUFFERFI, ClearNamedFramebufferfi)                                            \
    X(CLEARNAMEDFRAMEBUFFERFV, ClearNamedFramebufferfv)                                            \
    X(CLEARNAMEDFRAMEBUFFERUIV, ClearNamedFramebufferuiv)                                          \
    X(CLEARTEXIMAGE, ClearTexImage)                                                                \
    X(CLIPCONTROL, ClipControl)                                                                    \
    X(COLORMASKI, ColorMaski)                                                                      \
    X(COMPILESHADER, CompileShader)                                                                \
    X(COPYNAMEDBUFFERSUBDATA, CopyNamedBufferSubData)                                              \
    X(CREATEBUFFERS, CreateBuffers)                                                                \
    X(CREATEFRAMEBUFFERS, CreateFramebuffers)                                                      \
    X(CREATEPROGRAM, CreateProgram)                                                                \
    X(CREATEQUERIES, CreateQueries)                                                                \
    X(CREATESHADER, CreateShader)                                                                  \
    X(CREATETEXTURES, CreateTextures)                                                              \
    X(CREATEVERTEXARRAYS, CreateVertexArrays)                                                      \
    X(CULLFACE, CullFace)                                                                          \
    X(DEBUGMESSAGECALLBACK, DebugMessageCallback)                                                  \
    X(DEBUGMESSAGECONTROL, DebugMessageControl)                                                    \
    X(DELETEBUFFERS, DeleteBuffers)                                                                \
    X(DELETEFRAMEBUFFERS, DeleteFramebuffers)                                                      \
    X(DELETEPROGRAM, DeleteProgram)                                                                \
    X(DELETEQUERIES, DeleteQueries)                                                                \
    X(DELETESHADER, DeleteShader)                                                                  \
    X(DELETETEXTURES, DeleteTextures)                                                              \
    X(DEPTHFUNC, DepthFunc)                                                                        \
    X(DEPTHMASK, DepthMask)                                                                        \
    X(DEPTHRANGEF, DepthRangef)                                                                    \
    X(DETACHSHADER, DetachShader)                                                                  \
    X(DISABLE, Disable)                                                                            \
    X(DISABLEI, Disablei)                                                                          \
    X(DISPATCHCOMPUTE, DispatchCompute)                                                            \
    X(DISPATCHCOMPUTEINDIRECT, DispatchComputeIndirect)                                            \
    X(DRAWARRAYS, DrawArrays)                                                                      \
    X(ENABLE, Enable)                                                                              \
    X(ENABLEI, Enablei)                                                                            \
    X(ENDQUERY, EndQuery)                                                                          \
    X(FINISH, Finish)                                                                              \
    X(FRONTFACE, FrontFace)                                                                        \
    X(GETERROR, GetError)                                                                          \
    X(GETGRAPHICSRESETSTATUS, GetGraphicsResetStatus)                                              \
    X(GETINTEGER64V, GetInteger64v)                                                                \
    X(GETINTEGERI_V, GetIntegeri_v)                                                                \
    X(GETINTEGERV, GetIntegerv)                                                                    \
    X(GETNAMEDBUFFERSUBDATA, GetNamedBufferSubData)                                                \
    X(GETPROGRAMINFOLOG, GetProgramInfoLog)                                                        \
    X(GETPROGRAMIV, GetProgramiv)                                                                  \
    X(GETQUERYOBJECTUI64V, GetQueryObjectui64v)                                                    \
    X(GETSHADERINFOLOG, GetShaderInfoLog)                                                          \
    X(GETSHADERIV, GetShaderiv)                                                                    \
    X(GETSTRING, GetString)                                                                        \
    X(GETSTRINGI, GetStringi)                                                                      \
    X(GETTEXTURESUBIMAGE, GetTextureSubImage)                                                      \
    X(LINKPROGRAM, LinkProgram)                                                                    \
    X(MAPNAMEDBUFFERRANGE, MapNamedBufferRange)                                                    \
    X(MEMORYBARRIER, MemoryBarrier)                                                                \
    X(NAMEDBUFFERSTORAGE, NamedBufferStorage)                                                      \
    X(NAMEDBUFFERSUBDATA, NamedBufferSubData)                                                      \
    X(NAMEDFRAMEBUFFERDRAWBUFFERS, NamedFramebufferDrawBuffers)                                    \
    X(NAMEDFRAMEBUFFERPARAMETERI, NamedFramebufferParameteri)                                      \
    X(NAMEDFRAMEBUFFERTEXTURE, NamedFramebufferTexture)                                            \
    X(NAMEDFRAMEBUFFERTEXTURELAYER, NamedFramebufferTextureLayer)                                  \
    X(OBJECTLABEL, ObjectLabel)                                                                    \
    X(PIXELSTOREI, PixelStorei)                                                                    \
    X(POLYGONMODE, PolygonMode)                                                                    \
    X(PROVOKINGVERTEX, ProvokingVertex)                                                            \
    X(SAMPLEMASKI, SampleMaski)                                                                    \
    X(SCISSOR, Scissor)                                                                            \
    X(SHADERBINARY, ShaderBinary)                                                                  \
    X(SHADERSOURCE, ShaderSource)                                                                  \
    X(STENCILFUNC, StencilFunc)                                                                    \
    X(STENCILMASK, StencilMask)                                                                    \
    X(STENCILOP, StencilOp)                                                                        \
    X(TEXTUREBUFFER, TextureBuffer)                                                                \
    X(TEXTUREPARAMETERI, TextureParameteri)                                                        \
    X(TEXTURESTORAGE2D, TextureStorage2D)                                                          \
    X(TEXTURESTORAGE2DMULTISAMPLE, TextureStorage2DMultisample)                                    \
    X(TEXTURESTORAGE3D, TextureStorage3D)                                                          \
    X(TEXTURESUBIMAGE2D, TextureSubImage2D)                                                        \
    X(TEXTURESUBIMAGE3D, TextureSubImage3D)                                                        \
    X(USEPROGRAM, UseProgram)                                                                      \
    X(VERTEXARRAYELEMENTBUFFER, VertexArrayElementBuffer)                                          \
    X(VIEWPORT, Viewport)

/* GL_ARB_gl_spirv, GL_ARB_indirect_parameters */
#define GPU_GL_FUNCTIONS_ARB(X)                                                                    \
    X(SPECIALIZESHADER, SpecializeShader)                                                          \
    X(MULTIDRAWELEMENTSINDIRECTCOUNT, MultiDrawElementsIndirectCount)

typedef struct gl_functions {
#define X(suffix, name) PFNGL##suffix##PROC name;
    GPU_GL_FUNCTIONS(X)
    GPU_GL_FUNCTIONS_ARB(X)
#undef X
} gl_functions;

#endif
