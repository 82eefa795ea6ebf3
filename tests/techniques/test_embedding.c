/* SPDX-License-Identifier: MIT
 *
 * strata/host.h and strata/frame.h held to their words: what an embedding program may keep, may not
 * mix, and finds after failures; that pools of opaque techniques are verified like all others.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/gpu_internal.h"
#include "render/render.h"

enum { WIDTH = 16, HEIGHT = 8 };

static strata *open_on(const char *backend) {
    const strata_open_options options = {.struct_size = sizeof options, .backend = backend};
    strata *s = NULL;
    assert_int_equal(strata_open(&options, &s), STRATA_OK);
    return s;
}

static strata *open_null(void) {
    return open_on("null");
}

static strata_scene *layers(strata *s) {
    strata_scene *sc = NULL;
    assert_int_equal(strata_scene_load(s, "scene:layers?count=3", &sc), STRATA_OK);
    return sc;
}

static const strata_render_options small = {
    .struct_size = sizeof small, .width = WIDTH, .height = HEIGHT};

static strata_result ignore(void *user, const char *text, size_t length) {
    (void)user, (void)text, (void)length;
    return STRATA_OK;
}

/* "The image stays with the instance until the next render." */
static void the_image_outlives_its_scene(void **state) {
    static float pixels[HEIGHT * WIDTH * 4];
    uint32_t width = 0, height = 0;
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    assert_int_equal(strata_render(s, sc, &small), STRATA_OK);
    strata_scene_close(sc);
    assert_int_equal(strata_size(s, &width, &height), STRATA_OK);
    assert_int_equal(width, WIDTH);
    assert_int_equal(height, HEIGHT);
    assert_int_equal(strata_read(s, STRATA_OUTPUT_COLOR, pixels, sizeof pixels), STRATA_OK);
    assert_int_equal(strata_account(s, ignore, NULL), STRATA_ERROR_INVALID_STATE);
    assert_non_null(strstr(strata_error(s), "closed"));
    strata_close(s);
}

static void a_scene_of_another_instance_is_refused(void **state) {
    (void)state;
    strata *s = open_null(), *other = open_null();
    strata_scene *sc = layers(other);
    assert_int_equal(strata_render(s, sc, &small), STRATA_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(strata_error(s), "another instance"));
    assert_int_equal(strata_plan(s, sc, &small, ignore, NULL), STRATA_ERROR_INVALID_ARGUMENT);
    assert_int_equal(strata_render(other, sc, &small), STRATA_OK);
    strata_close(other);
    strata_close(s);
}

/* Options of a later version: their unknown end must be zero, and is then no matter. */
static void unknown_options_are_refused(void **state) {
    struct {
        strata_open_options known;
        uint64_t later;
    } open = {.known = {.struct_size = sizeof open, .backend = "null"}, .later = 1};
    struct {
        strata_render_options known;
        uint64_t later;
    } render = {.known = small, .later = 1};
    strata *s = NULL;
    (void)state;
    render.known.struct_size = sizeof render;
    assert_int_equal(strata_open(&open.known, &s), STRATA_ERROR_INVALID_ARGUMENT);
    assert_null(s);
    assert_non_null(strstr(strata_error(NULL), "strata_open"));
    open.later = 0;
    assert_int_equal(strata_open(&open.known, &s), STRATA_OK);
    strata_scene *sc = layers(s);
    assert_int_equal(strata_render(s, sc, &render.known), STRATA_ERROR_INVALID_ARGUMENT);
    render.later = 0;
    assert_int_equal(strata_render(s, sc, &render.known), STRATA_OK);
    strata_close(s);
}

/* However often the device is lost, from one render to the next it is replaced. */
static void every_render_may_lose_the_device(void **state) {
    (void)state;
    strata *s = open_null();
    strata_scene *sc = layers(s);
    for (int i = 0; i < 4; ++i) {
        if (strata_render(s, sc, &small) != STRATA_OK)
            fail_msg("render %d: %s", i, strata_error(s));
        assert_int_equal(s->result.warning_count, i > 0);
        s->gpu->lost = 1;
    }
    assert_int_equal(s->exclusion_count, 0);
    strata_close(s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_image_outlives_its_scene),
        cmocka_unit_test(a_scene_of_another_instance_is_refused),
        cmocka_unit_test(unknown_options_are_refused),
        cmocka_unit_test(every_render_may_lose_the_device),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
