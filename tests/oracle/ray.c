/* SPDX-License-Identifier: MIT
 *
 * The ray oracle's geometry: every triangle and splat of a scene projected in double, and where the
 * ray through a pixel's centre meets it. See oracle.h.
 *
 * A corner in clip space is kept as V = (X, Y, W), its window coordinates times w, and Z. The point
 * of the triangle that a pixel p = (x, y, 1) shows is sum b_k V_k = p, so b = (V_0 V_1 V_2)^-1 p:
 * three functions linear in x and y, all >= 0 inside (also when a corner is behind the eye), and
 * depth is sum b_k Z_k, linear too. Its distance from an edge is b_k over the length of b_k's
 * gradient.
 *
 * A rasteriser moves each corner: by rounding it to a grid of 1/256 pixel (half of that in x and in
 * y, which is less than 1/256 in all), and by the roundings of the vertex stage. Coverage is then
 * that of a triangle whose every point moved by no more than that, so a centre further from the
 * outline is inside or outside without doubt.
 */
#include "oracle/oracle.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GRID         (1.0 / 256.0)
#define SPLAT_PIXELS 1.5          /* radius of a splat that has none of its own */
#define GUARD_BAND   16384.0      /* clippers keep window coordinates within */
#define CLIP_GRID    (1.0 / 64.0) /* of the near and far planes: clippers interpolate in float */

/* ---- projecting ------------------------------------------------------------------------------ */

typedef struct camera {
    const scene_view *view;
    double width, height;
} camera;

/* World position and the error of its float computation: three products and sums in a row. */
static void to_world(const scene_instance *instance, const float *p, double world[3],
                     double error[3], int *exact) {
    const double gamma = oracle_gamma(4, ORACLE_UNIT);
    for (int i = 0; i < 3; i++) {
        double size = fabs((double)instance->world[12 + i]);
        world[i] = 0;
        for (int k = 0; k < 3; k++) {
            const double term = (double)instance->world[4 * k + i] * (double)p[k];
            world[i] += term;
            size += fabs(term);
            *exact &= term == (double)(float)term && world[i] == (double)(float)world[i];
        }
        world[i] += (double)instance->world[12 + i];
        *exact &= world[i] == (double)(float)world[i];
        error[i] = gamma * size;
    }
}

/* Corner k of the shape. */
static void project(const camera *c, const double world[3], const double world_error[3],
                    oracle_shape *s, int k) {
    const float *m = c->view->world_to_clip;
    const double gamma = oracle_gamma(4, ORACLE_UNIT);
    double clip[4], error[4];
    for (int i = 0; i < 4; i++) {
        double size = fabs((double)m[12 + i]), moved = 0;
        clip[i] = 0;
        for (int j = 0; j < 3; j++) {
            const double term = (double)m[4 * j + i] * world[j];
            clip[i] += term;
            size += fabs(term);
            moved += fabs((double)m[4 * j + i]) * world_error[j];
            if (i >= 2)
                s->exact &= term == (double)(float)term && clip[i] == (double)(float)clip[i];
        }
        clip[i] += (double)m[12 + i];
        if (i >= 2)
            s->exact &= clip[i] == (double)(float)clip[i];
        error[i] = gamma * (size + moved) + moved;
    }
    s->corner[k][0] = (clip[0] + clip[3]) * c->width / 2;
    s->corner[k][1] = (clip[1] + clip[3]) * c->height / 2;
    s->error[k][0] = (error[0] + error[3]) * c->width / 2;
    s->error[k][1] = (error[1] + error[3]) * c->height / 2;
    for (int i = 2; i < 4; i++) {
        s->corner[k][i] = clip[i];
        s->error[k][i] = error[i];
    }
}

/* ---- setting up ------------------------------------------------------------------------------ */

static void cross(const double a[3], const double b[3], double out[3]) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/* Window coordinates' bounds: those of the corners, or the image's when one is behind the eye. */
static void bound(const camera *c, oracle_shape *s) {
    const double all[4] = {0, 0, c->width, c->height};
    s->box[0] = s->box[1] = INFINITY;
    s->box[2] = s->box[3] = -INFINITY;
    s->reach = 0;
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 2; i++) {
            const double at = s->corner[k][i] / s->corner[k][3];
            if (!(s->corner[k][3] > 0) || fabs(at) > GUARD_BAND) {
                memcpy(s->box, all, sizeof s->box);
                s->reach = GUARD_BAND;
                return;
            }
            s->box[i] = fmin(s->box[i], at);
            s->box[2 + i] = fmax(s->box[2 + i], at);
            s->reach = fmax(s->reach, fabs(at));
        }
    for (int i = 0; i < 4; i++)
        s->box[i] += i < 2 ? -1 : 1;
}

/* Depth one pixel away, as a rasteriser computes it in float from differences of the corners: each
 * product with a few roundings, over twice the area. */
static double slope_error(const oracle_shape *s, double twice_area) {
    double at[3][3];
    if (s->reach >= GUARD_BAND)
        return 16 * ORACLE_UNIT * (fabs(s->plane[0]) + fabs(s->plane[1]));
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 3; i++)
            at[k][i] = s->corner[k][i] / s->corner[k][3];
    double terms = 0;
    for (int i = 0; i < 2; i++)
        terms += fabs((at[1][2] - at[0][2]) * (at[2][i] - at[0][i])) +
                 fabs((at[2][2] - at[0][2]) * (at[1][i] - at[0][i]));
    return 16 * ORACLE_UNIT * terms / twice_area;
}

/* The linear functions of x and y, from the corners. */
static void set_up(const camera *c, oracle_shape *s) {
    double v[3][3], area = 0, longest = 0;
    for (int k = 0; k < 3; k++) {
        v[k][0] = s->corner[k][0];
        v[k][1] = s->corner[k][1];
        v[k][2] = s->corner[k][3];
    }
    for (int k = 0; k < 3; k++)
        cross(v[(k + 1) % 3], v[(k + 2) % 3], s->weight[k]);
    const double det =
        v[0][0] * s->weight[0][0] + v[0][1] * s->weight[0][1] + v[0][2] * s->weight[0][2];
    bound(c, s);
    for (int i = 0; i < 3; i++)
        s->plane[i] = 0;
    for (int k = 0; k < 3 && det != 0; k++)
        for (int i = 0; i < 3; i++) {
            s->weight[k][i] /= det;
            s->plane[i] += s->weight[k][i] * s->corner[k][2];
        }
    s->height = INFINITY; /* of a corner over its edge: b_k there is 1 / w_k */
    for (int k = 0; k < 3; k++) {
        const double slope = hypot(s->weight[k][0], s->weight[k][1]);
        s->height = fmin(s->height, det == 0 ? 0 : fabs(1 / (v[k][2] * slope)));
        const double *a = v[k], *b = v[(k + 1) % 3];
        longest = fmax(longest, hypot(a[0] / a[2] - b[0] / b[2], a[1] / a[2] - b[1] / b[2]));
    }
    area = s->height * longest;
    s->slope_error = det == 0 ? INFINITY : slope_error(s, area);
    for (int k = 0; k < 3; k++) /* constant, by the corners alone */
        s->exact &= s->corner[k][3] == 1 && s->corner[k][2] == s->corner[0][2];
    if (s->exact) {
        s->plane[0] = s->plane[1] = 0;
        s->plane[2] = s->corner[0][2];
    }
    /* orientation on the screen: counter-clockwise is the front, unless the instance mirrors */
    s->exists = s->exists || det > 0;
}

static double determinant(const float m[16]) {
    const double a[3] = {(double)m[0], (double)m[1], (double)m[2]},
                 b[3] = {(double)m[4], (double)m[5], (double)m[6]},
                 c[3] = {(double)m[8], (double)m[9], (double)m[10]};
    double n[3];
    cross(b, c, n);
    return a[0] * n[0] + a[1] * n[1] + a[2] * n[2];
}

/* ---- triangles and splats ---------------------------------------------------------------------
 */

/* Whether a constant alpha passes the test of a MASK material. */
static int passes(const scene_material *m) {
    return m->alpha != SCENE_MASK || m->base_color[3] >= m->alpha_cutoff;
}

static void make_triangle(const camera *c, const scene_instance *instance, const scene_mesh *mesh,
                          const scene_material *material, uint32_t number, oracle_shape *s) {
    const int mirrored = determinant(instance->world) < 0;
    int exact = 1;
    for (int k = 0; k < 3; k++) {
        /* the other way round where the instance mirrors: then the front is counter-clockwise */
        const int to = mirrored && k ? 3 - k : k;
        double world[3], error[3];
        s->position[k] = mesh->positions + 3 * (size_t)mesh->indices[3 * number + (uint32_t)k];
        to_world(instance, s->position[k], world, error, &exact);
        s->exact = (uint32_t)exact;
        project(c, world, error, s, to);
        exact &= (int)s->exact;
    }
    if (mirrored) { /* of the corners as they are now */
        const float *kept = s->position[1];
        s->position[1] = s->position[2];
        s->position[2] = kept;
    }
    s->exists = material->double_sided;
    set_up(c, s);
    s->exists = s->exists && passes(material);
}

/* A disc in the plane of its centre, facing the image plane, as a triangle around it: the corners
 * are at (-1, -1), (3, -1), (-1, 3) of the disc. */
static void make_splat(const camera *c, const scene_instance *instance, const scene_mesh *mesh,
                       uint32_t number, oracle_shape *s) {
    static const double corners[3][2] = {{-1, -1}, {3, -1}, {-1, 3}};
    const float *eye = c->view->world_to_eye;
    double world[3], error[3];
    int exact = 0;
    to_world(instance, mesh->positions + 3 * (size_t)number, world, error, &exact);
    for (int k = 0; k < 3; k++) {
        double at[3];
        const double scale = cbrt(fabs(determinant(instance->world)));
        const double radius = mesh->radii ? (double)mesh->radii[number] * scale : 0;
        for (int i = 0; i < 3; i++)
            at[i] = world[i] + radius * ((double)eye[4 * i] * corners[k][0] +
                                         (double)eye[4 * i + 1] * corners[k][1]);
        s->exact = 0;
        project(c, at, error, s, k);
        for (int i = 0; i < 2 && !mesh->radii; i++)
            s->corner[k][i] += corners[k][i] * SPLAT_PIXELS * s->corner[k][3];
    }
    s->disc = s->exists = 1;
    set_up(c, s);
}

static uint32_t primitives(const scene_mesh *mesh) {
    return mesh->topology == SCENE_TRIANGLES ? mesh->index_count / 3 : mesh->vertex_count;
}

void oracle_shapes_make(const scene *s, const scene_view *view, uint32_t width, uint32_t height,
                        oracle_shapes *out) {
    const camera c = {view, width, height};
    uint32_t total = 0;
    out->first = base_calloc(s->instance_count + 1, sizeof *out->first);
    assert_non_null(out->first);
    for (uint32_t i = 0; i < s->instance_count; i++)
        out->first[i + 1] = out->first[i] + primitives(&s->meshes[s->instances[i].mesh]);
    out->at = base_calloc(out->first[s->instance_count] + 1, sizeof *out->at);
    assert_non_null(out->at);
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_instance *instance = &s->instances[i];
        const scene_mesh *mesh = &s->meshes[instance->mesh];
        const scene_material *material = &s->materials[mesh->material];
        for (uint32_t k = 0; k < primitives(mesh) && instance->visible; k++) {
            oracle_shape *shape = &out->at[total++];
            *shape = (oracle_shape){.primitive = out->first[i] + k,
                                    .instance = i,
                                    .transparent = (uint32_t)oracle_transparent(material)};
            if (mesh->topology == SCENE_TRIANGLES)
                make_triangle(&c, instance, mesh, material, k, shape);
            else
                make_splat(&c, instance, mesh, k, shape);
        }
    }
    out->count = total;
}

void oracle_shapes_free(oracle_shapes *shapes) {
    free(shapes->at);
    free(shapes->first);
    *shapes = (oracle_shapes){0};
}

int oracle_same_depth(const oracle_shape *a, const oracle_shape *b) {
    if (a->exact && b->exact)
        return a->plane[2] == b->plane[2];
    for (int k = 0; k < 3; k++)
        if (a->disc || b->disc ||
            memcmp(a->position[k], b->position[k], 3 * sizeof *a->position[k]) != 0)
            return 0;
    return memcmp(a->corner, b->corner, sizeof a->corner) == 0;
}

/* ---- casting --------------------------------------------------------------------------------- */

static double at_pixel(const double f[3], double x, double y) {
    return f[0] * x + f[1] * y + f[2];
}

/* How far the point that (x, y) shows may be moved on the screen, in pixels: as a mean of what its
 * corners are moved, so no more than the most of them; with corners behind the eye, whose shares
 * may exceed 1, by their shares. */
static double moved(const oracle_shape *s, const double b[3], double x, double y) {
    double sum = 0, most = 0;
    for (int k = 0; k < 3; k++) {
        const double error = s->error[k][0] + s->error[k][1] + (fabs(x) + fabs(y)) * s->error[k][3];
        sum += fabs(b[k]) * error;
        most = fmax(most, error / s->corner[k][3]);
    }
    return GRID + (s->reach < GUARD_BAND ? most : sum) + 4 * ORACLE_UNIT * s->reach;
}

/* Position on a splat's disc. */
static void on_disc(const oracle_shape *s, double x, double y, double out[2]) {
    double b[3], sum = 0;
    for (int k = 0; k < 3; k++)
        sum += b[k] = at_pixel(s->weight[k], x, y);
    out[0] = (3 * b[1] - b[0] - b[2]) / sum;
    out[1] = (3 * b[2] - b[0] - b[1]) / sum;
}

/* Distance from the disc's rim in pixels, positive inside; the less of the two that an ellipse has.
 */
static double from_rim(const oracle_shape *s, double x, double y) {
    double here[2], right[2], above[2];
    on_disc(s, x, y, here);
    on_disc(s, x + 1, y, right);
    on_disc(s, x, y + 1, above);
    const double slope = fmax(fabs(right[0] - here[0]), fabs(above[1] - here[1]));
    return (1 - hypot(here[0], here[1])) / slope;
}

static double depth_tolerance(const oracle_shape *s, const double b[3], double depth,
                              double shift) {
    const double slope = hypot(s->plane[0], s->plane[1]);
    const double span =
        s->reach < GUARD_BAND ? hypot(s->box[2] - s->box[0], s->box[3] - s->box[1]) : GUARD_BAND;
    double error = slope * shift + s->slope_error * span;
    for (int k = 0; k < 3; k++)
        error += fabs(b[k]) * (s->error[k][2] + fabs(depth) * s->error[k][3]);
    return error + 8 * ORACLE_UNIT * (fabs(depth) + slope * span);
}

/* Whether the point lies beyond (1), at (0) or well before (-1) a clip plane, which `distance` in
 * depth is from it; corners that are all on the right side are never clipped. */
static int against_plane(const oracle_shape *s, double distance, double tolerance, int far) {
    int cut = 0;
    for (int k = 0; k < 3; k++) {
        const double room = far ? s->corner[k][2] : s->corner[k][3] - s->corner[k][2];
        cut |= !(room > s->error[k][2] + s->error[k][3]);
    }
    if (!cut)
        return -1;
    if (s->exact)
        return distance < 0 ? 1 : -1;
    const double grid = tolerance + CLIP_GRID * hypot(s->plane[0], s->plane[1]);
    return distance < -grid ? 1 : distance > grid ? -1 : 0;
}

/* Two corners that are one point give no area, wherever they are snapped to. */
static int has_point_twice(const oracle_shape *s) {
    int twice = 0;
    for (int k = 0; k < 3; k++)
        twice |= memcmp(s->corner[k], s->corner[(k + 1) % 3], sizeof s->corner[k]) == 0;
    return twice;
}

oracle_hit oracle_cast(const oracle_shape *s, double x, double y) {
    oracle_hit hit = {.cover = ORACLE_OUTSIDE};
    double b[3];
    if (!s->exists || x < s->box[0] || y < s->box[1] || x > s->box[2] || y > s->box[3])
        return hit;
    if (has_point_twice(s))
        return hit;
    if (s->height == 0)
        return (oracle_hit){.cover = ORACLE_EDGE, .edges = 7, .tolerance = 1};
    for (int k = 0; k < 3; k++)
        b[k] = at_pixel(s->weight[k], x, y);
    const double shift = moved(s, b, x, y);
    for (int k = 0; k < (s->disc ? 1 : 3); k++) {
        const double distance =
            s->disc ? from_rim(s, x, y) : b[k] / hypot(s->weight[k][0], s->weight[k][1]);
        if (distance < -shift || isnan(distance))
            return hit;
        hit.edges |= distance < shift ? 1u << k : 0u;
    }
    hit.depth = at_pixel(s->plane, x, y);
    hit.tolerance = s->exact ? 0 : depth_tolerance(s, b, hit.depth, shift);
    for (int far = 0; far < 2; far++) {
        const int beyond = against_plane(s, far ? hit.depth : 1 - hit.depth, hit.tolerance, far);
        if (beyond > 0)
            return (oracle_hit){.cover = ORACLE_OUTSIDE};
        hit.edges |= beyond == 0 ? 8u << far : 0u;
    }
    hit.cover = hit.edges ? ORACLE_EDGE : ORACLE_INSIDE;
    return hit;
}
