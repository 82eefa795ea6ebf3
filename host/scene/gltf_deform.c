/* SPDX-License-Identifier: MIT
 *
 * What deforms a glTF primitive: joints and weights of a skin, morph targets, and the undeformed
 * copies that each evaluation starts from (deform.c evaluates).
 */
#include "scene/gltf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Puts four of the influences of each vertex into place; joints are checked against the skin. */
static strata_result read_influences(gltf_loader *l, const gltf_primitive *p, uint32_t skin,
                                     uint32_t set, const char *place, scene_mesh *mesh) {
    scene_deform *d = mesh->deform;
    char name[2][16], where[128];
    uint32_t *joints = NULL, joint_count = 0, known = l->file.skins[skin].joint_count;
    float *weights = NULL;
    snprintf(name[0], sizeof name[0], "JOINTS_%u", set);
    snprintf(name[1], sizeof name[1], "WEIGHTS_%u", set);
    snprintf(where, sizeof where, "%s: %s", place, name[0]);
    strata_result result =
        gltf_read_integers(l, gltf_find(&p->attributes, name[0]), 4, where, &joints, &joint_count);
    if (result == STRATA_OK && joint_count != mesh->vertex_count)
        result = base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s has %u elements, POSITION has %u",
                           l->s->path, where, joint_count, mesh->vertex_count);
    if (result == STRATA_OK)
        result =
            gltf_read_attribute(l, &p->attributes, name[1], 4, mesh->vertex_count, place, &weights);
    for (size_t i = 0; result == STRATA_OK && i < (size_t)mesh->vertex_count * 4; i++) {
        size_t at = i / 4 * d->influences + (size_t)set * 4 + i % 4;
        int used = isfinite(weights[i]) && weights[i] > 0.0f;
        if (used && joints[i] >= known)
            result = base_fail(l->err, STRATA_ERROR_BAD_FILE,
                               "%s: %s[%zu] is joint %u, skins[%u] has %u", l->s->path, where,
                               i / 4, joints[i], skin, known);
        d->joints[at] = used ? (uint16_t)joints[i] : 0;
        d->weights[at] = used ? weights[i] : 0.0f;
    }
    free(joints);
    free(weights);
    return result;
}

/* Weights that sum to 1; a vertex without any hangs on its first joint. */
static void normalize_weights(gltf_loader *l, const char *place, scene_mesh *mesh) {
    scene_deform *d = mesh->deform;
    size_t lost = 0;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        float *weights = d->weights + v * d->influences;
        double sum = 0.0;
        for (size_t i = 0; i < d->influences; i++)
            sum += (double)weights[i];
        lost += !(sum > 0.0);
        for (size_t i = 0; i < d->influences; i++)
            weights[i] = sum > 0.0 ? (float)((double)weights[i] / sum) : i == 0 ? 1.0f : 0.0f;
    }
    if (lost)
        scene_warn(l->s, "%s: %s: WEIGHTS_0: %zu vertices have no weight", l->s->path, place, lost);
}

static strata_result read_skin(gltf_loader *l, const gltf_primitive *p, uint32_t skin,
                               const char *place, scene_mesh *mesh) {
    scene_deform *d = mesh->deform;
    if (gltf_find(&p->attributes, "JOINTS_0") == SCENE_NONE ||
        gltf_find(&p->attributes, "WEIGHTS_0") == SCENE_NONE) {
        scene_warn(l->s, "%s: %s: has a skin but no JOINTS_0 and WEIGHTS_0: not skinned",
                   l->s->path, place);
        return STRATA_OK;
    }
    int more = gltf_find(&p->attributes, "JOINTS_1") != SCENE_NONE &&
               gltf_find(&p->attributes, "WEIGHTS_1") != SCENE_NONE;
    if (l->file.skins[skin].joint_count == 0 || l->file.skins[skin].joint_count > UINT16_MAX + 1u)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: skins[%u].joints: %u joints, 1..65536",
                         l->s->path, skin, l->file.skins[skin].joint_count);
    d->influences = more ? 8 : 4;
    strata_result result = gltf_charge(l, place, mesh->vertex_count, d->influences * 6ull);
    if (result != STRATA_OK)
        return result;
    d->joints = base_calloc(mesh->vertex_count, d->influences * sizeof *d->joints);
    d->weights = base_calloc(mesh->vertex_count, d->influences * sizeof *d->weights);
    if (!d->joints || !d->weights)
        return gltf_no_memory(l);
    result = read_influences(l, p, skin, 0, place, mesh);
    if (result == STRATA_OK && more)
        result = read_influences(l, p, skin, 1, place, mesh);
    if (result == STRATA_OK)
        normalize_weights(l, place, mesh);
    mesh->skin = skin;
    return result;
}

/* One attribute of every target into *out, allocated when the first target has it. */
static strata_result read_targets(gltf_loader *l, const gltf_primitive *p, const char *name,
                                  const char *place, scene_mesh *mesh, float **out) {
    size_t floats = (size_t)mesh->vertex_count * 3;
    for (uint32_t t = 0; t < p->target_count; t++) {
        float *read;
        char where[112];
        if (gltf_find(&p->targets[t], name) == SCENE_NONE)
            continue;
        snprintf(where, sizeof where, "%s target %u", place, t);
        strata_result result =
            gltf_read_attribute(l, &p->targets[t], name, 3, mesh->vertex_count, where, &read);
        if (result == STRATA_OK && !*out)
            result = gltf_charge(l, where, p->target_count, floats * sizeof **out);
        if (result == STRATA_OK && !*out) {
            *out = base_calloc(p->target_count, floats * sizeof **out);
            result = *out ? STRATA_OK : gltf_no_memory(l);
        }
        if (result != STRATA_OK || !read || !*out) {
            free(read);
            return result;
        }
        gltf_mend(l, read, floats, where, name);
        memcpy(*out + t * floats, read, floats * sizeof *read);
        free(read);
    }
    return STRATA_OK;
}

static float *copy_of(const float *values, size_t count, int *failed) {
    if (!values)
        return NULL;
    float *copy = base_calloc(count, sizeof *copy);
    if (copy)
        memcpy(copy, values, count * sizeof *copy);
    *failed |= copy == NULL;
    return copy;
}

static strata_result keep_rest(gltf_loader *l, const char *place, scene_mesh *mesh) {
    scene_deform *d = mesh->deform;
    size_t vertices = mesh->vertex_count;
    int failed = 0;
    strata_result result = gltf_charge(l, place, vertices, 10 * sizeof(float));
    if (result != STRATA_OK)
        return result;
    d->rest_positions = copy_of(mesh->positions, vertices * 3, &failed);
    d->rest_normals = copy_of(mesh->normals, vertices * 3, &failed);
    d->rest_tangents = copy_of(mesh->tangents, vertices * 4, &failed);
    return failed ? gltf_no_memory(l) : STRATA_OK;
}

strata_result gltf_read_deform(gltf_loader *l, const gltf_primitive *p, uint32_t skin,
                               uint32_t node, const char *place, scene_mesh *mesh) {
    if (skin == SCENE_NONE && p->target_count == 0)
        return STRATA_OK;
    scene_deform *d = mesh->deform = base_calloc(1, sizeof *d);
    if (!d)
        return gltf_no_memory(l);
    mesh->node = node;
    strata_result result = STRATA_OK;
    if (skin != SCENE_NONE)
        result = read_skin(l, p, skin, place, mesh);
    d->target_count = p->target_count;
    if (result == STRATA_OK)
        result = read_targets(l, p, "POSITION", place, mesh, &d->target_positions);
    if (result == STRATA_OK && mesh->normals)
        result = read_targets(l, p, "NORMAL", place, mesh, &d->target_normals);
    if (result == STRATA_OK && mesh->tangents)
        result = read_targets(l, p, "TANGENT", place, mesh, &d->target_tangents);
    if (result == STRATA_OK)
        result = keep_rest(l, place, mesh);
    return result;
}
