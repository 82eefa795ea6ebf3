/* SPDX-License-Identifier: MIT
 *
 * Hard cases, "hard:NAME": fixed scenes of a few triangles, each of which asks one hard question of
 * a renderer. Data only; what must hold of each stands in tests/hard. Private to host/scene.
 */
#ifndef STRATA_HOST_SCENE_GENERATE_HARD_H
#define STRATA_HOST_SCENE_GENERATE_HARD_H

#include "scene/generate.h"

/* Either a procedural scene with these knobs, or built here with these values. */
typedef struct generate_hard_case {
    scene_hard_case shown;
    const char *of, *knobs[6];
    void (*build)(generate_builder *b); /* b->knobs are the values below */
    double values[2];
} generate_hard_case;

const generate_hard_case *generate_hard_find(const char *name); /* NULL: there is none */

/* ---- building blocks --------------------------------------------------------------------------
 */

/* Unlit, seen from both sides; alpha below 1 blends. */
scene_material generate_hard_material(double r, double g, double b, double alpha);
/* Ends a mesh of such a material and shows it. */
void generate_hard_show(generate_mesh *mesh, const char *name, const scene_material *material);
/* Two triangles in a plane of constant z; box: left, bottom, right, top. */
uint32_t generate_hard_quad(generate_mesh *mesh, const double box[4], double z);
/* A random multiple of 1/256. */
double generate_hard_between(generate_builder *b, double low, double high);

/* ---- generate_hard_geometry.c -----------------------------------------------------------------
 */
void generate_hard_crossing(generate_builder *b);
void generate_hard_slivers(generate_builder *b);
void generate_hard_near_plane(generate_builder *b);
void generate_hard_huge(generate_builder *b);
void generate_hard_tiny(generate_builder *b);
void generate_hard_depth_range(generate_builder *b);
void generate_hard_shared_edges(generate_builder *b);
void generate_hard_dust(generate_builder *b);
void generate_hard_screen(generate_builder *b);
void generate_hard_broken(generate_builder *b);  /* values: the coordinate that is no number */
void generate_hard_storage(generate_builder *b); /* values: layers, and how many in one pixel */

/* ---- generate_hard_color.c --------------------------------------------------------------------
 */
void generate_hard_bright(generate_builder *b); /* values: the brightest channel */
void generate_hard_nearly(generate_builder *b);
void generate_hard_straight(generate_builder *b);
void generate_hard_srgb(generate_builder *b);

#endif
