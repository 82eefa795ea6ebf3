/* SPDX-License-Identifier: MIT
 *
 * The life of a scene's GPU copy: the steps in order, the globals and defines under which shaders
 * find it, and their removal.
 */
#include "scene/upload_internal.h"

#include <stdlib.h>
#include <string.h>

/* Every name that a step may set; taken back as a whole. */
static const char *const global_names[] = {
    "StrataRecords",     "StrataPositions",   "StrataNormals",       "StrataTangents",
    "StrataUv0",         "StrataUv1",         "StrataColors",        "StrataRadii",
    "StrataMaterials",   "StrataTextures",    "StrataTexels",        "StrataPrimitiveMap",
    "StrataLights",      "strata_atlas_srgb", "strata_atlas_linear", "StrataObjects",
    "StrataObjectStates"};
static const char *const define_names[] = {
    "STRATA_LIGHT_COUNT",      "STRATA_HAS_LOCAL_LIGHTS", "STRATA_HAS_LIT",
    "STRATA_HAS_TEXTURES",     "STRATA_HAS_SRGB",         "STRATA_HAS_LINEAR",
    "STRATA_HAS_UV0",          "STRATA_HAS_UV1",          "STRATA_HAS_COLORS",
    "STRATA_HAS_TANGENTS",     "STRATA_HAS_POINTS",       "STRATA_HAS_RADII",
    "STRATA_HAS_MASK",         "STRATA_HAS_BLEND",        "STRATA_HAS_EMISSION",
    "STRATA_HAS_TRANSMISSION", "STRATA_HAS_SINGLE_SIDED", "STRATA_HAS_PRIMITIVE_MAP"};

strata_result upload_buffer(upload *u, const char *name, const char *label, const void *data,
                            uint64_t size, strata_buffer *out, base_error *err) {
    if (size == 0)
        return STRATA_OK;
    strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = label, .size = size, .data = data};
    strata_result result = gpu_buffer_create(u->scope, &desc, out, err);
    if (result != STRATA_OK || !name)
        return result;
    strata_bind bind = {.struct_size = sizeof bind, .name = name, .buffer = *out};
    return gpu_set_global(u->g, name, &bind, err);
}

strata_result upload_image(upload *u, const char *name, strata_image image, base_error *err) {
    strata_bind bind = {.struct_size = sizeof bind, .name = name, .image = image};
    return image.id ? gpu_set_global(u->g, name, &bind, err) : STRATA_OK;
}

strata_result upload_define(upload *u, const char *name, int wanted, base_error *err) {
    return gpu_set_define(u->g, name, wanted ? "1" : NULL, err);
}

static void forget_names(gpu *g) {
    for (size_t i = 0; i < BASE_COUNT(global_names); i++)
        gpu_set_global(g, global_names[i], NULL, NULL);
    for (size_t i = 0; i < BASE_COUNT(define_names); i++)
        gpu_set_define(g, define_names[i], NULL, NULL);
}

/* Fisher and Yates over splitmix64: the same permutation everywhere for one seed. */
static void shuffle(uint32_t *items, uint32_t count, uint64_t seed) {
    for (uint32_t i = count; i > 1; i--) {
        seed += 0x9e3779b97f4a7c15u;
        uint64_t z = seed;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        z ^= z >> 31;
        uint32_t j = (uint32_t)(z % i), swap = items[i - 1];
        items[i - 1] = items[j];
        items[j] = swap;
    }
}

uint32_t *upload_permutation(uint32_t count, uint64_t seed) {
    uint32_t *items = base_calloc(count ? count : 1, sizeof *items);
    if (!items)
        return NULL;
    for (uint32_t i = 0; i < count; i++)
        items[i] = i;
    if (seed)
        shuffle(items, count, seed);
    return items;
}

static upload *allocate(gpu *g, const scene *s, const upload_options *options) {
    upload *u = base_calloc(1, sizeof *u);
    if (!u)
        return NULL;
    u->g = g;
    u->shuffle_seed = options->shuffle_seed;
    u->wants_objects = options->objects;
    u->mesh_count = s->mesh_count;
    u->instance_count = s->instance_count;
    u->material_count = s->material_count;
    u->meshes = base_calloc(s->mesh_count ? s->mesh_count : 1, sizeof *u->meshes);
    u->order = upload_permutation(s->instance_count, options->shuffle_seed);
    u->scope = gpu_scope_create(g, "scene");
    if (u->meshes && u->order && u->scope)
        return u;
    upload_free(u);
    return NULL;
}

strata_result upload_create(gpu *g, const scene *s, const upload_options *options, upload **out,
                            base_error *err) {
    *out = NULL;
    forget_names(g);
    upload *u = allocate(g, s, options);
    if (!u)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory to upload it",
                         s->path);
    strata_result result = upload_geometry(u, s, options->transparent, err);
    if (result == STRATA_OK)
        result = upload_materials(u, s, options->transparent, err);
    if (result == STRATA_OK)
        result = upload_lights(u, s, err);
    if (result == STRATA_OK)
        result = upload_records(u, s, err);
    if (result != STRATA_OK) {
        upload_free(u);
        return result;
    }
    *out = u;
    return STRATA_OK;
}

strata_result upload_update(upload *u, const scene *s, base_error *err) {
    if (s->mesh_count != u->mesh_count || s->instance_count != u->instance_count)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: not the scene that was uploaded",
                         s->path);
    strata_result result = upload_deformed(u, s, err);
    if (result == STRATA_OK)
        result = upload_lights(u, s, err);
    if (result == STRATA_OK)
        result = upload_records(u, s, err);
    return result;
}

upload_counts upload_count(const upload *u) {
    return (upload_counts){.lights = u->light_count,
                           .materials = u->material_count,
                           .records = u->record_count,
                           .textures = u->texture_count,
                           .opaque_draws = u->lists[0].count,
                           .transparent_draws = u->lists[1].count,
                           .opaque_triangles = u->lists[0].triangles,
                           .transparent_triangles = u->lists[1].triangles,
                           .objects = u->wants_objects ? u->record_count : 0};
}

strata_buffer upload_indices(const upload *u) {
    return u->indices;
}

uint64_t upload_bytes(const upload *u) {
    return gpu_bytes(u->g, "scene");
}

void upload_free(upload *u) {
    if (!u)
        return;
    forget_names(u->g);
    upload_draws_free(u);
    if (u->scope)
        gpu_scope_end(u->scope);
    free(u->meshes);
    free(u->clusters);
    free(u->record);
    free(u->object);
    free(u->order);
    free(u);
}
