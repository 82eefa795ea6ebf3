/* SPDX-License-Identifier: MIT
 *
 * A camera's path as key poses in a JSON file, and the pose at a time. Calls nothing of the
 * library, so that tests take it alone; names of cameras are looked up by who reads the path.
 */
#ifndef STRATA_CLI_PATH_H
#define STRATA_CLI_PATH_H

#include <stddef.h>

#include "strata/host.h"

#define PATH_LINE 512u

typedef struct path_key {
    double time; /* seconds */
    int cut;     /* the pose before holds until this time */
    strata_camera_pose pose;
} path_key;

typedef struct cli_path { /* zero-initialised = empty; path_free */
    path_key *keys;       /* [count], count >= 1, times ascending */
    size_t count;
    int smooth; /* eye and target: 1 Catmull-Rom, 0 linear */
} cli_path;

/* The pose of a camera of the scene; 0 when there is none, with the reason in line. */
typedef int (*path_camera_fn)(void *user, const char *name, strata_camera_pose *out,
                              char line[PATH_LINE]);

/* Returns 1, or 0 with one line that names the file and the place in it, and nothing to free. */
int path_read(const char *file, path_camera_fn camera, void *user, cli_path *out,
              char line[PATH_LINE]);
void path_free(cli_path *p);

/* The pose at a time; the first and the last hold beyond their times. At a key's time it is that
 * key's, bit for bit. near is the smaller and far the larger of the keys on both sides. */
strata_camera_pose path_pose(const cli_path *p, double time);

/* Of frame i of `frames`: `fps` frames a second from the first key on; fps 0: spread evenly, the
 * first frame at the first key and the last at the last. */
double path_time(const cli_path *p, uint32_t frame, uint32_t frames, double fps);

/* Whether the eye is at its target in one of the frames; *frame is the first. */
int path_meets_target(const cli_path *p, uint32_t frames, double fps, uint32_t *frame);

#endif
