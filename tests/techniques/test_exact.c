/* SPDX-License-Identifier: MIT
 *
 * Exact means bit-identical: layouts, backends, bands, orders of submission, runs and thread counts
 * give one image for each scene; and that image is the fold of the deep image's samples, term by
 * term.
 */
#define _GNU_SOURCE

#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmocka.h>

#include "named.h"
#include "render/render.h"

static const char *const backends[] = {"vulkan", "gl", "vulkan lacks:ordered_attachments",
                                       "gl lacks:ordered_attachments"};

/* Every way to render that promises the same bits as the first. */
static void all_ways(const test_scene *s) {
    static const way ways[] = {
        {.bands = 0},
        {.bands = 7},
        {.shuffle = 5},
        {.settings = {"abuffer.mode=linked"}},
        {.settings = {"abuffer.mode=linked"}, .bands = 7, .shuffle = 9},
        {.settings = {"surface.ties=exact"}, .shuffle = 5},
    };
    picture reference = {0};
    for (size_t b = 0; b < sizeof backends / sizeof *backends; ++b) {
        strata *instance = picture_instance(backends[b]);
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, s->path);
        const size_t count =
            b < 2 ? sizeof ways / sizeof ways[0] : 2; /* contiguous alone differs */
        for (size_t i = 0; i < count; ++i) {
            char what[256];
            way w = ways[i];
            w.backend = backends[b];
            w.use = "abuffer,ppc";
            snprintf(what, sizeof what, "%s on %s, %s, %u bands, shuffle %u", s->path, backends[b],
                     w.settings[0] ? w.settings[0] : "contiguous", w.bands, w.shuffle);
            picture p = picture_render(sc, instance, &w, s->width, s->height);
            if (!reference.pixels) {
                reference = p;
                continue;
            }
            picture_same(&reference, &p, what);
            picture_free(&p);
        }
        strata_scene_close(sc);
    }
    if (!reference.pixels)
        skip();
    picture_free(&reference);
}

static void every_way_gives_the_same_bits(void **state) {
    (void)state;
    for (size_t i = 0; i < picture_scene_count; ++i)
        all_ways(&picture_scenes[i]);
}

/* ---- the fold, term by term
 * ---------------------------------------------------------------------- */

static void fold_samples(const image_deep *deep, size_t pixel, const float background[4],
                         float out[4]) {
    float color[4] = {0, 0, 0, 0}, through[4] = {1, 1, 1, 1};
    for (uint32_t i = 0; i < deep->count[pixel]; ++i) {
        const size_t at = deep->offset[pixel] + i;
        for (int c = 0; c < 4; ++c)
            color[c] = color[c] + through[c] * deep->color[4 * at + (size_t)c];
        for (int c = 0; c < 4; ++c)
            through[c] = through[c] * (1.0f - deep->color[4 * at + 3]);
    }
    for (int c = 0; c < 4; ++c)
        out[c] = color[c] + through[c] * background[c];
}

/* Deep samples are sorted on the CPU; folding them with the technique's own operations must give
 * its bits. Plain transparency without an opaque surface, whose samples carry no coverage of their
 * own. */
static void check_fold(const char *backend, const char *path, const char *setting, uint32_t width,
                       uint32_t height, uint64_t fragments) {
    strata *instance = picture_instance(backend);
    if (!instance)
        return;
    strata_scene *sc = picture_scene(instance, path);
    const float background[4] = {0.2f, 0.2f, 0.2f, 1};
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = width,
                                           .height = height,
                                           .outputs = STRATA_OUTPUT_DEEP,
                                           .settings = &setting,
                                           .setting_count = 1};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s: %s", path, strata_error(instance));
    const render_result *result = &instance->result;
    assert_int_equal(result->deep.sample_count, fragments);
    for (size_t i = 0; i < (size_t)width * height; ++i) {
        float expected[4];
        fold_samples(&result->deep, i, background, expected);
        if (memcmp(expected, result->color.pixels + 4 * i, sizeof expected) != 0)
            fail_msg("%s on %s, %s: pixel %zu of %u samples is not their fold", path, backend,
                     setting, i, result->deep.count[i]);
    }
    strata_scene_close(sc);
}

static void long_pixels_fold_in_order(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; ++b) {
        check_fold(backends[b], "scene:layers?count=64&width=16&height=16",
                   "abuffer.mode=contiguous", 16, 16, 64 * 256);
        check_fold(backends[b], "scene:layers?count=20000&where=pixel&width=16&height=16",
                   "abuffer.mode=contiguous", 16, 16, 20000);
        check_fold(backends[b], "scene:layers?count=20000&where=pixel&width=16&height=16",
                   "abuffer.mode=linked", 16, 16, 20000);
        check_fold(backends[b], "scene:layers?count=100000&where=pixel&width=16&height=16",
                   "abuffer.mode=contiguous", 16, 16, 100000);
        check_fold(backends[b], "scene:layers?count=100000&where=pixel&width=16&height=16",
                   "abuffer.mode=linked", 16, 16, 100000);
    }
}

/* ---- processes and threads ------------------------------------------------------------------- */

/* Ways that give the same bits for every number of threads and every order of submission; those of
 * one group, the same as each other. */
typedef struct threaded_way {
    const char *use, *settings[4], *fact; /* fact: that it needs of the device */
    uint32_t group;
    uint32_t deep; /* 1: a pixel of 1,500 layers, where fpc reassociates; 0: soup */
    double tolerance;
} threaded_way;

static const threaded_way threaded[] = {
    {NULL, {NULL}, .group = 0},
    {"abuffer,fpc", {"fpc.mode=fragments"}, .group = 1},
    {"abuffer,fpc", {"abuffer.mode=linked", "fpc.mode=fragments"}, .group = 1},
    {"abuffer,fpc", {"fpc.mode=hybrid"}, .group = 2},
    {"kplus,ppc", {"kplus.k=7"}, .group = 7},
    {"kplus,ppc",
     {"kplus.k=7", "kplus.exclusion=unlocked", "kplus.structure=array"},
     .fact = "selftest.ordered_rmw",
     .group = 7},
    {"kplus,ppc",
     {"kplus.k=7", "kplus.exclusion=unlocked", "kplus.structure=heap", "kplus.memory=exact"},
     .fact = "selftest.ordered_rmw",
     .group = 7},
    {"kplus,ppc",
     {"kplus.k=7", "kplus.exclusion=ordered"},
     .fact = "ordered_attachments",
     .group = 7},
    {"kplus,ppc", {"kplus.k=7", "kplus.exclusion=lock", "kplus.structure=array"}, .group = 7},
    {"kplus,ppc",
     {"kplus.k=7", "kplus.exclusion=lock", "kplus.structure=heap", "kplus.memory=exact"},
     .group = 7},
    {"kplus,ppc", {"kplus.k=7", "kplus.exclusion=lock", "kplus.tries=1"}, .group = 7},
    {"kplus,ppc", {"kplus.k=7", "kplus.exclusion=atomic32"}, .group = 7},
    {"kplus,ppc",
     {"kplus.k=7", "kplus.exclusion=atomic64"},
     .fact = "feature.int64_atomics",
     .group = 7},
    {"kplus,ppc", {"kplus.payload=float"}, .group = 8, .tolerance = 0.01},
    {"abuffer,fpc", {"fpc.mode=fragments"}, .group = 9, .deep = 1},
    {"abuffer,fpc", {"abuffer.mode=linked", "fpc.mode=fragments"}, .group = 9, .deep = 1},
    {"abuffer,fpc", {"fpc.mode=hybrid"}, .group = 10, .deep = 1},
    {"kplus,fpc",
     {"kplus.k=1000", "kplus.memory=exact", "fpc.mode=hybrid"},
     .group = 11,
     .deep = 1},
};

/* What a child of this program prints on a backend under LP_NUM_THREADS. */
static void print_in_child(const char *self, const char *backend, const char *threads, char *out,
                           size_t size) {
    int ends[2], status = 0;
    assert_int_equal(pipe(ends), 0);
    const pid_t child = fork();
    if (child == 0) {
        dup2(ends[1], 1);
        setenv("LP_NUM_THREADS", threads, 1);
        execl(self, self, "--hash", backend, (char *)NULL);
        _exit(127);
    }
    close(ends[1]);
    FILE *from = fdopen(ends[0], "r");
    out[fread(out, 1, size - 1, from)] = '\0';
    fclose(from);
    waitpid(child, &status, 0);
    if (status != 0)
        fail_msg("%s with %s threads: %s", backend, threads, out);
}

static void threads_do_not_matter(void **state) {
    static const char *const threads[] = {"2", "0", "1", "4"};
    for (size_t b = 0; b < 2; ++b) {
        char first[4096], other[4096];
        if (!picture_instance(backends[b]))
            continue;
        print_in_child(*state, backends[b], threads[0], first, sizeof first);
        for (size_t i = 1; i < BASE_COUNT(threads); ++i) {
            print_in_child(*state, backends[b], threads[i], other, sizeof other);
            if (strcmp(first, other) != 0)
                fail_msg("%s: with %s threads\n%swith %s\n%s", backends[b], threads[0], first,
                         threads[i], other);
        }
    }
}

/* Prints the hash of each way. 1: the order of submission changed it, or it is not its group's. */
static int print_way(strata *instance, const char *backend, const threaded_way *t,
                     uint64_t *group) {
    static const uint32_t shuffles[] = {0, 5};
    const test_scene *seen = &picture_scenes[t->deep ? picture_scene_count - 1 : 0];
    way w = {.backend = backend, .use = t->use, .tolerance = t->tolerance};
    strata_scene *sc = picture_scene(instance, seen->path);
    int failed = 0;
    memcpy(w.settings, t->settings, sizeof t->settings);
    for (size_t i = 0; i < BASE_COUNT(shuffles); ++i) {
        w.shuffle = shuffles[i];
        picture p = picture_render(sc, instance, &w, seen->width, seen->height);
        const uint64_t hash = picture_hash(&p);
        picture_free(&p);
        *group = *group ? *group : hash;
        printf("%lx %s %s %s, shuffle %u\n", hash, t->use ? t->use : "",
               w.settings[0] ? w.settings[0] : "", w.settings[1] ? w.settings[1] : "", shuffles[i]);
        failed |= hash != *group;
    }
    strata_scene_close(sc);
    return failed;
}

static int print_hashes(const char *backend) {
    strata *instance = picture_instance(backend);
    uint64_t groups[16] = {0};
    int failed = !instance;
    if (failed)
        return 1;
    for (size_t i = 0; i < BASE_COUNT(threaded) && !failed; ++i)
        if (!threaded[i].fact || picture_fact(instance, threaded[i].fact))
            failed = print_way(instance, backend, &threaded[i], &groups[threaded[i].group]);
    picture_close();
    return failed;
}

int main(int argc, char **argv) {
    if (argc == 3 && strcmp(argv[1], "--hash") == 0)
        return print_hashes(argv[2]);
    static char self[4096];
    const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    self[length > 0 ? length : 0] = '\0';
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_way_gives_the_same_bits),
        cmocka_unit_test(long_pixels_fold_in_order),
        cmocka_unit_test_prestate(threads_do_not_matter, self),
    };
    const int failed = named_run("exact", argc > 1 ? argv[1] : NULL, tests, BASE_COUNT(tests));
    picture_close();
    return failed;
}
