/* SPDX-License-Identifier: MIT
 *
 * A scene at a time: keyframe channels into node poses, poses into world transforms, those into
 * instances, lights and cameras. Deformed vertices follow in deform.c.
 */
#include "scene/animations.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void scene_animations_free(scene_animations *a) {
    if (!a)
        return;
    for (uint32_t i = 0; i < a->node_count && a->nodes; i++) {
        free(a->nodes[i].rest_weights);
        free(a->nodes[i].weights);
    }
    for (uint32_t i = 0; i < a->channel_count; i++) {
        free(a->channels[i].times);
        free(a->channels[i].values);
    }
    for (uint32_t i = 0; i < a->skin_count && a->skins; i++) {
        free(a->skins[i].joints);
        free(a->skins[i].inverse);
    }
    free(a->nodes);
    free(a->order);
    free(a->channels);
    free(a->skins);
    free(a);
}

/* ---- channels -------------------------------------------------------------------------------- */

/* The last key at or before `time`; 0 before the first. */
static uint32_t key_before(const scene_channel *c, double time) {
    uint32_t low = 0, high = c->key_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if ((double)c->times[middle] <= time)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* Spherical interpolation along the shorter way (glTF 2.0, appendix C.3). */
static void slerp(const float *from, const float *to, double u, double out[4]) {
    double cosine = 0.0, sign = 1.0, a = 1.0 - u, b = u;
    for (int i = 0; i < 4; i++)
        cosine += (double)from[i] * (double)to[i];
    if (cosine < 0.0) {
        cosine = -cosine;
        sign = -1.0;
    }
    if (cosine < 0.9999) {
        double angle = acos(cosine), sine = sin(angle);
        a = sin((1.0 - u) * angle) / sine;
        b = sin(u * angle) / sine;
    }
    for (int i = 0; i < 4; i++)
        out[i] = a * (double)from[i] + sign * b * (double)to[i];
}

/* Component i of the value between keys k and k + 1, u in 0..1, `span` seconds apart (C.5). */
static double hermite(const scene_channel *c, uint32_t k, uint32_t i, double u, double span) {
    const float *key = c->values + (size_t)k * 3 * c->width, *next = key + 3 * (size_t)c->width;
    double v0 = (double)key[c->width + i], v1 = (double)next[c->width + i];
    double out0 = (double)key[2 * c->width + i] * span, in1 = (double)next[i] * span;
    double u2 = u * u, u3 = u2 * u;
    return (2 * u3 - 3 * u2 + 1) * v0 + (u3 - 2 * u2 + u) * out0 + (3 * u2 - 2 * u3) * v1 +
           (u3 - u2) * in1;
}

/* One component at a time; times outside the keys take the nearest one. */
static double sample(const scene_channel *c, double time, uint32_t i) {
    uint32_t k = key_before(c, time);
    size_t cubic = c->interpolation == SCENE_CUBIC;
    const float *at = c->values + (size_t)k * (cubic ? 3 : 1) * c->width + cubic * c->width;
    double start = (double)c->times[k];
    double end = k + 1 < c->key_count ? (double)c->times[k + 1] : start;
    if (c->interpolation == SCENE_STEP || time <= start || end <= start)
        return (double)at[i];
    double u = fmin((time - start) / (end - start), 1.0);
    if (cubic)
        return hermite(c, k, i, u, end - start);
    return (1.0 - u) * (double)at[i] + u * (double)at[c->width + i];
}

static void sample_rotation(const scene_channel *c, double time, double out[4]) {
    uint32_t k = key_before(c, time);
    int between = k + 1 < c->key_count && time > (double)c->times[k] &&
                  c->times[k + 1] > c->times[k] && c->interpolation == SCENE_SLOPE;
    if (between) {
        const float *at = c->values + (size_t)k * 4;
        double span = (double)c->times[k + 1] - (double)c->times[k];
        slerp(at, at + 4, fmin((time - (double)c->times[k]) / span, 1.0), out);
    } else {
        for (uint32_t i = 0; i < 4; i++)
            out[i] = sample(c, time, i);
    }
    scene_normalize_rotation(out);
}

static void apply_channel(scene_animations *a, const scene_channel *c, double time) {
    scene_node *node = &a->nodes[c->node];
    switch (c->path) {
    case SCENE_ROTATION:
        sample_rotation(c, time, node->pose.rotation);
        break;
    case SCENE_TRANSLATION:
    case SCENE_SCALE:
        for (uint32_t i = 0; i < 3; i++)
            (c->path == SCENE_SCALE ? node->pose.scale : node->pose.translation)[i] =
                sample(c, time, i);
        break;
    case SCENE_WEIGHTS:
        for (uint32_t i = 0; i < c->width; i++)
            node->weights[i] = (float)sample(c, time, i);
        break;
    }
}

/* ---- hierarchy ------------------------------------------------------------------------------- */

static strata_result update_nodes(const scene *s, scene_animations *a, base_error *err) {
    for (uint32_t i = 0; i < a->node_count; i++) {
        scene_node *node = &a->nodes[a->order[i]];
        double local[16];
        float narrow[16];
        if (node->fixed)
            memcpy(local, node->matrix, sizeof local);
        else
            scene_compose(&node->pose, local);
        if (node->parent == SCENE_NONE)
            memcpy(node->world, local, sizeof local);
        else
            scene_multiply(a->nodes[node->parent].world, local, node->world);
        if (!scene_narrow(node->world, narrow))
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: nodes[%u]: its transform to the world is not finite", s->path,
                             a->order[i]);
    }
    return STRATA_OK;
}

static strata_result move_instances(scene *s, const scene_animations *a, base_error *err) {
    for (uint32_t i = 0; i < s->instance_count; i++) {
        scene_instance *instance = &s->instances[i];
        double local[16], world[16];
        float narrow[16];
        if (instance->node == SCENE_NONE)
            continue;
        for (int k = 0; k < 16; k++)
            local[k] = (double)instance->local[k];
        scene_multiply(a->nodes[instance->node].world, local, world);
        if (!scene_narrow(world, narrow))
            return base_fail(err, STRATA_ERROR_BAD_FILE,
                             "%s: nodes[%u]: the transform of an instance is not finite", s->path,
                             instance->node);
        memcpy(instance->world, narrow, sizeof narrow);
    }
    return STRATA_OK;
}

static void move_lights_and_cameras(scene *s, const scene_animations *a) {
    for (uint32_t i = 0; i < s->light_count; i++) {
        scene_light *light = &s->lights[i];
        float frame[16];
        if (light->node == SCENE_NONE)
            continue;
        scene_rigid(a->nodes[light->node].world, frame);
        for (int k = 0; k < 3; k++) {
            light->position[k] = frame[12 + k];
            light->direction[k] = -frame[8 + k];
        }
    }
    for (uint32_t i = 0; i < s->camera_count; i++)
        if (s->cameras[i].node != SCENE_NONE)
            scene_rigid(a->nodes[s->cameras[i].node].world, s->cameras[i].world);
}

/* ---- the whole ------------------------------------------------------------------------------- */

strata_result scene_evaluate(scene *s, scene_animations *a, double time, base_error *err) {
    for (uint32_t i = 0; i < a->node_count; i++) {
        scene_node *node = &a->nodes[i];
        node->pose = node->rest;
        if (node->weight_count)
            memcpy(node->weights, node->rest_weights, node->weight_count * sizeof *node->weights);
    }
    for (uint32_t i = 0; i < a->channel_count && !isnan(time); i++)
        apply_channel(a, &a->channels[i], time);
    strata_result result = update_nodes(s, a, err);
    if (result == STRATA_OK)
        result = move_instances(s, a, err);
    if (result == STRATA_OK)
        result = scene_deform_meshes(s, a, err);
    if (result != STRATA_OK)
        return result;
    move_lights_and_cameras(s, a);
    a->time = time;
    return STRATA_OK;
}

strata_result scene_set_time(scene *s, double seconds, base_error *err) {
    if (!isfinite(seconds))
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%s: the time is not finite", s->path);
    if (!s->animations)
        return STRATA_OK;
    double before = s->animations->time;
    strata_result result = scene_evaluate(s, s->animations, seconds, err);
    if (result != STRATA_OK)
        scene_evaluate(s, s->animations, before, NULL); /* that one went well before */
    scene_bounds(s);
    s->revision++;
    return result;
}
