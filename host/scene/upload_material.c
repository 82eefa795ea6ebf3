/* SPDX-License-Identifier: MIT
 *
 * Materials and textures as shaders index them: one texture entry for each filled slot of each
 * material in use, its image packed into the atlas of colours or of data.
 */
#include "scene/upload_internal.h"

#include <stdlib.h>
#include <string.h>

typedef struct images { /* of one atlas, one element for each image of the scene */
    uint32_t *levels;   /* 0: not in this atlas */
    uint32_t *first_level;
    strata_image atlas;
} images;

const scene_texture *upload_slot(const scene_material *m, uint32_t slot, int *colour) {
    const scene_texture *const slots[UPLOAD_SLOTS] = {
        &m->base_color_texture, &m->metallic_roughness_texture, &m->normal_texture,
        &m->occlusion_texture,  &m->emissive_texture,           &m->transmission_texture};
    *colour = slot == 0 || slot == 4;
    return slots[slot];
}

static uint32_t full_chain(const scene_image *image) {
    uint32_t size = image->width > image->height ? image->width : image->height, levels = 1;
    while (size >>= 1)
        levels++;
    return levels;
}

/* A texture that this material's shading reads. */
static int is_read(const scene *s, const scene_material *m, uint32_t slot, const scene_texture *t) {
    if (t->image >= s->image_count || (m->unlit && slot != 0))
        return 0;
    return slot != 5 || m->transmission > 0.0f;
}

/* Notes which images the used materials need in which atlas; returns the number of textures. */
static uint32_t collect(const upload *u, const scene *s, images sets[2]) {
    uint32_t count = 0;
    unsigned char *used = base_calloc(s->material_count ? s->material_count : 1, 1);
    if (!used)
        return SCENE_NONE;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        used[s->meshes[i].material] |= u->meshes[i].used != 0;
    for (uint32_t i = 0; i < s->material_count; i++)
        for (uint32_t slot = 0; slot < UPLOAD_SLOTS && used[i]; slot++) {
            int colour;
            const scene_texture *t = upload_slot(&s->materials[i], slot, &colour);
            if (!is_read(s, &s->materials[i], slot, t))
                continue;
            uint32_t *levels = &sets[colour].levels[t->image];
            uint32_t wanted = t->mipmap == SCENE_MIP_NONE ? 1 : full_chain(&s->images[t->image]);
            *levels = *levels > wanted ? *levels : wanted;
            count++;
        }
    free(used);
    return count;
}

static upload_texture make_texture(const scene *s, const scene_texture *t, const images *set) {
    const scene_image *image = &s->images[t->image];
    upload_texture out = {.size = image->width | image->height << 16,
                          .levels = set->levels[t->image],
                          .first_level = set->first_level[t->image]};
    memcpy(out.scale_rotate, t->scale_rotate, sizeof out.scale_rotate);
    memcpy(out.offset, t->offset, sizeof out.offset);
    out.flags = (t->uv == 1 ? 1u : 0u) | (t->magnify == SCENE_LINEAR ? 2u : 0u) |
                (t->minify == SCENE_LINEAR ? 4u : 0u) | (t->mipmap == SCENE_MIP_NEAREST ? 8u : 0u) |
                (t->mipmap == SCENE_MIP_LINEAR ? 16u : 0u) | (uint32_t)t->wrap_u << 5 |
                (uint32_t)t->wrap_v << 7;
    return out;
}

static upload_material make_material(const scene_material *m, int transparent) {
    float bend = (m->ior - 1.0f) / (m->ior + 1.0f);
    upload_material out = {.metallic = m->metallic,
                           .roughness = m->roughness,
                           .normal_scale = m->normal_scale,
                           .occlusion_strength = m->occlusion_strength,
                           .f0 = bend * bend,
                           .transmission = transparent ? m->transmission : 0.0f};
    if (m->ior == 0.0f) /* KHR_materials_ior: reflects all */
        out.f0 = 1.0f;
    memcpy(out.base_color, m->base_color, sizeof out.base_color);
    memcpy(out.emissive, m->emissive, sizeof m->emissive);
    out.emissive[3] = m->alpha_cutoff;
    return out;
}

/* Fills materials and the textures that they name; returns the number of textures. */
static uint32_t fill(const scene *s, images sets[2], const unsigned char *transparent,
                     upload_material *materials, upload_texture *textures) {
    uint32_t next = 0;
    for (uint32_t i = 0; i < s->material_count; i++) {
        materials[i] = make_material(&s->materials[i], transparent && transparent[i]);
        uint32_t *const fields[UPLOAD_SLOTS] = {
            &materials[i].base_color_texture, &materials[i].metallic_roughness_texture,
            &materials[i].normal_texture,     &materials[i].occlusion_texture,
            &materials[i].emissive_texture,   &materials[i].transmission_texture};
        for (uint32_t slot = 0; slot < UPLOAD_SLOTS; slot++) {
            int colour;
            const scene_texture *t = upload_slot(&s->materials[i], slot, &colour);
            *fields[slot] = SCENE_NONE;
            /* An image without levels belongs to a material that nothing visible uses. */
            if (!is_read(s, &s->materials[i], slot, t) || !sets[colour].levels[t->image])
                continue;
            textures[next] = make_texture(s, t, &sets[colour]);
            *fields[slot] = next++;
        }
    }
    return next;
}

static strata_result build_atlases(upload *u, const scene *s, images sets[2], base_error *err) {
    static const char *const names[2] = {"strata_atlas_linear", "strata_atlas_srgb"};
    static const char *const defines[2] = {"STRATA_HAS_LINEAR", "STRATA_HAS_SRGB"};
    upload_texel *texels = NULL;
    uint32_t texel_count = 0;
    strata_result result = STRATA_OK;
    for (int colour = 0; colour < 2 && result == STRATA_OK; colour++) {
        images *set = &sets[colour];
        result = upload_atlas(u->scope, u->g, s, set->levels, colour, set->first_level, &texels,
                              &texel_count, &set->atlas, err);
        if (result == STRATA_OK)
            result = upload_image(u, names[colour], set->atlas, err);
        if (result == STRATA_OK)
            result = upload_define(u, defines[colour], set->atlas.id != 0, err);
    }
    strata_buffer buffer = {0};
    if (result == STRATA_OK)
        result = upload_buffer(u, "StrataTexels", "atlas places", texels,
                               texel_count * sizeof *texels, &buffer, err);
    free(texels);
    return result;
}

static strata_result fill_buffers(upload *u, const scene *s, images sets[2],
                                  const unsigned char *transparent, base_error *err) {
    /* A material that is not used may share images with one that is: room for all. */
    size_t most = (size_t)s->material_count * UPLOAD_SLOTS;
    upload_material *materials =
        base_calloc(s->material_count ? s->material_count : 1, sizeof *materials);
    upload_texture *textures = base_calloc(most ? most : 1, sizeof *textures);
    strata_result result = STRATA_OK;
    strata_buffer buffers[2] = {{0}};
    if (materials && textures)
        u->texture_count = fill(s, sets, transparent, materials, textures);
    else
        result =
            base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for materials", s->path);
    if (result == STRATA_OK)
        result = upload_buffer(u, "StrataMaterials", "materials", materials,
                               (s->material_count ? s->material_count : 1) * sizeof *materials,
                               &buffers[0], err);
    if (result == STRATA_OK && u->texture_count)
        result = upload_buffer(u, "StrataTextures", "textures", textures,
                               u->texture_count * sizeof *textures, &buffers[1], err);
    free(materials);
    free(textures);
    return result;
}

strata_result upload_materials(upload *u, const scene *s, const unsigned char *transparent,
                               base_error *err) {
    size_t count = s->image_count ? s->image_count : 1;
    images sets[2] = {
        {base_calloc(count, sizeof(uint32_t)), base_calloc(count, sizeof(uint32_t)), {0}},
        {base_calloc(count, sizeof(uint32_t)), base_calloc(count, sizeof(uint32_t)), {0}}};
    strata_result result = STRATA_OK;
    if (sets[0].levels && sets[0].first_level && sets[1].levels && sets[1].first_level)
        u->texture_count = collect(u, s, sets);
    else
        u->texture_count = SCENE_NONE;
    if (u->texture_count == SCENE_NONE)
        result =
            base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for textures", s->path);
    if (result == STRATA_OK && u->texture_count)
        result = build_atlases(u, s, sets, err);
    if (result == STRATA_OK)
        result = upload_define(u, "STRATA_HAS_TEXTURES", u->texture_count > 0, err);
    if (result == STRATA_OK)
        result = fill_buffers(u, s, sets, transparent, err);
    for (int colour = 0; colour < 2; colour++) {
        free(sets[colour].levels);
        free(sets[colour].first_level);
    }
    return result;
}
