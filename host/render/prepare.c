/* SPDX-License-Identifier: MIT
 *
 * From a scene and what the user asked for to a session that can render it: demand, estimate, plan;
 * and whether the session at hand still fits.
 */
#include "render/render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void render_warn(strata *s, const char *format, ...) {
    va_list arguments;
    char line[512];
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    base_log(BASE_LOG_INFO, "%s", line); /* who reads the account prints it */
    char **warnings =
        base_realloc(s->result.warnings, (size_t)s->result.warning_count + 1, sizeof *warnings);
    if (!warnings)
        return;
    s->result.warnings = warnings;
    warnings[s->result.warning_count] = base_strdup(line);
    s->result.warning_count += warnings[s->result.warning_count] != NULL;
}

strata_result render_modules(strata *s, base_error *err) {
    return s->modules ? STRATA_OK : modules_scan(s->module_path, &s->modules, err);
}

strata_result render_device(strata *s, base_error *err) {
    if (s->gpu)
        return STRATA_OK;
    const gpu_open_info info = {.backend = s->backend,
                                .device = s->device,
                                .cache_dir = s->cache_dir,
                                .check = (int)s->check,
                                .profile = 1,
                                .inject = s->losses ? NULL : s->inject};
    strata_result r = gpu_open(&info, &s->gpu, err);
    if (r != STRATA_OK)
        return r;
    gpu_describe(s->gpu, &s->device_info);
    return render_costs_load(s, err);
}

strata_result render_exclude(strata *s, const char *technique, const char *reason,
                             base_error *err) {
    plan_exclusion *exclusions =
        base_realloc(s->exclusions, (size_t)s->exclusion_count + 1, sizeof *exclusions);
    if (!exclusions)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "exclusions: out of memory");
    s->exclusions = exclusions;
    plan_exclusion *added = &exclusions[s->exclusion_count];
    *added = (plan_exclusion){.technique = base_strdup(technique), .reason = base_strdup(reason)};
    if (!added->technique || !added->reason) {
        free((void *)(uintptr_t)added->technique);
        free((void *)(uintptr_t)added->reason);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "exclusions: out of memory");
    }
    s->exclusion_count++;
    render_warn(s, "%s is left out: %s", technique, reason);
    return STRATA_OK;
}

/* ---- the plan -------------------------------------------------------------------------------- */

static uint64_t device_fact(void *user, const char *id) {
    return gpu_fact(((strata *)user)->gpu, id);
}

const modules_note **render_notes(const strata *s) {
    const uint32_t count = modules_count(s->modules);
    const modules_note **notes = base_calloc((size_t)count + 1, sizeof *notes);
    for (uint32_t i = 0; notes && i < count; ++i)
        notes[i] = modules_note_at(s->modules, i);
    return notes;
}

static strata_result estimate(plan_input *input, scene *sc, const scene_view *view,
                              strata_scene_stats *stats, const strata_render_options *options,
                              base_error *err) {
    const uint32_t side = render_side(options);
    estimate_view seen = {.width = options->width * side, .height = options->height * side};
    unsigned char *transparent = base_calloc((size_t)sc->material_count + 1, 1);
    if (!transparent)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "estimate: out of memory");
    memcpy(seen.world_to_clip, view->world_to_clip, sizeof seen.world_to_clip);
    strata_result r = plan_transparent_materials(input, sc, transparent, err);
    if (r == STRATA_OK)
        r = estimate_stats(sc, &seen, transparent, stats, err);
    free(transparent);
    return r;
}

strata_result render_plan(strata *s, scene *sc, const strata_render_options *options,
                          const scene_view *view, plan **out, base_error *err) {
    demand wants;
    strata_scene_stats stats = {.struct_size = sizeof stats};
    const int follows = s->start.scene == sc && s->budget.watch.asked == options->budget;
    const int learnt = follows && s->budget.costs.count > 0;
    plan_input input = {.demand = &wants,
                        .stats = &stats,
                        .fact = s->gpu ? device_fact : NULL,
                        .user = s,
                        .use = options->use,
                        .effects = options->effects,
                        .settings = options->settings,
                        .setting_count = options->setting_count,
                        .exclusions = s->exclusions,
                        .exclusion_count = s->exclusion_count,
                        .samples = options->samples,
                        .need_fragments = (options->outputs & STRATA_OUTPUT_DEEP) != 0,
                        .tolerance = options->tolerance,
                        .raise = s->raise,
                        .memory = s->memory,
                        .costs = learnt   ? &s->budget.costs
                                 : s->gpu ? &s->costs
                                          : NULL,
                        .budget = options->budget,
                        .beside = follows ? s->budget.beside : 0,
                        .ns = follows ? s->budget.ns : 0,
                        .least_late = follows ? s->budget.watch.least_late : 0,
                        .late = follows ? s->budget.watch.late : 0};
    const modules_note **notes = NULL;
    strata_result r = render_modules(s, err);
    if (r == STRATA_OK)
        r = demand_make(sc, &wants, err);
    if (r != STRATA_OK)
        return r;
    notes = render_notes(s);
    if (!notes)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "plan: out of memory");
    input.modules = notes;
    input.module_count = modules_count(s->modules);
    r = estimate(&input, sc, view, &stats, options, err);
    if (follows)
        stats.largest_depth = fmax(stats.largest_depth, s->budget.deepest);
    if (r == STRATA_OK)
        r = plan_make(&input, out, err);
    free(notes);
    return r;
}

/* ---- whether the session still fits ---------------------------------------------------------- */

/* What of a plan the techniques were prepared for; costs and reasons do not matter. Without what a
 * budget turns: what its plans have in common. */
static char *plan_key(const plan *p, int with_turned) {
    base_text text = {0};
    for (uint32_t i = 0; i < p->technique_count; ++i) {
        base_text_add(&text, "%s", p->techniques[i].technique->id);
        for (uint32_t k = 0; k < p->techniques[i].settings.count; ++k)
            if (with_turned || p->techniques[i].technique != p->turned || k != p->turned_knob)
                base_text_add(&text, " %a", p->techniques[i].settings.values[k]);
        base_text_add(&text, "\n");
    }
    for (uint32_t i = 0; i < p->effect_count; ++i)
        if (p->effects[i].active)
            base_text_add(&text, "+%s", p->effects[i].effect->id);
    base_text_add(&text, ".");
    if (text.failed) {
        base_text_free(&text);
        return NULL;
    }
    return text.data;
}

static int fits(const render_session *session, const scene *sc,
                const strata_render_options *options) {
    const uint32_t side = render_side(options);
    return session && session->scene == sc && session->width == options->width * side &&
           session->height == options->height * side && session->samples == options->samples &&
           session->filter == render_filter(options) && session->shuffle == options->shuffle &&
           session->certify == (uint32_t)render_certify(options) &&
           session->tolerance == options->tolerance;
}

/* What of the options goes into a plan beside what fits() compares. */
static char *request_of(const strata_render_options *options) {
    base_text text = {0};
    base_text_add(&text, "%s\n%s\n%a\n%a\n%u\n", options->use ? options->use : "",
                  options->effects ? options->effects : "auto", options->tolerance, options->budget,
                  options->outputs & STRATA_OUTPUT_DEEP);
    for (uint32_t i = 0; i < options->setting_count; ++i)
        base_text_add(&text, "%s\n", options->settings[i] ? options->settings[i] : "");
    if (text.failed) {
        base_text_free(&text);
        return NULL;
    }
    return text.data;
}

static int same_demand(const demand *a, const demand *b) {
    int same = a->count == b->count;
    for (uint32_t i = 0; i < a->count && same; ++i)
        same =
            strcmp(a->facts[i].id, b->facts[i].id) == 0 && a->facts[i].value == b->facts[i].value;
    return same;
}

int render_continues(const strata *s, const strata_render_options *options) {
    if (!options->continues || !s->session)
        return 0;
    char *request = request_of(options);
    const int same = request && strcmp(s->session->request, request) == 0;
    free(request);
    return same;
}

int render_keeps_plan(const strata *s, const scene *sc, const strata_render_options *options) {
    demand wants;
    base_error ignored = {0};
    return !s->budget.replan && render_continues(s, options) && fits(s->session, sc, options) &&
           s->session->raise == s->raise &&
           (s->session->scene_revision == sc->revision ||
            (demand_make(sc, &wants, &ignored) == STRATA_OK &&
             same_demand(&wants, &s->session->wants)));
}

/* Techniques prepare again only when the draws that they hold were replaced. */
static strata_result follow_edits(render_session *session, base_error *err) {
    const uint32_t opaque = upload_draws(session->upload, "draws.opaque/1").id,
                   transparent = upload_draws(session->upload, "draws.transparent/1").id,
                   objects = upload_count(session->upload).objects;
    strata_result r = upload_update(session->upload, session->scene, err);
    session->scene_revision = session->scene->revision;
    if (upload_draws(session->upload, "draws.opaque/1").id != opaque ||
        upload_draws(session->upload, "draws.transparent/1").id != transparent ||
        upload_count(session->upload).objects != objects) {
        session->changed |= STRATA_CHANGED_SCENE;
        session->prepared = 0;
    }
    return r;
}

/* A session that fits keeps its own, equal plan and follows the scene's edits. */
static strata_result refresh(render_session *session, const strata_render_options *options,
                             base_error *err) {
    strata_result r = STRATA_OK;
    if (session->scene_revision != session->scene->revision)
        r = follow_edits(session, err);
    if (r == STRATA_OK && options->bands > session->band_count)
        r = render_bands(session, options->bands, err);
    return r;
}

strata_result render_same_plan(strata *s, scene *sc, const strata_render_options *options,
                               int *same, base_error *err) {
    plan *p = NULL;
    scene_view view;
    *same = 0;
    strata_result r = render_view(s, sc, options, 0, &view, err);
    if (r == STRATA_OK)
        r = render_plan(s, sc, options, &view, &p, err);
    if (r != STRATA_OK)
        return r;
    char *key = plan_key(p, 1);
    if (!key)
        r = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "plan: out of memory");
    else
        *same = s->session && strcmp(s->session->plan_text, key) == 0;
    free(key);
    plan_free(p);
    return r;
}

/* Half of a session or of an edit is none. */
static strata_result drop_failed(strata *s, strata_result r) {
    if (r != STRATA_OK) {
        render_session_free(s->session);
        s->session = NULL;
    }
    return r;
}

strata_result render_session_keep(strata *s, const strata_render_options *options,
                                  base_error *err) {
    return drop_failed(s, refresh(s->session, options, err));
}

static void turn(render_session *session, double value) {
    plan_turn(session->plan, value);
    session->changed |= STRATA_CHANGED_SETTINGS;
    session->prepared = 0;
}

strata_result render_session_turn(render_session *session, double value, base_error *err) {
    turn(session, value);
    char *key = plan_key(session->plan, 1);
    if (!key)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "plan: out of memory");
    free(session->plan_text);
    session->plan_text = key;
    return STRATA_OK;
}

/* Whether the session runs what the plan of this key does, or may with its knob turned: so it is.
 */
static int turn_alike(render_session *session, const plan *p, const char *key) {
    if (strcmp(session->plan_text, key) == 0)
        return 1;
    if (!p->turned || p->turned != session->plan->turned)
        return 0;
    char *mine = plan_key(session->plan, 0), *theirs = plan_key(p, 0);
    const int alike = mine && theirs && strcmp(mine, theirs) == 0;
    free(mine);
    free(theirs);
    if (alike)
        turn(session, plan_turned(p));
    return alike;
}

strata_result render_session_open(strata *s, scene *sc, const strata_render_options *options,
                                  plan *p, base_error *err) {
    char *key = plan_key(p, 1), *request = request_of(options);
    strata_result r;
    if (!key || !request) {
        free(key);
        free(request);
        plan_free(p);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "plan: out of memory");
    }
    if (fits(s->session, sc, options) && turn_alike(s->session, p, key)) {
        plan_expect(s->session->plan, p);
        r = refresh(s->session, options, err);
        plan_free(p);
    } else {
        render_session_free(s->session);
        s->session = NULL;
        r = render_session_create(s, sc, options, p, &s->session, err);
    }
    if (s->session) {
        free(s->session->plan_text);
        free(s->session->request);
        s->session->plan_text = key;
        s->session->request = request;
        s->session->raise = s->raise;
    } else {
        free(key);
        free(request);
    }
    if (r == STRATA_OK)
        r = demand_make(sc, &s->session->wants, err);
    return drop_failed(s, r);
}
