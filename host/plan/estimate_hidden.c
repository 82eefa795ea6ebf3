/* SPDX-License-Identifier: MIT
 *
 * How much of what is opaque nobody sees: sampled triangles and the nearest points of sampled
 * objects, in one order from near to far. Triangles cover the cells of a coarse grid. Cover n times
 * over, of pieces that lie at random, leaves exp(-n) of a cell open; an object is hidden when all
 * of it is, which takes (1 + sqrt(its area / that of a piece))^2 pieces.
 */
#include "plan/estimate.h"

#include <math.h>
#include <stdlib.h>

#define CELLS     32
#define TRIANGLES 8192u /* samples, at most */
#define OBJECTS   4096u
#define CLUSTER   128.0 /* triangles of a large mesh that can be hidden on their own */

/* Fewer are not worth the time that it takes to ask. */
#define FEWEST_OBJECTS 64.0

typedef struct event {
    double depth;  /* grows with the distance */
    double weight; /* triangle: cells it covers, in all that it stands for; object: triangles */
    double area;   /* cells, of itself */
    double x0, y0, x1, y1; /* cells, inclusive */
    uint32_t object;       /* 0: a triangle */
} event;

typedef struct work {
    const scene *s;
    const estimate_view *view;
    const unsigned char *transparent;
    double to_clip[16]; /* of the instance at hand */
    event *events;
    uint32_t count;
    double outside; /* triangles of objects that the view does not hold */
} work;

typedef struct cell {
    double cover, pieces; /* times; of these, cover times area */
} cell;

#define NDC_TO_CELLS (CELLS * CELLS / 4.0) /* areas */

static int is_counted(const work *w, const scene_instance *instance) {
    const scene_mesh *mesh = &w->s->meshes[instance->mesh];
    return instance->visible && mesh->index_count > 0 && mesh->topology == SCENE_TRIANGLES &&
           !w->transparent[mesh->material];
}

static double clusters_of(const scene_mesh *mesh) {
    return mesh->deform ? 1.0 : ceil(mesh->index_count / 3.0 / CLUSTER);
}

static void take_instance(work *w, const scene_instance *instance) {
    const float *m = instance->world, *c = w->view->world_to_clip;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++) {
            double sum = 0.0;
            for (int k = 0; k < 4; k++)
                sum += (double)c[k * 4 + row] * (double)m[column * 4 + k];
            w->to_clip[column * 4 + row] = sum;
        }
}

static void project(const work *w, const double p[3], double clip[4]) {
    for (int row = 0; row < 4; row++)
        clip[row] = w->to_clip[row] * p[0] + w->to_clip[4 + row] * p[1] +
                    w->to_clip[8 + row] * p[2] + w->to_clip[12 + row];
}

static double cell_of(double ndc) {
    return fmin(fmax(floor((ndc * 0.5 + 0.5) * CELLS), 0.0), CELLS - 1.0);
}

/* ---- events ---------------------------------------------------------------------------------- */

/* A triangle that reaches the eye's plane is left out: it would be clipped. */
static void add_triangle(work *w, const scene_mesh *mesh, uint32_t triangle, double weight) {
    double x[3], y[3], depth = 0.0;
    for (int i = 0; i < 3; i++) {
        const float *v = mesh->positions + (size_t)mesh->indices[triangle * 3 + (uint32_t)i] * 3;
        double clip[4];
        project(w, (const double[3]){(double)v[0], (double)v[1], (double)v[2]}, clip);
        if (!(clip[3] > 0.0) || clip[2] > clip[3])
            return;
        x[i] = clip[0] / clip[3];
        y[i] = clip[1] / clip[3];
        depth = fmax(depth, 1.0 - clip[2] / clip[3]); /* it hides what lies behind all of it */
    }
    double middle_x = (x[0] + x[1] + x[2]) / 3.0, middle_y = (y[0] + y[1] + y[2]) / 3.0;
    double area = 0.5 * fabs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]));
    if (fabs(middle_x) > 1.0 || fabs(middle_y) > 1.0 || !(area > 0.0))
        return;
    if (!w->s->materials[mesh->material].double_sided)
        area *= 0.5; /* one of a closed surface's two sides is not drawn */
    event *e = &w->events[w->count++];
    *e = (event){
        .depth = depth, .weight = area * weight * NDC_TO_CELLS, .area = area * NDC_TO_CELLS};
    e->x0 = cell_of(fmin(fmin(x[0], x[1]), x[2]));
    e->x1 = cell_of(fmax(fmax(x[0], x[1]), x[2]));
    e->y0 = cell_of(fmin(fmin(y[0], y[1]), y[2]));
    e->y1 = cell_of(fmax(fmax(y[0], y[1]), y[2]));
}

/* Bounds in object space, which stand for so many triangles. One that reaches the eye's plane is
 * never hidden. */
static void add_object(work *w, const double lower[3], const double upper[3], double triangles) {
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (int corner = 0; corner < 8; corner++) {
        double p[3], clip[4];
        for (int axis = 0; axis < 3; axis++)
            p[axis] = corner >> axis & 1 ? upper[axis] : lower[axis];
        project(w, p, clip);
        if (!(clip[3] > 0.0) || clip[2] > clip[3])
            return;
        for (int axis = 0; axis < 3; axis++) {
            low[axis] = fmin(low[axis], clip[axis] / clip[3]);
            high[axis] = fmax(high[axis], clip[axis] / clip[3]);
        }
    }
    if (low[0] > 1.0 || high[0] < -1.0 || low[1] > 1.0 || high[1] < -1.0) {
        w->outside += triangles;
        return;
    }
    w->events[w->count++] = (event){.depth = 1.0 - high[2],
                                    .weight = triangles,
                                    .area = (high[0] - low[0]) * (high[1] - low[1]) * NDC_TO_CELLS,
                                    .x0 = cell_of(low[0]),
                                    .x1 = cell_of(high[0]),
                                    .y0 = cell_of(low[1]),
                                    .y1 = cell_of(high[1]),
                                    .object = 1};
}

/* A cluster of a large mesh: a box about a triangle, of the size that evenly cut ones would have.
 */
static void add_cluster(work *w, const scene_mesh *mesh, uint32_t triangle, double triangles) {
    const double share = 0.5 / cbrt(clusters_of(mesh));
    const float *v = mesh->positions + (size_t)mesh->indices[triangle * 3] * 3;
    double lower[3], upper[3];
    for (int axis = 0; axis < 3; axis++) {
        double half = share * ((double)mesh->upper[axis] - (double)mesh->lower[axis]);
        lower[axis] = (double)v[axis] - half;
        upper[axis] = (double)v[axis] + half;
    }
    add_object(w, lower, upper, triangles);
}

/* Walks the triangles of all that counts in steps of `triangle_step`, and its objects likewise. */
static void sample(work *w, double triangle_step, double object_step) {
    double triangle = 0.5 * triangle_step, object = 0.5 * object_step;
    for (uint32_t i = 0; i < w->s->instance_count; i++) {
        const scene_instance *instance = &w->s->instances[i];
        const scene_mesh *mesh = &w->s->meshes[instance->mesh];
        if (!is_counted(w, instance))
            continue;
        const double triangles = mesh->index_count / 3.0, clusters = clusters_of(mesh);
        if (triangle < triangles || object < clusters)
            take_instance(w, instance);
        for (; triangle < triangles; triangle += triangle_step)
            add_triangle(w, mesh, (uint32_t)triangle, triangle_step);
        for (; object < clusters; object += object_step) {
            if (clusters > 1.0) {
                add_cluster(w, mesh, (uint32_t)(object / clusters * triangles),
                            triangles / clusters * object_step);
                continue;
            }
            double lower[3], upper[3];
            for (int axis = 0; axis < 3; axis++) {
                lower[axis] = (double)mesh->lower[axis];
                upper[axis] = (double)mesh->upper[axis];
            }
            add_object(w, lower, upper, triangles * object_step);
        }
        triangle -= triangles;
        object -= clusters;
    }
}

/* ---- from near to far ------------------------------------------------------------------------ */

static int by_depth(const void *a, const void *b) {
    const event *left = a, *right = b;
    if (left->depth != right->depth)
        return left->depth < right->depth ? -1 : 1;
    return (int)right->object - (int)left->object; /* an object before its own triangles */
}

/* Of an object in the least covered of its cells. */
static double hidden_chance(const cell *c, const event *object) {
    if (!(c->cover > 0.0))
        return 0.0;
    const double pieces = 1.0 + sqrt(object->area * c->cover / c->pieces);
    return pow(1.0 - exp(-c->cover), pieces * pieces);
}

static void go_through(work *w, strata_scene_stats *stats) {
    cell cells[CELLS][CELLS] = {{{0.0, 0.0}}};
    const double pixels = (double)w->view->width * (double)w->view->height / (CELLS * CELLS);
    qsort(w->events, w->count, sizeof *w->events, by_depth);
    for (uint32_t i = 0; i < w->count; i++) {
        const event *e = &w->events[i];
        const double cover = e->weight / ((e->x1 - e->x0 + 1.0) * (e->y1 - e->y0 + 1.0));
        const cell *least = &cells[(int)e->y0][(int)e->x0];
        for (int y = (int)e->y0; y <= (int)e->y1; y++)
            for (int x = (int)e->x0; x <= (int)e->x1; x++) {
                cell *c = &cells[y][x];
                if (c->cover < least->cover)
                    least = c;
                if (e->object)
                    continue;
                c->cover += cover;
                c->pieces += cover * e->area;
            }
        if (e->object)
            stats->hidden_triangles += e->weight * hidden_chance(least, e);
    }
    /* Of n fragments in random order ln n and a half come before all that are nearer. */
    for (int y = 0; y < CELLS; y++)
        for (int x = 0; x < CELLS; x++)
            stats->opaque_overdraw += pixels * log1p(cells[y][x].cover);
}

strata_result estimate_hidden(const scene *s, const estimate_view *view,
                              const unsigned char *transparent, strata_scene_stats *stats,
                              base_error *err) {
    work w = {.s = s, .view = view, .transparent = transparent};
    double triangles = 0.0, objects = 0.0;
    for (uint32_t i = 0; i < s->instance_count; i++)
        if (is_counted(&w, &s->instances[i])) {
            triangles += s->meshes[s->instances[i].mesh].index_count / 3.0;
            objects += clusters_of(&s->meshes[s->instances[i].mesh]);
        }
    stats->opaque_objects = (uint64_t)objects;
    if (objects < FEWEST_OBJECTS)
        return STRATA_OK;
    /* A sample more than the steps say, for rounding. */
    w.events = base_calloc(TRIANGLES + OBJECTS + 2u, sizeof *w.events);
    if (!w.events)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for an estimate",
                         s->path);
    sample(&w, fmax(triangles / TRIANGLES, 1.0), fmax(objects / OBJECTS, 1.0));
    go_through(&w, stats);
    stats->outside_triangles = w.outside;
    free(w.events);
    return STRATA_OK;
}
