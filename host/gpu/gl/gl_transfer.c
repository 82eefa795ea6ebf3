/* SPDX-License-Identifier: MIT
 *
 * Host access to buffers and images of the OpenGL backend; the device is idle meanwhile. Texels are
 * tightly packed, row 0 is the lowest, on both sides.
 */
#include "gpu/gl/gl_internal.h"

#define TRANSFER_STEP (1u << 30) /* bytes of one call: OpenGL counts a read's size in 31 bits */

strata_result gl_buffer_read(void *self, void *native, uint64_t offset, uint64_t size, void *data,
                             base_error *err) {
    gl *g = self;
    const gl_buffer *buffer = native;
    strata_result result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    g->fn.GetNamedBufferSubData(buffer->name, (GLintptr)offset, (GLsizeiptr)size, data);
    result = gl_report(g, STRATA_OK, "reading a buffer", err);
    gl_leave(g);
    return result;
}

strata_result gl_buffer_write(void *self, void *native, uint64_t offset, uint64_t size,
                              const void *data, base_error *err) {
    gl *g = self;
    const gl_buffer *buffer = native;
    strata_result result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    g->fn.NamedBufferSubData(buffer->name, (GLintptr)offset, (GLsizeiptr)size, data);
    result = gl_report(g, STRATA_OK, "writing a buffer", err);
    gl_leave(g);
    return result;
}

strata_result gl_image_read(void *self, void *native, uint32_t layer, void *texels, size_t size,
                            base_error *err) {
    gl *g = self;
    const gl_image *image = native;
    const gl_format *format = image->format;
    size_t row = (size_t)image->width * format->texel;
    if (size / row < image->height)
        return base_fail(err, STRATA_ERROR_INTERNAL, "gl: reading an image: %zu bytes are too few",
                         size);
    strata_result result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    uint32_t step = (uint32_t)(TRANSFER_STEP / row);
    for (uint32_t y = 0; y < image->height; y += step) {
        uint32_t rows = image->height - y < step ? image->height - y : step;
        g->fn.GetTextureSubImage(image->name, 0, 0, (GLint)y, (GLint)layer, (GLsizei)image->width,
                                 (GLsizei)rows, 1, format->format, format->type,
                                 (GLsizei)(rows * row), (char *)texels + y * row);
    }
    result = gl_report(g, STRATA_OK, "reading an image", err);
    gl_leave(g);
    return result;
}

strata_result gl_image_write(void *self, void *native, uint32_t layer, uint32_t x, uint32_t y,
                             uint32_t width, uint32_t height, const void *texels, base_error *err) {
    gl *g = self;
    const gl_image *image = native;
    const gl_format *format = image->format;
    strata_result result = gl_enter(g, err);
    if (result != STRATA_OK)
        return result;
    if (image->layers)
        g->fn.TextureSubImage3D(image->name, 0, (GLint)x, (GLint)y, (GLint)layer, (GLsizei)width,
                                (GLsizei)height, 1, format->format, format->type, texels);
    else
        g->fn.TextureSubImage2D(image->name, 0, (GLint)x, (GLint)y, (GLsizei)width, (GLsizei)height,
                                format->format, format->type, texels);
    result = gl_report(g, STRATA_OK, "writing an image", err);
    gl_leave(g);
    return result;
}
