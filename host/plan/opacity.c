/* SPDX-License-Identifier: MIT
 *
 * Optical depth of materials; see opacity.h. Vertex colours and textures vary together over a
 * surface in ways that only a rasteriser finds: the means of their alphas are multiplied.
 */
#include "plan/opacity.h"

#include <math.h>

#define SAMPLES 512u
#define LEAST   0x1p-24 /* transmittance */

static double mean_alpha_of_vertices(const scene_mesh *mesh) {
    const uint32_t stride = mesh->vertex_count / SAMPLES + 1;
    double sum = 0.0;
    uint32_t count = 0;
    for (uint32_t i = 0; mesh->colors && i < mesh->vertex_count; i += stride, count++)
        sum += (double)mesh->colors[(size_t)i * 4 + 3];
    return count ? sum / count : 1.0;
}

static double mean_of_image(const scene *s, uint32_t image, int channel) {
    if (image == SCENE_NONE)
        return 1.0;
    const scene_image *im = &s->images[image];
    const size_t pixels = (size_t)im->width * im->height, stride = pixels / SAMPLES + 1;
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < pixels; i += stride, count++)
        sum += im->pixels[i * 4 + (size_t)channel] / 255.0;
    return sum / (double)count;
}

double opacity_optical_depth(const scene *s, const scene_mesh *mesh) {
    const scene_material *m = &s->materials[mesh->material];
    const double color =
        fmax((double)m->base_color[0], fmax((double)m->base_color[1], (double)m->base_color[2]));
    const double alpha = m->alpha == SCENE_BLEND
                             ? (double)m->base_color[3] * mean_alpha_of_vertices(mesh) *
                                   mean_of_image(s, m->base_color_texture.image, 3)
                             : 1.0;
    const double lets =
        (double)m->transmission * mean_of_image(s, m->transmission_texture.image, 0) * color;
    return -log(fmin(fmax(1.0 - alpha * (1.0 - lets), LEAST), 1.0));
}
