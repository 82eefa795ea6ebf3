/* SPDX-License-Identifier: MIT
 *
 * Skins and morph targets on the CPU: undeformed vertices, weights and joint transforms to the
 * positions, normals and tangents that are drawn. Targets first, then joints, as glTF has it.
 */
#include "scene/animations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Adds weight * displacement of each target; width is that of the destination, displacements
 * have 3. */
static void morph(const scene_mesh *mesh, const float *targets, const float *weights, size_t width,
                  float *out) {
    size_t vertices = mesh->vertex_count;
    for (size_t t = 0; targets && t < mesh->deform->target_count; t++) {
        const float *displacement = targets + t * vertices * 3;
        if (weights[t] == 0.0f)
            continue;
        for (size_t v = 0; v < vertices; v++)
            for (size_t i = 0; i < 3; i++)
                out[v * width + i] += weights[t] * displacement[v * 3 + i];
    }
}

static void blend_joints(const scene_deform *d, size_t vertex, const float (*joints)[12],
                         float m[12]) {
    memset(m, 0, 12 * sizeof *m);
    for (size_t i = 0; i < d->influences; i++) {
        float weight = d->weights[vertex * d->influences + i];
        const float *joint = joints[d->joints[vertex * d->influences + i]];
        for (size_t k = 0; k < 12 && weight > 0.0f; k++)
            m[k] += weight * joint[k];
    }
}

/* m holds three columns and the translation, three floats each. */
static void transform_vector(const float m[12], const float v[3], float out[3]) {
    for (int row = 0; row < 3; row++)
        out[row] = m[row] * v[0] + m[3 + row] * v[1] + m[6 + row] * v[2];
}

/* Normals follow the cofactors of m, that is its inverse transpose up to a positive factor. */
static void transform_normal(const float m[12], const float v[3], float out[3]) {
    float c[9] = {
        m[4] * m[8] - m[5] * m[7], m[5] * m[6] - m[3] * m[8], m[3] * m[7] - m[4] * m[6],
        m[7] * m[2] - m[8] * m[1], m[8] * m[0] - m[6] * m[2], m[6] * m[1] - m[7] * m[0],
        m[1] * m[5] - m[2] * m[4], m[2] * m[3] - m[0] * m[5], m[0] * m[4] - m[1] * m[3],
    };
    float determinant = m[0] * c[0] + m[1] * c[1] + m[2] * c[2];
    float sign = determinant < 0.0f ? -1.0f : 1.0f;
    for (int row = 0; row < 3; row++)
        out[row] = sign * (c[row] * v[0] + c[3 + row] * v[1] + c[6 + row] * v[2]);
}

static void skin_vertices(scene_mesh *mesh, const float (*joints)[12]) {
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float m[12], moved[3];
        blend_joints(mesh->deform, v, joints, m);
        transform_vector(m, mesh->positions + v * 3, moved);
        for (size_t i = 0; i < 3; i++)
            mesh->positions[v * 3 + i] = moved[i] + m[9 + i];
        if (mesh->normals) {
            transform_normal(m, mesh->normals + v * 3, moved);
            memcpy(mesh->normals + v * 3, moved, sizeof moved);
        }
        if (mesh->tangents) {
            transform_vector(m, mesh->tangents + v * 4, moved);
            memcpy(mesh->tangents + v * 4, moved, sizeof moved);
        }
    }
}

static void normalize_all(float *vectors, size_t count, size_t width) {
    for (size_t i = 0; vectors && i < count; i++) {
        float *v = vectors + i * width;
        double length = sqrt((double)v[0] * (double)v[0] + (double)v[1] * (double)v[1] +
                             (double)v[2] * (double)v[2]);
        int fine = length > 0.0 && isfinite(length);
        for (size_t k = 0; k < 3; k++)
            v[k] = fine ? (float)((double)v[k] / length) : k == 2 ? 1.0f : 0.0f;
    }
}

/* World transform times inverse bind matrix of each joint; NULL when out of memory. */
static float (*joint_matrices(const scene_animations *a, const scene_skin *skin))[12] {
    float(*out)[12] = base_calloc(skin->joint_count, sizeof *out);
    for (uint32_t j = 0; out && j < skin->joint_count; j++) {
        double inverse[16], product[16];
        for (int i = 0; i < 16; i++)
            inverse[i] = skin->inverse ? (double)skin->inverse[(size_t)j * 16 + (size_t)i]
                                       : (i % 5 == 0 ? 1.0 : 0.0);
        scene_multiply(a->nodes[skin->joints[j]].world, inverse, product);
        for (int column = 0; column < 4; column++)
            for (int row = 0; row < 3; row++)
                out[j][column * 3 + row] = (float)product[column * 4 + row];
    }
    return out;
}

static strata_result deform_mesh(scene *s, const scene_animations *a, scene_mesh *mesh,
                                 base_error *err) {
    const scene_deform *d = mesh->deform;
    const scene_node *node = &a->nodes[mesh->node];
    size_t vertices = mesh->vertex_count;
    memcpy(mesh->positions, d->rest_positions, vertices * 3 * sizeof(float));
    if (d->rest_normals)
        memcpy(mesh->normals, d->rest_normals, vertices * 3 * sizeof(float));
    if (d->rest_tangents)
        memcpy(mesh->tangents, d->rest_tangents, vertices * 4 * sizeof(float));
    if (d->target_count > 0 && d->target_count <= node->weight_count) {
        morph(mesh, d->target_positions, node->weights, 3, mesh->positions);
        if (d->rest_normals)
            morph(mesh, d->target_normals, node->weights, 3, mesh->normals);
        if (d->rest_tangents)
            morph(mesh, d->target_tangents, node->weights, 4, mesh->tangents);
    }
    if (d->influences > 0) {
        float(*joints)[12] = joint_matrices(a, &a->skins[mesh->skin]);
        if (!joints)
            return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", s->path);
        skin_vertices(mesh, (const float(*)[12])joints);
        free(joints);
    }
    if (!d->rest_normals && mesh->normals)
        scene_flat_normals_update(mesh);
    normalize_all(mesh->normals, vertices, 3);
    normalize_all(mesh->tangents, vertices, 4);
    for (size_t i = 0; i < vertices * 3; i++)
        if (!isfinite(mesh->positions[i]))
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: mesh '%s': position %zu is not finite once deformed", s->path,
                             mesh->name, i / 3);
    scene_mesh_bounds(mesh);
    return STRATA_OK;
}

strata_result scene_deform_meshes(scene *s, const scene_animations *a, base_error *err) {
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < s->mesh_count && result == STRATA_OK; i++)
        if (s->meshes[i].deform)
            result = deform_mesh(s, a, &s->meshes[i], err);
    return result;
}
