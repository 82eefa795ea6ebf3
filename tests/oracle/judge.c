/* SPDX-License-Identifier: MIT
 *
 * The ray oracle's verdict: pixel by pixel, the records that were captured against the primitives
 * that a ray meets. See oracle.h.
 *
 * A fragment must be there when the pixel's centre is inside a transparent primitive and nothing
 * opaque is nearer (at the same depth the transparent one counts); it must not when the centre is
 * outside or something opaque is nearer. What the rasteriser's grid or the depth's rounding leaves
 * open is counted apart.
 */
#include "oracle/oracle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define THIN 0.125 /* pixels: a triangle not higher than this is a sliver */

typedef struct met { /* a primitive under the pixel */
    const oracle_shape *shape;
    oracle_hit hit;
    const oracle_record *record; /* NULL: not captured */
    enum { VISIBLE, DOUBTFUL, HIDDEN } state;
} met;

typedef struct judge {
    const oracle_capture *c;
    oracle_verdict *out;
    size_t pixel;
    met *opaque, *transparent;
    uint32_t opaque_count, transparent_count;
    const oracle_record **by_primitive;
    const oracle_record *sorted;
    size_t count;
} judge;

__attribute__((format(printf, 2, 3))) static void note(judge *j, const char *format, ...) {
    char *text = j->out->first;
    if (text[0])
        return;
    va_list arguments;
    va_start(arguments, format);
    const int length =
        snprintf(text, sizeof j->out->first, "pixel (%zu, %zu): ", j->pixel % j->c->width,
                 j->pixel / j->c->width);
    vsnprintf(text + length, sizeof j->out->first - (size_t)length, format, arguments);
    va_end(arguments);
}

/* ---- what a ray meets ------------------------------------------------------------------------ */

static void cast(judge *j, const oracle_shapes *shapes) {
    const double x = (double)(j->pixel % j->c->width) + 0.5;
    const double y = (double)(j->pixel / j->c->width) + 0.5;
    j->opaque_count = j->transparent_count = 0;
    for (uint32_t i = 0; i < shapes->count; i++) {
        const oracle_shape *s = &shapes->at[i];
        const oracle_hit hit = oracle_cast(s, x, y);
        if (hit.cover == ORACLE_OUTSIDE)
            continue;
        if (s->transparent)
            j->transparent[j->transparent_count++] = (met){.shape = s, .hit = hit};
        else
            j->opaque[j->opaque_count++] = (met){.shape = s, .hit = hit};
    }
}

static int thin(const met *m) {
    return m->shape->height < THIN;
}

/* The opaque depth lies between the nearest that is certain and the nearest that is possible. */
static void judge_opaque(judge *j) {
    const double depth = (double)j->c->depth[j->pixel];
    double least = 0, most = 0;
    for (uint32_t i = 0; i < j->opaque_count; i++) {
        const oracle_hit *hit = &j->opaque[i].hit;
        most = fmax(most, hit->cover == ORACLE_EDGE && thin(&j->opaque[i])
                              ? 1
                              : hit->depth + hit->tolerance);
        if (hit->cover == ORACLE_INSIDE)
            least = fmax(least, hit->depth - hit->tolerance);
    }
    if (depth >= least && depth <= most)
        return;
    j->out->opaque_wrong++;
    note(j, "opaque depth %.9g is not in %.9g .. %.9g", depth, least, most);
}

static void compare_with_opaque(const judge *j, met *t) {
    t->state = VISIBLE;
    for (uint32_t i = 0; i < j->opaque_count && t->state != HIDDEN; i++) {
        const met *o = &j->opaque[i];
        if (oracle_same_depth(t->shape, o->shape))
            continue;
        if (o->hit.cover == ORACLE_INSIDE &&
            o->hit.depth - o->hit.tolerance > t->hit.depth + t->hit.tolerance)
            t->state = HIDDEN;
        else if (o->hit.depth + o->hit.tolerance >= t->hit.depth - t->hit.tolerance ||
                 (o->hit.cover == ORACLE_EDGE && thin(o)))
            t->state = DOUBTFUL;
    }
}

/* ---- what was captured ------------------------------------------------------------------------
 */

static int by_primitive(const void *a, const void *b) {
    const uint32_t left = oracle_primitive(*(const oracle_record *const *)a);
    const uint32_t right = oracle_primitive(*(const oracle_record *const *)b);
    return left < right ? -1 : left > right;
}

/* Gives each record to the primitive that it says it is of. Shapes come in the order of numbers. */
static void match(judge *j) {
    for (size_t i = 0; i < j->count; i++)
        j->by_primitive[i] = &j->sorted[i];
    qsort(j->by_primitive, j->count, sizeof *j->by_primitive, by_primitive);
    size_t at = 0;
    for (uint32_t i = 0; i <= j->transparent_count; i++) {
        met *t = i < j->transparent_count ? &j->transparent[i] : NULL;
        while (at < j->count &&
               (!t || oracle_primitive(j->by_primitive[at]) < t->shape->primitive)) {
            j->out->surplus++;
            note(j, "primitive %u is captured and is not there, or twice",
                 oracle_primitive(j->by_primitive[at++]));
        }
        if (t && at < j->count && oracle_primitive(j->by_primitive[at]) == t->shape->primitive)
            t->record = j->by_primitive[at++];
    }
}

static void judge_depth(judge *j, const met *t) {
    const double depth = (double)oracle_depth(t->record);
    const double error = fabs(depth - t->hit.depth);
    if (error <= t->hit.tolerance) {
        if (t->hit.tolerance > 0)
            j->out->worst_depth = fmax(j->out->worst_depth, error / t->hit.tolerance);
    } else if (t->hit.cover == ORACLE_EDGE && thin(t)) {
        j->out->slivers++;
    } else {
        j->out->misplaced++;
        note(j, "primitive %u is at %.9g, not %.9g +- %.3g", t->shape->primitive, depth,
             t->hit.depth, t->hit.tolerance);
    }
}

static void judge_fragment(judge *j, met *t) {
    compare_with_opaque(j, t);
    if (t->state == HIDDEN) {
        j->out->surplus += t->record != NULL;
        if (t->record)
            note(j, "primitive %u is captured behind the opaque surface", t->shape->primitive);
        return;
    }
    if (t->record)
        judge_depth(j, t);
    if (t->state == DOUBTFUL) {
        j->out->hidden_or_not++;
    } else if (t->hit.cover == ORACLE_EDGE) {
        j->out->edge++;
        j->out->edge_drawn += t->record != NULL;
    } else if (t->record) {
        j->out->judged++;
    } else {
        j->out->missing++;
        note(j, "primitive %u is missing at depth %.9g", t->shape->primitive, t->hit.depth);
    }
}

/* ---- order ----------------------------------------------------------------------------------- */

static const met *owner(const judge *j, const oracle_record *record) {
    for (uint32_t i = 0; i < j->transparent_count; i++)
        if (j->transparent[i].record == record)
            return &j->transparent[i];
    return NULL;
}

/* Neighbours in the order of the keys are not the other way round for the rays. */
static void judge_order(judge *j) {
    const met *before = j->count ? owner(j, &j->sorted[0]) : NULL;
    for (size_t i = 1; i < j->count; i++) {
        const met *t = owner(j, &j->sorted[i]);
        if (t && before &&
            t->hit.depth - t->hit.tolerance > before->hit.depth + before->hit.tolerance &&
            !(thin(t) && t->hit.cover == ORACLE_EDGE) &&
            !(thin(before) && before->hit.cover == ORACLE_EDGE)) {
            j->out->disordered++;
            note(j, "primitive %u at %.9g comes before %u at %.9g", before->shape->primitive,
                 before->hit.depth, t->shape->primitive, t->hit.depth);
        }
        before = t;
    }
}

/* What lies at the same depth has the same key, and the later primitive comes first. */
static void judge_ties(judge *j) {
    for (uint32_t i = 0; i < j->transparent_count; i++)
        for (uint32_t k = i + 1; k < j->transparent_count; k++) {
            const met *early = &j->transparent[i], *late = &j->transparent[k];
            if (!early->record || !late->record || !oracle_same_depth(early->shape, late->shape))
                continue;
            j->out->ties++;
            if (early->record->key == late->record->key && late->record < early->record)
                continue;
            j->out->disordered++;
            note(j, "primitives %u and %u lie at one depth, with keys %08x and %08x",
                 early->shape->primitive, late->shape->primitive, early->record->key,
                 late->record->key);
        }
}

/* ---- shared edges ---------------------------------------------------------------------------- */

static int same_point(const float *a, const float *b) {
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The edge of `b` that is edge `k` of `a`, or -1. */
static int shared_edge(const oracle_shape *a, int k, const oracle_shape *b) {
    const float *from = a->position[(k + 1) % 3], *to = a->position[(k + 2) % 3];
    for (int i = 0; i < 3 && a->instance == b->instance; i++) {
        const float *x = b->position[(i + 1) % 3], *y = b->position[(i + 2) % 3];
        if ((same_point(from, x) && same_point(to, y)) ||
            (same_point(from, y) && same_point(to, x)))
            return i;
    }
    return -1;
}

/* The edge alone that the pixel's centre lies on, or -1. */
static int on_one_edge(const met *t) {
    const uint32_t e = t->hit.edges;
    if (t->state != VISIBLE || thin(t) || t->shape->disc || (e != 1 && e != 2 && e != 4))
        return -1;
    return e == 4 ? 2 : (int)e - 1;
}

/* Two triangles on either side of an edge: one has the pixel; on the same side: both or none. */
static void judge_seams(judge *j) {
    for (uint32_t i = 0; i < j->transparent_count; i++) {
        const met *a = &j->transparent[i], *found = NULL;
        const int k = on_one_edge(a);
        uint32_t sharers = 0;
        int other = -1;
        for (uint32_t n = 0; n < j->transparent_count && k >= 0; n++) {
            const met *b = &j->transparent[n];
            const int edge = n == i ? -1 : shared_edge(a->shape, k, b->shape);
            sharers += edge >= 0;
            found = edge >= 0 ? b : found;
            other = edge >= 0 ? edge : other;
        }
        if (sharers != 1 || found < a || on_one_edge(found) != other)
            continue;
        const double *u = a->shape->weight[k], *v = found->shape->weight[other];
        const int across = u[0] * v[0] + u[1] * v[1] < 0;
        const int both = (a->record != NULL) + (found->record != NULL);
        j->out->seams++;
        if (across ? both == 1 : both != 1)
            continue;
        j->out->seam_wrong++;
        note(j, "on the edge of primitives %u and %u %d are captured", a->shape->primitive,
             found->shape->primitive, both);
    }
}

/* ---- the frame ------------------------------------------------------------------------------- */

static void judge_pixel(judge *j, const oracle_shapes *shapes) {
    const oracle_capture *c = j->c;
    j->count = c->first[j->pixel + 1] - c->first[j->pixel];
    j->sorted = c->records + c->first[j->pixel];
    oracle_sort(c->records + c->first[j->pixel], j->count);
    cast(j, shapes);
    judge_opaque(j);
    match(j);
    for (uint32_t i = 0; i < j->transparent_count; i++)
        judge_fragment(j, &j->transparent[i]);
    judge_order(j);
    judge_seams(j);
    if (j->transparent_count <= 256)
        judge_ties(j);
}

void oracle_judge(const oracle_capture *c, oracle_verdict *out) {
    const size_t pixels = (size_t)c->width * c->height;
    oracle_shapes shapes;
    oracle_shapes_make(c->scene, &c->view, c->width, c->height, &shapes);
    judge j = {.c = c,
               .out = out,
               .opaque = base_calloc(shapes.count + 1, sizeof(met)),
               .transparent = base_calloc(shapes.count + 1, sizeof(met)),
               .by_primitive = base_calloc(c->record_count + 1, sizeof(oracle_record *))};
    *out = (oracle_verdict){0};
    assert_true(j.opaque && j.transparent && j.by_primitive);
    for (j.pixel = 0; j.pixel < pixels; j.pixel++)
        judge_pixel(&j, &shapes);
    free(j.opaque);
    free(j.transparent);
    free(j.by_primitive);
    oracle_shapes_free(&shapes);
}
