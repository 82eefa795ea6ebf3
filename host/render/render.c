/* SPDX-License-Identifier: MIT
 *
 * strata_render and the outputs: options with their defaults, the frames, the image read back; a
 * module that fails is left out and the plan made again, a lost device is replaced.
 */
#include "render/render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_REPLANS 16u
#define MAX_SAMPLES 1024u

strata_result render_own(const strata *s, const strata_scene *sc, base_error *err) {
    if (sc && sc->owner == s)
        return STRATA_OK;
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s",
                     sc ? "the scene belongs to another instance" : "no scene is given");
}

/* ---- options --------------------------------------------------------------------------------- */

static const char *const filters[] = {
    [STRATA_FILTER_BOX] = "box",
    [STRATA_FILTER_TENT] = "tent",
    [STRATA_FILTER_GAUSSIAN] = "gaussian",
};

const char *render_filter_name(uint32_t filter) {
    return filters[filter];
}

uint32_t render_filter(const strata_render_options *options) {
    for (uint32_t i = 0; i < BASE_COUNT(filters); ++i)
        if (options->filter && strcmp(filters[i], options->filter) == 0)
            return i;
    return STRATA_FILTER_BOX;
}

uint32_t render_side(const strata_render_options *options) {
    uint32_t side = 1;
    while (side * side < options->samples)
        ++side;
    return side;
}

static strata_result check_size(const strata_render_options *options, base_error *err) {
    if (options->width > IMAGE_MAX_SIDE || options->height > IMAGE_MAX_SIDE ||
        (uint64_t)options->width * options->height > IMAGE_MAX_PIXELS)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "size %ux%u is too large",
                         options->width, options->height);
    const uint32_t side = options->samples <= MAX_SAMPLES ? render_side(options) : 0;
    if (side * side != options->samples)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "samples: %u is not one of 1, 4, 9, 16, .. %u, the squares that a "
                         "regular grid of sub-pixels takes",
                         options->samples, MAX_SAMPLES);
    if (options->width > IMAGE_MAX_SIDE / side || options->height > IMAGE_MAX_SIDE / side ||
        (uint64_t)options->width * options->height > IMAGE_MAX_PIXELS / options->samples)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "size %ux%u with %u samples a pixel is too large", options->width,
                         options->height, options->samples);
    return STRATA_OK;
}

static strata_result check_filter(const strata_render_options *options, base_error *err) {
    if (options->filter && strcmp(options->filter, filters[render_filter(options)]) != 0)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "filter: '%.64s' is not box, tent or gaussian", options->filter);
    if (options->samples > 1 && (options->outputs & STRATA_OUTPUT_DEEP))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "a deep image holds the fragments of pixels: it takes one sample a pixel, "
                         "not %u",
                         options->samples);
    return STRATA_OK;
}

strata_result render_options(const strata_render_options *given, strata_render_options *options,
                             base_error *err) {
    *options = (strata_render_options){.struct_size = sizeof *options};
    if (given && !base_take(options, sizeof *options, given))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "struct_size is not set, or options are of a later version");
    if (options->width == 0)
        options->width = 800;
    if (options->height == 0)
        options->height = 600;
    if (options->samples == 0)
        options->samples = 1;
    strata_result r = check_size(options, err);
    if (r == STRATA_OK)
        r = check_filter(options, err);
    if (r != STRATA_OK)
        return r;
    if (options->repeat == 0)
        options->repeat = 1;
    if (!options->has_background) {
        const float gray[4] = {0.2f, 0.2f, 0.2f, 1.0f};
        memcpy(options->background, gray, sizeof gray);
    }
    for (int i = 0; i < 4; ++i)
        if (!isfinite(options->background[i]))
            return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "background is not finite");
    if (options->continues > 1 || options->learn > 1)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "continues or learn is neither 0 nor 1");
    if (!(options->budget >= 0))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "budget is negative or not a number");
    if (!(options->pace >= 0 && isfinite(options->pace)))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "pace is negative or not a finite number");
    if (options->pace == 0)
        options->pace = 1;
    if (options->setting_count && !options->settings)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "settings is NULL");
    if (!(options->tolerance >= 0))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                         "tolerance is negative or not a number");
    if (options->outputs &
        ~(STRATA_OUTPUT_COLOR | STRATA_OUTPUT_DEPTH | STRATA_OUTPUT_BOUND | STRATA_OUTPUT_DEEP))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "outputs: 0x%x has unknown bits",
                         options->outputs);
    return STRATA_OK;
}

strata_result render_view(const strata *s, const scene *sc, const strata_render_options *options,
                          double turn, scene_view *view, base_error *err) {
    const int continues = options->continues && s->start.scene == sc;
    return scene_view_choose(sc, options->camera, options->pose,
                             continues ? &s->start.bounds : NULL, turn, options->width,
                             options->height, view, err);
}

/* ---- reading back ---------------------------------------------------------------------------- */

/* The nearest of a pixel's sub-pixels, in reversed depth. A mean of depths would be a surface that
 * is not there. */
static float nearest_depth(const float *raw, const render_session *session, size_t x, size_t y) {
    const size_t side = session->side;
    float nearest = 0;
    for (size_t j = 0; j < side; ++j)
        for (size_t i = 0; i < side; ++i) {
            const float z = raw[(y * side + j) * session->width + x * side + i];
            nearest = z > nearest ? z : nearest;
        }
    return nearest;
}

static strata_result read_depth(strata *s, base_error *err) {
    const render_session *session = s->session;
    const size_t count = (size_t)session->width * session->height;
    const uint32_t width = s->result.width, height = s->result.height;
    float *raw = base_calloc(count, sizeof *raw);
    if (!raw)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "depth: out of memory");
    strata_result r = image_create(width, height, &s->result.depth, err);
    if (r == STRATA_OK)
        r = gpu_image_read(s->gpu, session->depth, 0, raw, count * sizeof *raw, err);
    for (size_t i = 0; i < (size_t)width * height && r == STRATA_OK; ++i) {
        const float z = nearest_depth(raw, session, i % width, i / width);
        const float distance =
            z > 0 ? (float)scene_view_distance(&s->result.view, (double)z) : INFINITY;
        for (int c = 0; c < 3; ++c)
            s->result.depth.pixels[4 * i + (size_t)c] = distance;
        s->result.depth.pixels[4 * i + 3] = 1;
    }
    s->result.has_depth = r == STRATA_OK;
    free(raw);
    return r;
}

static strata_result read_back(strata *s, const strata_render_options *options, base_error *err) {
    render_session *session = s->session;
    render_result *result = &s->result;
    const strata_image shown = session->image.id ? session->image : session->color;
    image_free(&result->color); /* of a rendering that missed the tolerance */
    image_free(&result->depth);
    strata_result r = image_create(result->width, result->height, &result->color, err);
    if (r == STRATA_OK)
        r = gpu_image_read(s->gpu, shown, 0, result->color.pixels,
                           (size_t)result->width * result->height * 4 * sizeof(float), err);
    if (r == STRATA_OK && (options->outputs & STRATA_OUTPUT_DEPTH))
        r = read_depth(s, err);
    if (r == STRATA_OK && session->certify)
        r = render_bound_read(session, &result->bound, err);
    result->has_deep = r == STRATA_OK && (options->outputs & STRATA_OUTPUT_DEEP) != 0;
    if (result->has_deep)
        result->deep = render_deep_image(session);
    return r;
}

/* ---- frames ---------------------------------------------------------------------------------- */

static double gpu_ms(const render_result *result) {
    double sum = result->pass_count > 0 ? 0 : -1;
    for (uint32_t i = 0; i < result->pass_count && sum >= 0; ++i)
        sum = result->passes[i].gpu_ms < 0 ? -1 : sum + result->passes[i].gpu_ms;
    return sum;
}

/* What the frame that just ended added to the result since `before`. */
static render_figures figures_of(const strata *s, const render_result *before, double ms) {
    const render_result *result = &s->result;
    return (render_figures){.ms = ms,
                            .gpu_ms = gpu_ms(result),
                            .retries = result->retries - before->retries,
                            .stalls = result->stalls - before->stalls,
                            .prepared = result->prepared - before->prepared,
                            .bands = s->session->band_count,
                            .report = s->session->report};
}

static strata_result render_frames(strata *s, const strata_render_options *options,
                                   const char **failed, base_error *err) {
    render_result *result = &s->result;
    /* The key light belongs to the camera that the sequence began with, before it turned. */
    strata_result r = upload_set_key_light(s->session->upload, &s->start.view, err);
    if (r != STRATA_OK)
        return r;
    for (uint32_t i = result->frame_count; i < options->repeat && !s->budget.replan; ++i) {
        const double begin = base_now_ms();
        const render_result before = *result;
        r = render_view(s, s->session->scene, options, options->angle + options->turn * i,
                        &result->view, err);
        if (r == STRATA_OK)
            r = render_frame(s->session, &result->view, options, failed, err);
        if (r != STRATA_OK)
            return r;
        result->frames[result->frame_count++] = figures_of(s, &before, base_now_ms() - begin);
        if (options->learn)
            result->learnt |= (uint32_t)render_learn_frame(s, &s->costs, options->pace);
        r = render_budget_learn(s, options, err);
        if (r != STRATA_OK)
            return r;
        if (options->progress &&
            options->progress(options->user, (i + 1.0) / options->repeat) != STRATA_OK)
            return base_fail(err, STRATA_ERROR_CANCELLED, "cancelled");
    }
    return STRATA_OK;
}

static void end_frames(strata *s) {
    render_result *result = &s->result;
    result->bands = s->session->band_count;
    result->report = s->session->report;
    if (result->report.lost > 0)
        render_warn(s,
                    "%llu pixels are wrong: their fragments arrived out of order by more than the "
                    "technique holds",
                    (unsigned long long)result->report.lost);
}

/* Ends everything that lives on the device, so that the next attempt opens a new one. */
static void drop_device(strata *s) {
    render_session_free(s->session);
    s->session = NULL;
    gpu_close(s->gpu);
    s->gpu = NULL;
}

/* Where a sequence begins, this frame is what its others go by. */
static void begin_sequence(strata *s, const scene *sc, const scene_view *view) {
    s->start = (render_start){.scene = sc, .view = *view};
    memcpy(s->start.bounds.lower, sc->lower, sizeof s->start.bounds.lower);
    memcpy(s->start.bounds.upper, sc->upper, sizeof s->start.bounds.upper);
}

/* Whether what its plan expects is of this view and scene. */
static void compare_view(strata *s, const scene *sc, const strata_render_options *options) {
    render_session *session = s->session;
    session->as_planned = session->planned_revision == sc->revision &&
                          session->planned_angle == options->angle &&
                          memcmp(session->planned_view.world_to_clip, s->result.view.world_to_clip,
                                 sizeof s->result.view.world_to_clip) == 0;
}

/* The session that fits, and what of the frames it renders. */
static strata_result plan_and_render(strata *s, scene *sc, const strata_render_options *options,
                                     const char **failed, base_error *err) {
    plan *p = NULL;
    strata_result r = render_view(s, sc, options, 0, &s->result.view, err);
    if (r == STRATA_OK && !options->continues)
        begin_sequence(s, sc, &s->result.view);
    if (r == STRATA_OK && render_keeps_plan(s, sc, options)) {
        r = render_session_keep(s, options, err);
    } else if (r == STRATA_OK) {
        r = render_plan(s, sc, options, &s->result.view, &p, err);
        if (r == STRATA_OK)
            r = render_session_open(s, sc, options, p, err);
        if (r == STRATA_OK) {
            s->session->planned_view = s->result.view;
            s->session->planned_angle = options->angle;
            s->session->planned_revision = sc->revision;
            render_budget_planned(s);
        }
    }
    if (r != STRATA_OK)
        return r;
    compare_view(s, sc, options);
    s->session->careful = s->losses > 0;
    return render_frames(s, options, failed, err);
}

/* All frames; a budget may want another plan between two of them. */
static strata_result attempt(strata *s, scene *sc, const strata_render_options *options,
                             const char **failed, base_error *err) {
    *failed = NULL;
    s->result.frame_count = 0;
    strata_result r = render_device(s, err);
    while (r == STRATA_OK && s->result.frame_count < options->repeat)
        r = plan_and_render(s, sc, options, failed, err);
    if (r == STRATA_OK)
        end_frames(s);
    return r;
}

/* Whether another plan or device may succeed after this failure; excludes the culprit. */
static int recoverable(strata *s, strata_result r, const char *failed, const base_error *err) {
    base_error ignored = {0};
    if (r == STRATA_ERROR_DEVICE_LOST) {
        s->losses++;
        drop_device(s); /* also when this render is given up: the next one opens another */
        if (++s->result.losses > 1)
            return failed && render_exclude(s, failed, "the device was lost twice in its passes",
                                            &ignored) == STRATA_OK;
        render_warn(s, "the device was lost and is replaced");
        return 1;
    }
    if (!failed || r == STRATA_ERROR_CANCELLED || r == STRATA_ERROR_OUT_OF_HOST_MEMORY ||
        r == STRATA_ERROR_OVERFLOW)
        return 0;
    r = render_exclude(s, failed, err->text, &ignored);
    render_session_free(s->session);
    s->session = NULL;
    return r == STRATA_OK;
}

/* Those of a render that failed as a whole, or for want of memory, say nothing about the next. */
static void forget_exclusions(strata *s, uint32_t count) {
    while (s->exclusion_count > count) {
        const plan_exclusion *last = &s->exclusions[--s->exclusion_count];
        free((void *)(uintptr_t)last->technique);
        free((void *)(uintptr_t)last->reason);
    }
}

/* Renders, with other techniques where some fail, and reads back. */
static strata_result render_once(strata *s, scene *sc, const strata_render_options *options,
                                 base_error *err) {
    base_error first = {0};
    const uint32_t exclusions = s->exclusion_count;
    strata_result r = STRATA_OK;
    int out_of_memory = 0;
    for (uint32_t i = 0; i < MAX_REPLANS; ++i) {
        const char *failed = NULL;
        *err = (base_error){0};
        r = attempt(s, sc, options, &failed, err);
        out_of_memory |= r == STRATA_ERROR_OUT_OF_DEVICE_MEMORY;
        if (r == STRATA_OK || !recoverable(s, r, failed, err))
            break;
        if (first.result == STRATA_OK)
            first = *err;
    }
    if (r == STRATA_OK)
        r = read_back(s, options, err);
    if (r != STRATA_OK || out_of_memory)
        forget_exclusions(s, exclusions);
    if (r != STRATA_OK && first.result != STRATA_OK)
        *err = first; /* what went wrong first explains more than that no plan was left */
    return r == STRATA_OK ? r : err->result;
}

/* Raises the plan until it differs from what was rendered; *more = 0: there is nothing else. */
static strata_result raise_plan(strata *s, scene *sc, const strata_render_options *options,
                                int *more, base_error *err) {
    int same = 1;
    strata_result r = STRATA_OK;
    while (same && s->raise < PLAN_RAISE_EXACT && r == STRATA_OK) {
        s->raise++;
        r = render_same_plan(s, sc, options, &same, err);
    }
    *more = !same;
    return r;
}

/* Again and again, until the certificate is within the tolerance. PARTIAL: it never was. */
static strata_result render_within(strata *s, scene *sc, const strata_render_options *options,
                                   base_error *err) {
    strata_result r = render_once(s, sc, options, err);
    int more = 1;
    while (r == STRATA_OK && options->tolerance > 0) {
        r = render_bound_note(s, err);
        if (r != STRATA_OK || render_bound_holds(&s->result))
            return r;
        r = raise_plan(s, sc, options, &more, err);
        if (r == STRATA_OK && !more) {
            render_warn(s, "the certificate does not hold the tolerance of %.3g",
                        options->tolerance);
            return STRATA_PARTIAL;
        }
        if (r == STRATA_OK)
            r = render_once(s, sc, options, err);
    }
    return r;
}

strata_result strata_render(strata *s, strata_scene *sc, const strata_render_options *given) {
    strata_render_options options;
    base_error err = {0};
    s->error = (base_error){0};
    s->raise = 0;
    render_result_clear(&s->result);
    strata_result r = render_own(s, sc, &s->error);
    if (r == STRATA_OK)
        r = render_options(given, &options, &s->error);
    if (r != STRATA_OK)
        return r;
    s->result.outputs = options.outputs | STRATA_OUTPUT_COLOR;
    s->result.width = options.width;
    s->result.height = options.height;
    s->result.samples = options.samples;
    s->result.filter = render_filter(&options);
    s->result.tolerance = options.tolerance;
    s->result.scene_path = base_strdup(sc->scene->path ? sc->scene->path : "");
    s->result.frames = base_calloc(options.repeat, sizeof *s->result.frames);
    if (!s->result.frames || !s->result.scene_path)
        return base_fail(&s->error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    options.continues = options.continues && s->start.scene == sc->scene;
    if (!options.continues || options.budget != s->budget.watch.asked)
        render_budget_begin(s, options.budget);
    if (render_continues(s, &options))
        s->raise = s->session->raise;
    r = render_within(s, sc->scene, &options, &err);
    s->raise = 0;
    if (r == STRATA_OK || r == STRATA_PARTIAL)
        render_budget_warn(s, &options);
    if (s->result.learnt)
        render_learn_keep(s);
    s->result.valid = r == STRATA_OK || r == STRATA_PARTIAL;
    return s->result.valid ? r : base_fail(&s->error, err.result, "%s", err.text);
}

/* ---- outputs --------------------------------------------------------------------------------- */

static const image *output_image(const strata *s, uint32_t output) {
    if (!s->result.valid)
        return NULL;
    if (output == STRATA_OUTPUT_COLOR)
        return &s->result.color;
    if (output == STRATA_OUTPUT_BOUND && (s->result.outputs & STRATA_OUTPUT_BOUND))
        return &s->result.bound.map;
    return output == STRATA_OUTPUT_DEPTH && s->result.has_depth ? &s->result.depth : NULL;
}

strata_result strata_size(const strata *s, uint32_t *width, uint32_t *height) {
    if (!s->result.valid)
        return STRATA_ERROR_INVALID_STATE;
    *width = s->result.width;
    *height = s->result.height;
    return STRATA_OK;
}

strata_result strata_read(strata *s, uint32_t output, float *pixels, size_t size) {
    s->error = (base_error){0};
    const image *im = output_image(s, output);
    if (!im)
        return base_fail(&s->error, STRATA_ERROR_INVALID_STATE, "no such output was rendered");
    const size_t row = (size_t)im->width * 4;
    if (size != row * im->height * sizeof(float))
        return base_fail(&s->error, STRATA_ERROR_INVALID_ARGUMENT,
                         "the output has %zu bytes, not %zu", row * im->height * sizeof(float),
                         size);
    for (uint32_t y = 0; y < im->height; ++y)
        memcpy(pixels + row * y, im->pixels + row * (im->height - 1 - y), row * sizeof(float));
    return STRATA_OK;
}

strata_result strata_save(strata *s, uint32_t output, const char *path) {
    s->error = (base_error){0};
    if (output == STRATA_OUTPUT_DEEP && s->result.valid && s->result.has_deep)
        return image_write_deep_exr(&s->result.deep, path, &s->error);
    const image *im = output_image(s, output);
    if (!im)
        return base_fail(&s->error, STRATA_ERROR_INVALID_STATE, "no such output was rendered");
    return image_write(im, path, &s->error);
}
