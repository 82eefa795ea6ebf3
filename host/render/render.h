/* SPDX-License-Identifier: MIT
 *
 * From a plan to an image: the instance behind strata/host.h, the session that keeps techniques
 * alive between frames, and the frame's loops (rounds, bands, retries). Holds no rendering
 * algorithm.
 *
 *     api.c       strata/host.h: instances, scenes, texts
 *     render.c    strata/host.h: rendering and outputs
 *     prepare.c   scene -> demand -> plan -> session
 *     session.c   techniques: create, prepare, destroy; what they see of the host
 *     frame.c     record, verify, retry
 *     room.c      pools grow, or more bands
 *     native.c    the native extensions
 *     effects.c   the generated effect header
 *     bound.c     certificates: losses and bound/1
 *     deep.c      fragments as elements, for deep images
 *     account.c   what it cost
 *     budget.c    frames within a budget of time
 *     learn.c     and what the plan learns of that
 *     complexity.c  how many fragments pixels hold, and how many they need
 *     configurations.c  every way to render a scene
 *     compare.c   strata/host.h: how far pictures are apart
 */
#ifndef STRATA_HOST_RENDER_H
#define STRATA_HOST_RENDER_H

#include "gpu/gpu.h"
#include "image/image.h"
#include "modules/modules.h"
#include "plan/budget.h"
#include "plan/demand.h"
#include "plan/estimate.h"
#include "plan/plan.h"
#include "scene/camera.h"
#include "scene/scene.h"
#include "scene/upload.h"
#include "strata/host.h"

#define RENDER_MAX_POOLS 16u
#define RENDER_MAX_BANDS 65536u

struct strata_scene {
    strata *owner;
    scene *scene;
    struct strata_scene *next; /* in the owner's list */
};

typedef struct render_rect {
    uint32_t x, y, width, height;
} render_rect;

/* Mirrors StrataFrame in shaders/strata/frame.glsl (std140). */
typedef struct render_frame_block {
    float world_to_clip[16], world_to_eye[16], clip_to_world[16];
    float eye[4], background[4];
    uint32_t frame_size[4]; /* width, height, samples, index */
    uint32_t band[4];
    uint32_t counts[4]; /* lights, materials, records, textures */
} render_frame_block;

struct render_session;

/* One technique of the session. The tables that it is handed have this as `self`. */
typedef struct render_technique {
    struct render_session *session;
    const plan_technique *planned;
    const strata_technique *technique;
    void *state;
    strata_gpu gpu;
    strata_host host;
    gpu_scope *create_scope, *prepare_scope;
    gpu_scope *scope; /* where creation goes now; NULL: creation is not allowed */
    strata_pool pools[RENDER_MAX_POOLS];
    uint64_t pool_capacity[RENDER_MAX_POOLS]; /* to begin with after the next prepare, in order */
    uint64_t pool_needed[RENDER_MAX_POOLS];   /* most that a band of the last recording needed */
    uint32_t pool_count;
    uint32_t pools_begin_small; /* at the next prepare: the frame was split */
    uint32_t created;           /* create() was called: destroy() is due */
    uint32_t recording;         /* in record(): native passes are allowed */
    uint32_t verifying;
    base_error error;
} render_technique;

#define RENDER_REPORT_BEFORE 1u /* bit of render_report.known */
typedef struct render_report {
    uint64_t total, kept, dropped, largest;
    uint64_t lost;   /* pixels */
    uint64_t before; /* total of a clip technique, which hides some from those after it */
    uint64_t objects, outside, slipped, occluded, late, certified;
    uint64_t visible, wrong, overshot; /* objects, as a checker found them */
    uint32_t known;                    /* bit 1 << STRATA_REPORT_*, or RENDER_REPORT_BEFORE */
} render_report;

/* Everything that lives as long as the plan, the scene, the size and the device stay the same. */
typedef struct render_session {
    strata *owner;
    scene *scene;
    uint64_t scene_revision;
    uint32_t width, height; /* in sub-pixels */
    uint32_t samples, side; /* sub-pixels a pixel, and along one side of it */
    uint32_t filter;        /* STRATA_FILTER_* */
    uint32_t shuffle;
    uint32_t certify; /* how wrong the image may be is asked for */
    double tolerance; /* the most that is accepted; 0: none was given */
    uint32_t careful; /* submit after each technique, to learn which one loses the device */
    plan *plan;
    scene_view planned_view; /* that it was made for, before it turned by this angle */
    double planned_angle;
    uint64_t planned_revision; /* and of which scene */
    uint32_t as_planned; /* 1: these are what is rendered; else its statistics are of others */
    char *plan_text;     /* its JSON, compared to see whether it changed */
    char *request;       /* what of the options it was made for */
    uint32_t raise;      /* and the instance's raise then */
    demand wants;        /* and what the scene called for */
    upload *upload;
    gpu_scope *scope;
    strata_image color, depth, limit, bound; /* bound: when it is asked for */
    gpu_scope *loss_scope;
    strata_buffer loss;              /* StrataLoss, for the largest band */
    strata_image image, image_bound; /* image/1 and its bound in pixels; none when a pixel has one
                                        sample */
    strata_buffer frame_block;
    strata_fragments fragments;
    uint32_t has_fragments;
    strata_draws draws[2]; /* opaque, transparent: as a technique published them last, or none */
    uint32_t rounds;       /* of the opaque part: 2 when techniques that draw learn from depth/1 */
    render_technique *techniques;
    uint32_t technique_count;
    render_rect *bands;
    uint32_t band_count, band_width, band_height;
    uint32_t prepared; /* 0: prepare() is due */
    uint32_t changed;  /* STRATA_CHANGED_* for it */
    uint64_t frame_index;
    uint32_t attempt;
    const char *again_by; /* technique for which this frame is recorded again; NULL: none was */
    strata_program deep_program; /* made when the first deep image is asked for */
    strata_buffer deep_elements;
    render_report report;
    strata_scene_stats stats;
} render_session;

typedef struct render_pass_time {
    char label[64], owner[64];
    double gpu_ms, cpu_ms;
} render_pass_time;

/* A deep image while its bands come in; see image_deep. */
typedef struct render_deep {
    uint64_t *offset;
    uint32_t *count;
    float *depth, *color, *color_alpha; /* color_alpha: coloured transmission only */
    float *opaque;                      /* color/1 before anything transparent was folded */
    uint64_t samples;
    size_t capacity;
} render_deep;

/* How wrong an image may be. */
typedef struct render_bound {
    image map;            /* of each channel; +inf: uncertified */
    double max, mean;     /* over all channels of certified pixels */
    uint64_t uncertified; /* pixels */
    uint32_t known;       /* 1: a certificate was asked for */
} render_bound;

/* One rendering on the way to a tolerance. */
typedef struct render_step {
    char *plan; /* "kplus kplus.k=8 ..": what ran, with what trades accuracy */
    double max, mean;
    uint64_t uncertified; /* pixels */
} render_step;

/* What one frame cost. */
typedef struct render_figures {
    double ms, gpu_ms; /* gpu_ms: of its passes, -1 unknown */
    uint32_t retries, stalls, bands;
    uint32_t prepared; /* times that the techniques prepared */
    render_report report;
} render_figures;

/* What the frames of a sequence share; see strata_render_options.continues. */
typedef struct render_start {
    const scene *scene; /* NULL: none began */
    scene_box bounds;
    scene_view view; /* for the key light */
    uint32_t frames; /* so far; of the last: */
    float seen[16];  /* world_to_clip */
    uint64_t seen_revision;
    uint32_t moving; /* 1: the camera or the scene was another in two frames */
} render_start;

/* What the last render did, for the account and the outputs. */
typedef struct render_result {
    uint32_t valid, width, height, samples, filter, outputs;
    scene_view view;
    image color, depth;
    render_bound bound;
    double tolerance; /* 0: none was asked for */
    render_step steps[PLAN_RAISE_EXACT + 1];
    uint32_t step_count;
    render_deep deep_build;
    image_deep deep;
    uint32_t has_depth, has_deep;
    render_figures *frames;
    uint32_t frame_count;
    render_pass_time *passes;
    uint32_t pass_count;
    uint32_t retries, bands, stalls, prepared;
    uint32_t losses; /* of the device */
    uint32_t learnt; /* 1: some frame added to what is known of the device */
    render_report report;
    char **warnings;
    uint32_t warning_count;
    char *scene_path;
} render_result;

#define RENDER_BUDGET_FRAMES 1024u /* that are remembered */

/* A frame of a sequence with a budget. */
typedef struct render_budget_frame {
    double ms, level; /* level of what is turned, 0: nothing is */
    uint32_t judged;  /* 0: it says nothing, see budget.c */
    uint32_t plan;    /* index into the sequence's */
} render_budget_frame;

/* Of a sequence: what was learnt, and what happens next. */
typedef struct render_budget {
    budget_watch watch;
    costs costs;                  /* what the device's are, and what the frames add to them */
    double beside;                /* ms of a frame that are not its passes' */
    double ns;                    /* of a blended fragment, as frames took it; 0: as costs say */
    double paces;                 /* of this plan's frames, summed, see render_frame_pace */
    uint32_t paced;               /* and of how many */
    double deepest;               /* most fragments in one pixel that its frames reported */
    uint32_t replan;              /* 1: the next frame wants another plan */
    int prepared, recorded_again; /* the last frame was */
    render_budget_frame *frames;  /* the last ones */
    uint32_t count;
    json_t *plans; /* what folds in them, each once, "kplus payload=half + ppc"; NULL = no plan */
    uint32_t plan; /* index of the present one */
} render_budget;

struct strata {
    base_error error;
    char *backend, *device, *module_path, *cache_dir, *inject;
    uint32_t check;
    uint64_t memory;
    modules *modules;
    gpu *gpu;
    gpu_device_info device_info;
    render_session *session;
    render_result result;
    render_start start;         /* of the sequence */
    plan_exclusion *exclusions; /* techniques that failed; texts owned */
    uint32_t exclusion_count;
    struct strata_scene *scenes;
    uint32_t losses;      /* of the device, in all renders */
    costs costs;          /* measured on the device that is open, while there is one */
    render_budget budget; /* of the sequence */
    uint32_t raise;       /* of the plan: how often the tolerance was missed in this render */
};

/* ---- api.c ----------------------------------------------------------------------------------- */
/* Writes the object and lets go of it. */
strata_result render_write_json(strata *s, json_t *object, strata_write_fn write, void *user);

/* ---- render.c -------------------------------------------------------------------------------- */
/* INVALID_ARGUMENT unless the scene is one of the instance's. */
strata_result render_own(const strata *s, const strata_scene *sc, base_error *err);
/* Checked options with every default filled in. */
strata_result render_options(const strata_render_options *given, strata_render_options *options,
                             base_error *err);
/* Of checked options: sub-pixels along one side of a pixel; STRATA_FILTER_*, and its name. */
uint32_t render_side(const strata_render_options *options);
uint32_t render_filter(const strata_render_options *options);
const char *render_filter_name(uint32_t filter);
/* The camera of these options, turned by so many degrees. */
strata_result render_view(const strata *s, const scene *sc, const strata_render_options *options,
                          double turn, scene_view *view, base_error *err);

/* ---- prepare.c ------------------------------------------------------------------------------- */
/* Demand, estimate and plan for these options, as this camera sees the scene. */
strata_result render_plan(strata *s, scene *sc, const strata_render_options *options,
                          const scene_view *view, plan **out, base_error *err);
/* Opens the device unless it is open. */
strata_result render_device(strata *s, base_error *err);
strata_result render_modules(strata *s, base_error *err);
const modules_note **render_notes(const strata *s); /* of all modules; free(); NULL: no memory */
/* Whether these options would be rendered, at this raise, as the session was. */
strata_result render_same_plan(strata *s, scene *sc, const strata_render_options *options,
                               int *same, base_error *err);
/* Whether the frame continues a sequence that the session was made for by options that ask for the
 * same: the raise of its plan holds; and whether its plan does, the scene calling for the same. */
int render_continues(const strata *s, const strata_render_options *options);
int render_keeps_plan(const strata *s, const scene *sc, const strata_render_options *options);
/* The session as it is, after the scene's edits. */
strata_result render_session_keep(strata *s, const strata_render_options *options, base_error *err);
/* Makes s->session fit the plan and options, keeping the old one where nothing changed. Takes
 * ownership of p in any case. */
strata_result render_session_open(strata *s, scene *sc, const strata_render_options *options,
                                  plan *p, base_error *err);
/* Sets the plan's knob to a value; the next frame prepares. */
strata_result render_session_turn(render_session *session, double value, base_error *err);
/* No technique of this id in later plans. */
strata_result render_exclude(strata *s, const char *technique, const char *reason, base_error *err);
void render_warn(strata *s, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* ---- session.c ------------------------------------------------------------------------------- */
strata_result render_session_create(strata *s, scene *sc, const strata_render_options *options,
                                    plan *p, render_session **out, base_error *err);
/* prepare() of every technique, in order, if it is due. *failed: the technique that failed. */
strata_result render_session_prepare(render_session *session, const char **failed, base_error *err);
void render_session_free(render_session *session); /* NULL is fine */
/* Splits the frame into at least `count` rows (then columns) of even size. */
strata_result render_bands(render_session *session, uint32_t count, base_error *err);

/* ---- frame.c --------------------------------------------------------------------------------- */
/* One frame with all its rounds, bands and retries. *failed as above. */
strata_result render_frame(render_session *session, const scene_view *view,
                           const strata_render_options *options, const char **failed,
                           base_error *err);

/* ---- native.c -------------------------------------------------------------------------------- */
/* The table of this extension for the techniques of this device, NULL when it has none. */
const void *render_extension(const gpu *g, const char *id);

/* ---- room.c ---------------------------------------------------------------------------------- */
/* render_session_prepare; *again = 1: it did not fit and the frame was split, prepare again. */
strata_result render_prepare_in_room(render_session *session, int *again, const char **failed,
                                     base_error *err);
/* Before a frame: whether the camera or the scene is another than in the one before. */
void render_room_watch(render_session *session, const scene_view *view);
/* Before it is recorded: where it moves what may soon be short grows, which costs no recording now.
 * *again = 1: for want of memory the frame was split instead, prepare again. */
strata_result render_room_ahead(render_session *session, int *again, base_error *err);
/* Grows what was short; or splits the frame. */
strata_result render_make_room(render_session *session, base_error *err);

/* ---- effects.c ------------------------------------------------------------------------------- */
/* Hands the generated effect header and the effects' sources to the device. */
strata_result render_effects(render_session *session, base_error *err);

/* ---- bound.c --------------------------------------------------------------------------------- */
/* Whether these options ask for a certificate. */
int render_certify(const strata_render_options *options);
/* bound/1 and what programs see of it, before any is compiled; nothing where none is asked for. */
strata_result render_bound_create(render_session *session, base_error *err);
/* StrataLoss for the largest band. OUT_OF_DEVICE_MEMORY: bands must be smaller. */
strata_result render_bound_prepare(render_session *session, base_error *err);
void render_bound_begin(render_session *session);      /* recorded first in a frame */
void render_bound_begin_band(render_session *session); /* recorded first in a band */
/* Whether the result's certificate is within its tolerance; and notes that step. */
int render_bound_holds(const render_result *result);
strata_result render_bound_note(strata *s, base_error *err);
strata_result render_bound_read(const render_session *session, render_bound *out, base_error *err);

/* ---- deep.c ---------------------------------------------------------------------------------- */
/* After the opaque part: keeps its colours. */
strata_result render_deep_begin(render_session *session, base_error *err);
/* After a band was verified: appends its fragments, sorted, and the opaque surface. */
strata_result render_deep_band(render_session *session, const render_rect *band, base_error *err);
image_deep render_deep_image(const render_session *session); /* borrows the arrays */
void render_deep_free(render_deep *deep);

/* ---- budget.c -------------------------------------------------------------------------------- */
void render_budget_begin(strata *s, double asked); /* forgets the sequence before */
void render_budget_end(strata *s);
void render_budget_planned(strata *s); /* the session has a plan of its own */
/* Learns from the frame that just ended; what is to be turned is turned. */
strata_result render_budget_learn(strata *s, const strata_render_options *options, base_error *err);
void render_budget_warn(strata *s, const strata_render_options *options);
json_t *render_budget_json(const strata *s); /* null when there is none */

/* ---- learn.c --------------------------------------------------------------------------------- */
/* What is known of the device that was just opened. */
strata_result render_costs_load(strata *s, base_error *err);
/* Adds the frame that just ended, its times divided by `pace`, to the device's costs or to those of
 * a sequence; 0: it is not typical, or passes are not timed. */
int render_learn_frame(const strata *s, costs *c, double pace);
/* How many times as long as usual it took, by those of its techniques that were measured on this
 * device before; 0: unknown. */
double render_frame_pace(const strata *s);
/* Whether all of it that was timed was measured on this device before. */
int render_knows_frame(const strata *s);
/* What the frames of this render added: fits and saves it. */
void render_learn_keep(strata *s);
strata_result render_costs_fit(strata *s, costs *c, base_error *err);

/* ---- complexity.c ---------------------------------------------------------------------------- */
/* Of the last render's deep image: how many pixels hold, and how many need, so many fragments.
 * Null when there is none. */
json_t *render_complexity_json(const strata *s);

/* ---- configurations.c ------------------------------------------------------------------------ */
/* {"configurations", "refused"}; *out is set in any case. all: also knobs that only cost time. */
strata_result render_configurations(strata *s, scene *sc, const strata_render_options *options,
                                    const scene_view *view, int all, json_t **out, base_error *err);

/* ---- account.c ------------------------------------------------------------------------------- */
/* Merges the device's timings since gpu_begin into the frame's. */
strata_result render_account_passes(strata *s, base_error *err);
void render_result_clear(render_result *result);
/* New references; NULL when out of memory. */
json_t *render_account_json(const strata *s);
json_t *render_device_json(const strata *s);
json_t *render_filter_json(uint32_t samples, uint32_t filter); /* null when nothing is filtered */
json_t *render_warnings_json(const strata *s, const scene *sc, const plan *p); /* p may be NULL */

#endif
