/* SPDX-License-Identifier: MIT
 *
 * Vertex streams and indices: which streams each mesh needs for its material, where it stands in
 * them, and their contents, the meshes one after another. Points become quads of six indices, whose
 * vertices number 4 * point + corner.
 */
#include "scene/upload_internal.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

typedef struct stream_info {
    const char *global, *label;
    uint32_t flag, width; /* of the record; floats a vertex */
} stream_info;

static const stream_info infos[UPLOAD_STREAMS] = {
    [UPLOAD_POSITION] = {"StrataPositions", "positions", 0, 3},
    [UPLOAD_NORMAL] = {"StrataNormals", "normals", UPLOAD_NORMALS, 3},
    [UPLOAD_TANGENT] = {"StrataTangents", "tangents", UPLOAD_TANGENTS, 4},
    [UPLOAD_STREAM_UV0] = {"StrataUv0", "texture coordinates", UPLOAD_UV0, 2},
    [UPLOAD_STREAM_UV1] = {"StrataUv1", "second texture coordinates", UPLOAD_UV1, 2},
    [UPLOAD_COLOR] = {"StrataColors", "vertex colours", UPLOAD_COLORS, 4},
    [UPLOAD_RADIUS] = {"StrataRadii", "splat radii", UPLOAD_RADII, 1},
};

static const float *stream_data(const scene_mesh *mesh, upload_stream stream) {
    switch (stream) {
    case UPLOAD_POSITION:
        return mesh->positions;
    case UPLOAD_NORMAL:
        return mesh->normals;
    case UPLOAD_TANGENT:
        return mesh->tangents;
    case UPLOAD_STREAM_UV0:
        return mesh->uv0;
    case UPLOAD_STREAM_UV1:
        return mesh->uv1;
    case UPLOAD_COLOR:
        return mesh->colors;
    case UPLOAD_RADIUS:
        return mesh->radii;
    default:
        return NULL;
    }
}

static int has_stream(const upload_mesh *layout, upload_stream stream) {
    return layout->used && (stream == UPLOAD_POSITION || (layout->flags & infos[stream].flag));
}

/* ---- layout ---------------------------------------------------------------------------------- */

static uint32_t mesh_flags(const scene_mesh *mesh, const scene_material *material) {
    uint32_t flags = 0;
    for (uint32_t slot = 0; slot < UPLOAD_SLOTS; slot++) {
        int colour;
        const scene_texture *t = upload_slot(material, slot, &colour);
        if (t->image != SCENE_NONE && t->uv == 0 && mesh->uv0)
            flags |= UPLOAD_UV0;
        if (t->image != SCENE_NONE && t->uv == 1 && mesh->uv1)
            flags |= UPLOAD_UV1;
    }
    if (mesh->normals && !material->unlit)
        flags |= UPLOAD_NORMALS;
    if (mesh->tangents && (flags & UPLOAD_NORMALS) && material->normal_texture.image != SCENE_NONE)
        flags |= UPLOAD_TANGENTS;
    if (mesh->colors)
        flags |= UPLOAD_COLORS;
    if (mesh->topology == SCENE_POINTS)
        flags |= UPLOAD_SPLATS | UPLOAD_DOUBLE_SIDED | (mesh->radii ? UPLOAD_RADII : 0u);
    if (material->double_sided)
        flags |= UPLOAD_DOUBLE_SIDED;
    if (material->unlit)
        flags |= UPLOAD_UNLIT;
    if (material->alpha == SCENE_MASK)
        flags |= UPLOAD_MASK;
    if (material->alpha == SCENE_BLEND)
        flags |= UPLOAD_BLEND;
    return flags;
}

static strata_result fail_size(const scene *s, const char *what, uint64_t bytes, uint64_t limit,
                               base_error *err) {
    return base_fail(err, STRATA_ERROR_OVERFLOW,
                     "%s: its %s take %" PRIu64 " MB, and this device binds at most %" PRIu64
                     " MB at a time",
                     s->path, what, (bytes + 999999u) / 1000000u, limit / 1000000u);
}

/* Numbers every mesh's first vertex in each stream; counts[] are the streams' vertices. */
static strata_result lay_out_streams(upload *u, const scene *s, uint64_t counts[UPLOAD_STREAMS],
                                     base_error *err) {
    uint64_t limit = gpu_fact(u->g, "limit.storage_range");
    for (int stream = 0; stream < UPLOAD_STREAMS; stream++) {
        counts[stream] = 0;
        for (uint32_t i = 0; i < s->mesh_count; i++) {
            if (!has_stream(&u->meshes[i], (upload_stream)stream))
                continue;
            u->meshes[i].first[stream] = (uint32_t)counts[stream];
            counts[stream] += s->meshes[i].vertex_count;
        }
        uint64_t bytes = counts[stream] * infos[stream].width * sizeof(float);
        if (counts[stream] * infos[stream].width > UINT32_MAX || (limit && bytes > limit))
            return fail_size(s, infos[stream].label, bytes, limit, err);
    }
    return STRATA_OK;
}

static strata_result lay_out_indices(upload *u, const scene *s, uint64_t *indices,
                                     uint64_t *primitives, base_error *err) {
    *indices = *primitives = 0;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        upload_mesh *layout = &u->meshes[i];
        const scene_mesh *mesh = &s->meshes[i];
        if (!layout->used)
            continue;
        int points = mesh->topology == SCENE_POINTS;
        uint64_t count = points ? (uint64_t)mesh->index_count * 6 : mesh->index_count;
        if (*indices + count > UINT32_MAX || (points && mesh->vertex_count > UINT32_MAX / 4))
            return base_fail(err, STRATA_ERROR_OVERFLOW,
                             "%s: mesh '%s': the scene has 2^32 or more indices", s->path,
                             mesh->name);
        layout->first_index = (uint32_t)*indices;
        layout->index_count = (uint32_t)count;
        layout->primitive_map = SCENE_NONE;
        *indices += count;
        if (u->shuffle_seed || layout->cluster_count > 1) {
            layout->primitive_map = (uint32_t)*primitives;
            *primitives += points ? mesh->index_count : mesh->index_count / 3;
        }
    }
    return STRATA_OK;
}

/* ---- contents -------------------------------------------------------------------------------- */

static strata_result fill_stream(upload *u, const scene *s, upload_stream stream, uint64_t count,
                                 base_error *err) {
    const stream_info *info = &infos[stream];
    uint32_t meshes = 0;
    const float *data = NULL;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        if (has_stream(&u->meshes[i], stream)) {
            data = stream_data(&s->meshes[i], stream);
            meshes++;
        }
    static const float nowhere[3];
    if (count == 0 && stream != UPLOAD_POSITION)
        return STRATA_OK;
    if (count == 0) { /* empty lists are drawn all the same, and bind what they do not read */
        data = nowhere;
        count = 1;
    }
    float *joined = NULL;
    if (meshes > 1) { /* one mesh needs no copy */
        joined = base_calloc((size_t)count, info->width * sizeof *joined);
        if (!joined)
            return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for its %s",
                             s->path, info->label);
        for (uint32_t i = 0; i < s->mesh_count; i++)
            if (has_stream(&u->meshes[i], stream) && s->meshes[i].vertex_count)
                memcpy(joined + (size_t)u->meshes[i].first[stream] * info->width,
                       stream_data(&s->meshes[i], stream),
                       (size_t)s->meshes[i].vertex_count * info->width * sizeof *joined);
        data = joined;
    }
    strata_result result =
        upload_buffer(u, info->global, info->label, data, count * info->width * sizeof(float),
                      &u->streams[stream], err);
    free(joined);
    return result;
}

static void write_point(uint32_t *out, uint32_t vertex) {
    static const uint32_t corners[6] = {0, 1, 2, 2, 1, 3};
    for (int i = 0; i < 6; i++)
        out[i] = vertex * 4 + corners[i];
}

/* Indices of one mesh; with a seed, or in clusters, in another order, which map[] undoes. */
static strata_result fill_mesh_indices(const upload *u, const scene_mesh *mesh,
                                       const upload_mesh *layout, uint32_t number,
                                       uint32_t *indices, uint32_t *map, base_error *err) {
    uint32_t *out = indices + layout->first_index;
    int points = mesh->topology == SCENE_POINTS;
    uint32_t count = points ? mesh->index_count : mesh->index_count / 3;
    uint32_t *order = NULL;
    if (layout->primitive_map != SCENE_NONE) {
        uint64_t seed = u->shuffle_seed ? ((uint64_t)u->shuffle_seed << 32) + number + 1 : 0;
        order = upload_permutation(count, seed);
        strata_result r =
            order ? upload_cluster_order(mesh, layout, order, err)
                  : base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for an order");
        if (r != STRATA_OK) {
            free(order);
            return r;
        }
        memcpy(map + layout->primitive_map, order, count * sizeof *map);
    }
    for (uint32_t i = 0; i < count; i++) {
        uint32_t from = order ? order[i] : i;
        if (points)
            write_point(out + (size_t)i * 6, mesh->indices[from]);
        else
            memcpy(out + (size_t)i * 3, mesh->indices + (size_t)from * 3, 3 * sizeof *out);
    }
    free(order);
    return STRATA_OK;
}

static strata_result fill_indices(upload *u, const scene *s, base_error *err) {
    uint64_t count = 0, primitives = 0, limit = gpu_fact(u->g, "limit.storage_range");
    strata_result result = lay_out_indices(u, s, &count, &primitives, err);
    if (result != STRATA_OK)
        return result;
    if (limit && primitives * sizeof(uint32_t) > limit)
        return fail_size(s, "shuffled primitives", primitives * sizeof(uint32_t), limit, err);
    /* A scene without any has one index, so that its empty lists can be drawn. */
    uint32_t *indices = base_calloc(count ? (size_t)count : 1, sizeof *indices);
    uint32_t *map = base_calloc(primitives ? (size_t)primitives : 1, sizeof *map);
    if (!indices || !map)
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for its indices",
                           s->path);
    for (uint32_t i = 0; i < s->mesh_count && result == STRATA_OK; i++) {
        if (!u->meshes[i].used)
            continue;
        result = fill_mesh_indices(u, &s->meshes[i], &u->meshes[i], i, indices, map, err);
        if (result == STRATA_OK)
            upload_cluster_bounds(u, &s->meshes[i], &u->meshes[i], indices);
    }
    if (result == STRATA_OK)
        result = upload_buffer(u, NULL, "indices", indices, (count ? count : 1) * sizeof *indices,
                               &u->indices, err);
    strata_buffer map_buffer = {0};
    if (result == STRATA_OK)
        result = upload_buffer(u, "StrataPrimitiveMap", "primitive map", map,
                               primitives * sizeof *map, &map_buffer, err);
    if (result == STRATA_OK)
        result = upload_define(u, "STRATA_HAS_PRIMITIVE_MAP", primitives > 0, err);
    free(indices);
    free(map);
    return result;
}

static strata_result define_features(upload *u, const scene *s, base_error *err) {
    uint32_t any = 0, single = 0, emission = 0, transmission = 0;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        const scene_material *m = &s->materials[s->meshes[i].material];
        if (!u->meshes[i].used)
            continue;
        any |= u->meshes[i].flags;
        single |= !(u->meshes[i].flags & UPLOAD_DOUBLE_SIDED);
        transmission |= u->meshes[i].transparent && m->transmission > 0.0f && !m->unlit;
        emission |= !m->unlit &&
                    (m->emissive[0] != 0.0f || m->emissive[1] != 0.0f || m->emissive[2] != 0.0f);
    }
    const struct {
        const char *name;
        uint32_t wanted;
    } features[] = {
        {"STRATA_HAS_LIT", any & UPLOAD_NORMALS},   {"STRATA_HAS_TANGENTS", any & UPLOAD_TANGENTS},
        {"STRATA_HAS_UV0", any & UPLOAD_UV0},       {"STRATA_HAS_UV1", any & UPLOAD_UV1},
        {"STRATA_HAS_COLORS", any & UPLOAD_COLORS}, {"STRATA_HAS_POINTS", any & UPLOAD_SPLATS},
        {"STRATA_HAS_RADII", any & UPLOAD_RADII},   {"STRATA_HAS_MASK", any & UPLOAD_MASK},
        {"STRATA_HAS_BLEND", any & UPLOAD_BLEND},   {"STRATA_HAS_SINGLE_SIDED", single},
        {"STRATA_HAS_EMISSION", emission},          {"STRATA_HAS_TRANSMISSION", transmission},
    };
    strata_result result = STRATA_OK;
    for (size_t i = 0; i < BASE_COUNT(features) && result == STRATA_OK; i++)
        result = upload_define(u, features[i].name, features[i].wanted != 0, err);
    return result;
}

strata_result upload_geometry(upload *u, const scene *s, const unsigned char *transparent,
                              base_error *err) {
    for (uint32_t i = 0; i < s->instance_count; i++)
        u->meshes[s->instances[i].mesh].used = s->meshes[s->instances[i].mesh].index_count > 0;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        const scene_material *material = &s->materials[s->meshes[i].material];
        u->meshes[i].flags = mesh_flags(&s->meshes[i], material);
        u->meshes[i].transparent = transparent && transparent[s->meshes[i].material];
        if (!u->meshes[i].transparent)
            u->meshes[i].flags &= ~UPLOAD_BLEND;
    }
    uint64_t counts[UPLOAD_STREAMS];
    strata_result result = upload_clusters(u, s, err);
    if (result == STRATA_OK)
        result = lay_out_streams(u, s, counts, err);
    for (int stream = 0; stream < UPLOAD_STREAMS && result == STRATA_OK; stream++)
        result = fill_stream(u, s, (upload_stream)stream, counts[stream], err);
    if (result == STRATA_OK)
        result = fill_indices(u, s, err);
    if (result == STRATA_OK)
        result = define_features(u, s, err);
    return result;
}

strata_result upload_deformed(upload *u, const scene *s, base_error *err) {
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        const scene_mesh *mesh = &s->meshes[i];
        if (!mesh->deform || !mesh->vertex_count)
            continue;
        for (int stream = UPLOAD_POSITION; stream <= UPLOAD_TANGENT; stream++) {
            if (result != STRATA_OK || !has_stream(&u->meshes[i], (upload_stream)stream))
                continue;
            uint64_t vertex = infos[stream].width * sizeof(float);
            result = gpu_buffer_write(u->g, u->streams[stream], u->meshes[i].first[stream] * vertex,
                                      mesh->vertex_count * vertex,
                                      stream_data(mesh, (upload_stream)stream), err);
        }
    }
    return result;
}
