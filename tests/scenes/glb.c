/* SPDX-License-Identifier: MIT
 *
 * See glb.h. The PNG writer uses zlib's stored blocks, so that its output is known byte for byte.
 */
#include "scenes/glb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void must(int fine) {
    if (!fine)
        abort();
}

uint32_t test_glb_view(test_glb *g, const void *data, size_t size, uint32_t stride) {
    base_text_add(&g->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu",
                  g->view_count ? "," : "", g->binary.length, size);
    if (stride)
        base_text_add(&g->views, ",\"byteStride\":%u", stride);
    base_text_add(&g->views, "}");
    base_text_append(&g->binary, data, size);
    base_text_append(&g->binary, "\0\0\0", (4 - g->binary.length % 4) % 4);
    return g->view_count++;
}

uint32_t test_glb_accessor(test_glb *g, uint32_t view, int component, const char *type,
                           uint64_t count, const char *more) {
    base_text_add(&g->accessors, "%s{", g->accessor_count ? "," : "");
    if (view != UINT32_MAX)
        base_text_add(&g->accessors, "\"bufferView\":%u,", view);
    base_text_add(&g->accessors, "\"componentType\":%d,\"type\":\"%s\",\"count\":%llu%s}",
                  component, type, (unsigned long long)count, more);
    return g->accessor_count++;
}

uint32_t test_glb_floats(test_glb *g, const char *type, uint32_t width, uint32_t count,
                         const float *values) {
    uint32_t view = test_glb_view(g, values, (size_t)count * width * sizeof *values, 0);
    return test_glb_accessor(g, view, TEST_GLB_F32, type, count, "");
}

void test_glb_json(test_glb *g, const char *format, ...) {
    char text[4096];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    must(length >= 0 && length < (int)sizeof text);
    base_text_add(&g->rest, ",%s", text);
}

static void put_word(unsigned char *at, size_t value) {
    for (int i = 0; i < 4; i++)
        at[i] = (unsigned char)(value >> 8 * i & 0xffu);
}

unsigned char *test_glb_pack(const char *json, const void *binary, size_t binary_size,
                             size_t *size) {
    size_t length = strlen(json), padded = (length + 3) / 4 * 4, data = (binary_size + 3) / 4 * 4;
    *size = 20 + padded + (binary_size ? 8 + data : 0);
    unsigned char *file = calloc(*size, 1);
    must(file != NULL);
    memcpy(file, "glTF", 4);
    put_word(file + 4, 2);
    put_word(file + 8, *size);
    put_word(file + 12, padded);
    memcpy(file + 16, "JSON", 4);
    memset(file + 20, ' ', padded);
    memcpy(file + 20, json, length);
    if (binary_size) {
        put_word(file + 20 + padded, data);
        memcpy(file + 24 + padded, "BIN", 4);
        memcpy(file + 28 + padded, binary, binary_size);
    }
    return file;
}

unsigned char *test_glb_finish(test_glb *g, size_t *size) {
    base_text json = {0};
    base_text_add(&json, "{\"asset\":{\"version\":\"2.0\"}%s", g->rest.data ? g->rest.data : "");
    if (g->binary.length)
        base_text_add(&json, ",\"buffers\":[{\"byteLength\":%zu}]", g->binary.length);
    if (g->view_count)
        base_text_add(&json, ",\"bufferViews\":[%s]", g->views.data);
    if (g->accessor_count)
        base_text_add(&json, ",\"accessors\":[%s]", g->accessors.data);
    base_text_add(&json, "}");
    must(!json.failed && !g->binary.failed && !g->views.failed && !g->accessors.failed &&
         !g->rest.failed);
    unsigned char *file = test_glb_pack(json.data, g->binary.data, g->binary.length, size);
    base_text_free(&json);
    base_text_free(&g->binary);
    base_text_free(&g->views);
    base_text_free(&g->accessors);
    base_text_free(&g->rest);
    *g = (test_glb){0};
    return file;
}

/* ---- PNG ------------------------------------------------------------------------------------- */

static uint32_t crc32_of(const unsigned char *bytes, size_t size) {
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void append_big(base_text *out, uint32_t value) {
    char bytes[4] = {(char)(value >> 24), (char)(value >> 16), (char)(value >> 8), (char)value};
    base_text_append(out, bytes, 4);
}

static void append_chunk(base_text *png, const char *type, const base_text *data) {
    base_text checked = {0};
    base_text_append(&checked, type, 4);
    base_text_append(&checked, data->data, data->length);
    append_big(png, (uint32_t)data->length);
    base_text_append(png, checked.data, checked.length);
    append_big(png, crc32_of((const unsigned char *)checked.data, checked.length));
    base_text_free(&checked);
}

static void append_stored(base_text *out, const unsigned char *bytes, size_t size) {
    uint32_t a = 1, b = 0; /* Adler-32 */
    base_text_append(out, "\x78\x01", 2);
    for (size_t at = 0; at < size;) {
        size_t part = size - at < 65535 ? size - at : 65535;
        unsigned char head[5] = {at + part == size, (unsigned char)part, (unsigned char)(part >> 8),
                                 (unsigned char)~part, (unsigned char)(~part >> 8)};
        base_text_append(out, (const char *)head, 5);
        base_text_append(out, (const char *)bytes + at, part);
        at += part;
    }
    for (size_t i = 0; i < size; i++) {
        a = (a + bytes[i]) % 65521;
        b = (b + a) % 65521;
    }
    append_big(out, b << 16 | a);
}

void test_glb_png(base_text *png, uint32_t width, uint32_t height, const unsigned char color[4]) {
    base_text head = {0}, body = {0};
    size_t row = (size_t)width * 4 + 1, size = row * height;
    unsigned char *pixels = calloc(size, 1);
    must(pixels != NULL);
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++)
            memcpy(pixels + y * row + 1 + x * 4, color, 4);
    append_big(&head, width);
    append_big(&head, height);
    base_text_append(&head, "\x08\x06\0\0\0", 5);
    append_stored(&body, pixels, size);
    base_text_append(png, "\x89PNG\r\n\x1a\n", 8);
    append_chunk(png, "IHDR", &head);
    append_chunk(png, "IDAT", &body);
    append_chunk(png, "IEND", &(base_text){.data = (char[1]){0}});
    base_text_free(&head);
    base_text_free(&body);
    free(pixels);
}
