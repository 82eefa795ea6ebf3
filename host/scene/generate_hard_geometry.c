/* SPDX-License-Identifier: MIT
 *
 * Hard cases of geometry: what projection, clipping, coverage and depth find difficult. Where a
 * case does not forbid it, coordinates are multiples of 1/256, which translation keeps exact.
 */
#include "scene/generate_hard.h"

#include <math.h>

static const double origin[3] = {0, 0, 0}, forwards[3] = {0, 0, -1}, before[3] = {0, 0, 3};

/* corner: x, y and z of each. */
static void triangle(generate_mesh *mesh, const double corner[9]) {
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (int i = 0; i < 9; i += 3)
        generate_vertex(mesh, corner[i], corner[i + 1], corner[i + 2]);
    generate_triangle(mesh, first, first + 1, first + 2);
}

/* `count` triangles with corners in a box of half extents `reach` about the origin. */
static void scatter(generate_builder *b, generate_mesh *mesh, int count, const double reach[3]) {
    for (int i = 0; i < count; i++) {
        double corner[9];
        for (int k = 0; k < 9; k++)
            corner[k] = generate_hard_between(b, -reach[k % 3], reach[k % 3]);
        triangle(mesh, corner);
    }
}

/* ---- crossing ---------------------------------------------------------------------------------
 */

/* Three bars, each before the next and behind the one before: no order of drawing is right. */
static void ring(generate_mesh *mesh) {
    for (int i = 0; i < 3; i++) {
        double s, c, corner[9];
        generate_turn(i / 3.0, &s, &c);
        const double at[3][3] = {{-0.75, 0.5, 0.25}, {0.9375, 0.375, -0.25}, {0.875, 0.625, -0.25}};
        for (int k = 0; k < 3; k++) {
            corner[3 * k] = floor((at[k][0] * c - at[k][1] * s) * 256) / 256;
            corner[3 * k + 1] = floor((at[k][0] * s + at[k][1] * c) * 256) / 256;
            corner[3 * k + 2] = at[k][2];
        }
        triangle(mesh, corner);
    }
}

void generate_hard_crossing(generate_builder *b) {
    static const double colors[5][4] = {{0.9, 0.3, 0.2, 0.5},
                                        {0.2, 0.8, 0.4, 0.375},
                                        {0.6, 0.6, 0.5, 1},
                                        {0.2, 0.4, 0.9, 0.25},
                                        {0.9, 0.8, 0.3, 0.5}};
    const double reach[3] = {1.25, 1.25, 1.25}, inner[3] = {0.75, 0.75, 1.25};
    for (int i = 0; i < 5; i++) {
        const double *c = colors[i];
        scene_material material = generate_hard_material(c[0], c[1], c[2], c[3]);
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
        if (i == 4)
            ring(&mesh);
        scatter(b, &mesh, i == 2 ? 2 : 8, i == 2 ? inner : reach);
        generate_hard_show(&mesh, i == 2 ? "wall" : "glass", &material);
    }
    generate_camera(b, "front", before, origin, 60, 0.5, 16);
}

/* ---- slivers ----------------------------------------------------------------------------------
 */

static void sliver(generate_builder *b, generate_mesh *mesh, int i) {
    double corner[9];
    for (int k = 0; k < 2; k++) {
        corner[3 * k] = generate_hard_between(b, -1, 1);
        corner[3 * k + 1] = generate_hard_between(b, -1, 1);
        corner[3 * k + 2] = generate_hard_between(b, -1.5, 1.5);
    }
    const int kind = i % 16;
    for (int k = 0; k < 3; k++) /* on the line, between its ends */
        corner[6 + k] = (corner[k] + corner[3 + k]) / 2;
    if (kind > 2)
        corner[6] += i / 1024.0; /* up to an eighth */
    for (int k = 0; k < 3; k++) {
        corner[6 + k] = kind == 1 || kind == 2 ? corner[k] : corner[6 + k];
        corner[3 + k] = kind == 2 ? corner[k] : corner[3 + k];
    }
    triangle(mesh, corner);
}

void generate_hard_slivers(generate_builder *b) {
    scene_material material = generate_hard_material(0.9, 0.7, 0.3, 0.5);
    scene_material glass = generate_hard_material(0.2, 0.5, 0.9, 0.375);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    for (int i = 0; i < 128; i++)
        sliver(b, &mesh, i);
    generate_hard_show(&mesh, "slivers", &material);
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    scatter(b, &mesh, 4, (const double[3]){1, 1, 1});
    generate_hard_show(&mesh, "glass", &glass);
    generate_camera(b, "front", before, origin, 60, 0.5, 16);
}

/* ---- the near plane ---------------------------------------------------------------------------
 */

void generate_hard_near_plane(generate_builder *b) {
    static const double corners[][9] = {
        {0, 0, -0.125, -2, 1, -4, 1, 2, -4},                               /* one on the plane */
        {-0.0625, 0, -0.125, 0.0625, 0, -0.125, 0, -2, -4},                /* an edge on it */
        {-0.125, -0.125, -0.125, 0.125, -0.125, -0.125, 0, 0.125, -0.125}, /* all of it */
        {0.5, 0.25, 0, -1, -1, -2, 2, -1, -2},                             /* w = 0 */
        {0, 0, 0, -1, 0.5, -2, 1, 0.75, -2},                               /* the eye itself */
        {-0.5, 0, 0, 0.5, 0, 0, 0, 0.5, -3},                               /* an edge at w = 0 */
        {0, 1, 1, -1, -1, -3, 1, -1, -3},                                  /* behind the eye */
        {-3, 0.25, 2, 3, 0.5, 2, 0, -0.25, -6},                            /* two behind it */
        {-1, -1, 2, 1, -1, 2, 0, 1, 1},                                    /* all behind it */
        {-1, -1, 0, 1, -1, 0, 0, 1, 0},                                    /* all at w = 0 */
    };
    scene_material sharp = generate_hard_material(0.9, 0.4, 0.2, 0.5);
    scene_material glass = generate_hard_material(0.2, 0.5, 0.9, 0.25);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    for (size_t i = 0; i < BASE_COUNT(corners); i++)
        triangle(&mesh, corners[i]);
    generate_hard_show(&mesh, "near", &sharp);
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    scatter(b, &mesh, 16, (const double[3]){2, 2, 3});
    generate_hard_show(&mesh, "around", &glass);
    generate_camera(b, "inside", origin, forwards, 60, 0.125, 0);
}

/* ---- scales -----------------------------------------------------------------------------------
 */

void generate_hard_huge(generate_builder *b) {
    static const double corners[][9] = {
        {-1e30, -1e30, -1e30, 1e30, -1e30, -1e30, 0, 1e30, -1e30},
        {-2, -2, -2, 1e30, 0, -1e30, 0, 1e30, -1e30},
        {1, -1, -2, -1e15, 1e15, -1e15, 1e30, 1e29, -1e30},
        {-1, -0.5, -2, 1, -0.5, -2, 0, 1, -2},
        {-1e20, 0, -3e20, 1e20, -1e20, -3e20, 1e20, 1e20, -2e20},
    };
    for (size_t i = 0; i < BASE_COUNT(corners); i++) {
        float color[3];
        generate_hue(0.19 * (double)i, color);
        scene_material material =
            generate_hard_material((double)color[0], (double)color[1], (double)color[2], 0.5);
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
        triangle(&mesh, corners[i]);
        generate_hard_show(&mesh, "huge", &material);
    }
    generate_camera(b, "front", origin, forwards, 60, 1, 0);
}

void generate_hard_tiny(generate_builder *b) {
    scene_material material = generate_hard_material(0.3, 0.8, 0.5, 0.375);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    for (int i = 0; i < 16; i++) {
        double corner[9];
        for (int k = 0; k < 9; k++)
            corner[k] =
                1e-30 * generate_between(&b->random, k % 3 == 2 ? -1.9 : -1, k % 3 == 2 ? -0.1 : 1);
        triangle(&mesh, corner);
    }
    generate_hard_show(&mesh, "tiny", &material);
    generate_camera_flat(b, 1e-30, 1e-30, 2e-30);
}

void generate_hard_depth_range(generate_builder *b) {
    static const double steps[3] = {1, 1 + 0x1p-20, 1.5};
    double scale = 1e-5;
    for (int i = 0; i < 15; i++, scale *= 10) { /* the last lies beyond the far plane */
        float color[3];
        generate_hue(0.14 * i, color);
        scene_material material =
            generate_hard_material((double)color[0], (double)color[1], (double)color[2], 0.25);
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
        for (int k = 0; k < 3; k++) {
            double z = scale * steps[k], x = z * (0.05 * i - 0.5), y = z * (0.1 * k - 0.4);
            generate_hard_quad(&mesh, (const double[4]){x, y, x + z * 0.4, y + z * 0.6}, -z);
        }
        generate_hard_show(&mesh, "far and near", &material);
    }
    generate_camera(b, "front", origin, forwards, 60, 1e-6, 1e9);
}

/* ---- coverage ---------------------------------------------------------------------------------
 */

/* For 32 x 32 pixels: corners at every other pixel's centre, the diagonals through those between,
 * turned by turns. */
static void centred_grid(generate_mesh *mesh, double z) {
    for (int y = 0; y < 17; y++)
        for (int x = 0; x < 17; x++) {
            double left = (4 * x - 1) / 32.0 - 1, low = (4 * y - 1) / 32.0 - 1;
            uint32_t a = generate_vertex(mesh, left, low, z), turned = (uint32_t)(x + y) % 2;
            generate_vertex(mesh, left + 0.125, low, z);
            generate_vertex(mesh, left + 0.125, low + 0.125, z);
            generate_vertex(mesh, left, low + 0.125, z);
            generate_triangle(mesh, a + turned, a + turned + 1, a + turned + 2);
            generate_triangle(mesh, a + turned, a + turned + 2, a + (turned + 3) % 4);
        }
}

/* Spokes from a pixel's centre to beyond the image, through many other centres. */
static void centred_fan(generate_mesh *mesh, double z) {
    const double x = 1 / 32.0, y = 1 / 32.0;
    const uint32_t hub = generate_vertex(mesh, x, y, z);
    for (int i = 0; i < 64; i++) {
        const double along = (i % 16) / 4.0 - 2;
        static const double side[4][4] = {
            {0, 2, 1, 0}, {-1, 0, 0, 2}, {0, -2, -1, 0}, {1, 0, 0, -2}};
        const double *s = side[i / 16];
        generate_vertex(mesh, x + s[0] * along + s[1], y + s[2] * along + s[3], z);
    }
    for (uint32_t i = 0; i < 64; i++)
        generate_triangle(mesh, hub, hub + 1 + i, hub + 1 + (i + 1) % 64);
}

void generate_hard_shared_edges(generate_builder *b) {
    scene_material cell = generate_hard_material(0.4, 0.6, 0.8, 0.5);
    scene_material spoke = generate_hard_material(0.8, 0.5, 0.2, 0.25);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    centred_grid(&mesh, -0.5);
    uint32_t material = generate_material(b, "cells", &cell);
    uint32_t cells = generate_mesh_end(&mesh, "cells", material);
    generate_instance_here(b, cells);
    generate_instance(b, cells, (const double[3]){0, 0, 0.25}, (const double[3]){-1, 1, 1});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    centred_fan(&mesh, -0.75);
    generate_hard_show(&mesh, "spokes", &spoke);
    generate_camera_flat(b, 1, 1, 1);
}

/* For 48 x 48 pixels, of 1/24 each; some heaps, so that some pixels hold many. */
void generate_hard_dust(generate_builder *b) {
    scene_material material = generate_hard_material(0.9, 0.8, 0.6, 0.25);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_mesh_reserve(&mesh, 60000, 60000);
    for (int i = 0; i < 20000; i++) {
        const double spread = i % 2 ? 1 : 0.125;
        const double x = generate_between(&b->random, -spread, spread);
        const double y = generate_between(&b->random, -spread, spread);
        double corner[9];
        for (int k = 0; k < 3; k++) {
            corner[3 * k] = x + generate_between(&b->random, -0.01, 0.01);
            corner[3 * k + 1] = y + generate_between(&b->random, -0.01, 0.01);
            corner[3 * k + 2] = -(i % 509 + 1) / 512.0;
        }
        triangle(&mesh, corner);
    }
    generate_hard_show(&mesh, "dust", &material);
    generate_camera_flat(b, 1, 1, 1);
}

void generate_hard_screen(generate_builder *b) {
    static const double corners[][9] = {
        {-1, -1, -0.5, 3, -1, -0.5, -1, 3, -0.5},
        {1, 1, -0.25, -3, 1, -0.25, 1, -3, -0.25},
        {-1024, -1024, -0.75, 3072, -1024, -0.75, -1024, 3072, -0.75},
    };
    static const double colors[][3] = {{0.9, 0.3, 0.3}, {0.3, 0.9, 0.3}, {0.3, 0.3, 0.9}};
    for (size_t i = 0; i < BASE_COUNT(corners); i++) {
        const double *c = colors[i];
        scene_material material = generate_hard_material(c[0], c[1], c[2], 0.5);
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
        triangle(&mesh, corners[i]);
        generate_hard_show(&mesh, "screen", &material);
    }
    generate_camera_flat(b, 1, 1, 1);
}

/* ---- what is refused, and what just fits ------------------------------------------------------
 */

void generate_hard_broken(generate_builder *b) {
    scene_material material = generate_hard_material(0.5, 0.5, 0.5, 0.5);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    const double corner[9] = {-1, -1, -0.5, 1, b->knobs[0], -0.5, 0, 1, -0.5};
    triangle(&mesh, corner);
    generate_hard_show(&mesh, "broken", &material);
    generate_camera_flat(b, 1, 1, 1);
}

/* For 512 x 512 pixels: layers over all of them, and more in the one right above the middle. */
void generate_hard_storage(generate_builder *b) {
    const uint32_t layers = (uint32_t)b->knobs[0], more = (uint32_t)b->knobs[1];
    scene_material material = generate_hard_material(0.7, 0.5, 0.9, 0x1p-6);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    for (uint32_t i = 0; i < layers + more; i++) {
        const double all[4] = {-1, -1, 1, 1};
        const double one[4] = {0x1p-10, 0x1p-10, 0x1.8p-9 + 0x1p-11, 0x1.8p-9};
        generate_hard_quad(&mesh, i < layers ? all : one, -(i + 1.0) / 128);
    }
    generate_hard_show(&mesh, "layers", &material);
    generate_camera_flat(b, 1, 1, 1);
}
