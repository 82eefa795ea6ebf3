/* SPDX-License-Identifier: MIT
 *
 * The world of gpu_world.h over the null backend: one of each object, a dispatch and a draw that
 * are sound as they are.
 */
#define _POSIX_C_SOURCE 200809L
#include "unit/gpu_world.h"

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

static const strata_glsl texels_source = {"layout(location = 0) out vec4 color;\n"
                                          "uniform usamplerBuffer Values;\n"
                                          "void main() { color = vec4(texelFetch(Values, 7)); }\n",
                                          "texels.glsl"};

static const strata_glsl replace_source = {
    "#include \"strata/ordered.glsl\"\n"
    "STRATA_ORDERED_FLOAT(0)\n"
    "layout(std430) buffer Values { uint values[]; };\n"
    "void main() { values[0] = 1u; STRATA_ORDERED_STORE(0, STRATA_ORDERED_LOAD(0) + 1.0); }\n",
    "replace.glsl"};

unsigned char caused[128];

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

int open_world(void **state) {
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
    w->multisampled = make_multisampled(f, "multisampled", 4);
    w->compute = make_program(f, STRATA_PROGRAM_COMPUTE, &compute_source);
    w->fullscreen = make_program(f, STRATA_PROGRAM_FULLSCREEN, &color_source);
    w->writing = make_program(f, STRATA_PROGRAM_FULLSCREEN, &write_source);
    w->reading = make_program(f, STRATA_PROGRAM_FULLSCREEN, &image_source);
    w->texels = make_program(f, STRATA_PROGRAM_FULLSCREEN, &texels_source);
    w->replacing = make_program(f, STRATA_PROGRAM_FULLSCREEN, &replace_source);
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

int close_world(void **state) {
    world *w = *state;
    gpu_close(w->f.g);
    free(w);
    return 0;
}

void refused(world *w, const strata_pass *pass, gpu_code code, const char *text) {
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

void accepted(world *w, const strata_pass *pass) {
    gpu_pass(w->f.g, "tester", pass);
    if (gpu_frame_error(w->f.g)->result != STRATA_OK)
        fail_msg("%s", gpu_frame_error(w->f.g)->text);
}

void failed(world *w, strata_result result, gpu_code code, const char *text) {
    if (result == STRATA_OK || gpu_last_code(w->f.g) != code)
        fail_msg("expected '%s', got '%s' (%s)", gpu_code_text(code),
                 gpu_code_text(gpu_last_code(w->f.g)), w->f.err.text);
    caused[code] = 1;
    assert_int_equal(w->f.err.result, result);
    assert_non_null(strstr(w->f.err.text, text));
    w->f.err = (base_error){0};
}
