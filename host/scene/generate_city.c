/* SPDX-License-Identifier: MIT
 *
 * A town on a grid: a few meshes, very many instances, nearly all of them hidden from the street.
 * For occlusion culling and instancing; some buildings have glass fronts, so that there is
 * something transparent in the distance too.
 */
#include "scene/generate.h"

#include <math.h>
#include <stdio.h>

enum { CITY_KINDS = 6, FACADE_SIDE = 64 };

#define CITY_PITCH 24.0 /* metres from house to house, of which 14 are house */

/* One wall of 4 x 4 windows; the top row is the roof's colour, too. */
static uint32_t facade(generate_builder *b) {
    unsigned char *pixels = base_calloc(FACADE_SIDE * FACADE_SIDE, 4);
    for (int y = 0; pixels && y < FACADE_SIDE; y++) {
        for (int x = 0; x < FACADE_SIDE; x++) {
            unsigned char *p = pixels + (y * FACADE_SIDE + x) * 4;
            int pane = x % 16 >= 4 && x % 16 < 12 && y % 16 >= 4 && y % 16 < 13;
            int frame = pane && (x % 16 == 8 || y % 16 == 8);
            p[0] = pane && !frame ? 58 : 214;
            p[1] = pane && !frame ? 74 : 208;
            p[2] = pane && !frame ? 96 : 198;
            p[3] = 255;
        }
    }
    return generate_image(b, "facade", FACADE_SIDE, FACADE_SIDE, pixels);
}

/* A block of unit height with a storey set back on top, the same for all houses of a kind. The
 * upper windows are as high as the lower ones. */
static void house(generate_mesh *mesh, int kind) {
    double in = 0.5 - 0.06 * (kind % 3), step = 0.72 + 0.09 * (kind / 3);
    generate_box(mesh, (const double[3]){-0.5, 0, -0.5}, (const double[3]){0.5, step, 0.5});
    size_t first = mesh->vertex_count;
    generate_box(mesh, (const double[3]){-in, step, -in}, (const double[3]){in, 1, in});
    for (size_t v = first; v < mesh->vertex_count && !mesh->builder->failed; v++)
        mesh->uv[v * 2 + 1] *= (float)((1 - step) / step);
}

typedef struct plot {
    double centre[3], size[3];
    int kind, glass;
} plot;

/* What stands on lot `index`: a pure function of it and the seed, so that each kind of mesh can be
 * gone through in turn. */
static plot survey(const generate_builder *b, uint32_t index, uint32_t side) {
    generate_random random = generate_seed(b->random.state ^ ((uint64_t)index << 20));
    double x = index % side - (side - 1) / 2.0, z = index / side - (side - 1) / 2.0;
    double middle = 1 - sqrt(x * x + z * z) / (0.75 * side + 1), u = generate_unit(&random);
    plot out = {.centre = {x * CITY_PITCH, 0, z * CITY_PITCH},
                .kind = (int)(generate_unit(&random) * CITY_KINDS),
                .glass = generate_unit(&random) < b->knobs[CITY_GLASS]};
    out.size[0] = generate_between(&random, 11, 15);
    out.size[1] = 9 + 60 * u * u * u * fmax(middle, 0.1) + 8 * generate_unit(&random);
    out.size[2] = generate_between(&random, 11, 15);
    return out;
}

/* One instance of `mesh` for each house of the kind. */
static void place_houses(generate_builder *b, uint32_t mesh, int kind, uint32_t count,
                         uint32_t side) {
    for (uint32_t i = 0; i < count && !b->failed; i++) {
        plot p = survey(b, i, side);
        if (p.kind == kind)
            generate_instance(b, mesh, p.centre, p.size);
    }
}

static void place_fronts(generate_builder *b, uint32_t mesh, uint32_t count, uint32_t side) {
    for (uint32_t i = 0; i < count && !b->failed; i++) {
        plot p = survey(b, i, side);
        const double size[3] = {p.size[0] + 1.2, p.size[1] * 0.68, p.size[2] + 1.2};
        if (p.glass)
            generate_instance(b, mesh, p.centre, size);
    }
}

static void build_ground(generate_builder *b, uint32_t side) {
    scene_material ground = scene_default_material();
    ground.metallic = 0;
    ground.roughness = 0.9f;
    for (int c = 0; c < 3; c++)
        ground.base_color[c] = 0.11f + 0.01f * (float)c;
    uint32_t material = generate_material(b, "ground", &ground);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_floor(&mesh, side * CITY_PITCH, 0, 10, 8);
    generate_instance_here(b, generate_mesh_end(&mesh, "ground", material));
}

static void build_houses(generate_builder *b, int kind, uint32_t image, uint32_t count,
                         uint32_t side) {
    static const float tints[CITY_KINDS][3] = {{0.9f, 0.86f, 0.8f},  {0.74f, 0.42f, 0.32f},
                                               {0.85f, 0.73f, 0.5f}, {0.6f, 0.65f, 0.7f},
                                               {0.83f, 0.6f, 0.47f}, {0.56f, 0.62f, 0.5f}};
    char name[32];
    scene_material wall = scene_default_material();
    wall.metallic = 0;
    wall.roughness = 0.75f;
    for (int c = 0; c < 3; c++)
        wall.base_color[c] = tints[kind][c];
    wall.base_color_texture.image = image; /* a picture a wall across, 2 to 4 of them up */
    wall.base_color_texture.scale_rotate[0] = 4;
    wall.base_color_texture.scale_rotate[3] = (float)(2 + kind % 3);
    snprintf(name, sizeof name, "house %d", kind);
    uint32_t material = generate_material(b, name, &wall);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_UV);
    house(&mesh, kind);
    place_houses(b, generate_mesh_end(&mesh, name, material), kind, count, side);
}

static void build_fronts(generate_builder *b, uint32_t count, uint32_t side) {
    scene_material pane = scene_default_material();
    const double color[4] = {0.35, 0.6, 0.68, b->knobs[CITY_ALPHA]};
    for (int c = 0; c < 4; c++)
        pane.base_color[c] = (float)color[c];
    pane.alpha = SCENE_BLEND;
    pane.double_sided = 1;
    pane.metallic = 0;
    pane.roughness = 0.1f;
    uint32_t material = generate_material(b, "glass front", &pane);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_box(&mesh, (const double[3]){-0.5, 0.02, -0.5}, (const double[3]){0.5, 1, 0.5});
    place_fronts(b, generate_mesh_end(&mesh, "glass front", material), count, side);
}

static void cameras(generate_builder *b, uint32_t side) {
    double half = side * CITY_PITCH / 2, lane = side % 2 ? -CITY_PITCH / 2 : 0;
    int aerial = generate_knob(b, CITY_VIEW) == CITY_AERIAL;
    for (int i = 0; i < 2; i++) {
        if (i == aerial)
            generate_camera(b, "street", (const double[3]){lane + 1.5, 2.2, half},
                            (const double[3]){lane - 1, 6.5, half - 60}, 60, 0.2, 2.5 * half + 500);
        else
            generate_camera(b, "aerial",
                            (const double[3]){half * 0.5, 60 + half * 0.5, half * 1.35},
                            (const double[3]){0, 0, half * 0.1}, 45, 1, 5 * half + 500);
    }
}

void generate_city(generate_builder *b) {
    uint32_t count = generate_knob(b, CITY_COUNT);
    uint32_t side = (uint32_t)ceil(sqrt(count)), houses[CITY_KINDS] = {0}, fronts = 0;
    for (uint32_t i = 0; i < count; i++) {
        plot p = survey(b, i, side);
        houses[p.kind]++;
        fronts += p.glass != 0;
    }
    build_ground(b, side);
    uint32_t image = facade(b);
    for (int kind = 0; kind < CITY_KINDS; kind++)
        if (houses[kind])
            build_houses(b, kind, image, count, side);
    if (fronts)
        build_fronts(b, count, side);
    generate_sun(b, (const double[3]){-0.55, -1, -0.65}, (const float[3]){2.8f, 2.6f, 2.3f});
    generate_sun(b, (const double[3]){0.6, -0.3, 0.8}, (const float[3]){0.4f, 0.5f, 0.65f});
    cameras(b, side);
}
