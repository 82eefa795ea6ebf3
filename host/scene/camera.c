/* SPDX-License-Identifier: MIT
 *
 * Choice of a camera and its matrices, in double: the orbit that frames the bounds, the cameras of
 * a scene, reversed projections and their inverses written out, never computed by elimination.
 */
#include "scene/camera.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI               3.14159265358979323846
#define ORBIT_YFOV       (45.0 * PI / 180.0)
#define ORBIT_MARGIN     1.06  /* of the picture over what it frames */
#define SMALLEST_NEAR    1e-30 /* its reciprocal is a float too */
#define LARGEST_DISTANCE 1e37
#define LARGEST_POSE     1e30  /* of a pose's numbers: their squares' sums are finite */
#define PARALLEL         1e-12 /* sine of the angle below which two directions are one */

/* A camera before it becomes matrices: columns of world are right, up, back and position. */
typedef struct placement {
    double right[3], up[3], back[3], position[3];
} placement;

typedef struct lens {
    int orthographic;
    double yfov;        /* radians */
    double half_height; /* orthographic */
    double near, far;   /* 0: none is given */
} lens;

typedef struct framing {
    double centre[3], half[3]; /* half extents, > 0 */
    double radius;             /* of the sphere around the box */
} framing;

/* ---- small double algebra -------------------------------------------------------------------- */

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double c[3]) {
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

static void multiply(const double a[16], const double b[16], double c[16]) {
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += a[k * 4 + row] * b[column * 4 + k];
            c[column * 4 + row] = sum;
        }
}

static float to_float(double value) {
    if (isnan(value))
        return 0.0f;
    return (float)fmin(fmax(value, -(double)FLT_MAX), (double)FLT_MAX);
}

static void to_floats(const double m[16], float out[16]) {
    for (int i = 0; i < 16; i++)
        out[i] = to_float(m[i]);
}

/* Sine and cosine of an angle in degrees, exact at multiples of 90. */
static void sine_cosine(double degrees, double *sine, double *cosine) {
    double quarter = nearbyint(degrees / 90.0);
    double rest = (degrees - quarter * 90.0) * (PI / 180.0);
    double s = sin(rest), c = cos(rest);
    switch ((int)fmod(quarter, 4.0) & 3) {
    case 0:
        *sine = s;
        *cosine = c;
        break;
    case 1:
        *sine = c;
        *cosine = -s;
        break;
    case 2:
        *sine = -s;
        *cosine = -c;
        break;
    default:
        *sine = -c;
        *cosine = s;
        break;
    }
}

/* ---- where the camera stands ----------------------------------------------------------------- */

static framing frame_bounds(const scene_box *s) {
    framing f = {.half = {1.0, 1.0, 1.0}};
    int empty = 0;
    for (int i = 0; i < 3; i++)
        empty |= !(s->lower[i] <= s->upper[i]);
    double largest = 0.0;
    for (int i = 0; i < 3 && !empty; i++) {
        f.centre[i] = 0.5 * ((double)s->lower[i] + (double)s->upper[i]);
        f.half[i] = 0.5 * ((double)s->upper[i] - (double)s->lower[i]);
        largest = fmax(largest, f.half[i]);
    }
    /* A single point is looked at from a distance that its coordinates can still resolve. */
    if (!empty && largest == 0.0) {
        double away = fmax(fabs(f.centre[0]), fmax(fabs(f.centre[1]), fabs(f.centre[2])));
        largest = fmax(1.0, away * 1e-3);
        f.half[0] = f.half[1] = f.half[2] = largest;
    }
    for (int i = 0; i < 3; i++)
        f.half[i] = fmin(fmax(f.half[i], SMALLEST_NEAR), LARGEST_DISTANCE);
    f.radius = sqrt(dot(f.half, f.half));
    return f;
}

/* The closest distance from which a perspective eye sees all eight corners. */
static double orbit_distance(const framing *f, const placement *p, const scene_view *view) {
    double distance = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        double offset[3];
        for (int i = 0; i < 3; i++)
            offset[i] = corner >> i & 1 ? f->half[i] : -f->half[i];
        double x = fabs(dot(offset, p->right)) / view->half_width;
        double y = fabs(dot(offset, p->up)) / view->half_height;
        distance = fmax(distance, dot(offset, p->back) + ORBIT_MARGIN * fmax(x, y));
    }
    return distance;
}

static void place_orbit(const framing *f, double azimuth, double elevation, double aspect,
                        placement *p, scene_view *view) {
    double sa, ca, se, ce;
    sine_cosine(azimuth, &sa, &ca);
    sine_cosine(fmin(fmax(elevation, -90.0), 90.0), &se, &ce);
    *p = (placement){.right = {ca, 0.0, -sa}, .back = {sa * ce, se, ca * ce}};
    cross(p->back, p->right, p->up);
    view->half_height = tan(ORBIT_YFOV / 2.0);
    view->half_width = view->half_height * aspect;
    double distance = orbit_distance(f, p, view);
    for (int i = 0; i < 3; i++)
        p->position[i] = f->centre[i] + p->back[i] * distance;
    view->near = fmax((distance - f->radius) * 0.5, distance * 1e-3);
}

/* The axes right and up for p->back, a unit vector; an axis of the world stands in for an `up` that
 * says nothing. */
static void place_axes(const double up[3], placement *p) {
    cross(up, p->back, p->right);
    double length = sqrt(dot(p->right, p->right));
    if (!(length > PARALLEL * sqrt(dot(up, up)))) {
        double other[3] = {fabs(p->back[1]) < 0.9 ? 0.0 : 1.0, fabs(p->back[1]) < 0.9, 0.0};
        cross(other, p->back, p->right);
        length = sqrt(dot(p->right, p->right));
    }
    for (int i = 0; i < 3; i++)
        p->right[i] /= length;
    cross(p->back, p->right, p->up);
}

/* Makes the axes of a camera's node orthonormal; a degenerate node looks along -z. */
static void place_camera(const scene_camera *camera, placement *p) {
    const float *m = camera->world;
    double up[3];
    for (int i = 0; i < 3; i++) {
        p->back[i] = (double)m[8 + i];
        up[i] = (double)m[4 + i];
        p->position[i] = (double)m[12 + i];
    }
    double length = sqrt(dot(p->back, p->back));
    for (int i = 0; i < 3; i++)
        p->back[i] = length > 0.0 ? p->back[i] / length : (i == 2 ? 1.0 : 0.0);
    place_axes(up, p);
}

static void place_pose(const strata_camera_pose *pose, placement *p) {
    for (int i = 0; i < 3; i++) {
        p->position[i] = pose->eye[i];
        p->back[i] = pose->eye[i] - pose->target[i];
    }
    double length = sqrt(dot(p->back, p->back));
    for (int i = 0; i < 3; i++)
        p->back[i] /= length;
    place_axes(pose->up, p);
}

static lens lens_of_camera(const scene_camera *camera) {
    return (lens){.orthographic = camera->projection == SCENE_ORTHOGRAPHIC,
                  .yfov = (double)camera->yfov,
                  .half_height = fabs((double)camera->ymag),
                  .near = (double)camera->znear,
                  .far = (double)camera->zfar};
}

static lens lens_of_pose(const strata_camera_pose *pose) {
    return (lens){.orthographic = pose->height > 0.0,
                  .yfov = pose->yfov * PI / 180.0,
                  .half_height = pose->height / 2.0,
                  .near = pose->near,
                  .far = pose->far};
}

static void look_through(const lens *glass, const framing *f, double aspect, scene_view *view) {
    double near = glass->near, far = glass->far;
    if (glass->orthographic) {
        view->orthographic = 1;
        view->half_height = glass->half_height > 0.0 ? glass->half_height : f->half[1];
        view->near = near > 0.0 ? near : 0.0;
        view->far = far > view->near ? far : view->near + 4.0 * f->radius;
    } else {
        double yfov = glass->yfov;
        if (!(yfov > 0.0 && yfov < PI))
            yfov = ORBIT_YFOV;
        view->half_height = tan(yfov / 2.0);
        view->near = near > 0.0 ? fmax(near, SMALLEST_NEAR) : f->radius * 1e-4;
        view->far = far > view->near ? far : 0.0;
    }
    view->half_width = view->half_height * aspect;
}

static void turn_about(const double centre[3], double degrees, placement *p) {
    double s, c;
    sine_cosine(degrees, &s, &c);
    double *vectors[4] = {p->right, p->up, p->back, p->position};
    for (int i = 0; i < 4; i++) {
        double *v = vectors[i], cx = i == 3 ? centre[0] : 0.0, cz = i == 3 ? centre[2] : 0.0;
        double x = v[0] - cx, z = v[2] - cz;
        v[0] = cx + c * x + s * z;
        v[2] = cz - s * x + c * z;
    }
}

/* ---- matrices -------------------------------------------------------------------------------- */

/* Reversed projections: clip z / w is 1 at near and 0 at far. */
static void project(const scene_view *view, double to_clip[16], double to_eye[16]) {
    double n = view->near, f = view->far;
    double x = 1.0 / view->half_width, y = 1.0 / view->half_height;
    memset(to_clip, 0, 16 * sizeof *to_clip);
    memset(to_eye, 0, 16 * sizeof *to_eye);
    to_clip[0] = x;
    to_clip[5] = y;
    to_eye[0] = view->half_width;
    to_eye[5] = view->half_height;
    if (view->orthographic) {
        to_clip[10] = 1.0 / (f - n);
        to_clip[14] = f / (f - n);
        to_clip[15] = 1.0;
        to_eye[10] = f - n;
        to_eye[14] = -f;
        to_eye[15] = 1.0;
        return;
    }
    double slope = f > 0.0 ? n / (f - n) : 0.0;
    double offset = f > 0.0 ? n * (f / (f - n)) : n;
    to_clip[10] = slope;
    to_clip[14] = offset;
    to_clip[11] = -1.0;
    to_eye[14] = -1.0;
    to_eye[11] = 1.0 / offset;
    to_eye[15] = slope / offset;
}

static void fill_matrices(const placement *p, scene_view *view) {
    double from_world[16] = {0}, to_world[16] = {0}, to_clip[16], to_eye[16], product[16];
    const double *axes[3] = {p->right, p->up, p->back};
    for (int axis = 0; axis < 3; axis++) {
        for (int i = 0; i < 3; i++) {
            from_world[i * 4 + axis] = axes[axis][i];
            to_world[axis * 4 + i] = axes[axis][i];
        }
        from_world[12 + axis] = -dot(axes[axis], p->position);
        to_world[12 + axis] = p->position[axis];
    }
    from_world[15] = to_world[15] = 1.0;
    project(view, to_clip, to_eye);
    to_floats(from_world, view->world_to_eye);
    to_floats(to_clip, view->eye_to_clip);
    multiply(to_clip, from_world, product);
    to_floats(product, view->world_to_clip);
    multiply(to_world, to_eye, product);
    to_floats(product, view->clip_to_world);
    for (int i = 0; i < 3; i++)
        view->eye[i] = to_float(view->orthographic ? p->back[i] : p->position[i]);
    view->eye[3] = view->orthographic ? 0.0f : 1.0f;
}

/* ---- choice ---------------------------------------------------------------------------------- */

/* A decimal number without exponent, whatever the locale; returns what follows it or NULL. */
static const char *read_number(const char *text, double *value) {
    double sign = *text == '-' ? -1.0 : 1.0, number = 0.0, scale = 1.0;
    int digits = 0;
    if (*text == '-' || *text == '+')
        text++;
    for (; *text >= '0' && *text <= '9'; text++, digits++)
        number = number * 10.0 + (*text - '0');
    if (*text == '.')
        for (text++; *text >= '0' && *text <= '9'; text++, digits++)
            number += (*text - '0') * (scale *= 0.1);
    *value = sign * number;
    return digits > 0 && number <= 1e9 ? text : NULL;
}

static int read_orbit(const char *text, double *azimuth, double *elevation) {
    text = read_number(text, azimuth);
    if (!text || *text != ',')
        return 0;
    text = read_number(text + 1, elevation);
    return text && *text == '\0';
}

static const scene_camera *find_camera(const scene *s, const char *name) {
    for (uint32_t i = 0; i < s->camera_count; i++)
        if (strcmp(s->cameras[i].name, name) == 0)
            return &s->cameras[i];
    char *end = NULL;
    unsigned long index = *name >= '0' && *name <= '9' ? strtoul(name, &end, 10) : 0;
    if (end && *end == '\0' && index < s->camera_count)
        return &s->cameras[index];
    return NULL;
}

static strata_result fail_unknown(const scene *s, const char *name, base_error *err) {
    base_text names = {0};
    for (uint32_t i = 0; i < s->camera_count && i < 16; i++)
        base_text_add(&names, "%s%u '%s'", i ? ", " : "", i, s->cameras[i].name);
    strata_result result = base_fail(
        err, STRATA_ERROR_NOT_FOUND,
        "%s: no camera '%s'; it has %s%s, and orbit:AZIMUTH,ELEVATION is always there", s->path,
        name, names.length ? names.data : "none", s->camera_count > 16 ? ".." : "");
    base_text_free(&names);
    return result;
}

/* NULL in *chosen: an orbit of these angles. */
static strata_result choose(const scene *s, const char *camera, const scene_camera **chosen,
                            double *azimuth, double *elevation, base_error *err) {
    *chosen = NULL;
    *azimuth = 30.0;
    *elevation = 20.0;
    if (!camera || !*camera) {
        *chosen = s->camera_count > 0 ? &s->cameras[0] : NULL;
        return STRATA_OK;
    }
    *chosen = find_camera(s, camera);
    if (!*chosen && strncmp(camera, "orbit:", 6) != 0)
        return fail_unknown(s, camera, err);
    if (!*chosen && !read_orbit(camera + 6, azimuth, elevation))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "camera '%s' is not orbit:AZIMUTH,ELEVATION in degrees", camera);
    return STRATA_OK;
}

static strata_result place_named(const scene *s, const char *camera, const framing *f,
                                 double aspect, placement *p, scene_view *view, base_error *err) {
    const scene_camera *chosen;
    double azimuth, elevation;
    strata_result r = choose(s, camera, &chosen, &azimuth, &elevation, err);
    if (r != STRATA_OK)
        return r;
    if (!chosen) {
        place_orbit(f, azimuth, elevation, aspect, p, view);
        return STRATA_OK;
    }
    const lens glass = lens_of_camera(chosen);
    view->from_scene = 1;
    place_camera(chosen, p);
    look_through(&glass, f, aspect, view);
    return STRATA_OK;
}

static scene_box bounds_of(const scene *s) {
    scene_box bounds;
    memcpy(bounds.lower, s->lower, sizeof bounds.lower);
    memcpy(bounds.upper, s->upper, sizeof bounds.upper);
    return bounds;
}

static strata_result refuse_pose(const char *what, base_error *err) {
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "pose: %s", what);
}

/* Copies what the caller knows of a pose; the rest is 0. */
static strata_result take_pose(const strata_camera_pose *given, strata_camera_pose *pose,
                               base_error *err) {
    *pose = (strata_camera_pose){0};
    if (!base_take(pose, sizeof *pose, given) || pose->reserved)
        return refuse_pose("struct_size is not set, or it is of a later version", err);
    const double numbers[] = {pose->eye[0],    pose->eye[1],    pose->eye[2], pose->target[0],
                              pose->target[1], pose->target[2], pose->up[0],  pose->up[1],
                              pose->up[2],     pose->yfov,      pose->height, pose->near,
                              pose->far};
    for (size_t i = 0; i < BASE_COUNT(numbers); i++)
        if (!(fabs(numbers[i]) <= LARGEST_POSE))
            return refuse_pose("a number is not finite or beyond 1e30", err);
    double view[3];
    for (int i = 0; i < 3; i++)
        view[i] = pose->eye[i] - pose->target[i];
    if (!(dot(view, view) > 0.0))
        return refuse_pose("the eye is at its target", err);
    if (pose->yfov < 0.0 || pose->yfov >= 180.0)
        return refuse_pose("yfov is not from 0 to below 180 degrees", err);
    if (pose->height < 0.0 || pose->near < 0.0)
        return refuse_pose("height or near is negative", err);
    if (pose->far != 0.0 && !(pose->far > pose->near))
        return refuse_pose("far is not beyond near", err);
    return STRATA_OK;
}

strata_result scene_view_choose(const scene *s, const char *camera, const strata_camera_pose *pose,
                                const scene_box *bounds, double turn, uint32_t width,
                                uint32_t height, scene_view *view, base_error *err) {
    *view = (scene_view){0};
    if (width == 0 || height == 0 || !isfinite(turn))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "a view needs a size and a finite turn");
    const double aspect = (double)width / (double)height;
    const scene_box own = bounds_of(s);
    const framing f = frame_bounds(bounds ? bounds : &own);
    strata_camera_pose taken;
    placement p;
    strata_result r =
        pose ? take_pose(pose, &taken, err) : place_named(s, camera, &f, aspect, &p, view, err);
    if (r != STRATA_OK)
        return r;
    if (pose) {
        const lens glass = lens_of_pose(&taken);
        place_pose(&taken, &p);
        look_through(&glass, &f, aspect, view);
    }
    if (turn != 0.0)
        turn_about(f.centre, turn, &p);
    fill_matrices(&p, view);
    return STRATA_OK;
}

strata_result scene_view_make(const scene *s, const char *camera, double turn, uint32_t width,
                              uint32_t height, scene_view *view, base_error *err) {
    return scene_view_choose(s, camera, NULL, NULL, turn, width, height, view, err);
}

strata_result scene_pose(const scene *s, const char *camera, uint32_t width, uint32_t height,
                         strata_camera_pose *pose, base_error *err) {
    const scene_box own = bounds_of(s);
    const framing f = frame_bounds(&own);
    scene_view view = {0};
    placement p;
    if (width == 0 || height == 0)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "a view needs a size");
    strata_result r = place_named(s, camera, &f, (double)width / (double)height, &p, &view, err);
    if (r != STRATA_OK)
        return r;
    /* The target is level with the centre of the scene, or a radius ahead where that is behind; and
     * so far that the eye's coordinates tell the two apart. */
    double to_centre[3], away = 0.0;
    for (int i = 0; i < 3; i++) {
        to_centre[i] = p.position[i] - f.centre[i];
        away = fmax(away, fabs(p.position[i]));
    }
    double distance = dot(to_centre, p.back);
    distance = fmax(distance > 0.0 ? distance : f.radius, 1e-6 * away);
    *pose = (strata_camera_pose){.struct_size = sizeof *pose,
                                 .yfov = atan(view.half_height) * 2.0 * 180.0 / PI,
                                 .near = view.near,
                                 .far = view.far};
    if (view.orthographic) {
        pose->yfov = 0.0;
        pose->height = 2.0 * view.half_height;
    }
    for (int i = 0; i < 3; i++) {
        pose->eye[i] = p.position[i];
        pose->target[i] = p.position[i] - p.back[i] * distance;
        pose->up[i] = p.up[i];
    }
    return STRATA_OK;
}

double scene_view_distance(const scene_view *view, double depth) {
    double n = view->near, f = view->far;
    if (view->orthographic)
        return f - depth * (f - n);
    return f > 0.0 ? n * f / (n + depth * (f - n)) : n / depth;
}
