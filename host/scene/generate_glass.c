/* SPDX-License-Identifier: MIT
 *
 * The demonstration's still life: coloured glass (KHR_materials_transmission) and alpha-blended
 * objects that run into each other, smoke, and opaque things to see through them. Both effects in
 * one picture, some ten to thirty layers deep.
 */
#include "scene/generate.h"

#include <math.h>

typedef struct paint {
    const char *name;
    float color[4];
    float roughness, metallic, transmission;
} paint;

static uint32_t mix(generate_builder *b, const paint *p) {
    scene_material m = scene_default_material();
    for (int c = 0; c < 4; c++)
        m.base_color[c] = p->color[c];
    m.roughness = p->roughness;
    m.metallic = p->metallic;
    m.transmission = p->transmission;
    m.alpha = p->color[3] < 1 ? SCENE_BLEND : SCENE_OPAQUE;
    m.double_sided = p->color[3] < 1 || p->transmission > 0;
    return generate_material(b, p->name, &m);
}

static void show(generate_builder *b, generate_mesh *mesh, const paint *p) {
    uint32_t material = mix(b, p);
    generate_instance_here(b, generate_mesh_end(mesh, p->name, material));
}

/* ---- opaque --------------------------------------------------------------------------------- */

enum { TILE_SIDE = 128 };

/* Four tiles with pale joints. */
static uint32_t tiles(generate_builder *b) {
    static const unsigned char tone[2][3] = {{196, 186, 170}, {92, 96, 104}};
    unsigned char *pixels = base_calloc(TILE_SIDE * TILE_SIDE, 4);
    generate_random grain = generate_seed(11);
    for (int y = 0; pixels && y < TILE_SIDE; y++) {
        for (int x = 0; x < TILE_SIDE; x++) {
            int half = TILE_SIDE / 2, dark = (x / half + y / half) % 2;
            int joint = x % half < 1 || y % half < 1;
            int noise = (int)(generate_bits(&grain) % 13) - 6;
            unsigned char *p = pixels + (y * TILE_SIDE + x) * 4;
            for (int c = 0; c < 3; c++)
                p[c] = (unsigned char)(joint ? 150 : tone[dark][c] + noise);
            p[3] = 255;
        }
    }
    return generate_image(b, "tiles", TILE_SIDE, TILE_SIDE, pixels);
}

static void opaque_things(generate_builder *b, uint32_t detail) {
    scene_material ground = scene_default_material();
    ground.metallic = 0;
    ground.roughness = 0.7f;
    ground.base_color_texture.image = tiles(b);
    uint32_t material = generate_material(b, "floor", &ground);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_UV);
    generate_floor(&mesh, 6, 0, 1, 8);
    generate_instance_here(b, generate_mesh_end(&mesh, "floor", material));

    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_sphere(&mesh, (const double[3]){0.25, 0.42, -1.35}, 0.42, 5 * detail);
    show(b, &mesh, &(paint){"pearl", {0.58f, 0.53f, 0.48f, 1}, 0.45f, 0, 0});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_box(&mesh, (const double[3]){-2.1, 0, -1.5}, (const double[3]){-1.2, 0.5, -0.6});
    generate_box(&mesh, (const double[3]){-1.95, 0.5, -1.35},
                 (const double[3]){-1.35, 0.62, -0.75});
    show(b, &mesh, &(paint){"plinth", {0.5f, 0.2f, 0.14f, 1}, 0.85f, 0, 0});
}

/* ---- glass ---------------------------------------------------------------------------------- */

/* Outside from the foot to the rim, then down the inside. */
static const double vase[][2] = {
    {0, 0},      {0.3, 0},    {0.34, 0.03}, {0.35, 0.1},  {0.42, 0.3}, {0.46, 0.5},  {0.44, 0.7},
    {0.36, 0.9}, {0.26, 1.1}, {0.21, 1.25}, {0.2, 1.4},   {0.23, 1.5}, {0.29, 1.58}, {0.3, 1.6},
    {0.28, 1.6}, {0.21, 1.5}, {0.18, 1.4},  {0.19, 1.25}, {0.24, 1.1}, {0.34, 0.9},  {0.42, 0.7},
    {0.44, 0.5}, {0.4, 0.3},  {0.33, 0.12}, {0.28, 0.06}, {0, 0.05}};
static const double bowl[][2] = {{0, 0},       {0.22, 0},    {0.24, 0.03}, {0.3, 0.06},
                                 {0.45, 0.16}, {0.56, 0.3},  {0.6, 0.44},  {0.58, 0.44},
                                 {0.54, 0.31}, {0.43, 0.19}, {0.29, 0.1},  {0, 0.06}};

static void coloured_glass(generate_builder *b, uint32_t detail) {
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_lathe(&mesh, (const double[3]){-0.85, 0, -0.35}, vase, BASE_COUNT(vase), 20 * detail);
    show(b, &mesh, &(paint){"vase", {0.3f, 0.82f, 0.72f, 1}, 0.12f, 0, 1});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_sphere(&mesh, (const double[3]){0.3, 0.48, 0.15}, 0.48, 6 * detail);
    show(b, &mesh, &(paint){"ruby", {0.92f, 0.2f, 0.16f, 1}, 0.1f, 0, 1});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_torus(&mesh, (const double[3]){1.3, 0.52, -0.35}, 0.42, 0.1,
                   (const double[3]){-0.35, 0.25, 1}, 20 * detail, 6 * detail);
    show(b, &mesh, &(paint){"ring", {0.62f, 0.34f, 0.9f, 1}, 0.1f, 0, 1});
}

static void blended_things(generate_builder *b, uint32_t detail) {
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_sphere(&mesh, (const double[3]){0.82, 0.36, 0.42}, 0.36, 6 * detail);
    show(b, &mesh, &(paint){"bubble", {0.15f, 0.35f, 0.9f, 0.38f}, 0.25f, 0, 0});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_lathe(&mesh, (const double[3]){-0.35, 0.001, 0.85}, bowl, BASE_COUNT(bowl),
                   20 * detail);
    show(b, &mesh, &(paint){"bowl", {0.95f, 0.62f, 0.12f, 0.42f}, 0.3f, 0, 0});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_box(&mesh, (const double[3]){1.05, 0.001, -0.75}, (const double[3]){1.6, 0.55, -0.2});
    show(b, &mesh, &(paint){"block", {0.75f, 0.9f, 0.3f, 0.35f}, 0.3f, 0, 0});
    mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_sphere(&mesh, (const double[3]){-0.35, 0.34, 0.85}, 0.26, 4 * detail);
    show(b, &mesh, &(paint){"fruit", {0.35f, 0.75f, 0.25f, 0.6f}, 0.4f, 0, 0});
}

/* A thread of smoke from the vase's mouth: narrow, then curling and wide. */
static void smoke(generate_builder *b) {
    generate_random *random = &b->random;
    scene_material m = scene_default_material();
    m.alpha = SCENE_BLEND;
    m.unlit = m.double_sided = 1;
    uint32_t material = generate_material(b, "smoke", &m);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_COLORS | GENERATE_RADII);
    for (uint32_t i = 0; i < generate_knob(b, GLASS_SMOKE) && !b->failed; i++) {
        double s, c, t = generate_unit(random), wide = 0.02 + 0.2 * t * t, off[3];
        generate_turn(0.1 + 1.3 * t * t, &s, &c);
        generate_direction(random, off);
        double far = wide * sqrt(generate_unit(random));
        generate_vertex(&mesh, -0.85 + 0.55 * t * t * c + far * off[0],
                        1.35 + 1.25 * t + 0.6 * far * off[1],
                        -0.35 + 0.45 * t * t * s + far * off[2]);
        const float grey = (float)(0.5 + 0.35 * generate_unit(random));
        generate_color(&mesh, (const float[3]){grey, grey, grey * 1.05f}, 0.16 * (1 - 0.85 * t));
        generate_radius(&mesh, 0.025 + 0.09 * t * generate_between(random, 0.6, 1.2));
    }
    generate_instance_here(b, generate_mesh_end(&mesh, "smoke", material));
}

void generate_glass(generate_builder *b) {
    uint32_t detail = generate_knob(b, GLASS_DETAIL);
    opaque_things(b, detail);
    coloured_glass(b, detail);
    blended_things(b, detail);
    smoke(b);
    generate_sun(b, (const double[3]){-0.55, -1, -0.6}, (const float[3]){2.4f, 2.25f, 2.0f});
    generate_lamp(b, (const double[3]){2.4, 2.6, 1.8}, (const float[3]){5, 6, 8});
    generate_lamp(b, (const double[3]){-2.6, 1.6, 2.2}, (const float[3]){5, 3.6f, 2.4f});
    generate_camera(b, "front", (const double[3]){0.75, 1.75, 4.3},
                    (const double[3]){0.02, 0.72, 0}, 38, 0.1, 30);
}
