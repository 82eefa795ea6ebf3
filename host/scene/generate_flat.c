/* SPDX-License-Identifier: MIT
 *
 * Scenes made for counting fragments: soup (even depth complexity), stack (equal depths), layers
 * (exactly so many fragments in exactly these pixels), burst (so many, unevenly) and particles
 * (splats). Unlit, so that
 * shading costs nothing.
 */
#include "scene/generate.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static scene_material unlit_blend(void) {
    scene_material m = scene_default_material();
    m.alpha = SCENE_BLEND;
    m.unlit = m.double_sided = 1;
    m.metallic = 0;
    return m;
}

/* ---- soup ----------------------------------------------------------------------------------- */

#define SOUP_TANGENT      0.57735026918962576 /* of half of 60 degrees */
#define SOUP_MEDIUM_SCALE 4.0

typedef struct soup_corner {
    double x, y, z; /* x, y on the image, -1..1 inside; z: distance */
} soup_corner;

/* One triangle whose corners lie about `radius` from (x, y). Returns its area on the image. */
static double soup_triangle(generate_random *random, double x, double y, double radius,
                            soup_corner corner[3]) {
    double z = generate_between(random, 3, 9), start = generate_unit(random);
    for (int i = 0; i < 3; i++) {
        double s, c, r = radius * generate_between(random, 0.5, 1);
        generate_turn(start + i / 3.0 + generate_between(random, -0.1, 0.1), &s, &c);
        corner[i] = (soup_corner){
            .x = x + r * c, .y = y + r * s, .z = z * generate_between(random, 0.85, 1.15)};
    }
    return 0.5 * fabs((corner[1].x - corner[0].x) * (corner[2].y - corner[0].y) -
                      (corner[2].x - corner[0].x) * (corner[1].y - corner[0].y));
}

/* The radius of small triangles at which the mean depth is as wanted: areas grow with its square,
 * the region that they are spread over with the margin that the largest need. */
static double soup_radius(const generate_builder *b) {
    uint32_t small = generate_knob(b, SOUP_SMALL), medium = generate_knob(b, SOUP_MEDIUM);
    generate_random random = b->random;
    double total = 0, largest = medium ? SOUP_MEDIUM_SCALE : 1;
    soup_corner corner[3];
    for (uint32_t i = 0; i < small; i++)
        total += soup_triangle(&random, 0, 0, 1, corner);
    for (uint32_t i = 0; i < medium; i++)
        total += soup_triangle(&random, 0, 0, SOUP_MEDIUM_SCALE, corner);
    double slack = sqrt(total) - 2 * largest * sqrt(b->knobs[SOUP_DEPTH]);
    double radius = slack > 0 ? 2 * sqrt(b->knobs[SOUP_DEPTH]) / slack : 1;
    return fmin(radius, 1); /* too few triangles cannot be deep: they become large, no more */
}

/* Number `i` of its size, anywhere on the image or up to `margin` beside it. The small ones fall at
 * random; the medium ones, of which a few more here or there would show, follow the R2 sequence
 * (Roberts 2018), so that the deepest pixel stays below twice the mean. */
static void soup_add(generate_mesh *mesh, double radius, double margin, int medium, uint32_t i) {
    generate_random *random = &mesh->builder->random;
    double u = medium ? 0.5 + i * 0.75487766624669276 : generate_unit(random);
    double v = medium ? 0.5 + i * 0.56984029099805327 : generate_unit(random);
    soup_corner corner[3];
    soup_triangle(random, (1 + margin) * (2 * (u - floor(u)) - 1),
                  (1 + margin) * (2 * (v - floor(v)) - 1),
                  medium ? radius * SOUP_MEDIUM_SCALE : radius, corner);
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (int k = 0; k < 3; k++) {
        double scale = SOUP_TANGENT * corner[k].z;
        generate_vertex(mesh, corner[k].x * scale, corner[k].y * scale, -corner[k].z);
    }
    generate_triangle(mesh, first, first + 1, first + 2);
}

void generate_soup(generate_builder *b) {
    uint32_t small = generate_knob(b, SOUP_SMALL), medium = generate_knob(b, SOUP_MEDIUM);
    uint32_t materials = generate_knob(b, SOUP_MATERIALS);
    double radius = soup_radius(b), margin = radius * (medium ? SOUP_MEDIUM_SCALE : 1);
    for (uint32_t m = 0; m < materials && !b->failed; m++) {
        char name[32];
        scene_material material = unlit_blend();
        generate_hue(m / (double)materials, material.base_color);
        material.base_color[3] =
            (float)fmin(1, b->knobs[SOUP_ALPHA] * generate_between(&b->random, 0.5, 1.5));
        snprintf(name, sizeof name, "soup %u", m);
        uint32_t index = generate_material(b, name, &material);
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS);
        uint32_t few = small / materials + (m < small % materials);
        uint32_t more = medium / materials + (m < medium % materials);
        generate_mesh_reserve(&mesh, 3 * ((size_t)few + more) + 1, 3 * ((size_t)few + more) + 1);
        for (uint32_t i = 0; i < few; i++)
            soup_add(&mesh, radius, margin, 0, i);
        for (uint32_t i = 0; i < more; i++)
            soup_add(&mesh, radius, margin, 1, i * materials + m);
        generate_instance_here(b, generate_mesh_end(&mesh, name, index));
    }
    generate_camera(b, "front", (const double[3]){0, 0, 0}, (const double[3]){0, 0, -1}, 60, 1, 12);
}

/* ---- stack ---------------------------------------------------------------------------------- */

/* Square number i: always the same corners but for the shift, which leaves the plane. */
static void stack_add(generate_mesh *mesh, uint32_t i, double hue, double alpha) {
    const double *knobs = mesh->builder->knobs;
    double s, c, tilt_s, tilt_c;
    float color[3];
    generate_turn(i * 0.381966, &s, &c);
    generate_turn(knobs[STACK_TILT] / 360, &tilt_s, &tilt_c);
    generate_hue(hue + i * 0.381966, color);
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (int corner = 0; corner < 4; corner++) {
        double x = (corner == 1 || corner == 2 ? 0.45 : -0.45) + knobs[STACK_SHIFT] * c;
        double y = (corner >= 2 ? 0.45 : -0.45) + knobs[STACK_SHIFT] * s;
        generate_vertex(mesh, x, y * tilt_c, y * tilt_s - 1);
        generate_color(mesh, color, alpha);
    }
    uint32_t turned = knobs[STACK_SPLIT] > 0 && i % 2 ? 1 : 0;
    uint32_t a = first + turned, c2 = first + 2 + turned, d = first + (3 + turned) % 4;
    generate_triangle(mesh, a, a + 1, c2);
    generate_triangle(mesh, a, c2, d);
}

void generate_stack(generate_builder *b) {
    uint32_t count = generate_knob(b, STACK_COUNT), opaque = generate_knob(b, STACK_OPAQUE);
    double hue = generate_unit(&b->random);
    scene_material blend = unlit_blend(), solid = blend;
    solid.alpha = SCENE_OPAQUE;
    uint32_t material = generate_material(b, "square", &blend);
    if (opaque) {
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
        stack_add(&mesh, 0, hue, 1);
        uint32_t index = generate_material(b, "opaque square", &solid);
        generate_instance_here(b, generate_mesh_end(&mesh, "opaque square", index));
    }
    uint32_t step = generate_knob(b, STACK_MERGED) ? count : 1;
    for (uint32_t i = opaque; i < count && !b->failed; i += step) {
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
        for (uint32_t j = i; j < i + step && j < count; j++)
            stack_add(&mesh, j, hue, b->knobs[STACK_ALPHA]);
        generate_instance_here(b, generate_mesh_end(&mesh, "square", material));
    }
    generate_camera_flat(b, 1, 1, 2);
}

/* ---- layers --------------------------------------------------------------------------------- */

static void layers_add(generate_mesh *mesh, const double box[4], double z, const float color[3],
                       double alpha) {
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (int corner = 0; corner < 4; corner++) {
        generate_vertex(mesh, corner == 1 || corner == 2 ? box[2] : box[0],
                        corner >= 2 ? box[3] : box[1], z);
        generate_color(mesh, color, alpha);
    }
    generate_triangle(mesh, first, first + 1, first + 2);
    generate_triangle(mesh, first, first + 2, first + 3);
}

/* The depth rank of each layer in the order of the file; NULL when out of memory. */
static uint32_t *layers_order(generate_builder *b, uint32_t count, uint32_t order) {
    uint32_t *rank = base_calloc(count, sizeof *rank);
    for (uint32_t i = 0; rank && i < count; i++)
        rank[i] = order == LAYERS_FAR_FIRST ? count - 1 - i : i;
    for (uint32_t i = count; rank && order == LAYERS_SHUFFLED && i > 1; i--) {
        uint32_t j = (uint32_t)(((uint64_t)generate_bits(&b->random) * i) >> 32);
        uint32_t kept = rank[i - 1];
        rank[i - 1] = rank[j];
        rank[j] = kept;
    }
    return rank;
}

/* Left, bottom, right, top. A pixel's rectangle lies well inside the pixel and has the centre well
 * inside one of its triangles, so that no rounding of the projection can add or lose a fragment;
 * the image's is the image. */
static void layers_box(const generate_builder *b, double aspect, double box[4]) {
    box[0] = -aspect;
    box[1] = -1;
    box[2] = aspect;
    box[3] = 1;
    if (generate_knob(b, LAYERS_WHERE) == LAYERS_PIXEL) {
        double w = b->knobs[LAYERS_WIDTH], h = b->knobs[LAYERS_HEIGHT];
        double x = floor(w / 2) + 0.5, y = floor(h / 2) + 0.5;
        box[0] = aspect * (2 * (x - 0.25) / w - 1);
        box[1] = 2 * (y - 0.25) / h - 1;
        box[2] = aspect * (2 * (x + 0.4375) / w - 1);
        box[3] = 2 * (y + 0.25) / h - 1;
    }
}

static void layers_mesh(generate_builder *b, uint32_t count, double aspect) {
    double box[4];
    scene_material blend = unlit_blend();
    uint32_t *rank = layers_order(b, count, generate_knob(b, LAYERS_ORDER));
    b->failed |= !rank;
    layers_box(b, aspect, box);
    double hue = generate_unit(&b->random);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
    generate_mesh_reserve(&mesh, (size_t)count * 4, (size_t)count * 6);
    for (uint32_t i = 0; i < count && !b->failed; i++) {
        float color[3];
        generate_hue(hue + rank[i] * 0.381966, color);
        layers_add(&mesh, box, -(rank[i] + 1.0) / (count + 1.0), color, b->knobs[LAYERS_ALPHA]);
    }
    free(rank);
    uint32_t material = generate_material(b, "layer", &blend);
    generate_instance_here(b, generate_mesh_end(&mesh, "layers", material));
}

void generate_layers(generate_builder *b) {
    uint32_t count = generate_knob(b, LAYERS_COUNT);
    double aspect = b->knobs[LAYERS_WIDTH] / b->knobs[LAYERS_HEIGHT];
    scene_material solid = unlit_blend();
    solid.alpha = SCENE_OPAQUE;
    if (generate_knob(b, LAYERS_OPAQUE)) {
        generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
        const double all[4] = {-2 * aspect, -2, 2 * aspect, 2};
        layers_add(&mesh, all, -1, (const float[3]){0.2f, 0.2f, 0.25f}, 1);
        uint32_t index = generate_material(b, "backdrop", &solid);
        generate_instance_here(b, generate_mesh_end(&mesh, "backdrop", index));
    }
    if (count > 0)
        layers_mesh(b, count, aspect);
    generate_camera_flat(b, aspect, 1, 1.0625);
}

/* ---- burst ---------------------------------------------------------------------------------- */

static int descending(const void *a, const void *b) {
    const uint32_t left = *(const uint32_t *)a, right = *(const uint32_t *)b;
    return left < right ? 1 : left > right ? -1 : 0;
}

/* Fragments of each pixel, most first: the first share s of the pixels holds the share s^(1 -
 * spread) of all fragments. NULL when out of memory. */
static uint32_t *burst_counts(const generate_builder *b, uint32_t pixels) {
    const double total = floor(b->knobs[BURST_MEAN] * pixels + 0.5);
    const double power = 1 - b->knobs[BURST_SPREAD];
    uint32_t *counts = base_calloc(pixels, sizeof *counts);
    double before = 0;
    for (uint32_t i = 0; counts && i < pixels; i++) {
        double upto = floor(total * pow((i + 1.0) / pixels, power) + 0.5);
        counts[i] = (uint32_t)(upto - before);
        before = upto;
    }
    if (counts)
        qsort(counts, pixels, sizeof *counts, descending);
    return counts;
}

/* Covers the pixels of a rectangle; its edges lie well inside pixels, beside their centres. */
static void burst_add(const generate_builder *b, generate_mesh *mesh, const uint32_t cells[4],
                      double z, const float color[3]) {
    double w = b->knobs[BURST_WIDTH], h = b->knobs[BURST_HEIGHT], aspect = w / h;
    const double box[4] = {aspect * (2 * (cells[0] + 0.25) / w - 1), 2 * (cells[1] + 0.25) / h - 1,
                           aspect * (2 * (cells[2] - 0.0625) / w - 1),
                           2 * (cells[3] - 0.25) / h - 1};
    if (cells[0] < cells[2] && cells[1] < cells[3])
        layers_add(mesh, box, z, color, b->knobs[BURST_ALPHA]);
}

/* Layers at distinct depths, each over the pixels that have so many: whole rows, and the begin of
 * one more. */
void generate_burst(generate_builder *b) {
    uint32_t width = generate_knob(b, BURST_WIDTH), height = generate_knob(b, BURST_HEIGHT);
    uint32_t pixels = width * height, *counts = burst_counts(b, pixels);
    uint32_t layers = counts ? counts[0] : 0;
    uint32_t *rank = layers_order(b, layers, LAYERS_SHUFFLED);
    scene_material blend = unlit_blend();
    b->failed |= !counts || (layers > 0 && !rank);
    double hue = generate_unit(&b->random);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
    for (uint32_t i = 0, covered = pixels; i < layers && !b->failed; i++) {
        double z = -(rank[i] + 1.0) / (layers + 1.0);
        float color[3];
        while (covered > 0 && counts[covered - 1] <= i)
            covered--;
        uint32_t row = covered / width, rest = covered % width;
        generate_hue(hue + rank[i] * 0.381966, color);
        burst_add(b, &mesh, (const uint32_t[4]){0, 0, width, row}, z, color);
        burst_add(b, &mesh, (const uint32_t[4]){0, row, rest, row + 1}, z, color);
    }
    free(counts);
    free(rank);
    uint32_t material = generate_material(b, "burst", &blend);
    if (layers > 0)
        generate_instance_here(b, generate_mesh_end(&mesh, "burst", material));
    generate_camera_flat(b, b->knobs[BURST_WIDTH] / b->knobs[BURST_HEIGHT], 1, 1.0625);
}

/* ---- particles ------------------------------------------------------------------------------ */

static void particles_core(generate_builder *b) {
    scene_material solid = scene_default_material();
    solid.metallic = 0;
    solid.roughness = 0.6f;
    solid.base_color[0] = solid.base_color[1] = solid.base_color[2] = 0.7f;
    generate_mesh core = generate_mesh_begin(b, GENERATE_NORMALS);
    generate_sphere(&core, (const double[3]){0, 0.1, 0}, 0.22, 24);
    uint32_t index = generate_material(b, "core", &solid);
    generate_instance_here(b, generate_mesh_end(&core, "core", index));
    generate_sun(b, (const double[3]){-0.5, -1, -0.7}, (const float[3]){2.5f, 2.4f, 2.2f});
}

/* A vortex that widens and cools as it rises. */
void generate_particles(generate_builder *b) {
    generate_random *random = &b->random;
    uint32_t count = generate_knob(b, PARTICLES_COUNT);
    if (generate_knob(b, PARTICLES_CORE))
        particles_core(b);
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_COLORS | GENERATE_RADII);
    generate_mesh_reserve(&mesh, count, 0);
    for (uint32_t i = 0; i < count && !b->failed; i++) {
        double s, c, h = generate_unit(random);
        double spread = (generate_unit(random) + generate_unit(random) + generate_unit(random)) / 3;
        double r = (0.1 + 0.7 * h) * (0.25 + 1.3 * spread) * 0.9;
        double arm = floor(generate_between(random, 0, 3)) / 3;
        float color[3];
        generate_turn(arm + 1.4 * h + generate_between(random, -0.09, 0.09), &s, &c);
        generate_hue(0.02 + 0.62 * h + generate_between(random, -0.04, 0.04), color);
        generate_vertex(&mesh, r * c, 2 * h - 1 + generate_between(random, -0.05, 0.05), r * s);
        generate_color(&mesh, color, b->knobs[PARTICLES_ALPHA]);
        generate_radius(&mesh, b->knobs[PARTICLES_RADIUS] * generate_between(random, 0.5, 1.5));
    }
    scene_material material = unlit_blend();
    uint32_t index = generate_material(b, "particle", &material);
    generate_instance_here(b, generate_mesh_end(&mesh, "plume", index));
    generate_camera(b, "front", (const double[3]){0.6, 0.5, 3.4}, (const double[3]){0, 0.02, 0}, 42,
                    0.1, 20);
}
