/* SPDX-License-Identifier: MIT
 *
 * Certificates: where a frame is asked how wrong it may be, the image bound/1 and the block
 * StrataLoss (shaders/strata/certificate.glsl), in which techniques account for what they drop.
 * Stands between the frame and the image.
 */
#include "render/render.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

int render_certify(const strata_render_options *options) {
    return (options->outputs & STRATA_OUTPUT_BOUND) != 0 || options->tolerance > 0;
}

static uint32_t loss_words(const plan *p) {
    return p->transmittance_channels == 3 ? 10 : 8;
}

/* Whether what folds says how wrong it may be: it names the slot bound/1. */
static int certifies(const render_session *session) {
    for (uint32_t i = 0; i < session->technique_count; ++i) {
        const strata_technique *t = session->techniques[i].technique;
        if (strcmp(t->stage, "resolve") != 0 && strcmp(t->stage, "stream") != 0)
            continue;
        for (uint32_t k = 0; k < t->slot_count; ++k)
            if (strcmp(t->slots[k]->slot, "bound/1") == 0)
                return 1;
        return 0;
    }
    return 1; /* nothing is folded */
}

static int has_negative(const float *values, size_t count, size_t stride) {
    for (size_t i = 0; values && i < count; ++i)
        for (size_t c = 0; c < 3; ++c)
            if (values[i * stride + c] < 0)
                return 1;
    return 0;
}

/* The largest radiance that leaves a transparent surface, where the scene itself guarantees one,
 * and none below 0: unlit materials under effects that cover. Textures hold at most 1. */
static float radiance(const render_session *session) {
    const scene *sc = session->scene;
    float largest = 0, colors = 1;
    for (uint32_t i = 0; i < sc->mesh_count; ++i) {
        if (has_negative(sc->meshes[i].colors, sc->meshes[i].vertex_count, 4))
            return 3.4e38f;
        for (uint32_t k = 0; sc->meshes[i].colors && k < sc->meshes[i].vertex_count; ++k)
            for (int c = 0; c < 3; ++c)
                colors = fmaxf(colors, sc->meshes[i].colors[4 * (size_t)k + (size_t)c]);
    }
    for (uint32_t i = 0; i < sc->material_count; ++i) {
        const scene_material *m = &sc->materials[i];
        const plan_effect *effect = plan_material_effect(session->plan, m);
        if (!effect)
            continue;
        if (!m->unlit || !(effect->effect->flags & STRATA_EFFECT_COVERS) ||
            has_negative(m->base_color, 1, 4))
            return 3.4e38f;
        for (int c = 0; c < 3; ++c)
            largest = fmaxf(largest, m->base_color[c]);
    }
    return largest * colors * 1.0001f;
}

strata_result render_bound_create(render_session *session, base_error *err) {
    gpu *g = session->owner->gpu;
    char words[32];
    snprintf(words, sizeof words, "%uu", loss_words(session->plan));
    strata_result r = gpu_set_define(g, "STRATA_BOUND", session->certify ? words : NULL, err);
    if (r != STRATA_OK || !session->certify)
        return r;
    snprintf(words, sizeof words, "%.9e", (double)radiance(session));
    r = gpu_set_define(g, "STRATA_RADIANCE", words, err);
    if (r != STRATA_OK)
        return r;
    const strata_image_desc bound = {.struct_size = sizeof bound,
                                     .label = "bound/1",
                                     .format = STRATA_FORMAT_RGBA32F,
                                     .width = session->width,
                                     .height = session->height};
    strata_image_desc pixels = bound;
    pixels.label = "image.bound/1";
    pixels.width /= session->side;
    pixels.height /= session->side;
    r = gpu_image_create(session->scope, &bound, &session->bound, err);
    if (r == STRATA_OK && session->samples > 1)
        r = gpu_image_create(session->scope, &pixels, &session->image_bound, err);
    if (r != STRATA_OK)
        return r;
    return gpu_set_global(g, "strata_bound",
                          &(strata_bind){.struct_size = sizeof(strata_bind),
                                         .name = "strata_bound",
                                         .image = session->bound},
                          err);
}

strata_result render_bound_prepare(render_session *session, base_error *err) {
    gpu *g = session->owner->gpu;
    if (!session->certify || !session->plan->transparent)
        return STRATA_OK;
    const uint64_t bytes = (uint64_t)session->band_width * session->band_height *
                           loss_words(session->plan) * sizeof(uint32_t);
    const uint64_t range = gpu_fact(g, "limit.storage_range");
    gpu_scope_end(session->loss_scope);
    session->loss_scope = NULL;
    if (range && bytes > range)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                         "losses take %llu bytes, a storage range has %llu",
                         (unsigned long long)bytes, (unsigned long long)range);
    session->loss_scope = gpu_scope_create(g, "host");
    if (!session->loss_scope)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "losses: out of memory");
    strata_result r = gpu_buffer_create(session->loss_scope,
                                        &(strata_buffer_desc){
                                            .struct_size = sizeof(strata_buffer_desc),
                                            .label = "losses",
                                            .size = bytes,
                                        },
                                        &session->loss, err);
    if (r != STRATA_OK)
        return r;
    return gpu_set_global(g, "StrataLoss",
                          &(strata_bind){.struct_size = sizeof(strata_bind),
                                         .name = "StrataLoss",
                                         .buffer = session->loss},
                          err);
}

void render_bound_begin(render_session *session) {
    const float unknown = certifies(session) ? 0.0f : INFINITY;
    const float value[4] = {unknown, unknown, unknown, unknown};
    const float nothing[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
    if (session->certify)
        gpu_clear_image(session->owner->gpu, "host", session->bound, value);
    if (session->image_bound.id) /* until who fills image/1 says better */
        gpu_clear_image(session->owner->gpu, "host", session->image_bound, nothing);
}

void render_bound_begin_band(render_session *session) {
    if (session->certify && session->plan->transparent)
        gpu_fill(session->owner->gpu, "host", session->loss, 0, 0, 0);
}

strata_result render_bound_read(const render_session *session, render_bound *out, base_error *err) {
    const uint32_t width = session->width / session->side, height = session->height / session->side;
    const size_t pixels = (size_t)width * height;
    const strata_image from = session->image_bound.id ? session->image_bound : session->bound;
    double sum = 0;
    image_free(&out->map);
    *out = (render_bound){.known = 1};
    strata_result r = image_create(width, height, &out->map, err);
    if (r == STRATA_OK)
        r = gpu_image_read(session->owner->gpu, from, 0, out->map.pixels,
                           pixels * 4 * sizeof(float), err);
    if (r != STRATA_OK)
        return r;
    for (size_t i = 0; i < pixels; ++i) {
        const float *p = out->map.pixels + 4 * i;
        double largest = 0;
        for (int c = 0; c < 4; ++c)
            largest = p[c] >= 0 && largest < HUGE_VAL ? fmax(largest, (double)p[c]) : HUGE_VAL;
        if (largest == HUGE_VAL) {
            out->uncertified++;
            continue;
        }
        out->max = fmax(out->max, largest);
        sum += ((double)p[0] + (double)p[1] + (double)p[2] + (double)p[3]) / 4;
    }
    out->mean = pixels > out->uncertified ? sum / (double)(pixels - out->uncertified) : 0;
    return STRATA_OK;
}

/* ---- tolerance ------------------------------------------------------------------------------- */

/* The techniques of a plan, each with those of its knobs that trade accuracy. */
static char *plan_line(const plan *p) {
    base_text text = {0};
    for (uint32_t i = 0; i < p->technique_count; ++i) {
        const plan_technique *t = &p->techniques[i];
        base_text_add(&text, "%s%s", i ? " " : "", t->technique->id);
        for (uint32_t k = 0; k < t->technique->knob_count; ++k) {
            const strata_knob *knob = t->technique->knobs[k];
            if (knob->trades_accuracy && knob->type == STRATA_KNOB_CHOICE)
                base_text_add(&text, " %s.%s=%s", t->technique->id, knob->name,
                              knob->choices[(size_t)t->values[k]]);
            else if (knob->trades_accuracy)
                base_text_add(&text, " %s.%s=%.9g", t->technique->id, knob->name, t->values[k]);
        }
    }
    base_text_add(&text, "%s", p->technique_count ? "" : "nothing");
    if (!text.failed)
        return text.data;
    base_text_free(&text);
    return NULL;
}

int render_bound_holds(const render_result *result) {
    return result->bound.uncertified == 0 && result->bound.max <= result->tolerance;
}

strata_result render_bound_note(strata *s, base_error *err) {
    const render_bound *bound = &s->result.bound;
    render_step *step = &s->result.steps[s->result.step_count];
    *step = (render_step){.plan = plan_line(s->session->plan),
                          .max = bound->max,
                          .mean = bound->mean,
                          .uncertified = bound->uncertified};
    if (!step->plan)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "tolerance: out of memory");
    s->result.step_count++;
    return STRATA_OK;
}
