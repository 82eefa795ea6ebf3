/* SPDX-License-Identifier: MIT
 *
 * The GLB writer: every procedural scene, and one with all that none of them has, is the same scene
 * after it was written and loaded.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/generated.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

static char folder[64];

static int make_folder(void **state) {
    (void)state;
    snprintf(folder, sizeof folder, "/tmp/strata-write-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    char command[128];
    (void)state;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

static void assert_near(const float *a, const float *b, size_t count, double tolerance) {
    assert_true(!a == !b);
    for (size_t i = 0; a && i < count; i++)
        if (!(fabs((double)a[i] - (double)b[i]) <= tolerance * fmax(1, fabs((double)a[i]))))
            fail_msg("value %zu: %.9g became %.9g", i, (double)a[i], (double)b[i]);
}

static void assert_same_mesh(const scene_mesh *a, const scene_mesh *b) {
    assert_int_equal(a->topology, b->topology);
    assert_int_equal(a->material, b->material);
    assert_int_equal(a->vertex_count, b->vertex_count);
    assert_int_equal(a->index_count, b->index_count);
    assert_memory_equal(a->indices, b->indices, a->index_count * sizeof(uint32_t));
    size_t n = a->vertex_count;
    assert_near(a->positions, b->positions, n * 3, 0);
    assert_near(a->normals, b->normals, n * 3, 1e-6); /* the loader normalises once more */
    assert_near(a->uv0, b->uv0, n * 2, 0);
    assert_near(a->colors, b->colors, n * 4, 0);
    assert_near(a->radii, b->radii, n, 0);
}

static void assert_same_texture(const scene *sa, const scene_texture *a, const scene *sb,
                                const scene_texture *b) {
    assert_int_equal(a->image == SCENE_NONE, b->image == SCENE_NONE);
    if (a->image == SCENE_NONE)
        return;
    const scene_image *x = &sa->images[a->image], *y = &sb->images[b->image];
    assert_int_equal(x->width, y->width);
    assert_int_equal(x->height, y->height);
    assert_memory_equal(x->pixels, y->pixels, (size_t)x->width * x->height * 4);
    assert_near(a->scale_rotate, b->scale_rotate, 4, 1e-6);
    assert_near(a->offset, b->offset, 2, 1e-6);
    assert_int_equal(a->uv, b->uv);
    assert_int_equal(a->magnify, b->magnify);
    assert_int_equal(a->minify, b->minify);
    assert_int_equal(a->mipmap, b->mipmap);
    assert_int_equal(a->wrap_u, b->wrap_u);
    assert_int_equal(a->wrap_v, b->wrap_v);
}

static void assert_same_material(const scene *sa, const scene_material *a, const scene *sb,
                                 const scene_material *b) {
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->alpha, b->alpha);
    assert_int_equal(a->double_sided, b->double_sided);
    assert_int_equal(a->unlit, b->unlit);
    assert_near(a->base_color, b->base_color, 4, 0);
    assert_near(a->emissive, b->emissive, 3, 1e-6);
    const float x[] = {a->metallic,     a->roughness,          a->ior,         a->transmission,
                       a->normal_scale, a->occlusion_strength, a->alpha_cutoff};
    const float y[] = {b->metallic,     b->roughness,          b->ior,         b->transmission,
                       b->normal_scale, b->occlusion_strength, b->alpha_cutoff};
    assert_near(x, y, BASE_COUNT(x), 0);
    assert_same_texture(sa, &a->base_color_texture, sb, &b->base_color_texture);
    assert_same_texture(sa, &a->metallic_roughness_texture, sb, &b->metallic_roughness_texture);
    assert_same_texture(sa, &a->normal_texture, sb, &b->normal_texture);
    assert_same_texture(sa, &a->occlusion_texture, sb, &b->occlusion_texture);
    assert_same_texture(sa, &a->emissive_texture, sb, &b->emissive_texture);
    assert_same_texture(sa, &a->transmission_texture, sb, &b->transmission_texture);
}

static void assert_same_scene(const scene *a, const scene *b) {
    assert_int_equal(a->mesh_count, b->mesh_count);
    assert_int_equal(a->instance_count, b->instance_count);
    assert_int_equal(a->material_count, b->material_count);
    assert_int_equal(a->light_count, b->light_count);
    assert_int_equal(a->camera_count, b->camera_count);
    assert_int_equal(a->primitive_count, b->primitive_count);
    for (uint32_t i = 0; i < a->mesh_count; i++)
        assert_same_mesh(&a->meshes[i], &b->meshes[i]);
    for (uint32_t i = 0; i < a->instance_count; i++) {
        assert_int_equal(a->instances[i].mesh, b->instances[i].mesh);
        assert_int_equal(a->instances[i].primitive_base, b->instances[i].primitive_base);
        assert_near(a->instances[i].world, b->instances[i].world, 16, 2e-6);
    }
    for (uint32_t i = 0; i < a->material_count; i++)
        assert_same_material(a, &a->materials[i], b, &b->materials[i]);
    for (uint32_t i = 0; i < a->light_count; i++) {
        const scene_light *x = &a->lights[i], *y = &b->lights[i];
        assert_int_equal(x->kind, y->kind);
        assert_near(x->color, y->color, 3, 1e-6);
        if (x->kind != SCENE_DIRECTIONAL)
            assert_near(x->position, y->position, 3, 1e-6);
        if (x->kind != SCENE_POINT)
            assert_near(x->direction, y->direction, 3, 1e-6);
        const float range[2] = {x->range, y->range};
        assert_near(range, range + 1, 1, 0);
        if (x->kind == SCENE_SPOT) {
            assert_near(&x->inner_cos, &y->inner_cos, 1, 1e-6);
            assert_near(&x->outer_cos, &y->outer_cos, 1, 1e-6);
        }
    }
    for (uint32_t i = 0; i < a->camera_count; i++) {
        const scene_camera *x = &a->cameras[i], *y = &b->cameras[i];
        assert_string_equal(x->name, y->name);
        assert_int_equal(x->projection, y->projection);
        const float p[] = {x->yfov, x->aspect, x->znear, x->zfar, x->xmag, x->ymag};
        const float q[] = {y->yfov, y->aspect, y->znear, y->zfar, y->xmag, y->ymag};
        assert_near(p, q, BASE_COUNT(p), 0);
        assert_near(x->world, y->world, 16, 1e-6);
    }
}

static void round_trip(const scene *s) {
    char path[128];
    base_error err = {0};
    scene *back = NULL;
    snprintf(path, sizeof path, "%s/scene.glb", folder);
    if (scene_write_glb(s, path, &err) != STRATA_OK || scene_load(path, &back, &err) != STRATA_OK)
        fail_msg("%s: %s", s->path, err.text);
    for (uint32_t i = 0; i < back->warning_count; i++)
        fail_msg("%s: warning: %s", s->path, back->warnings[i]);
    assert_same_scene(s, back);
    scene_free(back);
}

static void every_scene_survives_the_file(void **state) {
    (void)state;
    static const char *const texts[] = {"shells",
                                        "shells transmission=0.9",
                                        "soup small=500 medium=20",
                                        "hairball",
                                        "needles",
                                        "particles",
                                        "stack opaque=1 tilt=20",
                                        "city count=300",
                                        "city view=aerial count=20",
                                        "layers opaque=1 where=pixel",
                                        "glass",
                                        "hard:crossing",
                                        "hard:near-plane",
                                        "hard:huge",
                                        "hard:tiny",
                                        "hard:layers-0",
                                        "hard:alpha-denormal",
                                        "hard:hdr-million",
                                        "hard:straight"};
    for (size_t i = 0; i < BASE_COUNT(texts); i++) {
        scene *s = generated(texts[i]);
        round_trip(s);
        scene_free(s);
    }
}

/* All that no generator makes: turned, mirrored and sheared instances of one mesh, odd names,
 * every texture slot and filter, emission above 1, a spot light, an invisible instance. */
static void odd_scenes_survive_the_file(void **state) {
    (void)state;
    scene *s = generated("city count=12 glass=1 seed=3");
    free(s->materials[0].name);
    s->materials[0].name = base_strdup("a \"quoted\" \\ name\twith \xc3\xa9");
    scene_material *m = &s->materials[1];
    scene_texture *slots[] = {&m->metallic_roughness_texture, &m->normal_texture,
                              &m->occlusion_texture, &m->emissive_texture,
                              &m->transmission_texture};
    for (size_t i = 0; i < BASE_COUNT(slots); i++) {
        double angle = 0.3 + (double)i, c = cos(angle), n = sin(angle);
        *slots[i] = (scene_texture){
            .image = 0,
            .scale_rotate = {(float)(2 * c), (float)(-0.5 * -n), (float)(-2 * n), (float)(0.5 * c)},
            .offset = {0.25f, (float)i},
            .magnify = i % 2 ? SCENE_LINEAR : SCENE_NEAREST,
            .minify = i % 2 ? SCENE_NEAREST : SCENE_LINEAR,
            .mipmap = (scene_mipmap)(i % 3),
            .wrap_u = (scene_wrap)(i % 3),
            .wrap_v = (scene_wrap)((i + 1) % 3)};
    }
    m->emissive[0] = 7.5f;
    m->emissive[1] = 0.25f;
    m->ior = 1.33f;
    m->transmission = 0.5f;
    m->alpha = SCENE_MASK;
    m->alpha_cutoff = 0.3f;
    m->normal_scale = 0.7f;
    m->occlusion_strength = 0.6f;
    s->lights[1] = (scene_light){.name = s->lights[1].name,
                                 .kind = SCENE_SPOT,
                                 .node = SCENE_NONE,
                                 .color = {3, 2, 1},
                                 .range = 50,
                                 .inner_cos = 0.9f,
                                 .outer_cos = 0.6f,
                                 .position = {1, 2, 3},
                                 .direction = {0, 0.6f, 0.8f}};
    for (uint32_t i = 2; i < s->instance_count; i++) {
        float *w = s->instances[i].world, angle = 0.7f * (float)i;
        const float c = cosf(angle), n = sinf(angle);
        memcpy(w, (const float[12]){2 * c, 0, -2 * n, 0, 0, i % 3 ? 3.0f : -3.0f, 0, 0, n, 0, c, 0},
               12 * sizeof(float));
        if (i % 5 == 0)
            w[4] = 0.5f; /* shear */
    }
    round_trip(s);
    s->instances[s->instance_count - 1].visible = 0;
    char path[128];
    base_error err = {0};
    scene *back;
    snprintf(path, sizeof path, "%s/hidden.glb", folder);
    assert_int_equal(scene_write_glb(s, path, &err), STRATA_OK);
    assert_int_equal(scene_load(path, &back, &err), STRATA_OK);
    assert_int_equal(back->instance_count, s->instance_count - 1);
    scene_free(back);
    err = (base_error){0};
    assert_int_equal(scene_write_glb(s, "/no/such/folder/x.glb", &err), STRATA_ERROR_NOT_FOUND);
    scene_free(s);
}

/* Hundreds of houses are a few nodes, not hundreds. */
static void repeated_meshes_are_instanced(void **state) {
    (void)state;
    char path[128];
    base_error err = {0};
    unsigned char *data;
    size_t size, nodes = 0;
    scene *s = generated("city count=900");
    snprintf(path, sizeof path, "%s/city.glb", folder);
    assert_int_equal(scene_write_glb(s, path, &err), STRATA_OK);
    assert_int_equal(base_file_read(path, 1 << 24, &data, &size, &err), STRATA_OK);
    for (const char *at = (char *)data + 20; (at = strstr(at, "\"mesh\":")); at++)
        nodes++;
    assert_in_range(nodes, 2, 8);
    assert_non_null(
        strstr((char *)data + 20, "\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"]"));
    free(data);
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_survives_the_file),
        cmocka_unit_test(odd_scenes_survive_the_file),
        cmocka_unit_test(repeated_meshes_are_instanced),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
