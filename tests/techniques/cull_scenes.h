/* SPDX-License-Identifier: MIT
 *
 * Scenes that are hard on occlusion culling, and what must hold of each frame of them: rendered
 * with culling and a checker beside a plain render of the same scene, frame by frame, while cameras
 * jump, objects move, appear and vanish, and the image changes its size. All from a seed.
 */
#ifndef STRATA_TESTS_CULL_SCENES_H
#define STRATA_TESTS_CULL_SCENES_H

#include "strata/host.h"

typedef enum cull_kind {
    CULL_HOLES,    /* a wall with a hole of one pixel, objects that reach just to it */
    CULL_NEAR,     /* walls beside the eye, boxes around it */
    CULL_RANDOM,   /* boxes, quads and balls in any transform: mirrored, sheared, flat */
    CULL_COPLANAR, /* quads at equal depths, or next to equal ones */
    CULL_SLIVERS,  /* needles, quads seen from the side, boxes far below a pixel */
    CULL_CLUSTERS, /* large meshes of many clusters */
    CULL_GLASS,    /* transparent objects before and behind opaque ones */
    CULL_DEFORM,   /* morph targets and skins that leave their rest bounds */
    CULL_KINDS
} cull_kind;

extern const char *const cull_kind_names[CULL_KINDS];

typedef struct cull_case {
    cull_kind kind;
    uint64_t seed;
    uint32_t objects; /* instances, about */
    uint32_t frames;
    uint32_t width, height;  /* of the first frame; 0: from the seed */
    uint32_t sweep_holes;    /* CULL_HOLES: the hole visits every pixel in turn, the size stays */
    uint32_t large;          /* sizes of up to 1919 x 1079 too */
    const char *settings[4]; /* of hiz, up to the first NULL, in place of those from the seed */
} cull_case;

typedef struct cull_counts {
    uint64_t frames, object_frames, wrong, overshot, ties,
        lost_pixels; /* lost: by overshot objects */
    uint64_t visible, outside, slipped, occluded, late;
    char failure[256]; /* the first one; "" = none */
} cull_counts;

/* Two instances of one backend: with culling and without. */
typedef struct cull_rig {
    strata *culled, *plain;
} cull_rig;

/* 0 and *rig empty when the backend cannot be opened here. */
int cull_open(const char *backend, int check, cull_rig *rig);
void cull_close(cull_rig *rig);

/* Called after each frame, before the next. */
typedef void (*cull_frame_fn)(void *user, strata *culled);

/* Runs the case and adds to the counts; with a failure it ends early. */
void cull_run(cull_rig *rig, const cull_case *c, cull_counts *counts, cull_frame_fn each,
              void *user);

/* The scene alone, loaded; NULL: strata_error has the line. */
strata_scene *cull_scene(strata *instance, const cull_case *c);

#endif
