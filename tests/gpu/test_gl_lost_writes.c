/* SPDX-License-Identifier: MIT
 *
 * llvmpipe forgets what fragments wrote to storage when an opaque draw covers their tile before its
 * scene is flushed. The shapes of pass that the host allows (no colour attachment, blended, masked)
 * must lose nothing, whatever later passes do to the same target; the shape that loses is refused.
 */
#include "gpu/gpu_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define SIZE      256u
#define PIXELS    (SIZE * SIZE)
#define TRIANGLES 3u

static const strata_glsl count_source = {.text =
                                             "layout(std430) buffer Counts { uint counts[]; };\n"
                                             "layout(location = 0) out vec4 color;\n"
                                             "void main() {\n"
                                             "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
                                             "    atomicAdd(counts[p.y * 256u + p.x], 1u);\n"
                                             "    color = vec4(0.5);\n"
                                             "}\n",
                                         .path = "count.glsl"};
static const strata_glsl replace_source = {.text =
                                               "#include \"strata/ordered.glsl\"\n"
                                               "STRATA_ORDERED_FLOAT(0)\n"
                                               "layout(std430) buffer Counts { uint counts[]; };\n"
                                               "void main() {\n"
                                               "    uvec2 p = uvec2(gl_FragCoord.xy);\n"
                                               "    atomicAdd(counts[p.y * 256u + p.x], 1u);\n"
                                               "    vec4 before = STRATA_ORDERED_LOAD(0);\n"
                                               "    STRATA_ORDERED_STORE(0, before * 0.5 + 0.5);\n"
                                               "}\n",
                                           .path = "replace.glsl"};
static const strata_glsl plain_source = {.text = "layout(location = 0) out vec4 color;\n"
                                                 "void main() { color = vec4(1.0); }\n",
                                         .path = "plain.glsl"};

typedef struct fixture {
    gpu *g;
    gpu_scope *scope;
    strata_program count, plain, replace; /* replace: only where attachments can be read */
    strata_image color, depth;
    strata_buffer counts, commands, draw_count, indices;
    uint32_t found[PIXELS];
} fixture;

static strata_program program(fixture *f, const strata_glsl *source) {
    const strata_program_desc desc = {.struct_size = sizeof desc,
                                      .kind = STRATA_PROGRAM_FULLSCREEN,
                                      .label = source->path,
                                      .source = source};
    strata_program out;
    base_error err = {0};
    if (gpu_program_create(f->scope, &desc, &out, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    return out;
}

static strata_image image(fixture *f, const char *label, uint32_t format) {
    const strata_image_desc desc = {.struct_size = sizeof desc,
                                    .format = format,
                                    .label = label,
                                    .width = SIZE,
                                    .height = SIZE};
    strata_image out;
    assert_int_equal(gpu_image_create(f->scope, &desc, &out, NULL), STRATA_OK);
    return out;
}

static strata_buffer buffer(fixture *f, const char *label, uint64_t size, const void *data) {
    const strata_buffer_desc desc = {
        .struct_size = sizeof desc, .label = label, .size = size, .data = data};
    strata_buffer out;
    assert_int_equal(gpu_buffer_create(f->scope, &desc, &out, NULL), STRATA_OK);
    return out;
}

static int set_up(void **state) {
    const gpu_open_info info = {.backend = "gl", .check = 1};
    const uint32_t command[5] = {3 * TRIANGLES, 1, 0, 0, 0}, draws = 1;
    uint32_t indices[3 * TRIANGLES];
    base_error err = {0};
    fixture *f = calloc(1, sizeof *f);
    *state = f;
    if (!f || gpu_open(&info, &f->g, &err) != STRATA_OK) {
        print_message("no OpenGL here: %s\n", err.text);
        return 0;
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++)
        indices[i] = i % 3; /* each covers the whole target */
    f->scope = gpu_scope_create(f->g, "test");
    f->count = program(f, &count_source);
    f->plain = program(f, &plain_source);
    if (gpu_fact(f->g, "ordered_attachments"))
        f->replace = program(f, &replace_source);
    f->color = image(f, "color", STRATA_FORMAT_RGBA8);
    f->depth = image(f, "depth", STRATA_FORMAT_D32F);
    f->counts = buffer(f, "counts", sizeof f->found, NULL);
    f->commands = buffer(f, "commands", sizeof command, command);
    f->draw_count = buffer(f, "draw count", sizeof draws, &draws);
    f->indices = buffer(f, "indices", sizeof indices, indices);
    return 0;
}

static int tear_down(void **state) {
    fixture *f = *state;
    gpu_close(f->g);
    free(f);
    return 0;
}

static fixture *fixture_of(void **state) {
    fixture *f = *state;
    if (!f->g)
        skip();
    return f;
}

static gpu_object *find(const fixture *f, uint32_t id, gpu_kind kind) {
    gpu_code code;
    gpu_object *object = gpu_object_find(f->g, id, kind, &code);
    assert_non_null(object);
    return object;
}

/* Several triangles through a full-screen program: what only the host's self-tests may draw, so the
 * backend is called here in place of the core. */
static void draw(const fixture *f, const strata_pass *pass, strata_program with) {
    const gpu_object *object = find(f, with.id, GPU_PROGRAM);
    const gpu_program_state *state = object->program;
    gpu_native_bind bind = {.native = find(f, f->counts.id, GPU_BUFFER)->buffer.storage->native,
                            .size = sizeof f->found};
    gpu_native_pass native = {
        .pass = pass,
        .program = state->native,
        .binds = &bind,
        .width = SIZE,
        .height = SIZE,
        .scissor = {0, 0, SIZE, SIZE},
        .commands = find(f, f->commands.id, GPU_BUFFER)->buffer.storage->native,
        .count = find(f, f->draw_count.id, GPU_BUFFER)->buffer.storage->native,
        .indices = find(f, f->indices.id, GPU_BUFFER)->buffer.storage->native,
        .draw_capacity = 1};
    if (state->binding_count > 0) {
        bind.binding = &state->bindings[0];
        native.bind_count = 1;
    }
    if (pass->color_count > 0)
        native.color[0] = find(f, f->color.id, GPU_IMAGE)->image.storage->native;
    if (pass->depth)
        native.depth = find(f, f->depth.id, GPU_IMAGE)->image.storage->native;
    f->g->backend->pass(f->g->self, &native);
}

static void clear_counts(const fixture *f) {
    f->g->backend->begin(f->g->self);
    f->g->backend->fill(f->g->self, find(f, f->counts.id, GPU_BUFFER)->buffer.storage->native, 0,
                        sizeof f->found, 0, NULL, 0);
}

/* Submits; returns how many writes are missing. */
static uint32_t lost_writes(fixture *f) {
    base_error err = {0};
    uint32_t lost = 0;
    if (f->g->backend->submit(f->g->self, NULL, 0, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    assert_int_equal(gpu_buffer_read(f->g, f->counts, 0, sizeof f->found, f->found, &err),
                     STRATA_OK);
    for (uint32_t i = 0; i < PIXELS; i++) {
        assert_true(f->found[i] <= TRIANGLES);
        lost += TRIANGLES - f->found[i];
    }
    return lost;
}

static const strata_attachment opaque = {.struct_size = sizeof opaque};
static const strata_attachment blended = {.struct_size = sizeof blended,
                                          .blend = STRATA_BLEND_OVER};
static const strata_attachment masked = {.struct_size = sizeof masked, .mask_off = 15};
static const strata_attachment cleared = {.struct_size = sizeof cleared, .load = STRATA_LOAD_CLEAR};

/* One counting draw with this colour and depth, alone and before an opaque draw (after a clear or
 * not) over the same target. */
static void expect_nothing_lost_by(fixture *f, strata_program program,
                                   const strata_attachment *color, const strata_attachment *depth) {
    const strata_attachment *const after[] = {NULL, &opaque, &cleared};
    const strata_pass counting = {.struct_size = sizeof counting,
                                  .label = "count",
                                  .color = color,
                                  .color_count = color ? 1 : 0,
                                  .depth = depth};
    for (size_t i = 0; i < BASE_COUNT(after); i++) {
        const strata_pass covering = {.struct_size = sizeof covering,
                                      .label = "cover",
                                      .color = after[i],
                                      .color_count = 1,
                                      .depth = depth};
        clear_counts(f);
        draw(f, &counting, program);
        if (after[i])
            draw(f, &covering, f->plain);
        assert_int_equal(lost_writes(f), 0);
    }
}

static void expect_nothing_lost(fixture *f, const strata_attachment *color,
                                const strata_attachment *depth) {
    expect_nothing_lost_by(f, f->count, color, depth);
}

static void no_colour_attachment_loses_nothing(void **state) {
    expect_nothing_lost(fixture_of(state), NULL, NULL);
    expect_nothing_lost(fixture_of(state), NULL, &opaque);
}

static void blended_colour_loses_nothing(void **state) {
    expect_nothing_lost(fixture_of(state), &blended, NULL);
    expect_nothing_lost(fixture_of(state), &blended, &opaque);
}

static void masked_colour_loses_nothing(void **state) {
    expect_nothing_lost(fixture_of(state), &masked, NULL);
    expect_nothing_lost(fixture_of(state), &masked, &opaque);
}

/* Opaque for the API, but a driver cannot know what the shader makes of what it reads. */
static void colour_that_is_read_loses_nothing(void **state) {
    static const strata_attachment read = {.struct_size = sizeof read, .read = 1};
    fixture *f = fixture_of(state);
    if (!f->replace.id)
        skip();
    expect_nothing_lost_by(f, f->replace, &read, NULL);
    expect_nothing_lost_by(f, f->replace, &read, &opaque);
}

static void opaque_colour_is_refused(void **state) {
    fixture *f = fixture_of(state);
    const strata_attachment color = {.struct_size = sizeof color, .image = f->color};
    const strata_bind bind = {.struct_size = sizeof bind, .name = "Counts", .buffer = f->counts};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "opaque",
                              .program = f->count,
                              .binds = &bind,
                              .bind_count = 1,
                              .color = &color,
                              .color_count = 1};
    gpu_begin(f->g, SIZE, SIZE);
    gpu_pass(f->g, "test", &pass);
    assert_int_not_equal(gpu_submit(f->g, NULL), STRATA_OK);
    assert_int_equal(gpu_last_code(f->g), GPU_ERROR_OPAQUE_WRITES);
}

/* Not asserted: a driver that keeps these writes is welcome. */
static void what_the_refusal_protects_from(void **state) {
    fixture *f = fixture_of(state);
    const strata_pass pass = {
        .struct_size = sizeof pass, .label = "trap", .color = &opaque, .color_count = 1};
    clear_counts(f);
    draw(f, &pass, f->count);
    uint32_t lost = lost_writes(f);
    print_message("with an opaque colour this driver loses %u of %u writes\n", lost,
                  PIXELS * TRIANGLES);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_colour_attachment_loses_nothing),
        cmocka_unit_test(blended_colour_loses_nothing),
        cmocka_unit_test(masked_colour_loses_nothing),
        cmocka_unit_test(colour_that_is_read_loses_nothing),
        cmocka_unit_test(opaque_colour_is_refused),
        cmocka_unit_test(what_the_refusal_protects_from),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
