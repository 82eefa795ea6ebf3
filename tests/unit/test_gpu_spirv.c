/* SPDX-License-Identifier: MIT
 *
 * What comes out of compiling, reflecting and rewriting, for Vulkan and for OpenGL: SPIR-V that the
 * Khronos validator accepts, with the host's binding numbers and without what nothing uses.
 */
#define _POSIX_C_SOURCE 200809L
#include "gpu/gpu_internal.h"
#include "unit/gpu_fixture.h"

#include <spirv-tools/libspirv.h>
#include <spirv_cross/spirv.h>

static const strata_glsl fragment = {
    "layout(location = 0) out vec4 color;\n"
    "layout(std430) buffer Written { uint written[]; };\n"
    "layout(std430) readonly buffer Unused { uint unused[]; };\n"
    "layout(std140) uniform Block { vec4 block; };\n"
    "layout(std140) uniform UnusedBlock { vec4 unused_block; };\n"
    "uniform sampler2D plain;\n"
    "uniform sampler2DArray unused_pages;\n"
    "layout(r32ui) uniform uimage2D counts;\n"
    "layout(rgba16f) uniform readonly image2D stored;\n"
    "STRATA_PARAMS { uint first; vec2 pair; } params;\n"
    "void main() {\n"
    "    ivec2 p = ivec2(gl_FragCoord.xy);\n"
    "    written[params.first] = imageAtomicAdd(counts, p, 1u);\n"
    "    color = block * texelFetch(plain, p, 0) + imageLoad(stored, p) * params.pair.x;\n"
    "}\n",
    "fragment.glsl"};

typedef struct built {
    gpu_spirv spirv;
    gpu_reflection reflection;
} built;

static void build(fixture *f, uint32_t kind, int vulkan_target, const strata_glsl *source,
                  built *out) {
    gpu_source sources[2] = {0};
    const strata_program_desc desc = {
        .struct_size = sizeof desc, .kind = kind, .label = "program", .source = source};
    *out = (built){0};
    strata_result result = gpu_shader_expand(
        f->g, &desc, kind == STRATA_PROGRAM_COMPUTE ? GPU_STAGE_COMPUTE : GPU_STAGE_VERTEX,
        &sources[0], &f->err);
    if (result == STRATA_OK && kind != STRATA_PROGRAM_COMPUTE)
        result = gpu_shader_expand(f->g, &desc, GPU_STAGE_FRAGMENT, &sources[1], &f->err);
    if (result == STRATA_OK)
        result = gpu_compile("program", kind, vulkan_target, sources, &out->spirv, &f->err);
    if (result == STRATA_OK)
        result =
            gpu_reflect("program", kind, vulkan_target, &out->spirv, &out->reflection, &f->err);
    gpu_source_free(&sources[0]);
    gpu_source_free(&sources[1]);
    if (result != STRATA_OK)
        fail_msg("%s", f->err.text);
}

static void validate(const built *b, int vulkan_target) {
    spv_context context = spvContextCreate(vulkan_target ? SPV_ENV_VULKAN_1_3 : SPV_ENV_OPENGL_4_5);
    for (int i = 0; i < 2; i++) {
        spv_diagnostic diagnostic = NULL;
        if (!b->spirv.count[i])
            continue;
        if (spvValidateBinary(context, b->spirv.words[i], b->spirv.count[i], &diagnostic) !=
            SPV_SUCCESS)
            fail_msg("%s, stage %d: %s", vulkan_target ? "vulkan" : "gl", i,
                     diagnostic ? diagnostic->error : "refused");
        spvDiagnosticDestroy(diagnostic);
    }
    spvContextDestroy(context);
}

/* Variables of a stage that are not its inputs, outputs or privates. */
static uint32_t count_resources(const built *b, int stage) {
    uint32_t count = 0;
    const uint32_t *words = b->spirv.words[stage];
    for (size_t at = 5; at < b->spirv.count[stage]; at += words[at] >> 16)
        if ((words[at] & 0xffff) == SpvOpVariable)
            count += words[at + 3] == SpvStorageClassUniform ||
                     words[at + 3] == SpvStorageClassUniformConstant ||
                     words[at + 3] == SpvStorageClassStorageBuffer ||
                     words[at + 3] == SpvStorageClassPushConstant;
    return count;
}

static const gpu_binding *find(const built *b, const char *name) {
    for (uint32_t i = 0; i < b->reflection.binding_count; i++)
        if (strcmp(b->reflection.bindings[i].name, name) == 0)
            return &b->reflection.bindings[i];
    return NULL;
}

static void check_access(const built *b) {
    const gpu_binding *written = find(b, "Written"), *stored = find(b, "stored");
    const gpu_binding *counts = find(b, "counts"), *plain = find(b, "plain");
    assert_int_equal(written->kind, GPU_BINDING_STORAGE);
    assert_int_equal(written->access, GPU_ACCESS_STORAGE_READ | GPU_ACCESS_STORAGE_WRITE);
    assert_int_equal(written->stages, GPU_STAGE_FRAGMENT);
    assert_int_equal(stored->access, GPU_ACCESS_STORAGE_READ);
    assert_int_equal(stored->format, STRATA_FORMAT_RGBA16F);
    assert_int_equal(counts->access, GPU_ACCESS_STORAGE_READ | GPU_ACCESS_STORAGE_WRITE);
    assert_int_equal(counts->format, STRATA_FORMAT_R32U);
    assert_true(counts->is_unsigned && !counts->arrayed);
    assert_int_equal(plain->access, GPU_ACCESS_SAMPLED);
    assert_int_equal(find(b, "Block")->size, 16);
    assert_int_equal(b->reflection.params_size, 16);
    assert_int_equal(b->reflection.outputs[0], GPU_OUTPUT_FLOAT);
    assert_int_equal(b->reflection.outputs[1], GPU_OUTPUT_NONE);
}

/* Vulkan: one sequence of numbers; OpenGL: one for each kind, params among the uniform blocks. */
static void check_numbers(const built *b, int vulkan_target) {
    uint64_t seen[GPU_BINDING_PARAMS + 1] = {0};
    for (uint32_t i = 0; i < b->reflection.binding_count; i++) {
        const gpu_binding *binding = &b->reflection.bindings[i];
        gpu_binding_kind group = binding->kind;
        if (vulkan_target && group == GPU_BINDING_PARAMS)
            continue;
        if (vulkan_target || group == GPU_BINDING_PARAMS)
            group = GPU_BINDING_UNIFORM;
        assert_true(binding->binding < b->reflection.binding_count);
        assert_false(seen[group] >> binding->binding & 1);
        seen[group] |= UINT64_C(1) << binding->binding;
    }
    if (!vulkan_target)
        assert_int_equal(seen[GPU_BINDING_UNIFORM], 3); /* Block and params: 0 and 1 */
}

static void test_fragment(void **state) {
    fixture *f = *state;
    for (int vulkan_target = 0; vulkan_target < 2; vulkan_target++) {
        built b;
        build(f, STRATA_PROGRAM_FULLSCREEN, vulkan_target, &fragment, &b);
        validate(&b, vulkan_target);
        assert_int_equal(b.reflection.binding_count, 6);
        assert_int_equal(count_resources(&b, 0), 0);
        assert_int_equal(count_resources(&b, 1), 6);
        check_access(&b);
        check_numbers(&b, vulkan_target);
        gpu_spirv_free(&b.spirv);
    }
}

/* The scene's vertex stage, and a fragment stage that shares two of its blocks. */
static void test_scene(void **state) {
    static const strata_glsl source = {
        "#include \"strata/frame.glsl\"\n"
        "layout(location = 0) flat in uvec4 ids;\n"
        "STRATA_READ(StrataPositions, float)\n"
        "layout(std430) writeonly buffer Own { float own[]; };\n"
        "void main() { own[ids.x] = strata_background.x + STRATA_AT_FLOAT(StrataPositions, 0); }\n",
        "scene.glsl"};
    fixture *f = *state;
    for (int vulkan_target = 0; vulkan_target < 2; vulkan_target++) {
        built b;
        build(f, STRATA_PROGRAM_SCENE, vulkan_target, &source, &b);
        validate(&b, vulkan_target);
        const uint32_t both = GPU_STAGE_VERTEX | GPU_STAGE_FRAGMENT;
        assert_int_equal(find(&b, "StrataFrame")->stages, both);
        assert_int_equal(find(&b, "StrataPositions")->stages, both);
        assert_int_equal(find(&b, "StrataPositions")->access, GPU_ACCESS_STORAGE_READ);
        assert_int_equal(find(&b, "StrataRecords")->stages, GPU_STAGE_VERTEX);
        assert_int_equal(find(&b, "Own")->stages, GPU_STAGE_FRAGMENT);
        gpu_spirv_free(&b.spirv);
    }
}

/* Stages that disagree on a block: one line that names it. */
static void test_stages_disagree(void **state) {
    static const strata_glsl source = {
        "layout(location = 0) flat in uvec4 ids;\n"
        "layout(std430) buffer StrataPositions { float strata_positions[]; };\n"
        "void main() { strata_positions[ids.x] = 1.0; }\n",
        "scene.glsl"};
    fixture *f = *state;
    strata_program program;
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_SCENE,
                                      .label = "disagreeing",
                                      .source = &source};
    assert_int_equal(gpu_program_create(f->scope, &desc, &program, &f->err), STRATA_ERROR_SHADER);
    assert_non_null(strstr(f->err.text, "disagreeing: "));
    assert_non_null(strstr(f->err.text, "StrataPositions"));
}

static void test_compute(void **state) {
    static const strata_glsl source = {
        "#extension GL_KHR_shader_subgroup_ballot : enable\n"
        "layout(local_size_x = 64) in;\n"
        "layout(std430) coherent buffer Heads { uint count; uvec2 heads[]; };\n"
        "layout(std430) writeonly buffer Out { uint value[]; };\n"
        "shared uint sums[64];\n"
        "void main() {\n"
        "    sums[gl_LocalInvocationIndex] = atomicAdd(count, 1u) + heads.length();\n"
        "    barrier();\n"
        "    value[gl_GlobalInvocationID.x] = sums[63u - gl_LocalInvocationIndex];\n"
        "}\n",
        "compute.glsl"};
    fixture *f = *state;
    for (int vulkan_target = 0; vulkan_target < 2; vulkan_target++) {
        built b;
        build(f, STRATA_PROGRAM_COMPUTE, vulkan_target, &source, &b);
        validate(&b, vulkan_target);
        assert_int_equal(find(&b, "Heads")->size, 8); /* before the array, aligned */
        assert_int_equal(find(&b, "Out")->access, GPU_ACCESS_STORAGE_WRITE);
        gpu_spirv_free(&b.spirv);
    }
}

/* Damaged modules are refused or rewritten within bounds; the sanitizers watch. */
static void test_damaged(void **state) {
    fixture *f = *state;
    built b;
    uint32_t seed = 1;
    build(f, STRATA_PROGRAM_FULLSCREEN, 1, &fragment, &b);
    const gpu_spirv_binding binding = {.id = 7, .number = 3};
    for (int round = 0; round < 4000; round++) {
        size_t count = b.spirv.count[1];
        uint32_t *words = malloc(count * sizeof *words);
        base_error err = {0};
        assert_non_null(words);
        memcpy(words, b.spirv.words[1], count * sizeof *words);
        for (int i = 0; i < 3; i++) {
            seed = seed * 1664525u + 1013904223u;
            words[(seed >> 8) % count] ^= 1u << (seed & 31);
        }
        if (round % 4 == 0)
            count = (seed >> 8) % count;
        gpu_spirv_rewrite(&words, &count, &binding, 1, 1, &err);
        free(words);
    }
    gpu_spirv_free(&b.spirv);
}

#define ON_NULL(test) cmocka_unit_test_setup_teardown(test, open_null, close_fixture)

int main(void) {
    const struct CMUnitTest tests[] = {
        ON_NULL(test_fragment), ON_NULL(test_scene),   ON_NULL(test_stages_disagree),
        ON_NULL(test_compute),  ON_NULL(test_damaged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
