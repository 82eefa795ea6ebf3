/* SPDX-License-Identifier: MIT
 *
 * strata/host.h: opening, scenes, and the texts that cross as JSON. Every entry keeps the line of
 * its failure with the instance. Rendering itself is in render.c.
 */
#include "render/render.h"

#include <stdlib.h>
#include <string.h>

static _Thread_local base_error open_error;

/* ---- instances ------------------------------------------------------------------------------- */

static char *copy_text(const char *text, int *failed) {
    if (!text)
        return NULL;
    char *copy = base_strdup(text);
    *failed |= copy == NULL;
    return copy;
}

/* The user's cache: STRATA_CACHE_DIR, else XDG_CACHE_HOME/strata, else HOME/.cache/strata, else
 * none. */
static char *cache_folder(const char *given, int *failed) {
    const char *set = getenv("STRATA_CACHE_DIR"), *xdg = getenv("XDG_CACHE_HOME"),
               *home = getenv("HOME");
    char *folder = NULL;
    if (!given && set)
        given = set;
    if (given)
        return given[0] ? copy_text(given, failed) : NULL;
    if (xdg && xdg[0])
        folder = base_format("%s/strata", xdg);
    else if (home && home[0])
        folder = base_format("%s/.cache/strata", home);
    else
        return NULL;
    *failed |= folder == NULL;
    return folder;
}

strata_result strata_open(const strata_open_options *given, strata **out) {
    strata_open_options options = {.struct_size = sizeof options};
    const char *check = getenv("STRATA_CHECK");
    int failed = 0;
    open_error = (base_error){0};
    if (!out)
        return base_fail(&open_error, STRATA_ERROR_INVALID_ARGUMENT, "strata_open: out is NULL");
    *out = NULL;
    if (given && !base_take(&options, sizeof options, given))
        return base_fail(&open_error, STRATA_ERROR_INVALID_ARGUMENT,
                         "strata_open: struct_size is not set, or options are of a later version");
    strata *s = base_calloc(1, sizeof *s);
    if (!s)
        return base_fail(&open_error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    s->check = options.check || (check && strcmp(check, "1") == 0);
    s->memory = options.memory;
    s->backend = copy_text(options.backend, &failed);
    s->device = copy_text(options.device, &failed);
    s->module_path = copy_text(options.module_path, &failed);
    s->inject = copy_text(options.inject, &failed);
    s->cache_dir = cache_folder(options.cache_dir, &failed);
    if (failed) {
        strata_close(s);
        return base_fail(&open_error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    }
    *out = s;
    return STRATA_OK;
}

void strata_close(strata *s) {
    if (!s)
        return;
    while (s->scenes)
        strata_scene_close(s->scenes);
    render_session_free(s->session);
    gpu_close(s->gpu);
    costs_free(&s->costs);
    render_budget_end(s);
    modules_free(s->modules);
    render_result_clear(&s->result);
    for (uint32_t i = 0; i < s->exclusion_count; ++i) {
        free((void *)(uintptr_t)s->exclusions[i].technique);
        free((void *)(uintptr_t)s->exclusions[i].reason);
    }
    free(s->exclusions);
    free(s->backend);
    free(s->device);
    free(s->module_path);
    free(s->inject);
    free(s->cache_dir);
    free(s);
}

const char *strata_error(const strata *s) {
    return s ? s->error.text : open_error.text;
}

/* ---- scenes ---------------------------------------------------------------------------------- */

static strata_result keep_scene(strata *s, scene *loaded, strata_scene **out) {
    strata_scene *sc = base_calloc(1, sizeof *sc);
    if (!sc) {
        scene_free(loaded);
        return base_fail(&s->error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "scene: out of memory");
    }
    *sc = (strata_scene){.owner = s, .scene = loaded, .next = s->scenes};
    s->scenes = sc;
    *out = sc;
    return STRATA_OK;
}

strata_result strata_scene_generate(strata *s, const char *name, const char *const *knobs,
                                    uint32_t count, strata_scene **out) {
    scene *loaded = NULL;
    s->error = (base_error){0};
    *out = NULL;
    strata_result r = scene_generate(name, knobs, count, &loaded, &s->error);
    return r == STRATA_OK ? keep_scene(s, loaded, out) : r;
}

/* "NAME?K=V&K=V", cut apart in place. */
static strata_result generate_from(strata *s, char *spec, strata_scene **out) {
    const char *knobs[64];
    uint32_t count = 0;
    char *next = strchr(spec, '?');
    while (next) {
        *next++ = '\0';
        if (count == BASE_COUNT(knobs))
            return base_fail(&s->error, STRATA_ERROR_INVALID_ARGUMENT, "%s: too many knobs", spec);
        knobs[count++] = next;
        next = strchr(next, '&');
    }
    return strata_scene_generate(s, spec, knobs, count, out);
}

strata_result strata_scene_load(strata *s, const char *path, strata_scene **out) {
    scene *loaded = NULL;
    s->error = (base_error){0};
    *out = NULL;
    const int hard = strncmp(path, "hard:", 5) == 0;
    if (hard || strncmp(path, "scene:", 6) == 0) {
        char *spec = base_strdup(hard ? path : path + 6);
        if (!spec)
            return base_fail(&s->error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "scene: out of memory");
        strata_result r = generate_from(s, spec, out);
        free(spec);
        return r;
    }
    strata_result r = scene_load(path, &loaded, &s->error);
    return r == STRATA_OK ? keep_scene(s, loaded, out) : r;
}

strata_result strata_scene_save(strata_scene *sc, const char *path) {
    sc->owner->error = (base_error){0};
    return scene_write_glb(sc->scene, path, &sc->owner->error);
}

void strata_scene_close(strata_scene *sc) {
    if (!sc)
        return;
    strata *s = sc->owner;
    if (s->session && s->session->scene == sc->scene) {
        render_session_free(s->session);
        s->session = NULL;
    }
    if (s->start.scene == sc->scene)
        s->start = (render_start){0};
    for (strata_scene **at = &s->scenes; *at; at = &(*at)->next)
        if (*at == sc) {
            *at = sc->next;
            break;
        }
    scene_free(sc->scene);
    free(sc);
}

strata_result strata_scene_set_time(strata_scene *sc, double seconds) {
    sc->owner->error = (base_error){0};
    return scene_set_time(sc->scene, seconds, &sc->owner->error);
}

strata_result strata_scene_set_transform(strata_scene *sc, uint32_t instance,
                                         const float world[16]) {
    sc->owner->error = (base_error){0};
    return scene_set_transform(sc->scene, instance, world, &sc->owner->error);
}

strata_result strata_scene_set_visible(strata_scene *sc, uint32_t instance, uint32_t visible) {
    sc->owner->error = (base_error){0};
    return scene_set_visible(sc->scene, instance, visible, &sc->owner->error);
}

strata_result strata_scene_camera(strata_scene *sc, const char *camera, uint32_t width,
                                  uint32_t height, strata_camera_pose *out) {
    strata_camera_pose pose;
    base_error *err = &sc->owner->error;
    *err = (base_error){0};
    if (!out || out->struct_size < sizeof out->struct_size)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "pose: struct_size is not set");
    strata_result r = scene_pose(sc->scene, camera, width, height, &pose, err);
    if (r == STRATA_OK) { /* of the caller's version, which keeps its size */
        pose.struct_size = out->struct_size;
        memcpy(out, &pose, out->struct_size < sizeof pose ? out->struct_size : sizeof pose);
    }
    return r;
}

/* ---- texts ----------------------------------------------------------------------------------- */

strata_result render_write_json(strata *s, json_t *object, strata_write_fn write, void *user) {
    char *text = object ? json_dumps(object, JSON_INDENT(2) | JSON_REAL_PRECISION(9)) : NULL;
    strata_result r = STRATA_ERROR_OUT_OF_HOST_MEMORY;
    if (text)
        r = write(user, text, strlen(text));
    if (r == STRATA_OK)
        r = write(user, "\n", 1);
    if (r != STRATA_OK)
        base_fail(&s->error, r, text ? "the receiver of the text stopped" : "out of memory");
    free(text);
    json_decref(object);
    return r;
}

strata_result strata_account(strata *s, strata_write_fn write, void *user) {
    s->error = (base_error){0};
    if (!s->result.valid || !s->session)
        return base_fail(&s->error, STRATA_ERROR_INVALID_STATE, "%s",
                         s->result.valid ? "the scene that was rendered is closed"
                                         : "nothing was rendered yet");
    return render_write_json(s, render_account_json(s), write, user);
}

static void add_device(void *user, const gpu_device_info *info, uint32_t index) {
    json_array_append_new(user,
                          json_pack("{s:i, s:s, s:s, s:s}", "index", (int)index, "backend",
                                    info->backend, "name", info->name, "driver", info->driver));
}

static json_t *knob_value(const scene_generator_knob *knob, double value) {
    return knob->whole ? json_integer((json_int_t)value) : json_real(value);
}

static json_t *scene_knob_json(const scene_generator_knob *knob) {
    json_t *object = json_pack("{s:s, s:s, s:o, s:o, s:o, s:b}", "name", knob->name, "title",
                               knob->title, "default", knob_value(knob, knob->preset), "minimum",
                               knob_value(knob, knob->minimum), "maximum",
                               knob_value(knob, knob->maximum), "whole", knob->whole);
    if (object && knob->choices) {
        json_t *choices = json_array();
        for (const char *const *choice = knob->choices; *choice; ++choice)
            json_array_append_new(choices, json_string(*choice));
        json_object_set_new(object, "choices", choices);
    }
    return object;
}

static json_t *scenes_json(void) {
    json_t *scenes = json_array();
    uint32_t count = 0;
    const scene_generator *generators = scene_generators(&count);
    for (uint32_t i = 0; i < count; ++i) {
        json_t *knobs = json_array();
        for (uint32_t k = 0; k < generators[i].knob_count; ++k)
            json_array_append_new(knobs, scene_knob_json(&generators[i].knobs[k]));
        json_array_append_new(scenes, json_pack("{s:s, s:s, s:o}", "name", generators[i].name,
                                                "title", generators[i].title, "knobs", knobs));
    }
    for (uint32_t i = 0; scene_hard_cases(i); ++i) {
        const scene_hard_case *hard = scene_hard_cases(i);
        json_array_append_new(scenes, json_pack("{s:s, s:s, s:[i, i], s:[]}", "name", hard->name,
                                                "title", hard->title, "size", (int)hard->width,
                                                (int)hard->height, "knobs"));
    }
    return scenes;
}

strata_result strata_list(strata *s, strata_write_fn write, void *user) {
    char version[32];
    s->error = (base_error){0};
    strata_result r = render_modules(s, &s->error);
    if (r != STRATA_OK)
        return r;
    const uint32_t count = modules_count(s->modules);
    const modules_note **notes = base_calloc((size_t)count + 1, sizeof *notes);
    json_t *rejected = json_array(), *devices = json_array();
    if (!notes) {
        json_decref(rejected);
        json_decref(devices);
        return base_fail(&s->error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "list: out of memory");
    }
    for (uint32_t i = 0; i < count; ++i)
        notes[i] = modules_note_at(s->modules, i);
    for (uint32_t i = 0; i < modules_refused_count(s->modules); ++i) {
        const modules_refusal *refusal = modules_refused_at(s->modules, i);
        json_array_append_new(
            rejected, json_pack("{s:s, s:s}", "path", refusal->path, "reason", refusal->reason));
    }
    gpu_enumerate(add_device, devices);
    snprintf(version, sizeof version, "%u.%u", STRATA_VERSION_MAJOR(STRATA_ABI_VERSION),
             STRATA_VERSION_MINOR(STRATA_ABI_VERSION));
    json_t *object = json_pack("{s:s, s:s, s:o, s:o, s:o, s:o}", "release", STRATA_RELEASE,
                               "version", version, "modules", plan_json_modules(notes, count),
                               "rejected", rejected, "devices", devices, "scenes", scenes_json());
    free(notes);
    return render_write_json(s, object, write, user);
}

/* ---- plan ------------------------------------------------------------------------------------ */

strata_result strata_plan(strata *s, strata_scene *sc, const strata_render_options *given,
                          strata_write_fn write, void *user) {
    strata_render_options options;
    scene_view view;
    plan *p = NULL;
    base_error no_device = {0};
    s->error = (base_error){0};
    strata_result r = render_own(s, sc, &s->error);
    if (r == STRATA_OK)
        r = render_options(given, &options, &s->error);
    if (r == STRATA_OK)
        render_device(s, &no_device); /* a plan without a device says so */
    if (r == STRATA_OK)
        r = render_view(s, sc->scene, &options, 0, &view, &s->error);
    if (r == STRATA_OK)
        r = render_plan(s, sc->scene, &options, &view, &p, &s->error);
    if (r != STRATA_OK)
        return r;
    json_t *object = plan_json(p);
    if (object) {
        json_object_set_new(object, "scene", json_string(sc->scene->path ? sc->scene->path : ""));
        json_object_set_new(object, "size",
                            json_pack("[i,i]", (int)options.width, (int)options.height));
        json_object_set_new(object, "samples", json_integer(options.samples));
        json_object_set_new(object, "filter",
                            render_filter_json(options.samples, render_filter(&options)));
        json_object_set_new(object, "device", render_device_json(s));
        json_object_set_new(object, "warnings", render_warnings_json(s, sc->scene, p));
    }
    plan_free(p);
    return render_write_json(s, object, write, user);
}

strata_result strata_configurations(strata *s, strata_scene *sc, const strata_render_options *given,
                                    uint32_t all, strata_write_fn write, void *user) {
    strata_render_options options;
    scene_view view;
    json_t *object = NULL;
    s->error = (base_error){0};
    strata_result r = render_own(s, sc, &s->error);
    if (r == STRATA_OK)
        r = render_options(given, &options, &s->error);
    if (r == STRATA_OK &&
        (options.use || options.setting_count || options.tolerance > 0 || options.budget > 0))
        r = base_fail(&s->error, STRATA_ERROR_INVALID_ARGUMENT,
                      "configurations: use, settings, tolerance and budget are what it looks for");
    if (r == STRATA_OK)
        r = render_device(s, &s->error);
    if (r == STRATA_OK)
        r = render_view(s, sc->scene, &options, 0, &view, &s->error);
    if (r == STRATA_OK)
        r = render_configurations(s, sc->scene, &options, &view, all != 0, &object, &s->error);
    if (r == STRATA_OK)
        return render_write_json(s, object, write, user);
    json_decref(object);
    return r;
}
