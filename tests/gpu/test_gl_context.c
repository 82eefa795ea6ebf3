/* SPDX-License-Identifier: MIT
 *
 * The OpenGL backend beside other users of EGL in the same process: whatever was current stays
 * current, instances do not disturb each other, devices are chosen by index and name, and what the
 * driver complains about fails the frame in the driver's words.
 */
#include "gpu/gl/gl_internal.h"
#include "gpu/gpu_internal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define COUNT 256u

static const strata_glsl double_source = {
    .text = "layout(local_size_x = 64) in;\n"
            "STRATA_PARAMS { uint factor; } params;\n"
            "layout(std430) buffer Values { uint values[]; };\n"
            "void main() { values[gl_GlobalInvocationID.x] *= params.factor; }\n",
    .path = "double.glsl"};

typedef struct instance {
    gpu *g;
    gpu_scope *scope;
    strata_program program;
    strata_buffer values;
    uint32_t expected;
} instance;

static int available;

static int probe(void **state) {
    const gpu_open_info info = {.backend = "gl"};
    base_error err = {0};
    gpu *g = NULL;
    (void)state;
    available = gpu_open(&info, &g, &err) == STRATA_OK;
    if (!available)
        print_message("no OpenGL here: %s\n", err.text);
    gpu_close(g);
    return 0;
}

static void need_device(void) {
    if (!available)
        skip();
}

static instance instance_open(void) {
    const gpu_open_info info = {.backend = "gl", .check = 1, .profile = 1};
    const strata_program_desc program = {.struct_size = sizeof program,
                                         .kind = STRATA_PROGRAM_COMPUTE,
                                         .label = "double",
                                         .source = &double_source};
    uint32_t ones[COUNT];
    const strata_buffer_desc buffer = {
        .struct_size = sizeof buffer, .label = "values", .size = sizeof ones, .data = ones};
    base_error err = {0};
    instance out = {.expected = 1};
    for (uint32_t i = 0; i < COUNT; i++)
        ones[i] = 1;
    if (gpu_open(&info, &out.g, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    out.scope = gpu_scope_create(out.g, "test");
    if (gpu_program_create(out.scope, &program, &out.program, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    assert_int_equal(gpu_buffer_create(out.scope, &buffer, &out.values, &err), STRATA_OK);
    return out;
}

static void multiply(instance *in, uint32_t factor) {
    const strata_bind bind = {.struct_size = sizeof bind, .name = "Values", .buffer = in->values};
    const strata_pass pass = {.struct_size = sizeof pass,
                              .label = "multiply",
                              .groups = {COUNT / 64},
                              .program = in->program,
                              .params = &factor,
                              .params_size = sizeof factor,
                              .binds = &bind,
                              .bind_count = 1};
    gpu_pass(in->g, "test", &pass);
    in->expected *= factor;
}

static void expect_values(instance *in) {
    uint32_t values[COUNT];
    assert_int_equal(gpu_buffer_read(in->g, in->values, 0, sizeof values, values, NULL), STRATA_OK);
    for (uint32_t i = 0; i < COUNT; i++)
        assert_int_equal(values[i], in->expected);
}

static void frame(instance *in, uint32_t factor) {
    base_error err = {0};
    gpu_begin(in->g, 16, 16);
    multiply(in, factor);
    if (gpu_submit(in->g, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    expect_values(in);
}

/* ---- what the embedding program has current ---------------------------------------------------
 */
static void nothing_current_stays_so(void **state) {
    (void)state;
    need_device();
    instance in = instance_open();
    assert_ptr_equal(eglGetCurrentContext(), EGL_NO_CONTEXT);
    frame(&in, 3);
    assert_ptr_equal(eglGetCurrentContext(), EGL_NO_CONTEXT);
    gpu_close(in.g);
    assert_ptr_equal(eglGetCurrentContext(), EGL_NO_CONTEXT);
}

static void embedders_context_stays_current(void **state) {
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    EGLDisplay displays[GPU_GL_MAX_DEVICES];
    (void)state;
    need_device();
    assert_true(gl_displays(displays) > 0);
    assert_true(eglBindAPI(EGL_OPENGL_ES_API));
    EGLContext context =
        eglCreateContext(displays[0], EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    if (context == EGL_NO_CONTEXT)
        skip();
    assert_true(eglMakeCurrent(displays[0], EGL_NO_SURFACE, EGL_NO_SURFACE, context));
    instance in = instance_open();
    assert_ptr_equal(eglGetCurrentContext(), context);
    frame(&in, 5);
    assert_ptr_equal(eglGetCurrentContext(), context);
    gpu_begin(in.g, 16, 16);
    multiply(&in, 2);
    gpu_close(in.g); /* in the middle of a frame */
    assert_ptr_equal(eglGetCurrentContext(), context);
    assert_int_equal(eglQueryAPI(), EGL_OPENGL_ES_API);
    eglMakeCurrent(displays[0], EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(displays[0], context);
    eglBindAPI(EGL_OPENGL_API);
}

static void instances_are_apart(void **state) {
    (void)state;
    need_device();
    instance a = instance_open(), b = instance_open();
    for (uint32_t i = 0; i < 3; i++) {
        frame(&a, 3);
        frame(&b, 2);
    }
    gpu_close(a.g);
    frame(&b, 7);
    gpu_close(b.g);
}

/* ---- recording --------------------------------------------------------------------------------
 */

/* More parameter blocks in one submission than their buffer holds. */
static void parameters_outlast_their_buffer(void **state) {
    (void)state;
    need_device();
    instance in = instance_open();
    gpu_begin(in.g, 16, 16);
    for (uint32_t i = 0; i < 70000; i++)
        multiply(&in, i % 2 ? 3u : 2863311531u); /* 3 * 2863311531 = 1 modulo 2^32 */
    base_error err = {0};
    if (gpu_submit(in.g, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    assert_int_equal(in.expected, 1);
    expect_values(&in);
    gpu_close(in.g);
}

static void passes_are_timed(void **state) {
    uint32_t count = 0;
    (void)state;
    need_device();
    instance in = instance_open();
    frame(&in, 3);
    const gpu_timing *timings = gpu_timings(in.g, &count);
    assert_int_equal(count, 1);
    assert_string_equal(timings[0].label, "multiply");
    assert_true(timings[0].gpu_ms > 0 && timings[0].gpu_ms < 10000);
    gpu_close(in.g);
}

static void driver_complaints_fail_the_frame(void **state) {
    (void)state;
    need_device();
    instance in = instance_open();
    gl *device = in.g->self;
    gpu_begin(in.g, 16, 16);
    multiply(&in, 2);
    device->where = "the wrong pass";
    device->fn.Enable(0x1234); /* no such capability */
    base_error err = {0};
    assert_int_equal(gpu_submit(in.g, &err), STRATA_ERROR_INTERNAL);
    assert_non_null(strstr(err.text, "the wrong pass"));
    assert_non_null(strstr(err.text, "GL_INVALID_ENUM"));
    device->where = NULL;
    expect_values(&in); /* and only that frame */
    frame(&in, 2);
    gpu_close(in.g);
}

/* What recording did wrong is not hidden by a creation in between. */
static void complaints_survive_creation(void **state) {
    const strata_buffer_desc desc = {.struct_size = sizeof desc, .label = "late", .size = 64};
    strata_buffer late;
    (void)state;
    need_device();
    instance in = instance_open();
    gl *device = in.g->self;
    gpu_begin(in.g, 16, 16);
    multiply(&in, 2);
    device->fn.Enable(0x1234);
    assert_int_equal(gpu_buffer_create(in.scope, &desc, &late, NULL), STRATA_OK);
    assert_int_equal(gpu_submit(in.g, NULL), STRATA_ERROR_INTERNAL);
    gpu_close(in.g);
}

/* ---- devices ----------------------------------------------------------------------------------
 */
static void device_found(void *user, const gpu_device_info *info, uint32_t index) {
    gpu_device_info *first = user;
    if (strcmp(info->backend, "gl") == 0 && index == 0)
        *first = *info;
}

static void devices_have_index_and_name(void **state) {
    gpu_device_info first = {0}, opened;
    gpu_open_info info = {.backend = "gl"};
    base_error err = {0};
    gpu *g = NULL;
    (void)state;
    need_device();
    gpu_backend_gl.enumerate(device_found, &first);
    assert_string_not_equal(first.name, "");
    const char *const wanted[] = {"0", first.name};
    for (size_t i = 0; i < BASE_COUNT(wanted); i++) {
        info.device = wanted[i];
        assert_int_equal(gpu_open(&info, &g, &err), STRATA_OK);
        gpu_describe(g, &opened);
        assert_string_equal(opened.name, first.name);
        assert_string_equal(opened.driver, first.driver);
        gpu_close(g);
    }
    info.device = "no such device";
    assert_int_equal(gpu_open(&info, &g, &err), STRATA_ERROR_UNSUPPORTED);
    assert_non_null(strstr(err.text, "no such device"));
    assert_null(g);
    assert_ptr_equal(eglGetCurrentContext(), EGL_NO_CONTEXT);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_current_stays_so),
        cmocka_unit_test(embedders_context_stays_current),
        cmocka_unit_test(instances_are_apart),
        cmocka_unit_test(parameters_outlast_their_buffer),
        cmocka_unit_test(passes_are_timed),
        cmocka_unit_test(driver_complaints_fail_the_frame),
        cmocka_unit_test(complaints_survive_creation),
        cmocka_unit_test(devices_have_index_and_name),
    };
    return cmocka_run_group_tests(tests, probe, NULL);
}
