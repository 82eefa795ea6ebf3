/* SPDX-License-Identifier: MIT
 *
 * Hard cases of capacity: at a limit of the implementation, one below it and one above. See hard.h.
 */
#include "hard/hard.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gpu/gpu_internal.h"

static strata_render_options small(const char *use, const char *const *setting) {
    return (strata_render_options){.width = 16,
                                   .height = 16,
                                   .use = use,
                                   .settings = setting,
                                   .setting_count = setting != NULL};
}

/* ---- k ----------------------------------------------------------------------------------------
 */

/* 33 layers with room for 32, 33 and 34: exact from 33 on, and certified below. */
static void nearest_k(void **state) {
    static const char *const settings[][3] = {
        {"kplus.k=32", "kplus.k=33", "kplus.k=34"},
        {"peel.layers=32", "peel.layers=33", "peel.layers=34"}};
    (void)state;
    for (size_t b = 0; b < 2; b++) {
        strata *instance = picture_instance(hard_backends[b]);
        if (!instance)
            continue;
        const oracle_case frame = {ORACLE_FRAME("hard:layers-33", 16, 16)};
        strata_scene *sc = hard_scene(instance, "layers-33");
        oracle_exact exact = oracle_exact_make(instance, sc, &frame);
        picture all = hard_render(instance, sc, small(NULL, NULL));
        for (size_t i = 0; i < 6; i++) {
            const char *use = i < 3 ? "kplus,ppc" : "peel";
            const char *const setting[3] = {settings[i / 3][i % 3]};
            picture p = hard_render(instance, sc, small(use, setting));
            const uint64_t lost = instance->result.report.total - instance->result.report.kept;
            if (i % 3 > 0)
                picture_same(&all, &p, setting[0]);
            else if (i == 0)
                assert_int_equal(lost, 16 * 16);
            if (i % 3 == 0)
                assert_int_not_equal(picture_hash(&all), picture_hash(&p));
            picture_free(&p);
            oracle_certify(instance, sc, &frame, use, setting, 0);
            oracle_tally tally = oracle_hold(instance, &exact, setting[0]);
            assert_int_equal(tally.uncertified, 0);
            oracle_tally_free(&tally);
        }
        picture_free(&all);
        oracle_exact_free(&exact);
        strata_scene_close(sc);
    }
}

/* ---- stencil ----------------------------------------------------------------------------------
 */

/* 253 and 254 layers are routed, 255 and 256 refused with what would hold them. */
static void stencil_layers(void **state) {
    static const char *const names[] = {"layers-253", "layers-254", "layers-255", "layers-256"};
    (void)state;
    for (size_t b = 0; b < 2; b++) {
        strata *instance = picture_instance(hard_backends[b]);
        for (size_t i = 0; instance && i < 4; i++) {
            const strata_render_options options = {
                .struct_size = sizeof options, .width = 8, .height = 8, .use = "stencil,ppc"};
            strata_scene *sc = hard_scene(instance, names[i]);
            if (i < 2) {
                picture reference = {0};
                hard_ways(instance, sc, names[i], 254, 8, 8, &reference);
                picture_free(&reference);
            } else {
                char line[96];
                snprintf(line, sizeof line, "stencil: a pixel holds %zu fragments", 253 + i);
                assert_true(strata_render(instance, sc, &options) < 0);
                assert_non_null(strstr(strata_error(instance), line));
            }
            strata_scene_close(sc);
        }
    }
}

/* ---- pools ------------------------------------------------------------------------------------
 */

/* How often the frame is recorded again when the pool of records has so many. */
static uint32_t retries_with(strata *instance, strata_scene *sc, const char *mode,
                             uint64_t capacity, const picture *expected) {
    base_error err = {0};
    const strata_pool pool = instance->session->fragments.records;
    assert_int_equal(gpu_pool_grow(instance->gpu, pool, capacity, &err), STRATA_OK);
    picture p = hard_render(instance, sc, small(NULL, &mode));
    picture_same(expected, &p, mode);
    picture_free(&p);
    return instance->result.retries;
}

/* Exactly full and one spare are enough, one short is found out and mended. */
static void pool_sizes(void **state) {
    static const char *const modes[] = {"abuffer.mode=contiguous", "abuffer.mode=linked"};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        const char *mode = modes[i % 2];
        strata *instance = picture_instance(hard_backends[i / 2]);
        if (!instance)
            continue;
        base_error err = {0};
        uint64_t needed = 0;
        strata_scene *sc = hard_scene(instance, "layers-65");
        picture expected = hard_render(instance, sc, small(NULL, &mode));
        assert_int_equal(
            gpu_pool_needed(instance->gpu, instance->session->fragments.records, &needed, &err),
            STRATA_OK);
        assert_int_equal(needed, 65 * 16 * 16);
        assert_int_equal(retries_with(instance, sc, mode, needed, &expected), 0);
        assert_int_equal(retries_with(instance, sc, mode, needed - 1, &expected), 1);
        assert_int_equal(retries_with(instance, sc, mode, needed + 1, &expected), 0);
        picture_free(&expected);
        strata_scene_close(sc);
    }
}

/* ---- sizes of the picture ---------------------------------------------------------------------
 */

static void picture_sizes(void **state) {
    static const uint32_t sizes[][2] = {{1, 1}, {1, 61}, {61, 1}, {61, 53}, {2, 127}};
    (void)state;
    for (size_t i = 0; i < BASE_COUNT(sizes); i++) {
        picture reference = {0};
        for (size_t b = 0; b < 2; b++) {
            strata *instance = picture_instance(hard_backends[b]);
            if (!instance)
                continue;
            char what[64];
            snprintf(what, sizeof what, "%u x %u", sizes[i][0], sizes[i][1]);
            strata_scene *sc = hard_scene(instance, "crossing");
            hard_ways(instance, sc, what, 64, sizes[i][0], sizes[i][1], &reference);
            strata_scene_close(sc);
        }
        picture_free(&reference);
    }
}

/* ---- memory that is refused -------------------------------------------------------------------
 */

/* One creation after the other fails, every seventh: either the picture comes all the same or one
 * line does, and the next frame is right. */
static void allocation_refused(void **state) {
    (void)state;
    for (size_t b = 0; b < 2; b++) {
        strata *sound = picture_instance(hard_backends[b]);
        if (!sound)
            continue;
        strata_scene *sc = hard_scene(sound, "layers-65");
        picture expected = hard_render(sound, sc, small(NULL, NULL));
        strata_scene_close(sc);
        for (unsigned n = 1, reached = 1; reached; n += 7) {
            char inject[32];
            snprintf(inject, sizeof inject, "allocation:%u", n);
            const strata_open_options options = {.struct_size = sizeof options,
                                                 .backend = hard_backends[b],
                                                 .inject = inject,
                                                 .check = 1};
            strata_render_options frame = small("abuffer,ppc", NULL);
            strata *s = NULL;
            frame.struct_size = sizeof frame;
            assert_int_equal(strata_open(&options, &s), STRATA_OK);
            sc = hard_scene(s, "layers-65");
            if (strata_render(s, sc, &frame) != STRATA_OK)
                assert_true(strata_error(s)[0] && !strchr(strata_error(s), '\n'));
            reached = !s->gpu || s->gpu->creations >= n;
            picture p = hard_render(s, sc, frame);
            picture_same(&expected, &p, inject);
            picture_free(&p);
            strata_scene_close(sc);
            strata_close(s);
        }
        picture_free(&expected);
    }
}

const hard_limit hard_limits[] = {
    {"nearest-k", nearest_k, "an evicted fragment is not lost"},
    {"stencil-layers", stencil_layers, "more layers than a stencil counts are let pass"},
    {"pool-sizes", pool_sizes, "a pool that is one record short is let pass"},
    {"picture-sizes", picture_sizes, "a last tile that is not full is left out"},
    {"allocation-refused", allocation_refused, "after one refusal all creations are refused"},
};
const size_t hard_limit_count = sizeof hard_limits / sizeof *hard_limits;
