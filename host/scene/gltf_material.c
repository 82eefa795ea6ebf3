/* SPDX-License-Identifier: MIT
 *
 * glTF materials, textures, samplers and images as the scene's. An image is decoded when the first
 * texture asks for it; one that cannot be read is a warning, and what it was for is drawn without.
 */
#include "scene/gltf.h"
#include "scene/image_decode.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- images ---------------------------------------------------------------------------------- */

/* The encoded bytes; *owned is what to free. */
static strata_result image_bytes(gltf_loader *l, const gltf_image *image,
                                 const unsigned char **bytes, size_t *size, unsigned char **owned,
                                 base_error *trouble) {
    *owned = NULL;
    if (image->uri) {
        strata_result result = gltf_read_uri(l, image->uri, (size_t)1 << 30, owned, size, trouble);
        *bytes = *owned;
        return result;
    }
    if (image->view == SCENE_NONE)
        return base_fail(trouble, STRATA_ERROR_BAD_FILE, "has neither uri nor bufferView");
    uint64_t length;
    base_error *kept = l->err;
    l->err = trouble;
    strata_result result = gltf_view_bytes(l, image->view, "bufferView", bytes, &length);
    l->err = kept;
    *size = (size_t)length;
    return result;
}

static strata_result decode_image(gltf_loader *l, uint32_t index, scene_image *out,
                                  base_error *trouble) {
    const gltf_image *image = &l->file.images[index];
    const unsigned char *bytes = NULL;
    unsigned char *owned = NULL;
    size_t size = 0;
    strata_result result = image_bytes(l, image, &bytes, &size, &owned, trouble);
    if (result == STRATA_OK)
        result = scene_decode_image(bytes, size, out, trouble);
    free(owned);
    if (result != STRATA_OK)
        return result;
    const char *name = image->name ? image->name : image->uri && !owned ? image->uri : NULL;
    if (name && strncmp(name, "data:", 5) != 0)
        out->name = base_strdup(name);
    return STRATA_OK;
}

/* The scene image of a glTF image, decoded now if it was not; SCENE_NONE, with a warning, when it
 * cannot be. */
static strata_result use_image(gltf_loader *l, uint32_t index, uint32_t *out) {
    scene_image decoded = {0};
    base_error trouble = {0};
    *out = l->image_map[index];
    if (*out != SCENE_NONE || l->image_bad[index])
        return STRATA_OK;
    strata_result result = decode_image(l, index, &decoded, &trouble);
    uint64_t bytes = (uint64_t)decoded.width * decoded.height * 4u;
    if (result == STRATA_OK && bytes > l->image_bytes_left)
        result = base_fail(&trouble, STRATA_ERROR_BAD_FILE, "all images together exceed 4 GiB");
    if (result != STRATA_OK) {
        free(decoded.name);
        free(decoded.pixels);
        l->image_bad[index] = 1;
        scene_warn(l->s, "%s: images[%u]: %s: drawn without it", l->s->path, index, trouble.text);
        return STRATA_OK;
    }
    l->s->images[l->s->image_count] = decoded;
    *out = l->image_map[index] = l->s->image_count++;
    l->image_bytes_left -= bytes;
    return STRATA_OK;
}

/* ---- textures -------------------------------------------------------------------------------- */

static scene_wrap wrap_of(int mode) {
    return mode == 33071 ? SCENE_CLAMP : mode == 33648 ? SCENE_MIRROR : SCENE_REPEAT;
}

static void apply_sampler(const gltf_sampler *sampler, scene_texture *out) {
    out->magnify = sampler->magnify == 9728 ? SCENE_NEAREST : SCENE_LINEAR;
    out->wrap_u = wrap_of(sampler->wrap_s);
    out->wrap_v = wrap_of(sampler->wrap_t);
    switch (sampler->minify) {
    case 9728:
    case 9729:
        out->mipmap = SCENE_MIP_NONE;
        break;
    case 9984:
    case 9985:
        out->mipmap = SCENE_MIP_NEAREST;
        break;
    default:
        out->mipmap = SCENE_MIP_LINEAR;
        break;
    }
    out->minify = sampler->minify == 9728 || sampler->minify == 9984 || sampler->minify == 9986
                      ? SCENE_NEAREST
                      : SCENE_LINEAR;
}

static int fits(double value) {
    return fabs(value) <= (double)FLT_MAX;
}

/* Rotation is counter-clockwise with v pointing down: M = R(-angle) S in a y-up notation. */
static int apply_transform(const gltf_texture_use *use, scene_texture *out) {
    double c = cos(use->rotation), s = sin(use->rotation);
    double m[6] = {c * use->scale[0], s * use->scale[1], -s * use->scale[0],
                   c * use->scale[1], use->offset[0],    use->offset[1]};
    for (int i = 0; i < 6; i++) {
        if (!fits(m[i]))
            return 0;
        *(i < 4 ? &out->scale_rotate[i] : &out->offset[i - 4]) = (float)m[i];
    }
    return 1;
}

static strata_result use_texture(gltf_loader *l, uint32_t material, const char *slot,
                                 const gltf_texture_use *use, scene_texture *out) {
    *out = scene_no_texture();
    if (use->texture == SCENE_NONE)
        return STRATA_OK;
    const gltf_texture *texture = &l->file.textures[use->texture];
    if (use->uv > 1) {
        scene_warn(l->s, "%s: materials[%u].%s: texCoord %u is not supported: drawn without it",
                   l->s->path, material, slot, use->uv);
        return STRATA_OK;
    }
    if (texture->image == SCENE_NONE) {
        scene_warn(l->s, "%s: textures[%u]: has no image that can be read: drawn without it",
                   l->s->path, use->texture);
        return STRATA_OK;
    }
    if (!apply_transform(use, out))
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: materials[%u].%s: KHR_texture_transform is not finite", l->s->path,
                         material, slot);
    out->uv = use->uv;
    if (texture->sampler != SCENE_NONE)
        apply_sampler(&l->file.samplers[texture->sampler], out);
    return use_image(l, texture->image, &out->image);
}

/* ---- materials ------------------------------------------------------------------------------- */

static float unit(float value) {
    return value > 0.0f ? (value < 1.0f ? value : 1.0f) : 0.0f;
}

/* Factors into the ranges that glTF gives them; colours may exceed 1, but nothing is negative. */
static void clamp_factors(scene_material *m) {
    m->base_color[3] = unit(m->base_color[3]);
    m->metallic = unit(m->metallic);
    m->roughness = unit(m->roughness);
    m->occlusion_strength = unit(m->occlusion_strength);
    m->transmission = unit(m->transmission);
    m->ior = m->ior >= 1.0f ? m->ior : m->ior == 0.0f ? 0.0f : 1.0f;
    for (int i = 0; i < 3; i++) {
        m->base_color[i] = fmaxf(m->base_color[i], 0.0f);
        m->emissive[i] = fminf(fmaxf(m->emissive[i], 0.0f), FLT_MAX);
    }
}

static strata_result read_material(gltf_loader *l, uint32_t index) {
    const gltf_material *from = &l->file.materials[index];
    scene_material *out = scene_add_material(l->s, &l->material_capacity);
    if (!out)
        return gltf_no_memory(l);
    *out = from->values;
    clamp_factors(out);
    if (from->name && !(out->name = base_strdup(from->name)))
        return gltf_no_memory(l);
    struct {
        const char *slot;
        const gltf_texture_use *use;
        scene_texture *texture;
    } slots[] = {
        {"baseColorTexture", &from->base_color, &out->base_color_texture},
        {"metallicRoughnessTexture", &from->metallic_roughness, &out->metallic_roughness_texture},
        {"normalTexture", &from->normal, &out->normal_texture},
        {"occlusionTexture", &from->occlusion, &out->occlusion_texture},
        {"emissiveTexture", &from->emissive, &out->emissive_texture},
        {"transmissionTexture", &from->transmission, &out->transmission_texture},
    };
    strata_result result = STRATA_OK;
    for (size_t i = 0; i < BASE_COUNT(slots) && result == STRATA_OK; i++)
        result = use_texture(l, index, slots[i].slot, slots[i].use, slots[i].texture);
    return result;
}

strata_result gltf_read_materials(gltf_loader *l) {
    strata_result result = STRATA_OK;
    l->image_map = base_calloc(l->file.image_count, sizeof *l->image_map);
    l->image_bad = base_calloc(l->file.image_count, 1);
    l->s->images = base_calloc(l->file.image_count, sizeof *l->s->images);
    if (!l->image_map || !l->image_bad || !l->s->images)
        return gltf_no_memory(l);
    for (uint32_t i = 0; i < l->file.image_count; i++)
        l->image_map[i] = SCENE_NONE;
    for (uint32_t i = 0; i < l->file.material_count && result == STRATA_OK; i++)
        result = read_material(l, i);
    return result;
}
