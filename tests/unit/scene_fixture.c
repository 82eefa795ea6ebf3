/* SPDX-License-Identifier: MIT
 *
 * See scene_fixture.h.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "unit/scene_fixture.h"

scene *load_glb(test_glb *g) {
    size_t size;
    unsigned char *file = test_glb_finish(g, &size);
    base_error err = {0};
    scene *s = NULL;
    strata_result result = scene_load_memory("test.glb", file, size, &s, &err);
    free(file);
    if (result != STRATA_OK)
        fail_msg("%s", err.text);
    assert_non_null(s);
    return s;
}

void add_square(test_glb *g) {
    static const float corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    test_glb_floats(g, "VEC3", 3, 4, corners);
}

void add_square_scene(test_glb *g, int mode, const char *attributes) {
    test_glb_json(g, "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}]");
    test_glb_json(g,
                  "\"meshes\":[{\"name\":\"square\",\"primitives\":[{\"mode\":%d,\"attributes\":"
                  "{\"POSITION\":0%s}}]}]",
                  mode, attributes);
}

void expect_floats(const float *actual, const float *expected, size_t count) {
    assert_non_null(actual);
    for (size_t i = 0; i < count; i++) {
        float scale = fmaxf(1.0f, fabsf(expected[i]));
        if (!(fabsf(actual[i] - expected[i]) <= 1e-6f * scale))
            fail_msg("[%zu] is %.9g, not %.9g", i, (double)actual[i], (double)expected[i]);
    }
}

void expect_indices(const scene_mesh *mesh, const uint32_t *expected, size_t count) {
    assert_int_equal(mesh->index_count, count);
    for (size_t i = 0; i < count; i++)
        assert_int_equal(mesh->indices[i], expected[i]);
}

void expect_warning(const scene *s, const char *part) {
    if (!part && s->warning_count)
        fail_msg("warned: %s", s->warnings[0]);
    for (uint32_t i = 0; i < s->warning_count; i++)
        if (strstr(s->warnings[i], part))
            return;
    if (part)
        fail_msg("no warning says '%s'; the first of %u: %s", part, s->warning_count,
                 s->warning_count ? s->warnings[0] : "");
}

void expect_refused(test_glb *g, const char *part) {
    size_t size;
    unsigned char *file = test_glb_finish(g, &size);
    base_error err = {0};
    scene *s = (scene *)&err;
    strata_result result = scene_load_memory("test.glb", file, size, &s, &err);
    free(file);
    assert_int_equal(result, STRATA_ERROR_BAD_FILE);
    assert_int_equal(err.result, STRATA_ERROR_BAD_FILE);
    assert_null(s);
    if (strncmp(err.text, "test.glb: ", 10) != 0 || !strstr(err.text, part))
        fail_msg("'%s' does not say '%s'", err.text, part);
}
