/* SPDX-License-Identifier: MIT
 *
 * scene_load and scene_load_memory: a file or a piece of memory, the GLB container around it, and
 * the order of the loader's steps. Whatever fails, everything is released and one line says where.
 */
#include "scene/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

strata_result gltf_charge(gltf_loader *l, const char *place, uint64_t count, uint64_t size) {
    uint64_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > l->bytes_left)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: the scene unfolds to far more than its files hold", l->s->path,
                         place);
    l->bytes_left -= bytes;
    return STRATA_OK;
}

void gltf_allow(gltf_loader *l, size_t file_size) {
    l->bytes_left += (uint64_t)file_size * 200u;
}

strata_result gltf_no_memory(gltf_loader *l) {
    return base_fail(l->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", l->s->path);
}

/* ---- the container --------------------------------------------------------------------------- */

typedef struct container {
    const char *json;
    size_t json_size;
    const unsigned char *binary; /* NULL: none */
    size_t binary_size;
} container;

static uint32_t word(const unsigned char *at) {
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

/* GLB 2.0: 12 bytes of header, then chunks of {length, type, bytes}; the first is JSON, a second
 * one may be binary, others are skipped. */
static strata_result open_glb(const char *name, const unsigned char *data, size_t size,
                              container *out, base_error *err) {
    if (size < 20)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: GLB header: cut off after %zu bytes",
                         name, size);
    if (word(data + 4) != 2)
        return base_fail(err, STRATA_ERROR_BAD_FILE,
                         "%s: GLB header: version %u, only 2 is supported", name, word(data + 4));
    if (word(data + 8) > size)
        return base_fail(err, STRATA_ERROR_BAD_FILE,
                         "%s: GLB header: length is %u, the file has %zu", name, word(data + 8),
                         size);
    size = word(data + 8);
    for (size_t at = 12, chunk = 0; at + 8 <= size; chunk++) {
        size_t length = word(data + at);
        uint32_t type = word(data + at + 4);
        if (length > size - at - 8)
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: GLB chunk %zu: %zu bytes long, %zu are left", name, chunk, length,
                             size - at - 8);
        if (chunk == 0 && type != 0x4e4f534au)
            return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: GLB chunk 0: is not JSON", name);
        if (chunk == 0) {
            out->json = (const char *)data + at + 8;
            out->json_size = length;
            while (out->json_size > 0 && out->json[out->json_size - 1] == '\0')
                out->json_size--; /* some writers pad with zeros instead of spaces */
        } else if (type == 0x004e4942u && !out->binary) {
            out->binary = data + at + 8;
            out->binary_size = length;
        }
        at += 8 + length;
    }
    if (!out->json)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: GLB: has no chunk", name);
    return STRATA_OK;
}

static strata_result open_container(const char *name, const unsigned char *data, size_t size,
                                    container *out, base_error *err) {
    *out = (container){0};
    if (size >= 4 && memcmp(data, "glTF", 4) == 0)
        return open_glb(name, data, size, out, err);
    out->json = (const char *)data;
    out->json_size = size;
    if (size >= 3 && memcmp(data, "\xef\xbb\xbf", 3) == 0) { /* a byte order mark */
        out->json += 3;
        out->json_size -= 3;
    }
    return STRATA_OK;
}

/* ---- the steps ------------------------------------------------------------------------------- */

/* Nothing moves: the evaluated vertices stay, what they were made from goes. */
static void bake(scene *s) {
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        scene_deform_free(s->meshes[i].deform);
        s->meshes[i].deform = NULL;
        s->meshes[i].skin = SCENE_NONE;
    }
}

static strata_result convert(gltf_loader *l) {
    strata_result result = gltf_read_buffers(l);
    if (result == STRATA_OK)
        result = gltf_read_materials(l);
    if (result == STRATA_OK)
        result = gltf_read_nodes(l);
    if (result == STRATA_OK)
        result = gltf_read_animations(l);
    if (result == STRATA_OK)
        result = scene_evaluate(l->s, l->animations, NAN, l->err);
    if (result != STRATA_OK)
        return result;
    if (l->animations->channel_count > 0) {
        l->s->animations = l->animations;
        l->animations = NULL;
    } else {
        bake(l->s);
    }
    return scene_finish(l->s, l->err);
}

static strata_result load(scene *s, const char *folder, const unsigned char *data, size_t size,
                          base_error *err) {
    gltf_loader l = {.s = s,
                     .folder = folder,
                     .err = err,
                     .bytes_left = UINT64_C(256) << 20,
                     .image_bytes_left = UINT64_C(4) << 30};
    gltf_allow(&l, size);
    gltf_document document = {0};
    container parts;
    strata_result result = open_container(s->path, data, size, &parts, err);
    if (result == STRATA_OK)
        result = gltf_check(s, parts.json, parts.json_size, &document, err);
    if (result == STRATA_OK)
        result = gltf_parse(s->path, document.text, document.text_size, &l.file, err);
    if (result != STRATA_OK)
        goto cleanup;
    l.file.buffers = document.buffers;
    l.file.buffer_count = document.buffer_count;
    l.file.images = document.images;
    l.file.image_count = document.image_count;
    l.binary = parts.binary;
    l.binary_size = parts.binary_size;
    l.animations = base_calloc(1, sizeof *l.animations);
    result = l.animations ? convert(&l) : gltf_no_memory(&l);
cleanup:
    scene_animations_free(l.animations);
    free(l.mesh_first);
    free(l.mesh_map);
    free(l.image_map);
    free(l.image_bad);
    gltf_parse_free(&l.file);
    gltf_document_free(&document);
    return result;
}

static strata_result load_named(const char *name, const char *folder, const void *data, size_t size,
                                scene **out, base_error *err) {
    scene *s = scene_new(name);
    if (!s)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", name);
    strata_result result = load(s, folder, data, size, err);
    if (result != STRATA_OK)
        scene_free(s);
    else
        *out = s;
    return result;
}

strata_result scene_load_memory(const char *name, const void *data, size_t size, scene **out,
                                base_error *err) {
    *out = NULL;
    return load_named(name, NULL, data, size, out, err);
}

strata_result scene_load(const char *path, scene **out, base_error *err) {
    unsigned char *data = NULL;
    size_t size;
    *out = NULL;
    strata_result result = base_file_read(path, GLTF_MAX_FILE, &data, &size, err);
    if (result != STRATA_OK)
        return result;
    const char *slash = strrchr(path, '/');
    char *folder = base_strdup(path);
    if (folder) {
        folder[slash ? slash - path + 1 : 0] = '\0';
        result = load_named(path, folder, data, size, out, err);
    } else {
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", path);
    }
    free(folder);
    free(data);
    return result;
}
