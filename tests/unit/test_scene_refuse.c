/* SPDX-License-Identifier: MIT
 *
 * Broken glTF files: each kind of damage gives one line that names the file and the place, and
 * nothing is left allocated (the leak checker of a sanitizer build sees to that).
 */
#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "unit/scene_fixture.h"

#define NONE UINT32_MAX

/* ---- JSON ------------------------------------------------------------------------------------ */

static void refuse_json(const char *json, const char *part) {
    base_error err = {0};
    scene *s;
    assert_int_equal(scene_load_memory("bad.gltf", json, strlen(json), &s, &err),
                     STRATA_ERROR_BAD_FILE);
    assert_null(s);
    if (strncmp(err.text, "bad.gltf: ", 10) != 0 || !strstr(err.text, part))
        fail_msg("'%s' does not say '%s'", err.text, part);
}

static void text_that_is_not_gltf(void **state) {
    static const char *const cases[][2] = {
        {"", "is neither a GLB nor a JSON object"},
        {"{\"asset\":\n{\"version\" \"2.0\"}}", "JSON line 2"},
        {"{\"asset\":{\"version\":\"2.0\"}", "JSON line 1"},
        {" \n[]", "is neither a GLB nor a JSON object"},
        {"{\"asset\":{\"version\":\"1.1\"},\"nodes\":{}}", "asset.version: '1.1' is not supported"},
        {"{}", "has no 'asset'"},
        {"{\"asset\":{}}", "asset: has no 'version'"},
        {"{\"asset\":{\"version\":\"1.0\"}}", "asset.version: '1.0' is not supported"},
        {"{\"asset\":{\"version\":2.0}}", "asset.version: must be text, is a number"},
        {"{\"asset\":{\"version\":\"2.9\",\"minVersion\":\"2.9\"}}", "asset.minVersion: '2.9'"},
        {"{\"asset\":{\"version\":\"2.0\"},\"a\":1e999}", "JSON line 1"},
        {"{\"asset\":{\"version\":\"2.0\",\"generator\":\"\xff\"}}", "JSON line 1"},
    };
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); i++)
        refuse_json(cases[i][0], cases[i][1]);
}

static void members_of_the_wrong_kind(void **state) {
    static const char *const cases[][2] = {
        {"\"scene\":0", "scene: there is no scenes[0] (0 exist)"},
        {"\"nodes\":{}", "nodes: must be an array, is an object"},
        {"\"nodes\":[7]", "nodes[0]: must be an object, is an integer"},
        {"\"nodes\":[{\"mesh\":0}]", "nodes[0].mesh: there is no meshes[0] (0 exist)"},
        {"\"nodes\":[{},{\"children\":[0,2]}]", "nodes[1].children[1]: there is no nodes[2]"},
        {"\"nodes\":[{\"children\":[-1]}]", "nodes[0].children[0]: there is no nodes[-1]"},
        {"\"nodes\":[{\"children\":[0.5]}]", "nodes[0].children[0]: must be an index, is a number"},
        {"\"nodes\":[{\"matrix\":[1,2]}]", "nodes[0].matrix: must hold 16 numbers, holds 2"},
        {"\"nodes\":[{\"scale\":[1,2,null]}]", "nodes[0].scale[2]: must be a number, is null"},
        {"\"nodes\":[{\"scale\":[1,2,1e39]}]", "nodes[0].scale[2]: 1e+39 is beyond"},
        {"\"nodes\":[{\"name\":[]}]", "nodes[0].name: must be text, is an array"},
        {"\"meshes\":[{}]", "meshes[0]: has no 'primitives'"},
        {"\"meshes\":[{\"primitives\":[{}]}]", "meshes[0].primitives[0]: has no 'attributes'"},
        {"\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":3}}]}]",
         "meshes[0].primitives[0].attributes.POSITION: there is no accessors[3]"},
        {"\"meshes\":[{\"primitives\":[{\"attributes\":{},\"mode\":7}]}]", "mode: 7 is none of"},
        {"\"accessors\":[{\"componentType\":5124,\"count\":1,\"type\":\"VEC3\"}]",
         "accessors[0].componentType: 5124 is none of"},
        {"\"accessors\":[{\"componentType\":5126,\"count\":-1,\"type\":\"VEC3\"}]",
         "accessors[0].count: -1 is out of range"},
        {"\"accessors\":[{\"componentType\":5126,\"count\":1,\"type\":\"VEC\"}]",
         "accessors[0].type: 'VEC' is none of"},
        {"\"bufferViews\":[{\"buffer\":0,\"byteLength\":4}]", "bufferViews[0].buffer: there is no"},
        {"\"materials\":[{\"doubleSided\":1}]", "materials[0].doubleSided: must be true or false"},
        {"\"materials\":[{\"alphaMode\":\"GLASS\"}]", "materials[0].alphaMode: 'GLASS' is none of"},
        {"\"materials\":[{\"extensions\":{\"KHR_materials_ior\":{\"ior\":\"1\"}}}]",
         "materials[0].extensions.KHR_materials_ior.ior: must be a number"},
        {"\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0,\"znear\":1}}]",
         "cameras[0].perspective.yfov: must be above 0"},
        {"\"cameras\":[{\"type\":\"perspective\"}]", "cameras[0]: has no 'perspective'"},
        {"\"animations\":[{\"samplers\":[],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
         "\"path\":\"scale\"}}]}],\"nodes\":[{}]",
         "animations[0].channels[0].sampler: there is no sampler 0"},
        {"\"extensionsRequired\":[\"KHR_materials_unlit\",\"KHR_draco_mesh_compression\"]",
         "extensionsRequired[1]: KHR_draco_mesh_compression is not supported"},
        {"\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"spot\"}]}}",
         "lights[0]: has no 'spot'"},
        {"\"extensionsUsed\":[0]", "extensionsUsed[0]: must be text"},
        {"\"buffers\":[{\"byteLength\":4}]", "buffers[0]: has no uri"},
        {"\"buffers\":[{\"byteLength\":4,\"uri\":\"data:,abcd\"}]",
         "buffers[0].uri: the data URI is not base64"},
        {"\"buffers\":[{\"byteLength\":4,\"uri\":\"data:x;base64,AA*A\"}]",
         "buffers[0].uri: the data URI's base64 is damaged"},
        {"\"buffers\":[{\"byteLength\":4,\"uri\":\"data:x;base64,AAAA\"}]",
         "buffers[0].byteLength: is 4, but only 3 bytes are there"},
        {"\"buffers\":[{\"byteLength\":4,\"uri\":\"a.bin\"}]", "buffers[0].uri: 'a.bin' is a file"},
    };
    char json[1024];
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        snprintf(json, sizeof json, "{\"asset\":{\"version\":\"2.0\"},%s}", cases[i][0]);
        refuse_json(json, cases[i][1]);
    }
}

static void nesting_without_end(void **state) {
    base_text json = {0};
    (void)state;
    base_text_add(&json, "{\"asset\":{\"version\":\"2.0\"},\"extras\":");
    for (int i = 0; i < 200000; i++)
        base_text_append(&json, "[", 1);
    refuse_json(json.data, "JSON line 1: more than 32 nested objects and arrays");
    base_text_free(&json);
    /* Brackets inside text do not nest, and extras may hold anything. */
    const char *fine =
        "{\"asset\":{\"version\":\"2.0\",\"extras\":\"\\\"[[[[[[[[[[[[[[[[[[[[[[[[[[[["
        "[[[[[[[[[[[[[[[[[[\"},\"extras\":[1,{\"a\":null}]}";
    scene *s;
    assert_int_equal(scene_load_memory("fine", fine, strlen(fine), &s, NULL), STRATA_OK);
    scene_free(s);
}

static void arrays_without_end(void **state) {
    base_text json = {0};
    (void)state;
    base_text_add(&json, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{}");
    for (int i = 0; i < 1 << 20; i++)
        base_text_append(&json, ",{}", 3);
    base_text_add(&json, "]}");
    refuse_json(json.data, "nodes: has 1048577 elements, the limit is 1048576");
    base_text_free(&json);
}

/* ---- the tree -------------------------------------------------------------------------------- */

static void trees_that_are_none(void **state) {
    static const char *const cases[][2] = {
        {"[{\"children\":[0]}]", "nodes[0]: is its own ancestor"},
        {"[{},{\"children\":[2]},{\"children\":[3]},{\"children\":[2]}]",
         "nodes[2]: is a child of nodes[1] and of nodes[3]"},
        {"[{},{\"children\":[2]},{\"children\":[1]}]", "nodes["},
        {"[{\"children\":[1,1]},{}]", "nodes[1]: is a child of nodes[0] and of nodes[0]"},
        {"[{\"scale\":[1e38,1,1],\"children\":[1]},{\"scale\":[10,1,1]}]",
         "nodes[1]: its transform to the world is not finite"},
    };
    char json[300];
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        snprintf(json, sizeof json, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":%s}", cases[i][0]);
        refuse_json(json, cases[i][1]);
    }
}

static void deep_trees_are_fine(void **state) {
    base_text json = {0};
    scene *s;
    (void)state;
    base_text_add(&json, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{}");
    for (int i = 0; i < 100000; i++)
        base_text_add(&json, ",{\"children\":[%d]}", i);
    base_text_add(&json, "]}");
    assert_int_equal(scene_load_memory("deep", json.data, json.length, &s, NULL), STRATA_OK);
    scene_free(s);
    base_text_free(&json);
}

/* ---- data ------------------------------------------------------------------------------------ */

static void positions_that_are_not_finite(void **state) {
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        float corners[18] = {0};
        corners[13] = kind ? NAN : -INFINITY;
        test_glb g = {0};
        test_glb_floats(&g, "VEC3", 3, 6, corners);
        add_square_scene(&g, 4, "");
        expect_refused(&g, "meshes[0] 'square' primitive 0: POSITION[4] is not finite");
    }
}

static void attributes_that_do_not_fit(void **state) {
    static const float few[9] = {0};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_floats(&g, "VEC3", 3, 3, few);
    add_square_scene(&g, 4, ",\"NORMAL\":1");
    expect_refused(&g, "NORMAL: accessors[1] has 3 elements, POSITION has 4");
    add_square(&g);
    test_glb_floats(&g, "VEC3", 3, 3, few);
    add_square_scene(&g, 4, ",\"TEXCOORD_0\":1");
    expect_refused(&g, "TEXCOORD_0: accessors[1]: has 3 components, 2 are needed");
}

static void accessors_beyond_their_bytes(void **state) {
    static const struct {
        uint64_t count;
        uint32_t stride;
        const char *more, *part;
    } cases[] = {
        {5, 0, "",
         "POSITION: accessors[0]: 5 elements from byte 0 on do not fit into the 48 bytes"},
        {4, 0, ",\"byteOffset\":1", "4 elements from byte 1 on do not fit"},
        {3, 20, "", "3 elements from byte 0 on do not fit"},
        {3, 8, "", "bufferViews[0].byteStride is 8, an element has 12 bytes"},
        {UINT64_C(1) << 52, 0, "", "has 4503599627370496 elements, 2^32 or more"},
        {4294967294u, 252, "", "do not fit"},
        {4, 0, ",\"byteOffset\":9007199254740992", "do not fit"},
        {4, 256, "", "byteStride"},
        {4, 13, "", "byteStride"},
    };
    static const float bytes[12] = {0};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        test_glb g = {0};
        test_glb_accessor(&g, test_glb_view(&g, bytes, 48, cases[i].stride), TEST_GLB_F32, "VEC3",
                          cases[i].count, cases[i].more);
        add_square_scene(&g, 4, "");
        expect_refused(&g, cases[i].part);
    }
}

static void views_beyond_their_buffer(void **state) {
    static const char *const views[] = {"\"byteOffset\":16,\"byteLength\":40",
                                        "\"byteOffset\":9007199254740992,\"byteLength\":48",
                                        "\"byteLength\":9007199254740992"};
    char json[600];
    static const float bytes[12] = {0};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(views); i++) {
        snprintf(
            json, sizeof json,
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":48}],\"bufferViews\":"
            "[{\"buffer\":0,%s}],\"accessors\":[{\"bufferView\":0,\"componentType\":5126,"
            "\"type\":\"VEC3\",\"count\":3}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":"
            "[{\"attributes\":{\"POSITION\":0}}]}]}",
            views[i]);
        size_t size;
        base_error err = {0};
        scene *s;
        unsigned char *file = test_glb_pack(json, bytes, sizeof bytes, &size);
        assert_int_equal(scene_load_memory("x", file, size, &s, &err), STRATA_ERROR_BAD_FILE);
        free(file);
        assert_non_null(strstr(err.text, "POSITION: accessors[0]: bufferViews[0] ends at byte"));
    }
}

static void indices_out_of_range(void **state) {
    static const uint16_t indices[3] = {0, 1, 4};
    static const float floats[3] = {0, 1, 2};
    (void)state;
    for (int as_float = 0; as_float < 2; as_float++) {
        test_glb g = {0};
        add_square(&g);
        if (as_float)
            test_glb_floats(&g, "SCALAR", 1, 3, floats);
        else
            test_glb_accessor(&g, test_glb_view(&g, indices, 6, 0), TEST_GLB_U16, "SCALAR", 3, "");
        test_glb_json(&g, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":"
                          "{\"POSITION\":0},\"indices\":1}]}]");
        expect_refused(&g, as_float ? "indices: accessors[1]: componentType 5126 is not an unsigned"
                                    : "meshes[0] primitive 0: indices[2] is 4 of 4 vertices");
    }
}

static void sparse_data_out_of_range(void **state) {
    static const struct {
        unsigned count, at;
        const char *part;
    } cases[] = {{1, 3, "sparse.indices[0] is 3 of 3 elements"},
                 {4, 0, "sparse.count is 4 of 3"},
                 {3, 0, "3 elements from byte 0 on do not fit into the 24 bytes"}};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        const unsigned char at[4] = {(unsigned char)cases[i].at, 1, 2, 0};
        static const float values[6] = {0};
        char more[200];
        test_glb g = {0};
        test_glb_view(&g, at, 4, 0);
        test_glb_view(&g, values, 24, 0);
        snprintf(more, sizeof more,
                 ",\"sparse\":{\"count\":%u,\"indices\":{\"bufferView\":0,\"componentType\":5121},"
                 "\"values\":{\"bufferView\":1}}",
                 cases[i].count);
        test_glb_accessor(&g, NONE, TEST_GLB_F32, "VEC3", 3, more);
        add_square_scene(&g, 4, "");
        expect_refused(&g, cases[i].part);
    }
}

static void zeros_without_end(void **state) {
    (void)state;
    test_glb g = {0};
    test_glb_accessor(&g, NONE, TEST_GLB_F32, "VEC3", 4000000000u, "");
    add_square_scene(&g, 4, "");
    expect_refused(&g,
                   "accessors[0]: has no bufferView and 4000000000 elements, more than 16777216");
}

/* Forty primitives of one accessor: small in the file, large in memory. */
static void data_used_too_often(void **state) {
    (void)state;
    for (int times = 4; times <= 40; times += 36) {
        base_text primitives = {0};
        for (int i = 0; i < times; i++)
            base_text_add(&primitives, "%s{\"mode\":0,\"attributes\":{\"POSITION\":0}}",
                          i ? "," : "");
        test_glb g = {0};
        test_glb_accessor(&g, NONE, TEST_GLB_F32, "VEC3", 1u << 20, "");
        test_glb_json(&g, "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[%s]}]",
                      primitives.data);
        base_text_free(&primitives);
        if (times > 4)
            expect_refused(&g, "the scene unfolds to far more than its files hold");
        else
            scene_free(load_glb(&g));
    }
}

static void two_to_the_32_primitives(void **state) {
    (void)state;
    for (int over = 0; over < 2; over++) {
        test_glb g = {0};
        test_glb_accessor(&g, NONE, TEST_GLB_F32, "VEC3", 3u << 18, "");
        test_glb_accessor(&g, NONE, TEST_GLB_F32, "VEC3", (1u << 14) - !over, "");
        test_glb_json(&g, "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":"
                          "{\"attributes\":{\"TRANSLATION\":1}}}}],\"meshes\":[{\"primitives\":"
                          "[{\"attributes\":{\"POSITION\":0}}]}]");
        if (over) {
            expect_refused(&g, "the scene has 2^32 or more triangles and points");
        } else {
            scene *s = load_glb(&g);
            assert_true(s->primitive_count == (UINT64_C(1) << 32) - (1u << 18));
            scene_free(s);
        }
    }
}

static void joints_out_of_range(void **state) {
    static const unsigned char joints[16] = {0, 9, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0};
    static const float weights[16] = {1, 0, 0, 0, 1, 0, 0, 0, .5f, 0, .5f, 0, 1};
    (void)state;
    test_glb g = {0};
    add_square(&g);
    test_glb_accessor(&g, test_glb_view(&g, joints, 16, 0), TEST_GLB_U8, "VEC4", 4, "");
    test_glb_floats(&g, "VEC4", 4, 4, weights);
    test_glb_json(&g, "\"nodes\":[{\"mesh\":0,\"skin\":0}],\"skins\":[{\"joints\":[0]}],\"meshes\":"
                      "[{\"primitives\":[{\"mode\":5,\"attributes\":{\"POSITION\":0,\"JOINTS_0\":1,"
                      "\"WEIGHTS_0\":2}}]}]");
    expect_refused(&g, "JOINTS_0[2] is joint 1, skins[0] has 1");
}

static void keys_that_cannot_be_used(void **state) {
    static const struct {
        float times[2];
        unsigned values;
        const char *part;
    } cases[] = {{{1, 0}, 2, "its times are not finite and ascending"},
                 {{0, NAN}, 2, "its times are not finite and ascending"},
                 {{0, 1}, 3, "holds 9 numbers, the keys need 6"}};
    static const float values[9] = {0};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(cases); i++) {
        test_glb g = {0};
        test_glb_floats(&g, "SCALAR", 1, 2, cases[i].times);
        test_glb_floats(&g, "VEC3", 3, cases[i].values, values);
        test_glb_json(
            &g, "\"nodes\":[{}],\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1}],"
                "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}]}]");
        expect_refused(&g, cases[i].part);
    }
}

/* ---- container and files --------------------------------------------------------------------- */

static void refuse_bytes(const unsigned char *file, size_t size, const char *part) {
    base_error err = {0};
    scene *s;
    unsigned char *copy = malloc(size ? size : 1); /* so that a sanitizer sees reads beyond it */
    assert_non_null(copy);
    memcpy(copy, file, size);
    assert_int_equal(scene_load_memory("bad.glb", copy, size, &s, &err), STRATA_ERROR_BAD_FILE);
    free(copy);
    if (strncmp(err.text, "bad.glb: ", 9) != 0 || !strstr(err.text, part))
        fail_msg("'%s' does not say '%s'", err.text, part);
}

static void containers_that_lie(void **state) {
    size_t size;
    unsigned char *file = test_glb_pack("{\"asset\":{\"version\":\"2.0\"}}", "abcd", 4, &size);
    (void)state;
    refuse_bytes(file, 12, "GLB header: cut off after 12 bytes");
    refuse_bytes(file, size - 1, "GLB header: length is");
    file[4] = 1;
    refuse_bytes(file, size, "GLB header: version 1");
    file[4] = 2;
    file[8] = 24;
    refuse_bytes(file, size, "GLB chunk 0: 28 bytes long, 4 are left");
    file[8] = 12;
    refuse_bytes(file, size, "GLB: has no chunk");
    file[8] = (unsigned char)size;
    file[15] = 0xff;
    refuse_bytes(file, size, "GLB chunk 0: ");
    file[15] = 0;
    file[16] = 'X';
    refuse_bytes(file, size, "GLB chunk 0: is not JSON");
    file[16] = 'J';
    file[20 + 28] = 0xff;
    refuse_bytes(file, size, "GLB chunk 1: 255 bytes long, 4 are left");
    free(file);
}

static void files_outside_the_folder(void **state) {
    static const char *const uris[] = {"../a.bin",
                                       "/etc/passwd",
                                       "x/../../a.bin",
                                       "%2e%2e/a.bin",
                                       "file:///etc/passwd",
                                       "..\\\\a.bin",
                                       "",
                                       ".."};
    char folder[] = "/tmp/strata-refuse-XXXXXX", path[64], command[100], json[300];
    (void)state;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/s.gltf", folder);
    for (size_t i = 0; i < BASE_COUNT(uris) + 1; i++) {
        base_error err = {0};
        scene *s;
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        snprintf(
            json, sizeof json,
            "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4,\"uri\":\"%s\"}]}",
            i < BASE_COUNT(uris) ? uris[i] : "lost%20data.bin");
        fputs(json, file);
        fclose(file);
        assert_int_equal(scene_load(path, &s, &err), STRATA_ERROR_BAD_FILE);
        assert_int_equal(strncmp(err.text, path, strlen(path)), 0);
        const char *part = i < BASE_COUNT(uris) ? "leads out of the scene's folder"
                                                : "lost data.bin: cannot open: No such file";
        if (!strstr(err.text, part) || !strstr(err.text, "buffers[0].uri: "))
            fail_msg("'%s' does not say '%s'", err.text, part);
    }
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    assert_int_equal(system(command), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(text_that_is_not_gltf),
        cmocka_unit_test(members_of_the_wrong_kind),
        cmocka_unit_test(nesting_without_end),
        cmocka_unit_test(arrays_without_end),
        cmocka_unit_test(trees_that_are_none),
        cmocka_unit_test(deep_trees_are_fine),
        cmocka_unit_test(positions_that_are_not_finite),
        cmocka_unit_test(attributes_that_do_not_fit),
        cmocka_unit_test(accessors_beyond_their_bytes),
        cmocka_unit_test(views_beyond_their_buffer),
        cmocka_unit_test(indices_out_of_range),
        cmocka_unit_test(sparse_data_out_of_range),
        cmocka_unit_test(zeros_without_end),
        cmocka_unit_test(data_used_too_often),
        cmocka_unit_test(two_to_the_32_primitives),
        cmocka_unit_test(joints_out_of_range),
        cmocka_unit_test(keys_that_cannot_be_used),
        cmocka_unit_test(containers_that_lie),
        cmocka_unit_test(files_outside_the_folder),
    };
    return cmocka_run_group_tests_name("scene refusal", tests, NULL, NULL);
}
