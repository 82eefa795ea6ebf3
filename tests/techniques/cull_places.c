/* SPDX-License-Identifier: MIT
 *
 * Where instances and cameras of the scenes of cull_scenes.h stand.
 */
#include "techniques/cull_internal.h"

#include <math.h>
#include <string.h>

/* ---- matrices, column-major ------------------------------------------------------------------ */

static void box_of(double x0, double x1, double y0, double y1, double z0, double z1,
                   float world[16]) {
    const double m[16] = {
        x1 - x0,       0, 0, 0, 0, y1 - y0, 0, 0, 0, 0, z1 - z0, 0, (x0 + x1) / 2, (y0 + y1) / 2,
        (z0 + z1) / 2, 1};
    for (int i = 0; i < 16; ++i)
        world[i] = (float)m[i];
}

/* Any rotation, a scale of its own for each axis, sometimes mirrored, flat or sheared. */
static void any_transform(cull_random *random, double smallest, double largest, const double at[3],
                          float world[16]) {
    double q[4], length = 0, scale[3];
    for (int i = 0; i < 4; ++i)
        q[i] = cull_between(random, -1, 1);
    for (int i = 0; i < 4; ++i)
        length += q[i] * q[i];
    length = length > 0 ? 1 / sqrt(length) : 0;
    if (cull_below(random, 3) == 0) { /* along the axes */
        memcpy(q, (double[4]){0, 0, 0, 1}, sizeof q);
        length = 1;
    }
    for (int i = 0; i < 4; ++i)
        q[i] *= length;
    for (int i = 0; i < 3; ++i)
        scale[i] = exp(cull_between(random, log(smallest), log(largest)));
    if (cull_below(random, 4) == 0)
        scale[cull_below(random, 3)] *= -1;
    if (cull_below(random, 8) == 0)
        scale[cull_below(random, 3)] = 0;
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y + z * w),     2 * (x * z - y * w),
                         2 * (x * y - z * w),     1 - 2 * (x * x + z * z), 2 * (y * z + x * w),
                         2 * (x * z + y * w),     2 * (y * z - x * w),     1 - 2 * (x * x + y * y)};
    memset(world, 0, 16 * sizeof *world);
    world[15] = 1;
    const double shear = cull_below(random, 4) == 0 ? cull_between(random, -2, 2) : 0;
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
            world[column * 4 + row] = (float)(r[column * 3 + row] * scale[column]);
        world[4 + row] += (float)shear * world[row];
        world[12 + row] = (float)at[row];
    }
}

static void anywhere(cull_random *random, double reach, double at[3]) {
    for (int i = 0; i < 3; ++i)
        at[i] = cull_between(random, -reach, reach);
}

/* ---- a hole of one pixel: one unit is one pixel, the image's centre is the origin -------------
 */

void cull_wall(uint32_t width, uint32_t height, uint32_t x, uint32_t y,
               float world[CULL_WALL][16]) {
    const double w = width * 0.5, h = height * 0.5, left = x - w, low = y - h;
    box_of(-w - 4, left, -h - 4, h + 4, 0, 0, world[0]);
    box_of(left + 1, w + 4, -h - 4, h + 4, 0, 0, world[1]);
    box_of(left, left + 1, -h - 4, low, 0, 0, world[2]);
    box_of(left, left + 1, low + 1, h + 4, 0, 0, world[3]);
}

void cull_behind(cull_random *random, uint32_t width, uint32_t height, uint32_t x, uint32_t y,
                 float world[16]) {
    static const double reaches[] = {0, 0.25, 0.49, 0.5, 0.51, 0.75, 1};
    const double hole[2] = {x - width * 0.5, y - height * 0.5};
    double low[2], high[2];
    for (int axis = 0; axis < 2; ++axis) {
        const double size = axis ? height : width;
        const double reach = reaches[cull_below(random, 7)];
        const double long_side = cull_between(random, 0, cull_below(random, 2) ? size : 8);
        switch (cull_below(random, 4)) {
        case 0: /* from below up to some place within the hole's pixel */
            high[axis] = hole[axis] + reach;
            low[axis] = high[axis] - long_side;
            break;
        case 1: /* from above */
            low[axis] = hole[axis] + 1 - reach;
            high[axis] = low[axis] + long_side;
            break;
        case 2: /* across it */
            low[axis] = hole[axis] - cull_between(random, 0, long_side);
            high[axis] = hole[axis] + 1 + cull_between(random, 0, long_side);
            break;
        default: /* anywhere */
            low[axis] = cull_between(random, -size * 0.5 - 2, size * 0.5 + 2);
            high[axis] = low[axis] + long_side;
        }
    }
    /* Few so close that roundings save them: of those in the hole only the nearest is visible. */
    static const double close[] = {0, 1e-6, 1e-4, 1e-3};
    const double front =
        cull_below(random, 8) ? -cull_between(random, 0.01, 60) : -close[cull_below(random, 4)];
    box_of(low[0], high[0], low[1], high[1], front - cull_below(random, 3), front, world);
}

/* ---- instances ------------------------------------------------------------------------------- */

static cull_instance place_near(cull_random *random, uint32_t number) {
    cull_instance in = {.mesh = CULL_BOX};
    double at[3];
    anywhere(random, 0.4, at);
    if (number < 6) { /* long walls past the eye, and boxes around it */
        const double side = number % 2 ? 0.3 : -0.3, reach = cull_between(random, 2, 80);
        if (number < 4)
            box_of(side + at[0] * 0.1, side * 1.2 + at[0] * 0.1, -2, number < 2 ? 2 : 0.1, -reach,
                   reach, in.world);
        else
            any_transform(random, 0.05, 3, at, in.world);
        return in;
    }
    anywhere(random, 30, at);
    any_transform(random, 0.05, 6, at, in.world);
    in.mesh = (uint32_t[]){CULL_BOX, CULL_QUAD, CULL_BALL}[number % 3];
    return in;
}

/* No two neighbours are of one mesh: each is a draw of its own. */
static cull_instance place_coplanar(cull_random *random, uint32_t number) {
    cull_instance in = {.mesh = number % 2 ? CULL_QUAD : CULL_OTHER_QUAD};
    const double x = cull_below(random, 33) * 0.5 - 8, y = cull_below(random, 33) * 0.5 - 8;
    const double w = (1 + cull_below(random, 16)) * 0.5, h = (1 + cull_below(random, 16)) * 0.5;
    const uint32_t plane = cull_below(random, 6);
    const double z = plane < 3 ? 0 : plane == 3 ? nextafterf(1, 2) - 1 : plane == 4 ? -1e-6 : -1;
    box_of(x, x + w, y, y + h, z, z, in.world);
    return in;
}

static cull_instance place_sliver(cull_random *random, uint32_t number) {
    cull_instance in = {.mesh = CULL_NEEDLE};
    double at[3];
    anywhere(random, 8, at);
    if (number < 4) { /* something to hide behind */
        in.mesh = CULL_BOX;
        any_transform(random, 4, 10, at, in.world);
        return in;
    }
    switch (number % 4) {
    case 0:
        any_transform(random, 0.5, 12, at, in.world);
        break;
    case 1: /* quads along the view */
        in.mesh = CULL_QUAD;
        any_transform(random, 0.2, 8, at, in.world);
        break;
    default:
        in.mesh = number % 4 == 2 ? CULL_BOX : CULL_BALL;
        any_transform(random, 1e-3, 2e-2, at, in.world);
    }
    return in;
}

static cull_instance place_any(const cull_case *c, cull_random *random, uint32_t number) {
    cull_instance in = {.mesh = (uint32_t[]){CULL_BOX, CULL_QUAD, CULL_BALL, CULL_BOX}[number % 4]};
    const int big = number < 5;
    double at[3];
    anywhere(random, big ? 6 : 10, at);
    any_transform(random, big ? 1 : 0.05, big ? 9 : 3, at, in.world);
    if (c->kind == CULL_CLUSTERS) {
        in.mesh = number % 4 == 3 ? CULL_BOX : CULL_BALL;
        any_transform(random, 0.5, 6, at, in.world);
    } else if (c->kind == CULL_GLASS && number >= 4 && number % 2) {
        in.mesh = number % 4 == 1 ? CULL_GLASS_BOX : CULL_GLASS_BALL;
    }
    return in;
}

cull_instance cull_place(const cull_case *c, cull_random *random, uint32_t number) {
    cull_instance in = {.mesh = CULL_BOX};
    switch (c->kind) {
    case CULL_HOLES: /* moved in every frame */
        in.mesh = number < CULL_WALL ? CULL_QUAD : CULL_BOX;
        box_of(0, 1, 0, 1, 0, 1, in.world);
        return in;
    case CULL_NEAR:
        return place_near(random, number);
    case CULL_COPLANAR:
        return place_coplanar(random, number);
    case CULL_SLIVERS:
        return place_sliver(random, number);
    default:
        return place_any(c, random, number);
    }
}

/* ---- cameras --------------------------------------------------------------------------------- */

strata_camera_pose cull_pose(const cull_case *c, cull_random *random, uint32_t height) {
    strata_camera_pose pose = {.struct_size = sizeof pose,
                               .near = 1e-3 * (1 << cull_below(random, 9))};
    const double reach = c->kind == CULL_NEAR ? 0.3 : cull_below(random, 3) ? 14 : 5;
    anywhere(random, reach, pose.eye);
    anywhere(random, 4, pose.target);
    pose.target[2] += 1e-3 + pose.eye[2] * (pose.target[2] == pose.eye[2]);
    anywhere(random, 1, pose.up);
    pose.yfov = cull_between(random, 10, 120);
    if (c->kind == CULL_HOLES) {
        pose = (strata_camera_pose){.struct_size = sizeof pose, .near = 1, .far = 200};
        pose.eye[2] = 100;
        pose.up[1] = 1;
        pose.height = height;
    } else if (c->kind == CULL_COPLANAR && cull_below(random, 4)) { /* at right angles */
        memcpy(pose.target, pose.eye, sizeof pose.eye);
        pose.eye[2] = 4 + cull_below(random, 8);
        pose.target[2] = 0;
        memcpy(pose.up, (double[3]){0, 1, 0}, sizeof pose.up);
        pose.height = cull_below(random, 2) ? 16 : 0;
    } else if (cull_below(random, 3) == 0) {
        pose.height = cull_between(random, 0.5, 30);
        pose.far = cull_below(random, 2) ? 0 : 40;
    }
    return pose;
}
