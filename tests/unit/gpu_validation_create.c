/* SPDX-License-Identifier: MIT
 *
 * Errors of creation calls, each caused on purpose, and failures that are injected.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_world.h"

/* ---- creation ------------------------------------------------------------------------------- */

static void test_create_buffer(void **state) {
    world *w = *state;
    strata_buffer buffer;
    strata_buffer_desc desc = {.struct_size = sizeof desc, .label = "b"};
    failed(w, gpu_buffer_create(w->f.scope, &desc, &buffer, &w->f.err), GPU_ERROR_BUFFER_SIZE,
           "'b' of 0 bytes");
    desc.size = 6;
    failed(w, gpu_buffer_create(w->f.scope, &desc, &buffer, &w->f.err), GPU_ERROR_BUFFER_SIZE, "6");
    desc.size = 4;
    desc.label = NULL;
    failed(w, gpu_buffer_create(w->f.scope, &desc, &buffer, &w->f.err), GPU_ERROR_LABEL_MISSING,
           "label");
    assert_int_equal(buffer.id, 0);
    failed(w, gpu_buffer_create(w->f.scope, NULL, &buffer, &w->f.err), GPU_ERROR_VALUE, "NULL");
}

static void test_create_image(void **state) {
    world *w = *state;
    strata_image image;
    strata_image_desc desc = {
        .struct_size = sizeof desc, .label = "i", .format = 99, .width = 4, .height = 4};
    failed(w, gpu_image_create(w->f.scope, &desc, &image, &w->f.err), GPU_ERROR_IMAGE_FORMAT, "99");
    desc.format = STRATA_FORMAT_R32F;
    desc.width = 0;
    failed(w, gpu_image_create(w->f.scope, &desc, &image, &w->f.err), GPU_ERROR_IMAGE_SIZE, "0x4");
    desc.width = 1u << 20;
    failed(w, gpu_image_create(w->f.scope, &desc, &image, &w->f.err), GPU_ERROR_IMAGE_SIZE, "'i'");
}

static void test_create_multisampled(void **state) {
    world *w = *state;
    strata_image image;
    const strata_image_desc sound = {.struct_size = sizeof sound,
                                     .label = "i",
                                     .format = STRATA_FORMAT_D32F_S8,
                                     .width = 4,
                                     .height = 4,
                                     .samples = 8};
    strata_image_desc bad[] = {sound, sound, sound, sound, sound};
    bad[0].samples = 16; /* limit.samples is 8 */
    bad[1].samples = 6;
    bad[2].layers = 1;
    bad[3].format = STRATA_FORMAT_R32U;
    bad[4].format = STRATA_FORMAT_RGBA8_SRGB;
    assert_int_equal(gpu_fact(w->f.g, "limit.samples"), 8);
    for (size_t i = 0; i < BASE_COUNT(bad); i++)
        failed(w, gpu_image_create(w->f.scope, &bad[i], &image, &w->f.err), GPU_ERROR_IMAGE_SAMPLES,
               "image 'i'");
    const uint64_t before = gpu_bytes(w->f.g, "test");
    assert_int_equal(gpu_image_create(w->f.scope, &sound, &image, &w->f.err), STRATA_OK);
    assert_int_equal(gpu_bytes(w->f.g, "test"), before + 4 * 4 * 8 * 8);
    assert_logged(&w->f, "image i 4x4x0 format 10 samples 8\n");
}

/* One sample is as good as none said; the host has no way into several. */
static void test_host_access_to_samples(void **state) {
    world *w = *state;
    float texels[16 * 16 * 4] = {0};
    const strata_image one = make_multisampled(&w->f, "one", 1);
    assert_int_equal(gpu_image_read(w->f.g, one, 0, texels, sizeof texels, &w->f.err), STRATA_OK);
    failed(w, gpu_image_read(w->f.g, w->multisampled, 0, texels, sizeof texels, &w->f.err),
           GPU_ERROR_IMAGE_SAMPLES, "4 samples");
    failed(w, gpu_image_write(w->f.g, w->multisampled, 0, 0, 0, 1, 1, texels, &w->f.err),
           GPU_ERROR_IMAGE_SAMPLES, "4 samples");
}

static void test_create_pool(void **state) {
    world *w = *state;
    strata_pool pool;
    strata_pool_desc desc = {.struct_size = sizeof desc,
                             .label = "p",
                             .counter_name = "Counter",
                             .plane_names = {"Plane"},
                             .plane_strides = {12}};
    failed(w, gpu_pool_create(w->f.scope, &desc, &pool, &w->f.err), GPU_ERROR_POOL_PLANES,
           "0 planes");
    desc.plane_count = 1;
    failed(w, gpu_pool_create(w->f.scope, &desc, &pool, &w->f.err), GPU_ERROR_POOL_PLANES,
           "stride 12");
    desc.plane_strides[0] = 8;
    desc.plane_names[0] = NULL;
    failed(w, gpu_pool_create(w->f.scope, &desc, &pool, &w->f.err), GPU_ERROR_POOL_PLANES,
           "plane 0");
    desc.plane_names[0] = "Plane";
    desc.plane_count = 9;
    failed(w, gpu_pool_create(w->f.scope, &desc, &pool, &w->f.err), GPU_ERROR_POOL_PLANES, "9");
    assert_int_equal(pool.id, 0);
}

static void test_create_program(void **state) {
    world *w = *state;
    strata_program program;
    const strata_glsl bad = {"void main() { undefined_function(); }\n", "bad.glsl"};
    strata_program_desc desc = {
        .struct_size = sizeof desc, .kind = STRATA_PROGRAM_COMPUTE, .label = "bad", .source = &bad};
    failed(w, gpu_program_create(w->f.scope, &desc, &program, &w->f.err), GPU_ERROR_PROGRAM_COMPILE,
           "bad.glsl:1: ");
    desc.kind = 3;
    failed(w, gpu_program_create(w->f.scope, &desc, &program, &w->f.err), GPU_ERROR_PROGRAM_KIND,
           "bad");
    desc.kind = STRATA_PROGRAM_COMPUTE;
    desc.source = NULL;
    failed(w, gpu_program_create(w->f.scope, &desc, &program, &w->f.err), GPU_ERROR_VALUE, "bad");
    /* A lazy program fails in its first pass, with its own words. */
    desc.source = &bad;
    desc.flags = STRATA_PROGRAM_LAZY;
    assert_int_equal(gpu_program_create(w->f.scope, &desc, &program, &w->f.err), STRATA_OK);
    w->dispatch.program = program;
    gpu_pass(w->f.g, "tester", &w->dispatch);
    assert_int_equal(gpu_last_code(w->f.g), GPU_ERROR_PROGRAM_COMPILE);
    assert_int_equal(gpu_frame_error(w->f.g)->result, STRATA_ERROR_SHADER);
    assert_non_null(strstr(gpu_frame_error(w->f.g)->text, "bad.glsl:1: "));
    assert_non_null(strstr(gpu_frame_error(w->f.g)->text, "pass 'dispatch'"));
}

/* One storage block more than a stage can have; unused ones do not count. */
static void test_create_too_many_blocks(void **state) {
    world *w = *state;
    strata_program program;
    base_text text = {0};
    uint32_t most = (uint32_t)gpu_fact(w->f.g, "limit.storage_blocks");
    base_text_add(&text, "layout(local_size_x = 1) in;\n");
    for (uint32_t i = 0; i <= most; i++)
        base_text_add(&text, "layout(std430) buffer B%u { uint v%u; };\n", i, i);
    base_text_add(&text, "void main() {\n#ifdef ALL\n    v%u = 1u;\n#endif\n", most);
    for (uint32_t i = 0; i < most; i++)
        base_text_add(&text, "    v%u = 1u;\n", i);
    base_text_add(&text, "}\n");
    static const char *const all[] = {"ALL"};
    const strata_glsl source = {text.data, "blocks.glsl"};
    strata_program_desc desc = {.struct_size = sizeof desc,
                                .kind = STRATA_PROGRAM_COMPUTE,
                                .label = "blocks",
                                .source = &source,
                                .defines = all};
    assert_int_equal(gpu_program_create(w->f.scope, &desc, &program, &w->f.err), STRATA_OK);
    desc.define_count = 1;
    failed(w, gpu_program_create(w->f.scope, &desc, &program, &w->f.err), GPU_ERROR_PROGRAM_BLOCKS,
           "blocks");
    base_text_free(&text);
}

static void test_draws(void **state) {
    world *w = *state;
    strata_draws draws;
    gpu_draws_desc desc = {.commands = w->values, .indices = w->extra, .capacity = 205};
    failed(w, gpu_draws_create(w->f.scope, &desc, &draws, &w->f.err), GPU_ERROR_BUFFER_RANGE,
           "205 commands");
    desc.capacity = 204;
    assert_int_equal(gpu_draws_create(w->f.scope, &desc, &draws, &w->f.err), STRATA_OK);
    desc.indices.id = 0;
    failed(w, gpu_draws_create(w->f.scope, &desc, &draws, &w->f.err), GPU_ERROR_HANDLE_UNKNOWN,
           "indices");
}

/* ---- failures that are injected -------------------------------------------------------------- */

static void test_memory_and_loss(void **state) {
    world *w = *state;
    fixture f;
    strata_buffer buffer;
    const strata_buffer_desc desc = {.struct_size = sizeof desc, .label = "b", .size = 4};
    open_device(&f, &(gpu_open_info){.backend = "null", .inject = "allocation:2"});
    make_buffer(&f, "first", 4);
    assert_int_equal(gpu_buffer_create(f.scope, &desc, &buffer, &f.err),
                     STRATA_ERROR_OUT_OF_DEVICE_MEMORY);
    assert_int_equal(gpu_last_code(f.g), GPU_ERROR_MEMORY);
    caused[GPU_ERROR_MEMORY] = 1;
    make_buffer(&f, "third", 4); /* only that one fails */
    gpu_close(f.g);

    open_device(&f, &(gpu_open_info){.backend = "null", .inject = "lost:2"});
    buffer = make_buffer(&f, "b", 4);
    gpu_begin(f.g, 4, 4);
    gpu_fill(f.g, "tester", buffer, 0, 4, 1);
    assert_int_equal(gpu_submit(f.g, &f.err), STRATA_OK);
    gpu_fill(f.g, "tester", buffer, 0, 4, 1);
    assert_int_equal(gpu_submit(f.g, &f.err), STRATA_ERROR_DEVICE_LOST);
    assert_int_equal(gpu_last_code(f.g), GPU_ERROR_LOST);
    caused[GPU_ERROR_LOST] = 1;
    f.err = (base_error){0};
    assert_int_equal(gpu_buffer_create(f.scope, &desc, &buffer, &f.err), STRATA_ERROR_DEVICE_LOST);
    size_t before = strlen(gpu_null_log(f.g));
    gpu_begin(f.g, 4, 4);
    gpu_fill(f.g, "tester", buffer, 0, 4, 1);
    f.err = (base_error){0};
    assert_int_equal(gpu_submit(f.g, &f.err), STRATA_ERROR_DEVICE_LOST);
    assert_string_equal(gpu_null_log(f.g) + before, "");
    gpu_scope_end(f.scope); /* destruction still works */
    assert_non_null(strstr(gpu_null_log(f.g) + before, "destroy buffer b"));
    gpu_close(f.g);
    (void)w;
}

static void test_inject_text(void **state) {
    gpu *g;
    static const char *const bad[] = {"allocation", "allocation:",     "allocation:0",  "lost:1x",
                                      "frob:1",     "allocation:-1",   "lacks:",        "lacks:a,",
                                      "claims:",    "claims:a,lost:1", "lacks:,lacks:a"};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(bad); i++) {
        base_error err = {0};
        assert_int_equal(gpu_open(&(gpu_open_info){.backend = "null", .inject = bad[i]}, &g, &err),
                         STRATA_ERROR_INVALID_ARGUMENT);
        assert_null(g);
    }
}

const struct CMUnitTest creation_tests[] = {
    IN_WORLD(test_create_buffer),
    IN_WORLD(test_create_image),
    IN_WORLD(test_create_multisampled),
    IN_WORLD(test_host_access_to_samples),
    IN_WORLD(test_create_pool),
    IN_WORLD(test_create_program),
    IN_WORLD(test_create_too_many_blocks),
    IN_WORLD(test_draws),
    IN_WORLD(test_memory_and_loss),
    cmocka_unit_test(test_inject_text),
};
const size_t creation_test_count = BASE_COUNT(creation_tests);
