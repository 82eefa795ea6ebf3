/* SPDX-License-Identifier: MIT
 *
 * A sweep's results.json: begun from what was asked for, and saved whole or not at all.
 */
#define _POSIX_C_SOURCE 200809L
#include "cli/sweep.h"

#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

/* ---- beginning ------------------------------------------------------------------------------- */

static json_t *text_or_null(const char *text) {
    return text ? json_string(text) : json_null();
}

/* "model name" of the first processor. */
static json_t *processor(void) {
    char line[256], *colon;
    json_t *name = NULL;
    FILE *file = fopen("/proc/cpuinfo", "r");
    while (file && !name && fgets(line, sizeof line, file))
        if (strncmp(line, "model name", 10) == 0 && (colon = strchr(line, ':')) != NULL) {
            colon[strcspn(colon, "\n")] = '\0';
            name = json_string(colon + 1 + strspn(colon + 1, " "));
        }
    if (file)
        fclose(file);
    return name ? name : json_string("unknown");
}

static json_t *machine(void) {
    struct utsname system = {0};
    uname(&system);
    return json_pack("{s:o, s:I, s:o}", "processor", processor(), "cores",
                     (json_int_t)sysconf(_SC_NPROCESSORS_ONLN), "system",
                     json_sprintf("%s %s %s", system.sysname, system.release, system.machine));
}

static json_t *places(const sweep_options *o) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < o->place_count; i++)
        json_array_append_new(list, json_pack("{s:s, s:[i,i]}", "scene", o->places[i].scene, "size",
                                              (int)o->places[i].width, (int)o->places[i].height));
    return list;
}

/* What was asked for: equal for all parts of one sweep. */
static json_t *request(const sweep_options *o) {
    const strata_render_options *r = &o->common.render;
    json_t *only = json_array();
    for (uint32_t i = 0; i < o->only_count; i++)
        json_array_append_new(only, json_string(o->only[i]));
    return json_pack("{s:o, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:I, s:i, s:b, s:o}", "cases",
                     places(o), "samples", (int)(r->samples ? r->samples : 1), "filter",
                     text_or_null(r->filter), "camera", text_or_null(r->camera), "time",
                     o->common.has_time ? json_real(o->common.time) : json_null(), "effects",
                     text_or_null(r->effects), "backend", text_or_null(o->common.open.backend),
                     "device", text_or_null(o->common.open.device), "memory",
                     (json_int_t)o->common.open.memory, "frames", (int)o->frames, "all", o->all,
                     "only", only);
}

json_t *sweep_begin(const sweep_options *o) {
    return json_pack("{s:s, s:s, s:o, s:n, s:o, s:b, s:i, s:[], s:[]}", "format", SWEEP_FORMAT,
                     "strata", strata_release(), "machine", machine(), "device", "request",
                     request(o), "complete", 0, "failed", 0, "violations", "cases");
}

/* ---- a configuration ------------------------------------------------------------------------- */

/* Its settings of one technique, without what names it: "k=8 payload=half". */
static void add_settings(cli_text *name, const char *id, const json_t *settings) {
    const size_t length = strlen(id);
    size_t i;
    const json_t *setting;
    json_array_foreach(settings, i, setting) {
        const char *text = json_string_value(setting);
        if (strncmp(text, id, length) == 0 && text[length] == '.') {
            cli_text_write(name, " ", 1);
            cli_text_write(name, text + length + 1, strlen(text + length + 1));
        }
    }
}

/* "occupancy + kplus k=8 + ppc". */
static json_t *name_of(const json_t *listed) {
    const char *use = cli_get(listed, "use");
    const json_t *settings = cli_array(listed, "settings");
    cli_text name = {0};
    while (*use) {
        char id[64];
        const size_t length = strcspn(use, ",");
        snprintf(id, sizeof id, "%.*s", (int)length, use);
        if (name.length)
            cli_text_write(&name, " + ", 3);
        cli_text_write(&name, id, strlen(id));
        add_settings(&name, id, settings);
        use += length + (use[length] == ',');
    }
    json_t *text = json_string(name.data ? name.data : "");
    free(name.data);
    return text;
}

/* One word of a shell command, in quotes where it needs them. */
static void add_word(cli_text *out, const char *option, const char *word) {
    static const char plain[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/";
    cli_text_write(out, " ", 1);
    cli_text_write(out, option, strlen(option));
    if (*option)
        cli_text_write(out, " ", 1);
    if (*word && strspn(word, plain) == strlen(word)) {
        cli_text_write(out, word, strlen(word));
        return;
    }
    cli_text_write(out, "'", 1);
    for (; *word; word++)
        cli_text_write(out, *word == '\'' ? "'\\''" : word, *word == '\'' ? 4 : 1);
    cli_text_write(out, "'", 1);
}

static void add_number(cli_text *out, const char *option, double value) {
    char word[40];
    snprintf(word, sizeof word, "%.17g", value);
    add_word(out, option, word);
}

/* What renders it once, as the pictures show it. */
static json_t *command_of(const sweep_options *o, const sweep_place *place, const json_t *listed) {
    const strata_render_options *r = &o->common.render;
    char size[40];
    size_t i;
    const json_t *setting;
    cli_text out = {0};
    cli_text_write(&out, "strata render", 13);
    add_word(&out, "", place->scene);
    snprintf(size, sizeof size, "%ux%u", place->width, place->height);
    add_word(&out, "--size", size);
    if (*cli_get(listed, "use"))
        add_word(&out, "--use", cli_get(listed, "use"));
    json_array_foreach(cli_array(listed, "settings"), i, setting)
        add_word(&out, "--set", json_string_value(setting));
    if (r->samples > 1)
        add_number(&out, "--samples", r->samples);
    const char *const named[][2] = {{"--filter", r->filter},
                                    {"--camera", r->camera},
                                    {"--effects", r->effects},
                                    {"--backend", o->common.open.backend},
                                    {"--device", o->common.open.device}};
    for (i = 0; i < sizeof named / sizeof *named; i++)
        if (named[i][1])
            add_word(&out, named[i][0], named[i][1]);
    if (o->common.has_time)
        add_number(&out, "--time", o->common.time);
    if (o->common.open.memory)
        add_number(&out, "--memory", (double)o->common.open.memory);
    add_word(&out, "-o", "out.exr");
    json_t *text = json_string(out.data ? out.data : "");
    free(out.data);
    return text;
}

json_t *sweep_configuration(const sweep_options *o, const sweep_place *place,
                            const json_t *listed) {
    json_t *object = json_deep_copy(listed), *name = name_of(listed);
    if (!*cli_get(listed, "use")) {
        json_decref(name);
        name = json_string("the plan's own choice");
    }
    json_object_set_new(object, "name", name);
    json_object_set_new(object, "command", command_of(o, place, listed));
    json_object_set_new(object, "state", json_string("pending"));
    json_object_set_new(object, "reason", json_null());
    json_object_set_new(object, "rounds", json_array());
    json_object_set_new(object, "cpu_ms", json_array());
    json_object_set_new(object, "pace_ms", json_array());
    return object;
}

/* ---- files ----------------------------------------------------------------------------------- */

int sweep_picture(const sweep_options *o, size_t at_case, size_t at, const char *kind,
                  char path[4096]) {
    const int length = snprintf(path, 4096, "%s/pictures/%zu-%zu%s%s.png", o->folder, at_case, at,
                                *kind ? "-" : "", kind);
    return length > 0 && length < 4096;
}

int sweep_save(const sweep *w) {
    char path[4096];
    cli_text text = {0};
    char *data = json_dumps(w->root, SWEEP_JSON);
    if (!data)
        return cli_fail(CLI_FAILED, "results.json: out of memory");
    text.data = data;
    text.length = strlen(data);
    snprintf(path, sizeof path, "%s/results.json", w->options->folder);
    const int status = cli_text_save(&text, path);
    free(data);
    return status;
}
