/* SPDX-License-Identifier: MIT
 *
 * The scenes of stage.h, and drawing them on a backend by name.
 */
#include "gpu/stage.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

const char *const stage_backends[2] = {"vulkan", "gl"};

static float *copy(const float *values, size_t count) {
    float *out = base_calloc(count, sizeof *out);
    assert_non_null(out);
    memcpy(out, values, count * sizeof *out);
    return out;
}

stage stage_new(void) {
    stage t = {.s = scene_new("stage")};
    assert_non_null(t.s);
    scene_camera *camera = base_calloc(1, sizeof *camera);
    assert_non_null(camera);
    *camera = (scene_camera){.projection = SCENE_ORTHOGRAPHIC,
                             .node = SCENE_NONE,
                             .znear = 1.0f,
                             .zfar = 9.0f,
                             .xmag = 1.0f,
                             .ymag = 1.0f};
    scene_identity(camera->world);
    camera->world[14] = 5.0f;
    t.s->cameras = camera;
    t.s->camera_count = 1;
    return t;
}

uint32_t stage_material(stage *t, float r, float g, float b) {
    scene_material *m = scene_add_material(t->s, &t->materials);
    assert_non_null(m);
    m->unlit = m->double_sided = 1;
    m->base_color[0] = r;
    m->base_color[1] = g;
    m->base_color[2] = b;
    return t->s->material_count - 1;
}

static uint32_t add_instance(stage *t) {
    scene_instance *instance = scene_add_instance(t->s, &t->instances);
    assert_non_null(instance);
    instance->mesh = t->s->mesh_count - 1;
    return t->s->instance_count - 1;
}

uint32_t stage_quad(stage *t, uint32_t material, float x0, float y0, float x1, float y1, float z) {
    static const float uv[8] = {0, 1, 1, 1, 1, 0, 0, 0};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    const float positions[12] = {x0, y0, z, x1, y0, z, x1, y1, z, x0, y1, z};
    scene_mesh *mesh = scene_add_mesh(t->s, &t->meshes);
    assert_non_null(mesh);
    mesh->material = material;
    mesh->vertex_count = 4;
    mesh->index_count = 6;
    mesh->positions = copy(positions, 12);
    mesh->uv0 = copy(uv, 8);
    mesh->indices = base_calloc(6, sizeof *mesh->indices);
    assert_non_null(mesh->indices);
    memcpy(mesh->indices, indices, sizeof indices);
    return add_instance(t);
}

uint32_t stage_points(stage *t, uint32_t material, const float *positions, const float *radii,
                      uint32_t count) {
    scene_mesh *mesh = scene_add_mesh(t->s, &t->meshes);
    assert_non_null(mesh);
    mesh->topology = SCENE_POINTS;
    mesh->material = material;
    mesh->vertex_count = mesh->index_count = count;
    mesh->positions = copy(positions, (size_t)count * 3);
    mesh->radii = radii ? copy(radii, count) : NULL;
    mesh->indices = base_calloc(count, sizeof *mesh->indices);
    assert_non_null(mesh->indices);
    for (uint32_t i = 0; i < count; i++)
        mesh->indices[i] = i;
    return add_instance(t);
}

uint32_t stage_image(stage *t, uint32_t width, uint32_t height, const unsigned char *pixels) {
    scene_image *images = base_realloc(t->s->images, t->s->image_count + 1u, sizeof *images);
    assert_non_null(images);
    t->s->images = images;
    scene_image *image = &images[t->s->image_count++];
    *image = (scene_image){
        .width = width, .height = height, .pixels = base_calloc((size_t)width * height, 4)};
    assert_non_null(image->pixels);
    memcpy(image->pixels, pixels, (size_t)width * height * 4);
    return t->s->image_count - 1;
}

void stage_finish(stage *t) {
    base_error err = {0};
    if (scene_finish(t->s, &err) != STRATA_OK)
        fail_msg("%s", err.text);
}

gpu *stage_open(const char *backend) {
    gpu_open_info info = {.backend = backend, .check = 1};
    base_error err = {0};
    gpu *g = NULL;
    if (gpu_open(&info, &g, &err) == STRATA_OK)
        return g;
    print_message("%s left out: %s\n", backend, err.text);
    return NULL;
}

drawing stage_draw(gpu *g, const scene *s, drawing_options options) {
    drawing d;
    base_error err = {0};
    if (!drawing_make(&d, g, s, &options, &err))
        fail_msg("%s", err.text);
    const char *folder = getenv("STRATA_TEST_PICTURES");
    if (folder) {
        static unsigned number;
        char path[512];
        snprintf(path, sizeof path, "%s/%03u.png", folder, number++);
        drawing_save(&d, path);
    }
    return d;
}

const float *stage_pixel(const drawing *d, uint32_t x, uint32_t y) {
    return d->pixels + ((size_t)y * d->width + x) * 4;
}

int stage_same(const drawing *a, const drawing *b) {
    size_t count = (size_t)a->width * a->height;
    return a->width == b->width && a->height == b->height &&
           memcmp(a->pixels, b->pixels, count * 16) == 0 &&
           memcmp(a->depths, b->depths, count * 4) == 0;
}
