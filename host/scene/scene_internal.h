/* SPDX-License-Identifier: MIT
 *
 * What those who build scenes share (the glTF loader, the generators): an empty scene, warnings,
 * defaults, and scene_finish, which derives everything that follows from meshes and instances.
 * Private to host/scene.
 */
#ifndef STRATA_HOST_SCENE_INTERNAL_H
#define STRATA_HOST_SCENE_INTERNAL_H

#include "scene/scene.h"

#define SCENE_MAX_IMAGE 16384u /* pixels along either side of an image */

/* An empty scene with a copy of `path`; NULL when out of memory. Its arrays are allocated with
 * base_calloc/base_realloc by whoever fills them and freed by scene_free, also when half filled:
 * a count never exceeds the elements that are valid or all zero. */
scene *scene_new(const char *path);

/* Adds one warning line; repeated text is kept once and at most 100 lines are kept. Running out of
 * memory loses the line, not the scene. */
void scene_warn(scene *s, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Values of glTF's defaults. name stays NULL; scene_finish fills absent names. */
scene_material scene_default_material(void);
scene_texture scene_no_texture(void);

void scene_identity(float matrix[16]);

/* Appends a zeroed element and returns its address, which is valid until the next append; NULL when
 * out of memory. capacity belongs to the caller and starts as 0. */
scene_mesh *scene_add_mesh(scene *s, size_t *capacity);
scene_instance *scene_add_instance(scene *s, size_t *capacity); /* identity, visible, no node */
scene_material *scene_add_material(scene *s, size_t *capacity); /* defaults */

/* Gives a triangle mesh flat unit normals. Vertices are no longer shared then: vertex_count becomes
 * index_count and every attribute is expanded. Triangles keep their order. Zero-area ones get +z.
 */
strata_result scene_flat_normals(scene_mesh *mesh, base_error *err);
/* The same again, after the positions of such an expanded mesh moved. */
void scene_flat_normals_update(scene_mesh *mesh);

/* To be called once, when meshes, instances, materials, lights and cameras stand:
 *  - absent names become "mesh 3" and the like; a mesh without material (SCENE_NONE) gets a default
 *    material, which is appended;
 *  - triangle meshes without normals get flat ones;
 *  - positions and indices are checked (finite, in range, whole triangles) and bounds computed;
 *  - instances are numbered (primitive_base) and primitive_count is checked to be < 2^32.
 * On failure the scene remains the caller's, to be freed. */
strata_result scene_finish(scene *s, base_error *err);

/* Recomputes mesh->lower/upper from positions and radii. Empty meshes: all zero. */
void scene_mesh_bounds(scene_mesh *mesh);
/* Recomputes s->lower/upper over the visible instances. */
void scene_bounds(scene *s);

void scene_deform_free(scene_deform *deform); /* NULL is fine */

/* ---- animations.c ---------------------------------------------------------------------------- */
void scene_animations_free(scene_animations *animations);

#endif
