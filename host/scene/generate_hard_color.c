/* SPDX-License-Identifier: MIT
 *
 * Hard cases of colour: beyond what a payload holds, below zero, straight and premultiplied, linear
 * and sRGB. Every scene looks along -z at squares of constant depth.
 */
#include "scene/generate_hard.h"

#include <stdlib.h>

static generate_mesh begin_colored(generate_builder *b) {
    return generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_COLORS);
}

/* Blends, by the alpha of its vertices. */
static void show_colored(generate_builder *b, generate_mesh *mesh, const char *name) {
    scene_material material = generate_hard_material(1, 1, 1, 0.5);
    material.base_color[3] = 1;
    generate_hard_show(mesh, name, &material);
    generate_camera_flat(b, 1, 1, 1);
}

static void colored_quad(generate_mesh *mesh, const double box[4], double z, const float color[3],
                         double alpha) {
    uint32_t first = (uint32_t)mesh->vertex_count;
    for (int corner = 0; corner < 4; corner++) {
        generate_vertex(mesh, corner % 3 ? box[2] : box[0], corner / 2 ? box[3] : box[1], z);
        generate_color(mesh, color, alpha);
    }
    generate_triangle(mesh, first, first + 1, first + 2);
    generate_triangle(mesh, first, first + 2, first + 3);
}

/* Steps that overlap, so that a pixel sees up to eight; dim ones between the bright. */
void generate_hard_bright(generate_builder *b) {
    static const double alphas[8] = {0.5, 0.25, 0x1p-9, 0.75, 1 - 0x1p-24, 0, 0.125, 0.5};
    generate_mesh mesh = begin_colored(b);
    for (int i = 0; i < 8; i++) {
        const float top = i % 2 ? 0.75f : (float)b->knobs[0];
        const float color[3] = {top, top / 2, i % 4 ? 0.125f : top / 4};
        const double left = -1 + i / 8.0, box[4] = {left, -1 + i / 16.0, left + 1, 1 - i / 16.0};
        colored_quad(&mesh, box, -(i * 3 % 8 + 1) / 16.0, color, alphas[i]);
    }
    show_colored(b, &mesh, "steps");
}

/* A dark layer that lets 2^-24 through, of what is 2^20 bright. */
void generate_hard_nearly(generate_builder *b) {
    const double all[4] = {-1, -1, 1, 1};
    generate_mesh mesh = begin_colored(b);
    colored_quad(&mesh, all, -0.5, (const float[3]){0x1p20f, 0x1p19f, 0x1p18f}, 0.5);
    colored_quad(&mesh, all, -0.25, (const float[3]){0.25f, 0.25f, 0.25f}, 1 - 0x1p-24);
    colored_quad(&mesh, all, -0.75, (const float[3]){0x1p18f, 0x1p19f, 0x1p20f}, 1 - 0x1p-24);
    show_colored(b, &mesh, "layers");
}

static scene_texture texture(uint32_t image, scene_filter filter) {
    scene_texture t = scene_no_texture();
    t.image = image;
    t.magnify = t.minify = filter;
    t.mipmap = SCENE_MIP_NONE;
    t.wrap_u = t.wrap_v = SCENE_CLAMP;
    return t;
}

static void textured_quad(generate_builder *b, const char *name, const scene_material *material,
                          const double box[4], double z) {
    generate_mesh mesh = generate_mesh_begin(b, GENERATE_NORMALS | GENERATE_UV);
    uint32_t first = (uint32_t)mesh.vertex_count;
    for (int corner = 0; corner < 4; corner++) {
        const int right = corner == 1 || corner == 2, top = corner >= 2;
        generate_vertex(&mesh, box[right ? 2 : 0], box[top ? 3 : 1], z);
        generate_uv(&mesh, right, 1 - top);
    }
    generate_triangle(&mesh, first, first + 1, first + 2);
    generate_triangle(&mesh, first, first + 2, first + 3);
    generate_hard_show(&mesh, name, material);
}

/* Green discs on texels that are magenta and let everything through. */
void generate_hard_straight(generate_builder *b) {
    enum { SIDE = 8 };
    unsigned char *pixels = base_calloc((size_t)SIDE * SIDE, 4);
    for (int i = 0; pixels && i < SIDE * SIDE; i++) {
        const int x = i % SIDE % 4, y = i / SIDE % 4, inside = x > 0 && x < 3 && y > 0 && y < 3;
        unsigned char *p = pixels + 4 * i;
        p[0] = p[2] = inside ? 30 : 255;
        p[1] = inside ? 200 : 0;
        p[3] = inside ? 255 : 0;
    }
    b->failed |= !pixels;
    scene_material material = generate_hard_material(1, 1, 1, 0.5);
    material.base_color[3] = 1;
    material.base_color_texture =
        texture(generate_image(b, "discs", SIDE, SIDE, pixels), SCENE_LINEAR);
    textured_quad(b, "behind", &material, (const double[4]){-1, -1, 0.75, 0.75}, -0.5);
    textured_quad(b, "before", &material, (const double[4]){-0.75, -0.75, 1, 1}, -0.25);
    generate_camera_flat(b, 1, 1, 1);
}

/* Columns from the left: grey 188 of a texture, its linear value as a factor, half white over
 * black, half black over white. The last two are 1/2 exactly where blending is linear. */
void generate_hard_srgb(generate_builder *b) {
    const double grey = 0.50288645; /* ((188 / 255 + 0.055) / 1.055)^2.4 */
    unsigned char *pixels = base_calloc(1, 4);
    for (int i = 0; pixels && i < 4; i++)
        pixels[i] = i < 3 ? 188 : 255;
    b->failed |= !pixels;
    scene_material painted = generate_hard_material(1, 1, 1, 1);
    painted.base_color_texture = texture(generate_image(b, "grey", 1, 1, pixels), SCENE_NEAREST);
    textured_quad(b, "texture", &painted, (const double[4]){-1, -1, -0.5, 1}, -0.5);
    for (int i = 0; i < 3; i++) {
        const double shade = i ? i - 1 : grey, left = -0.5 + 0.5 * i;
        const double box[4] = {left, -1, left + 0.5, 1};
        scene_material solid = generate_hard_material(shade, shade, shade, 1);
        textured_quad(b, i ? "backdrop" : "factor", &solid, box, -0.5);
        scene_material half = generate_hard_material(2 - i, 2 - i, 2 - i, 0.5);
        if (i)
            textured_quad(b, "half", &half, box, -0.25);
    }
    generate_camera_flat(b, 1, 1, 1);
}
