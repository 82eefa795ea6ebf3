/* SPDX-License-Identifier: MIT
 *
 * Techniques agree: every way that promises all fragments in their exact order gives the bits of
 * abuffer and ppc at the same payload, on every scene and both backends. They share no code but the
 * effects and the fold, so this is the strongest test of each. `test_agree SCENE` takes those of
 * this name, with * and ?.
 */
#include "named.h"
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct exact_way {
    way way;
    uint32_t depth; /* the most fragments in one pixel that it holds; 0 = memory alone limits */
    const char *payload; /* of the reference; NULL: float */
    const char *fact;    /* of the device, without which it does not run; NULL: runs anywhere */
} exact_way;

/* A technique's own test holds its edge cases; here stands one row for each of its paths. */
static const exact_way ways[] = {
    {.way = {.use = "abuffer,ppc", .settings = {"abuffer.mode=contiguous"}, .shuffle = 3}},
    {.way = {.use = "abuffer,ppc", .settings = {"abuffer.mode=linked"}, .shuffle = 3}},
    {.way = {.use = "abuffer,ppc", .settings = {"abuffer.mode=linked", "abuffer.payload=half"}},
     .payload = "half"},
    {.way = {.use = "abuffer,ppc", .settings = {"abuffer.mode=linked", "abuffer.payload=unorm8"}},
     .payload = "unorm8"},
    {{.use = "kplus,ppc", .settings = {"kplus.k=16"}, .shuffle = 3}, .depth = 16},
    {{.use = "kplus,ppc", .settings = {"kplus.k=64", "kplus.memory=exact"}}, .depth = 64},
    {{.use = "kplus,ppc", .settings = {"kplus.k=16", "kplus.exclusion=ordered"}, .shuffle = 3},
     .depth = 16,
     .fact = "ordered_attachments"},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=2", "kplus.exclusion=ordered", "kplus.memory=exact"}},
     .depth = 2,
     .fact = "ordered_attachments"},
    {{.use = "kplus,ppc", .settings = {"kplus.k=16", "kplus.exclusion=lock"}}, .depth = 16},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=128", "kplus.exclusion=lock", "kplus.memory=exact"},
      .shuffle = 7},
     .depth = 128},
    {{.use = "kplus,ppc", .settings = {"kplus.k=64", "kplus.exclusion=lock", "kplus.tries=0"}},
     .depth = 64},
    {{.use = "kplus,ppc", .settings = {"kplus.k=64", "kplus.exclusion=atomic32"}, .shuffle = 5},
     .depth = 64},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=128", "kplus.exclusion=atomic32", "kplus.memory=exact"},
      .bands = 3},
     .depth = 128},
    {{.use = "kplus,ppc", .settings = {"kplus.k=64", "kplus.exclusion=atomic64"}, .shuffle = 5},
     .depth = 64,
     .fact = "feature.int64_atomics"},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=128", "kplus.exclusion=atomic64", "kplus.memory=exact"}},
     .depth = 128,
     .fact = "feature.int64_atomics"},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=16", "kplus.exclusion=unlocked", "kplus.structure=heap"}},
     .depth = 16,
     .fact = "selftest.ordered_rmw"},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=64", "kplus.exclusion=interlock", "kplus.structure=array"},
      .shuffle = 3},
     .depth = 64,
     .fact = "selftest.interlock"},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=128", "kplus.exclusion=interlock", "kplus.memory=exact"}},
     .depth = 128,
     .fact = "selftest.interlock"},
    {{.use = "kplus,ppc",
      .settings = {"kplus.k=128", "kplus.exclusion=unlocked", "kplus.structure=array",
                   "kplus.payload=half"}},
     .depth = 128,
     .payload = "half",
     .fact = "selftest.ordered_rmw"},
    {{.use = "kplus,ppc", .settings = {"kplus.k=0", "kplus.payload=unorm8"}, .bands = 5},
     .payload = "unorm8"},
    {.way = {.use = "occupancy,kplus,ppc", .settings = {"kplus.k=64"}, .shuffle = 3}, .depth = 64},
    {.way = {.use = "occupancy,kplus,ppc",
             .settings = {"kplus.k=128", "kplus.memory=exact", "occupancy.buckets=1024"},
             .bands = 3},
     .depth = 128},
    /* one chunk is folded like any other pixel */
    {.way = {.use = "abuffer,fpc"}, .depth = 64},
    {.way = {.use = "abuffer,fpc", .settings = {"fpc.mode=fragments"}}, .depth = 64},
    {.way = {.use = "abuffer,fpc",
             .settings = {"fpc.mode=fragments", "abuffer.mode=linked"},
             .shuffle = 3},
     .depth = 64},
    {.way = {.use = "stencil,ppc", .shuffle = 3}, .depth = 254},
    {.way = {.use = "stencil,ppc", .settings = {"stencil.routing=layers"}, .bands = 3},
     .depth = 254},
    {.way = {.use = "stencil,ppc", .settings = {"stencil.routing=samples"}, .shuffle = 3},
     .depth = 254,
     .fact = "selftest.sample_routing"},
    {.way = {.use = "stencil,ppc", .settings = {"stencil.payload=half"}},
     .depth = 254,
     .payload = "half"},
    {.way = {.use = "stencil,ppc", .settings = {"stencil.payload=unorm8"}},
     .depth = 254,
     .payload = "unorm8"},
    {.way = {.use = "peel"}},
    {.way = {.use = "peel", .bands = 5, .shuffle = 3}},
    {.way = {.use = "peel", .settings = {"peel.payload=half"}}, .payload = "half"},
    {.way = {.use = "peel", .settings = {"peel.payload=unorm8"}}, .payload = "unorm8"},
};

static const char *const payloads[] = {"float", "half", "unorm8"};

static size_t payload_index(const exact_way *w) {
    size_t i = 0;
    while (w->payload && strcmp(payloads[i], w->payload) != 0)
        ++i;
    return i;
}

static void describe(const exact_way *w, const char *backend, const char *scene, char text[512]) {
    int length = snprintf(text, 512, "%s on %s, %s", scene, backend, w->way.use);
    for (size_t i = 0; w->way.settings[i] && length < 500; ++i)
        length += snprintf(text + length, 512 - (size_t)length, " %s", w->way.settings[i]);
}

/* The first ways on one backend against the references, which the first backend renders. */
static void compare_ways(const test_scene *scene, const char *backend, size_t count,
                         picture references[3]) {
    strata *instance = picture_instance(backend);
    if (!instance)
        return;
    strata_scene *sc = picture_scene(instance, scene->path);
    for (size_t p = 0; p < 3; ++p) {
        char setting[64];
        snprintf(setting, sizeof setting, "abuffer.payload=%s", payloads[p]);
        const way reference = {.backend = backend, .use = "abuffer,ppc", .settings = {setting}};
        if (!references[p].pixels)
            references[p] = picture_render(sc, instance, &reference, scene->width, scene->height);
    }
    for (size_t i = 0; i < count; ++i) {
        if (ways[i].depth > 0 && scene->depth > ways[i].depth)
            continue;
        if (ways[i].fact && !picture_fact(instance, ways[i].fact))
            continue;
        char what[512];
        way w = ways[i].way;
        w.backend = backend;
        describe(&ways[i], backend, scene->path, what);
        picture p = picture_render(sc, instance, &w, scene->width, scene->height);
        picture_same(&references[payload_index(&ways[i])], &p, what);
        picture_free(&p);
    }
    strata_scene_close(sc);
}

static void exact_ways_agree(void **state) {
    const test_scene *scene = *state;
    picture references[3] = {{0}};
    const size_t count = sizeof ways / sizeof *ways;
    compare_ways(scene, "vulkan claims:selftest.interlock", count, references);
    compare_ways(scene, "gl claims:selftest.interlock", count, references);
    /* As devices compile that read no buffers as texels and hand no uniforms on as flat inputs. */
    compare_ways(scene, "gl claims:selftest.interlock,lacks:device.software",
                 scene == picture_scenes ? count : 1, references);
    if (!references[0].pixels)
        skip();
    for (size_t p = 0; p < 3; ++p)
        picture_free(&references[p]);
}

int main(int argc, char **argv) {
    struct CMUnitTest tests[32];
    for (size_t i = 0; i < picture_scene_count; ++i)
        tests[i] = (struct CMUnitTest){.name = picture_scenes[i].path,
                                       .test_func = exact_ways_agree,
                                       .initial_state = (void *)(uintptr_t)&picture_scenes[i]};
    const int failed =
        named_run("exact ways agree", argc > 1 ? argv[1] : NULL, tests, picture_scene_count);
    picture_close();
    return failed;
}
