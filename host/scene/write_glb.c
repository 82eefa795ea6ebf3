/* SPDX-License-Identifier: MIT
 *
 * scene_write_glb: a scene as one self-contained binary glTF 2.0 file. Deformed meshes are written
 * as they stand; invisible instances are left out. Arrays go from the scene to the file without
 * being copied.
 */
#include "scene/write_glb.h"

#include "image/image.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- JSON ----------------------------------------------------------------------------------- */

base_text *glb_begin(glb_list *list) {
    base_text_add(&list->text, "%s{", list->count ? ",\n" : "\n");
    list->count++;
    return &list->text;
}

void glb_number(base_text *text, double value) {
    char digits[40];
    snprintf(digits, sizeof digits, "%.9g", value);
    for (char *c = digits; *c; c++)
        if (!strchr("0123456789+-e", *c))
            *c = '.'; /* the locale's decimal point */
    base_text_add(text, "%s", digits);
}

void glb_numbers(base_text *text, const char *key, const float *values, uint32_t count) {
    base_text_add(text, ",\"%s\":[", key);
    for (uint32_t i = 0; i < count; i++) {
        base_text_add(text, "%s", i ? "," : "");
        glb_number(text, (double)values[i]);
    }
    base_text_add(text, "]");
}

void glb_string(base_text *text, const char *string) {
    base_text_append(text, "\"", 1);
    for (const char *c = string; *c; c++) {
        if ((unsigned char)*c < 0x20)
            base_text_add(text, "\\u%04x", (unsigned)*c);
        else
            base_text_add(text, *c == '"' || *c == '\\' ? "\\%c" : "%c", *c);
    }
    base_text_append(text, "\"", 1);
}

/* ---- the binary chunk ----------------------------------------------------------------------- */

enum { GLB_VERTICES = 34962, GLB_INDICES = 34963 }; /* bufferView.target; 0: neither */

static uint32_t add_view(glb_writer *w, const void *data, void *owned, size_t size,
                         unsigned target) {
    glb_piece *pieces = base_grow(w->pieces, &w->piece_capacity, w->piece_count, sizeof *pieces);
    w->failed |= !pieces;
    if (!pieces) {
        free(owned);
        return 0;
    }
    w->pieces = pieces;
    pieces[w->piece_count++] = (glb_piece){.data = data, .owned = owned, .size = size};
    base_text *text = glb_begin(&w->views);
    base_text_add(text, "\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%zu",
                  (unsigned long long)w->length, size);
    if (target)
        base_text_add(text, ",\"target\":%u", target);
    base_text_add(text, "}");
    w->length += ((uint64_t)size + 3) & ~(uint64_t)3;
    return w->views.count - 1;
}

/* Leaves the object open for more members. */
static base_text *add_accessor(glb_writer *w, uint32_t view, uint32_t component, uint32_t count,
                               uint32_t width) {
    static const char *const types[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    base_text *text = glb_begin(&w->accessors);
    base_text_add(text, "\"bufferView\":%u,\"componentType\":%u,\"count\":%u,\"type\":\"%s\"", view,
                  component, count, types[width - 1]);
    return text;
}

uint32_t glb_floats(glb_writer *w, const float *values, float *owned, uint32_t count,
                    uint32_t width) {
    /* what is made for the file is per instance, which has no target */
    uint32_t view =
        add_view(w, values, owned, (size_t)count * width * sizeof(float), owned ? 0 : GLB_VERTICES);
    base_text_add(add_accessor(w, view, 5126, count, width), "}");
    return w->accessors.count - 1;
}

/* ---- meshes --------------------------------------------------------------------------------- */

/* glTF wants the exact bounds of positions, without radii. */
static uint32_t write_positions(glb_writer *w, const scene_mesh *mesh) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < (size_t)mesh->vertex_count * 3; i++) {
        low[i % 3] = fminf(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmaxf(high[i % 3], mesh->positions[i]);
    }
    uint32_t view = add_view(w, mesh->positions, NULL,
                             (size_t)mesh->vertex_count * 3 * sizeof(float), GLB_VERTICES);
    base_text *text = add_accessor(w, view, 5126, mesh->vertex_count, 3);
    glb_numbers(text, "min", low, 3);
    glb_numbers(text, "max", high, 3);
    base_text_add(text, "}");
    return w->accessors.count - 1;
}

/* SCENE_NONE for points in their own order, which need no indices. */
static uint32_t write_indices(glb_writer *w, const scene_mesh *mesh) {
    uint32_t i = 0;
    while (i < mesh->index_count && mesh->indices[i] == i)
        i++;
    if (mesh->topology == SCENE_POINTS && i == mesh->index_count && i == mesh->vertex_count)
        return SCENE_NONE;
    uint32_t view =
        add_view(w, mesh->indices, NULL, (size_t)mesh->index_count * sizeof(uint32_t), GLB_INDICES);
    base_text_add(add_accessor(w, view, 5125, mesh->index_count, 1), "}");
    return w->accessors.count - 1;
}

static void write_mesh(glb_writer *w, const scene_mesh *mesh) {
    const struct {
        const char *name;
        const float *values;
        uint32_t width;
    } attributes[] = {{"NORMAL", mesh->normals, 3}, {"TANGENT", mesh->tangents, 4},
                      {"TEXCOORD_0", mesh->uv0, 2}, {"TEXCOORD_1", mesh->uv1, 2},
                      {"COLOR_0", mesh->colors, 4}, {"_RADIUS", mesh->radii, 1}};
    uint32_t positions = write_positions(w, mesh), indices = write_indices(w, mesh);
    base_text *text = glb_begin(&w->meshes);
    base_text_add(text, "\"name\":");
    glb_string(text, mesh->name);
    base_text_add(text, ",\"primitives\":[{\"attributes\":{\"POSITION\":%u", positions);
    for (size_t i = 0; i < BASE_COUNT(attributes); i++)
        if (attributes[i].values)
            base_text_add(
                text, ",\"%s\":%u", attributes[i].name,
                glb_floats(w, attributes[i].values, NULL, mesh->vertex_count, attributes[i].width));
    base_text_add(text, "},\"material\":%u", mesh->material);
    if (indices != SCENE_NONE)
        base_text_add(text, ",\"indices\":%u", indices);
    base_text_add(text, "%s}]}", mesh->topology == SCENE_POINTS ? ",\"mode\":0" : "");
}

/* ---- materials ------------------------------------------------------------------------------ */

static void write_images(glb_writer *w, strata_result *result, base_error *err) {
    for (uint32_t i = 0; i < w->s->image_count && *result == STRATA_OK; i++) {
        const scene_image *im = &w->s->images[i];
        unsigned char *data = NULL;
        size_t size = 0;
        *result = image_encode_png(im->name, im->pixels, im->width, im->height, &data, &size, err);
        if (*result != STRATA_OK)
            return;
        uint32_t view = add_view(w, data, data, size, 0);
        base_text *text = glb_begin(&w->images);
        base_text_add(text, "\"bufferView\":%u,\"mimeType\":\"image/png\",\"name\":", view);
        glb_string(text, im->name);
        base_text_add(text, "}");
    }
}

/* `,"key":{"index":...}` with its sampler, texture and transform; nothing for an absent texture.
 * `extra` is a member that the slot has besides, named by `extra_key` when not NULL. */
static void write_texture(glb_writer *w, base_text *text, const char *key,
                          const scene_texture *texture, const char *extra_key, float extra) {
    static const unsigned minify[3][2] = {{9728, 9729}, {9984, 9985}, {9986, 9987}};
    static const unsigned wrap[3] = {10497, 33648, 33071};
    if (texture->image == SCENE_NONE)
        return;
    base_text_add(glb_begin(&w->samplers),
                  "\"magFilter\":%u,\"minFilter\":%u,\"wrapS\":%u,\"wrapT\":%u}",
                  texture->magnify == SCENE_NEAREST ? 9728u : 9729u,
                  minify[texture->mipmap][texture->minify == SCENE_LINEAR], wrap[texture->wrap_u],
                  wrap[texture->wrap_v]);
    base_text_add(glb_begin(&w->textures), "\"sampler\":%u,\"source\":%u}", w->samplers.count - 1,
                  texture->image);
    base_text_add(text, ",\"%s\":{\"index\":%u,\"texCoord\":%u", key, w->textures.count - 1,
                  texture->uv);
    if (extra_key) {
        base_text_add(text, ",\"%s\":", extra_key);
        glb_number(text, (double)extra);
    }
    const float *m = texture->scale_rotate; /* rotation times scale: the columns keep their angle */
    const float identity[4] = {1, 0, 0, 1}, none[2] = {0, 0};
    if (memcmp(m, identity, sizeof identity) != 0 ||
        memcmp(texture->offset, none, sizeof none) != 0) {
        double angle = atan2(-(double)m[2], (double)m[0]);
        double x = (double)m[0], y = (double)m[3];
        if (m[1] != 0 || m[2] != 0) {
            x = sqrt((double)m[0] * (double)m[0] + (double)m[2] * (double)m[2]);
            y = (double)m[1] * sin(angle) + (double)m[3] * cos(angle);
        } else {
            angle = 0;
        }
        w->extensions |= GLB_TEXTURE_TRANSFORM;
        base_text_add(text, ",\"extensions\":{\"KHR_texture_transform\":{\"rotation\":");
        glb_number(text, angle);
        glb_numbers(text, "scale", (const float[2]){(float)x, (float)y}, 2);
        glb_numbers(text, "offset", texture->offset, 2);
        base_text_add(text, "}}");
    }
    base_text_add(text, "}");
}

static float emissive_strength(const scene_material *m) {
    return fmaxf(1, fmaxf(m->emissive[0], fmaxf(m->emissive[1], m->emissive[2])));
}

static void write_material_extensions(glb_writer *w, base_text *text, const scene_material *m) {
    const char *comma = "";
    float strength = emissive_strength(m);
    base_text_add(text, ",\"extensions\":{");
    if (m->unlit) {
        w->extensions |= GLB_UNLIT;
        base_text_add(text, "\"KHR_materials_unlit\":{}");
        comma = ",";
    }
    if (strength > 1) {
        w->extensions |= GLB_EMISSIVE_STRENGTH;
        base_text_add(text, "%s\"KHR_materials_emissive_strength\":{\"emissiveStrength\":", comma);
        glb_number(text, (double)strength);
        base_text_add(text, "}");
        comma = ",";
    }
    if (m->ior < 1.5f || m->ior > 1.5f) {
        w->extensions |= GLB_IOR;
        base_text_add(text, "%s\"KHR_materials_ior\":{\"ior\":", comma);
        glb_number(text, (double)m->ior);
        base_text_add(text, "}");
        comma = ",";
    }
    if (m->transmission > 0) {
        w->extensions |= GLB_TRANSMISSION;
        base_text_add(text, "%s\"KHR_materials_transmission\":{\"transmissionFactor\":", comma);
        glb_number(text, (double)m->transmission);
        write_texture(w, text, "transmissionTexture", &m->transmission_texture, NULL, 0);
        base_text_add(text, "}");
    }
    base_text_add(text, "}");
}

static void write_material(glb_writer *w, const scene_material *m) {
    static const char *const modes[] = {"OPAQUE", "MASK", "BLEND"};
    base_text *text = glb_begin(&w->materials);
    base_text_add(text, "\"name\":");
    glb_string(text, m->name);
    base_text_add(text, ",\"pbrMetallicRoughness\":{\"metallicFactor\":");
    glb_number(text, (double)m->metallic);
    base_text_add(text, ",\"roughnessFactor\":");
    glb_number(text, (double)m->roughness);
    glb_numbers(text, "baseColorFactor", m->base_color, 4);
    write_texture(w, text, "baseColorTexture", &m->base_color_texture, NULL, 0);
    write_texture(w, text, "metallicRoughnessTexture", &m->metallic_roughness_texture, NULL, 0);
    base_text_add(text, "},\"alphaMode\":\"%s\"", modes[m->alpha]);
    if (m->alpha == SCENE_MASK) {
        base_text_add(text, ",\"alphaCutoff\":");
        glb_number(text, (double)m->alpha_cutoff);
    }
    base_text_add(text, ",\"doubleSided\":%s", m->double_sided ? "true" : "false");
    write_texture(w, text, "normalTexture", &m->normal_texture, "scale", m->normal_scale);
    write_texture(w, text, "occlusionTexture", &m->occlusion_texture, "strength",
                  m->occlusion_strength);
    write_texture(w, text, "emissiveTexture", &m->emissive_texture, NULL, 0);
    float strength = emissive_strength(m);
    glb_numbers(text, "emissiveFactor",
                (const float[3]){m->emissive[0] / strength, m->emissive[1] / strength,
                                 m->emissive[2] / strength},
                3);
    write_material_extensions(w, text, m);
    base_text_add(text, "}");
}

/* ---- the file ------------------------------------------------------------------------------- */

static void add_array(base_text *json, const char *key, glb_list *list) {
    if (list->count == 0)
        return;
    base_text_add(json, ",\n\"%s\":[", key);
    base_text_append(json, list->text.data, list->text.length);
    base_text_add(json, "]");
    json->failed |= list->text.failed;
}

static void add_extensions(const glb_writer *w, base_text *json) {
    static const char *const names[] = {"KHR_materials_unlit",    "KHR_materials_transmission",
                                        "KHR_materials_ior",      "KHR_materials_emissive_strength",
                                        "KHR_texture_transform",  "KHR_lights_punctual",
                                        "EXT_mesh_gpu_instancing"};
    const char *comma = "";
    if (!w->extensions)
        return;
    base_text_add(json, ",\n\"extensionsUsed\":[");
    for (unsigned i = 0; i < BASE_COUNT(names); i++) {
        if (w->extensions & 1u << i) {
            base_text_add(json, "%s\"%s\"", comma, names[i]);
            comma = ",";
        }
    }
    base_text_add(json, "]");
    if (w->extensions & GLB_INSTANCING)
        base_text_add(json, ",\n\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"]");
}

static void assemble(glb_writer *w, base_text *json) {
    base_text_add(json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Strata\"}");
    add_extensions(w, json);
    base_text_add(json, ",\n\"scene\":0,\"scenes\":[{");
    for (uint32_t i = 0; i < w->nodes.count; i++)
        base_text_add(json, "%s%u", i ? "," : "\"nodes\":[", i);
    base_text_add(json, "%s}]", w->nodes.count ? "]" : "");
    add_array(json, "nodes", &w->nodes);
    add_array(json, "meshes", &w->meshes);
    add_array(json, "materials", &w->materials);
    add_array(json, "textures", &w->textures);
    add_array(json, "samplers", &w->samplers);
    add_array(json, "images", &w->images);
    add_array(json, "cameras", &w->cameras);
    if (w->lights.count) {
        base_text_add(json, ",\n\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[");
        base_text_append(json, w->lights.text.data, w->lights.text.length);
        base_text_add(json, "]}}");
        json->failed |= w->lights.text.failed;
    }
    add_array(json, "accessors", &w->accessors);
    add_array(json, "bufferViews", &w->views);
    if (w->length)
        base_text_add(json, ",\n\"buffers\":[{\"byteLength\":%llu}]",
                      (unsigned long long)w->length);
    base_text_add(json, "}");
    while (json->length % 4 && !json->failed)
        base_text_append(json, " ", 1);
}

static strata_result put_chunk_header(base_output *out, uint64_t length, uint32_t type,
                                      base_error *err) {
    const uint32_t header[2] = {(uint32_t)length, type};
    return base_output_write(out, header, sizeof header, err);
}

static strata_result put_file(const glb_writer *w, const base_text *json, const char *path,
                              base_error *err) {
    uint64_t total = 12 + 8 + json->length + (w->length ? 8 + w->length : 0);
    base_output out;
    if (total > UINT32_MAX)
        return base_fail(err, STRATA_ERROR_OVERFLOW,
                         "%s: the scene takes %llu bytes, more than a GLB file can hold", path,
                         (unsigned long long)total);
    strata_result result = base_output_open(&out, path, err);
    if (result != STRATA_OK)
        return result;
    const uint32_t magic[3] = {0x46546c67, 2, (uint32_t)total};
    result = base_output_write(&out, magic, sizeof magic, err);
    if (result == STRATA_OK)
        result = put_chunk_header(&out, json->length, 0x4e4f534a, err);
    if (result == STRATA_OK)
        result = base_output_write(&out, json->data, json->length, err);
    if (result == STRATA_OK && w->length)
        result = put_chunk_header(&out, w->length, 0x004e4942, err);
    for (size_t i = 0; i < w->piece_count && result == STRATA_OK; i++) {
        static const char padding[4];
        result = base_output_write(&out, w->pieces[i].data, w->pieces[i].size, err);
        if (result == STRATA_OK)
            result = base_output_write(&out, padding, -w->pieces[i].size % 4, err);
    }
    if (result == STRATA_OK)
        result = base_output_commit(&out, err);
    base_output_abort(&out);
    return result;
}

static void free_writer(glb_writer *w) {
    glb_list *lists[] = {&w->views,    &w->accessors, &w->meshes,    &w->nodes,  &w->images,
                         &w->samplers, &w->textures,  &w->materials, &w->lights, &w->cameras};
    for (size_t i = 0; i < BASE_COUNT(lists); i++)
        base_text_free(&lists[i]->text);
    for (size_t i = 0; i < w->piece_count; i++)
        free(w->pieces[i].owned);
    free(w->pieces);
    free(w->mesh_number);
}

strata_result scene_write_glb(const scene *s, const char *path, base_error *err) {
    glb_writer w = {.s = s, .mesh_number = base_calloc(s->mesh_count + 1u, sizeof(uint32_t))};
    base_text json = {0};
    strata_result result = STRATA_OK;
    w.failed = !w.mesh_number;
    for (uint32_t i = 0; i < s->mesh_count && !w.failed; i++) {
        int empty = s->meshes[i].index_count == 0;
        w.mesh_number[i] = empty ? SCENE_NONE : w.meshes.count;
        if (!empty)
            write_mesh(&w, &s->meshes[i]);
    }
    for (uint32_t i = 0; i < s->material_count; i++)
        write_material(&w, &s->materials[i]);
    write_images(&w, &result, err);
    if (!w.failed)
        glb_write_instances(&w);
    glb_write_cameras(&w);
    glb_write_lights(&w);
    assemble(&w, &json);
    if (result == STRATA_OK && (w.failed || json.failed))
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to write it", path);
    if (result == STRATA_OK)
        result = put_file(&w, &json, path, err);
    base_text_free(&json);
    free_writer(&w);
    return result;
}
