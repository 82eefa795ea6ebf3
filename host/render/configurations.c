/* SPDX-License-Identifier: MIT
 *
 * Every configuration that can render a scene: variants of techniques (plan/variants.h) brought
 * together as the slots allow, of which the plan says whether they run on this scene and device.
 */
#include "plan/variants.h"
#include "render/render.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What is asked to fold. resolve, clip NULL: none; draws: the plan's own fold after it. */
typedef struct combination {
    const plan_variant *fold, *resolve, *clip, *draws;
} combination;

typedef struct search {
    strata *s;
    scene *scene;
    const strata_render_options *options;
    const scene_view *view;
    int breadth;
    json_t *found, *refused;
    plan_variants draws, clips, captures, resolves, streams;
} search;

static const char *const orders[] = {"exact", "nearest", "approximate"};

static void use_of(const combination *c, char use[256]) {
    const plan_variant *parts[] = {c->draws, c->clip, c->fold, c->resolve};
    size_t length = 0;
    use[0] = '\0';
    for (size_t i = 0; i < 4 && length < 256; ++i)
        if (parts[i])
            length += (size_t)snprintf(use + length, 256 - length, "%s%s", length ? "," : "",
                                       parts[i]->technique->id);
}

/* "ID.mode=PRESET" of a capture that does not set it: the plan would take the layout that it knows
 * to cost less, and what the other one costs would never be known. "" where there is none. */
static void lay_out(const combination *c, char setting[PLAN_VARIANT_SETTING]) {
    const modules_technique_note *fold = c->resolve ? c->fold->technique : NULL;
    setting[0] = '\0';
    for (uint32_t i = 0; fold && i < fold->knob_count; ++i) {
        const strata_knob *knob = fold->knobs[i];
        if (strcmp(knob->name, "mode") != 0 || knob->type != STRATA_KNOB_CHOICE)
            continue;
        snprintf(setting, PLAN_VARIANT_SETTING, "%s.mode=", fold->id);
        for (int k = 0; k < PLAN_VARIANT_KNOBS; ++k)
            if (strncmp(c->fold->settings[k], setting, strlen(setting)) == 0) {
                setting[0] = '\0';
                return;
            }
        const size_t length = strlen(setting);
        snprintf(setting + length, PLAN_VARIANT_SETTING - length, "%s",
                 knob->choices[(uint32_t)knob->preset]);
    }
}

static uint32_t settings_of(const combination *c, const char *layout, const char *settings[8]) {
    const plan_variant *parts[] = {c->draws, c->clip, c->fold, c->resolve};
    uint32_t count = 0;
    if (layout[0])
        settings[count++] = layout;
    for (size_t i = 0; i < 4; ++i)
        for (int k = 0; parts[i] && k < PLAN_VARIANT_KNOBS && parts[i]->settings[k][0]; ++k)
            settings[count++] = parts[i]->settings[k];
    return count;
}

/* Whether the plan runs all that was asked for. */
static int runs(const plan *p, const combination *c) {
    const plan_variant *parts[] = {c->draws, c->clip, c->fold, c->resolve};
    for (size_t i = 0; i < 4; ++i)
        if (parts[i] && !plan_find(p, parts[i]->technique->id))
            return 0;
    return 1;
}

/* What the settings promise, in words that do not depend on how deep the scene turns out to be. */
static void add_promises(json_t *object, const combination *c) {
    const plan_variant *fold = c->fold;
    const strata_promises *p = fold ? fold->technique->promises : NULL;
    const int early = (fold && fold->ends_early) || (c->resolve && c->resolve->ends_early);
    json_object_set_new(object, "order", json_string(orders[fold ? fold->order : 0]));
    json_object_set_new(object, "keeps", json_integer(fold ? (json_int_t)fold->keeps : 0));
    json_object_set_new(object, "holds", json_integer(p ? (json_int_t)p->largest_depth : 0));
    json_object_set_new(object, "payload",
                        json_string(costs_payload_name(fold ? fold->payload : 0)));
    json_object_set_new(object, "ends_early", json_boolean(early));
    json_object_set_new(
        object, "bits",
        json_boolean(fold && fold->orderly && (!c->resolve || c->resolve->orderly)));
}

static void tell(search *q, const char *use, const char *const *settings, uint32_t count,
                 const plan *p, const combination *c, const char *reason) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < count; ++i)
        json_array_append_new(list, json_string(settings[i]));
    json_t *object = json_pack("{s:s, s:o}", "use", use, "settings", list);
    if (p)
        add_promises(object, c);
    else
        json_object_set_new(object, "reason", json_string(reason));
    json_array_append_new(p ? q->found : q->refused, object);
}

static strata_result try_one(search *q, combination c, base_error *err) {
    char use[256], layout[PLAN_VARIANT_SETTING];
    const char *settings[8];
    plan *p = NULL;
    base_error why = {0};
    strata_render_options options = *q->options;
    use_of(&c, use);
    options.use = use;
    options.settings = settings;
    lay_out(&c, layout);
    options.setting_count = settings_of(&c, layout, settings);
    const strata_result r = render_plan(q->s, q->scene, &options, q->view, &p, &why);
    if (r == STRATA_ERROR_OUT_OF_HOST_MEMORY)
        return base_fail(err, r, "%s", why.text);
    if (r == STRATA_OK && runs(p, &c))
        tell(q, use, settings, options.setting_count, p, &c, NULL);
    else
        tell(q, use, settings, options.setting_count, NULL, &c,
             r == STRATA_OK ? "the scene does not call for it" : why.text);
    plan_free(p);
    return STRATA_OK;
}

/* Alone, and where nothing but how it keeps was turned behind each clip at its presets. A payload
 * is as wrong behind a clip as without. */
static strata_result try_with_clips(search *q, combination c, base_error *err) {
    strata_result r = try_one(q, c, err);
    const int crossed = c.fold->crossed && (!c.resolve || c.resolve->crossed);
    for (uint32_t i = 0; i < q->clips.count && r == STRATA_OK && crossed; ++i) {
        c.clip = &q->clips.at[i];
        if (!c.clip->settings[0][0])
            r = try_one(q, c, err);
    }
    return r;
}

/* Knobs of what draws, where it may paint over the picture, are there to look at something else. */
static int shows(const plan_variant *v) {
    return v->settings[0][0] && modules_slot(v->technique, "color/1", 0);
}

static strata_result try_all(search *q, base_error *err) {
    strata_result r = STRATA_OK;
    for (uint32_t i = 0; i < q->draws.count && r == STRATA_OK; ++i)
        if (!shows(&q->draws.at[i]))
            r = try_one(q, (combination){.draws = &q->draws.at[i]}, err);
    for (uint32_t i = 0; i < q->captures.count; ++i)
        for (uint32_t k = 0; k < q->resolves.count && r == STRATA_OK; ++k) {
            const combination c = {.fold = &q->captures.at[i], .resolve = &q->resolves.at[k]};
            if (plan_variants_meet(c.fold, c.resolve, q->breadth))
                r = try_with_clips(q, c, err);
        }
    for (uint32_t i = 0; i < q->streams.count && r == STRATA_OK; ++i)
        r = try_with_clips(q, (combination){.fold = &q->streams.at[i]}, err);
    return r;
}

static strata_result collect(search *q, base_error *err) {
    plan *p = NULL;
    strata_result r = render_plan(q->s, q->scene, q->options, q->view, &p, err);
    if (r != STRATA_OK)
        return r;
    const double largest = ceil(p->stats.largest_depth);
    const uint32_t depth = largest < 1 ? 1 : largest > 65536 ? 65536 : (uint32_t)largest;
    const struct {
        const char *stage;
        plan_variants *out;
    } stages[] = {{"draws", &q->draws},
                  {"clip", &q->clips},
                  {"capture", &q->captures},
                  {"resolve", &q->resolves},
                  {"stream", &q->streams}};
    for (size_t i = 0; i < BASE_COUNT(stages) && r == STRATA_OK; ++i)
        r = plan_variants_collect(q->s->modules, stages[i].stage, depth, q->breadth, stages[i].out,
                                  err);
    plan_free(p);
    return r;
}

strata_result render_configurations(strata *s, scene *sc, const strata_render_options *options,
                                    const scene_view *view, int all, json_t **out,
                                    base_error *err) {
    search q = {.s = s,
                .scene = sc,
                .options = options,
                .view = view,
                .breadth = all ? PLAN_BREADTH_LADDER_ALL : PLAN_BREADTH_LADDER,
                .found = json_array(),
                .refused = json_array()};
    strata_result r = collect(&q, err);
    if (r == STRATA_OK)
        r = try_all(&q, err);
    *out = json_pack("{s:o, s:o}", "configurations", q.found, "refused", q.refused);
    free(q.draws.at);
    free(q.clips.at);
    free(q.captures.at);
    free(q.resolves.at);
    free(q.streams.at);
    return r;
}
