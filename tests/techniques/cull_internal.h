/* SPDX-License-Identifier: MIT
 *
 * What the parts of cull_scenes.h share: meshes, and where instances and cameras stand.
 */
#ifndef STRATA_TESTS_CULL_INTERNAL_H
#define STRATA_TESTS_CULL_INTERNAL_H

#include "techniques/cull_scenes.h"

typedef uint64_t cull_random;
uint64_t cull_bits(cull_random *random);
uint32_t cull_below(cull_random *random, uint32_t count);
double cull_between(cull_random *random, double low, double high);

typedef enum cull_mesh { /* within [-1/2, 1/2]^3 */
                         CULL_BOX,
                         CULL_QUAD,
                         CULL_OTHER_QUAD, /* of other colours */
                         CULL_BALL,       /* of several clusters */
                         CULL_NEEDLE,
                         CULL_GLASS_BOX,
                         CULL_GLASS_BALL,
                         CULL_MESHES
} cull_mesh;

typedef struct cull_instance {
    uint32_t mesh;
    float world[16];
} cull_instance;

/* Instance `number` of the case; may be called again to move it. */
cull_instance cull_place(const cull_case *c, cull_random *random, uint32_t number);

/* CULL_HOLES: instances 0 to 3 are the wall, the hole is pixel (x, y). */
enum { CULL_WALL = 4 };
void cull_wall(uint32_t width, uint32_t height, uint32_t x, uint32_t y, float world[CULL_WALL][16]);
/* And one of the others, which knows where the hole is. */
void cull_behind(cull_random *random, uint32_t width, uint32_t height, uint32_t x, uint32_t y,
                 float world[16]);

strata_camera_pose cull_pose(const cull_case *c, cull_random *random, uint32_t height);

#endif
