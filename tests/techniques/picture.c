/* SPDX-License-Identifier: MIT
 *
 * Renders for the tests of techniques. Instances are kept, so that devices are opened once.
 */
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "gpu/gpu_internal.h"
#include "render/render.h"

const test_scene picture_scenes[] = {
    {"scene:soup?small=3000&medium=150", 96, 96, 54},
    {"scene:glass", 80, 60, 117},
    {"scene:shells", 64, 64, 16},
    {"scene:particles?count=2000", 64, 64, 19},
    {"scene:stack?count=2", 48, 48, 2},
    {"scene:stack?count=100", 48, 48, 100},
    {"scene:city?count=300", 80, 60, 2},
    {"scene:hairball?strands=800", 64, 64, 18},
    {"scene:needles", 64, 64, 20},
    {"scene:layers?count=0", 16, 16, 0},
    {"scene:layers?count=1", 16, 16, 1},
    {"scene:layers?count=33", 17, 13, 33},
    {"scene:layers?count=65", 17, 13, 65},
    {"scene:layers?count=1500&where=pixel&width=16&height=16", 16, 16, 1500},
};
const size_t picture_scene_count = sizeof picture_scenes / sizeof *picture_scenes;

#define KEPT 8

static struct {
    const char *backend;
    strata *instance;
} kept[KEPT];

strata *picture_instance(const char *backend) {
    size_t at = 0;
    while (at < KEPT - 1 && kept[at].backend && strcmp(kept[at].backend, backend) != 0)
        ++at;
    if (kept[at].backend)
        return kept[at].instance;
    char name[16] = "";
    const char *fault = strchr(backend, ' ');
    strncat(name, backend, fault ? (size_t)(fault - backend) : sizeof name - 1);
    const strata_open_options options = {.struct_size = sizeof options,
                                         .backend = name,
                                         .check = 1,
                                         .inject = fault ? fault + 1 : NULL};
    strata_scene *sc = NULL;
    kept[at].backend = backend;
    if (strata_open(&options, &kept[at].instance) != STRATA_OK)
        return NULL;
    /* The device is opened by the first render. */
    const strata_render_options tiny = {.struct_size = sizeof tiny, .width = 4, .height = 4};
    const char *const none[] = {"count=0"};
    strata_result r = strata_scene_generate(kept[at].instance, "layers", none, 1, &sc);
    if (r == STRATA_OK)
        r = strata_render(kept[at].instance, sc, &tiny);
    if (r != STRATA_OK) {
        print_message("%s cannot be opened: %s\n", backend, strata_error(kept[at].instance));
        strata_close(kept[at].instance);
        kept[at].instance = NULL;
        return NULL;
    }
    strata_scene_close(sc);
    return kept[at].instance;
}

uint64_t picture_fact(const strata *instance, const char *id) {
    if (strcmp(id, "selftest.interlock") == 0 &&
        !gpu_fact(instance->gpu, "feature.fragment_interlock") &&
        !gpu_selftest(instance->gpu, "selftest.ordered_rmw")) /* whatever was injected */
        return 0;
    return gpu_fact(instance->gpu, id);
}

void picture_close(void) {
    for (size_t i = 0; i < KEPT; ++i)
        strata_close(kept[i].instance);
    memset(kept, 0, sizeof kept);
}

strata_scene *picture_scene(strata *instance, const char *path) {
    strata_scene *sc = NULL;
    if (strata_scene_load(instance, path, &sc) != STRATA_OK)
        fail_msg("%s: %s", path, strata_error(instance));
    return sc;
}

picture picture_render(strata_scene *sc, strata *instance, const way *w, uint32_t width,
                       uint32_t height) {
    picture p = {.width = width, .height = height};
    const size_t size = (size_t)width * height * 4 * sizeof(float);
    uint32_t count = 0;
    while (count < sizeof w->settings / sizeof *w->settings && w->settings[count])
        ++count;
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = width,
                                           .height = height,
                                           .use = w->use,
                                           .effects = w->effects,
                                           .settings = w->settings,
                                           .setting_count = count,
                                           .camera = w->camera,
                                           .bands = w->bands,
                                           .samples = w->samples,
                                           .filter = w->filter,
                                           .tolerance = w->tolerance,
                                           .shuffle = w->shuffle};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s %s: %s", w->backend ? w->backend : "", count ? w->settings[0] : "",
                 strata_error(instance));
    p.pixels = malloc(size);
    assert_non_null(p.pixels);
    assert_int_equal(strata_read(instance, STRATA_OUTPUT_COLOR, p.pixels, size), STRATA_OK);
    return p;
}

void picture_free(picture *p) {
    free(p->pixels);
    p->pixels = NULL;
}

void picture_same(const picture *a, const picture *b, const char *what) {
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    const size_t count = (size_t)a->width * a->height;
    size_t differing = 0, first = 0;
    for (size_t i = count; i-- > 0;)
        if (memcmp(a->pixels + 4 * i, b->pixels + 4 * i, 4 * sizeof(float)) != 0) {
            ++differing;
            first = i;
        }
    if (differing > 0) {
        const float *p = a->pixels + 4 * first, *q = b->pixels + 4 * first;
        fail_msg("%s: %zu of %zu pixels differ, first (%zu, %zu): %a %a %a %a and %a %a %a %a",
                 what, differing, count, first % a->width, first / a->width, (double)p[0],
                 (double)p[1], (double)p[2], (double)p[3], (double)q[0], (double)q[1], (double)q[2],
                 (double)q[3]);
    }
}

uint64_t picture_hash(const picture *p) {
    const unsigned char *bytes = (const unsigned char *)p->pixels;
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < (size_t)p->width * p->height * 4 * sizeof(float); ++i)
        hash = (hash ^ bytes[i]) * UINT64_C(1099511628211);
    return hash;
}
