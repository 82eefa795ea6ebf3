/* SPDX-License-Identifier: MIT
 *
 * What a technique's own OpenGL calls meet: native passes, the names of objects, functions. A
 * callback ought to leave state as it found it; nothing later depends on whether it did.
 */
#include "gpu/gl/gl_internal.h"

#include <string.h>

/* Whatever draws, dispatches, clears and transfers rely on, but for what each sets for itself. */
void gl_state_set(gl *g) {
    static const GLenum off[] = {GL_DITHER,
                                 GL_RASTERIZER_DISCARD,
                                 GL_DEPTH_CLAMP,
                                 GL_COLOR_LOGIC_OP,
                                 GL_PRIMITIVE_RESTART,
                                 GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                 GL_POLYGON_OFFSET_FILL,
                                 GL_POLYGON_SMOOTH,
                                 GL_SAMPLE_ALPHA_TO_COVERAGE,
                                 GL_SAMPLE_ALPHA_TO_ONE,
                                 GL_SAMPLE_COVERAGE,
                                 GL_SAMPLE_SHADING,
                                 GL_FRAMEBUFFER_SRGB};
    static const GLenum zero[] = {
        GL_PACK_SWAP_BYTES,  GL_PACK_ROW_LENGTH,    GL_PACK_IMAGE_HEIGHT,   GL_PACK_SKIP_PIXELS,
        GL_PACK_SKIP_ROWS,   GL_PACK_SKIP_IMAGES,   GL_UNPACK_SWAP_BYTES,   GL_UNPACK_ROW_LENGTH,
        GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_IMAGES};
    const gl_functions *fn = &g->fn;
    for (size_t i = 0; i < BASE_COUNT(off); i++)
        fn->Disable(off[i]);
    for (GLenum i = 0; i < 8; i++)
        fn->Disable(GL_CLIP_DISTANCE0 + i);
    fn->Enable(GL_SCISSOR_TEST);
    fn->ClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    fn->DepthRangef(0.0f, 1.0f);
    fn->ProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
    fn->FrontFace(GL_CCW);
    fn->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    for (size_t i = 0; i < BASE_COUNT(zero); i++)
        fn->PixelStorei(zero[i], 0);
    fn->PixelStorei(GL_PACK_ALIGNMENT, 1);
    fn->PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    fn->BindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    fn->BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    fn->BindSamplers(0, g->limits[GPU_BINDING_SAMPLED], NULL);
    fn->BindVertexArray(g->vertex_array);
}

/* What a callback finds: ready to draw into the pass's target, inside its scissor. */
static void state_open(gl *g, GLuint target, const gpu_native_pass *pass) {
    static const GLenum off[] = {GL_DEPTH_TEST, GL_STENCIL_TEST, GL_CULL_FACE,
                                 GL_BLEND,      GL_MULTISAMPLE,  GL_SAMPLE_MASK};
    const gl_functions *fn = &g->fn;
    for (size_t i = 0; i < BASE_COUNT(off); i++)
        fn->Disable(off[i]);
    for (GLuint i = 0; i < GPU_GL_MAX_COLORS; i++)
        fn->ColorMaski(i, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    fn->DepthMask(GL_TRUE);
    fn->StencilMask(0xffu);
    fn->BindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
    fn->Viewport(0, 0, (GLsizei)pass->width, (GLsizei)pass->height);
    fn->Scissor((GLint)pass->scissor[0], (GLint)pass->scissor[1], (GLsizei)pass->scissor[2],
                (GLsizei)pass->scissor[3]);
}

/* Barriers on both sides: llvmpipe's scene is flushed, as in gl_record.c, whatever is drawn. */
void gl_native_run(gl *g, const gpu_native_pass *pass) {
    const GLbitfield storage = GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT;
    GLuint target = gl_target_get(g, pass);
    if (!target)
        return;
    if (g->writing_target)
        g->fn.MemoryBarrier(storage);
    g->writing_target = 0;
    if (gl_report(g, g->failure.result, "recording", &g->failure) != STRATA_OK)
        return;
    state_open(g, target, pass);
    pass->call(pass->user, target);
    g->fn.MemoryBarrier(storage);
    gl_report(g, g->failure.result, pass->pass->label, &g->failure);
    gl_state_set(g);
}

uint64_t gl_native_handle(void *self, void *native, gpu_native_kind kind) {
    (void)self;
    if (native && kind == GPU_NATIVE_BUFFER)
        return ((const gl_buffer *)native)->name;
    if (native && kind == GPU_NATIVE_IMAGE)
        return ((const gl_image *)native)->name;
    return 0;
}

void *gl_get_proc(void *self, const char *name) {
    typedef void (*any_function)(void);
    any_function function = eglGetProcAddress(name);
    void *address = NULL;
    (void)self;
    memcpy(&address, &function, sizeof address);
    return address;
}
