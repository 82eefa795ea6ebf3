/* SPDX-License-Identifier: MIT
 *
 * Each error that the validation in front of the backends can report, caused on purpose over the
 * null backend: the code, and that the line names what was wrong. Passes here, creation calls in
 * gpu_validation_create.c; the last test asks that no code of the list went uncaused.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_world.h"

/* ---- passes --------------------------------------------------------------------------------- */

static void test_sound(void **state) {
    world *w = *state;
    accepted(w, &w->dispatch);
    accepted(w, &w->draw);
    w->draw.depth = &w->depth_attachment;
    w->draw.depth_test = STRATA_TEST_GREATER;
    accepted(w, &w->draw);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
}

static void test_state(void **state) {
    world *w = *state;
    fixture fresh;
    open_device(&fresh, &(gpu_open_info){.backend = "null"});
    assert_int_equal(gpu_submit(fresh.g, &fresh.err), STRATA_ERROR_INVALID_STATE);
    assert_int_equal(gpu_last_code(fresh.g), GPU_ERROR_STATE);
    gpu_fill(fresh.g, "tester", make_buffer(&fresh, "b", 4), 0, 4, 0);
    assert_int_equal(gpu_last_code(fresh.g), GPU_ERROR_STATE);
    gpu_close(fresh.g);
    uint32_t value;
    accepted(w, &w->dispatch);
    failed(w, gpu_buffer_read(w->f.g, w->values, 0, 4, &value, &w->f.err), GPU_ERROR_STATE,
           "values");
    failed(w, gpu_buffer_write(w->f.g, w->values, 0, 4, &value, &w->f.err), GPU_ERROR_STATE,
           "values");
}

static void test_handles(void **state) {
    world *w = *state;
    gpu_scope *scope = gpu_scope_create(w->f.g, "short");
    strata_buffer dead;
    const strata_buffer_desc desc = {.struct_size = sizeof desc, .label = "dead", .size = 4};
    assert_int_equal(gpu_buffer_create(scope, &desc, &dead, &w->f.err), STRATA_OK);
    gpu_scope_end(scope);
    w->binds[0].buffer = dead;
    refused(w, &w->dispatch, GPU_ERROR_HANDLE_DEAD, "Values");
    strata_buffer next; /* may have the dead one's place, but not its id */
    assert_int_equal(gpu_buffer_create(w->f.scope, &desc, &next, &w->f.err), STRATA_OK);
    assert_int_not_equal(next.id, dead.id);
    refused(w, &w->dispatch, GPU_ERROR_HANDLE_DEAD, "Values");
    w->binds[0].buffer = (strata_buffer){9999};
    refused(w, &w->dispatch, GPU_ERROR_HANDLE_UNKNOWN, "Values");
    w->binds[0].buffer = (strata_buffer){w->color.id}; /* an image */
    refused(w, &w->dispatch, GPU_ERROR_HANDLE_UNKNOWN, "Values");
    w->binds[0].buffer = w->values;
    w->dispatch.program = (strata_program){0};
    refused(w, &w->dispatch, GPU_ERROR_HANDLE_UNKNOWN, "program");
    w->attachment.image = (strata_image){w->values.id};
    refused(w, &w->draw, GPU_ERROR_HANDLE_UNKNOWN, "colour attachment 0");
    w->draw.program = w->scene;
    failed(w, gpu_pool_grow(w->f.g, (strata_pool){77}, 4, &w->f.err), GPU_ERROR_HANDLE_UNKNOWN,
           "77");
}

static void test_struct_size(void **state) {
    world *w = *state;
    struct {
        strata_pass pass;
        uint32_t tail;
    } newer = {.pass = w->dispatch};
    newer.pass.struct_size = sizeof newer;
    accepted(w, &newer.pass); /* an unknown tail of zeros asks for nothing */
    gpu_begin(w->f.g, 16, 16);
    newer.tail = 1;
    refused(w, &newer.pass, GPU_ERROR_STRUCT_SIZE, "strata_pass");
    w->dispatch.struct_size = 8;
    refused(w, &w->dispatch, GPU_ERROR_STRUCT_SIZE, "strata_pass");
    w->dispatch.struct_size = sizeof w->dispatch;
    w->binds[1].struct_size = 0;
    refused(w, &w->dispatch, GPU_ERROR_STRUCT_SIZE, "bind 1");
    w->attachment.struct_size = 4;
    refused(w, &w->draw, GPU_ERROR_STRUCT_SIZE, "colour attachment 0");
    strata_buffer buffer;
    failed(w, gpu_buffer_create(w->f.scope, &(strata_buffer_desc){.size = 4}, &buffer, &w->f.err),
           GPU_ERROR_STRUCT_SIZE, "strata_buffer_desc");
}

static void test_values(void **state) {
    world *w = *state;
    w->draw.depth = &w->depth_attachment;
    w->draw.depth_test = 9;
    refused(w, &w->draw, GPU_ERROR_VALUE, "depth");
    w->draw.depth_test = 0;
    w->draw.color_count = 9;
    refused(w, &w->draw, GPU_ERROR_VALUE, "colour");
    w->draw.color_count = 1;
    w->attachment.load = 7;
    refused(w, &w->draw, GPU_ERROR_VALUE, "colour attachment 0");
    w->attachment.load = 0;
    w->binds[2].name = NULL;
    refused(w, &w->dispatch, GPU_ERROR_VALUE, "bind 2");
    failed(w, gpu_set_define(w->f.g, "two words", "1", &w->f.err), GPU_ERROR_VALUE, "two words");
    failed(w, gpu_set_include(w->f.g, "", "x", &w->f.err), GPU_ERROR_VALUE, "include");
}

static void test_label(void **state) {
    world *w = *state;
    w->dispatch.label = "";
    refused(w, &w->dispatch, GPU_ERROR_LABEL_MISSING, "strata_pass");
    w->dispatch.label = NULL;
    refused(w, &w->dispatch, GPU_ERROR_LABEL_MISSING, "strata_pass");
}

static void test_program_kind(void **state) {
    world *w = *state;
    w->draw.program = w->compute;
    refused(w, &w->draw, GPU_ERROR_PROGRAM_KIND, "draw");
    w->draw.program = w->fullscreen;
    w->draw.groups[0] = 1;
    refused(w, &w->draw, GPU_ERROR_PROGRAM_KIND, "draw");
    w->draw.groups[0] = 0;
    const gpu_draws_desc desc = {.commands = w->values, .indices = w->values, .capacity = 1};
    assert_int_equal(gpu_draws_create(w->f.scope, &desc, &w->draw.draws, &w->f.err), STRATA_OK);
    refused(w, &w->draw, GPU_ERROR_PROGRAM_KIND, "draw");
    w->draw.draws = (strata_draws){0};
    w->draw.program = w->scene;
    refused(w, &w->draw, GPU_ERROR_DRAWS_MISSING, "draw");
}

static void test_binds(void **state) {
    world *w = *state;
    w->dispatch.bind_count = 2;
    refused(w, &w->dispatch, GPU_ERROR_BIND_MISSING, "Block");
    w->dispatch.bind_count = 3;
    w->binds[1].name = "Extras";
    refused(w, &w->dispatch, GPU_ERROR_BIND_UNKNOWN, "Extras");
    w->binds[1].name = "Values";
    refused(w, &w->dispatch, GPU_ERROR_BIND_TWICE, "Values");
    w->binds[1] = bind_image("Extra", w->color);
    refused(w, &w->dispatch, GPU_ERROR_BIND_KIND, "Extra");
    w->binds[1] = bind_buffer("Extra", w->extra);
    w->binds[1].image = w->color; /* two at once */
    refused(w, &w->dispatch, GPU_ERROR_BIND_KIND, "Extra");
    w->binds[1] = bind_buffer("Extra", (strata_buffer){0}); /* none */
    refused(w, &w->dispatch, GPU_ERROR_BIND_KIND, "Extra");
    const strata_bind images[] = {bind_buffer("plain", w->values), bind_image("stored", w->other)};
    w->draw.program = w->reading;
    w->draw.binds = images;
    w->draw.bind_count = 2;
    refused(w, &w->draw, GPU_ERROR_BIND_KIND, "plain");
    const strata_bind layers[] = {bind_image("plain", w->layered), bind_image("stored", w->other)};
    w->draw.binds = layers;
    refused(w, &w->draw, GPU_ERROR_BIND_KIND, "layered");
}

/* A pool's plane and a buffer of the same name. */
static void test_bind_pool_twice(void **state) {
    world *w = *state;
    strata_pool pool;
    const strata_pool_desc desc = {.struct_size = sizeof desc,
                                   .label = "pool",
                                   .plane_count = 1,
                                   .counter_name = "Counter",
                                   .plane_names = {"Extra"},
                                   .plane_strides = {4}};
    assert_int_equal(gpu_pool_create(w->f.scope, &desc, &pool, &w->f.err), STRATA_OK);
    const strata_bind binds[] = {w->binds[0], w->binds[1], w->binds[2], bind_pool(pool)};
    w->dispatch.binds = binds;
    w->dispatch.bind_count = 4;
    refused(w, &w->dispatch, GPU_ERROR_BIND_TWICE, "Extra");
}

static void test_globals(void **state) {
    world *w = *state;
    w->dispatch.bind_count = 2;
    strata_bind global = bind_buffer("Block", w->block);
    assert_int_equal(gpu_set_global(w->f.g, "Block", &global, &w->f.err), STRATA_OK);
    accepted(w, &w->dispatch);
    assert_logged(&w->f, "Block=block");
    w->dispatch.bind_count = 3; /* a pass's own bind comes first */
    strata_buffer own = make_buffer(&w->f, "own", 64);
    w->binds[2].buffer = own;
    accepted(w, &w->dispatch);
    assert_logged(&w->f, "Block=own");
    w->dispatch.bind_count = 2;
    assert_int_equal(gpu_set_global(w->f.g, "Block", NULL, &w->f.err), STRATA_OK);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    refused(w, &w->dispatch, GPU_ERROR_BIND_MISSING, "Block");
}

static void test_params(void **state) {
    world *w = *state;
    w->dispatch.params_size = 8;
    refused(w, &w->dispatch, GPU_ERROR_PARAMS_SIZE, "8 bytes");
    w->dispatch.params_size = 0;
    refused(w, &w->dispatch, GPU_ERROR_PARAMS_SIZE, "has 4");
    w->draw.params = &w->count;
    w->draw.params_size = 4;
    refused(w, &w->draw, GPU_ERROR_PARAMS_SIZE, "has 0");
}

static void test_ranges(void **state) {
    world *w = *state;
    w->binds[0].offset = 256;
    w->binds[0].size = 4096 - 256;
    accepted(w, &w->dispatch);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    w->binds[0].size = 4096;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "values");
    w->binds[0].offset = 128;
    w->binds[0].size = 128;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "128 at 128");
    w->binds[0].offset = 4096;
    w->binds[0].size = 0;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "values");
    w->binds[0].offset = UINT64_MAX - 255;
    w->binds[0].size = 512;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "values");
    w->binds[0].offset = 256;
    w->binds[0].size = UINT64_MAX - 99;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "values");
    w->binds[0] = bind_buffer("Values", w->values);
    w->binds[2].buffer = make_buffer(&w->f, "short", 60); /* the block has 64 */
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "short");
    w->binds[2].buffer = w->block;
    w->binds[1].buffer = make_buffer(&w->f, "head", 4); /* before its array it has 8 */
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "the block has 8");
    uint32_t words[2];
    failed(w, gpu_buffer_read(w->f.g, w->values, 4092, 8, words, &w->f.err), GPU_ERROR_BUFFER_RANGE,
           "values");
    failed(w, gpu_buffer_write(w->f.g, w->values, 2, 4, words, &w->f.err), GPU_ERROR_BUFFER_RANGE,
           "values");
    gpu_fill(w->f.g, "tester", w->values, 0, 4100, 0);
    assert_int_equal(gpu_last_code(w->f.g), GPU_ERROR_BUFFER_RANGE);
    gpu_begin(w->f.g, 16, 16);
    gpu_copy(w->f.g, "tester", w->values, 0, w->values, 64, 128);
    assert_int_equal(gpu_last_code(w->f.g), GPU_ERROR_BUFFER_RANGE);
    gpu_begin(w->f.g, 16, 16);
    gpu_copy(w->f.g, "tester", w->values, 0, w->values, 64, 64);
    gpu_copy(w->f.g, "tester", w->extra, 4032, w->values, 0, 64);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    gpu_copy(w->f.g, "tester", w->extra, 4036, w->values, 0, 64);
    assert_int_equal(gpu_last_code(w->f.g), GPU_ERROR_BUFFER_RANGE);
}

/* Behind a usamplerBuffer stands a whole buffer, no image, and no more words than it reads. */
static void test_texels(void **state) {
    world *w = *state;
    const uint64_t limit = gpu_fact(w->f.g, "limit.texels");
    w->draw.program = w->texels;
    w->draw.binds = w->binds;
    w->draw.bind_count = 1;
    accepted(w, &w->draw);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    w->binds[0].size = 4096;
    accepted(w, &w->draw);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    w->binds[0].size = 256;
    refused(w, &w->draw, GPU_ERROR_BUFFER_RANGE, "256 bytes at 0; a usamplerBuffer");
    w->binds[0].size = 0;
    w->binds[0].offset = 256;
    refused(w, &w->draw, GPU_ERROR_BUFFER_RANGE, "3840 bytes at 256");
    w->binds[0] = bind_buffer("Values", make_buffer(&w->f, "many", 4 * limit + 4));
    refused(w, &w->draw, GPU_ERROR_BUFFER_LIMIT, "many");
    w->binds[0] =
        (strata_bind){.struct_size = sizeof(strata_bind), .name = "Values", .image = w->integer};
    refused(w, &w->draw, GPU_ERROR_BIND_KIND, "integer");
}

static void test_limits(void **state) {
    world *w = *state;
    uint64_t limit = gpu_fact(w->f.g, "limit.storage_range");
    strata_buffer large = make_buffer(&w->f, "large", limit + 4);
    w->binds[1].buffer = large;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_LIMIT, "large");
    w->binds[1].size = limit;
    accepted(w, &w->dispatch);
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    w->binds[1] = bind_buffer("Extra", w->extra);
    w->dispatch.groups[1] = (uint32_t)gpu_fact(w->f.g, "limit.groups") + 1;
    refused(w, &w->dispatch, GPU_ERROR_GROUPS_LIMIT, "groups");
    w->dispatch.groups[1] = 0;
    w->dispatch.indirect = w->extra;
    w->dispatch.indirect_offset = 2;
    refused(w, &w->dispatch, GPU_ERROR_INDIRECT_ALIGNMENT, "indirect");
    w->dispatch.indirect_offset = 4088;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "indirect");
    w->dispatch.indirect = make_buffer(&w->f, "two words", 8);
    w->dispatch.indirect_offset = 0;
    refused(w, &w->dispatch, GPU_ERROR_BUFFER_RANGE, "indirect");
    w->dispatch.indirect = w->extra;
    w->dispatch.indirect_offset = 4084;
    accepted(w, &w->dispatch);
}

/* ---- attachments ---------------------------------------------------------------------------- */

static void test_attachments(void **state) {
    world *w = *state;
    strata_attachment two[2] = {w->attachment, w->attachment};
    two[1].image = w->small;
    w->draw.color = two;
    w->draw.color_count = 2;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_SIZE, "small");
    two[1].image = w->layered;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_SIZE, "layered");
    two[1].image = w->color;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_HAZARD, "colour attachment 1");
    two[1].image = w->depth;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "colour attachment 1");
    two[1].image = w->srgb;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "colour attachment 1");
    two[1].image = w->integer;
    two[1].blend = STRATA_BLEND_ADD;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "colour attachment 1");
    w->draw.color_count = 1;
    w->draw.depth_test = STRATA_TEST_GREATER;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_MISSING, "depth");
    w->draw.depth = &w->attachment;
    w->draw.color_count = 0;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "depth attachment");
    w->draw.depth = &w->depth_attachment;
    w->draw.stencil_test = STRATA_TEST_EQUAL; /* no stencil in it */
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "depth attachment");
}

static void test_outputs(void **state) {
    world *w = *state;
    strata_attachment two[2] = {w->attachment, w->attachment};
    two[0].image = w->integer; /* the program writes floats */
    w->draw.color = two;
    refused(w, &w->draw, GPU_ERROR_OUTPUT_TYPE, "colour attachment 0");
    two[0].image = w->color;
    two[1].image = w->other; /* and nothing here */
    w->draw.color_count = 2;
    refused(w, &w->draw, GPU_ERROR_OUTPUT_TYPE, "colour attachment 1");
    two[1].mask_off = 15;
    accepted(w, &w->draw);
}

static void test_target(void **state) {
    world *w = *state;
    w->draw.color_count = 0;
    accepted(w, &w->draw); /* the frame's size */
    assert_logged(&w->f, "draw program program 16x16 scissor 0,0 16x16");
    w->draw.width = 40;
    w->draw.height = 8;
    accepted(w, &w->draw);
    assert_logged(&w->f, "draw program program 40x8 scissor 0,0 16x8");
    w->draw.whole_frame = 1;
    accepted(w, &w->draw);
    assert_logged(&w->f, "draw program program 40x8 scissor 0,0 40x8");
    assert_int_equal(gpu_submit(w->f.g, &w->f.err), STRATA_OK);
    w->draw.width = w->draw.height = 0;
    gpu_begin(w->f.g, 0, 0);
    gpu_pass(w->f.g, "tester", &w->draw);
    assert_int_equal(gpu_last_code(w->f.g), GPU_ERROR_ATTACHMENT_MISSING);
    gpu_begin(w->f.g, 16, 16);
    w->draw.width = 100000;
    w->draw.height = 1;
    refused(w, &w->draw, GPU_ERROR_IMAGE_SIZE, "target");
}

static void test_feedback(void **state) {
    world *w = *state;
    const strata_bind images[] = {bind_image("plain", w->color), bind_image("stored", w->other)};
    w->draw.program = w->reading;
    w->draw.binds = images;
    w->draw.bind_count = 2;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_HAZARD, "plain");
    w->attachment.image = w->other;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_HAZARD, "stored");
    const strata_bind formats[] = {bind_image("plain", w->color), bind_image("stored", w->srgb)};
    w->draw.binds = formats;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "stored");
    strata_image half = make_image(&w->f, "half", STRATA_FORMAT_RGBA16F, 16, 16, 0);
    const strata_bind halves[] = {bind_image("plain", w->color), bind_image("stored", half)};
    w->draw.binds = halves; /* the shader says rgba32f */
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "stored");
    const strata_bind integers[] = {bind_image("plain", w->integer),
                                    bind_image("stored", w->color)};
    w->draw.binds = integers;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "plain");
}

static void test_read_attachments(void **state) {
    world *w = *state;
    const strata_bind bind = bind_buffer("Values", w->values);
    const strata_glsl source = {"#include \"strata/ordered.glsl\"\nSTRATA_ORDERED_UINT(0)\n"
                                "void main() { STRATA_ORDERED_STORE(0, uvec4(1u)); }\n",
                                "replace.glsl"};
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_FULLSCREEN,
                                      .label = "replacing",
                                      .source = &source};
    strata_program program;
    fixture lacking;
    w->attachment.read = 1;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_READ, "program"); /* it does not */
    w->draw.program = w->replacing;
    w->draw.binds = &bind;
    w->draw.bind_count = 1;
    accepted(w, &w->draw); /* storage may be written beside it */
    assert_logged(&w->f, "color read color Values=values");
    w->attachment.read = 2;
    refused(w, &w->draw, GPU_ERROR_VALUE, "color");
    w->attachment.read = 1;
    w->attachment.blend = STRATA_BLEND_ADD;
    refused(w, &w->draw, GPU_ERROR_VALUE, "color");
    w->attachment.blend = STRATA_BLEND_NONE;
    w->attachment.image = w->layered;
    refused(w, &w->draw, GPU_ERROR_VALUE, "layered");
    w->attachment.image = w->color;
    w->attachment.read = 0;
    w->attachment.mask_off = 15;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_READ, "program");
    w->depth_attachment.read = 1;
    w->draw.depth = &w->depth_attachment;
    refused(w, &w->draw, GPU_ERROR_VALUE, "depth");

    open_device(&lacking,
                &(gpu_open_info){.backend = "null", .inject = "lacks:ordered_attachments"});
    assert_int_equal(gpu_program_create(lacking.scope, &desc, &program, &lacking.err),
                     STRATA_ERROR_UNSUPPORTED);
    assert_int_equal(gpu_last_code(lacking.g), GPU_ERROR_ORDERED_MISSING);
    assert_non_null(strstr(lacking.err.text, "replacing"));
    caused[GPU_ERROR_ORDERED_MISSING] = 1;
    gpu_close(lacking.g);
}

static void test_multisampled_attachments(void **state) {
    world *w = *state;
    strata_attachment two[2] = {w->attachment, w->attachment};
    two[0].image = w->multisampled;
    w->draw.color = two;
    accepted(w, &w->draw);
    two[1].image = w->other;
    two[1].mask_off = 15;
    w->draw.color_count = 2;
    refused(w, &w->draw, GPU_ERROR_ATTACHMENT_SIZE, "1 samples beside 16x16, 1, 4");
    w->draw.color_count = 1;
    two[0].read = 1;
    w->draw.program = w->replacing;
    const strata_bind bind = bind_buffer("Values", w->values);
    w->draw.binds = &bind;
    w->draw.bind_count = 1;
    refused(w, &w->draw, GPU_ERROR_VALUE, "multisampled");
}

static void test_sample_mask(void **state) {
    world *w = *state;
    w->draw.sample_mask = 1;
    refused(w, &w->draw, GPU_ERROR_SAMPLE_MASK, "mask 0x1 of 1 samples");
    w->dispatch.sample_mask = 1;
    refused(w, &w->dispatch, GPU_ERROR_SAMPLE_MASK, "mask 0x1 of 0 samples");
    w->attachment.image = w->multisampled;
    w->draw.sample_mask = 10;
    accepted(w, &w->draw);
    assert_logged(&w->f, "color multisampled samples 0xa");
    w->draw.sample_mask = 16;
    refused(w, &w->draw, GPU_ERROR_SAMPLE_MASK, "mask 0x10 of 4 samples");
}

/* Draws reach all samples. */
static void test_sample_mask_of_draws(void **state) {
    static const char *const globals[] = {"StrataFrame", "StrataRecords", "StrataPositions",
                                          "StrataMaterials"};
    world *w = *state;
    const gpu_draws_desc desc = {.commands = w->values, .indices = w->extra, .capacity = 1};
    for (size_t i = 0; i < BASE_COUNT(globals); i++) {
        const strata_bind bind = bind_buffer(globals[i], w->values);
        assert_int_equal(gpu_set_global(w->f.g, globals[i], &bind, &w->f.err), STRATA_OK);
    }
    assert_int_equal(gpu_draws_create(w->f.scope, &desc, &w->draw.draws, &w->f.err), STRATA_OK);
    w->draw.program = w->scene;
    w->attachment.image = w->multisampled;
    accepted(w, &w->draw);
    w->draw.sample_mask = 1;
    refused(w, &w->draw, GPU_ERROR_SAMPLE_MASK, "mask 0x1 of 4 samples");
}

static void test_multisampled_binds(void **state) {
    static const strata_glsl sampling = {
        "layout(location = 0) out vec4 color;\n"
        "uniform sampler2DMS samples;\n"
        "void main() { color = texelFetch(samples, ivec2(0), 3); }\n",
        "sampling.glsl"};
    static const strata_glsl storing = {
        "layout(location = 0) out vec4 color;\n"
        "layout(rgba32f) uniform readonly image2DMS samples;\n"
        "void main() { color = imageLoad(samples, ivec2(0), 3); }\n",
        "storing.glsl"};
    world *w = *state;
    strata_bind bind = bind_image("samples", w->multisampled);
    w->draw.program = make_program(&w->f, STRATA_PROGRAM_FULLSCREEN, &sampling);
    w->draw.binds = &bind;
    w->draw.bind_count = 1;
    accepted(w, &w->draw);
    assert_logged(&w->f, "samples=multisampled");
    bind.image = w->other;
    refused(w, &w->draw, GPU_ERROR_IMAGE_SAMPLES, "image 'other' of 1 samples");
    const strata_bind images[] = {bind_image("plain", w->multisampled),
                                  bind_image("stored", w->other)};
    w->draw.program = w->reading;
    w->draw.binds = images;
    w->draw.bind_count = 2;
    refused(w, &w->draw, GPU_ERROR_IMAGE_SAMPLES, "'plain': image 'multisampled' of 4 samples");
    strata_program program;
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_FULLSCREEN,
                                      .label = "storing",
                                      .source = &storing};
    assert_int_equal(gpu_program_create(w->f.scope, &desc, &program, &w->f.err),
                     STRATA_ERROR_SHADER);
}

static void test_opaque_writes(void **state) {
    world *w = *state;
    const strata_bind binds[] = {bind_buffer("Values", w->values)};
    w->draw.program = w->writing;
    w->draw.binds = binds;
    w->draw.bind_count = 1;
    refused(w, &w->draw, GPU_ERROR_OPAQUE_WRITES, "Values");
    w->attachment.mask_off = 15;
    accepted(w, &w->draw);
    w->attachment.mask_off = 0;
    w->attachment.blend = STRATA_BLEND_ADD;
    accepted(w, &w->draw);
    w->draw.color_count = 0;
    accepted(w, &w->draw);
}

static void test_all_caused(void **state) {
    (void)state;
    for (int code = GPU_ERROR_NONE + 1; code <= GPU_ERROR_LOST; code++)
        if (!caused[code])
            fail_msg("nothing caused '%s'", gpu_code_text((gpu_code)code));
}

int main(void) {
    const struct CMUnitTest pass_tests[] = {
        IN_WORLD(test_sound),
        IN_WORLD(test_state),
        IN_WORLD(test_handles),
        IN_WORLD(test_struct_size),
        IN_WORLD(test_values),
        IN_WORLD(test_label),
        IN_WORLD(test_program_kind),
        IN_WORLD(test_binds),
        IN_WORLD(test_bind_pool_twice),
        IN_WORLD(test_globals),
        IN_WORLD(test_params),
        IN_WORLD(test_ranges),
        IN_WORLD(test_texels),
        IN_WORLD(test_limits),
        IN_WORLD(test_attachments),
        IN_WORLD(test_outputs),
        IN_WORLD(test_target),
        IN_WORLD(test_feedback),
        IN_WORLD(test_read_attachments),
        IN_WORLD(test_opaque_writes),
        IN_WORLD(test_multisampled_attachments),
        IN_WORLD(test_sample_mask),
        IN_WORLD(test_sample_mask_of_draws),
        IN_WORLD(test_multisampled_binds),
    };
    const struct CMUnitTest last[] = {cmocka_unit_test(test_all_caused)};
    return cmocka_run_group_tests(pass_tests, NULL, NULL) +
           _cmocka_run_group_tests("creation_tests", creation_tests, creation_test_count, NULL,
                                   NULL) +
           cmocka_run_group_tests(last, NULL, NULL);
}
