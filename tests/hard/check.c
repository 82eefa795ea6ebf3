/* SPDX-License-Identifier: MIT
 *
 * What must hold of every row: the ways that promise the same bits, the invariances, the oracles.
 * See hard.h.
 */
#define _DEFAULT_SOURCE
#include "hard/hard.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

const char *const hard_backends[2] = {"vulkan", "gl"};
uint32_t hard_thorough;
void (*hard_tell)(const hard_told *told);

/* ---- rendering --------------------------------------------------------------------------------
 */

const scene_hard_case *hard_case(const char *name) {
    const scene_hard_case *found;
    for (uint32_t i = 0; (found = scene_hard_cases(i)); i++)
        if (strcmp(found->name + strlen("hard:"), name) == 0)
            return found;
    fail_msg("there is no scene hard:%s", name);
    return NULL;
}

strata_scene *hard_scene(strata *instance, const char *name) {
    return picture_scene(instance, hard_case(name)->name);
}

picture hard_render(strata *instance, strata_scene *sc, strata_render_options options) {
    picture p = {.width = options.width, .height = options.height};
    const size_t size = (size_t)p.width * p.height * sizeof(float[4]);
    options.struct_size = sizeof options;
    options.use = options.use ? options.use : "abuffer,ppc";
    if (strata_render(instance, sc, &options) != STRATA_OK)
        fail_msg("%s: %s", options.use, strata_error(instance));
    p.pixels = malloc(size);
    assert_non_null(p.pixels);
    assert_int_equal(strata_read(instance, STRATA_OUTPUT_COLOR, p.pixels, size), STRATA_OK);
    return p;
}

/* ---- ways -------------------------------------------------------------------------------------
 * Each is rendered plainly, and in bands with the draws and triangles submitted in another order.
 */
static const struct {
    const char *use, *settings[2];
    uint32_t depth; /* the most fragments in one pixel; 0: memory alone limits */
    uint32_t quick; /* beyond so many it takes seconds: hard_large only */
} ways[] = {
    {"abuffer,ppc", {"abuffer.mode=contiguous"}, 0, 0},
    {"abuffer,ppc", {"abuffer.mode=linked"}, 0, 0},
    {"stencil,ppc", {NULL}, 254, 0},
    {"kplus,ppc", {"kplus.k=0"}, 0, 0},
    {"peel", {NULL}, 2048, 300}, /* in so many steps */
};

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void tell(const strata *instance, const char *what, size_t at, double took,
                 const picture *p) {
    const render_result *result = &instance->result;
    if (hard_tell)
        hard_tell(&(hard_told){.what = what,
                               .backend = instance->backend,
                               .use = ways[at].use,
                               .setting = ways[at].settings[0] ? ways[at].settings[0] : "",
                               .seconds = took,
                               .fragments = result->report.total,
                               .largest = result->report.largest,
                               .hash = picture_hash(p),
                               .bands = result->bands,
                               .retries = result->retries});
}

void hard_ways(strata *instance, strata_scene *sc, const char *what, uint32_t depth, uint32_t width,
               uint32_t height, picture *reference) {
    for (size_t i = 0; i < BASE_COUNT(ways); i++)
        for (uint32_t banded = 0; banded < 2; banded++) {
            if ((ways[i].depth > 0 && depth > ways[i].depth) ||
                (ways[i].quick > 0 && depth > ways[i].quick && !hard_thorough))
                continue;
            const double before = seconds();
            picture p =
                hard_render(instance, sc,
                            (strata_render_options){.width = width,
                                                    .height = height,
                                                    .use = ways[i].use,
                                                    .settings = ways[i].settings,
                                                    .setting_count = ways[i].settings[0] != NULL,
                                                    .bands = banded ? 2 + (uint32_t)i % 3 : 1,
                                                    .shuffle = banded ? 11 + (uint32_t)i : 0});
            if (!banded)
                tell(instance, what, i, seconds() - before, &p);
            if (!reference->pixels) {
                *reference = p;
                continue;
            }
            char text[192];
            snprintf(text, sizeof text, "%s on %s, %s %s, %s", what, instance->backend, ways[i].use,
                     ways[i].settings[0] ? ways[i].settings[0] : "",
                     banded ? "shuffled in bands" : "whole");
            picture_same(reference, &p, text);
            picture_free(&p);
        }
}

static void check_ways(strata *instance, strata_scene *sc, const hard_row *row,
                       const scene_hard_case *k, picture *reference) {
    strata_render_options options = {.width = k->width, .height = k->height};
    picture p = hard_render(instance, sc, options);
    const render_result *result = &instance->result;
    const uint32_t largest = (uint32_t)result->report.largest;
    if (row->depth != HARD_ANY && largest != (uint32_t)row->depth)
        fail_msg("%s on %s: %u fragments in one pixel, not %d", k->name, instance->backend, largest,
                 row->depth);
    if (row->fragments != HARD_ANY && result->report.total != (uint64_t)row->fragments)
        fail_msg("%s on %s: %llu fragments, not %lld", k->name, instance->backend,
                 (unsigned long long)result->report.total, (long long)row->fragments);
    if (reference->pixels)
        picture_same(reference, &p, k->name);
    picture_free(&p);
    hard_ways(instance, sc, k->name, largest, k->width, k->height, reference);
    for (options.shuffle = 1; options.shuffle <= row->orders; options.shuffle++) {
        char text[128];
        snprintf(text, sizeof text, "%s on %s in order %u", k->name, instance->backend,
                 options.shuffle);
        p = hard_render(instance, sc, options);
        picture_same(reference, &p, text);
        picture_free(&p);
    }
}

/* ---- the same triangles otherwise -------------------------------------------------------------
 */

/* Loads anew what `edit` changes, and renders it. */
static void check_edit(strata *instance, const scene_hard_case *k, void (*edit)(scene *s),
                       const char *what, const picture *reference) {
    char text[128];
    strata_scene *sc = picture_scene(instance, k->name);
    edit(sc->scene);
    picture p =
        hard_render(instance, sc,
                    (strata_render_options){.width = k->width, .height = k->height, .shuffle = 3});
    snprintf(text, sizeof text, "%s on %s, %s", k->name, instance->backend, what);
    picture_same(reference, &p, text);
    picture_free(&p);
    strata_scene_close(sc);
}

static void check_file(strata *instance, strata_scene *sc, const scene_hard_case *k,
                       const picture *reference) {
    char path[] = "/tmp/strata-hard-XXXXXX.glb", text[128];
    const int fd = mkstemps(path, 4);
    assert_true(fd >= 0);
    close(fd);
    if (strata_scene_save(sc, path) != STRATA_OK)
        fail_msg("%s: %s", k->name, strata_error(instance));
    strata_scene *loaded = picture_scene(instance, path);
    unlink(path);
    picture p = hard_render(instance, loaded,
                            (strata_render_options){.width = k->width, .height = k->height});
    snprintf(text, sizeof text, "%s on %s, from a file", k->name, instance->backend);
    picture_same(reference, &p, text);
    picture_free(&p);
    strata_scene_close(loaded);
}

/* ---- the same view from elsewhere -------------------------------------------------------------
 * A view of 90 degrees has a projection of ones, so that moving it loses no bit. */
static strata_camera_pose square_pose(strata_scene *sc, const scene_hard_case *k) {
    strata_camera_pose pose = {.struct_size = sizeof pose};
    assert_int_equal(k->width, k->height);
    if (strata_scene_camera(sc, NULL, k->width, k->height, &pose) != STRATA_OK)
        fail_msg("%s: no camera", k->name);
    pose.yfov = pose.height > 0 ? 0 : 90;
    return pose;
}

static picture posed(strata *instance, strata_scene *sc, const scene_hard_case *k,
                     const strata_camera_pose *pose) {
    return hard_render(
        instance, sc,
        (strata_render_options){.width = k->width, .height = k->height, .pose = pose});
}

static void check_translation(strata *instance, const scene_hard_case *k, const double move[2]) {
    strata_scene *sc = picture_scene(instance, k->name);
    hard_round(sc->scene);
    strata_camera_pose pose = square_pose(sc, k);
    picture still = posed(instance, sc, k, &pose);
    char text[128];
    for (uint32_t i = 0; i < sc->scene->instance_count; i++) {
        float world[16];
        memcpy(world, sc->scene->instances[i].world, sizeof world);
        for (int axis = 0; axis < 2; axis++)
            world[12 + axis] += (float)move[axis];
        assert_int_equal(strata_scene_set_transform(sc, i, world), STRATA_OK);
    }
    for (int axis = 0; axis < 2; axis++) {
        pose.eye[axis] += move[axis];
        pose.target[axis] += move[axis];
    }
    picture moved = posed(instance, sc, k, &pose);
    snprintf(text, sizeof text, "%s on %s, moved by (%g, %g)", k->name, instance->backend, move[0],
             move[1]);
    picture_same(&still, &moved, text);
    picture_free(&moved);
    picture_free(&still);
    strata_scene_close(sc);
}

/* Up becomes right: pixel (x, y) shows what (y, side - 1 - x) did, rows counted from the bottom. */
static void check_rotation(strata *instance, const scene_hard_case *k) {
    const uint32_t side = k->width;
    char text[128];
    strata_scene *sc = picture_scene(instance, k->name);
    strata_camera_pose pose = square_pose(sc, k);
    picture upright = posed(instance, sc, k, &pose);
    pose.up[0] = 1;
    pose.up[1] = pose.up[2] = 0;
    picture turned = posed(instance, sc, k, &pose);
    picture back = {side, side, malloc((size_t)side * side * sizeof(float[4]))};
    assert_non_null(back.pixels);
    for (uint32_t y = 0; y < side; y++) /* from the bottom, of the upright picture */
        for (uint32_t x = 0; x < side; x++) {
            const uint32_t at_x = side - 1 - y, at_y = x;
            memcpy(back.pixels + 4 * ((size_t)(side - 1 - y) * side + x),
                   turned.pixels + 4 * ((size_t)(side - 1 - at_y) * side + at_x), sizeof(float[4]));
        }
    snprintf(text, sizeof text, "%s on %s, turned", k->name, instance->backend);
    picture_same(&upright, &back, text);
    picture_free(&upright);
    picture_free(&turned);
    picture_free(&back);
    strata_scene_close(sc);
}

/* ---- the oracles ------------------------------------------------------------------------------
 */

/* With the cases that have pixels without a certificate: colours beyond what the payload can hold.
 */
static const struct {
    const char *use, *settings[3];
    uint32_t bands;
    const char *open[5];
} certified[] = {
    {"abuffer,ppc", {"abuffer.payload=float"}, 0, {NULL}},
    {"abuffer,ppc",
     {"abuffer.mode=linked", "abuffer.payload=half"},
     3,
     {"hdr-million", "alpha-next-to-1"}},
    {"abuffer,ppc",
     {"abuffer.payload=unorm8"},
     0,
     {"hdr-65504", "hdr-million", "negative", "alpha-next-to-1"}},
    {"abuffer,fpc", {"fpc.mode=fragments"}, 0, {NULL}},
    {"abuffer,fpc", {"fpc.mode=hybrid"}, 2, {NULL}},
    {"kplus,ppc", {"kplus.k=4"}, 0, {NULL}},
    {"peel", {"peel.layers=3"}, 0, {NULL}},
};

static int may_be_open(size_t at, const char *name) {
    for (size_t i = 0; certified[at].open[i]; i++)
        if (strstr(name, certified[at].open[i]))
            return 1;
    return 0;
}

/* The second backend does the same arithmetic; it gets every other one. */
static void check_fold(strata *instance, strata_scene *sc, const scene_hard_case *k, size_t step) {
    const oracle_case frame = {ORACLE_FRAME(k->name, k->width, k->height)};
    oracle_exact exact = oracle_exact_make(instance, sc, &frame);
    for (size_t i = 0; i < BASE_COUNT(certified); i += step) {
        char what[128];
        snprintf(what, sizeof what, "%s on %s, %s %s", k->name, instance->backend, certified[i].use,
                 certified[i].settings[0]);
        oracle_certify(instance, sc, &frame, certified[i].use, certified[i].settings,
                       certified[i].bands);
        oracle_tally tally = oracle_hold(instance, &exact, what);
        if ((tally.uncertified > 0) != may_be_open(i, k->name))
            fail_msg("%s: %llu pixels have no certificate", what,
                     (unsigned long long)tally.uncertified);
        oracle_tally_free(&tally);
    }
    oracle_exact_free(&exact);
}

static void check_rays(strata *instance, strata_scene *sc, const scene_hard_case *k) {
    const oracle_case frame = {ORACLE_FRAME(k->name, k->width, k->height)};
    oracle_capture c;
    oracle_verdict v;
    oracle_capture_frame(instance, sc, &frame, &c);
    oracle_judge(&c, &v);
    oracle_capture_free(&c);
    if (v.judged == 0 && v.edge + v.hidden_or_not > 0)
        fail_msg("%s on %s: no fragment could be judged", k->name, instance->backend);
    if (v.missing + v.surplus + v.misplaced + v.disordered + v.opaque_wrong + v.seam_wrong)
        fail_msg("%s on %s: %llu missing, %llu surplus, %llu misplaced, %llu disordered, %llu "
                 "opaque depths, %llu seams; first: %s",
                 k->name, instance->backend, (unsigned long long)v.missing,
                 (unsigned long long)v.surplus, (unsigned long long)v.misplaced,
                 (unsigned long long)v.disordered, (unsigned long long)v.opaque_wrong,
                 (unsigned long long)v.seam_wrong, v.first);
}

/* ---- a row ------------------------------------------------------------------------------------
 */

static void check_refused(strata *instance, const scene_hard_case *k) {
    char line[128];
    strata_scene *sc = NULL;
    snprintf(line, sizeof line, "%s: mesh 'broken': position[1] is not finite", k->name);
    assert_int_equal(strata_scene_load(instance, k->name, &sc), STRATA_ERROR_BAD_FILE);
    assert_string_equal(strata_error(instance), line);
}

/* Both backends give the same bits, so that each checks half of what is not about backends. */
static void check_scene(strata *instance, size_t backend, const hard_row *row,
                        const scene_hard_case *k, picture *reference) {
    static const double moves[2][2] = {{4, -8}, {-16, 0.5}};
    strata_scene *sc = picture_scene(instance, k->name);
    check_ways(instance, sc, row, k, reference);
    if (row->holds & HARD_SPLIT)
        check_edit(instance, k, backend ? hard_merge : hard_split, backend ? "merged" : "split",
                   reference);
    if ((row->holds & HARD_FILE) && !backend)
        check_file(instance, sc, k, reference);
    if (row->holds & HARD_TRANSLATE)
        check_translation(instance, k, moves[backend]);
    if (row->holds & HARD_ROTATE)
        check_rotation(instance, k);
    if (row->holds & HARD_FOLD)
        check_fold(instance, sc, k, 1 + backend);
    if (row->holds & HARD_RAY)
        check_rays(instance, sc, k);
    if (row->also)
        row->also(instance, sc, row);
    strata_scene_close(sc);
}

void hard_check(const hard_row *row) {
    const scene_hard_case *k = hard_case(row->name);
    picture reference = {0};
    size_t opened = 0;
    for (size_t b = 0; b < BASE_COUNT(hard_backends); b++) {
        strata *instance = picture_instance(hard_backends[b]);
        if (!instance)
            continue;
        opened++;
        if (row->holds & HARD_REFUSED)
            check_refused(instance, k);
        else
            check_scene(instance, b, row, k, &reference);
    }
    picture_free(&reference);
    if (!opened)
        skip();
}
