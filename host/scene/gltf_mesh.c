/* SPDX-License-Identifier: MIT
 *
 * One glTF primitive as a scene mesh: strips and fans become triangle lists, attributes are read,
 * checked and mended where a picture is still possible without them. What deforms it is
 * gltf_deform.c.
 */
#include "scene/gltf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MODE_POINTS = 0, MODE_TRIANGLES = 4, MODE_STRIP = 5, MODE_FAN = 6 };

/* ---- attributes ------------------------------------------------------------------------------ */

uint32_t gltf_find(const gltf_attributes *attributes, const char *name) {
    for (uint32_t i = 0; i < attributes->count; i++)
        if (strcmp(attributes->items[i].name, name) == 0)
            return attributes->items[i].accessor;
    return SCENE_NONE;
}

strata_result gltf_read_attribute(gltf_loader *l, const gltf_attributes *attributes,
                                  const char *name, uint32_t width, uint32_t vertices,
                                  const char *place, float **out) {
    uint32_t accessor = gltf_find(attributes, name), count;
    char where[128];
    *out = NULL;
    if (accessor == SCENE_NONE)
        return STRATA_OK;
    snprintf(where, sizeof where, "%.96s: %.24s", place, name);
    strata_result result = gltf_read_floats(l, accessor, width, where, out, &count);
    if (result == STRATA_OK && count != vertices)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: accessors[%u] has %u elements, POSITION has %u", l->s->path,
                         where, accessor, count, vertices);
    return result;
}

void gltf_mend(gltf_loader *l, float *values, size_t count, const char *place, const char *name) {
    size_t bad = 0;
    for (size_t i = 0; i < count && values; i++)
        if (!isfinite(values[i])) {
            values[i] = 0.0f;
            bad++;
        }
    if (bad)
        scene_warn(l->s, "%s: %s: %s: %zu values are not finite: 0 taken", l->s->path, place, name,
                   bad);
}

static strata_result read_positions(gltf_loader *l, const gltf_primitive *p, const char *place,
                                    scene_mesh *mesh) {
    uint32_t accessor = gltf_find(&p->attributes, "POSITION");
    char where[128];
    snprintf(where, sizeof where, "%s: POSITION", place);
    strata_result result =
        gltf_read_floats(l, accessor, 3, where, &mesh->positions, &mesh->vertex_count);
    for (size_t i = 0; result == STRATA_OK && i < (size_t)mesh->vertex_count * 3; i++)
        if (!isfinite(mesh->positions[i]))
            return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: POSITION[%zu] is not finite",
                             l->s->path, place, i / 3);
    return result;
}

/* ---- normals and tangents -------------------------------------------------------------------- */

/* Scales v to unit length; 0 when it has none. In double: any finite float vector survives. */
static int normalize(float v[3]) {
    double length = sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] +
                         (double)v[2] * (double)v[2]);
    if (!(length > 0.0) || !isfinite(length))
        return 0;
    for (int i = 0; i < 3; i++)
        v[i] = (float)((double)v[i] / length);
    return 1;
}

/* The sum of a triangle's normals, weighted by area, added to those of its corners. */
static void add_face(const scene_mesh *mesh, const uint32_t *corner, double *sums) {
    double edge[2][3], n[3];
    for (size_t e = 0; e < 2; e++)
        for (size_t i = 0; i < 3; i++)
            edge[e][i] = (double)mesh->positions[(size_t)corner[e + 1] * 3 + i] -
                         (double)mesh->positions[(size_t)corner[0] * 3 + i];
    n[0] = edge[0][1] * edge[1][2] - edge[0][2] * edge[1][1];
    n[1] = edge[0][2] * edge[1][0] - edge[0][0] * edge[1][2];
    n[2] = edge[0][0] * edge[1][1] - edge[0][1] * edge[1][0];
    for (size_t c = 0; c < 3; c++)
        for (size_t i = 0; i < 3; i++)
            sums[(size_t)corner[c] * 3 + i] += n[i];
}

/* Replaces the marked normals by the average of the faces around; +z where that is nothing. */
static strata_result regenerate_normals(gltf_loader *l, scene_mesh *mesh,
                                        const unsigned char *bad) {
    double *sums = base_calloc(mesh->vertex_count, 3 * sizeof *sums);
    if (!sums)
        return gltf_no_memory(l);
    for (size_t i = 0; i + 2 < mesh->index_count; i += 3)
        add_face(mesh, mesh->indices + i, sums);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double *s = sums + v * 3, length = sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]);
        for (size_t i = 0; i < 3 && bad[v]; i++)
            mesh->normals[v * 3 + i] = length > 0.0 && isfinite(length) ? (float)(s[i] / length)
                                       : i == 2                         ? 1.0f
                                                                        : 0.0f;
    }
    free(sums);
    return STRATA_OK;
}

static strata_result read_normals(gltf_loader *l, const gltf_primitive *p, const char *place,
                                  scene_mesh *mesh) {
    strata_result result = gltf_read_attribute(l, &p->attributes, "NORMAL", 3, mesh->vertex_count,
                                               place, &mesh->normals);
    if (result != STRATA_OK || !mesh->normals)
        return result;
    size_t count = 0;
    unsigned char *bad = base_calloc(mesh->vertex_count, 1);
    if (!bad)
        return gltf_no_memory(l);
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        bad[i] = !normalize(mesh->normals + i * 3);
        count += bad[i];
    }
    if (count) {
        scene_warn(l->s, "%s: %s: NORMAL: %zu of %u are zero or not finite: made from the faces",
                   l->s->path, place, count, mesh->vertex_count);
        result = regenerate_normals(l, mesh, bad);
    }
    free(bad);
    return result;
}

static strata_result read_tangents(gltf_loader *l, const gltf_primitive *p, const char *place,
                                   scene_mesh *mesh) {
    if (!mesh->normals)
        return STRATA_OK; /* glTF: without normals, tangents are to be ignored */
    strata_result result = gltf_read_attribute(l, &p->attributes, "TANGENT", 4, mesh->vertex_count,
                                               place, &mesh->tangents);
    int fine = 1;
    for (size_t i = 0; result == STRATA_OK && mesh->tangents && i < mesh->vertex_count; i++) {
        float *tangent = mesh->tangents + i * 4;
        fine &= normalize(tangent) && isfinite(tangent[3]);
        tangent[3] = tangent[3] < 0.0f ? -1.0f : 1.0f;
    }
    if (!fine) {
        scene_warn(l->s, "%s: %s: TANGENT: zero or not finite: derived instead", l->s->path, place);
        free(mesh->tangents);
        mesh->tangents = NULL;
    }
    return result;
}

/* ---- the other attributes -------------------------------------------------------------------- */

static strata_result read_uv(gltf_loader *l, const gltf_primitive *p, const char *place,
                             const char *name, uint32_t vertices, float **out) {
    strata_result result = gltf_read_attribute(l, &p->attributes, name, 2, vertices, place, out);
    if (result == STRATA_OK)
        gltf_mend(l, *out, (size_t)vertices * 2, place, name);
    return result;
}

static strata_result read_colors(gltf_loader *l, const gltf_primitive *p, const char *place,
                                 scene_mesh *mesh) {
    uint32_t accessor = gltf_find(&p->attributes, "COLOR_0");
    if (accessor == SCENE_NONE)
        return STRATA_OK;
    uint32_t width = l->file.accessors[accessor].width == 3 ? 3 : 4;
    size_t vertices = mesh->vertex_count;
    float *read, *wide;
    strata_result result =
        gltf_read_attribute(l, &p->attributes, "COLOR_0", width, mesh->vertex_count, place, &read);
    if (result != STRATA_OK || !read || width == 4) {
        mesh->colors = read;
    } else {
        mesh->colors = wide = base_calloc(vertices, 4 * sizeof *wide);
        for (size_t i = 0; wide && i < vertices; i++) {
            memcpy(wide + i * 4, read + i * 3, 3 * sizeof *wide);
            wide[i * 4 + 3] = 1.0f;
        }
        free(read);
        result = wide ? STRATA_OK : gltf_no_memory(l);
    }
    if (result != STRATA_OK || !mesh->colors)
        return result;
    gltf_mend(l, mesh->colors, vertices * 4, place, "COLOR_0");
    for (size_t i = 0; i < vertices * 4; i++) {
        mesh->colors[i] = fmaxf(mesh->colors[i], 0.0f);
        if (i % 4 == 3)
            mesh->colors[i] = fminf(mesh->colors[i], 1.0f);
    }
    return STRATA_OK;
}

static strata_result read_radii(gltf_loader *l, const gltf_primitive *p, const char *place,
                                scene_mesh *mesh) {
    if (mesh->topology != SCENE_POINTS)
        return STRATA_OK;
    strata_result result = gltf_read_attribute(l, &p->attributes, "_RADIUS", 1, mesh->vertex_count,
                                               place, &mesh->radii);
    if (result != STRATA_OK || !mesh->radii)
        return result;
    gltf_mend(l, mesh->radii, mesh->vertex_count, place, "_RADIUS");
    for (size_t i = 0; i < mesh->vertex_count; i++)
        mesh->radii[i] = fmaxf(mesh->radii[i], 0.0f);
    return STRATA_OK;
}

/* ---- topology -------------------------------------------------------------------------------- */

/* Vertices in the order drawn: the indices, or 0, 1, 2, ... */
static strata_result read_order(gltf_loader *l, const gltf_primitive *p, const char *place,
                                uint32_t vertices, uint32_t **order, uint32_t *count) {
    char where[128];
    snprintf(where, sizeof where, "%s: indices", place);
    if (p->indices == SCENE_NONE) {
        strata_result result = gltf_charge(l, where, vertices, sizeof **order);
        if (result != STRATA_OK)
            return result;
        *order = base_calloc(vertices, sizeof **order);
        *count = vertices;
        for (uint32_t i = 0; *order && i < vertices; i++)
            (*order)[i] = i;
        return *order ? STRATA_OK : gltf_no_memory(l);
    }
    strata_result result = gltf_read_integers(l, p->indices, 1, where, order, count);
    for (uint32_t i = 0; result == STRATA_OK && i < *count; i++)
        if ((*order)[i] >= vertices)
            return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                             "%s: %s: indices[%u] is %u of %u vertices", l->s->path, place, i,
                             (*order)[i], vertices);
    return result;
}

/* A strip or fan of `count` vertices as a list, wound as glTF has it. */
static strata_result expand_triangles(gltf_loader *l, uint32_t mode, const char *place,
                                      const uint32_t *order, uint32_t count, scene_mesh *mesh) {
    uint64_t triangles = (uint64_t)count - 2;
    if (triangles * 3 > UINT32_MAX)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: has 2^32 or more indices",
                         l->s->path, place);
    strata_result result = gltf_charge(l, place, triangles * 3, sizeof *mesh->indices);
    if (result != STRATA_OK)
        return result;
    mesh->indices = base_calloc((size_t)triangles * 3, sizeof *mesh->indices);
    if (!mesh->indices)
        return gltf_no_memory(l);
    mesh->index_count = (uint32_t)triangles * 3;
    for (size_t t = 0; t < triangles; t++) {
        uint32_t *corner = mesh->indices + t * 3;
        corner[0] = mode == MODE_FAN ? order[t + 1] : order[t];
        corner[1] = mode == MODE_FAN ? order[t + 2] : order[t + 1 + t % 2];
        corner[2] = mode == MODE_FAN ? order[0] : order[t + 2 - t % 2];
    }
    return STRATA_OK;
}

static strata_result read_topology(gltf_loader *l, const gltf_primitive *p, const char *place,
                                   scene_mesh *mesh) {
    uint32_t *order = NULL, count = 0;
    strata_result result = read_order(l, p, place, mesh->vertex_count, &order, &count);
    if (result == STRATA_OK && (p->mode == MODE_STRIP || p->mode == MODE_FAN)) {
        result = expand_triangles(l, p->mode, place, order, count, mesh);
    } else if (result == STRATA_OK) {
        mesh->indices = order;
        mesh->index_count = count;
        order = NULL;
        if (p->mode == MODE_TRIANGLES && count % 3 != 0) {
            scene_warn(l->s, "%s: %s: %u indices are not whole triangles: the last %u ignored",
                       l->s->path, place, count, count % 3);
            mesh->index_count = count - count % 3;
        }
    }
    free(order);
    return result;
}

/* ---- the primitive --------------------------------------------------------------------------- */

/* Is there something to draw? Otherwise a warning says why not. */
static int drawable(gltf_loader *l, const gltf_primitive *p, const char *place) {
    uint32_t positions = gltf_find(&p->attributes, "POSITION");
    if (p->mode > MODE_POINTS && p->mode < MODE_TRIANGLES) {
        scene_warn(l->s, "%s: %s: lines are not drawn", l->s->path, place);
        return 0;
    }
    if (positions == SCENE_NONE) {
        scene_warn(l->s, "%s: %s: has no POSITION: not drawn", l->s->path, place);
        return 0;
    }
    uint32_t counts = p->indices != SCENE_NONE ? p->indices : positions;
    if (l->file.accessors[counts].count < (p->mode == MODE_POINTS ? 1u : 3u)) {
        scene_warn(l->s, "%s: %s: is empty: not drawn", l->s->path, place);
        return 0;
    }
    return 1;
}

static strata_result read_attributes(gltf_loader *l, const gltf_primitive *p, const char *place,
                                     scene_mesh *mesh) {
    strata_result result = STRATA_OK;
    if (mesh->topology == SCENE_TRIANGLES)
        result = read_normals(l, p, place, mesh);
    if (result == STRATA_OK)
        result = read_tangents(l, p, place, mesh);
    if (result == STRATA_OK)
        result = read_uv(l, p, place, "TEXCOORD_0", mesh->vertex_count, &mesh->uv0);
    if (result == STRATA_OK)
        result = read_uv(l, p, place, "TEXCOORD_1", mesh->vertex_count, &mesh->uv1);
    if (result == STRATA_OK)
        result = read_colors(l, p, place, mesh);
    if (result == STRATA_OK)
        result = read_radii(l, p, place, mesh);
    return result;
}

strata_result gltf_read_primitive(gltf_loader *l, uint32_t mesh_index, uint32_t primitive,
                                  uint32_t skin, uint32_t node, uint32_t *out) {
    const gltf_mesh *from = &l->file.meshes[mesh_index];
    const gltf_primitive *p = &from->primitives[primitive];
    char place[96];
    int wrote = snprintf(place, sizeof place, "meshes[%u]", mesh_index);
    if (from->name)
        wrote += snprintf(place + wrote, sizeof place - (size_t)wrote, " '%.40s'", from->name);
    snprintf(place + wrote, sizeof place - (size_t)wrote, " primitive %u", primitive);

    *out = SCENE_NONE;
    if (!drawable(l, p, place))
        return STRATA_OK;
    scene_mesh *mesh = scene_add_mesh(l->s, &l->mesh_capacity);
    if (!mesh)
        return gltf_no_memory(l);
    mesh->name = from->name ? base_format("%s/%u", from->name, primitive)
                            : base_format("mesh %u/%u", mesh_index, primitive);
    if (!mesh->name)
        return gltf_no_memory(l);
    mesh->material = p->material;
    mesh->topology = p->mode == MODE_POINTS ? SCENE_POINTS : SCENE_TRIANGLES;
    strata_result result = read_positions(l, p, place, mesh);
    if (result == STRATA_OK)
        result = read_topology(l, p, place, mesh);
    if (result == STRATA_OK)
        result = read_attributes(l, p, place, mesh);
    if (result == STRATA_OK)
        result = gltf_read_deform(l, p, skin, node, place, mesh);
    if (result == STRATA_OK && mesh->topology == SCENE_TRIANGLES && !mesh->normals)
        result = scene_flat_normals(mesh, l->err);
    *out = l->s->mesh_count - 1;
    return result;
}
