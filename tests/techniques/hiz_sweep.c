/* SPDX-License-Identifier: MIT
 *
 * The scenes of test_hiz for as long as one likes: `hiz_sweep OBJECT-FRAMES [SEED]` checks at least
 * so many object-frames on each backend that opens. Then, what share of the hidden is found: of the
 * objects that a test of their pixels' rectangle against every pixel of the final depth finds, and
 * of those without any visible fragment. Prints one JSON object; the status is 1 when something is
 * wrong.
 */
#define _POSIX_C_SOURCE 200809L

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <jansson.h>

#include "render/render.h"
#include "scene/upload_internal.h"
#include "techniques/cull_internal.h"

static const char *const backends[] = {"vulkan", "gl"};

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* ---- no visible object is culled ------------------------------------------------------------- */

static json_t *counts_json(const cull_counts *n, uint32_t failures, double seconds) {
    return json_pack("{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:i, s:I, s:f}", "frames",
                     (json_int_t)n->frames, "object_frames", (json_int_t)n->object_frames,
                     "outside", (json_int_t)n->outside, "slipped", (json_int_t)n->slipped,
                     "occluded", (json_int_t)n->occluded, "late", (json_int_t)n->late, "visible",
                     (json_int_t)n->visible, "wrong", (json_int_t)n->wrong, "slivers",
                     (json_int_t)n->overshot, "sliver_pixels", (json_int_t)n->lost_pixels,
                     "failures", (int)failures, "tie_pixels", (json_int_t)n->ties, "seconds",
                     seconds);
}

static const uint32_t kind_objects[CULL_KINDS] = {
    [CULL_HOLES] = 48,    [CULL_NEAR] = 300,     [CULL_RANDOM] = 600, [CULL_COPLANAR] = 300,
    [CULL_SLIVERS] = 500, [CULL_CLUSTERS] = 150, [CULL_GLASS] = 300,  [CULL_DEFORM] = 300};

/* Until the kind has had its share. */
static uint32_t sweep_kind(cull_rig *rig, cull_kind kind, uint64_t share, uint64_t seed,
                           json_t *to) {
    cull_counts n = {0};
    uint32_t failures = 0;
    const double start = now();
    for (uint64_t i = 0; n.object_frames < share && failures < 20; ++i) {
        const cull_case c = {.kind = kind,
                             .seed = seed + i * 977,
                             .objects = kind_objects[kind] >> i % 4,
                             .frames = 16,
                             .large = 1};
        cull_run(rig, &c, &n, NULL, NULL);
        if (n.failure[0]) {
            fprintf(stderr, "%s\n", n.failure);
            n.failure[0] = '\0';
            ++failures;
        }
    }
    json_object_set_new(to, cull_kind_names[kind], counts_json(&n, failures, now() - start));
    return failures;
}

/* ---- what is found --------------------------------------------------------------------------- */

typedef struct found {
    uint64_t slipped, in_view, hidden, culled_of_hidden, oracle, culled_of_oracle;
} found;

typedef struct target {
    uint32_t width, height;
    const float *depth; /* row 0 is the lowest */
    const float *to_clip;
} target;

typedef enum verdict { SEEN, HIDDEN, BETWEEN } verdict;

/* HIDDEN: the pixels whose centres the object's rectangle covers all lie in front of it. BETWEEN:
 * it covers none. SEEN too where the box reaches the near plane. The rectangle is wider by the
 * 1/256 that vertices are snapped to, the depth nearer by the roundings of the vertex stage: what a
 * test must leave to be right, so that what this one finds is hidden. */
static verdict ask_oracle(const target *t, const upload_object *object,
                          const upload_record *record) {
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL}, nearest = -HUGE_VAL;
    for (int corner = 0; corner < 8; ++corner) {
        double world[4] = {0, 0, 0, 1}, clip[4], size[4] = {0, 0, 0, 1}, margin = 0;
        for (int row = 0; row < 3; ++row) {
            world[row] = (double)record->world[row][3];
            size[row] = fabs(world[row]);
            for (int k = 0; k < 3; ++k) {
                const double term = (double)record->world[row][k] *
                                    (double)(corner >> k & 1 ? object->upper[k] : object->lower[k]);
                world[row] += term;
                size[row] += fabs(term);
            }
        }
        for (int row = 0; row < 4; ++row) {
            clip[row] = 0;
            for (int k = 0; k < 4; ++k)
                clip[row] += (double)t->to_clip[k * 4 + row] * world[k];
        }
        for (int k = 0; k < 4; ++k) /* of z and w */
            margin += fabs((double)t->to_clip[k * 4 + 2] * size[k]) +
                      fabs((double)t->to_clip[k * 4 + 3] * size[k]) * clip[2] / clip[3];
        margin *= 16 * 0x1p-23;
        if (!(clip[3] > 0) || !(clip[2] < clip[3]))
            return SEEN;
        const double p[2] = {(clip[0] / clip[3] * 0.5 + 0.5) * t->width,
                             (clip[1] / clip[3] * 0.5 + 0.5) * t->height};
        for (int axis = 0; axis < 2; ++axis) {
            low[axis] = fmin(low[axis], p[axis]);
            high[axis] = fmax(high[axis], p[axis]);
        }
        nearest = fmax(nearest, (clip[2] + margin) / clip[3] * (1 + 4 * 0x1p-23));
    }
    const double snap = 1.0 / 256.0, left = low[0] - snap, right = high[0] + snap,
                 lower = low[1] - snap, upper = high[1] + snap;
    const double x0 = fmax(ceil(left - 0.5), 0), x1 = fmin(floor(right - 0.5), t->width - 1.0),
                 y0 = fmax(ceil(lower - 0.5), 0), y1 = fmin(floor(upper - 0.5), t->height - 1.0);
    for (double y = y0; y <= y1; ++y)
        for (double x = x0; x <= x1; ++x)
            if ((double)t->depth[(size_t)y * t->width + (size_t)x] <= nearest)
                return SEEN;
    return x0 > x1 || y0 > y1 ? BETWEEN : HIDDEN;
}

/* What lies between pixels hides behind nothing: it is counted apart. */
static int count_found(const strata *s, found *f) {
    enum { OUTSIDE = 4, SLIPPED = 5 };
    const render_session *session = s->session;
    const upload *u = session->upload;
    base_error err = {0};
    const size_t pixels = (size_t)session->width * session->height;
    float *depth = malloc(pixels * sizeof *depth);
    uint32_t *states = malloc(u->record_count * sizeof *states + 4);
    int done = depth && states &&
               gpu_image_read(s->gpu, session->depth, 0, depth, pixels * sizeof *depth, &err) ==
                   STRATA_OK &&
               gpu_buffer_read(s->gpu, u->states, 0, u->record_count * sizeof *states, states,
                               &err) == STRATA_OK;
    const target t = {.width = session->width,
                      .height = session->height,
                      .depth = depth,
                      .to_clip = s->result.view.world_to_clip};
    uint64_t in_view = 0, culled = 0;
    for (uint32_t i = 0; done && i < u->record_count; ++i) {
        if (states[i] == OUTSIDE)
            continue;
        const int is_culled = states[i] >= SLIPPED;
        const verdict says = ask_oracle(&t, &u->object[i], &u->record[i]);
        f->slipped += says == BETWEEN;
        if (says == BETWEEN)
            continue;
        in_view++;
        culled += (uint64_t)is_culled;
        f->oracle += says == HIDDEN;
        f->culled_of_oracle += says == HIDDEN && is_culled;
    }
    f->in_view += in_view;
    f->hidden += in_view - session->report.visible;
    f->culled_of_hidden += culled;
    free(depth);
    free(states);
    return done;
}

/* The fourth frame from one place: the history is that of the same view. */
static int look(strata *s, strata_scene *sc, const strata_camera_pose *pose, const char *taps,
                uint32_t width, uint32_t height, found *f) {
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = width,
                                           .height = height,
                                           .use = "surface,hiz,cullcheck,abuffer,ppc",
                                           .settings = &taps,
                                           .setting_count = 1,
                                           .pose = pose,
                                           .repeat = 4};
    if (strata_render(s, sc, &options) != STRATA_OK) {
        fprintf(stderr, "%s\n", strata_error(s));
        return 0;
    }
    return count_found(s, f);
}

static double share(uint64_t part, uint64_t all) {
    return all ? (double)part / (double)all : 1;
}

static json_t *found_json(const found *f) {
    return json_pack("{s:I, s:I, s:I, s:f, s:I, s:f}", "slipped", (json_int_t)f->slipped, "in_view",
                     (json_int_t)f->in_view, "oracle", (json_int_t)f->oracle, "of_oracle",
                     share(f->culled_of_oracle, f->oracle), "hidden", (json_int_t)f->hidden,
                     "of_hidden", share(f->culled_of_hidden, f->hidden));
}

static void add_found(found *all, const found *f) {
    all->slipped += f->slipped;
    all->in_view += f->in_view;
    all->hidden += f->hidden;
    all->culled_of_hidden += f->culled_of_hidden;
    all->oracle += f->oracle;
    all->culled_of_oracle += f->culled_of_oracle;
}

static int find_in_kind(strata *s, cull_kind kind, const char *taps, uint64_t seed, found *f) {
    enum { CASES = 6, POSES = 6 };
    int done = 1;
    for (uint64_t i = 0; i < CASES; ++i) {
        const cull_case c = {.kind = kind, .seed = seed + i, .objects = 400};
        cull_random random = seed + i;
        strata_scene *sc = cull_scene(s, &c);
        for (int p = 0; sc && p < POSES; ++p) {
            const uint32_t width = p % 2 ? 257 : 641, height = p % 2 ? 129 : 479;
            const strata_camera_pose pose = cull_pose(&c, &random, height);
            for (uint32_t k = 0; kind == CULL_HOLES && k < c.objects; ++k) {
                float wall[CULL_WALL][16], world[16];
                cull_wall(width, height, 77, 66, wall);
                cull_behind(&random, width, height, 77, 66, world);
                strata_scene_set_transform(sc, k, k < CULL_WALL ? wall[k] : world);
            }
            done &= look(s, sc, &pose, taps, width, height, f);
        }
        done &= sc != NULL;
        strata_scene_close(sc);
    }
    return done;
}

static int find_in_city(strata *s, const char *taps, found *f) {
    static const char *const paths[] = {"scene:city?count=20000",
                                        "scene:city?count=20000&view=aerial"};
    int done = 1;
    for (int i = 0; i < 2; ++i) {
        strata_scene *sc = NULL;
        strata_camera_pose pose = {.struct_size = sizeof pose};
        done &= strata_scene_load(s, paths[i], &sc) == STRATA_OK &&
                strata_scene_camera(sc, NULL, 641, 479, &pose) == STRATA_OK &&
                look(s, sc, &pose, taps, 641, 479, f);
        strata_scene_close(sc);
    }
    return done;
}

static json_t *efficiency(strata *s, uint64_t seed) {
    static const char *const taps[] = {"hiz.taps=2", "hiz.taps=4", "hiz.taps=8"};
    json_t *to = json_object();
    for (int t = 0; t < 3; ++t) {
        json_t *of = json_object();
        found all = {0}, city = {0};
        for (int kind = 0; kind < CULL_KINDS; ++kind) {
            found f = {0};
            find_in_kind(s, (cull_kind)kind, taps[t], seed, &f);
            add_found(&all, &f);
            json_object_set_new(of, cull_kind_names[kind], found_json(&f));
        }
        find_in_city(s, taps[t], &city);
        json_object_set_new(of, "city", found_json(&city));
        add_found(&all, &city);
        json_object_set_new(of, "all", found_json(&all));
        json_object_set_new(to, taps[t], of);
    }
    return to;
}

int main(int count, char **arguments) {
    const uint64_t wanted = count > 1 ? strtoull(arguments[1], NULL, 10) : 0,
                   seed = count > 2 ? strtoull(arguments[2], NULL, 10) : 1;
    uint32_t failures = 0, opened = 0;
    if (count < 2 || count > 3 || wanted == 0) {
        fprintf(stderr, "usage: hiz_sweep OBJECT-FRAMES [SEED]\n");
        return 2;
    }
    json_t *result =
        json_pack("{s:I, s:I}", "wanted", (json_int_t)wanted, "seed", (json_int_t)seed);
    for (int b = 0; b < 2; ++b) {
        cull_rig rig;
        json_t *kinds = json_object();
        if (!cull_open(backends[b], 0, &rig)) {
            json_decref(kinds);
            continue;
        }
        ++opened;
        for (int kind = 0; kind < CULL_KINDS; ++kind)
            failures += sweep_kind(&rig, (cull_kind)kind, wanted / CULL_KINDS + 1, seed, kinds);
        json_object_set_new(result, backends[b], kinds);
        if (!json_object_get(result, "found")) {
            json_object_set_new(result, "device", json_string(rig.culled->device_info.name));
            json_object_set_new(result, "found", efficiency(rig.culled, seed));
        }
        cull_close(&rig);
    }
    json_dumpf(result, stdout, JSON_INDENT(1) | JSON_REAL_PRECISION(4));
    putchar('\n');
    json_decref(result);
    return failures || !opened;
}
