/* SPDX-License-Identifier: MIT
 *
 * The GPU copy of a scene, owner "scene": vertex streams, indices, records, materials, textures,
 * lights, and the commands of the two draw lists. Made through gpu.h and handed to shaders as the
 * global Strata* blocks of shaders/strata; nothing is allocated for what a scene does not have.
 * Units and numbers are those of scene.h.
 */
#ifndef STRATA_HOST_UPLOAD_H
#define STRATA_HOST_UPLOAD_H

#include "gpu/gpu.h"
#include "scene/camera.h"
#include "scene/scene.h"

typedef struct upload upload;

typedef struct upload_counts {
    uint32_t lights, materials, records, textures;    /* strata_counts of the frame block */
    uint32_t opaque_draws, transparent_draws;         /* commands of each list */
    uint64_t opaque_triangles, transparent_triangles; /* visible; a splat counts as two */
    uint32_t objects; /* what techniques may cull one by one; 0 unless that was asked for */
} upload_counts;

typedef struct upload_options {
    const unsigned char *transparent; /* a byte for each material, 1 = drawn with
                                         draws.transparent/1; NULL: none is */
    uint32_t shuffle_seed; /* not 0: permutes the draws, and the triangles within each mesh, as
                              submitted; StrataPrimitiveMap maps them back: images do not change */
    uint32_t objects;      /* 1: meshes are cut into clusters, and each record is an object of
                              objects/1, with its bounds: blocks StrataObjects, StrataObjectStates */
} upload_options;

/* Copies the scene, sets the globals and the STRATA_HAS_* defines: programs are to be created after
 * this, and again after another scene was uploaded. One upload lives at a time on a device. A
 * stream that exceeds the device's storage range is refused by name (OVERFLOW). The scene is not
 * kept, but upload_update wants the same one. */
strata_result upload_create(gpu *g, const scene *s, const upload_options *options, upload **out,
                            base_error *err);

/* Follows the scene's edits: moved and hidden instances, deformed meshes, moved lights. Draw lists
 * whose number of commands changes get new handles. Outside recording. */
strata_result upload_update(upload *u, const scene *s, base_error *err);

/* When the scene has no lights of its own, one directional key light shines over the viewer's left
 * shoulder; this puts it where it belongs for the camera's first frame. It does not follow later
 * turns. No effect on scenes with lights and on unlit ones. Outside recording. */
strata_result upload_set_key_light(upload *u, const scene_view *first, base_error *err);

/* "draws.transparent/1": the materials said to be transparent; "draws.opaque/1": the others; each
 * in scene order. An empty list is a handle that draws nothing, made when first asked for. The zero
 * handle for other slots and when memory ran out. Valid until the next update. */
strata_draws upload_draws(upload *u, const char *slot);
strata_buffer upload_indices(const upload *u); /* that all draws take theirs from */

upload_counts upload_count(const upload *u);
uint64_t upload_bytes(const upload *u); /* device memory */

void upload_free(upload *u); /* NULL is fine; takes globals and defines back */

#endif
