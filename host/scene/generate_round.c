/* SPDX-License-Identifier: MIT
 *
 * Lit scenes of many surfaces one behind the other: shells, hairball and needles, the last two
 * after the models on which layered techniques are usually measured.
 */
#include "scene/generate.h"

#include <math.h>
#include <stdio.h>

static scene_material plain(double r, double g, double b, double alpha, double roughness) {
    scene_material m = scene_default_material();
    const double color[4] = {r, g, b, alpha};
    for (int i = 0; i < 4; i++)
        m.base_color[i] = (float)color[i];
    m.alpha = alpha < 1 ? SCENE_BLEND : SCENE_OPAQUE;
    m.metallic = 0;
    m.roughness = (float)roughness;
    return m;
}

static void lights(generate_builder *b) {
    generate_sun(b, (const double[3]){-0.5, -1, -0.8}, (const float[3]){2.6f, 2.5f, 2.3f});
    generate_sun(b, (const double[3]){1, -0.2, 0.4}, (const float[3]){0.35f, 0.45f, 0.6f});
}

static void core(generate_builder *b, double radius) {
    scene_material material = plain(0.75, 0.72, 0.68, 1, 0.5);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_sphere(&mesh, (const double[3]){0, 0, 0}, radius, 32);
    uint32_t index = generate_material(b, "core", &material);
    generate_instance_here(b, generate_mesh_end(&mesh, "core", index));
}

/* ---- shells --------------------------------------------------------------------------------- */

void generate_shells(generate_builder *b) {
    uint32_t count = generate_knob(b, SHELLS_COUNT);
    uint32_t detail = 1u << generate_knob(b, SHELLS_SUBDIVISION);
    double transmission = b->knobs[SHELLS_TRANSMISSION], hue = generate_unit(&b->random);
    if (generate_knob(b, SHELLS_CORE))
        core(b, 0.2);
    for (uint32_t i = 0; i < count && !b->failed; i++) {
        char name[32];
        float color[3];
        generate_hue(hue + 0.8 * i / count, color);
        scene_material material = plain((double)color[0], (double)color[1], (double)color[2],
                                        b->knobs[SHELLS_ALPHA], 0.35);
        material.alpha = SCENE_BLEND;
        material.double_sided = 1;
        if (transmission > 0) {
            material.alpha = SCENE_OPAQUE;
            material.base_color[3] = 1;
            material.transmission = (float)transmission;
            for (int c = 0; c < 3; c++)
                material.base_color[c] = 0.45f + 0.55f * material.base_color[c];
        }
        snprintf(name, sizeof name, "shell %u", i);
        uint32_t index = generate_material(b, name, &material);
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
        generate_sphere(&mesh, (const double[3]){0, 0, 0}, 1 - 0.75 * i / count, detail);
        generate_instance_here(b, generate_mesh_end(&mesh, name, index));
    }
    lights(b);
    generate_camera(b, "front", (const double[3]){1.1, 0.9, 2.9}, (const double[3]){0, 0, 0}, 40,
                    0.1, 10);
}

/* ---- hairball ------------------------------------------------------------------------------- */

enum { HAIR_POINTS = 1001 };

/* a cos + b sin: turns the unit vector a towards the unit vector b, both kept orthonormal. */
static void turn_pair(double a[3], double b[3], double turns) {
    double s, c;
    generate_turn(turns, &s, &c);
    for (int k = 0; k < 3; k++) {
        double kept = a[k];
        a[k] = kept * c + b[k] * s;
        b[k] = b[k] * c - kept * s;
    }
}

/* A walk on a sphere whose radius breathes: forwards along a great circle, steering by a slow wave.
 * A ribbon rolls about its own direction as it goes. */
static void hair(generate_random *random, uint32_t count, double (*points)[3],
                 double (*across)[3]) {
    double up[3], ahead[3], side[3], other[3];
    generate_direction(random, up);
    generate_direction(random, other);
    generate_cross(up, other, ahead);
    generate_normalize(ahead);
    generate_cross(up, ahead, side);
    double level = generate_between(random, 0.55, 0.95), swell = generate_between(random, 0, 0.1);
    double phase = generate_unit(random), waves = generate_between(random, 0.5, 3);
    double steer = generate_between(random, -1.2, 1.2), roll = generate_between(random, -2, 2);
    double length = generate_between(random, 0.4, 1.1);
    for (uint32_t i = 0; i < count; i++) {
        double t = count > 1 ? i / (count - 1.0) : 0, s, c, roll_s, roll_c;
        generate_turn(phase + waves * t, &s, &c);
        generate_turn(phase + roll * t, &roll_s, &roll_c);
        double radius = level + swell * s;
        for (int k = 0; k < 3; k++) {
            points[i][k] = radius * up[k];
            across[i][k] = side[k] * roll_c + up[k] * roll_s;
        }
        turn_pair(up, ahead, length / count);
        turn_pair(ahead, side, steer * c / count);
        generate_normalize(up);
        generate_cross(up, ahead, side);
        generate_normalize(side);
        generate_cross(side, up, ahead);
    }
}

void generate_hairball(generate_builder *b) {
    uint32_t strands = generate_knob(b, HAIRBALL_STRANDS);
    uint32_t count = generate_knob(b, HAIRBALL_SEGMENTS) + 1;
    uint32_t sides = generate_knob(b, HAIRBALL_SIDES);
    double points[HAIR_POINTS][3], across[HAIR_POINTS][3];
    if (generate_knob(b, HAIRBALL_CORE))
        core(b, 0.4);
    scene_material material = plain(1, 1, 1, b->knobs[HAIRBALL_ALPHA], 0.45);
    material.alpha = SCENE_BLEND;
    material.double_sided = 1;
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
    size_t quads = sides == 2 ? 1 : sides;
    generate_mesh_reserve(&mesh, (size_t)strands * count * sides,
                          (size_t)strands * (count - 1) * quads * 6);
    for (uint32_t i = 0; i < strands && !b->failed; i++) {
        size_t first = mesh.vertex_count;
        double tint = generate_unit(&b->random);
        hair(&b->random, count, points, across);
        generate_tube(&mesh, (const double(*)[3])points, (const double(*)[3])across, count,
                      b->knobs[HAIRBALL_RADIUS], 0.4, sides);
        const float color[4] = {(float)(0.45 + 0.4 * tint), (float)(0.16 + 0.34 * tint * tint),
                                (float)(0.05 + 0.12 * tint), 1};
        for (size_t v = first; v < mesh.vertex_count; v++)
            for (size_t k = 0; k < 4; k++)
                mesh.colors[v * 4 + k] = color[k];
    }
    uint32_t index = generate_material(b, "hair", &material);
    generate_instance_here(b, generate_mesh_end(&mesh, "hair", index));
    lights(b);
    generate_camera(b, "front", (const double[3]){1, 0.8, 2.6}, (const double[3]){0, 0, 0}, 42, 0.1,
                    10);
}

/* ---- needles -------------------------------------------------------------------------------- */

enum { BOUGH_POINTS = 6 };

typedef struct bough {
    double points[BOUGH_POINTS][3], across[BOUGH_POINTS][3];
} bough;

/* Number i of `count`, from the top down by the golden angle; hangs a little. */
static bough make_bough(generate_random *random, uint32_t i, uint32_t count) {
    bough out;
    double s, c, t = (i + 0.5) / count;
    generate_turn(i * 0.381966 + generate_between(random, -0.03, 0.03), &s, &c);
    double length = (0.1 + 0.72 * t) * generate_between(random, 0.85, 1.1);
    double height = 0.95 - 1.7 * t;
    for (int k = 0; k < BOUGH_POINTS; k++) {
        double along = k / (BOUGH_POINTS - 1.0), r = length * along;
        out.points[k][0] = r * c;
        out.points[k][1] = height + length * (0.25 * along - 0.5 * along * along);
        out.points[k][2] = r * s;
        out.across[k][0] = -s;
        out.across[k][1] = 0;
        out.across[k][2] = c;
    }
    return out;
}

/* One needle: a ribbon of two triangles that narrows, from somewhere on the bough, half forwards.
 */
static void add_needle(generate_mesh *mesh, const bough *from) {
    generate_random *random = &mesh->builder->random;
    const double *knobs = mesh->builder->knobs;
    double at = generate_between(random, 0.08, 1) * (BOUGH_POINTS - 1);
    int k = at < BOUGH_POINTS - 1 ? (int)at : BOUGH_POINTS - 2;
    double way[3], direction[3], side[3], points[2][3], across[2][3];
    generate_direction(random, way);
    double length = knobs[NEEDLES_LENGTH] * generate_between(random, 0.7, 1.2);
    for (int axis = 0; axis < 3; axis++)
        direction[axis] = from->points[k + 1][axis] - from->points[k][axis];
    generate_normalize(direction);
    for (int axis = 0; axis < 3; axis++)
        direction[axis] += 1.1 * way[axis];
    generate_normalize(direction);
    generate_direction(random, way);
    generate_cross(direction, way, side);
    generate_normalize(side);
    for (int axis = 0; axis < 3; axis++) {
        double start =
            from->points[k][axis] + (at - k) * (from->points[k + 1][axis] - from->points[k][axis]);
        points[0][axis] = start;
        points[1][axis] = start + length * direction[axis];
        across[0][axis] = across[1][axis] = side[axis];
    }
    generate_tube(mesh, (const double(*)[3])points, (const double(*)[3])across, 2,
                  knobs[NEEDLES_WIDTH] / 2, 0.3, 2);
}

void generate_needles(generate_builder *b) {
    static const double trunk[][2] = {{0, -1.1}, {0.07, -1.1}, {0.055, -0.5}, {0.03, 0.4}, {0, 1}};
    uint32_t boughs = generate_knob(b, NEEDLES_BRANCHES), each = generate_knob(b, NEEDLES_NEEDLES);
    generate_mesh wood = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_mesh green = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_mesh_reserve(&green, (size_t)boughs * each * 4 + 1, (size_t)boughs * each * 6 + 1);
    generate_lathe(&wood, (const double[3]){0, 0, 0}, trunk, BASE_COUNT(trunk), 24);
    for (uint32_t i = 0; i < boughs && !b->failed; i++) {
        bough limb = make_bough(&b->random, i, boughs);
        generate_tube(&wood, (const double(*)[3])limb.points, (const double(*)[3])limb.across,
                      BOUGH_POINTS, 0.006 + 0.01 * i / boughs, 0.3, 4);
        for (uint32_t n = 0; n < each && !b->failed; n++)
            add_needle(&green, &limb);
    }
    scene_material bark = plain(0.16, 0.09, 0.05, 1, 0.9);
    scene_material needle = plain(0.06, 0.26, 0.09, b->knobs[NEEDLES_ALPHA], 0.6);
    needle.alpha = SCENE_BLEND;
    needle.double_sided = 1;
    uint32_t index = generate_material(b, "bark", &bark);
    generate_instance_here(b, generate_mesh_end(&wood, "wood", index));
    index = generate_material(b, "needle", &needle);
    generate_instance_here(b, generate_mesh_end(&green, "needles", index));
    lights(b);
    generate_camera(b, "front", (const double[3]){0.9, 0.35, 3.1}, (const double[3]){0, -0.07, 0},
                    42, 0.1, 10);
}
