/* SPDX-License-Identifier: MIT
 *
 * From a scene, the name of a camera and the size of the image to matrices. Everything is computed
 * in double and rounded once, so that huge, tiny and empty scenes give finite floats. The depth
 * convention is that of strata/gpu.h: reversed, 1 at the near plane, 0 at the far one or at
 * infinity.
 */
#ifndef STRATA_HOST_SCENE_CAMERA_H
#define STRATA_HOST_SCENE_CAMERA_H

#include "scene/scene.h"
#include "strata/host.h"

/* Matrices are column-major for column vectors; every float is finite. */
typedef struct scene_view {
    float world_to_eye[16]; /* rigid; the eye looks along -z, y up */
    float eye_to_clip[16];
    float world_to_clip[16];
    float clip_to_world[16];
    float eye[4]; /* world position, w = 1; orthographic: unit direction to the eye, w = 0 */
    uint32_t orthographic; /* 0 or 1 */
    uint32_t from_scene;   /* 1: a camera of the scene, 0: orbit or pose */
    double near, far;      /* distances along the view axis, > 0; far 0 = infinite */
    double half_width,
        half_height; /* of the image plane: at distance 1; orthographic: in scene units */
} scene_view;

/* camera: a camera's name, else its index, else "orbit:AZIMUTH,ELEVATION" in degrees; NULL or "" is
 * the scene's first camera, or orbit:30,20 when it has none. Azimuth 0 looks along -z, growing
 * azimuth moves the eye towards +x; the distance frames the bounds of what is visible. A camera of
 * the scene keeps its vertical field of view and takes the image's aspect. turn: degrees that the
 * whole camera is rotated about the vertical (y) through the centre of the scene's bounds.
 * NOT_FOUND (with what there is), INVALID_ARGUMENT. width, height > 0. */
strata_result scene_view_make(const scene *s, const char *camera, double turn, uint32_t width,
                              uint32_t height, scene_view *view, base_error *err);

typedef struct scene_box {
    float lower[3], upper[3]; /* lower > upper when empty */
} scene_box;

/* The same of a camera that is named, or given by its pose. bounds: what an orbit frames and a turn
 * goes about, NULL = those that the scene has now. pose: NULL = the named camera; it is checked. */
strata_result scene_view_choose(const scene *s, const char *camera, const strata_camera_pose *pose,
                                const scene_box *bounds, double turn, uint32_t width,
                                uint32_t height, scene_view *view, base_error *err);

/* The pose of a named camera. Its view is that of the camera, but for the last bits. */
strata_result scene_pose(const scene *s, const char *camera, uint32_t width, uint32_t height,
                         strata_camera_pose *pose, base_error *err);

/* Distance from the eye's plane along the view axis of a depth value in [0, 1]; +inf for 0 when far
 * is infinite. */
double scene_view_distance(const scene_view *view, double depth);

#endif
