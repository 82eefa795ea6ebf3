/* SPDX-License-Identifier: MIT
 *
 * occupancy hides no fragment that belongs to the nearest k of its pixel, whatever the number of
 * buckets, and nothing where there are fewer; both backends, bands and orders of submission give
 * the same limit; everything it hides is counted; before kplus it changes no bit. Read through the
 * module `sieve`, which stores whatever passes limit/1.
 */
#define _DEFAULT_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "render/render.h"
#include "scenes/glb.h"
#include "techniques/picture.h"

static const char *const backends[] = {"vulkan", "gl"};
static char *module_path;

/* Each pixel's fragments by (key, order), and the limit they passed, as keys. */
typedef struct sieved {
    uint32_t width, height;
    uint64_t total, kept; /* as reported */
    size_t count;
    uint32_t *first;         /* [pixels + 1] */
    uint64_t *records;       /* key << 32 | order, ascending in each pixel */
    uint32_t *limit, *depth; /* [pixels] keys */
} sieved;

/* ---- rendering and reading back -------------------------------------------------------------- */

static int open_instances(void **state) {
    static strata *instances[2];
    const char *build = getenv("STRATA_TEST_BUILD"), *installed = getenv("STRATA_MODULE_PATH");
    module_path =
        base_format("%s:%s/tests/modules/sieve", installed ? installed : "", build ? build : ".");
    for (size_t b = 0; b < 2; ++b) {
        const strata_open_options options = {.struct_size = sizeof options,
                                             .backend = backends[b],
                                             .module_path = module_path,
                                             .check = 1};
        base_error err = {0};
        if (strata_open(&options, &instances[b]) != STRATA_OK)
            return -1;
        if (render_device(instances[b], &err) == STRATA_OK)
            continue;
        print_message("%s cannot be opened: %s\n", backends[b], err.text);
        strata_close(instances[b]);
        instances[b] = NULL;
    }
    *state = instances;
    return 0;
}

static int close_instances(void **state) {
    strata **instances = *state;
    strata_close(instances[0]);
    strata_close(instances[1]);
    free(module_path);
    return 0;
}

static void *room(size_t count, size_t size) {
    void *memory = base_calloc(count ? count : 1, size);
    assert_non_null(memory);
    return memory;
}

static uint32_t *read_keys(gpu *g, strata_image from, size_t pixels) {
    base_error err = {0};
    uint32_t *keys = room(pixels, sizeof *keys);
    if (gpu_image_read(g, from, 0, keys, pixels * sizeof *keys, &err) != STRATA_OK)
        fail_msg("%s", err.text);
    for (size_t i = 0; i < pixels; ++i)
        keys[i] = 0x3f800000u - keys[i];
    return keys;
}

static int ascending(const void *a, const void *b) {
    const uint64_t left = *(const uint64_t *)a, right = *(const uint64_t *)b;
    return left < right ? -1 : left > right;
}

/* Walks the lists of the whole frame, or with several bands nothing. */
static void read_records(const render_session *session, sieved *s) {
    gpu *g = session->owner->gpu;
    const size_t pixels = (size_t)s->width * s->height;
    base_error err = {0};
    uint64_t count = 0;
    s->first = room(pixels + 1, sizeof *s->first);
    if (session->band_count > 1 || !session->has_fragments)
        return;
    const strata_pool pool = session->fragments.records;
    assert_int_equal(gpu_pool_needed(g, pool, &count, &err), STRATA_OK);
    uint32_t *ranges = room(pixels, 8), *keys = room(count, 8), *links = room(count, 8);
    s->records = room(count, sizeof *s->records);
    assert_int_equal(gpu_buffer_read(g, session->fragments.ranges, 0, pixels * 8, ranges, &err), 0);
    if (count) {
        assert_int_equal(gpu_buffer_read(g, gpu_pool_plane(g, pool, 0), 0, count * 8, keys, &err),
                         0);
        assert_int_equal(gpu_buffer_read(g, gpu_pool_plane(g, pool, 1), 0, count * 8, links, &err),
                         0);
    }
    for (size_t p = 0; p < pixels; ++p) {
        uint64_t *records = s->records + s->count;
        for (size_t slot = ranges[2 * p]; slot < count; slot = links[2 * slot])
            s->records[s->count++] = (uint64_t)keys[2 * slot] << 32 | keys[2 * slot + 1];
        s->first[p + 1] = (uint32_t)s->count;
        qsort(records, s->first[p + 1] - s->first[p], sizeof *records, ascending);
    }
    assert_int_equal(s->count, count);
    free(ranges);
    free(keys);
    free(links);
}

typedef struct sieving {
    uint32_t k, buckets; /* buckets UINT32_MAX: without occupancy */
    uint32_t bands, shuffle;
} sieving;

static sieved sieve(strata *instance, strata_scene *sc, const sieving *how, uint32_t width,
                    uint32_t height) {
    char k[32], buckets[48];
    const int alone = how->buckets == UINT32_MAX;
    const char *const settings[] = {k, buckets};
    sieved s = {.width = width, .height = height};
    snprintf(k, sizeof k, "sieve.k=%u", how->k);
    snprintf(buckets, sizeof buckets, "occupancy.buckets=%u", how->buckets);
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = width,
                                           .height = height,
                                           .use = alone ? "sieve" : "sieve,occupancy",
                                           .settings = settings,
                                           .setting_count = alone ? 1 : 2,
                                           .bands = how->bands,
                                           .shuffle = how->shuffle};
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("k %u, %u buckets: %s", how->k, how->buckets, strata_error(instance));
    const render_session *session = instance->session;
    const size_t pixels = (size_t)width * height;
    s.limit = read_keys(instance->gpu, session->limit, pixels);
    s.depth = read_keys(instance->gpu, session->depth, pixels);
    s.total = alone ? session->report.total : session->report.before;
    s.kept = session->report.kept;
    read_records(session, &s);
    return s;
}

static void release(sieved *s) {
    free(s->first);
    free(s->records);
    free(s->limit);
    free(s->depth);
}

/* ---- what must hold -------------------------------------------------------------------------- */

/* The k nearest pass, fewer than k are not limited, and what passes is what lies up to the limit.
 */
static void check_pixel(const sieved *all, const sieved *s, size_t p, uint32_t k,
                        const char *what) {
    const uint64_t *records = all->records + all->first[p];
    const uint32_t count = all->first[p + 1] - all->first[p];
    const uint32_t limit = s->limit[p], depth = s->depth[p];
    uint32_t passing = 0;
    if (limit > depth)
        fail_msg("%s: pixel %zu: limit %08x lies behind the opaque %08x", what, p, limit, depth);
    if (count < k && limit != depth)
        fail_msg("%s: pixel %zu: %u fragments are limited to %08x", what, p, count, limit);
    if (count >= k && records[k - 1] >> 32 > limit)
        fail_msg("%s: pixel %zu of %u: fragment %u has key %08x, the limit %08x kills it", what, p,
                 count, k, (uint32_t)(records[k - 1] >> 32), limit);
    while (passing < count && records[passing] >> 32 <= limit)
        ++passing;
    if (s->first[p + 1] - s->first[p] != passing ||
        (passing && memcmp(s->records + s->first[p], records, passing * sizeof *records) != 0))
        fail_msg("%s: pixel %zu: %u records pass, not %u of %u", what, p,
                 s->first[p + 1] - s->first[p], passing, count);
}

static void check(const sieved *all, const sieved *s, uint32_t k, const char *what) {
    for (size_t p = 0; p < (size_t)s->width * s->height; ++p)
        check_pixel(all, s, p, k, what);
    if (s->total != all->count || s->kept != s->count)
        fail_msg("%s: %llu reported, %llu kept, there are %zu and %zu", what,
                 (unsigned long long)s->total, (unsigned long long)s->kept, all->count, s->count);
}

static const sieving hows[] = {
    {.k = 1, .buckets = 32},    {.k = 3, .buckets = 33},   {.k = 8, .buckets = 128},
    {.k = 33, .buckets = 1024}, {.k = 64, .buckets = 256}, {.k = 64, .buckets = 32},
};

typedef struct limits {
    uint32_t *of[sizeof hows / sizeof *hows]; /* of the first backend */
} limits;

static void sieve_scene(strata *instance, const test_scene *test, limits *first) {
    const uint32_t width = test->width, height = test->height;
    strata_scene *sc = picture_scene(instance, test->path);
    sieved all = sieve(instance, sc, &(sieving){.k = 1, .buckets = UINT32_MAX}, width, height);
    for (size_t i = 0; i < sizeof hows / sizeof *hows; ++i) {
        char what[256];
        sieved s = sieve(instance, sc, &hows[i], width, height);
        snprintf(what, sizeof what, "%s on %s, k %u, %u buckets", test->path, instance->backend,
                 hows[i].k, hows[i].buckets);
        check(&all, &s, hows[i].k, what);
        const size_t bytes = (size_t)width * height * sizeof *s.limit;
        if (first->of[i] && memcmp(first->of[i], s.limit, bytes) != 0)
            fail_msg("%s: its limits are not those of %s", what, backends[0]);
        if (!first->of[i]) {
            first->of[i] = s.limit;
            s.limit = NULL;
        }
        release(&s);
    }
    release(&all);
    strata_scene_close(sc);
}

static void the_nearest_k_pass(void **state) {
    strata **instances = *state;
    for (size_t i = 0; i < picture_scene_count; ++i) {
        limits first = {{0}};
        for (size_t b = 0; b < 2; ++b)
            if (instances[b])
                sieve_scene(instances[b], &picture_scenes[i], &first);
        for (size_t k = 0; k < sizeof hows / sizeof *hows; ++k)
            free(first.of[k]);
    }
}

/* Depths as they are hard on a division into buckets: all equal, far apart, hidden, on the edge of
 * the image. */
static void hard_depths_pass(void **state) {
    static const test_scene scenes[] = {
        {"scene:layers?count=20000&where=pixel&width=16&height=16", 16, 16, 20000},
        {"scene:layers?count=40&opaque=1&width=16&height=16", 16, 16, 40},
        {"scene:stack?count=40&opaque=1", 31, 29, 40},
        {"scene:stack?count=64&tilt=0", 8, 8, 64},
        {"scene:soup?small=9000&medium=900", 1, 1, 400},
        {"scene:soup?small=9000&medium=900", 127, 1, 400},
        {"scene:soup?small=9000&medium=900", 9, 17, 400},
    };
    strata **instances = *state;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; ++i) {
        limits first = {{0}};
        for (size_t b = 0; b < 2; ++b)
            if (instances[b])
                sieve_scene(instances[b], &scenes[i], &first);
        for (size_t k = 0; k < sizeof hows / sizeof *hows; ++k)
            free(first.of[k]);
    }
}

/* Large squares at 64 neighbouring depths, so that a bucket is one key. */
static strata_scene *close_scene(strata *instance) {
    enum { COUNT = 64 };
    static const float square[4][2] = {{-2, -2}, {2, -2}, {2, 2}, {-2, 2}};
    static const int corners[6] = {0, 1, 2, 0, 2, 3};
    static float positions[COUNT * 6][3];
    char path[] = "/tmp/strata-close-XXXXXX.glb";
    test_glb g = {0};
    strata_scene *sc = NULL;
    size_t size = 0;
    for (int i = 0; i < COUNT * 6; ++i) {
        positions[i][0] = square[corners[i % 6]][0];
        positions[i][1] = square[corners[i % 6]][1];
        positions[i][2] = -0.25f - 0x1p-24f * (float)(i / 6 * 37 % COUNT);
    }
    test_glb_floats(&g, "VEC3", 3, COUNT * 6, &positions[0][0]);
    test_glb_json(&g, "\"extensionsUsed\":[\"KHR_materials_unlit\"],\"materials\":[{\"alphaMode\":"
                      "\"BLEND\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,0.5,0.25,0.5]},"
                      "\"extensions\":{\"KHR_materials_unlit\":{}}}],\"meshes\":[{\"primitives\":[{"
                      "\"attributes\":{\"POSITION\":0},\"material\":0}]}]");
    test_glb_json(&g, "\"cameras\":[{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":1,"
                      "\"ymag\":1,\"znear\":0,\"zfar\":1}}],\"nodes\":[{\"mesh\":0},{\"camera\":"
                      "0}],\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}]");
    unsigned char *file = test_glb_finish(&g, &size);
    const int fd = mkstemps(path, 4);
    assert_true(fd >= 0);
    assert_int_equal(write(fd, file, size), size);
    close(fd);
    free(file);
    sc = picture_scene(instance, path);
    unlink(path);
    return sc;
}

/* There the limit is the k-th fragment's own depth, and that fragment passes. */
static void the_limit_is_exact_where_buckets_are_keys(void **state) {
    static const uint32_t counts[] = {1, 8, 31, 32, 33, 63, 64};
    strata **instances = *state;
    for (size_t i = 0; i < 2 * sizeof counts / sizeof *counts; ++i) {
        const uint32_t k = counts[i / 2];
        strata *instance = instances[i % 2];
        if (!instance)
            continue;
        strata_scene *sc = close_scene(instance);
        sieved all = sieve(instance, sc, &(sieving){.k = 1, .buckets = UINT32_MAX}, 12, 12);
        sieved s = sieve(instance, sc, &(sieving){.k = k, .buckets = 256}, 12, 12);
        check(&all, &s, k, "neighbouring depths");
        for (size_t p = 0; p < 12 * 12; ++p) {
            const uint64_t *records = all.records + all.first[p];
            const uint32_t kth = (uint32_t)(records[k - 1] >> 32);
            assert_int_equal(all.first[p + 1] - all.first[p], 64);
            for (uint32_t n = 1; n < 64; ++n)
                assert_true(records[n] >> 32 > records[n - 1] >> 32);
            if (k < 64 && s.limit[p] != kth)
                fail_msg("pixel %zu, k %u: limit %08x, not %08x", p, k, s.limit[p], kth);
        }
        release(&all);
        release(&s);
        strata_scene_close(sc);
    }
}

static void bands_and_orders_do_not_matter(void **state) {
    static const sieving others[] = {
        {.k = 8, .buckets = 128, .bands = 7},
        {.k = 8, .buckets = 128, .shuffle = 5},
        {.k = 8, .buckets = 128, .bands = 3, .shuffle = 11},
    };
    strata **instances = *state;
    for (size_t b = 0; b < 2; ++b) {
        if (!instances[b])
            continue;
        strata_scene *sc = picture_scene(instances[b], picture_scenes[0].path);
        const sieving whole = {.k = 8, .buckets = 128};
        sieved reference = sieve(instances[b], sc, &whole, 90, 70);
        for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
            sieved s = sieve(instances[b], sc, &others[i], 90, 70);
            if (memcmp(reference.limit, s.limit, sizeof *s.limit * 90 * 70) != 0)
                fail_msg("%s, %u bands, shuffle %u: another limit", backends[b], others[i].bands,
                         others[i].shuffle);
            assert_int_equal(s.total, reference.total);
            assert_int_equal(s.kept, reference.kept);
            release(&s);
        }
        release(&reference);
        strata_scene_close(sc);
    }
}

/* ---- in front of a capture that drops by itself ---------------------------------------------- */

static void kplus_keeps_the_same(void **state) {
    static const test_scene scenes[] = {
        {"scene:soup?small=9000&medium=900", 48, 40, 60},
        {"scene:hairball?strands=3000&segments=8&radius=0.03", 48, 48, 160},
        {"scene:glass", 40, 30, 117},
        {"scene:stack?count=40&opaque=1", 24, 24, 40},
    };
    static const char *const counts[] = {"kplus.k=1", "kplus.k=4", "kplus.k=8", "kplus.k=31",
                                         "kplus.k=64"};
    strata **instances = *state;
    for (size_t i = 0; i < 2 * sizeof scenes / sizeof *scenes; ++i) {
        const test_scene *s = &scenes[i / 2];
        strata *instance = instances[i % 2];
        if (!instance)
            continue;
        strata_scene *sc = picture_scene(instance, s->path);
        for (size_t k = 0; k < sizeof counts / sizeof *counts; ++k) {
            char what[256];
            const way alone = {.use = "kplus,ppc", .settings = {counts[k]}},
                      limited = {.use = "occupancy,kplus,ppc",
                                 .settings = {counts[k]},
                                 .bands = k % 2 ? 3 : 0};
            picture a = picture_render(sc, instance, &alone, s->width, s->height);
            const uint64_t total = instance->session->report.total;
            picture b = picture_render(sc, instance, &limited, s->width, s->height);
            snprintf(what, sizeof what, "%s on %s, %s", s->path, instance->backend, counts[k]);
            picture_same(&a, &b, what);
            assert_int_equal(instance->session->report.before, total);
            picture_free(&a);
            picture_free(&b);
        }
        strata_scene_close(sc);
    }
}

/* What was hidden weighs in the certificate as what kplus drops by itself. */
static void certificates_stay_the_same(void **state) {
    enum { SIZE = 40 };
    static const char *const uses[] = {"kplus,ppc", "occupancy,kplus,ppc"};
    const char *const setting = "kplus.k=4";
    strata **instances = *state;
    for (size_t b = 0; b < 2; ++b) {
        if (!instances[b])
            continue;
        static float bounds[2][SIZE * SIZE * 4];
        strata_scene *sc =
            picture_scene(instances[b], "scene:hairball?strands=500&segments=8&radius=0.06");
        for (size_t u = 0; u < 2; ++u) {
            const strata_render_options options = {.struct_size = sizeof options,
                                                   .width = SIZE,
                                                   .height = SIZE,
                                                   .use = uses[u],
                                                   .outputs = STRATA_OUTPUT_BOUND,
                                                   .settings = &setting,
                                                   .setting_count = 1};
            if (strata_render(instances[b], sc, &options) != STRATA_OK)
                fail_msg("%s", strata_error(instances[b]));
            assert_int_equal(
                strata_read(instances[b], STRATA_OUTPUT_BOUND, bounds[u], sizeof bounds[u]),
                STRATA_OK);
        }
        assert_memory_equal(bounds[0], bounds[1], sizeof bounds[0]);
        strata_scene_close(sc);
    }
}

/* ---- what it is good for --------------------------------------------------------------------- */

/* In percent, k = 8; the ideal is 8 of 41.5 fragments, 19 %. */
static void few_survive(void **state) {
    static const struct {
        uint32_t buckets;
        double most;
    } rows[] = {{32, 40}, {64, 30}, {128, 25}, {0, 25}, {1024, 21}};
    strata **instances = *state;
    strata *instance = instances[0] ? instances[0] : instances[1];
    if (!instance)
        skip();
    strata_scene *sc = picture_scene(instance, "scene:soup");
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        sieved s = sieve(instance, sc, &(sieving){.k = 8, .buckets = rows[i].buckets}, 96, 96);
        const double share = 100.0 * (double)s.kept / (double)s.total;
        print_message("%u buckets: %.1f %% of %llu survive\n", rows[i].buckets, share,
                      (unsigned long long)s.total);
        assert_true(share <= rows[i].most);
        release(&s);
    }
    strata_scene_close(sc);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_limit_is_exact_where_buckets_are_keys),
        cmocka_unit_test(certificates_stay_the_same),
        cmocka_unit_test(the_nearest_k_pass),
        cmocka_unit_test(hard_depths_pass),
        cmocka_unit_test(bands_and_orders_do_not_matter),
        cmocka_unit_test(kplus_keeps_the_same),
        cmocka_unit_test(few_survive),
    };
    return cmocka_run_group_tests(tests, open_instances, close_instances);
}
