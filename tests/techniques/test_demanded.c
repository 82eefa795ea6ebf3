/* SPDX-License-Identifier: MIT
 *
 * Only what a scene calls for is there: an opaque scene opens no transparency module and allocates
 * nothing for it; plain transparency stores no transmission payload. Asserted on the null backend's
 * log and on the account of every backend.
 */
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"

static const char *const backends[] = {"null", "vulkan", "gl"};

static strata *rendered(const char *backend, const char *path, const char *use) {
    strata *instance = NULL;
    strata_scene *sc = NULL;
    const strata_open_options open = {.struct_size = sizeof open, .backend = backend};
    const strata_render_options options = {
        .struct_size = sizeof options, .width = 64, .height = 48, .use = use};
    assert_int_equal(strata_open(&open, &instance), STRATA_OK);
    if (strata_scene_load(instance, path, &sc) != STRATA_OK)
        fail_msg("%s: %s", path, strata_error(instance));
    if (strata_render(instance, sc, &options) != STRATA_OK) {
        print_message("%s: %s\n", backend, strata_error(instance));
        strata_close(instance);
        return NULL;
    }
    return instance;
}

static json_t *account(strata *instance) {
    json_t *object = render_account_json(instance);
    assert_non_null(object);
    return object;
}

static int lists(json_t *array, const char *id) {
    size_t i;
    json_t *entry;
    json_array_foreach(array, i, entry) {
        if (strcmp(json_string_value(entry), id) == 0)
            return 1;
    }
    return 0;
}

static void an_opaque_scene_pays_nothing(void **state) {
    static const char *const transparent[] = {"abuffer", "ppc", "over", "transmission"};
    (void)state;
    for (size_t b = 0; b < 3; ++b) {
        strata *instance = rendered(backends[b], "scene:city?count=200&glass=0", NULL);
        if (!instance)
            continue;
        json_t *object = account(instance);
        json_t *opened = json_object_get(object, "modules_opened"),
               *bytes = json_object_get(object, "bytes");
        assert_true(lists(opened, "surface"));
        for (size_t i = 0; i < 4; ++i) {
            assert_false(lists(opened, transparent[i]));
            assert_null(json_object_get(bytes, transparent[i]));
            assert_int_equal(gpu_bytes_peak(instance->gpu, transparent[i]), 0);
        }
        const char *log = gpu_null_log(instance->gpu);
        if (log) {
            assert_non_null(strstr(log, "color/1"));
            assert_null(strstr(log, "fragments"));
            assert_null(strstr(log, "ranges"));
            assert_null(strstr(log, "resolve"));
        }
        json_decref(object);
        strata_close(instance);
    }
}

static void plain_transparency_stores_no_transmission(void **state) {
    (void)state;
    for (size_t b = 0; b < 3; ++b) {
        strata *instance = rendered(backends[b], "scene:soup?small=300&medium=20", "abuffer,ppc");
        if (!instance)
            continue;
        json_t *object = account(instance);
        assert_true(lists(json_object_get(object, "modules_opened"), "over"));
        assert_false(lists(json_object_get(object, "modules_opened"), "transmission"));
        const plan *p = instance->session->plan;
        assert_int_equal(p->transmittance_channels, 1);
        assert_int_equal(p->payload.words, 4);
        assert_int_equal(p->bytes_per_fragment, 24);
        const char *log = gpu_null_log(instance->gpu);
        if (log) {
            assert_non_null(strstr(log, "StrataPayload1"));
            assert_null(strstr(log, "StrataPayload2"));
        }
        json_decref(object);
        strata_close(instance);
    }
}

static void several_effects_store_their_union(void **state) {
    (void)state;
    strata *instance = rendered("null", "scene:glass", NULL);
    assert_non_null(instance);
    const plan *p = instance->session->plan;
    assert_int_equal(p->active_effects, 2);
    assert_int_equal(p->transmittance_channels, 3);
    assert_int_equal(p->payload.words, 11); /* color 4, glow 3, through 3, id 1 */
    strata_close(instance);
}

/* Exactly as many records as fragments, and at most 16 bytes a pixel beside them. */
static void memory_is_what_the_formula_says(void **state) {
    static const struct {
        const char *setting;
        uint64_t bytes;
    } cases[] = {{"abuffer.payload=float", 24},
                 {"abuffer.payload=half", 16},
                 {"abuffer.payload=unorm8", 12},
                 {"abuffer.mode=linked", 32}};
    (void)state;
    for (size_t b = 1; b < 3; ++b)
        for (size_t i = 0; i < 4; ++i) {
            strata *instance = NULL;
            strata_scene *sc = NULL;
            const strata_open_options open = {.struct_size = sizeof open, .backend = backends[b]};
            const strata_render_options options = {.struct_size = sizeof options,
                                                   .width = 256,
                                                   .height = 256,
                                                   .use = "abuffer,ppc",
                                                   .settings = &cases[i].setting,
                                                   .setting_count = 1};
            assert_int_equal(strata_open(&open, &instance), STRATA_OK);
            assert_int_equal(strata_scene_load(instance, "scene:soup?small=9000&medium=450", &sc),
                             STRATA_OK);
            if (strata_render(instance, sc, &options) == STRATA_OK) {
                const uint64_t fragments = instance->result.report.total,
                               used = gpu_bytes(instance->gpu, "abuffer") +
                                      gpu_bytes(instance->gpu, "ppc");
                assert_true(fragments > 100000);
                /* and what does not grow: counters, tables, pools that start at their minimum */
                assert_true(used <= cases[i].bytes * (fragments + 256) + 16 * 256 * 256 + 131072);
            }
            strata_close(instance);
        }
}

/* What a storage range cannot hold is held band by band, whatever the technique. */
static void large_images_are_split(void **state) {
    static const struct {
        const char *use, *setting;
    } ways[] = {
        {"abuffer,ppc", "abuffer.mode=contiguous"},
        {"abuffer,ppc", "abuffer.mode=linked"},
        {"abuffer,fpc", "fpc.mode=fragments"},
        {"kplus,ppc", "kplus.memory=exact"},
        {"kplus,ppc", "kplus.exclusion=lock"},
        {"occupancy,kplus,ppc", "kplus.k=8"},
        {"stencil,ppc", "stencil.payload=float"},
        {"peel", "peel.mode=front_to_back"},
        {"peel", "peel.mode=dual"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof ways / sizeof *ways; ++i) {
        strata *instance = NULL;
        strata_scene *sc = NULL;
        const strata_open_options open = {.struct_size = sizeof open, .backend = "null"};
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = 5000,
                                               .height = 4000,
                                               .use = ways[i].use,
                                               .settings = &ways[i].setting,
                                               .setting_count = 1};
        assert_int_equal(strata_open(&open, &instance), STRATA_OK);
        assert_int_equal(strata_scene_load(instance, "scene:shells", &sc), STRATA_OK);
        if (strata_render(instance, sc, &options) != STRATA_OK)
            fail_msg("%s %s: %s", ways[i].use, ways[i].setting, strata_error(instance));
        assert_true(instance->result.bands > 1); /* 8 bytes a pixel are too much for 128 MiB */
        strata_close(instance);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_opaque_scene_pays_nothing),
        cmocka_unit_test(plain_transparency_stores_no_transmission),
        cmocka_unit_test(several_effects_store_their_union),
        cmocka_unit_test(memory_is_what_the_formula_says),
        cmocka_unit_test(large_images_are_split),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
