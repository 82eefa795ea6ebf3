/* SPDX-License-Identifier: MIT
 *
 * The k-buffer: on input in order, or out of order by at most k places, the bits of abuffer and
 * ppc, from attachments and from storage; and where the order is lost, that it says so at exactly
 * the pixels where it was.
 */
#include "techniques/picture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "render/render.h"

/* Entries in attachments, in storage, in storage with an interlock. */
#define STORAGE   " lacks:ordered_attachments"
#define INTERLOCK STORAGE ",lacks:selftest.ordered_rmw,claims:selftest.interlock"
static const char *const backends[] = {
    "vulkan", "gl", "vulkan" STORAGE, "gl" STORAGE, "vulkan" INTERLOCK, "gl" INTERLOCK};

#define BACKENDS (sizeof backends / sizeof *backends)

typedef struct stream_case {
    const char *path;
    uint32_t width, height;
    const char *settings[3]; /* of kbuffer; a payload first, in abuffer's words too */
    uint32_t lost;           /* pixels; the others have the bits of the reference */
} stream_case;

static const stream_case cases[] = {
    /* in order: any k does */
    {"scene:layers?count=65&order=near", 17, 13, {"float", "kbuffer.k=1"}, 0},
    {"scene:layers?count=65&order=near", 17, 13, {"float", "kbuffer.k=4"}, 0},
    {"scene:layers?count=65&order=near", 17, 13, {"half", "kbuffer.k=6"}, 0},
    {"scene:layers?count=65&order=near", 17, 13, {"unorm8", "kbuffer.k=8"}, 0},
    {"scene:layers?count=1500&order=near&where=pixel&width=16&height=16",
     16,
     16,
     {"float", "kbuffer.k=2"},
     0},
    /* the nearest comes last: k + 1 layers are the most that k entries put in order */
    {"scene:layers?count=4&order=far", 9, 7, {"float", "kbuffer.k=4"}, 0},
    {"scene:layers?count=5&order=far", 9, 7, {"float", "kbuffer.k=4"}, 0},
    {"scene:layers?count=6&order=far", 8, 8, {"float", "kbuffer.k=4"}, 8 * 8},
    {"scene:layers?count=2&order=far", 9, 7, {"float", "kbuffer.k=1"}, 0},
    {"scene:layers?count=3&order=far", 8, 8, {"float", "kbuffer.k=1"}, 8 * 8},
    /* more entries than attachments hold */
    {"scene:layers?count=17&order=far", 9, 7, {"float", "kbuffer.k=16"}, 0},
    {"scene:layers?count=18&order=far", 8, 8, {"float", "kbuffer.k=16"}, 8 * 8},
    /* equal depths come as the painter's last one first: far first */
    {"scene:stack?count=2", 48, 48, {"float", "kbuffer.k=1"}, 0},
    {"scene:stack?count=9", 48, 48, {"unorm8", "kbuffer.k=8"}, 0},
    {"scene:layers?count=0", 16, 16, {"float", "kbuffer.k=4"}, 0},
};

static const char *const any_order[] = {"scene:soup?small=3000&medium=150", "scene:glass",
                                        "scene:shells"};

/* Whether this device, as it is to be taken, holds the entries somewhere. */
static int holds(const strata *instance, const char *const *settings) {
    static const char *const fit[] = {"kbuffer.k=1", "kbuffer.k=2", "kbuffer.k=4"};
    int fits = strcmp(settings[0], "float") != 0;
    for (size_t i = 0; i < sizeof fit / sizeof *fit; ++i)
        fits |= strcmp(settings[1], fit[i]) == 0;
    return picture_fact(instance, "selftest.ordered_rmw") ||
           picture_fact(instance, "selftest.interlock") ||
           (fits && picture_fact(instance, "ordered_attachments"));
}

static picture reference(strata *instance, strata_scene *sc, const char *payload, uint32_t width,
                         uint32_t height) {
    char setting[64];
    snprintf(setting, sizeof setting, "abuffer.payload=%s", payload);
    return picture_render(sc, instance, &(way){.use = "abuffer,ppc", .settings = {setting}}, width,
                          height);
}

static picture stream(strata *instance, strata_scene *sc, const char *const *settings,
                      uint32_t bands, uint32_t width, uint32_t height) {
    char payload[64];
    snprintf(payload, sizeof payload, "kbuffer.payload=%s", settings[0]);
    return picture_render(
        sc, instance, &(way){.use = "kbuffer", .settings = {payload, settings[1]}, .bands = bands},
        width, height);
}

static void check_case(const stream_case *c, const char *backend) {
    char what[256];
    strata *instance = picture_instance(backend);
    if (!instance || !holds(instance, c->settings))
        return;
    snprintf(what, sizeof what, "%s, %s %s on %s", c->path, c->settings[0], c->settings[1],
             backend);
    strata_scene *sc = picture_scene(instance, c->path);
    picture wanted = reference(instance, sc, c->settings[0], c->width, c->height);
    const uint64_t fragments = instance->result.report.total;
    for (uint32_t bands = 0; bands < 4; bands += 3) {
        picture p = stream(instance, sc, c->settings, bands, c->width, c->height);
        const render_report *report = &instance->result.report;
        if (report->lost != c->lost)
            fail_msg("%s: %llu pixels lost", what, (unsigned long long)report->lost);
        assert_int_equal(report->total, fragments);
        assert_int_equal(instance->result.warning_count > 0, c->lost > 0);
        if (c->lost == 0)
            picture_same(&wanted, &p, what);
        picture_free(&p);
    }
    picture_free(&wanted);
    strata_scene_close(sc);
}

static void sorted_streams_are_exact(void **state) {
    (void)state;
    for (size_t b = 0; b < BACKENDS; ++b)
        for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
            check_case(&cases[i], backends[b]);
}

/* In no order: pixels that differ from the exact image are among the flagged, so no more differ
 * than are counted, and attachments and storage flag and fold alike. */
static void lost_orders_are_counted(void **state) {
    static const char *const settings[] = {"float", "kbuffer.k=2"};
    (void)state;
    for (size_t i = 0; i < sizeof any_order / sizeof *any_order; ++i) {
        picture first = {0};
        uint64_t lost = 0;
        for (size_t b = 0; b < BACKENDS; ++b) {
            strata *instance = picture_instance(backends[b]);
            uint64_t differing = 0;
            if (!instance || !holds(instance, settings))
                continue;
            strata_scene *sc = picture_scene(instance, any_order[i]);
            picture wanted = reference(instance, sc, "float", 64, 48);
            picture p = stream(instance, sc, settings, 0, 64, 48);
            for (size_t k = 0; k < 64 * 48; ++k)
                differing += memcmp(wanted.pixels + 4 * k, p.pixels + 4 * k, 16) != 0;
            assert_true(differing <= instance->result.report.lost);
            picture_free(&wanted);
            strata_scene_close(sc);
            if (first.pixels) {
                picture_same(&first, &p, any_order[i]);
                assert_int_equal(lost, instance->result.report.lost);
                picture_free(&p);
                continue;
            }
            first = p;
            lost = instance->result.report.lost;
        }
        picture_free(&first);
    }
}

/* In order: a bound, which is that of rounding, everywhere. Out of order: none where it was lost.
 */
static void lost_orders_are_uncertified(void **state) {
    static const struct {
        const char *path;
        uint64_t uncertified;
    } rows[] = {{"scene:layers?count=33&order=near", 0},
                {"scene:layers?count=33&order=far", 8 * 8}};
    const char *const settings[] = {"kbuffer.k=2"};
    (void)state;
    for (size_t b = 0; b < BACKENDS; ++b)
        for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
            strata *instance = picture_instance(backends[b]);
            if (!instance || !picture_fact(instance, "ordered_access"))
                continue;
            strata_scene *sc = picture_scene(instance, rows[i].path);
            const strata_render_options options = {.struct_size = sizeof options,
                                                   .width = 8,
                                                   .height = 8,
                                                   .use = "kbuffer",
                                                   .outputs = STRATA_OUTPUT_BOUND,
                                                   .settings = settings,
                                                   .setting_count = 1};
            if (strata_render(instance, sc, &options) != STRATA_OK)
                fail_msg("%s: %s", backends[b], strata_error(instance));
            const render_result *result = &instance->result;
            assert_int_equal(result->report.lost, rows[i].uncertified);
            assert_int_equal(result->bound.uncertified, rows[i].uncertified);
            assert_true(rows[i].uncertified > 0 ||
                        (result->bound.max > 0 && result->bound.max < 1e-4));
            strata_scene_close(sc);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sorted_streams_are_exact),
        cmocka_unit_test(lost_orders_are_counted),
        cmocka_unit_test(lost_orders_are_uncertified),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    picture_close();
    return failed;
}
