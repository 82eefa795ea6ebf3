/* SPDX-License-Identifier: MIT
 *
 * The scene's own life: creation, what follows from meshes and instances (bounds, flat normals,
 * primitive numbers), edits of single instances, release. Used by the loader and the generators.
 */
#include "scene/scene_internal.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_WARNINGS 100u

scene *scene_new(const char *path) {
    scene *s = base_calloc(1, sizeof *s);
    if (!s)
        return NULL;
    s->path = base_strdup(path);
    if (!s->path) {
        free(s);
        return NULL;
    }
    for (int axis = 0; axis < 3; axis++) {
        s->lower[axis] = FLT_MAX;
        s->upper[axis] = -FLT_MAX;
    }
    return s;
}

void scene_deform_free(scene_deform *deform) {
    if (!deform)
        return;
    free(deform->joints);
    free(deform->weights);
    free(deform->target_positions);
    free(deform->target_normals);
    free(deform->target_tangents);
    free(deform->rest_positions);
    free(deform->rest_normals);
    free(deform->rest_tangents);
    free(deform);
}

static void free_mesh(scene_mesh *mesh) {
    free(mesh->name);
    free(mesh->positions);
    free(mesh->normals);
    free(mesh->tangents);
    free(mesh->uv0);
    free(mesh->uv1);
    free(mesh->colors);
    free(mesh->radii);
    free(mesh->indices);
    scene_deform_free(mesh->deform);
}

void scene_free(scene *s) {
    if (!s)
        return;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        free_mesh(&s->meshes[i]);
    for (uint32_t i = 0; i < s->image_count; i++) {
        free(s->images[i].name);
        free(s->images[i].pixels);
    }
    for (uint32_t i = 0; i < s->material_count; i++)
        free(s->materials[i].name);
    for (uint32_t i = 0; i < s->light_count; i++)
        free(s->lights[i].name);
    for (uint32_t i = 0; i < s->camera_count; i++)
        free(s->cameras[i].name);
    for (uint32_t i = 0; i < s->warning_count; i++)
        free(s->warnings[i]);
    free(s->meshes);
    free(s->instances);
    free(s->images);
    free(s->materials);
    free(s->lights);
    free(s->cameras);
    free(s->warnings);
    scene_animations_free(s->animations);
    free(s->path);
    free(s);
}

void scene_warn(scene *s, const char *format, ...) {
    base_error line = {0};
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line.text, sizeof line.text, format, arguments);
    va_end(arguments);
    if (s->warning_count >= MAX_WARNINGS)
        return;
    for (uint32_t i = 0; i < s->warning_count; i++)
        if (strcmp(s->warnings[i], line.text) == 0)
            return;
    base_error clean = {0};
    base_fail(&clean, STRATA_ERROR_BAD_FILE, "%s", line.text);
    if (s->warning_count == MAX_WARNINGS - 1)
        snprintf(clean.text, sizeof clean.text, "further warnings are not shown");
    char **warnings = base_realloc(s->warnings, s->warning_count + 1u, sizeof *warnings);
    if (!warnings)
        return;
    s->warnings = warnings;
    warnings[s->warning_count] = base_strdup(clean.text);
    if (warnings[s->warning_count])
        s->warning_count++;
}

/* ---- defaults and appending ------------------------------------------------------------------ */

void scene_identity(float matrix[16]) {
    for (int i = 0; i < 16; i++)
        matrix[i] = i % 5 == 0 ? 1.0f : 0.0f;
}

scene_texture scene_no_texture(void) {
    return (scene_texture){
        .image = SCENE_NONE,
        .scale_rotate = {1.0f, 0.0f, 0.0f, 1.0f},
        .magnify = SCENE_LINEAR,
        .minify = SCENE_LINEAR,
        .mipmap = SCENE_MIP_LINEAR,
        .wrap_u = SCENE_REPEAT,
        .wrap_v = SCENE_REPEAT,
    };
}

scene_material scene_default_material(void) {
    scene_texture none = scene_no_texture();
    return (scene_material){
        .alpha = SCENE_OPAQUE,
        .alpha_cutoff = 0.5f,
        .base_color = {1.0f, 1.0f, 1.0f, 1.0f},
        .metallic = 1.0f,
        .roughness = 1.0f,
        .normal_scale = 1.0f,
        .occlusion_strength = 1.0f,
        .ior = 1.5f,
        .base_color_texture = none,
        .metallic_roughness_texture = none,
        .normal_texture = none,
        .occlusion_texture = none,
        .emissive_texture = none,
        .transmission_texture = none,
    };
}

scene_mesh *scene_add_mesh(scene *s, size_t *capacity) {
    scene_mesh *meshes = s->mesh_count < SCENE_NONE - 1
                             ? base_grow(s->meshes, capacity, s->mesh_count, sizeof *meshes)
                             : NULL;
    if (!meshes)
        return NULL;
    s->meshes = meshes;
    scene_mesh *mesh = &meshes[s->mesh_count++];
    *mesh = (scene_mesh){.material = SCENE_NONE, .skin = SCENE_NONE, .node = SCENE_NONE};
    return mesh;
}

scene_instance *scene_add_instance(scene *s, size_t *capacity) {
    scene_instance *instances =
        s->instance_count < SCENE_NONE - 1
            ? base_grow(s->instances, capacity, s->instance_count, sizeof *instances)
            : NULL;
    if (!instances)
        return NULL;
    s->instances = instances;
    scene_instance *instance = &instances[s->instance_count++];
    *instance = (scene_instance){.node = SCENE_NONE, .visible = 1};
    scene_identity(instance->world);
    scene_identity(instance->local);
    return instance;
}

scene_material *scene_add_material(scene *s, size_t *capacity) {
    scene_material *materials =
        s->material_count < SCENE_NONE - 1
            ? base_grow(s->materials, capacity, s->material_count, sizeof *materials)
            : NULL;
    if (!materials)
        return NULL;
    s->materials = materials;
    scene_material *material = &materials[s->material_count++];
    *material = scene_default_material();
    return material;
}

/* ---- flat normals ---------------------------------------------------------------------------- */

/* Replaces *attribute[vertex_count], of `size` bytes each, by its values at the mesh's indices. */
static int expand(const scene_mesh *mesh, void *attribute, size_t size) {
    unsigned char *from, *expanded;
    memcpy(&from, attribute, sizeof from);
    if (!from || size == 0)
        return 1;
    expanded = base_calloc(mesh->index_count, size);
    if (!expanded)
        return 0;
    for (size_t i = 0; i < mesh->index_count; i++)
        memcpy(expanded + i * size, from + (size_t)mesh->indices[i] * size, size);
    free(from);
    memcpy(attribute, &expanded, sizeof expanded);
    return 1;
}

/* The same for each morph target in *attribute[target_count][vertex_count][3]. */
static int expand_targets(const scene_mesh *mesh, float **attribute) {
    size_t count = mesh->index_count, targets = mesh->deform->target_count;
    if (!*attribute)
        return 1;
    if (count * targets > SIZE_MAX / (3 * sizeof(float)))
        return 0;
    float *expanded = base_calloc(count * targets, 3 * sizeof *expanded);
    if (!expanded)
        return 0;
    for (size_t t = 0; t < targets; t++)
        for (size_t i = 0; i < count; i++)
            memcpy(expanded + (t * count + i) * 3,
                   *attribute + (t * mesh->vertex_count + mesh->indices[i]) * 3,
                   3 * sizeof *expanded);
    free(*attribute);
    *attribute = expanded;
    return 1;
}

static int expand_deform(const scene_mesh *mesh) {
    scene_deform *d = mesh->deform;
    return !d ||
           (expand(mesh, &d->joints, d->influences * sizeof *d->joints) &&
            expand(mesh, &d->weights, d->influences * sizeof *d->weights) &&
            expand(mesh, &d->rest_positions, 3 * sizeof(float)) &&
            expand(mesh, &d->rest_tangents, 4 * sizeof(float)) &&
            expand_targets(mesh, &d->target_positions) &&
            expand_targets(mesh, &d->target_normals) && expand_targets(mesh, &d->target_tangents));
}

/* The unit normal of a counter-clockwise triangle, in double so that tiny and huge ones have one;
 * +z when the area is zero. */
static void face_normal(const float *a, const float *b, const float *c, float normal[3]) {
    double u[3], v[3], n[3];
    for (int i = 0; i < 3; i++) {
        u[i] = (double)b[i] - (double)a[i];
        v[i] = (double)c[i] - (double)a[i];
    }
    n[0] = u[1] * v[2] - u[2] * v[1];
    n[1] = u[2] * v[0] - u[0] * v[2];
    n[2] = u[0] * v[1] - u[1] * v[0];
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++)
        normal[i] = length > 0.0 ? (float)(n[i] / length) : (i == 2 ? 1.0f : 0.0f);
}

void scene_flat_normals_update(scene_mesh *mesh) {
    for (size_t i = 0; i + 2 < mesh->vertex_count; i += 3) {
        float *normal = mesh->normals + i * 3, *position = mesh->positions + i * 3;
        face_normal(position, position + 3, position + 6, normal);
        memcpy(normal + 3, normal, 3 * sizeof *normal);
        memcpy(normal + 6, normal, 3 * sizeof *normal);
    }
}

strata_result scene_flat_normals(scene_mesh *mesh, base_error *err) {
    float *normals = base_calloc(mesh->index_count, 3 * sizeof *normals);
    if (!normals || !expand(mesh, &mesh->positions, 3 * sizeof(float)) ||
        !expand(mesh, &mesh->tangents, 4 * sizeof(float)) ||
        !expand(mesh, &mesh->uv0, 2 * sizeof(float)) ||
        !expand(mesh, &mesh->uv1, 2 * sizeof(float)) ||
        !expand(mesh, &mesh->colors, 4 * sizeof(float)) || !expand_deform(mesh)) {
        free(normals);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for normals");
    }
    free(mesh->normals);
    mesh->normals = normals;
    mesh->vertex_count = mesh->index_count;
    for (uint32_t i = 0; i < mesh->index_count; i++)
        mesh->indices[i] = i;
    scene_flat_normals_update(mesh);
    return STRATA_OK;
}

/* ---- bounds ---------------------------------------------------------------------------------- */

void scene_mesh_bounds(scene_mesh *mesh) {
    for (int axis = 0; axis < 3; axis++)
        mesh->lower[axis] = mesh->upper[axis] = 0.0f;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        float radius = mesh->radii ? mesh->radii[i] : 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            float low = mesh->positions[i * 3 + (size_t)axis] - radius;
            float high = mesh->positions[i * 3 + (size_t)axis] + radius;
            if (i == 0 || low < mesh->lower[axis])
                mesh->lower[axis] = low;
            if (i == 0 || high > mesh->upper[axis])
                mesh->upper[axis] = high;
        }
    }
}

static void add_instance_bounds(scene *s, const scene_instance *instance) {
    const scene_mesh *mesh = &s->meshes[instance->mesh];
    const float *m = instance->world;
    for (int axis = 0; axis < 3; axis++) {
        double low = (double)m[12 + axis], high = low;
        for (int column = 0; column < 3; column++) {
            double scale = (double)m[column * 4 + axis];
            double a = scale * (double)mesh->lower[column];
            double b = scale * (double)mesh->upper[column];
            low += fmin(a, b);
            high += fmax(a, b);
        }
        s->lower[axis] = fminf(s->lower[axis], (float)fmax(low, -(double)FLT_MAX));
        s->upper[axis] = fmaxf(s->upper[axis], (float)fmin(high, (double)FLT_MAX));
    }
}

void scene_bounds(scene *s) {
    for (int axis = 0; axis < 3; axis++) {
        s->lower[axis] = FLT_MAX;
        s->upper[axis] = -FLT_MAX;
    }
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (s->instances[i].visible && s->meshes[s->instances[i].mesh].index_count > 0)
            add_instance_bounds(s, &s->instances[i]);
}

/* ---- finishing ------------------------------------------------------------------------------- */

static int name_if_absent(char **name, const char *kind, uint32_t index) {
    if (!*name)
        *name = base_format("%s %u", kind, index);
    return *name != NULL;
}

static int fill_names(scene *s) {
    int fine = 1;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        fine &= name_if_absent(&s->meshes[i].name, "mesh", i);
    for (uint32_t i = 0; i < s->image_count; i++)
        fine &= name_if_absent(&s->images[i].name, "image", i);
    for (uint32_t i = 0; i < s->material_count; i++)
        fine &= name_if_absent(&s->materials[i].name, "material", i);
    for (uint32_t i = 0; i < s->light_count; i++)
        fine &= name_if_absent(&s->lights[i].name, "light", i);
    for (uint32_t i = 0; i < s->camera_count; i++)
        fine &= name_if_absent(&s->cameras[i].name, "camera", i);
    return fine;
}

static strata_result finish_mesh(scene *s, scene_mesh *mesh, base_error *err) {
    if (mesh->index_count > 0 && (!mesh->positions || !mesh->indices))
        return base_fail(err, STRATA_ERROR_INTERNAL, "%s: mesh '%s' has indices but no positions",
                         s->path, mesh->name);
    if (mesh->topology == SCENE_TRIANGLES && mesh->index_count % 3 != 0)
        return base_fail(err, STRATA_ERROR_INTERNAL,
                         "%s: mesh '%s' has %u indices, not whole triangles", s->path, mesh->name,
                         mesh->index_count);
    for (size_t i = 0; i < mesh->index_count; i++)
        if (mesh->indices[i] >= mesh->vertex_count)
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: mesh '%s': index[%zu] is %u of %u vertices", s->path, mesh->name,
                             i, mesh->indices[i], mesh->vertex_count);
    for (size_t i = 0; i < (size_t)mesh->vertex_count * 3; i++)
        if (!isfinite(mesh->positions[i]))
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: mesh '%s': position[%zu] is not finite", s->path, mesh->name,
                             i / 3);
    if (mesh->topology == SCENE_TRIANGLES && !mesh->normals && mesh->index_count > 0) {
        strata_result result = scene_flat_normals(mesh, err);
        if (result != STRATA_OK)
            return result;
    }
    scene_mesh_bounds(mesh);
    return STRATA_OK;
}

static strata_result number_primitives(scene *s, base_error *err) {
    uint64_t next = 0;
    for (uint32_t i = 0; i < s->instance_count; i++) {
        scene_instance *instance = &s->instances[i];
        if (instance->mesh >= s->mesh_count)
            return base_fail(err, STRATA_ERROR_INTERNAL, "%s: instance %u has no mesh", s->path, i);
        const scene_mesh *mesh = &s->meshes[instance->mesh];
        instance->primitive_base = (uint32_t)next;
        next += mesh->topology == SCENE_TRIANGLES ? mesh->index_count / 3 : mesh->index_count;
        if (next > UINT32_MAX)
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: the scene has 2^32 or more triangles and points", s->path);
    }
    s->primitive_count = next;
    return STRATA_OK;
}

static strata_result append_default_material(scene *s, base_error *err) {
    uint32_t wanted = s->material_count == 0;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        wanted |= s->meshes[i].material >= s->material_count;
    if (!wanted)
        return STRATA_OK;
    size_t capacity = 0; /* unknown here: base_grow moves the array */
    if (s->materials)
        capacity = s->material_count;
    scene_material *material = scene_add_material(s, &capacity);
    if (material)
        material->name = base_strdup("default");
    if (!material || !material->name)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for materials",
                         s->path);
    for (uint32_t i = 0; i < s->mesh_count; i++)
        if (s->meshes[i].material >= s->material_count - 1)
            s->meshes[i].material = s->material_count - 1;
    return STRATA_OK;
}

strata_result scene_finish(scene *s, base_error *err) {
    if (!fill_names(s))
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for names", s->path);
    strata_result result = append_default_material(s, err);
    for (uint32_t i = 0; i < s->mesh_count && result == STRATA_OK; i++)
        result = finish_mesh(s, &s->meshes[i], err);
    if (result == STRATA_OK)
        result = number_primitives(s, err);
    if (result == STRATA_OK)
        scene_bounds(s);
    return result;
}

/* ---- edits of one instance ------------------------------------------------------------------- */

static strata_result check_instance(const scene *s, uint32_t instance, base_error *err) {
    if (instance < s->instance_count)
        return STRATA_OK;
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: there is no instance %u (%u exist)",
                     s->path, instance, s->instance_count);
}

strata_result scene_set_transform(scene *s, uint32_t instance, const float world[16],
                                  base_error *err) {
    strata_result result = check_instance(s, instance, err);
    if (result != STRATA_OK)
        return result;
    for (int i = 0; i < 16; i++)
        if (!isfinite(world[i]))
            return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                             "%s: instance %u: matrix[%d] is not finite", s->path, instance, i);
    memcpy(s->instances[instance].world, world, sizeof s->instances[instance].world);
    s->instances[instance].node = SCENE_NONE; /* the hierarchy no longer moves it */
    scene_bounds(s);
    s->revision++;
    return STRATA_OK;
}

strata_result scene_set_visible(scene *s, uint32_t instance, uint32_t visible, base_error *err) {
    strata_result result = check_instance(s, instance, err);
    if (result != STRATA_OK)
        return result;
    s->instances[instance].visible = visible != 0;
    scene_bounds(s);
    s->revision++;
    return STRATA_OK;
}
