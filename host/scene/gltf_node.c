/* SPDX-License-Identifier: MIT
 *
 * The glTF node hierarchy: parents, instances of meshes, lights and cameras of the default scene.
 * Files may lie about their tree, so cycles and second parents are found before anything walks it.
 */
#include "scene/gltf.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNREAD (SCENE_NONE - 1) /* in mesh_map: not converted yet */

/* ---- the tree -------------------------------------------------------------------------------- */

static strata_result find_parents(gltf_loader *l) {
    scene_node *nodes = l->animations->nodes;
    for (uint32_t i = 0; i < l->file.node_count; i++)
        for (uint32_t c = 0; c < l->file.nodes[i].child_count; c++) {
            uint32_t child = (uint32_t)l->file.nodes[i].children[c];
            if (nodes[child].parent != SCENE_NONE)
                return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                                 "%s: nodes[%u]: is a child of nodes[%u] and of nodes[%u]",
                                 l->s->path, child, nodes[child].parent, i);
            nodes[child].parent = i;
        }
    return STRATA_OK;
}

/* Appends the tree below `root`, depth first, children in their order, to list. Nodes that `seen`
 * marks are left out. stack has room for every node. */
static void walk(const gltf_loader *l, uint32_t root, unsigned char *seen, uint32_t *stack,
                 uint32_t *list, uint32_t *count) {
    uint32_t depth = 0;
    if (seen[root])
        return;
    seen[root] = 1;
    stack[depth++] = root;
    while (depth > 0) {
        uint32_t node = stack[--depth];
        list[(*count)++] = node;
        for (uint32_t c = l->file.nodes[node].child_count; c-- > 0;) {
            uint32_t child = (uint32_t)l->file.nodes[node].children[c];
            if (!seen[child]) {
                seen[child] = 1;
                stack[depth++] = child;
            }
        }
    }
}

/* A node of a tree without root leads upwards into a cycle; returns one on it. */
static uint32_t node_on_cycle(const gltf_loader *l, uint32_t node) {
    for (uint32_t i = 0; i < l->file.node_count; i++)
        node = l->animations->nodes[node].parent;
    return node;
}

static strata_result order_nodes(gltf_loader *l, unsigned char *seen, uint32_t *stack) {
    scene_animations *a = l->animations;
    uint32_t count = 0;
    for (uint32_t i = 0; i < a->node_count; i++)
        if (a->nodes[i].parent == SCENE_NONE)
            walk(l, i, seen, stack, a->order, &count);
    for (uint32_t i = 0; i < a->node_count; i++)
        if (!seen[i])
            return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: nodes[%u]: is its own ancestor",
                             l->s->path, node_on_cycle(l, i));
    return STRATA_OK;
}

static strata_result read_pose(gltf_loader *l, uint32_t index) {
    const gltf_node *from = &l->file.nodes[index];
    scene_node *node = &l->animations->nodes[index];
    if (from->matrix) {
        node->fixed = 1;
        memcpy(node->matrix, from->matrix, sizeof node->matrix);
    }
    memcpy(node->rest.translation, from->translation, sizeof from->translation);
    memcpy(node->rest.rotation, from->rotation, sizeof from->rotation);
    memcpy(node->rest.scale, from->scale, sizeof from->scale);
    scene_normalize_rotation(node->rest.rotation);
    if (from->mesh == SCENE_NONE)
        return STRATA_OK;

    const gltf_mesh *mesh = &l->file.meshes[from->mesh];
    for (uint32_t p = 0; p < mesh->primitive_count; p++)
        if (mesh->primitives[p].target_count > node->weight_count)
            node->weight_count = mesh->primitives[p].target_count;
    if (node->weight_count == 0)
        return STRATA_OK;
    strata_result result = gltf_charge(l, "nodes", node->weight_count, 2 * sizeof(float));
    if (result != STRATA_OK) {
        node->weight_count = 0;
        return result;
    }
    node->rest_weights = base_calloc(node->weight_count, sizeof *node->rest_weights);
    node->weights = base_calloc(node->weight_count, sizeof *node->weights);
    if (!node->rest_weights || !node->weights)
        return gltf_no_memory(l);
    const double *weights = from->weight_count ? from->weights : mesh->weights;
    uint32_t given = from->weight_count ? from->weight_count : mesh->weight_count;
    for (uint32_t i = 0; i < given && i < node->weight_count; i++)
        node->rest_weights[i] = (float)weights[i];
    return STRATA_OK;
}

/* ---- instances ------------------------------------------------------------------------------- */

/* The local matrices of EXT_mesh_gpu_instancing; one identity without it. */
typedef struct copies {
    float *translation, *rotation, *scale; /* each may be NULL */
    uint32_t count;
} copies;

static void free_copies(copies *c) {
    free(c->translation);
    free(c->rotation);
    free(c->scale);
}

static strata_result read_copies(gltf_loader *l, uint32_t index, copies *out) {
    static const char *const names[] = {"TRANSLATION", "ROTATION", "SCALE"};
    const gltf_attributes *attributes = &l->file.nodes[index].instancing;
    float **arrays[] = {&out->translation, &out->rotation, &out->scale};
    int given = 0;
    for (size_t i = 0; i < BASE_COUNT(names); i++) {
        uint32_t accessor = gltf_find(attributes, names[i]), count;
        char place[80];
        if (accessor == SCENE_NONE)
            continue;
        snprintf(place, sizeof place, "nodes[%u].EXT_mesh_gpu_instancing: %s", index, names[i]);
        strata_result result =
            gltf_read_floats(l, accessor, i == 1 ? 4 : 3, place, arrays[i], &count);
        if (result == STRATA_OK && given && count != out->count)
            return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                             "%s: %s: accessors[%u] has %u elements, others have %u", l->s->path,
                             place, accessor, count, out->count);
        if (result != STRATA_OK)
            return result;
        for (size_t k = 0; k < (size_t)count * (i == 1 ? 4 : 3); k++)
            if (!isfinite((*arrays[i])[k]))
                return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: [%zu] is not finite",
                                 l->s->path, place, k / (i == 1 ? 4 : 3));
        out->count = count;
        given = 1;
    }
    if (!given)
        out->count = 1;
    return STRATA_OK;
}

static void copy_matrix(const copies *c, uint32_t index, float local[16]) {
    scene_pose pose = {.rotation = {0.0, 0.0, 0.0, 1.0}, .scale = {1.0, 1.0, 1.0}};
    double matrix[16];
    for (size_t i = 0; i < 3; i++) {
        if (c->translation)
            pose.translation[i] = (double)c->translation[(size_t)index * 3 + i];
        if (c->scale)
            pose.scale[i] = (double)c->scale[(size_t)index * 3 + i];
    }
    for (size_t i = 0; i < 4 && c->rotation; i++)
        pose.rotation[i] = (double)c->rotation[(size_t)index * 4 + i];
    scene_normalize_rotation(pose.rotation);
    scene_compose(&pose, matrix);
    scene_narrow(matrix, local);
}

/* The scene mesh of each primitive of a node's mesh: shared while rigid, the node's own otherwise.
 */
static strata_result read_primitives(gltf_loader *l, uint32_t node, uint32_t *meshes) {
    const gltf_node *from = &l->file.nodes[node];
    const gltf_mesh *mesh = &l->file.meshes[from->mesh];
    for (uint32_t p = 0; p < mesh->primitive_count; p++) {
        uint32_t *shared = &l->mesh_map[l->mesh_first[from->mesh] + p];
        int rigid = from->skin == SCENE_NONE && mesh->primitives[p].target_count == 0;
        strata_result result = STRATA_OK;
        if (!rigid || *shared == UNREAD)
            result = gltf_read_primitive(l, from->mesh, p, from->skin, node, &meshes[p]);
        else
            meshes[p] = *shared;
        if (result != STRATA_OK)
            return result;
        if (rigid)
            *shared = meshes[p];
    }
    return STRATA_OK;
}

static strata_result add_instances(gltf_loader *l, uint32_t node, const copies *c,
                                   const uint32_t *meshes, uint32_t mesh_count) {
    strata_result result =
        gltf_charge(l, "nodes", (uint64_t)c->count * mesh_count, sizeof(scene_instance));
    if (result != STRATA_OK)
        return result;
    for (uint32_t i = 0; i < c->count; i++)
        for (uint32_t p = 0; p < mesh_count; p++) {
            if (meshes[p] == SCENE_NONE)
                continue;
            const scene_deform *deform = l->s->meshes[meshes[p]].deform;
            int skinned = deform && deform->influences > 0;
            if (skinned && i > 0)
                continue; /* its joints place it: copies would coincide */
            scene_instance *instance = scene_add_instance(l->s, &l->instance_capacity);
            if (!instance)
                return gltf_no_memory(l);
            instance->mesh = meshes[p];
            instance->node = skinned ? SCENE_NONE : node;
            if (!skinned)
                copy_matrix(c, i, instance->local);
        }
    return STRATA_OK;
}

static strata_result read_mesh_node(gltf_loader *l, uint32_t node) {
    const gltf_mesh *mesh = &l->file.meshes[l->file.nodes[node].mesh];
    copies c = {0};
    uint32_t *meshes = base_calloc(mesh->primitive_count, sizeof *meshes);
    if (!meshes)
        return gltf_no_memory(l);
    strata_result result = read_copies(l, node, &c);
    if (result == STRATA_OK)
        result = read_primitives(l, node, meshes);
    if (result == STRATA_OK)
        result = add_instances(l, node, &c, meshes, mesh->primitive_count);
    free_copies(&c);
    free(meshes);
    return result;
}

/* ---- lights and cameras ---------------------------------------------------------------------- */

static strata_result add_light(gltf_loader *l, uint32_t node) {
    scene_light *light = &l->s->lights[l->s->light_count];
    *light = l->file.lights[l->file.nodes[node].light];
    if (light->name && !(light->name = base_strdup(light->name)))
        return gltf_no_memory(l);
    l->s->light_count++;
    light->node = node;
    for (int i = 0; i < 3; i++)
        light->color[i] = fminf(fmaxf(light->color[i], -FLT_MAX), FLT_MAX);
    if (light->inner_cos <= light->outer_cos)
        light->inner_cos = fminf(light->outer_cos + 1e-4f, 1.0f);
    return STRATA_OK;
}

static strata_result add_camera(gltf_loader *l, uint32_t node) {
    const float pi = 3.14159265f;
    uint32_t index = l->file.nodes[node].camera;
    const scene_camera *from = &l->file.cameras[index];
    int flat = from->projection == SCENE_ORTHOGRAPHIC;
    if ((flat && (from->xmag == 0.0f || from->ymag == 0.0f)) || (!flat && from->yfov >= pi) ||
        ((flat || from->zfar != 0.0f) && from->zfar <= from->znear)) {
        scene_warn(l->s, "%s: cameras[%u]: sees nothing (extent, angle or zfar): ignored",
                   l->s->path, index);
        return STRATA_OK;
    }
    scene_camera *camera = &l->s->cameras[l->s->camera_count];
    *camera = *from;
    if (camera->name && !(camera->name = base_strdup(camera->name)))
        return gltf_no_memory(l);
    l->s->camera_count++;
    camera->node = node;
    return STRATA_OK;
}

/* ---- the scene ------------------------------------------------------------------------------- */

/* The nodes of the default scene in drawing order. Without any scene: every root. */
static void list_scene(const gltf_loader *l, unsigned char *seen, uint32_t *stack, uint32_t *list,
                       uint32_t *count) {
    const gltf_file *file = &l->file;
    memset(seen, 0, file->node_count);
    if (file->scene_count == 0) {
        for (uint32_t i = 0; i < file->node_count; i++)
            if (l->animations->nodes[i].parent == SCENE_NONE)
                walk(l, i, seen, stack, list, count);
        return;
    }
    const gltf_scene_list *scene_nodes = &file->scenes[file->scene == SCENE_NONE ? 0 : file->scene];
    for (uint32_t i = 0; i < scene_nodes->count; i++)
        walk(l, (uint32_t)scene_nodes->nodes[i], seen, stack, list, count);
}

static strata_result prepare_meshes(gltf_loader *l) {
    uint64_t total = 0;
    l->mesh_first = base_calloc(l->file.mesh_count, sizeof *l->mesh_first);
    if (!l->mesh_first)
        return gltf_no_memory(l);
    for (uint32_t i = 0; i < l->file.mesh_count; i++) {
        l->mesh_first[i] = (size_t)total;
        total += l->file.meshes[i].primitive_count;
    }
    l->mesh_map = base_calloc((size_t)total, sizeof *l->mesh_map);
    if (!l->mesh_map)
        return gltf_no_memory(l);
    for (uint64_t i = 0; i < total; i++)
        l->mesh_map[i] = UNREAD;
    return STRATA_OK;
}

static strata_result read_listed(gltf_loader *l, const uint32_t *list, uint32_t count) {
    strata_result result = STRATA_OK;
    l->s->lights = base_calloc(count, sizeof *l->s->lights);
    l->s->cameras = base_calloc(count, sizeof *l->s->cameras);
    if (!l->s->lights || !l->s->cameras)
        return gltf_no_memory(l);
    for (uint32_t i = 0; i < count && result == STRATA_OK; i++) {
        const gltf_node *node = &l->file.nodes[list[i]];
        if (node->mesh != SCENE_NONE)
            result = read_mesh_node(l, list[i]);
        if (result == STRATA_OK && node->light != SCENE_NONE)
            result = add_light(l, list[i]);
        if (result == STRATA_OK && node->camera != SCENE_NONE)
            result = add_camera(l, list[i]);
    }
    return result;
}

strata_result gltf_read_nodes(gltf_loader *l) {
    uint32_t nodes = l->file.node_count, count = 0;
    scene_animations *a = l->animations;
    unsigned char *seen = base_calloc(nodes, 1);
    uint32_t *stack = base_calloc(nodes, sizeof *stack), *list = base_calloc(nodes, sizeof *list);
    a->nodes = base_calloc(nodes, sizeof *a->nodes);
    a->order = base_calloc(nodes, sizeof *a->order);
    strata_result result = STRATA_OK;
    if (!seen || !stack || !list || !a->nodes || !a->order) {
        result = gltf_no_memory(l);
        goto cleanup;
    }
    a->node_count = nodes;
    for (uint32_t i = 0; i < nodes; i++)
        a->nodes[i].parent = SCENE_NONE;
    result = find_parents(l);
    if (result == STRATA_OK)
        result = order_nodes(l, seen, stack);
    for (uint32_t i = 0; i < nodes && result == STRATA_OK; i++)
        result = read_pose(l, i);
    if (result == STRATA_OK)
        result = prepare_meshes(l);
    if (result == STRATA_OK) {
        list_scene(l, seen, stack, list, &count);
        result = read_listed(l, list, count);
    }
cleanup:
    free(seen);
    free(stack);
    free(list);
    return result;
}
