/* SPDX-License-Identifier: MIT
 *
 * Materials, textures and images as the glTF loader reads them, from views, data URIs and files.
 */
#define _POSIX_C_SOURCE 200809L
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

static void materials_and_their_extensions(void **state) {
    (void)state;
    test_glb g = {0};
    test_glb_json(
        &g, "\"materials\":[{\"name\":\"glass\",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.25,"
            "\"doubleSided\":true,\"emissiveFactor\":[1,0.5,0],\"pbrMetallicRoughness\":"
            "{\"baseColorFactor\":[0.5,2,0.25,7],\"metallicFactor\":0.125,"
            "\"roughnessFactor\":-3},\"extensions\":{\"KHR_materials_unlit\":{},"
            "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":4},"
            "\"KHR_materials_ior\":{\"ior\":1.25},\"KHR_materials_transmission\":"
            "{\"transmissionFactor\":0.75},\"X_other\":{\"deep\":[1,[2]]}}},"
            "{\"alphaMode\":\"BLEND\"}],\"extensionsUsed\":[\"X_other\",\"KHR_materials_ior\"]");
    scene *s = load_glb(&g);
    assert_int_equal(s->material_count, 2);
    const scene_material *m = &s->materials[0];
    assert_string_equal(m->name, "glass");
    assert_int_equal(m->alpha, SCENE_MASK);
    expect_floats(m->base_color, (const float[]){0.5f, 2, 0.25f, 1}, 4);
    expect_floats(m->emissive, (const float[]){4, 2, 0}, 3);
    expect_floats(
        (const float[]){m->alpha_cutoff, m->metallic, m->roughness, m->ior, m->transmission},
        (const float[]){0.25f, 0.125f, 0, 1.25f, 0.75f}, 5);
    assert_int_equal(m->double_sided, 1);
    assert_int_equal(m->unlit, 1);
    m = &s->materials[1];
    assert_string_equal(m->name, "material 1");
    assert_int_equal(m->alpha, SCENE_BLEND);
    expect_floats(
        (const float[]){m->alpha_cutoff, m->metallic, m->roughness, m->ior, m->transmission},
        (const float[]){0.5f, 1, 1, 1.5f, 0}, 5);
    assert_int_equal(m->unlit + m->double_sided, 0);
    assert_int_equal(m->base_color_texture.image, SCENE_NONE);
    assert_int_equal(s->warning_count, 1);
    expect_warning(s, "extension X_other is not supported: ignored");
    scene_free(s);
}

static const char *const textured =
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"texCoord\":1,"
    "\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0.5,-1],\"rotation\":0.5235987756,"
    "\"scale\":[2,4]}}}},\"normalTexture\":{\"index\":1,\"scale\":0.5},"
    "\"occlusionTexture\":{\"index\":1,\"strength\":0.25},\"emissiveTexture\":{\"index\":1,"
    "\"texCoord\":3},\"extensions\":{\"KHR_materials_transmission\":{\"transmissionTexture\":"
    "{\"index\":0,\"texCoord\":1}}}}],\"textures\":[{\"source\":0,\"sampler\":0},{\"source\":0}],"
    "\"samplers\":[{\"magFilter\":9728,\"minFilter\":9986,\"wrapS\":33071,\"wrapT\":33648}]";

static void check_textured(const scene *s) {
    const scene_material *m = &s->materials[0];
    const scene_texture *t = &m->base_color_texture;
    assert_int_equal(s->image_count, 1);
    assert_int_equal(s->images[0].width, 3);
    assert_int_equal(s->images[0].height, 2);
    for (int i = 0; i < 6; i++)
        assert_memory_equal(s->images[0].pixels + i * 4, "\x0a\x14\x1e\xc8", 4);
    assert_int_equal(t->image, 0);
    assert_int_equal(t->uv, 1);
    expect_floats(t->scale_rotate, (const float[]){1.7320508f, 2, -1, 3.4641016f}, 4);
    expect_floats(t->offset, (const float[]){0.5f, -1}, 2);
    assert_int_equal(t->magnify, SCENE_NEAREST);
    assert_int_equal(t->minify, SCENE_NEAREST);
    assert_int_equal(t->mipmap, SCENE_MIP_LINEAR);
    assert_int_equal(t->wrap_u, SCENE_CLAMP);
    assert_int_equal(t->wrap_v, SCENE_MIRROR);
    t = &m->normal_texture;
    assert_int_equal(t->image, 0);
    assert_int_equal(t->uv, 0);
    expect_floats(t->scale_rotate, (const float[]){1, 0, 0, 1}, 4);
    assert_int_equal(t->wrap_u, SCENE_REPEAT);
    assert_int_equal(t->minify, SCENE_LINEAR);
    expect_floats(&m->normal_scale, (const float[]){0.5f}, 1);
    expect_floats(&m->occlusion_strength, (const float[]){0.25f}, 1);
    assert_int_equal(m->emissive_texture.image, SCENE_NONE);
    assert_int_equal(m->transmission_texture.image, 0);
    assert_int_equal(m->transmission_texture.uv, 1);
    expect_warning(s, "materials[0].emissiveTexture: texCoord 3 is not supported");
}

static void images_in_a_buffer_view(void **state) {
    base_text png = {0};
    (void)state;
    test_glb g = {0};
    test_glb_png(&png, 3, 2, (const unsigned char[]){10, 20, 30, 200});
    test_glb_view(&g, png.data, png.length, 0);
    base_text_free(&png);
    test_glb_json(&g, "%s,\"images\":[{\"bufferView\":0,\"mimeType\":\"image/png\"}]", textured);
    scene *s = load_glb(&g);
    check_textured(s);
    scene_free(s);
}

static char *base64(const base_text *bytes) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    base_text out = {0};
    for (size_t i = 0; i < bytes->length; i += 3) {
        uint32_t bits = 0, have = 0;
        for (size_t k = 0; k < 3; k++) {
            bits = bits << 8 | (i + k < bytes->length ? (unsigned char)bytes->data[i + k] : 0);
            have += i + k < bytes->length;
        }
        char four[4] = {digits[bits >> 18], digits[bits >> 12 & 63],
                        have > 1 ? digits[bits >> 6 & 63] : '=',
                        have > 2 ? digits[bits & 63] : '='};
        base_text_append(&out, four, 4);
    }
    return out.data;
}

static void images_in_a_data_uri(void **state) {
    base_text png = {0};
    (void)state;
    test_glb g = {0};
    test_glb_png(&png, 3, 2, (const unsigned char[]){10, 20, 30, 200});
    char *coded = base64(&png);
    test_glb_json(&g, "%s,\"images\":[{\"uri\":\"data:image/png;base64,%s\"}]", textured, coded);
    free(coded);
    base_text_free(&png);
    scene *s = load_glb(&g);
    check_textured(s);
    scene_free(s);
}

static void write_file(const char *folder, const char *name, const void *data, size_t size) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(data, 1, size, file), size);
    fclose(file);
}

static void files_beside_the_scene(void **state) {
    char folder[] = "/tmp/strata-scene-XXXXXX", path[256], command[300];
    base_text png = {0}, json = {0};
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    base_error err = {0};
    scene *s;
    (void)state;
    assert_non_null(mkdtemp(folder));
    test_glb_png(&png, 3, 2, (const unsigned char[]){10, 20, 30, 200});
    write_file(folder, "a picture.png", png.data, png.length);
    write_file(folder, "data.bin", corners, sizeof corners);
    base_text_add(
        &json,
        "\xef\xbb\xbf{\"asset\":{\"version\":\"2.0\"},%s,\"images\":[{\"name\":\"pic\",\"uri\":"
        "\"a%%20picture.png\"}],\"buffers\":[{\"byteLength\":36.0,\"uri\":\"./data.bin\"}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
        "\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}],\"nodes\":[{\"mesh\":0}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]}",
        textured);
    write_file(folder, "scene.gltf", json.data, json.length);
    snprintf(path, sizeof path, "%s/scene.gltf", folder);
    if (scene_load(path, &s, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    check_textured(s);
    assert_string_equal(s->images[0].name, "pic");
    assert_string_equal(s->path, path);
    assert_int_equal(s->primitive_count, 1);
    scene_free(s);
    snprintf(command, sizeof command, "rm -r '%s'", folder);
    assert_int_equal(system(command), 0);
    assert_int_equal(scene_load(path, &s, &err), STRATA_ERROR_NOT_FOUND);
    base_text_free(&png);
    base_text_free(&json);
}

static void unreadable_images_are_left_out(void **state) {
    base_text png = {0};
    (void)state;
    test_glb g = {0};
    test_glb_png(&png, 3, 2, (const unsigned char[]){10, 20, 30, 200});
    memcpy(png.data + 16, "\0\x40\x01\x03", 4); /* the width: 0x00400103 */
    test_glb_view(&g, png.data, png.length, 0);
    test_glb_view(&g, "GIF89a", 6, 0);
    base_text_free(&png);
    test_glb_json(
        &g, "\"materials\":[{\"normalTexture\":{\"index\":0},\"emissiveTexture\":{\"index\":1},"
            "\"occlusionTexture\":{\"index\":2},\"pbrMetallicRoughness\":"
            "{\"baseColorTexture\":{\"index\":3},\"metallicRoughnessTexture\":{\"index\":4}}}],"
            "\"textures\":[{\"source\":0},{\"source\":1},{\"source\":2},{\"source\":3},{}],"
            "\"images\":[{\"bufferView\":0},{\"bufferView\":1},{\"uri\":\"no.png\"},{}]");
    scene *s = load_glb(&g);
    assert_int_equal(s->image_count, 0);
    assert_int_equal(s->materials[0].normal_texture.image, SCENE_NONE);
    expect_warning(s, "images[0]: is 4194563x2 pixels, the limit is 16384x16384");
    expect_warning(s, "images[1]: is neither PNG nor JPEG");
    expect_warning(s, "images[2]: 'no.png' is a file");
    expect_warning(s, "images[3]: has neither uri nor bufferView");
    expect_warning(s, "textures[4]: has no image");
    scene_free(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(materials_and_their_extensions), cmocka_unit_test(images_in_a_buffer_view),
        cmocka_unit_test(images_in_a_data_uri),           cmocka_unit_test(files_beside_the_scene),
        cmocka_unit_test(unreadable_images_are_left_out),
    };
    return cmocka_run_group_tests_name("scene materials", tests, NULL, NULL);
}
