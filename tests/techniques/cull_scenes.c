/* SPDX-License-Identifier: MIT
 *
 * The scenes: six meshes, instanced by matrices that each kind draws in its own way.
 */
#define _DEFAULT_SOURCE
#include "techniques/cull_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scenes/glb.h"

const char *const cull_kind_names[CULL_KINDS] = {"holes",   "near",     "random", "coplanar",
                                                 "slivers", "clusters", "glass",  "deform"};

/* ---- random numbers: splitmix64 -------------------------------------------------------------- */

uint64_t cull_bits(cull_random *random) {
    uint64_t z = *random += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return z ^ (z >> 31);
}

uint32_t cull_below(cull_random *random, uint32_t count) {
    return (uint32_t)((cull_bits(random) >> 32) * count >> 32);
}

double cull_between(cull_random *random, double low, double high) {
    return low + (high - low) * (double)(cull_bits(random) >> 11) * 0x1p-53;
}

/* ---- meshes ---------------------------------------------------------------------------------- */

enum { BALL_ROWS = 12, BALL_COLUMNS = 24, MOST_VERTICES = BALL_ROWS * BALL_COLUMNS * 6 };

typedef struct mesh {
    float positions[MOST_VERTICES][3], colors[MOST_VERTICES][4];
    uint32_t count;
} mesh;

static void add_vertex(mesh *m, cull_random *random, double x, double y, double z, double alpha) {
    float *p = m->positions[m->count], *c = m->colors[m->count++];
    p[0] = (float)x;
    p[1] = (float)y;
    p[2] = (float)z;
    for (int i = 0; i < 3; ++i)
        c[i] = (float)cull_between(random, 0.1, 0.9);
    c[3] = (float)alpha;
}

static void add_box(mesh *m, cull_random *random, double alpha) {
    static const int corners[6] = {0, 1, 2, 0, 2, 3};
    for (int face = 0; face < 6; ++face)
        for (int i = 0; i < 6; ++i) {
            static const double square[4][2] = {{-.5, -.5}, {.5, -.5}, {.5, .5}, {-.5, .5}};
            const double *q = square[corners[i]], out = face % 2 ? 0.5 : -0.5;
            double p[3];
            p[face / 2] = out;
            p[(face / 2 + 1) % 3] = q[0];
            p[(face / 2 + 2) % 3] = q[1];
            add_vertex(m, random, p[0], p[1], p[2], alpha);
        }
}

static void add_quad(mesh *m, cull_random *random) {
    static const double square[6][2] = {{-.5, -.5}, {.5, -.5}, {.5, .5},
                                        {-.5, -.5}, {.5, .5},  {-.5, .5}};
    for (int i = 0; i < 6; ++i)
        add_vertex(m, random, square[i][0], square[i][1], 0, 1);
}

static void ball_vertex(mesh *m, cull_random *random, int row, int column, double alpha) {
    const double polar = 3.14159265358979 * row / BALL_ROWS,
                 around = 6.28318530717959 * (column % BALL_COLUMNS) / BALL_COLUMNS;
    const double radius = 0.5 - 0.05 * ((row * 7 + column % BALL_COLUMNS * 3) % 5);
    add_vertex(m, random, radius * sin(polar) * cos(around), radius * cos(polar),
               radius * sin(polar) * sin(around), alpha);
}

static void add_ball(mesh *m, cull_random *random, double alpha) {
    static const int corners[6][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    for (int row = 0; row < BALL_ROWS; ++row)
        for (int column = 0; column < BALL_COLUMNS; ++column)
            for (int i = 0; i < 6; ++i)
                ball_vertex(m, random, row + corners[i][0], column + corners[i][1], alpha);
}

static void add_needle(mesh *m, cull_random *random) {
    add_vertex(m, random, -0.5, 0, 0, 1);
    add_vertex(m, random, 0.5, 0, 0, 1);
    add_vertex(m, random, 0.5, 1e-3, 0, 1);
}

/* Accessors 2 mesh and 2 mesh + 1. */
static void add_meshes(test_glb *g, cull_random *random) {
    mesh *m = malloc(sizeof *m);
    for (int i = 0; m && i < CULL_MESHES; ++i) {
        const double alpha = i == CULL_GLASS_BOX || i == CULL_GLASS_BALL ? 0.4 : 1;
        m->count = 0;
        if (i == CULL_QUAD || i == CULL_OTHER_QUAD)
            add_quad(m, random);
        else if (i == CULL_BALL || i == CULL_GLASS_BALL)
            add_ball(m, random, alpha);
        else if (i == CULL_NEEDLE)
            add_needle(m, random);
        else
            add_box(m, random, alpha);
        test_glb_floats(g, "VEC3", 3, m->count, m->positions[0]);
        test_glb_floats(g, "VEC4", 4, m->count, m->colors[0]);
    }
    free(m);
}

/* ---- the file -------------------------------------------------------------------------------- */

/* One morph target that carries a box away, and a skin of one joint that does the same. */
static void add_deformation(test_glb *g) {
    enum { BOX = 36 };
    static const float times[2] = {0, 8}, values[2] = {0, 1}, far[6] = {0, 0, 0, 9, 3, -2};
    static const unsigned char joints[BOX * 4];
    float away[BOX][3], weights[BOX][4];
    for (int i = 0; i < BOX; ++i) {
        memcpy(away[i], (float[3]){-6, 2, i % 2 ? 3 : -3}, sizeof away[i]);
        memcpy(weights[i], (float[4]){1, 0, 0, 0}, sizeof weights[i]);
    }
    const uint32_t first = g->accessor_count; /* 2 * CULL_MESHES */
    test_glb_floats(g, "VEC3", 3, BOX, away[0]);
    test_glb_floats(g, "VEC4", 4, BOX, weights[0]);
    test_glb_accessor(g, test_glb_view(g, joints, sizeof joints, 0), TEST_GLB_U8, "VEC4", BOX, "");
    test_glb_floats(g, "SCALAR", 1, 2, times);
    test_glb_floats(g, "SCALAR", 1, 2, values);
    test_glb_floats(g, "VEC3", 3, 2, far);
    test_glb_json(
        g,
        "\"skins\":[{\"joints\":[0]}],\"animations\":[{\"samplers\":[{\"input\":%u,"
        "\"output\":%u},{\"input\":%u,\"output\":%u}],\"channels\":[{\"sampler\":0,"
        "\"target\":{\"node\":1,\"path\":\"weights\"}},{\"sampler\":1,\"target\":{\"node\":"
        "0,\"path\":\"translation\"}}]}]",
        first + 3, first + 4, first + 3, first + 5);
}

static void add_materials(test_glb *g) {
    static const char unlit[] = "\"doubleSided\":true,\"extensions\":{\"KHR_materials_unlit\":{}}";
    base_text meshes = {0};
    for (uint32_t i = 0; i < CULL_MESHES; ++i)
        base_text_add(&meshes,
                      "%s{\"primitives\":[{\"attributes\":{\"POSITION\":%u,\"COLOR_0\":%u},"
                      "\"material\":%d}]}",
                      i ? "," : "", 2 * i, 2 * i + 1, i == CULL_GLASS_BOX || i == CULL_GLASS_BALL);
    base_text_add(&meshes,
                  ",{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1},\"material\":0,"
                  "\"targets\":[{\"POSITION\":%u}]}],\"weights\":[0]},{\"primitives\":[{"
                  "\"attributes\":{\"POSITION\":0,\"COLOR_0\":1,\"WEIGHTS_0\":%u,\"JOINTS_0\":%u},"
                  "\"material\":0}]}",
                  2 * CULL_MESHES, 2 * CULL_MESHES + 1, 2 * CULL_MESHES + 2);
    test_glb_json(g,
                  "\"extensionsUsed\":[\"KHR_materials_unlit\"],\"materials\":[{%s},{\"alphaMode\":"
                  "\"BLEND\",%s}]",
                  unlit, unlit);
    test_glb_json(g, "\"meshes\":[%s]", meshes.data);
    base_text_free(&meshes);
}

/* Node 0 is the joint; instances follow. In all kinds but CULL_DEFORM nothing deforms. */
static unsigned char *make_file(const cull_case *c, size_t *size) {
    cull_random random = c->seed * 31 + (uint64_t)c->kind;
    test_glb g = {0};
    base_text nodes = {0}, roots = {0};
    add_meshes(&g, &random);
    add_deformation(&g);
    add_materials(&g);
    base_text_add(&nodes, "{}");
    base_text_add(&roots, "0");
    for (uint32_t i = 0; i < c->objects; ++i) {
        cull_instance in = cull_place(c, &random, i);
        base_text_add(&roots, ",%u", i + 1);
        if (c->kind == CULL_DEFORM && i < 2) {
            base_text_add(&nodes, ",{\"mesh\":%d%s}", CULL_MESHES + (int)i, i ? ",\"skin\":0" : "");
            continue;
        }
        base_text_add(&nodes, ",{\"mesh\":%u,\"matrix\":[", in.mesh);
        for (int k = 0; k < 16; ++k)
            base_text_add(&nodes, "%s%.9g", k ? "," : "", (double)in.world[k]);
        base_text_add(&nodes, "]}");
    }
    base_text_add(&g.rest, ",\"nodes\":[%s],\"scene\":0,\"scenes\":[{\"nodes\":[%s]}]", nodes.data,
                  roots.data);
    base_text_free(&nodes);
    base_text_free(&roots);
    return test_glb_finish(&g, size);
}

strata_scene *cull_scene(strata *instance, const cull_case *c) {
    char path[] = "/tmp/strata-cull-XXXXXX.glb";
    size_t size = 0;
    strata_scene *sc = NULL;
    unsigned char *file = make_file(c, &size);
    const int fd = mkstemps(path, 4);
    if (fd >= 0 && write(fd, file, size) == (ssize_t)size)
        strata_scene_load(instance, path, &sc);
    if (fd >= 0) {
        close(fd);
        unlink(path);
    }
    free(file);
    return sc;
}
