/* SPDX-License-Identifier: MIT
 *
 * The estimate of depth complexity: each sampled triangle is clipped to the view, its area is
 * spread over the cells of a coarse grid, and a cell remembers the box that its contributions
 * touched, so that a stack over one pixel is not mistaken for a thin veil over the whole cell.
 */
#include "plan/estimate.h"
#include "plan/opacity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define CELLS        64u
#define MAX_VERTICES 10 /* a triangle cut by six planes has at most nine */
#define PLANES       6

/* The time an estimate may take, in visits of a cell (some nanoseconds each). */
#define MAX_STEPS     2500000u
#define FIXED_STEPS   12.0 /* of a triangle before it reaches a cell */
#define PILOT_SAMPLES 2048u

typedef struct cell {
    double area; /* pixels of fragments */
    double x0, x1, y0, y1;
} cell;

typedef struct grid {
    uint32_t columns, rows;
    double width, height, cell_width, cell_height, columns_a_pixel, rows_a_pixel;
    double fragments, optical_depth; /* sums; the second over the first are a fragment's */
    uint64_t steps;                  /* cells touched, the time it took */
    cell cells[CELLS][CELLS];
} grid;

/* A convex outline in pixels. */
typedef struct outline {
    int count;
    double x[MAX_VERTICES], y[MAX_VERTICES];
} outline;

typedef struct instance_view {
    double to_clip[16];
    double radius_x, radius_y; /* clip units an object-space unit of splat radius, times w */
    int cull;                  /* 0 none, 1 clockwise faces, -1 counter-clockwise ones (mirrored) */
    double optical_depth;      /* of its fragments */
} instance_view;

/* ---- the grid -------------------------------------------------------------------------------- */

static grid *grid_create(const estimate_view *view) {
    grid *g = base_calloc(1, sizeof *g);
    if (!g)
        return NULL;
    g->columns = view->width < CELLS ? view->width : CELLS;
    g->rows = view->height < CELLS ? view->height : CELLS;
    g->width = (double)view->width;
    g->height = (double)view->height;
    g->cell_width = g->width / (double)g->columns;
    g->cell_height = g->height / (double)g->rows;
    g->columns_a_pixel = (double)g->columns / g->width;
    g->rows_a_pixel = (double)g->rows / g->height;
    return g;
}

/* fmin and fmax order NaN as well, at the price of a call each; no NaN gets this far. */
static inline double smaller(double a, double b) {
    return a < b ? a : b;
}

static inline double larger(double a, double b) {
    return a > b ? a : b;
}

static inline uint32_t cell_index(double position, double scale, uint32_t count) {
    double index = position * scale;
    if (!(index > 0.0))
        return 0;
    return index >= (double)count ? count - 1 : (uint32_t)index;
}

static void add_to_cell(cell *c, double area, double x0, double x1, double y0, double y1) {
    if (c->area == 0.0) {
        *c = (cell){area, x0, x1, y0, y1};
        return;
    }
    c->area += area;
    c->x0 = x0 < c->x0 ? x0 : c->x0;
    c->x1 = x1 > c->x1 ? x1 : c->x1;
    c->y0 = y0 < c->y0 ? y0 : c->y0;
    c->y1 = y1 > c->y1 ? y1 : c->y1;
}

/* Where the line at height y crosses the outline. */
static void span_at(const outline *o, double y, double *left, double *right) {
    *left = HUGE_VAL;
    *right = -HUGE_VAL;
    for (int i = 0; i < o->count; i++) {
        int j = i + 1 == o->count ? 0 : i + 1;
        double yi = o->y[i], yj = o->y[j];
        if ((yi < y) == (yj < y))
            continue;
        double x = o->x[i] + (o->x[j] - o->x[i]) * ((y - yi) / (yj - yi));
        *left = smaller(*left, x);
        *right = larger(*right, x);
    }
}

/* Adds a span of one row of cells, `density` fragments a pixel of its area. */
static void add_span(grid *g, uint32_t row, double left, double right, double y0, double y1,
                     double density) {
    uint32_t first = cell_index(left, g->columns_a_pixel, g->columns);
    uint32_t last = cell_index(right, g->columns_a_pixel, g->columns);
    g->steps += last - first;
    for (uint32_t column = first; column <= last; column++) {
        double x0 = column == first ? left : (double)column * g->cell_width;
        double x1 = column == last ? right : (double)(column + 1) * g->cell_width;
        double area = (x1 - x0) * (y1 - y0) * density;
        if (area > 0.0)
            add_to_cell(&g->cells[row][column], area, x0, x1, y0, y1);
    }
}

/* Spreads `area` fragments over the outline: the exact span at the middle of each row of cells,
 * scaled so that the sum is right. */
static void add_outline(grid *g, const outline *o, double area) {
    double left[CELLS], right[CELLS], sum = 0.0;
    double x0 = o->x[0], x1 = x0, y0 = o->y[0], y1 = y0;
    for (int i = 1; i < o->count; i++) {
        x0 = smaller(x0, o->x[i]);
        x1 = larger(x1, o->x[i]);
        y0 = smaller(y0, o->y[i]);
        y1 = larger(y1, o->y[i]);
    }
    uint32_t first = cell_index(y0, g->rows_a_pixel, g->rows);
    uint32_t last = cell_index(y1, g->rows_a_pixel, g->rows);
    uint32_t column = cell_index(x0, g->columns_a_pixel, g->columns);
    g->fragments += area;
    g->steps += 1 + last - first;
    if (first == last && column == cell_index(x1, g->columns_a_pixel, g->columns)) {
        add_to_cell(&g->cells[first][column], area, x0, x1, y0, y1);
        return;
    }
    for (uint32_t row = first; row <= last; row++) {
        double low = larger(y0, (double)row * g->cell_height);
        double high = smaller(y1, (double)(row + 1) * g->cell_height);
        span_at(o, 0.5 * (low + high), &left[row], &right[row]);
        if (left[row] <= right[row])
            sum += (right[row] - left[row]) * (high - low);
    }
    if (!(sum > 0.0)) {
        add_to_cell(&g->cells[first][column], area, x0, x1, y0, y1);
        return;
    }
    for (uint32_t row = first; row <= last; row++) {
        double low = larger(y0, (double)row * g->cell_height);
        double high = smaller(y1, (double)(row + 1) * g->cell_height);
        if (left[row] <= right[row] && low < high)
            add_span(g, row, left[row], right[row], low, high, area / sum);
    }
}

/* ---- triangles ------------------------------------------------------------------------------- */

static void to_clip(const double m[16], const float *p, double out[4]) {
    double x = (double)p[0], y = (double)p[1], z = (double)p[2];
    for (int i = 0; i < 4; i++)
        out[i] = m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i];
}

/* Distance from a plane of the view volume, positive inside: left, right, bottom, top, near, far.
 */
static double inside(const double v[4], int plane) {
    switch (plane) {
    case 0:
        return v[3] + v[0];
    case 1:
        return v[3] - v[0];
    case 2:
        return v[3] + v[1];
    case 3:
        return v[3] - v[1];
    case 4:
        return v[3] - v[2];
    default:
        return v[2];
    }
}

static int clip_plane(double (*in)[4], int count, int plane, double (*out)[4]) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const double *a = in[i], *b = in[i + 1 == count ? 0 : i + 1];
        double da = inside(a, plane), db = inside(b, plane);
        if (da >= 0.0)
            memcpy(out[kept++], a, sizeof out[0]);
        if ((da >= 0.0) == (db >= 0.0) || kept >= MAX_VERTICES)
            continue;
        double t = da / (da - db);
        for (int k = 0; k < 4; k++)
            out[kept][k] = a[k] + (b[k] - a[k]) * t;
        kept++;
    }
    return kept;
}

/* A bit for each plane that v lies outside of; all of them when v is not a number. */
static inline unsigned outside(const double v[4]) {
    double x = v[0], y = v[1], z = v[2], w = v[3];
    return (unsigned)!(w + x >= 0.0) | (unsigned)!(w - x >= 0.0) << 1 |
           (unsigned)!(w + y >= 0.0) << 2 | (unsigned)!(w - y >= 0.0) << 3 |
           (unsigned)!(w - z >= 0.0) << 4 | (unsigned)!(z >= 0.0) << 5;
}

/* Clips a triangle to the view volume, in place. Returns the number of vertices, 0 = outside. */
static int clip_triangle(double (*v)[4]) {
    double other[MAX_VERTICES][4];
    unsigned a = outside(v[0]), b = outside(v[1]), c = outside(v[2]), cut = a | b | c;
    int count = 3;
    if (cut == 0)
        return 3;
    if (a & b & c)
        return 0;
    for (int plane = 0; plane < PLANES && count > 0; plane++) {
        if (!(cut & (1u << plane)))
            continue;
        count = clip_plane(v, count, plane, other);
        memcpy(v, other, (size_t)count * sizeof other[0]);
    }
    return count;
}

static void add_fragments(grid *g, const outline *o, double area, const instance_view *view) {
    if (!(area > 0.0) || !isfinite(area))
        return;
    add_outline(g, o, area);
    g->optical_depth += area * view->optical_depth;
}

static void add_triangle(grid *g, const instance_view *view, const scene_mesh *mesh,
                         uint64_t triangle, double weight) {
    double v[MAX_VERTICES][4];
    outline o;
    const uint32_t *indices = mesh->indices + triangle * 3;
    for (int i = 0; i < 3; i++)
        to_clip(view->to_clip, mesh->positions + (size_t)indices[i] * 3, v[i]);
    o.count = clip_triangle(v);
    if (o.count < 3)
        return;
    double twice = 0.0;
    for (int i = 0; i < o.count; i++) {
        if (!(v[i][3] > 0.0))
            return;
        double half = 0.5 / v[i][3];
        o.x[i] = smaller(larger((v[i][0] * half + 0.5) * g->width, 0.0), g->width);
        o.y[i] = smaller(larger((v[i][1] * half + 0.5) * g->height, 0.0), g->height);
    }
    for (int i = 0; i < o.count; i++) {
        int j = i + 1 == o.count ? 0 : i + 1;
        twice += o.x[i] * o.y[j] - o.x[j] * o.y[i];
    }
    if ((view->cull > 0 && twice < 0.0) || (view->cull < 0 && twice > 0.0))
        return;
    add_fragments(g, &o, 0.5 * fabs(twice) * weight, view);
}

/* A splat is a disc that faces the camera; without a radius it is one pixel. */
static void add_splat(grid *g, const instance_view *view, const scene_mesh *mesh, uint64_t point,
                      double weight) {
    double v[4];
    uint32_t vertex = mesh->indices[point];
    to_clip(view->to_clip, mesh->positions + (size_t)vertex * 3, v);
    if (!(v[3] > 0.0) || v[2] > v[3] || v[2] < 0.0)
        return;
    double radius = mesh->radii ? (double)mesh->radii[vertex] : 0.0;
    double rx = mesh->radii ? radius * view->radius_x / v[3] * 0.5 * g->width : 0.5;
    double ry = mesh->radii ? radius * view->radius_y / v[3] * 0.5 * g->height : 0.5;
    double x = (v[0] / v[3] * 0.5 + 0.5) * g->width, y = (v[1] / v[3] * 0.5 + 0.5) * g->height;
    double x0 = fmax(x - rx, 0.0), x1 = fmin(x + rx, g->width);
    double y0 = fmax(y - ry, 0.0), y1 = fmin(y + ry, g->height);
    if (!(x0 < x1) || !(y0 < y1))
        return;
    outline o = {.count = 4, .x = {x0, x1, x1, x0}, .y = {y0, y0, y1, y1}};
    double share = mesh->radii ? 0.785398163397448 : 1.0; /* a disc's of its square */
    add_fragments(g, &o, share * (x1 - x0) * (y1 - y0) * weight, view);
}

/* ---- the scene ------------------------------------------------------------------------------- */

static uint64_t primitive_count(const scene_mesh *mesh) {
    return mesh->topology == SCENE_TRIANGLES ? mesh->index_count / 3u : mesh->index_count;
}

static int counts(const scene *s, const scene_instance *instance) {
    return instance->visible && s->meshes[instance->mesh].index_count > 0;
}

static instance_view view_of(const scene *s, const scene_instance *instance,
                             const estimate_view *view, const double *optical_depths) {
    instance_view out = {.optical_depth = optical_depths[instance->mesh]};
    const float *w = instance->world, *c = view->world_to_clip;
    double scale = 0.0;
    for (int column = 0; column < 4; column++)
        for (int row = 0; row < 4; row++)
            for (int k = 0; k < 4; k++)
                out.to_clip[column * 4 + row] += (double)c[k * 4 + row] * (double)w[column * 4 + k];
    for (int column = 0; column < 3; column++) {
        double x = (double)w[column * 4], y = (double)w[column * 4 + 1];
        double z = (double)w[column * 4 + 2];
        scale = fmax(scale, sqrt(x * x + y * y + z * z));
    }
    out.radius_x = scale * sqrt((double)c[0] * (double)c[0] + (double)c[4] * (double)c[4] +
                                (double)c[8] * (double)c[8]);
    out.radius_y = scale * sqrt((double)c[1] * (double)c[1] + (double)c[5] * (double)c[5] +
                                (double)c[9] * (double)c[9]);
    if (s->materials[s->meshes[instance->mesh].material].double_sided)
        return out;
    double determinant = 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        determinant += (double)w[i] *
                       ((double)w[4 + j] * (double)w[8 + k] - (double)w[4 + k] * (double)w[8 + j]);
    }
    out.cull = determinant < 0.0 ? -1 : 1;
    return out;
}

static strata_result count_scene(const scene *s, const unsigned char *transparent,
                                 strata_scene_stats *out, uint64_t *primitives, base_error *err) {
    unsigned char *used = base_calloc(s->material_count, 1);
    if (!used)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY,
                         "%s: no memory to count its materials", s->path);
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_mesh *mesh = &s->meshes[s->instances[i].mesh];
        if (!counts(s, &s->instances[i]))
            continue;
        uint64_t count = primitive_count(mesh);
        uint64_t triangles = mesh->topology == SCENE_TRIANGLES ? count : 2 * count;
        int folded = transparent[mesh->material] != 0;
        out->instances++;
        out->materials += !used[mesh->material];
        used[mesh->material] = 1;
        *(folded ? &out->transparent_draws : &out->opaque_draws) += 1;
        *(folded ? &out->transparent_triangles : &out->opaque_triangles) += triangles;
        *primitives += folded ? count : 0;
    }
    free(used);
    return STRATA_OK;
}

/* Every stride-th primitive over all instances; the stride shares no factor with the 2, 3 or 12
 * triangles that quads, prisms and boxes repeat by. */
static uint64_t stride_for(uint64_t primitives, uint64_t samples) {
    uint64_t stride = (primitives + samples - 1) / samples;
    while (stride > 1 && (stride % 2 == 0 || stride % 3 == 0))
        stride++;
    return stride;
}

static void fill_grid(grid *g, const scene *s, const estimate_view *view,
                      const unsigned char *transparent, const double *optical_depths,
                      uint64_t primitives, uint64_t samples) {
    uint64_t stride = stride_for(primitives, samples), next = 0, base = 0;
    double weight = (double)primitives / (double)((primitives + stride - 1) / stride);
    for (uint32_t i = 0; i < s->instance_count; i++) {
        const scene_instance *instance = &s->instances[i];
        const scene_mesh *mesh = &s->meshes[instance->mesh];
        if (!counts(s, instance) || !transparent[mesh->material])
            continue;
        uint64_t end = base + primitive_count(mesh);
        if (next < end) {
            instance_view local = view_of(s, instance, view, optical_depths);
            for (; next < end; next += stride) {
                if (mesh->topology == SCENE_TRIANGLES)
                    add_triangle(g, &local, mesh, next - base, weight);
                else
                    add_splat(g, &local, mesh, next - base, weight);
            }
        }
        base = end;
    }
}

/* How many samples the time allows, from what the first few cost: large triangles touch many cells.
 */
static uint64_t affordable(const grid *pilot, uint64_t samples) {
    double steps = FIXED_STEPS + (double)pilot->steps / (double)samples;
    double affordable = (double)MAX_STEPS / steps;
    if (affordable >= (double)ESTIMATE_MAX_SAMPLES)
        return ESTIMATE_MAX_SAMPLES;
    return affordable > (double)PILOT_SAMPLES ? (uint64_t)affordable : PILOT_SAMPLES;
}

static void reset(grid *g) {
    g->fragments = g->optical_depth = 0.0;
    g->steps = 0;
    memset(g->cells, 0, sizeof g->cells);
}

/* Once, or once more after a few samples that say how many the time allows. */
static void fill(grid *g, const scene *s, const estimate_view *view,
                 const unsigned char *transparent, double *optical_depths, uint64_t primitives) {
    uint64_t samples = ESTIMATE_MAX_SAMPLES;
    for (uint32_t i = 0; i < s->mesh_count; i++)
        if (transparent[s->meshes[i].material])
            optical_depths[i] = opacity_optical_depth(s, &s->meshes[i]);
    if (primitives > 4 * PILOT_SAMPLES) {
        fill_grid(g, s, view, transparent, optical_depths, primitives, PILOT_SAMPLES);
        samples = affordable(g, PILOT_SAMPLES);
        reset(g);
    }
    fill_grid(g, s, view, transparent, optical_depths, primitives, samples);
}

static void summarise(const grid *g, strata_scene_stats *out) {
    for (uint32_t row = 0; row < g->rows; row++) {
        for (uint32_t column = 0; column < g->columns; column++) {
            const cell *c = &g->cells[row][column];
            double box = (c->x1 - c->x0) * (c->y1 - c->y0);
            double covered = fmin(c->area, fmax(box, 1.0));
            out->covered_pixels += covered;
            out->largest_depth = fmax(out->largest_depth, c->area / fmax(covered, 1.0));
        }
    }
    out->transparent_fragments = g->fragments;
    if (g->fragments > 0.0) {
        out->largest_depth = fmax(out->largest_depth, 1.0);
        out->covered_pixels = fmin(out->covered_pixels, g->width * g->height);
        out->mean_depth = g->fragments / out->covered_pixels;
        out->mean_optical_depth = g->optical_depth / g->fragments;
    }
}

strata_result estimate_stats(const scene *s, const estimate_view *view,
                             const unsigned char *transparent, strata_scene_stats *out,
                             base_error *err) {
    uint64_t primitives = 0;
    *out = (strata_scene_stats){
        .struct_size = sizeof *out,
        .width = view->width,
        .height = view->height,
        .lights = s->light_count,
    };
    if (view->width == 0 || view->height == 0)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "the image has no pixels");
    strata_result result = count_scene(s, transparent, out, &primitives, err);
    if (result == STRATA_OK)
        result = estimate_hidden(s, view, transparent, out, err);
    if (result != STRATA_OK || primitives == 0)
        return result;
    grid *g = grid_create(view);
    double *optical_depths = base_calloc(s->mesh_count, sizeof *optical_depths);
    if (g && optical_depths)
        fill(g, s, view, transparent, optical_depths, primitives);
    if (g && optical_depths)
        summarise(g, out);
    else
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for an estimate",
                           s->path);
    free(optical_depths);
    free(g);
    return result;
}
