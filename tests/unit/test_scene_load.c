/* SPDX-License-Identifier: MIT
 *
 * What the glTF loader understands, feature by feature, on files built here byte by byte.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "unit/scene_fixture.h"

#define NONE UINT32_MAX

/* ---- geometry -------------------------------------------------------------------------------- */

static void a_bare_strip_gets_what_it_lacks(void **state) {
    (void)state;
    test_glb g = {0};
    add_square(&g);
    add_square_scene(&g, 5, "");
    scene *s = load_glb(&g);
    assert_int_equal(s->mesh_count, 1);
    assert_int_equal(s->instance_count, 1);
    assert_int_equal(s->primitive_count, 2);
    const scene_mesh *mesh = &s->meshes[0];
    assert_string_equal(mesh->name, "square/0");
    assert_int_equal(mesh->topology, SCENE_TRIANGLES);
    assert_int_equal(mesh->vertex_count, 6); /* flat normals: no vertex is shared */
    expect_indices(mesh, (const uint32_t[]){0, 1, 2, 3, 4, 5}, 6);
    expect_floats(mesh->positions,
                  (const float[]){0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 18);
    for (size_t i = 0; i < 6; i++)
        expect_floats(mesh->normals + i * 3, (const float[]){0, 0, 1}, 3);
    assert_null(mesh->tangents);
    assert_null(mesh->uv0);
    assert_null(mesh->colors);
    assert_null(mesh->deform);
    assert_int_equal(mesh->material, 0);
    assert_int_equal(s->material_count, 1);
    expect_floats(s->materials[0].base_color, (const float[]){1, 1, 1, 1}, 4);
    expect_floats(s->lower, (const float[]){0, 0, 0}, 3);
    expect_floats(s->upper, (const float[]){1, 1, 0}, 3);
    assert_null(s->animations);
    expect_warning(s, NULL);
    scene_free(s);
}

static void indices_of_every_type(void **state) {
    static const unsigned char bytes[6] = {2, 1, 0, 1, 2, 3};
    static const uint16_t shorts[6] = {2, 1, 0, 1, 2, 3};
    static const uint32_t words[6] = {2, 1, 0, 1, 2, 3};
    const struct {
        int type;
        const void *data;
        size_t size;
    } kinds[] = {{TEST_GLB_U8, bytes, 6}, {TEST_GLB_U16, shorts, 12}, {TEST_GLB_U32, words, 24}};
    static const float normals[12] = {0, 0, 2, 0, 0, 1, 0, 3, 4, 1e-30f, 0, 0};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(kinds); i++) {
        test_glb g = {0};
        add_square(&g);
        test_glb_floats(&g, "VEC3", 3, 4, normals);
        test_glb_accessor(&g, test_glb_view(&g, kinds[i].data, kinds[i].size, 0), kinds[i].type,
                          "SCALAR", 6, "");
        test_glb_json(&g, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                          "{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}]}]");
        scene *s = load_glb(&g);
        assert_int_equal(s->meshes[0].vertex_count, 4);
        expect_indices(&s->meshes[0], words, 6);
        expect_floats(s->meshes[0].normals, (const float[]){0, 0, 1, 0, 0, 1, 0, .6f, .8f, 1, 0, 0},
                      12);
        expect_warning(s, NULL);
        scene_free(s);
    }
}

static void strips_and_fans_keep_their_winding(void **state) {
    static const float flat[30] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 0, 0};
    static const uint32_t strip[9] = {0, 1, 2, 1, 3, 2, 2, 3, 4};
    static const uint32_t fan[9] = {1, 2, 0, 2, 3, 0, 3, 4, 0};
    (void)state;
    for (int mode = 5; mode <= 6; mode++) {
        test_glb g = {0};
        test_glb_floats(&g, "VEC3", 3, 5, flat);
        test_glb_floats(&g, "VEC3", 3, 5,
                        (const float[]){0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
        add_square_scene(&g, mode, ",\"NORMAL\":1");
        scene *s = load_glb(&g);
        expect_indices(&s->meshes[0], mode == 5 ? strip : fan, 9);
        scene_free(s);
    }
}

static void points_have_radii_and_bounds(void **state) {
    static const float radii[4] = {0.5f, -1, NAN, 2};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "SCALAR", 1, 4, radii);
    add_square_scene(&g, 0, ",\"_RADIUS\":1");
    scene *s = load_glb(&g);
    const scene_mesh *mesh = &s->meshes[0];
    assert_int_equal(mesh->topology, SCENE_POINTS);
    assert_int_equal(s->primitive_count, 4);
    assert_null(mesh->normals);
    expect_floats(mesh->radii, (const float[]){0.5f, 0, 0, 2}, 4);
    expect_floats(mesh->lower, (const float[]){-1, -1, -2}, 3);
    expect_floats(s->upper, (const float[]){3, 3, 2}, 3);
    expect_warning(s, "_RADIUS: 1 values are not finite");
    scene_free(s);
}

static void lines_and_leftovers_are_ignored_with_a_warning(void **state) {
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"name\":\"m\",\"primitives\":["
                      "{\"mode\":1,\"attributes\":{\"POSITION\":0}},"
                      "{\"mode\":4,\"attributes\":{\"POSITION\":0}},"
                      "{\"attributes\":{\"NORMAL\":0}}]}]");
    scene *s = load_glb(&g);
    assert_int_equal(s->mesh_count, 1);
    assert_int_equal(s->instance_count, 1);
    assert_int_equal(s->meshes[0].index_count, 3);
    assert_string_equal(s->meshes[0].name, "m/1");
    expect_warning(s, "test.glb: meshes[0] 'm' primitive 0: lines are not drawn");
    expect_warning(s, "primitive 1: 4 indices are not whole triangles: the last 1 ignored");
    expect_warning(s, "primitive 2: has no POSITION");
    scene_free(s);
}

static void zero_area_triangles_count(void **state) {
    (void)state;
    test_glb g = {0};
    test_glb_accessor(&g, NONE, TEST_GLB_F32, "VEC3", 9, "");
    add_square_scene(&g, 4, "");
    scene *s = load_glb(&g);
    assert_int_equal(s->primitive_count, 3);
    expect_floats(s->meshes[0].normals, (const float[]){0, 0, 1}, 3);
    scene_free(s);
}

/* ---- accessors ------------------------------------------------------------------------------- */

/* The positions of three points stored as `type`. */
static void expect_points(int type, const void *data, size_t size, uint32_t stride,
                          const char *more, const float expected[9]) {
    test_glb g = {0};
    test_glb_accessor(&g, test_glb_view(&g, data, size, stride), type, "VEC3", 3, more);
    add_square_scene(&g, 0, "");
    scene *s = load_glb(&g);
    expect_floats(s->meshes[0].positions, expected, 9);
    scene_free(s);
}

static void components_of_every_type(void **state) {
    static const signed char i8[12] = {0, 127, -128, 9, 64, -127, 1, 9, 0, 0, 0, 9};
    static const unsigned char u8[12] = {0, 255, 51, 9, 1, 2, 3, 9, 4, 5, 6, 9};
    static const int16_t i16[12] = {0, 32767, -32768, 9, 1, -1, 2, 9, 3, 4, 5, 9};
    static const uint16_t u16[12] = {0, 65535, 13107, 9, 1, 2, 3, 9, 4, 5, 6, 9};
    static const uint32_t u32[9] = {0, 4294967295u, 1, 2, 3, 4, 5, 6, 7};
    const char *unit = ",\"normalized\":true";
    (void)state;
    expect_points(TEST_GLB_I8, i8, 12, 4, "", (const float[]){0, 127, -128, 64, -127, 1, 0, 0, 0});
    expect_points(TEST_GLB_I8, i8, 12, 4, unit,
                  (const float[]){0, 1, -1, 64 / 127.f, -1, 1 / 127.f, 0, 0, 0});
    expect_points(TEST_GLB_U8, u8, 12, 4, "", (const float[]){0, 255, 51, 1, 2, 3, 4, 5, 6});
    expect_points(TEST_GLB_U8, u8, 12, 4, unit,
                  (const float[]){0, 1, .2f, 1 / 255.f, 2 / 255.f, 3 / 255.f, 4 / 255.f, 5 / 255.f,
                                  6 / 255.f});
    expect_points(TEST_GLB_I16, i16, 24, 8, unit,
                  (const float[]){0, 1, -1, 1 / 32767.f, -1 / 32767.f, 2 / 32767.f, 3 / 32767.f,
                                  4 / 32767.f, 5 / 32767.f});
    expect_points(TEST_GLB_U16, u16, 24, 8, unit,
                  (const float[]){0, 1, .2f, 1 / 65535.f, 2 / 65535.f, 3 / 65535.f, 4 / 65535.f,
                                  5 / 65535.f, 6 / 65535.f});
    expect_points(TEST_GLB_U32, u32, 36, 0, "",
                  (const float[]){0, 4294967295.f, 1, 2, 3, 4, 5, 6, 7});
}

static void interleaved_attributes_with_offsets(void **state) {
    float rows[4][8];
    (void)state;
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 8; k++)
            rows[i][k] = (float)(i * 10 + k);
    test_glb g = {0};
    uint32_t view = test_glb_view(&g, rows, sizeof rows, 32);
    test_glb_accessor(&g, view, TEST_GLB_F32, "VEC3", 4, "");
    test_glb_accessor(&g, view, TEST_GLB_F32, "VEC2", 4, ",\"byteOffset\":12");
    test_glb_accessor(&g, view, TEST_GLB_F32, "VEC3", 4, ",\"byteOffset\":20");
    add_square_scene(&g, 5, ",\"NORMAL\":2,\"TEXCOORD_0\":1,\"TEXCOORD_1\":1");
    scene *s = load_glb(&g);
    expect_floats(s->meshes[0].positions + 9, (const float[]){30, 31, 32}, 3);
    expect_floats(s->meshes[0].uv0, (const float[]){3, 4, 13, 14, 23, 24, 33, 34}, 8);
    expect_floats(s->meshes[0].uv1 + 6, (const float[]){33, 34}, 2);
    float length = sqrtf(5 * 5 + 6 * 6 + 7 * 7);
    expect_floats(s->meshes[0].normals, (const float[]){5 / length, 6 / length, 7 / length}, 3);
    scene_free(s);
}

static void sparse_values_replace(void **state) {
    static const uint16_t at[2] = {1, 2};
    static const float values[6] = {7, 8, 9, -1, -2, -3};
    char more[200];
    (void)state;
    for (int based = 0; based < 2; based++) {
        test_glb g = {0};
        static const float base[9] = {1, 1, 1, 2, 2, 2, 3, 3, 3};
        uint32_t view = based ? test_glb_view(&g, base, sizeof base, 0) : NONE;
        uint32_t index = test_glb_view(&g, at, sizeof at, 0),
                 value = test_glb_view(&g, values, 24, 0);
        snprintf(more, sizeof more,
                 ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":%u,\"componentType\":5123},"
                 "\"values\":{\"bufferView\":%u}}",
                 index, value);
        test_glb_accessor(&g, view, TEST_GLB_F32, "VEC3", 3, more);
        add_square_scene(&g, 0, "");
        scene *s = load_glb(&g);
        float first = based ? 1.0f : 0.0f;
        expect_floats(s->meshes[0].positions,
                      (const float[]){first, first, first, 7, 8, 9, -1, -2, -3}, 9);
        scene_free(s);
    }
}

static void sparse_indices_without_a_view(void **state) {
    static const unsigned char at[4] = {1, 2, 0, 0};
    static const uint16_t values[2] = {1, 2};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    uint32_t index = test_glb_view(&g, at, 2, 0), value = test_glb_view(&g, values, 4, 0);
    char more[200];
    snprintf(more, sizeof more,
             ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":%u,\"componentType\":5121},"
             "\"values\":{\"bufferView\":%u}}",
             index, value);
    test_glb_accessor(&g, NONE, TEST_GLB_U16, "SCALAR", 6, more);
    test_glb_floats(&g, "VEC3", 3, 4, (const float[]){0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1});
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                      "{\"POSITION\":0,\"NORMAL\":2},\"indices\":1}]}]");
    scene *s = load_glb(&g);
    expect_indices(&s->meshes[0], (const uint32_t[]){0, 1, 2, 0, 0, 0}, 6);
    scene_free(s);
}

static void colors_of_three_and_four_components(void **state) {
    static const unsigned char three[16] = {255, 0, 51, 9, 0, 255, 0, 9, 1, 2, 3, 9, 0, 0, 0, 9};
    static const uint16_t four[16] = {65535, 0, 0, 13107, 0, 0, 0, 65535};
    static const float wild[16] = {2, -1, NAN, 7};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_accessor(&g, test_glb_view(&g, three, 16, 4), TEST_GLB_U8, "VEC3", 4,
                      ",\"normalized\":true");
    test_glb_accessor(&g, test_glb_view(&g, four, 32, 8), TEST_GLB_U16, "VEC4", 4,
                      ",\"normalized\":true");
    test_glb_floats(&g, "VEC4", 4, 4, wild);
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":["
                      "{\"mode\":0,\"attributes\":{\"POSITION\":0,\"COLOR_0\":1}},"
                      "{\"mode\":0,\"attributes\":{\"POSITION\":0,\"COLOR_0\":2}},"
                      "{\"mode\":0,\"attributes\":{\"POSITION\":0,\"COLOR_0\":3}}]}]");
    scene *s = load_glb(&g);
    expect_floats(s->meshes[0].colors, (const float[]){1, 0, .2f, 1, 0, 1, 0, 1}, 8);
    expect_floats(s->meshes[1].colors, (const float[]){1, 0, 0, .2f, 0, 0, 0, 1}, 8);
    expect_floats(s->meshes[2].colors, (const float[]){2, 0, 0, 1}, 4);
    expect_warning(s, "primitive 2: COLOR_0: 1 values are not finite");
    scene_free(s);
}

static void bad_normals_come_from_the_faces(void **state) {
    static const float normals[12] = {0, 0, 0, 0, 0, -1, NAN, 0, 1, 0, 0, -1};
    static const float tangents[16] = {1, 0, 0, 1, 1, 0, 0, -1, 0, 0, 0, 1, 1, 0, 0, 1};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "VEC3", 3, 4, normals);
    test_glb_floats(&g, "VEC4", 4, 4, tangents);
    add_square_scene(&g, 5, ",\"NORMAL\":1,\"TANGENT\":2");
    scene *s = load_glb(&g);
    expect_floats(s->meshes[0].normals, (const float[]){0, 0, 1, 0, 0, -1, 0, 0, 1, 0, 0, -1}, 12);
    assert_null(s->meshes[0].tangents);
    expect_warning(s, "NORMAL: 2 of 4 are zero or not finite");
    expect_warning(s, "TANGENT: zero or not finite");
    scene_free(s);
}

/* ---- nodes ----------------------------------------------------------------------------------- */

static void transforms_chain_and_meshes_are_shared(void **state) {
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_json(&g, "\"scene\":1,\"scenes\":[{},{\"nodes\":[3,0]}],\"nodes\":["
                      "{\"mesh\":0,\"children\":[1],\"translation\":[1,2,3],\"scale\":[2,2,2]},"
                      "{\"mesh\":0,\"rotation\":[0,0,1.4142135,1.4142135],\"translation\":[1,0,0]},"
                      "{\"mesh\":0,\"name\":\"not in the scene\"},"
                      "{\"mesh\":0,\"matrix\":[1,0,0,0,0,-1,0,0,0,0,1,0,5,6,7,1]}]");
    test_glb_json(&g,
                  "\"meshes\":[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0}}]}]");
    scene *s = load_glb(&g);
    assert_int_equal(s->mesh_count, 1);
    assert_int_equal(s->instance_count, 3);
    assert_int_equal(s->instances[0].node, 3);
    expect_floats(s->instances[0].world,
                  (const float[]){1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}, 16);
    expect_floats(s->instances[1].world,
                  (const float[]){2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 2, 3, 1}, 16);
    expect_floats(s->instances[2].world,
                  (const float[]){0, 2, 0, 0, -2, 0, 0, 0, 0, 0, 2, 0, 3, 2, 3, 1}, 16);
    for (uint32_t i = 0; i < 3; i++)
        assert_int_equal(s->instances[i].primitive_base, i * 2);
    assert_int_equal(s->primitive_count, 6);
    expect_floats(s->lower, (const float[]){1, 2, 3}, 3);
    expect_floats(s->upper, (const float[]){6, 6, 7}, 3);
    scene_free(s);
}

static void gpu_instances(void **state) {
    static const float moves[6] = {1, 0, 0, 0, 2, 0}, scales[6] = {2, 2, 2, 1, 1, 3};
    static const int16_t turns[8] = {0, 0, 0, 32767, 0, 0, 32767, 0};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "VEC3", 3, 2, moves);
    test_glb_accessor(&g, test_glb_view(&g, turns, 16, 0), TEST_GLB_I16, "VEC4", 2,
                      ",\"normalized\":true");
    test_glb_floats(&g, "VEC3", 3, 2, scales);
    test_glb_json(&g,
                  "\"nodes\":[{\"mesh\":0,\"translation\":[0,0,9],\"extensions\":"
                  "{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":1,\"ROTATION\":2,"
                  "\"SCALE\":3,\"_ID\":0}}}}],\"meshes\":[{\"primitives\":["
                  "{\"mode\":5,\"attributes\":{\"POSITION\":0}},{\"mode\":0,\"attributes\":"
                  "{\"POSITION\":0}}]}],\"extensionsRequired\":[\"EXT_mesh_gpu_instancing\"]");
    scene *s = load_glb(&g);
    assert_int_equal(s->mesh_count, 2);
    assert_int_equal(s->instance_count, 4);
    expect_floats(s->instances[1].world,
                  (const float[]){2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 1, 0, 9, 1}, 16);
    expect_floats(s->instances[2].local,
                  (const float[]){-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 3, 0, 0, 2, 0, 1}, 16);
    expect_floats(s->instances[3].world,
                  (const float[]){-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 3, 0, 0, 2, 9, 1}, 16);
    const uint32_t bases[4] = {0, 2, 6, 8};
    for (uint32_t i = 0; i < 4; i++)
        assert_int_equal(s->instances[i].primitive_base, bases[i]);
    assert_int_equal(s->primitive_count, 12);
    scene_free(s);
}

static void cameras_and_lights_stand_in_the_world(void **state) {
    (void)state;
    test_glb g = {0};
    test_glb_json(&g, "\"nodes\":[{\"translation\":[0,0,5],\"scale\":[3,3,3],\"children\":[1,2,3]},"
                      "{\"camera\":0},{\"camera\":1,\"extensions\":{\"KHR_lights_punctual\":"
                      "{\"light\":0}}},{\"rotation\":[0,0.70710678,0,0.70710678],\"camera\":2,"
                      "\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}}]");
    test_glb_json(&g,
                  "\"cameras\":[{\"type\":\"perspective\",\"name\":\"eye\",\"perspective\":"
                  "{\"yfov\":0.75,\"znear\":0.5,\"aspectRatio\":1.5}},{\"type\":\"orthographic\","
                  "\"orthographic\":{\"xmag\":2,\"ymag\":3,\"znear\":0,\"zfar\":10}},"
                  "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":0,\"ymag\":3,\"znear\":0,"
                  "\"zfar\":10}}]");
    test_glb_json(&g,
                  "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\","
                  "\"range\":20,\"intensity\":3,\"color\":[1,0.5,0]},{\"type\":\"spot\",\"name\":"
                  "\"torch\",\"spot\":{\"innerConeAngle\":0.25,\"outerConeAngle\":0.5}}]}}");
    scene *s = load_glb(&g);
    assert_int_equal(s->camera_count, 2);
    const scene_camera *c = s->cameras;
    assert_string_equal(c[0].name, "eye");
    assert_int_equal(c[0].projection, SCENE_PERSPECTIVE);
    expect_floats((const float[]){c[0].yfov, c[0].znear, c[0].zfar, c[0].aspect},
                  (const float[]){0.75f, 0.5f, 0, 1.5f}, 4);
    expect_floats(c[0].world, (const float[]){1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1}, 16);
    assert_int_equal(c[1].projection, SCENE_ORTHOGRAPHIC);
    expect_floats((const float[]){c[1].xmag, c[1].ymag, c[1].znear, c[1].zfar},
                  (const float[]){2, 3, 0, 10}, 4);
    expect_warning(s, "cameras[2]: sees nothing");
    assert_int_equal(s->light_count, 2);
    const scene_light *l = s->lights;
    assert_int_equal(l[0].kind, SCENE_POINT);
    expect_floats(l[0].color, (const float[]){3, 1.5f, 0}, 3);
    expect_floats(l[0].position, (const float[]){0, 0, 5}, 3);
    expect_floats(&l[0].range, (const float[]){20}, 1);
    assert_string_equal(l[1].name, "torch");
    assert_int_equal(l[1].kind, SCENE_SPOT);
    expect_floats(l[1].direction, (const float[]){-1, 0, 0}, 3);
    expect_floats((const float[]){l[1].inner_cos, l[1].outer_cos},
                  (const float[]){cosf(0.25f), cosf(0.5f)}, 2);
    scene_free(s);
}

static void an_empty_scene_is_one(void **state) {
    (void)state;
    test_glb g = {0};
    scene *s = load_glb(&g);
    assert_int_equal(s->instance_count, 0);
    assert_int_equal(s->primitive_count, 0);
    assert_true(s->lower[0] > s->upper[0]);
    scene_free(s);
    scene_free(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bare_strip_gets_what_it_lacks),
        cmocka_unit_test(indices_of_every_type),
        cmocka_unit_test(strips_and_fans_keep_their_winding),
        cmocka_unit_test(points_have_radii_and_bounds),
        cmocka_unit_test(lines_and_leftovers_are_ignored_with_a_warning),
        cmocka_unit_test(zero_area_triangles_count),
        cmocka_unit_test(components_of_every_type),
        cmocka_unit_test(interleaved_attributes_with_offsets),
        cmocka_unit_test(sparse_values_replace),
        cmocka_unit_test(sparse_indices_without_a_view),
        cmocka_unit_test(colors_of_three_and_four_components),
        cmocka_unit_test(bad_normals_come_from_the_faces),
        cmocka_unit_test(transforms_chain_and_meshes_are_shared),
        cmocka_unit_test(gpu_instances),
        cmocka_unit_test(cameras_and_lights_stand_in_the_world),
        cmocka_unit_test(an_empty_scene_is_one),
    };
    return cmocka_run_group_tests_name("scene loading", tests, NULL, NULL);
}
