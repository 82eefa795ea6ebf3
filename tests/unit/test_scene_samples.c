/* SPDX-License-Identifier: MIT
 *
 * The glTF 2.0 samples of Debian's package assimp-testmodels, good and broken. Looked for in
 * STRATA_SAMPLES (the folder that holds glTF2) and where the package puts them; skipped without.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "scene/scene.h"

#define REFUSED UINT64_MAX

static const struct {
    const char *file;
    uint64_t primitives;
    const char *part; /* of the error, when primitives is REFUSED; of a warning, or NULL: none */
} samples[] = {
    {"2CylinderEngine-glTF-Binary/2CylinderEngine.glb", 121496, NULL},
    {"BoxBadNormals-glTF-Binary/BoxBadNormals.glb", 12, "NORMAL: 4 of 24 are zero or not finite"},
    {"BoxTexcoords-glTF/boxTexcoords.gltf", 12, NULL},
    {"BoxTextured-glTF-Binary/BoxTextured.glb", 12, NULL},
    {"BoxTextured-glTF-Embedded/BoxTextured.gltf", 12, NULL},
    {"BoxTextured-glTF-pbrSpecularGlossiness/BoxTextured.gltf", 12,
     "extension KHR_materials_pbrSpecularGlossiness is not supported"},
    {"BoxTextured-glTF-techniqueWebGL/BoxTextured.gltf", REFUSED,
     "extensionsRequired[0]: KHR_technique_webgl is not supported"},
    {"BoxTextured-glTF/BoxTextured.gltf", 12, NULL},
    {"BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", REFUSED,
     "meshes[0] 'Mesh' primitive 0: POSITION[0] is not finite"},
    {"ClearCoat-glTF/ClearCoatTest.gltf", 37116, "KHR_materials_clearcoat is not supported"},
    {"IncorrectVertexArrays/Cube.gltf", 46, "35 indices are not whole triangles"},
    {"IndexOutOfRange/AllIndicesOutOfRange.gltf", REFUSED, "indices[0] is 65535 of 24 vertices"},
    {"IndexOutOfRange/IndexOutOfRange.gltf", REFUSED, "indices[0] is 255 of 24 vertices"},
    {"MissingBin/BoxTextured.gltf", REFUSED, "buffers[0].uri: "},
    {"RecursiveNodes/RecursiveNodes.gltf", REFUSED, "nodes[0]: is its own ancestor"},
    {"SchemaFailures/sceneWrongType.gltf", REFUSED, "scene: must be an index, is text"},
    {"TestNoRootNode/NoScene.gltf", REFUSED, "scene: there is no scenes[0] (0 exist)"},
    {"TestNoRootNode/SceneWithoutNodes.gltf", 0, NULL},
    {"cameras/Cameras.gltf", 2, NULL},
    {"draco/2CylinderEngine.gltf", REFUSED, "KHR_draco_mesh_compression is not supported"},
    {"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_00.gltf", 1024, NULL},
    {"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_03.gltf", 0,
     "lines are not drawn"},
    {"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_04.gltf", 2, NULL},
    {"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_05.gltf", 2, NULL},
    {"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_06.gltf", 2, NULL},
    {"glTF-Asset-Generator/Mesh_PrimitiveMode/Mesh_PrimitiveMode_15.gltf", 2, NULL},
    {"glTF-Sample-Models/AnimatedMorphCube-glTF/AnimatedMorphCube.gltf", 12, NULL},
    {"issue_3269/texcoord_crash.gltf", 10, NULL},
    {"simple_skin/simple_skin.gltf", 8, NULL},
    {"textureTransform/TextureTransformTest.gltf", 24, NULL},
    {"wrongTypes/badArray.gltf", REFUSED, "meshes[0].primitives: must be an array, is an object"},
    {"wrongTypes/badExtension.gltf", REFUSED, "KHR_texture_transform: must be an object, is text"},
    {"wrongTypes/badNumber.gltf", REFUSED, "materials[0].normalTexture.scale: must be a number"},
    {"wrongTypes/badObject.gltf", REFUSED, "pbrMetallicRoughness: must be an object, is an array"},
    {"wrongTypes/badUint.gltf", REFUSED, "baseColorTexture.index: there is no textures[-1]"},
};

static const char *samples_folder(void) {
    static const char *const places[] = {"/usr/share/assimp/models",
                                         "/usr/share/assimp/test/models"};
    struct stat info;
    const char *given = getenv("STRATA_SAMPLES");
    if (given)
        return given;
    for (size_t i = 0; i < BASE_COUNT(places); i++)
        if (stat(places[i], &info) == 0)
            return places[i];
    return NULL;
}

static int has_warning(const scene *s, const char *part) {
    for (uint32_t i = 0; i < s->warning_count; i++)
        if (strstr(s->warnings[i], part))
            return 1;
    return 0;
}

static void check_sample(const char *folder, size_t index) {
    const char *part = samples[index].part;
    char path[512];
    base_error err = {0};
    scene *s;
    snprintf(path, sizeof path, "%s/glTF2/%s", folder, samples[index].file);
    strata_result result = scene_load(path, &s, &err);
    if (samples[index].primitives == REFUSED) {
        if (result != STRATA_ERROR_BAD_FILE || strncmp(err.text, path, strlen(path)) != 0 ||
            !strstr(err.text, part))
            fail_msg("%s: result %d, '%s'", path, (int)result, err.text);
        return;
    }
    if (result != STRATA_OK)
        fail_msg("%s", err.text);
    if (s->primitive_count != samples[index].primitives)
        fail_msg("%s: %llu primitives", path, (unsigned long long)s->primitive_count);
    if (part ? !has_warning(s, part) : s->warning_count > 0)
        fail_msg("%s: warned of: %s", path, s->warning_count ? s->warnings[0] : "nothing");
    for (int step = 0; step < 12; step++)
        assert_int_equal(scene_set_time(s, step * 0.3, &err), STRATA_OK);
    scene_free(s);
}

static void samples_load_or_say_why_not(void **state) {
    const char *folder = samples_folder();
    (void)state;
    if (!folder) {
        print_message("no samples: neither STRATA_SAMPLES nor the package assimp-testmodels\n");
        skip();
    }
    for (size_t i = 0; i < BASE_COUNT(samples); i++)
        check_sample(folder, i);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(samples_load_or_say_why_not)};
    return cmocka_run_group_tests_name("scene samples", tests, NULL, NULL);
}
