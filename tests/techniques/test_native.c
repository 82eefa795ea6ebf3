/* SPDX-License-Identifier: MIT
 *
 * The native extensions as a module sees them: on the backend of each the module's own OpenGL or
 * Vulkan calls give the same picture as the host's, with the driver's validation silent; elsewhere
 * the extension is absent; misuse fails the render in one line that names technique and pass.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"

enum { WIDTH = 24, HEIGHT = 16 };

static char *module_path;

static int open_path(void **state) {
    const char *build = getenv("STRATA_TEST_BUILD"), *installed = getenv("STRATA_MODULE_PATH");
    (void)state;
    module_path =
        base_format("%s:%s/tests/modules/native", installed ? installed : "", build ? build : ".");
    return module_path ? 0 : -1;
}

static int close_path(void **state) {
    (void)state;
    free(module_path);
    return 0;
}

/* Renders a scene that calls for transparency with the test technique and these settings. */
static strata_result render(const char *backend, const char *path, const char *fault,
                            uint32_t bands, strata **out) {
    const strata_open_options open = {
        .struct_size = sizeof open, .backend = backend, .module_path = module_path, .check = 1};
    const char *const settings[] = {path, fault};
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = WIDTH,
                                           .height = HEIGHT,
                                           .use = "native",
                                           .settings = settings,
                                           .setting_count = 2,
                                           .bands = bands};
    strata_scene *sc = NULL;
    assert_int_equal(strata_open(&open, out), STRATA_OK);
    if (strata_scene_load(*out, "scene:layers?count=3", &sc) != STRATA_OK)
        fail_msg("%s", strata_error(*out));
    return strata_render(*out, sc, &options);
}

static int available(const char *backend) {
    gpu *g = NULL;
    base_error err = {0};
    if (gpu_open(&(gpu_open_info){.backend = backend}, &g, &err) != STRATA_OK) {
        print_message("%s: %s\n", backend, err.text);
        return 0;
    }
    gpu_close(g);
    return 1;
}

/* A pixel as the module's shaders make it: the source's float in the first half, then 0.25. */
static void check_pixels(strata *instance, float pool) {
    static float pixels[HEIGHT][WIDTH][4];
    assert_int_equal(strata_read(instance, STRATA_OUTPUT_COLOR, &pixels[0][0][0], sizeof pixels),
                     STRATA_OK);
    for (uint32_t y = 0; y < HEIGHT; ++y)
        for (uint32_t x = 0; x < WIDTH; ++x) {
            const float *p = pixels[HEIGHT - 1 - y][x];
            const uint32_t i = y * WIDTH + x;
            const float value =
                i < WIDTH * HEIGHT / 2 ? (float)(i * 7919u % 4096u) / 4096.0f : 0.25f;
            if (p[0] != value || (pool >= 0 && p[1] != pool) || p[2] != (float)i || p[3] != 1)
                fail_msg("(%u, %u): %g %g %g %g, not %g", x, y, (double)p[0], (double)p[1],
                         (double)p[2], (double)p[3], (double)value);
        }
}

static int has_pass(const strata *instance, const char *label) {
    for (uint32_t i = 0; i < instance->result.pass_count; ++i)
        if (strcmp(instance->result.passes[i].label, label) == 0)
            return 1;
    return 0;
}

static void native_calls_make_the_picture(const char *backend) {
    if (!available(backend))
        skip();
    for (uint32_t bands = 1; bands <= 3; bands += 2)
        for (int portable = 0; portable < 2; ++portable) {
            strata *instance = NULL;
            if (render(backend, portable ? "native.path=portable" : "native.path=native",
                       "native.fault=none", bands, &instance) != STRATA_OK)
                fail_msg("%s: %s", backend, strata_error(instance));
            check_pixels(instance, portable ? -1.0f : 3.0f);
            assert_true(has_pass(instance, "consume"));
            assert_int_equal(has_pass(instance, "transfer"), !portable);
            strata_close(instance);
        }
}

static void on_vulkan(void **state) {
    (void)state;
    native_calls_make_the_picture("vulkan");
}

static void on_gl(void **state) {
    (void)state;
    native_calls_make_the_picture("gl");
}

/* Without an API there is no extension, and the module goes its portable way. */
static void absent_on_null(void **state) {
    strata *instance = NULL;
    (void)state;
    if (render("null", "native.path=native", "native.fault=none", 1, &instance) != STRATA_OK)
        fail_msg("%s", strata_error(instance));
    const char *log = gpu_null_log(instance->gpu);
    assert_non_null(strstr(log, "pass consume"));
    assert_non_null(strstr(log, "copy source"));
    assert_null(strstr(log, " native"));
    assert_null(render_extension(instance->gpu, "strata.gl/1"));
    assert_null(render_extension(instance->gpu, "strata.vulkan/1"));
    strata_close(instance);
}

static void misuse_is_named(const char *backend) {
    const struct {
        const char *fault, *says;
        strata_result result;
    } cases[] = {
        {"native.fault=prepare", "outside record()", STRATA_ERROR_INVALID_STATE},
        {"native.fault=label", "a pass needs a label", STRATA_ERROR_INVALID_ARGUMENT},
        {"native.fault=callback", "no callback", STRATA_ERROR_INVALID_ARGUMENT},
        {"native.fault=call", strcmp(backend, "gl") ? "validation" : "transfer",
         STRATA_ERROR_INTERNAL},
    };
    if (!available(backend))
        skip();
    for (size_t i = 0; i < BASE_COUNT(cases); ++i) {
        strata *instance = NULL;
        strata_result r = render(backend, "native.path=native", cases[i].fault, 1, &instance);
        if (r != cases[i].result || !strstr(strata_error(instance), cases[i].says))
            fail_msg("%s %s: %d, %s", backend, cases[i].fault, (int)r, strata_error(instance));
        strata_close(instance);
    }
}

static void misuse_on_vulkan(void **state) {
    (void)state;
    misuse_is_named("vulkan");
}

static void misuse_on_gl(void **state) {
    (void)state;
    misuse_is_named("gl");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(on_vulkan),      cmocka_unit_test(on_gl),
        cmocka_unit_test(absent_on_null), cmocka_unit_test(misuse_on_vulkan),
        cmocka_unit_test(misuse_on_gl),
    };
    return cmocka_run_group_tests(tests, open_path, close_path);
}
