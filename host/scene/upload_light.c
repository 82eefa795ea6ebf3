/* SPDX-License-Identifier: MIT
 *
 * Lights: those of the scene, or a key light over the viewer's left shoulder, so that a model
 * without lights has form.
 */
#include "scene/upload_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LIGHTS 256u /* 16 KiB, what every device binds as a uniform block */

/* Towards the key light, in the eye's axes; and its illuminance in lux. */
static const double key_direction[3] = {-0.45, 0.65, 0.61};
static const float key_color[3] = {2.25f, 2.17f, 2.05f};

static upload_light from_scene(const scene_light *light) {
    upload_light out = {.position[3] = (float)light->kind,
                        .direction[3] = light->range,
                        .cone = {light->inner_cos, light->outer_cos, 0.0f, 0.0f}};
    memcpy(out.position, light->position, sizeof light->position);
    memcpy(out.direction, light->direction, sizeof light->direction);
    memcpy(out.color, light->color, sizeof light->color);
    return out;
}

static upload_light key_light(const float world_to_eye[16]) {
    upload_light out = {.position[3] = (float)SCENE_DIRECTIONAL};
    memcpy(out.color, key_color, sizeof key_color);
    double length = 0.0;
    for (int i = 0; i < 3; i++)
        length += key_direction[i] * key_direction[i];
    for (int i = 0; i < 3; i++) { /* the eye's axes are the rows of world_to_eye */
        double to_light = 0.0;
        for (int axis = 0; axis < 3; axis++)
            to_light += key_direction[axis] * (double)world_to_eye[i * 4 + axis];
        out.direction[i] = (float)(-to_light / sqrt(length));
    }
    return out;
}

static int any_lit(const upload *u) {
    uint32_t flags = 0;
    for (uint32_t i = 0; i < u->mesh_count; i++)
        flags |= u->meshes[i].used ? u->meshes[i].flags : 0u;
    return (flags & UPLOAD_NORMALS) != 0;
}

strata_result upload_lights(upload *u, const scene *s, base_error *err) {
    static const float upright[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    if (!any_lit(u) || (u->lights.id && u->key_light))
        return STRATA_OK;
    if (s->light_count > MOST_LIGHTS && !u->lights.id)
        base_log(BASE_LOG_WARNING, "%s: of %u lights the first %u shine", s->path, s->light_count,
                 MOST_LIGHTS);
    u->key_light = s->light_count == 0;
    uint32_t count = s->light_count < MOST_LIGHTS ? s->light_count : MOST_LIGHTS;
    u->light_count = count ? count : 1;
    upload_light *lights = base_calloc(u->light_count, sizeof *lights);
    if (!lights)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for its lights",
                         s->path);
    int local = 0;
    lights[0] = key_light(upright);
    for (uint32_t i = 0; i < count; i++) {
        lights[i] = from_scene(&s->lights[i]);
        local |= s->lights[i].kind != SCENE_DIRECTIONAL;
    }
    uint64_t size = u->light_count * sizeof *lights;
    strata_result result =
        u->lights.id ? gpu_buffer_write(u->g, u->lights, 0, size, lights, err)
                     : upload_buffer(u, "StrataLights", "lights", lights, size, &u->lights, err);
    free(lights);
    char count_text[16];
    snprintf(count_text, sizeof count_text, "%u", u->light_count);
    if (result == STRATA_OK)
        result = upload_define(u, "STRATA_HAS_LOCAL_LIGHTS", local, err);
    return result == STRATA_OK ? gpu_set_define(u->g, "STRATA_LIGHT_COUNT", count_text, err)
                               : result;
}

strata_result upload_set_key_light(upload *u, const scene_view *first, base_error *err) {
    if (!u->lights.id || !u->key_light)
        return STRATA_OK;
    upload_light light = key_light(first->world_to_eye);
    return gpu_buffer_write(u->g, u->lights, 0, sizeof light, &light, err);
}
