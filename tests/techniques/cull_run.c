/* SPDX-License-Identifier: MIT
 *
 * A case of cull_scenes.h, frame by frame: edits, the two renders, and what must hold.
 */
#include "techniques/cull_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "render/render.h"

typedef struct run {
    const cull_case *c;
    cull_rig *rig;
    strata_scene *scenes[2]; /* culled, plain */
    cull_random random;
    uint32_t width, height, frame;
    strata_render_options options;
    const char *settings[8];
    uint32_t exact;   /* surface.ties */
    float *pixels[4]; /* color and depth of each */
    cull_counts *counts;
} run;

int cull_open(const char *backend, int check, cull_rig *rig) {
    const strata_open_options options = {
        .struct_size = sizeof options, .backend = backend, .check = (uint32_t)check};
    const strata_render_options tiny = {.struct_size = sizeof tiny, .width = 4, .height = 4};
    strata **all[2] = {&rig->culled, &rig->plain};
    *rig = (cull_rig){0};
    for (int i = 0; i < 2; ++i) {
        strata_scene *sc = NULL;
        if (strata_open(&options, all[i]) != STRATA_OK ||
            strata_scene_load(*all[i], "scene:layers?count=0", &sc) != STRATA_OK ||
            strata_render(*all[i], sc, &tiny) != STRATA_OK) { /* opens the device */
            cull_close(rig);
            return 0;
        }
        strata_scene_close(sc);
    }
    return 1;
}

void cull_close(cull_rig *rig) {
    strata_close(rig->culled);
    strata_close(rig->plain);
    *rig = (cull_rig){0};
}

/* ---- what changes from frame to frame -------------------------------------------------------- */

static void set_size(run *r) {
    static const uint32_t sizes[][2] = {{1, 1},   {2, 1},     {2, 2},     {3, 5},      {5, 3},
                                        {17, 17}, {33, 19},   {64, 48},   {97, 61},    {31, 128},
                                        {5, 257}, {257, 129}, {641, 479}, {1919, 1079}};
    const uint32_t dice = cull_below(&r->random, 100);
    uint32_t i = cull_below(&r->random, 11);
    if (r->c->large && dice < 8) /* rarely: they take long */
        i = dice < 1 ? 13 : dice < 3 ? 12 : 11;
    r->width = sizes[i][0];
    r->height = sizes[i][1];
}

static void set_both(run *r, uint32_t instance, const float world[16]) {
    for (int i = 0; i < 2; ++i)
        strata_scene_set_transform(r->scenes[i], instance, world);
}

static void move_hole(run *r) {
    float wall[CULL_WALL][16], world[16];
    const uint32_t pixels = r->width * r->height;
    uint32_t x = cull_below(&r->random, r->width), y = cull_below(&r->random, r->height);
    if (r->c->sweep_holes) {
        x = r->frame % pixels % r->width;
        y = r->frame % pixels / r->width;
    } else if (cull_below(&r->random, 3) == 0) { /* the last column and row */
        x = r->width - 1;
        y = cull_below(&r->random, 2) ? r->height - 1 : y;
    }
    cull_wall(r->width, r->height, x, y, wall);
    for (uint32_t i = 0; i < CULL_WALL; ++i)
        set_both(r, i, wall[i]);
    for (uint32_t i = CULL_WALL; i < r->c->objects; ++i) {
        cull_behind(&r->random, r->width, r->height, x, y, world);
        set_both(r, i, world);
    }
}

static void edit(run *r) {
    const cull_case *c = r->c;
    if (c->kind == CULL_HOLES)
        move_hole(r);
    for (uint32_t i = c->kind == CULL_DEFORM ? 2 : 0; i < c->objects && r->frame > 0; ++i) {
        const uint32_t dice = cull_below(&r->random, 24);
        if (dice == 0 && c->kind != CULL_HOLES)
            set_both(r, i, cull_place(c, &r->random, i).world);
        for (int k = 0; k < 2 && dice >= 21 && i >= CULL_WALL; ++k)
            strata_scene_set_visible(r->scenes[k], i, dice == 21 ? 0 : 1);
    }
    for (int k = 0; k < 2 && c->kind == CULL_DEFORM; ++k)
        strata_scene_set_time(r->scenes[k], r->frame * 0.7);
}

static void set_options(run *r) {
    static const char *const histories[] = {"hiz.history=keep", "hiz.history=none",
                                            "hiz.history=all", "hiz.history=random"};
    static const char *const taps[] = {"hiz.taps=2", "hiz.taps=4", "hiz.taps=8"};
    uint32_t count = 0;
    const uint32_t history = cull_below(&r->random, 6), tap = cull_below(&r->random, 3);
    r->exact = cull_below(&r->random, 2);
    r->settings[count++] = r->exact ? "surface.ties=exact" : "surface.ties=any";
    const uint32_t shared = count;
    for (uint32_t i = 0; i < 4 && r->c->settings[i]; ++i)
        r->settings[count++] = r->c->settings[i];
    if (count == shared) {
        r->settings[count++] = histories[history < 4 ? history : 0];
        r->settings[count++] = taps[tap];
    }
    r->options = (strata_render_options){.struct_size = sizeof r->options,
                                         .outputs = STRATA_OUTPUT_DEPTH,
                                         .settings = r->settings,
                                         .setting_count = count,
                                         .samples = cull_below(&r->random, 6) ? 1 : 4,
                                         .bands = 1 + 2 * (cull_below(&r->random, 5) == 0),
                                         .shuffle = cull_below(&r->random, 4) == 0 ? 7 : 0};
}

/* ---- what must hold -------------------------------------------------------------------------- */

static void __attribute__((format(printf, 2, 3))) fails(run *r, const char *format, ...) {
    va_list arguments;
    char what[160];
    va_start(arguments, format);
    vsnprintf(what, sizeof what, format, arguments);
    va_end(arguments);
    if (!r->counts->failure[0])
        snprintf(r->counts->failure, sizeof r->counts->failure,
                 "%s, seed %llu, frame %u, %ux%u: %s", cull_kind_names[r->c->kind],
                 (unsigned long long)r->c->seed, r->frame, r->width, r->height, what);
}

/* Depths are equal bit for bit, and so are colours but for counted ties. */
static void compare(run *r, uint64_t overshot) {
    const size_t pixels = (size_t)r->width * r->height;
    for (size_t i = 0; i < pixels; ++i) {
        const int depth = memcmp(r->pixels[1] + 4 * i, r->pixels[3] + 4 * i, sizeof(float)),
                  color = memcmp(r->pixels[0] + 4 * i, r->pixels[2] + 4 * i, 4 * sizeof(float));
        if ((depth || color) && overshot > 0)
            r->counts->lost_pixels++;
        else if (depth)
            fails(r, "depth at %zu is %a, not %a", i, (double)r->pixels[1][4 * i],
                  (double)r->pixels[3][4 * i]);
        else if (color && r->exact)
            fails(r, "another colour at pixel %zu", i);
        else
            r->counts->ties += color != 0;
    }
}

static void account(run *r) {
    const render_report *report = &r->rig->culled->session->report;
    cull_counts *n = r->counts;
    const uint64_t objects = upload_count(r->rig->culled->session->upload).objects;
    n->frames++;
    n->object_frames += report->objects;
    n->overshot += report->overshot;
    n->visible += report->visible;
    n->outside += report->outside;
    n->slipped += report->slipped;
    n->occluded += report->occluded;
    n->late += report->late;
    if (report->objects != objects)
        fails(r, "%llu objects are accounted for, there are %llu",
              (unsigned long long)report->objects, (unsigned long long)objects);
    const uint64_t culled = report->outside + report->slipped + report->occluded;
    if (culled + report->late > objects || report->visible > objects - culled)
        fails(r,
              "of %llu objects %llu are outside, %llu slip, %llu occluded, %llu late, %llu visible",
              (unsigned long long)objects, (unsigned long long)report->outside,
              (unsigned long long)report->slipped, (unsigned long long)report->occluded,
              (unsigned long long)report->late, (unsigned long long)report->visible);
}

static int read_back(run *r) {
    const size_t size = (size_t)r->width * r->height * 4 * sizeof(float);
    strata *of[2] = {r->rig->culled, r->rig->plain};
    int done = 1;
    for (int i = 0; i < 4; ++i) {
        float *grown = realloc(r->pixels[i], size);
        r->pixels[i] = grown ? grown : r->pixels[i];
        done = done && grown &&
               strata_read(of[i / 2], i % 2 ? STRATA_OUTPUT_DEPTH : STRATA_OUTPUT_COLOR, grown,
                           size) == STRATA_OK;
    }
    return done;
}

static void one_frame(run *r, cull_frame_fn each, void *user) {
    cull_random jump = r->random;
    const uint32_t dice = cull_below(&r->random, 10);
    if (r->frame > 0 && dice < 3 && !r->c->sweep_holes)
        set_size(r);
    edit(r);
    if (r->frame > 0 && dice >= 8) /* the camera stays */
        jump = r->c->seed;
    const strata_camera_pose pose = cull_pose(r->c, &jump, r->height);
    r->options.width = r->width;
    r->options.height = r->height;
    r->options.pose = &pose;
    if (r->c->kind == CULL_HOLES)
        r->options.samples = 1; /* a pixel of the wall is one of depth/1 */
    strata_render_options plain = r->options;
    plain.use = "surface,abuffer,ppc";
    plain.setting_count = 1;
    r->options.use = "surface,hiz,cullcheck,abuffer,ppc";
    if (strata_render(r->rig->culled, r->scenes[0], &r->options) != STRATA_OK) {
        unsigned wrong = 0;
        const char *line = strata_error(r->rig->culled);
        if (sscanf(line, "cullcheck: %u of", &wrong) == 1)
            r->counts->wrong += wrong;
        fails(r, "%s", line);
    } else if (strata_render(r->rig->plain, r->scenes[1], &plain) != STRATA_OK) {
        fails(r, "%s", strata_error(r->rig->plain));
    } else if (!read_back(r)) {
        fails(r, "it cannot be read back");
    } else {
        account(r);
        compare(r, r->rig->culled->session->report.overshot);
        if (each)
            each(user, r->rig->culled);
    }
    r->options.pose = NULL;
}

void cull_run(cull_rig *rig, const cull_case *c, cull_counts *counts, cull_frame_fn each,
              void *user) {
    run r = {.c = c, .rig = rig, .random = c->seed, .counts = counts};
    r.scenes[0] = cull_scene(rig->culled, c);
    r.scenes[1] = cull_scene(rig->plain, c);
    set_options(&r);
    set_size(&r);
    if (c->width) {
        r.width = c->width;
        r.height = c->height;
    }
    if (!r.scenes[0] || !r.scenes[1])
        fails(&r, "%s", strata_error(r.scenes[0] ? rig->plain : rig->culled));
    for (r.frame = 0; r.frame < c->frames && !counts->failure[0]; ++r.frame)
        one_frame(&r, each, user);
    for (int i = 0; i < 2; ++i)
        strata_scene_close(r.scenes[i]);
    for (int i = 0; i < 4; ++i)
        free(r.pixels[i]);
}
