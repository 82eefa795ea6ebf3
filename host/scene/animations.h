/* SPDX-License-Identifier: MIT
 *
 * What moves in a scene: the node hierarchy, keyframe channels and skins. Filled by the glTF
 * loader, evaluated by scene_set_time in three steps: channels -> node transforms -> deformed
 * vertices. Transforms are composed in double; the scene receives floats. Private to host/scene.
 */
#ifndef STRATA_HOST_SCENE_ANIMATIONS_H
#define STRATA_HOST_SCENE_ANIMATIONS_H

#include "scene/scene_internal.h"

typedef struct scene_pose {                       /* what a channel may move */
    double translation[3], rotation[4], scale[3]; /* rotation: unit quaternion x y z w */
} scene_pose;

typedef struct scene_node {
    uint32_t parent; /* or SCENE_NONE */
    uint32_t fixed;  /* 1: `matrix` holds and no channel moves it */
    double matrix[16];
    scene_pose rest, pose;
    float *rest_weights, *weights; /* [weight_count] of morph targets */
    uint32_t weight_count;
    double world[16];
} scene_node;

typedef enum scene_channel_path {
    SCENE_TRANSLATION,
    SCENE_ROTATION,
    SCENE_SCALE,
    SCENE_WEIGHTS
} scene_channel_path;
typedef enum scene_interpolation { SCENE_STEP, SCENE_SLOPE, SCENE_CUBIC } scene_interpolation;

typedef struct scene_channel {
    uint32_t node;
    scene_channel_path path;
    scene_interpolation interpolation;
    uint32_t key_count, width; /* width: floats of one value */
    float *times;              /* [key_count], finite, ascending, seconds */
    float *values; /* [key_count][width]; cubic: [key_count][3][width], in-tangent, value,
                      out-tangent */
} scene_channel;

typedef struct scene_skin {
    uint32_t joint_count;
    uint32_t *joints; /* nodes */
    float *inverse;   /* [joint_count][16] inverse bind matrices, or NULL: identities */
} scene_skin;

struct scene_animations {
    scene_node *nodes;
    uint32_t *order; /* every node after its parent */
    uint32_t node_count;
    scene_channel *channels;
    uint32_t channel_count;
    scene_skin *skins;
    uint32_t skin_count;
    double time; /* last evaluated; NAN: the rest pose */
};

/* Puts the scene into the pose of `time` (NAN: rest): nodes, then instances, lights, cameras and
 * deformed meshes with their bounds. Fails naming the node or mesh whose numbers overflow. */
strata_result scene_evaluate(scene *s, scene_animations *a, double time, base_error *err);

/* deform.c: vertices of every deformed mesh from the nodes' present transforms and weights. */
strata_result scene_deform_meshes(scene *s, const scene_animations *a, base_error *err);

/* matrix.c: column-major, double. */
void scene_compose(const scene_pose *pose, double matrix[16]);
void scene_multiply(const double a[16], const double b[16], double out[16]); /* out: neither */
/* Unit length; a zero quaternion becomes the identity. */
void scene_normalize_rotation(double q[4]);
/* To float; 0 when an element is not finite then. */
int scene_narrow(const double from[16], float to[16]);
/* The rigid part of a matrix: origin and right-handed unit axes, z kept, then y. A degenerate axis
 * is replaced by a perpendicular one. */
void scene_rigid(const double from[16], float to[16]);

#endif
