/* SPDX-License-Identifier: MIT
 *
 * Which glMemoryBarrier bits the OpenGL backend makes of the core's barriers. Software rasterisers
 * hide a missing one, so the calls themselves are watched.
 */
#include "gpu/gl/gl_internal.h"
#include "gpu/gpu_internal.h"
#include "gpu/rig.h"

static PFNGLMEMORYBARRIERPROC real_barrier;
static GLbitfield seen;
static uint32_t calls;

static void APIENTRY watched_barrier(GLbitfield bits) {
    seen |= bits;
    calls++;
    real_barrier(bits);
}

typedef struct fixture {
    rig *r;
    strata_program write, read, sample, load, uniform;
    strata_buffer buffer, out;
    strata_image image;
} fixture;

static fixture all;

static int set_up(void **state) {
    all.r = rig_open("gl");
    *state = all.r ? &all : NULL;
    if (!all.r)
        return 0;
    gl *device = all.r->g->self;
    real_barrier = device->fn.MemoryBarrier;
    device->fn.MemoryBarrier = watched_barrier;
    return 0;
}

static int tear_down(void **state) {
    if (*state)
        rig_close(all.r);
    return 0;
}

#define COMPUTE "layout(local_size_x = 1) in;\n"
#define OUT     "layout(std430) writeonly buffer Out { vec4 result; };\n"

static fixture *fixture_of(void **state) {
    fixture *f = *state;
    if (!f)
        skip();
    rig_clear(f->r);
    f->buffer = rig_buffer(f->r, "buffer", 256, NULL);
    f->out = rig_buffer(f->r, "out", 256, NULL);
    f->image = rig_image(f->r, "image", STRATA_FORMAT_RGBA32F, 1, 1, 0);
    f->write = rig_program(f->r, STRATA_PROGRAM_COMPUTE,
                           COMPUTE "layout(std430) writeonly buffer Data { uvec4 data; };\n"
                                   "layout(rgba32f) writeonly uniform image2D picture;\n"
                                   "void main() {\n"
                                   "    data = uvec4(1);\n"
                                   "    imageStore(picture, ivec2(0), vec4(7));\n"
                                   "}\n");
    f->read = rig_program(f->r, STRATA_PROGRAM_COMPUTE,
                          COMPUTE OUT "layout(std430) readonly buffer Data { uvec4 data; };\n"
                                      "void main() { result = vec4(data); }\n");
    f->uniform = rig_program(f->r, STRATA_PROGRAM_COMPUTE,
                             COMPUTE OUT "layout(std140) uniform Data { uvec4 data; };\n"
                                         "void main() { result = vec4(data); }\n");
    f->sample = rig_program(f->r, STRATA_PROGRAM_COMPUTE,
                            COMPUTE OUT "uniform sampler2D picture;\n"
                                        "void main() { result = texelFetch(picture, ivec2(0), 0); }"
                                        "\n");
    f->load = rig_program(f->r, STRATA_PROGRAM_COMPUTE,
                          COMPUTE OUT "layout(rgba32f) readonly uniform image2D picture;\n"
                                      "void main() { result = imageLoad(picture, ivec2(0)); }\n");
    return f;
}

static void dispatch(fixture *f, strata_program program, const char *name) {
    const strata_bind binds[] = {strcmp(name, "picture") == 0 ? rig_bind_image(name, f->image)
                                                              : rig_bind_buffer(name, f->buffer),
                                 rig_bind_buffer("Out", f->out)};
    rig_pass(f->r,
             (strata_pass){.program = program, .groups = {1}, .binds = binds, .bind_count = 2});
}

static void write_both(fixture *f) {
    const strata_bind binds[] = {rig_bind_buffer("Data", f->buffer),
                                 rig_bind_image("picture", f->image)};
    rig_pass(f->r,
             (strata_pass){.program = f->write, .groups = {1}, .binds = binds, .bind_count = 2});
}

static void watch(void) {
    seen = 0;
    calls = 0;
}

static void what_shaders_wrote_is_made_visible(void **state) {
    fixture *f = fixture_of(state);
    const struct {
        strata_program program;
        const char *name;
        GLbitfield bit;
    } readers[] = {
        {f->read, "Data", GL_SHADER_STORAGE_BARRIER_BIT},
        {f->uniform, "Data", GL_UNIFORM_BARRIER_BIT},
        {f->sample, "picture", GL_TEXTURE_FETCH_BARRIER_BIT},
        {f->load, "picture", GL_SHADER_IMAGE_ACCESS_BARRIER_BIT},
    };
    for (size_t i = 0; i < BASE_COUNT(readers); i++) {
        gpu_begin(f->r->g, 1, 1);
        write_both(f);
        watch();
        dispatch(f, readers[i].program, readers[i].name);
        assert_int_equal(seen & readers[i].bit, readers[i].bit);
        watch();
        write_both(f); /* what was read is overwritten */
        assert_int_equal(seen, GL_SHADER_STORAGE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
        rig_submit(f->r);
    }
}

static void written_commands_and_copies(void **state) {
    fixture *f = fixture_of(state);
    const strata_bind binds[] = {rig_bind_buffer("Out", f->out),
                                 rig_bind_image("picture", f->image)};
    gpu_begin(f->r->g, 1, 1);
    write_both(f);
    watch();
    rig_pass(f->r, (strata_pass){
                       .program = f->load, .indirect = f->buffer, .binds = binds, .bind_count = 2});
    assert_true(seen & GL_COMMAND_BARRIER_BIT);
    write_both(f);
    watch();
    gpu_copy(f->r->g, "test", f->out, 0, f->buffer, 0, 16);
    assert_true(seen & GL_BUFFER_UPDATE_BARRIER_BIT);
    rig_submit(f->r);
    uint32_t found[4];
    rig_read(f->r, f->out, found, sizeof found);
    assert_int_equal(found[3], 1);
}

static void fills_and_targets_need_none(void **state) {
    fixture *f = fixture_of(state);
    strata_program paint = rig_program(f->r, STRATA_PROGRAM_FULLSCREEN,
                                       "layout(location = 0) out vec4 color;\n"
                                       "void main() { color = vec4(1); }\n");
    const strata_attachment color = {.struct_size = sizeof color, .image = f->image};
    const strata_pass pass = {.program = paint, .color = &color, .color_count = 1};
    gpu_begin(f->r->g, 1, 1);
    watch();
    gpu_fill(f->r->g, "test", f->buffer, 0, 0, 3);
    dispatch(f, f->uniform, "Data");
    rig_pass(f->r, pass);
    rig_pass(f->r, pass);
    assert_int_equal(calls, 0);
    dispatch(f, f->load, "picture"); /* a shader's own access to what was drawn does */
    assert_true(seen & GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    rig_submit(f->r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_shaders_wrote_is_made_visible),
        cmocka_unit_test(written_commands_and_copies),
        cmocka_unit_test(fills_and_targets_need_none),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
