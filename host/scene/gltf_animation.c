/* SPDX-License-Identifier: MIT
 *
 * glTF animations and skins as the scene's channels and joints. Every animation of a file is kept;
 * they are applied one after the other, so that a later one wins where two move the same thing.
 */
#include "scene/gltf.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static strata_result fail_channel(gltf_loader *l, const char *place, const char *text) {
    return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: %s", l->s->path, place, text);
}

static strata_result check_channel(gltf_loader *l, const char *place, const scene_channel *c,
                                   uint64_t values) {
    if (c->key_count == 0)
        return fail_channel(l, place, "has no keys");
    for (uint32_t i = 0; i < c->key_count; i++)
        if (!isfinite(c->times[i]) || (i > 0 && c->times[i] < c->times[i - 1]))
            return fail_channel(l, place, "its times are not finite and ascending");
    for (uint64_t i = 0; i < values; i++)
        if (!isfinite(c->values[i]))
            return fail_channel(l, place, "its values are not all finite");
    return STRATA_OK;
}

/* Reads the keys of `from` into c, whose path, width and interpolation stand. */
static strata_result read_keys(gltf_loader *l, const gltf_channel *from, const char *place,
                               scene_channel *c) {
    uint32_t width = c->path == SCENE_WEIGHTS ? 1 : c->width, elements;
    strata_result result = gltf_read_floats(l, from->input, 1, place, &c->times, &c->key_count);
    if (result == STRATA_OK)
        result = gltf_read_floats(l, from->output, width, place, &c->values, &elements);
    if (result != STRATA_OK)
        return result;
    uint64_t values = (uint64_t)c->key_count * c->width * (c->interpolation == SCENE_CUBIC ? 3 : 1);
    if (values != (uint64_t)elements * width)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: accessors[%u] holds %llu numbers, the keys need %llu", l->s->path,
                         place, from->output, (unsigned long long)elements * width,
                         (unsigned long long)values);
    return check_channel(l, place, c, values);
}

static strata_result read_channel(gltf_loader *l, const gltf_channel *from) {
    static const scene_channel_path paths[] = {SCENE_TRANSLATION, SCENE_ROTATION, SCENE_SCALE,
                                               SCENE_WEIGHTS};
    static const scene_interpolation ways[] = {SCENE_SLOPE, SCENE_STEP, SCENE_CUBIC};
    scene_animations *a = l->animations;
    const scene_node *node = &a->nodes[from->node];
    char place[80];
    snprintf(place, sizeof place, "animations[%u].channels[%u]", from->animation, from->channel);
    if (node->fixed && from->path != GLTF_WEIGHTS) {
        scene_warn(l->s, "%s: %s: nodes[%u] has a matrix: not moved", l->s->path, place,
                   from->node);
        return STRATA_OK;
    }
    if (node->weight_count == 0 && from->path == GLTF_WEIGHTS) {
        scene_warn(l->s, "%s: %s: nodes[%u] has no morph targets: ignored", l->s->path, place,
                   from->node);
        return STRATA_OK;
    }
    scene_channel *c = &a->channels[a->channel_count++];
    *c = (scene_channel){
        .node = from->node,
        .path = paths[from->path],
        .interpolation = ways[from->interpolation],
        .width = from->path == GLTF_WEIGHTS    ? node->weight_count
                 : from->path == GLTF_ROTATION ? 4
                                               : 3,
    };
    return read_keys(l, from, place, c);
}

static strata_result read_skin(gltf_loader *l, uint32_t index, scene_skin *out) {
    const gltf_skin *from = &l->file.skins[index];
    char place[64];
    uint32_t count;
    snprintf(place, sizeof place, "skins[%u].inverseBindMatrices", index);
    strata_result result = gltf_charge(l, place, from->joint_count, sizeof *out->joints);
    if (result != STRATA_OK)
        return result;
    out->joints = base_calloc(from->joint_count, sizeof *out->joints);
    if (!out->joints)
        return gltf_no_memory(l);
    out->joint_count = from->joint_count;
    for (uint32_t i = 0; i < from->joint_count; i++)
        out->joints[i] = (uint32_t)from->joints[i];
    if (from->inverse_bind == SCENE_NONE)
        return STRATA_OK;
    result = gltf_read_floats(l, from->inverse_bind, 16, place, &out->inverse, &count);
    if (result == STRATA_OK && count < from->joint_count)
        return base_fail(l->err, STRATA_ERROR_BAD_FILE,
                         "%s: %s: accessors[%u] has %u for %u joints", l->s->path, place,
                         from->inverse_bind, count, from->joint_count);
    for (size_t i = 0; result == STRATA_OK && i < (size_t)count * 16; i++)
        if (!isfinite(out->inverse[i]))
            return base_fail(l->err, STRATA_ERROR_BAD_FILE, "%s: %s: [%zu] is not finite",
                             l->s->path, place, i / 16);
    return result;
}

strata_result gltf_read_animations(gltf_loader *l) {
    scene_animations *a = l->animations;
    strata_result result = STRATA_OK;
    a->channels = base_calloc(l->file.channel_count, sizeof *a->channels);
    a->skins = base_calloc(l->file.skin_count, sizeof *a->skins);
    if (!a->channels || !a->skins)
        return gltf_no_memory(l);
    a->skin_count = l->file.skin_count;
    for (uint32_t i = 0; i < l->file.skin_count && result == STRATA_OK; i++)
        result = read_skin(l, i, &a->skins[i]);
    for (uint32_t i = 0; i < l->file.channel_count && result == STRATA_OK; i++)
        result = read_channel(l, &l->file.channels[i]);
    return result;
}
