/* SPDX-License-Identifier: MIT
 *
 * Numbers and the builder of the procedural scenes: random bits, portable trigonometry, growing
 * meshes, and the appending of materials, instances, lights and cameras.
 */
#include "scene/generate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- numbers -------------------------------------------------------------------------------- */

uint32_t generate_bits(generate_random *random) {
    uint64_t old = random->state;
    random->state = old * 6364136223846793005u + 1442695040888963407u;
    uint32_t shifted = (uint32_t)(((old >> 18) ^ old) >> 27), turn = (uint32_t)(old >> 59);
    return shifted >> turn | shifted << (-turn & 31);
}

generate_random generate_seed(uint64_t seed) {
    generate_random random = {.state = seed + 1442695040888963407u};
    generate_bits(&random);
    return random;
}

double generate_unit(generate_random *random) {
    return generate_bits(random) * 0x1p-32;
}

double generate_between(generate_random *random, double low, double high) {
    return low + (high - low) * generate_unit(random);
}

void generate_direction(generate_random *random, double out[3]) {
    double s, c, z = generate_between(random, -1, 1), r = sqrt(1 - z * z);
    generate_turn(generate_unit(random), &s, &c);
    out[0] = r * c;
    out[1] = r * s;
    out[2] = z;
}

/* Taylor series on an eighth of a turn: eight terms reach 1e-17. */
void generate_turn(double turns, double *sine, double *cosine) {
    double quarter = floor(turns * 4 + 0.5);
    double x = (turns - quarter / 4) * 6.283185307179586477, x2 = x * x;
    double s = 0, c = 0;
    for (int k = 8; k >= 1; k--) {
        s = 1 - x2 / (2 * k * (2 * k + 1)) * (k == 8 ? 1 : s);
        c = 1 - x2 / ((2 * k - 1) * (2 * k)) * (k == 8 ? 1 : c);
    }
    s *= x;
    switch ((int)(quarter - 4 * floor(quarter / 4))) {
    case 0:
        *sine = s, *cosine = c;
        break;
    case 1:
        *sine = c, *cosine = -s;
        break;
    case 2:
        *sine = -s, *cosine = -c;
        break;
    default:
        *sine = -c, *cosine = s;
        break;
    }
}

void generate_normalize(double v[3]) {
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] = length > 0 ? v[i] / length : i == 2;
}

void generate_cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

void generate_hue(double hue, float out[3]) {
    for (int i = 0; i < 3; i++) {
        double s, c;
        generate_turn(hue - i / 3.0, &s, &c);
        double v = 0.5 + 0.5 * c;
        out[i] = (float)(0.04 + 0.86 * v * v);
    }
}

/* ---- meshes --------------------------------------------------------------------------------- */

generate_mesh generate_mesh_begin(generate_builder *b, unsigned attributes) {
    return (generate_mesh){.builder = b,
                           .has_normals = (attributes & GENERATE_NORMALS) != 0,
                           .has_uv = (attributes & GENERATE_UV) != 0,
                           .has_colors = (attributes & GENERATE_COLORS) != 0,
                           .has_radii = (attributes & GENERATE_RADII) != 0};
}

static void resize(generate_builder *b, float **array, int wanted, size_t count, size_t width) {
    if (!wanted || b->failed)
        return;
    float *moved = base_realloc(*array, count, width * sizeof **array);
    if (moved)
        *array = moved;
    else
        b->failed = 1;
}

static void resize_vertices(generate_mesh *mesh, size_t capacity) {
    generate_builder *b = mesh->builder;
    b->failed |= capacity >= SCENE_NONE;
    resize(b, &mesh->positions, 1, capacity, 3);
    resize(b, &mesh->normals, mesh->has_normals, capacity, 3);
    resize(b, &mesh->uv, mesh->has_uv, capacity, 2);
    resize(b, &mesh->colors, mesh->has_colors, capacity, 4);
    resize(b, &mesh->radii, mesh->has_radii, capacity, 1);
    if (!b->failed)
        mesh->vertex_capacity = capacity;
}

static void resize_indices(generate_mesh *mesh, size_t capacity) {
    generate_builder *b = mesh->builder;
    uint32_t *moved = b->failed || capacity >= SCENE_NONE
                          ? NULL
                          : base_realloc(mesh->indices, capacity, sizeof *moved);
    if (moved) {
        mesh->indices = moved;
        mesh->index_capacity = capacity;
    } else {
        b->failed = 1;
    }
}

void generate_mesh_reserve(generate_mesh *mesh, size_t vertices, size_t indices) {
    if (mesh->vertex_count + vertices > mesh->vertex_capacity)
        resize_vertices(mesh, mesh->vertex_count + vertices);
    if (mesh->index_count + indices > mesh->index_capacity)
        resize_indices(mesh, mesh->index_count + indices);
}

uint32_t generate_vertex(generate_mesh *mesh, double x, double y, double z) {
    if (mesh->vertex_count == mesh->vertex_capacity)
        resize_vertices(mesh, mesh->vertex_capacity ? 2 * mesh->vertex_capacity : 64);
    if (mesh->builder->failed)
        return 0;
    size_t at = mesh->vertex_count++;
    float *p = mesh->positions + at * 3;
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
    if (mesh->has_normals)
        memcpy(mesh->normals + at * 3, (const float[3]){0, 0, 1}, 3 * sizeof(float));
    if (mesh->has_uv)
        memset(mesh->uv + at * 2, 0, 2 * sizeof(float));
    if (mesh->has_colors)
        memcpy(mesh->colors + at * 4, (const float[4]){1, 1, 1, 1}, 4 * sizeof(float));
    if (mesh->has_radii)
        mesh->radii[at] = 0;
    return (uint32_t)at;
}

void generate_normal(generate_mesh *mesh, double x, double y, double z) {
    double n[3] = {x, y, z};
    generate_normalize(n);
    for (int i = 0; i < 3 && !mesh->builder->failed && mesh->has_normals; i++)
        mesh->normals[(mesh->vertex_count - 1) * 3 + (size_t)i] = (float)n[i];
}

void generate_uv(generate_mesh *mesh, double u, double v) {
    if (mesh->builder->failed || !mesh->has_uv)
        return;
    mesh->uv[(mesh->vertex_count - 1) * 2] = (float)u;
    mesh->uv[(mesh->vertex_count - 1) * 2 + 1] = (float)v;
}

void generate_color(generate_mesh *mesh, const float rgb[3], double alpha) {
    if (mesh->builder->failed || !mesh->has_colors)
        return;
    float *color = mesh->colors + (mesh->vertex_count - 1) * 4;
    memcpy(color, rgb, 3 * sizeof *color);
    color[3] = (float)alpha;
}

void generate_radius(generate_mesh *mesh, double radius) {
    if (!mesh->builder->failed && mesh->has_radii)
        mesh->radii[mesh->vertex_count - 1] = (float)radius;
}

void generate_triangle(generate_mesh *mesh, uint32_t a, uint32_t b, uint32_t c) {
    if (mesh->index_count + 3 > mesh->index_capacity)
        resize_indices(mesh, mesh->index_capacity ? 2 * mesh->index_capacity : 192);
    if (mesh->builder->failed)
        return;
    uint32_t *corner = mesh->indices + mesh->index_count;
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
    mesh->index_count += 3;
}

/* Points are drawn in the order of their vertices. */
static void index_points(generate_mesh *mesh) {
    generate_mesh_reserve(mesh, 0, mesh->vertex_count);
    for (size_t i = 0; i < mesh->vertex_count && !mesh->builder->failed; i++)
        mesh->indices[i] = (uint32_t)i;
    mesh->index_count = mesh->vertex_count;
}

uint32_t generate_mesh_end(generate_mesh *mesh, const char *name, uint32_t material) {
    generate_builder *b = mesh->builder;
    if (mesh->has_radii)
        index_points(mesh);
    int wanted = mesh->index_count > 0 && !b->failed;
    scene_mesh *out = wanted ? scene_add_mesh(b->s, &b->mesh_capacity) : NULL;
    char *copy = out ? base_strdup(name) : NULL;
    b->failed |= wanted && !copy;
    if (!out) {
        free(mesh->positions);
        free(mesh->normals);
        free(mesh->uv);
        free(mesh->colors);
        free(mesh->radii);
        free(mesh->indices);
        return SCENE_NONE;
    }
    out->name = copy;
    out->topology = mesh->has_radii ? SCENE_POINTS : SCENE_TRIANGLES;
    out->material = material;
    out->vertex_count = (uint32_t)mesh->vertex_count;
    out->index_count = (uint32_t)mesh->index_count;
    out->positions = mesh->positions;
    out->normals = mesh->normals;
    out->uv0 = mesh->uv;
    out->colors = mesh->colors;
    out->radii = mesh->radii;
    out->indices = mesh->indices;
    return b->s->mesh_count - 1;
}

/* ---- the rest ------------------------------------------------------------------------------- */

void generate_instance(generate_builder *b, uint32_t mesh, const double translation[3],
                       const double scale[3]) {
    if (mesh == SCENE_NONE)
        return;
    scene_instance *instance = b->failed ? NULL : scene_add_instance(b->s, &b->instance_capacity);
    b->failed |= !instance;
    if (!instance)
        return;
    instance->mesh = mesh;
    for (int i = 0; i < 3; i++) {
        instance->world[i * 5] = (float)scale[i];
        instance->world[12 + i] = (float)translation[i];
    }
}

void generate_instance_here(generate_builder *b, uint32_t mesh) {
    generate_instance(b, mesh, (const double[3]){0, 0, 0}, (const double[3]){1, 1, 1});
}

uint32_t generate_material(generate_builder *b, const char *name, const scene_material *material) {
    scene_material *out = b->failed ? NULL : scene_add_material(b->s, &b->material_capacity);
    char *copy = out ? base_strdup(name) : NULL;
    b->failed |= !copy;
    if (!out)
        return 0;
    *out = *material;
    out->name = copy;
    return b->s->material_count - 1;
}

static scene_camera *add_camera(generate_builder *b, const char *name) {
    scene *s = b->s;
    scene_camera *cameras =
        b->failed ? NULL
                  : base_grow(s->cameras, &b->camera_capacity, s->camera_count, sizeof *cameras);
    char *copy = cameras ? base_strdup(name) : NULL;
    b->failed |= !copy;
    if (cameras)
        s->cameras = cameras;
    if (!copy)
        return NULL;
    scene_camera *camera = &cameras[s->camera_count++];
    *camera = (scene_camera){.name = copy, .node = SCENE_NONE};
    scene_identity(camera->world);
    return camera;
}

void generate_camera(generate_builder *b, const char *name, const double eye[3],
                     const double target[3], double yfov_degrees, double near, double far) {
    scene_camera *camera = add_camera(b, name);
    if (!camera)
        return;
    double back[3], right[3], up[3];
    for (int i = 0; i < 3; i++)
        back[i] = eye[i] - target[i];
    generate_normalize(back);
    generate_cross((const double[3]){0, 1, 0}, back, right);
    generate_normalize(right);
    generate_cross(back, right, up);
    for (int i = 0; i < 3; i++) {
        camera->world[i] = (float)right[i];
        camera->world[4 + i] = (float)up[i];
        camera->world[8 + i] = (float)back[i];
        camera->world[12 + i] = (float)eye[i];
    }
    camera->yfov = (float)(yfov_degrees * (3.14159265358979323846 / 180));
    camera->znear = (float)near;
    camera->zfar = (float)far;
}

void generate_camera_flat(generate_builder *b, double half_x, double half_y, double far) {
    scene_camera *camera = add_camera(b, "flat");
    if (!camera)
        return;
    camera->projection = SCENE_ORTHOGRAPHIC;
    camera->xmag = (float)half_x;
    camera->ymag = (float)half_y;
    camera->zfar = (float)far;
}

static scene_light *add_light(generate_builder *b, const char *name, scene_light_kind kind,
                              const float color[3]) {
    scene *s = b->s;
    scene_light *lights =
        b->failed ? NULL : base_grow(s->lights, &b->light_capacity, s->light_count, sizeof *lights);
    char *copy = lights ? base_strdup(name) : NULL;
    b->failed |= !copy;
    if (lights)
        s->lights = lights;
    if (!copy)
        return NULL;
    scene_light *light = &lights[s->light_count++];
    *light = (scene_light){.name = copy,
                           .kind = kind,
                           .node = SCENE_NONE,
                           .color = {color[0], color[1], color[2]},
                           .inner_cos = 1,
                           .direction = {0, 0, -1}};
    return light;
}

void generate_sun(generate_builder *b, const double direction[3], const float color[3]) {
    scene_light *light = add_light(b, "sun", SCENE_DIRECTIONAL, color);
    double d[3] = {direction[0], direction[1], direction[2]};
    generate_normalize(d);
    for (int i = 0; light && i < 3; i++)
        light->direction[i] = (float)d[i];
}

void generate_lamp(generate_builder *b, const double position[3], const float color[3]) {
    scene_light *light = add_light(b, "lamp", SCENE_POINT, color);
    for (int i = 0; light && i < 3; i++)
        light->position[i] = (float)position[i];
}

uint32_t generate_image(generate_builder *b, const char *name, uint32_t width, uint32_t height,
                        unsigned char *pixels) {
    scene *s = b->s;
    scene_image *images =
        b->failed || !pixels ? NULL : base_realloc(s->images, s->image_count + 1, sizeof *images);
    char *copy = images ? base_strdup(name) : NULL;
    b->failed |= !copy;
    if (images)
        s->images = images;
    if (!copy) {
        free(pixels);
        return SCENE_NONE;
    }
    images[s->image_count] =
        (scene_image){.name = copy, .width = width, .height = height, .pixels = pixels};
    return s->image_count++;
}
