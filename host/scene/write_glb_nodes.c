/* SPDX-License-Identifier: MIT
 *
 * What stands where in a GLB file: instances, as nodes or, where a mesh repeats, as rows of
 * EXT_mesh_gpu_instancing; cameras; lights. The order of instances is kept, since it numbers the
 * primitives.
 */
#include "scene/write_glb.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct placement {
    float translation[3], rotation[4], scale[3];
} placement;

/* The unit quaternion (x, y, z, w) of a rotation given by its columns. */
static void to_quaternion(double r[3][3], double q[4]) {
    double trace = r[0][0] + r[1][1] + r[2][2];
    if (trace > 0) {
        double s = 2 * sqrt(trace + 1);
        q[0] = (r[1][2] - r[2][1]) / s;
        q[1] = (r[2][0] - r[0][2]) / s;
        q[2] = (r[0][1] - r[1][0]) / s;
        q[3] = s / 4;
        return;
    }
    int i = r[1][1] > r[0][0] ? 1 : 0;
    i = r[2][2] > r[i][i] ? 2 : i;
    int j = (i + 1) % 3, k = (i + 2) % 3;
    double s = 2 * sqrt(1 + r[i][i] - r[j][j] - r[k][k]);
    q[i] = s / 4;
    q[j] = (r[i][j] + r[j][i]) / s;
    q[k] = (r[i][k] + r[k][i]) / s;
    q[3] = (r[j][k] - r[k][j]) / s;
}

/* The columns of the rotation that q stands for. */
static void from_quaternion(const float f[4], double r[3][3]) {
    double q[4] = {(double)f[0], (double)f[1], (double)f[2], (double)f[3]};
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        r[i][i] = 1 - 2 * (q[j] * q[j] + q[k] * q[k]);
        r[i][j] = 2 * (q[i] * q[j] + q[k] * q[3]);
        r[i][k] = 2 * (q[i] * q[k] - q[j] * q[3]);
    }
}

/* Translation, rotation and scale of an instance; 0 when they do not make its matrix (shear). */
static int decompose(const float m[16], placement *out) {
    double columns[3][3], lengths[3], q[4];
    for (int c = 0; c < 3; c++) {
        double square = 0;
        for (int i = 0; i < 3; i++) {
            columns[c][i] = (double)m[c * 4 + i];
            square += columns[c][i] * columns[c][i];
        }
        lengths[c] = sqrt(square);
        if (!(lengths[c] > 0))
            return 0;
    }
    double determinant =
        columns[0][0] * (columns[1][1] * columns[2][2] - columns[1][2] * columns[2][1]) -
        columns[0][1] * (columns[1][0] * columns[2][2] - columns[1][2] * columns[2][0]) +
        columns[0][2] * (columns[1][0] * columns[2][1] - columns[1][1] * columns[2][0]);
    if (determinant < 0)
        lengths[0] = -lengths[0];
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 3; i++)
            columns[c][i] /= lengths[c];
    to_quaternion(columns, q);
    for (int i = 0; i < 4; i++)
        out->rotation[i] = (float)q[i];
    from_quaternion(out->rotation, columns);
    for (int c = 0; c < 3; c++) {
        out->translation[c] = m[12 + c];
        out->scale[c] = (float)lengths[c];
        for (int i = 0; i < 3; i++)
            if (!(fabs(columns[c][i] * lengths[c] - (double)m[c * 4 + i]) <=
                  1e-6 * fabs(lengths[c])))
                return 0;
    }
    return 1;
}

static int is_identity(const float m[16]) {
    for (int i = 0; i < 16; i++)
        if (m[i] < (i % 5 == 0) || m[i] > (i % 5 == 0))
            return 0;
    return 1;
}

static void write_single(glb_writer *w, const scene_instance *instance) {
    base_text *text = glb_begin(&w->nodes);
    base_text_add(text, "\"mesh\":%u", w->mesh_number[instance->mesh]);
    if (!is_identity(instance->world))
        glb_numbers(text, "matrix", instance->world, 16);
    base_text_add(text, "}");
}

/* Instances first .. first + count - 1 of one mesh, all of which decompose. Rotations are left out
 * when there are none. */
static void write_run(glb_writer *w, uint32_t first, uint32_t count) {
    float *translation = base_calloc(count, 3 * sizeof(float));
    float *rotation = base_calloc(count, 4 * sizeof(float));
    float *scale = base_calloc(count, 3 * sizeof(float));
    int turned = 0;
    if (!translation || !rotation || !scale) {
        free(translation);
        free(rotation);
        free(scale);
        w->failed = 1;
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        placement p;
        decompose(w->s->instances[first + i].world, &p);
        memcpy(translation + (size_t)i * 3, p.translation, sizeof p.translation);
        memcpy(rotation + (size_t)i * 4, p.rotation, sizeof p.rotation);
        memcpy(scale + (size_t)i * 3, p.scale, sizeof p.scale);
        turned |= p.rotation[3] < 1;
    }
    base_text *text = glb_begin(&w->nodes);
    base_text_add(text,
                  "\"mesh\":%u,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":"
                  "{\"TRANSLATION\":%u,\"SCALE\":%u",
                  w->mesh_number[w->s->instances[first].mesh],
                  glb_floats(w, translation, translation, count, 3),
                  glb_floats(w, scale, scale, count, 3));
    if (turned)
        base_text_add(text, ",\"ROTATION\":%u", glb_floats(w, rotation, rotation, count, 4));
    else
        free(rotation);
    base_text_add(text, "}}}}");
    w->extensions |= GLB_INSTANCING;
}

void glb_write_instances(glb_writer *w) {
    const scene *s = w->s;
    for (uint32_t i = 0, next; i < s->instance_count; i = next) {
        const scene_instance *instance = &s->instances[i];
        placement ignored;
        next = i + 1;
        if (!instance->visible || w->mesh_number[instance->mesh] == SCENE_NONE)
            continue;
        if (!decompose(instance->world, &ignored)) {
            write_single(w, instance);
            continue;
        }
        while (next < s->instance_count && s->instances[next].visible &&
               s->instances[next].mesh == instance->mesh &&
               decompose(s->instances[next].world, &ignored))
            next++;
        if (next - i > 1)
            write_run(w, i, next - i);
        else
            write_single(w, instance);
    }
}

/* ---- cameras and lights --------------------------------------------------------------------- */

static void member(base_text *text, const char *key, float value) {
    base_text_add(text, ",\"%s\":", key);
    glb_number(text, (double)value);
}

void glb_write_cameras(glb_writer *w) {
    for (uint32_t i = 0; i < w->s->camera_count; i++) {
        const scene_camera *camera = &w->s->cameras[i];
        base_text *text = glb_begin(&w->cameras);
        base_text_add(text, "\"name\":");
        glb_string(text, camera->name);
        if (camera->projection == SCENE_ORTHOGRAPHIC) {
            base_text_add(text, ",\"type\":\"orthographic\",\"orthographic\":{\"znear\":");
            glb_number(text, (double)camera->znear);
            member(text, "zfar", camera->zfar);
            member(text, "xmag", camera->xmag);
            member(text, "ymag", camera->ymag);
        } else {
            base_text_add(text, ",\"type\":\"perspective\",\"perspective\":{\"yfov\":");
            glb_number(text, (double)camera->yfov);
            member(text, "znear", camera->znear);
            if (camera->zfar > 0)
                member(text, "zfar", camera->zfar);
            if (camera->aspect > 0)
                member(text, "aspectRatio", camera->aspect);
        }
        base_text_add(text, "}}");
        text = glb_begin(&w->nodes);
        base_text_add(text, "\"camera\":%u,\"name\":", i);
        glb_string(text, camera->name);
        if (!is_identity(camera->world))
            glb_numbers(text, "matrix", camera->world, 16);
        base_text_add(text, "}");
    }
}

/* A rigid matrix whose -z axis is `direction`. */
static void aim(const scene_light *light, float m[16]) {
    double z[3], x[3], length = 0;
    for (int i = 0; i < 3; i++)
        z[i] = -(double)light->direction[i];
    int up = fabs(z[1]) < 0.9 ? 1 : 0; /* the axis that x is made from is not near z */
    x[0] = up == 1 ? z[2] : 0;
    x[1] = up == 1 ? 0 : -z[2];
    x[2] = up == 1 ? -z[0] : z[1];
    for (int i = 0; i < 3; i++)
        length += x[i] * x[i];
    length = sqrt(length);
    memset(m, 0, 16 * sizeof *m);
    m[15] = 1;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        m[i] = (float)(x[i] / length);
        m[4 + i] = (float)((z[j] * x[k] - z[k] * x[j]) / length);
        m[8 + i] = (float)z[i];
        m[12 + i] = light->position[i];
    }
}

void glb_write_lights(glb_writer *w) {
    static const char *const kinds[] = {"directional", "point", "spot"};
    for (uint32_t i = 0; i < w->s->light_count; i++) {
        const scene_light *light = &w->s->lights[i];
        float world[16], color[3];
        float intensity = fmaxf(light->color[0], fmaxf(light->color[1], light->color[2]));
        for (int c = 0; c < 3; c++)
            color[c] = intensity > 0 ? light->color[c] / intensity : 1;
        base_text *text = glb_begin(&w->lights);
        base_text_add(text, "\"type\":\"%s\",\"name\":", kinds[light->kind]);
        glb_string(text, light->name);
        glb_numbers(text, "color", color, 3);
        member(text, "intensity", fmaxf(intensity, 0));
        if (light->range > 0)
            member(text, "range", light->range);
        if (light->kind == SCENE_SPOT) {
            base_text_add(text, ",\"spot\":{\"innerConeAngle\":");
            glb_number(text, acos(fmin((double)light->inner_cos, 1)));
            base_text_add(text, ",\"outerConeAngle\":");
            glb_number(text, acos(fmin((double)light->outer_cos, 1)));
            base_text_add(text, "}");
        }
        base_text_add(text, "}");
        aim(light, world);
        text = glb_begin(&w->nodes);
        base_text_add(text, "\"extensions\":{\"KHR_lights_punctual\":{\"light\":%u}}", i);
        glb_numbers(text, "matrix", world, 16);
        base_text_add(text, "}");
        w->extensions |= GLB_LIGHTS;
    }
}
