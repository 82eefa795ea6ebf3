/* SPDX-License-Identifier: MIT
 *
 * Bytes for the glTF loader: the GLB's chunk, data URIs, and files beside the scene. A file may not
 * be named by an absolute path, by a scheme or through "..": a scene reads from its own folder.
 */
#include "scene/gltf.h"

#include <stdlib.h>
#include <string.h>

static int base64_value(char c) {
    if (c >= 'A' && c <= 'Z')
        return c - 'A';
    if (c >= 'a' && c <= 'z')
        return c - 'a' + 26;
    if (c >= '0' && c <= '9')
        return c - '0' + 52;
    return c == '+' || c == '-' ? 62 : c == '/' || c == '_' ? 63 : -1;
}

/* `out` has room for strlen(text) / 4 * 3 + 3 bytes. Returns 0 on a character that is not base64.
 */
static int decode_base64(const char *text, unsigned char *out, size_t *size) {
    uint32_t bits = 0;
    int held = 0;
    *size = 0;
    for (; *text && *text != '='; text++) {
        int value = base64_value(*text);
        if (value < 0)
            return 0;
        bits = bits << 6 | (uint32_t)value;
        held += 6;
        if (held >= 8) {
            held -= 8;
            out[(*size)++] = (unsigned char)(bits >> held & 0xffu);
        }
    }
    return text[strspn(text, "=")] == '\0';
}

static strata_result read_data_uri(const char *uri, size_t limit, unsigned char **bytes,
                                   size_t *size, base_error *err) {
    const char *comma = strchr(uri, ',');
    if (!comma || comma - uri < 7 || strncmp(comma - 7, ";base64", 7) != 0)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "the data URI is not base64");
    size_t length = strlen(comma + 1);
    if (length / 4 * 3 > limit)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "the data URI holds more than %zu bytes",
                         limit);
    unsigned char *decoded = base_calloc(length / 4 * 3 + 4, 1);
    if (!decoded)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a data URI");
    if (!decode_base64(comma + 1, decoded, size)) {
        free(decoded);
        return base_fail(err, STRATA_ERROR_BAD_FILE, "the data URI's base64 is damaged");
    }
    *bytes = decoded;
    return STRATA_OK;
}

static int hex_value(char c) {
    const char *digits = "0123456789abcdef";
    const char *at = c ? strchr(digits, c | 0x20) : NULL;
    return at ? (int)(at - digits) : -1;
}

/* Replaces %20 and the like in place; 0 when a NUL would come of it. */
static int decode_percent(char *text) {
    char *out = text;
    for (const char *at = text; *at; at++) {
        int high = *at == '%' ? hex_value(at[1]) : -1;
        int low = high >= 0 ? hex_value(at[2]) : -1;
        if (low < 0) {
            *out++ = *at;
            continue;
        }
        if (high == 0 && low == 0)
            return 0;
        *out++ = (char)(high * 16 + low);
        at += 2;
    }
    *out = '\0';
    return 1;
}

/* A relative path with no way up: no leading '/', no ".." component, no scheme, no backslash. */
static int stays_inside(const char *path) {
    if (path[0] == '\0' || path[0] == '/' || strchr(path, '\\') || strstr(path, "://"))
        return 0;
    for (const char *part = path; part; part = strchr(part, '/')) {
        part += *part == '/';
        if (strncmp(part, "..", 2) == 0 && (part[2] == '/' || part[2] == '\0'))
            return 0;
    }
    return 1;
}

static strata_result read_file_uri(const char *folder, const char *uri, size_t limit,
                                   unsigned char **bytes, size_t *size, base_error *err) {
    char *relative = base_strdup(uri), *path = NULL;
    strata_result result;
    if (relative && !(decode_percent(relative) && stays_inside(relative)))
        result =
            base_fail(err, STRATA_ERROR_BAD_FILE, "'%.200s' leads out of the scene's folder", uri);
    else if (relative && !folder)
        result = base_fail(err, STRATA_ERROR_BAD_FILE,
                           "'%.200s' is a file, and a scene in memory has none beside it", uri);
    else if (!relative || !(path = base_format("%s%s", folder, relative)))
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a path");
    else
        result = base_file_read(path, limit, bytes, size, err);
    free(relative);
    free(path);
    return result;
}

strata_result gltf_read_uri(const gltf_loader *l, const char *uri, size_t limit,
                            unsigned char **bytes, size_t *size, base_error *err) {
    *bytes = NULL;
    *size = 0;
    if (strncmp(uri, "data:", 5) == 0)
        return read_data_uri(uri, limit, bytes, size, err);
    return read_file_uri(l->folder, uri, limit, bytes, size, err);
}

static strata_result read_buffer(gltf_loader *l, uint32_t index) {
    gltf_buffer *buffer = &l->file.buffers[index];
    size_t size = 0;
    if (!buffer->uri) {
        if (!l->binary || index != 0)
            return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                             "%s: buffers[%u]: has no uri, and there is no binary chunk for it",
                             l->s->path, index);
        buffer->bytes = l->binary;
        size = l->binary_size;
    } else {
        base_error trouble = {0};
        strata_result result =
            gltf_read_uri(l, buffer->uri, GLTF_MAX_FILE, &buffer->owned, &size, &trouble);
        if (result != STRATA_OK && result != STRATA_ERROR_OUT_OF_HOST_MEMORY)
            result = STRATA_ERROR_BAD_FILE;
        if (result != STRATA_OK)
            return base_fail(l->err, result, "%s: buffers[%u].uri: %s", l->s->path, index,
                             trouble.text);
        buffer->bytes = buffer->owned;
        gltf_allow(l, size);
    }
    if (buffer->length > size)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: buffers[%u].byteLength: is %llu, but only %zu bytes are there",
                         l->s->path, index, (unsigned long long)buffer->length, size);
    return STRATA_OK;
}

strata_result gltf_read_buffers(gltf_loader *l) {
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < l->file.buffer_count && result == STRATA_OK; i++)
        result = read_buffer(l, i);
    return result;
}

strata_result gltf_view_bytes(gltf_loader *l, uint32_t view, const char *place,
                              const unsigned char **bytes, uint64_t *size) {
    const gltf_view *v = &l->file.views[view];
    const gltf_buffer *buffer = &l->file.buffers[v->buffer];
    if (v->offset > buffer->length || v->length > buffer->length - v->offset)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: bufferViews[%u] ends at byte %llu of the %llu in buffers[%u]",
                         l->s->path, place, view, (unsigned long long)v->offset + v->length,
                         (unsigned long long)buffer->length, v->buffer);
    *bytes = buffer->bytes + v->offset;
    *size = v->length;
    return STRATA_OK;
}
