/* SPDX-License-Identifier: MIT
 *
 * Objects, what techniques may cull one by one: an instance of a mesh, or of one of its clusters.
 * Clusters are runs of 64 to 128 triangles that lie together in space; their bounds are those of
 * the vertices themselves, without any rounding.
 */
#include "scene/upload_internal.h"

#include <inttypes.h>
#include <meshoptimizer.h>
#include <stdlib.h>
#include <string.h>

#define CLUSTER_TRIANGLES 128u       /* at most */
#define MAX_OBJECTS       (1u << 20) /* beyond, meshes of several instances stay whole */

/* A mesh that deforms is one object, with the bounds of its pose. */
static uint32_t clusters_of(const scene_mesh *mesh) {
    const uint32_t triangles = mesh->index_count / 3;
    if (mesh->topology != SCENE_TRIANGLES || mesh->deform || triangles <= CLUSTER_TRIANGLES)
        return 1;
    return (triangles + CLUSTER_TRIANGLES - 1) / CLUSTER_TRIANGLES;
}

/* Clusters of each mesh that is used, and how many objects that makes. */
static uint64_t divide(upload *u, const scene *s, const uint32_t *instances, int whole) {
    uint64_t objects = 0;
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        upload_mesh *layout = &u->meshes[i];
        layout->cluster_count = layout->used;
        if (layout->used && u->wants_objects && !(whole && instances[i] > 1))
            layout->cluster_count = clusters_of(&s->meshes[i]);
        objects += (uint64_t)layout->cluster_count * instances[i];
    }
    return objects;
}

strata_result upload_clusters(upload *u, const scene *s, base_error *err) {
    uint32_t *instances = base_calloc(s->mesh_count ? s->mesh_count : 1, sizeof *instances);
    if (!instances)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for its clusters",
                         s->path);
    for (uint32_t i = 0; i < s->instance_count; i++)
        instances[s->instances[i].mesh]++;
    uint64_t objects = divide(u, s, instances, 0);
    if (objects > MAX_OBJECTS)
        objects = divide(u, s, instances, 1);
    free(instances);
    if (objects > UINT32_MAX)
        return base_fail(err, STRATA_ERROR_OVERFLOW, "%s: %" PRIu64 " objects are too many",
                         s->path, objects);
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        u->meshes[i].first_cluster = u->cluster_count;
        u->cluster_count += u->meshes[i].cluster_count;
    }
    u->record_capacity = objects ? (uint32_t)objects : 1;
    u->clusters = base_calloc(u->cluster_count ? u->cluster_count : 1, sizeof *u->clusters);
    u->record = base_calloc(u->record_capacity, sizeof *u->record);
    if (u->wants_objects)
        u->object = base_calloc(u->record_capacity, sizeof *u->object);
    if (!u->clusters || !u->record || (u->wants_objects && !u->object))
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for its clusters",
                         s->path);
    return STRATA_OK;
}

/* By the order of their middles along a space-filling curve. */
strata_result upload_cluster_order(const scene_mesh *mesh, const upload_mesh *layout,
                                   uint32_t *order, base_error *err) {
    const uint32_t count = mesh->index_count / 3;
    if (layout->cluster_count <= 1)
        return STRATA_OK;
    float *middles = base_calloc(count, 3 * sizeof *middles);
    uint32_t *place = base_calloc(count, sizeof *place),
             *sorted = base_calloc(count, sizeof *place);
    strata_result result = STRATA_OK;
    if (!middles || !place || !sorted) {
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY,
                           "mesh '%s': no memory for its clusters", mesh->name);
        goto cleanup;
    }
    for (uint32_t i = 0; i < count; i++)
        for (uint32_t corner = 0; corner < 3; corner++)
            for (uint32_t axis = 0; axis < 3; axis++)
                middles[i * 3 + axis] +=
                    mesh->positions[mesh->indices[order[i] * 3 + corner] * (size_t)3 + axis] / 3.0f;
    meshopt_spatialSortRemap(place, middles, count, 3 * sizeof *middles);
    for (uint32_t i = 0; i < count; i++)
        sorted[place[i]] = order[i];
    memcpy(order, sorted, count * sizeof *order);
cleanup:
    free(middles);
    free(place);
    free(sorted);
    return result;
}

/* Runs of even length: none has less than half the triangles of another. */
void upload_cluster_bounds(upload *u, const scene_mesh *mesh, const upload_mesh *layout,
                           const uint32_t *indices) {
    const uint64_t triangles = layout->index_count / 3;
    for (uint32_t i = 0; i < layout->cluster_count; i++) {
        upload_cluster *cluster = &u->clusters[layout->first_cluster + i];
        const uint32_t first = (uint32_t)(triangles * i / layout->cluster_count),
                       last = (uint32_t)(triangles * (i + 1) / layout->cluster_count);
        cluster->first_index = layout->first_index + first * 3;
        cluster->index_count = (last - first) * 3;
        if (layout->cluster_count == 1)
            continue; /* has the mesh's */
        for (uint32_t k = 0; k < cluster->index_count; k++) {
            const float *p = mesh->positions + (size_t)indices[cluster->first_index + k] * 3;
            for (int axis = 0; axis < 3; axis++) {
                if (k == 0 || p[axis] < cluster->lower[axis])
                    cluster->lower[axis] = p[axis];
                if (k == 0 || p[axis] > cluster->upper[axis])
                    cluster->upper[axis] = p[axis];
            }
        }
    }
}

upload_object upload_make_object(const upload *u, const scene_mesh *mesh, const upload_mesh *layout,
                                 uint32_t number) {
    const upload_cluster *cluster = &u->clusters[layout->first_cluster + number];
    const int whole = layout->cluster_count == 1;
    upload_object object = {.first_index = cluster->first_index,
                            .index_count = cluster->index_count,
                            .clusters = layout->cluster_count - number};
    memcpy(object.lower, whole ? mesh->lower : cluster->lower, sizeof object.lower);
    memcpy(object.upper, whole ? mesh->upper : cluster->upper, sizeof object.upper);
    if (layout->transparent)
        object.flags |= UPLOAD_OBJECT_TRANSPARENT;
    if (mesh->topology == SCENE_POINTS) /* splats reach beyond, in units of pixels */
        object.flags |= UPLOAD_OBJECT_UNBOUNDED;
    if (number > 0)
        object.flags |= UPLOAD_OBJECT_CONTINUES;
    return object;
}
