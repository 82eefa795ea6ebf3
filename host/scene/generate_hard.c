/* SPDX-License-Identifier: MIT
 *
 * The list of hard cases, as data, and what their builders share. First noun of scene -> demand ->
 * plan -> frame -> fragments -> image.
 */
#include "scene/generate_hard.h"

#include <math.h>
#include <string.h>

/* Alphas are such that the last layer of a pixel still counts. */
#define LAYERS(text, ...) .of = "layers", .knobs = {"count=" text, __VA_ARGS__}
#define SMALL             "width=16", "height=16"
#define PIXEL             "width=16", "height=16", "where=pixel"
#define STACK(text)       .of = "stack", .knobs = {"count=" text, "split=1"}

static const generate_hard_case cases[] = {
    {{"hard:coplanar-2", "two squares at one depth", 48, 48}, STACK("2")},
    {{"hard:coplanar-3", "three squares at one depth", 48, 48}, STACK("3")},
    {{"hard:coplanar-100", "a hundred squares at one depth", 48, 48}, STACK("100")},
    {{"hard:crossing", "triangles through each other and round in a ring, some opaque", 64, 64},
     .build = generate_hard_crossing},
    {{"hard:slivers", "long thin triangles, and some without area", 64, 64},
     .build = generate_hard_slivers},
    {{"hard:near-plane", "corners on the near plane, behind the eye, at w = 0", 64, 64},
     .build = generate_hard_near_plane},
    {{"hard:huge", "coordinates up to 1e30", 48, 48}, .build = generate_hard_huge},
    {{"hard:tiny", "coordinates of 1e-30", 48, 48}, .build = generate_hard_tiny},
    {{"hard:depth-range", "from 1e-6 to 1e9 before the eye", 48, 48},
     .build = generate_hard_depth_range},
    {{"hard:not-a-number", "a corner that is no number: refused", 16, 16},
     .build = generate_hard_broken,
     .values = {NAN}},
    {{"hard:infinite", "a corner at infinity: refused", 16, 16},
     .build = generate_hard_broken,
     .values = {INFINITY}},
    {{"hard:shared-edges", "edges and corners exactly on pixel centres", 32, 32},
     .build = generate_hard_shared_edges},
    {{"hard:dust", "triangles of a hundredth of a pixel", 48, 48}, .build = generate_hard_dust},
    {{"hard:screen", "single triangles over the whole image", 48, 48},
     .build = generate_hard_screen},
    {{"hard:layers-0", "no layer at all", 16, 16}, LAYERS("0", SMALL)},
    {{"hard:layers-1", "one layer", 16, 16}, LAYERS("1", SMALL)},
    {{"hard:layers-2", "2 layers", 16, 16}, LAYERS("2", SMALL)},
    {{"hard:layers-32", "32 layers", 16, 16}, LAYERS("32", SMALL, "alpha=0.0625")},
    {{"hard:layers-33", "33 layers", 16, 16}, LAYERS("33", SMALL, "alpha=0.0625")},
    {{"hard:layers-64", "64 layers", 16, 16}, LAYERS("64", SMALL, "alpha=0.0625")},
    {{"hard:layers-65", "65 layers", 16, 16}, LAYERS("65", SMALL, "alpha=0.0625")},
    {{"hard:layers-253", "253 layers", 8, 8},
     LAYERS("253", "width=8", "height=8", "alpha=0.015625")},
    {{"hard:layers-254", "254 layers", 8, 8},
     LAYERS("254", "width=8", "height=8", "alpha=0.015625")},
    {{"hard:layers-255", "255 layers", 8, 8},
     LAYERS("255", "width=8", "height=8", "alpha=0.015625")},
    {{"hard:layers-256", "256 layers", 8, 8},
     LAYERS("256", "width=8", "height=8", "alpha=0.015625")},
    {{"hard:layers-1500", "1,500 layers in one pixel", 16, 16},
     LAYERS("1500", PIXEL, "alpha=0.001953125")},
    {{"hard:layers-20000", "20,000 layers in one pixel", 16, 16},
     LAYERS("20000", PIXEL, "alpha=0.0001220703125")},
    {{"hard:pixel-100000", "one pixel of 100,000 fragments, all others empty", 16, 16},
     LAYERS("100000", PIXEL, "alpha=0.0001")},
    {{"hard:alpha-0", "8 layers that cover nothing", 16, 16}, LAYERS("8", SMALL, "alpha=0")},
    {{"hard:alpha-1", "8 layers that cover everything", 16, 16}, LAYERS("8", SMALL, "alpha=1")},
    {{"hard:alpha-next-to-1", "alpha 1 - 2^-24", 16, 16}, .build = generate_hard_nearly},
    {{"hard:alpha-512th", "alpha 1/512, below a step of 8 bits", 16, 16},
     LAYERS("200", SMALL, "alpha=0.001953125")},
    {{"hard:alpha-millionth", "10,000 layers of alpha 2^-20 in one pixel", 16, 16},
     LAYERS("10000", PIXEL, "alpha=9.5367431640625e-7")},
    {{"hard:alpha-denormal", "alpha 1e-40", 16, 16}, LAYERS("8", SMALL, "alpha=1e-40")},
    {{"hard:hdr-65504", "colours up to the largest half", 32, 32},
     .build = generate_hard_bright,
     .values = {65504}},
    {{"hard:hdr-million", "colours beyond the largest half", 32, 32},
     .build = generate_hard_bright,
     .values = {1e6}},
    {{"hard:negative", "colours below zero, which files cannot have", 32, 32},
     .build = generate_hard_bright,
     .values = {-0.5}},
    {{"hard:straight", "a texture whose transparent texels are bright", 32, 32},
     .build = generate_hard_straight},
    {{"hard:srgb", "the same grey from an sRGB texture and from a linear factor", 32, 32},
     .build = generate_hard_srgb},
    {{"hard:storage-128-mib", "2^24 fragments: 128 MiB of keys, exactly", 512, 512},
     .build = generate_hard_storage,
     .values = {64, 0}},
    {{"hard:storage-one-more", "2^24 + 1 fragments", 512, 512},
     .build = generate_hard_storage,
     .values = {64, 1}},
};

const scene_hard_case *scene_hard_cases(uint32_t index) {
    return index < BASE_COUNT(cases) ? &cases[index].shown : NULL;
}

const generate_hard_case *generate_hard_find(const char *name) {
    for (size_t i = 0; i < BASE_COUNT(cases); i++)
        if (strcmp(cases[i].shown.name, name) == 0)
            return &cases[i];
    return NULL;
}

/* ---- building blocks --------------------------------------------------------------------------
 */

scene_material generate_hard_material(double r, double g, double b, double alpha) {
    scene_material m = scene_default_material();
    const double color[4] = {r, g, b, alpha};
    for (int i = 0; i < 4; i++)
        m.base_color[i] = (float)color[i];
    m.alpha = alpha < 1 ? SCENE_BLEND : SCENE_OPAQUE;
    m.unlit = m.double_sided = 1;
    m.metallic = 0;
    return m;
}

void generate_hard_show(generate_mesh *mesh, const char *name, const scene_material *material) {
    generate_builder *b = mesh->builder;
    uint32_t index = generate_material(b, name, material);
    generate_instance_here(b, generate_mesh_end(mesh, name, index));
}

uint32_t generate_hard_quad(generate_mesh *mesh, const double box[4], double z) {
    uint32_t first = generate_vertex(mesh, box[0], box[1], z);
    generate_vertex(mesh, box[2], box[1], z);
    generate_vertex(mesh, box[2], box[3], z);
    generate_vertex(mesh, box[0], box[3], z);
    generate_triangle(mesh, first, first + 1, first + 2);
    generate_triangle(mesh, first, first + 2, first + 3);
    return first;
}

double generate_hard_between(generate_builder *b, double low, double high) {
    return floor(generate_between(&b->random, low, high) * 256) / 256;
}
