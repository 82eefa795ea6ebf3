/* SPDX-License-Identifier: MIT
 *
 * Edits of a scene that leave its triangles, their order and their numbers as they are: meshes cut
 * in two, put together, and positions rounded. See hard.h.
 */
#include "hard/hard.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A vertex's attributes in a mesh. */
typedef struct attribute {
    float **at;
    size_t width;
} attribute;

enum { ATTRIBUTES = 7 };

static void attributes(scene_mesh *m, attribute out[ATTRIBUTES]) {
    const attribute all[ATTRIBUTES] = {{&m->positions, 3}, {&m->normals, 3}, {&m->tangents, 4},
                                       {&m->uv0, 2},       {&m->uv1, 2},     {&m->colors, 4},
                                       {&m->radii, 1}};
    memcpy(out, all, sizeof all);
}

static void *room(size_t count, size_t size) {
    void *memory = base_calloc(count ? count : 1, size);
    assert_non_null(memory);
    return memory;
}

/* Indices first .. first + count - 1 of a mesh, with all of its vertices. */
static scene_mesh part(scene_mesh *from, uint32_t first, uint32_t count) {
    scene_mesh out = *from;
    attribute old[ATTRIBUTES], new[ATTRIBUTES];
    attributes(from, old);
    attributes(&out, new);
    out.name = base_strdup(from->name);
    assert_non_null(out.name);
    for (int i = 0; i < ATTRIBUTES; i++)
        if (*old[i].at) {
            const size_t size = from->vertex_count * old[i].width;
            *new[i].at = room(size, sizeof(float));
            memcpy(*new[i].at, *old[i].at, size * sizeof(float));
        }
    out.indices = room(count, sizeof *out.indices);
    memcpy(out.indices, from->indices + first, count * sizeof *out.indices);
    out.index_count = count;
    return out;
}

static void free_mesh(scene_mesh *m) {
    attribute all[ATTRIBUTES];
    attributes(m, all);
    for (int i = 0; i < ATTRIBUTES; i++)
        free(*all[i].at);
    free(m->indices);
    free(m->name);
}

/* Takes over both arrays; numbers follow the order of the instances. */
static void replace(scene *s, scene_mesh *meshes, uint32_t mesh_count, scene_instance *instances,
                    uint32_t instance_count) {
    uint32_t next = 0;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        free_mesh(&s->meshes[i]);
    free(s->meshes);
    free(s->instances);
    s->meshes = meshes;
    s->mesh_count = mesh_count;
    s->instances = instances;
    s->instance_count = instance_count;
    for (uint32_t i = 0; i < instance_count; i++) {
        instances[i].primitive_base = next;
        next += meshes[instances[i].mesh].index_count / 3;
    }
    assert_int_equal(next, s->primitive_count);
    s->revision++;
}

void hard_split(scene *s) {
    scene_mesh *meshes = room(2 * (size_t)s->mesh_count, sizeof *meshes);
    scene_instance *instances = room(2 * (size_t)s->instance_count, sizeof *instances);
    for (uint32_t i = 0; i < s->mesh_count; i++) {
        const uint32_t count = s->meshes[i].index_count, half = count / 6 * 3;
        meshes[2 * i] = part(&s->meshes[i], 0, half);
        meshes[2 * i + 1] = part(&s->meshes[i], half, count - half);
    }
    for (uint32_t i = 0; i < 2 * s->instance_count; i++) {
        instances[i] = s->instances[i / 2];
        instances[i].mesh = 2 * instances[i].mesh + i % 2;
    }
    replace(s, meshes, 2 * s->mesh_count, instances, 2 * s->instance_count);
}

static int joinable(const scene *s, const scene_instance *a, const scene_instance *b) {
    scene_mesh *m = &s->meshes[a->mesh], *n = &s->meshes[b->mesh];
    attribute left[ATTRIBUTES], right[ATTRIBUTES];
    attributes(m, left);
    attributes(n, right);
    for (int i = 0; i < ATTRIBUTES; i++)
        if (!*left[i].at != !*right[i].at)
            return 0;
    return m->material == n->material && memcmp(a->world, b->world, sizeof a->world) == 0;
}

static void append(scene_mesh *to, scene_mesh *from) {
    attribute old[ATTRIBUTES], new[ATTRIBUTES];
    attributes(from, old);
    attributes(to, new);
    for (int i = 0; i < ATTRIBUTES; i++)
        if (*old[i].at) {
            const size_t width = old[i].width, have = to->vertex_count * width,
                         more = from->vertex_count * width;
            float *grown = base_realloc(*new[i].at, have + more, sizeof *grown);
            assert_non_null(grown);
            memcpy(grown + have, *old[i].at, more * sizeof *grown);
            *new[i].at = grown;
        }
    uint32_t *indices =
        base_realloc(to->indices, (size_t)to->index_count + from->index_count, sizeof *indices);
    assert_non_null(indices);
    for (uint32_t i = 0; i < from->index_count; i++)
        indices[to->index_count + i] = from->indices[i] + to->vertex_count;
    to->indices = indices;
    to->index_count += from->index_count;
    to->vertex_count += from->vertex_count;
    for (int i = 0; i < 3; i++) {
        to->lower[i] = fminf(to->lower[i], from->lower[i]);
        to->upper[i] = fmaxf(to->upper[i], from->upper[i]);
    }
}

void hard_merge(scene *s) {
    scene_mesh *meshes = room(s->instance_count, sizeof *meshes);
    scene_instance *instances = room(s->instance_count, sizeof *instances);
    uint32_t count = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        scene_mesh *mesh = &s->meshes[s->instances[i].mesh];
        if (i > 0 && joinable(s, &s->instances[i - 1], &s->instances[i])) {
            append(&meshes[count - 1], mesh);
            continue;
        }
        meshes[count] = part(mesh, 0, mesh->index_count);
        instances[count] = s->instances[i];
        instances[count].mesh = count;
        count++;
    }
    replace(s, meshes, count, instances, count);
}

void hard_round(scene *s) {
    for (uint32_t i = 0; i < s->mesh_count; i++)
        for (size_t k = 0; k < 3 * (size_t)s->meshes[i].vertex_count; k++) {
            float *p = &s->meshes[i].positions[k];
            *p = (float)(nearbyint((double)*p * 0x1p14) * 0x1p-14);
        }
    s->revision++;
}
