/* SPDX-License-Identifier: MIT
 *
 * Each error that the validation in front of the backends can report, caused on purpose over the
 * null backend: the code, and that the line names what was wrong. The last test asks that no code
 * of the list went uncaused.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_fixture.h"

static const strata_glsl compute_source = {
    "layout(local_size_x = 64) in;\n"
    "layout(std430) buffer Values { uint values[]; };\n"
    "layout(std430) readonly buffer Extra { uint head[2]; uint extra[]; };\n"
    "layout(std140) uniform Block { vec4 block[4]; };\n"
    "STRATA_PARAMS { uint count; } params;\n"
    "void main() { values[0] = params.count + extra[0] + uint(block[1].x); }\n",
    "compute.glsl"};
static const strata_glsl color_source = {
    "layout(location = 0) out vec4 color;\nvoid main() { color = vec4(1.0); }\n", "color.glsl"};
static const strata_glsl write_source = {"layout(location = 0) out vec4 color;\n"
                                         "layout(std430) buffer Values { uint values[]; };\n"
                                         "void main() { values[0] = 1u; color = vec4(1.0); }\n",
                                         "write.glsl"};
static const strata_glsl image_source = {
    "layout(location = 0) out vec4 color;\n"
    "uniform sampler2D plain;\n"
    "layout(rgba32f) uniform readonly image2D stored;\n"
    "void main() { color = texelFetch(plain, ivec2(0), 0) + imageLoad(stored, ivec2(0)); }\n",
    "image.glsl"};

typedef struct world {
    fixture f;
    strata_buffer values, extra, block;
    strata_image color, other, small, depth, layered, integer, srgb;
    strata_program compute, fullscreen, writing, reading, scene;
    strata_bind binds[3];
    uint32_t count;
    strata_pass dispatch; /* sound as it is; a test spoils one thing */
    strata_pass draw;
    strata_attachment attachment, depth_attachment;
} world;

static unsigned char caused[128];

static strata_program scene_program(fixture *f) {
    strata_program program;
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_SCENE,
                                      .flags = STRATA_PROGRAM_LAZY,
                                      .label = "scene",
                                      .source = &color_source};
    assert_int_equal(gpu_program_create(f->scope, &desc, &program, &f->err), STRATA_OK);
    return program;
}

static int open_world(void **state) {
    world *w = calloc(1, sizeof *w);
    assert_non_null(w);
    fixture *f = &w->f;
    open_device(f, &(gpu_open_info){.backend = "null"});
    w->values = make_buffer(f, "values", 4096);
    w->extra = make_buffer(f, "extra", 4096);
    w->block = make_buffer(f, "block", 64);
    w->color = make_image(f, "color", STRATA_FORMAT_RGBA32F, 16, 16, 0);
    w->other = make_image(f, "other", STRATA_FORMAT_RGBA32F, 16, 16, 0);
    w->small = make_image(f, "small", STRATA_FORMAT_RGBA32F, 8, 8, 0);
    w->depth = make_image(f, "depth", STRATA_FORMAT_D32F, 16, 16, 0);
    w->layered = make_image(f, "layered", STRATA_FORMAT_RGBA32F, 16, 16, 2);
    w->integer = make_image(f, "integer", STRATA_FORMAT_R32U, 16, 16, 0);
    w->srgb = make_image(f, "srgb", STRATA_FORMAT_RGBA8_SRGB, 16, 16, 0);
    w->compute = make_program(f, STRATA_PROGRAM_COMPUTE, &compute_source);
    w->fullscreen = make_program(f, STRATA_PROGRAM_FULLSCREEN, &color_source);
    w->writing = make_program(f, STRATA_PROGRAM_FULLSCREEN, &write_source);
    w->reading = make_program(f, STRATA_PROGRAM_FULLSCREEN, &image_source);
    w->scene = scene_program(f);
    w->count = 1;
    w->binds[0] = bind_buffer("Values", w->values);
    w->binds[1] = bind_buffer("Extra", w->extra);
    w->binds[2] = bind_buffer("Block", w->block);
    w->dispatch = (strata_pass){.struct_size = sizeof w->dispatch,
                                .label = "dispatch",
                                .groups = {1},
                                .program = w->compute,
                                .params = &w->count,
                                .params_size = 4,
                                .binds = w->binds,
                                .bind_count = 3};
    w->attachment = (strata_attachment){.struct_size = sizeof w->attachment, .image = w->color};
    w->depth_attachment =
        (strata_attachment){.struct_size = sizeof w->depth_attachment, .image = w->depth};
    w->draw = (strata_pass){.struct_size = sizeof w->draw,
                            .label = "draw",
                            .program = w->fullscreen,
                            .color = &w->attachment,
                            .color_count = 1};
    gpu_begin(f->g, 16, 16);
    *state = w;
    return 0;
}

static int close_world(void **state) {
    world *w = *state;
    gpu_close(w->f.g);
    free(w);
    return 0;
}

/* The pass fails with this code, its line holds `text` and the pass's label, and nothing was
 * recorded; after gpu_begin the device is as good as new. */
static void refused(world *w, const strata_pass *pass, gpu_code code, const char *text) {
    gpu *g = w->f.g;
    size_t before = strlen(gpu_null_log(g));
    gpu_pass(g, "tester", pass);
    const base_error *failure = gpu_frame_error(g);
    if (failure->result == STRATA_OK || gpu_last_code(g) != code)
        fail_msg("expected '%s', got '%s' (%s)", gpu_code_text(code),
                 gpu_code_text(gpu_last_code(g)), failure->text);
    caused[code] = 1;
    assert_non_null(strstr(failure->text, text));
    assert_non_null(strstr(failure->text, "tester"));
    assert_non_null(strstr(failure->text, gpu_code_text(code)));
    assert_string_equal(gpu_null_log(g) + before, "");
    base_error err = {0};
    assert_int_equal(gpu_submit(g, &err), failure->result);
    assert_int_equal(gpu_last_code(g), code);
    gpu_begin(g, 16, 16);
    assert_int_equal(gpu_frame_error(g)->result, STRATA_OK);
    assert_int_equal(gpu_last_code(g), GPU_ERROR_NONE);
}

static void accepted(world *w, const strata_pass *pass) {
    gpu_pass(w->f.g, "tester", pass);
    if (gpu_frame_error(w->f.g)->result != STRATA_OK)
        fail_msg("%s", gpu_frame_error(w->f.g)->text);
}

/* A creation that has failed: the code, and words in its line. */
static void failed(world *w, strata_result result, gpu_code code, const char *text) {
    if (result == STRATA_OK || gpu_last_code(w->f.g) != code)
        fail_msg("expected '%s', got '%s' (%s)", gpu_code_text(code),
                 gpu_code_text(gpu_last_code(w->f.g)), w->f.err.text);
    caused[code] = 1;
    assert_int_equal(w->f.err.result, result);
    assert_non_null(strstr(w->f.err.text, text));
    w->f.err = (base_error){0};
}

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
    w->attachment.image = w->layered;
    refused(w, &w->draw, GPU_ERROR_VALUE, "layered");
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
    const strata_bind integers[] = {bind_image("plain", w->integer),
                                    bind_image("stored", w->color)};
    w->draw.binds = integers;
    refused(w, &w->draw, GPU_ERROR_IMAGE_FORMAT, "plain");
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

    open_device(&f, &(gpu_open_info){.backend = "null", .inject = "lost:1"});
    buffer = make_buffer(&f, "b", 4);
    gpu_begin(f.g, 4, 4);
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
    static const char *const bad[] = {"allocation", "allocation:", "allocation:0",
                                      "lost:1x",    "frob:1",      "allocation:-1"};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(bad); i++) {
        base_error err = {0};
        assert_int_equal(gpu_open(&(gpu_open_info){.backend = "null", .inject = bad[i]}, &g, &err),
                         STRATA_ERROR_INVALID_ARGUMENT);
        assert_null(g);
    }
}

static void test_all_caused(void **state) {
    (void)state;
    for (int code = GPU_ERROR_NONE + 1; code <= GPU_ERROR_LOST; code++)
        if (!caused[code])
            fail_msg("nothing caused '%s'", gpu_code_text((gpu_code)code));
}

#define IN_WORLD(test) cmocka_unit_test_setup_teardown(test, open_world, close_world)

int main(void) {
    const struct CMUnitTest tests[] = {
        IN_WORLD(test_sound),
        IN_WORLD(test_state),
        IN_WORLD(test_handles),
        IN_WORLD(test_struct_size),
        IN_WORLD(test_values),
        IN_WORLD(test_label),
        IN_WORLD(test_program_kind),
        IN_WORLD(test_binds),
        IN_WORLD(test_globals),
        IN_WORLD(test_params),
        IN_WORLD(test_ranges),
        IN_WORLD(test_limits),
        IN_WORLD(test_attachments),
        IN_WORLD(test_outputs),
        IN_WORLD(test_target),
        IN_WORLD(test_feedback),
        IN_WORLD(test_opaque_writes),
        IN_WORLD(test_create_buffer),
        IN_WORLD(test_create_image),
        IN_WORLD(test_create_pool),
        IN_WORLD(test_create_program),
        IN_WORLD(test_create_too_many_blocks),
        IN_WORLD(test_draws),
        IN_WORLD(test_memory_and_loss),
        cmocka_unit_test(test_inject_text),
        cmocka_unit_test(test_all_caused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
