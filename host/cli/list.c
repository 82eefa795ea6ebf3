/* SPDX-License-Identifier: MIT
 *
 * strata list: what is installed. Modules with their techniques, knobs and effects, devices, and
 * procedural scenes; as JSON or as text made from that JSON.
 */
#include "cli/cli.h"

#include <string.h>

enum { KEY_JSON = 512 };

static const struct argp_option options[] = {
    {"json", KEY_JSON, NULL, 0, "One JSON object instead of text", 0},
    {0},
};

static error_t parse(int key, char *text, struct argp_state *state) {
    int *json = state->input;
    switch (key) {
    case KEY_JSON:
        *json = 1;
        return 0;
    case ARGP_KEY_ARG:
        argp_error(state, "%s: list takes no arguments", text);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    .options = options,
    .parser = parse,
    .doc = "List modules with their techniques, knobs and effects, devices, and procedural scenes. "
           "No module is opened.",
};

/* ---- text ------------------------------------------------------------------------------------ */

static void append(char *line, size_t size, const char *text) {
    size_t length = strlen(line);
    snprintf(line + length, size - length, "%s", text);
}

/* The name of a choice, given as such or by its index. */
static const char *choice_name(const json_t *choices, const json_t *value) {
    const char *name = json_string_value(value);
    if (!name)
        name = json_string_value(json_array_get(choices, (size_t)json_number_value(value)));
    return name ? name : "";
}

/* "1..1024 fragments (8)" or "contiguous|linked (contiguous)". */
static void describe_range(const json_t *knob, char *line, size_t size) {
    const json_t *choices = cli_array(knob, "choices");
    char low[40], high[40], preset[40];
    line[0] = '\0';
    for (size_t i = 0; i < json_array_size(choices); i++) {
        append(line, size, i ? "|" : "");
        append(line, size, choice_name(choices, json_array_get(choices, i)));
    }
    if (!choices) {
        snprintf(low, sizeof low, "%.15g..", cli_number(knob, "minimum"));
        snprintf(high, sizeof high, "%.15g", cli_number(knob, "maximum"));
        append(line, size, low);
        append(line, size, high);
    }
    append(line, size, cli_get(knob, "unit")[0] ? " " : "");
    append(line, size, cli_get(knob, "unit"));
    snprintf(preset, sizeof preset, "%.15g", cli_number(knob, "default"));
    append(line, size, " (");
    append(line, size, choices ? choice_name(choices, json_object_get(knob, "default")) : preset);
    append(line, size, ")");
}

static void print_knobs(const char *prefix, const json_t *knobs, int indent) {
    for (size_t i = 0; i < json_array_size(knobs); i++) {
        const json_t *knob = json_array_get(knobs, i);
        char range[256], name[160];
        snprintf(name, sizeof name, "%s%s", prefix, cli_get(knob, "name"));
        describe_range(knob, range, sizeof range);
        int at = printf("%*s%-24s %s: ", indent, "", name, range);
        cli_wrap(stdout, at, indent + 25, cli_get(knob, "title"));
    }
}

static void print_technique(const json_t *t) {
    const json_t *promises = json_object_get(t, "promises"), *needs = cli_array(t, "needs");
    char prefix[96], line[256];
    int at = printf("    technique %-10s %s: ", cli_get(t, "id"), cli_get(t, "stage"));
    cli_wrap(stdout, at, 25, cli_get(t, "title"));
    snprintf(line, sizeof line, "order %s, determinism %s",
             promises ? cli_get(promises, "order") : "unknown",
             promises ? cli_get(promises, "determinism") : "unknown");
    if (cli_number(promises, "largest_depth") > 0) {
        char depth[64];
        snprintf(depth, sizeof depth, ", at most %.0f fragments a pixel",
                 cli_number(promises, "largest_depth"));
        append(line, sizeof line, depth);
    }
    for (size_t i = 0; i < json_array_size(needs); i++) {
        const char *need = json_string_value(json_array_get(needs, i));
        append(line, sizeof line, i ? ", " : "; needs ");
        append(line, sizeof line, need ? need : "");
    }
    cli_wrap(stdout, 0, 6, line);
    snprintf(prefix, sizeof prefix, "%s.", cli_get(t, "id"));
    print_knobs(prefix, cli_array(t, "knobs"), 6);
}

static void print_effect(const json_t *e) {
    const json_t *needs = cli_array(e, "called_for_by");
    int at = printf("    effect %-13s ", cli_get(e, "id"));
    cli_wrap(stdout, at, 25, cli_get(e, "title"));
    for (size_t i = 0; i < json_array_size(needs); i++) {
        const json_t *need = json_array_get(needs, i);
        printf("      called for by %s >= %g\n", cli_get(need, "fact"),
               cli_number(need, "threshold"));
    }
}

static void print_modules(const json_t *list) {
    const json_t *modules = cli_array(list, "modules"), *rejected = cli_array(list, "rejected");
    puts("modules");
    if (json_array_size(modules) == 0)
        puts("  none is installed; STRATA_MODULE_PATH names the folders to look in");
    for (size_t i = 0; i < json_array_size(modules); i++) {
        const json_t *m = json_array_get(modules, i);
        const json_t *techniques = cli_array(m, "techniques"), *effects = cli_array(m, "effects");
        printf("  %s %s, %s\n    %s\n", cli_get(m, "id"), cli_get(m, "version"),
               cli_get(m, "title"), cli_get(m, "path"));
        for (size_t k = 0; k < json_array_size(techniques); k++)
            print_technique(json_array_get(techniques, k));
        for (size_t k = 0; k < json_array_size(effects); k++)
            print_effect(json_array_get(effects, k));
    }
    if (json_array_size(rejected) > 0)
        puts("\nrejected");
    for (size_t i = 0; i < json_array_size(rejected); i++) {
        const json_t *r = json_array_get(rejected, i);
        printf("  %s\n", cli_get(r, "path"));
        cli_wrap(stdout, 0, 4, cli_get(r, "reason"));
    }
}

static void print_devices(const json_t *list) {
    const json_t *devices = cli_array(list, "devices");
    puts("\ndevices");
    if (json_array_size(devices) == 0)
        puts("  none");
    for (size_t i = 0; i < json_array_size(devices); i++) {
        const json_t *d = json_array_get(devices, i);
        printf("  %-7s %.0f  %s (%s)\n", cli_get(d, "backend"), cli_number(d, "index"),
               cli_get(d, "name"), cli_get(d, "driver"));
    }
}

static void print_scenes(const json_t *list) {
    const json_t *scenes = cli_array(list, "scenes");
    puts("\nscenes");
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const json_t *scene = json_array_get(scenes, i);
        const json_t *size = json_object_get(scene, "size"); /* of a hard case */
        int at = printf(size ? "  %-22s " : "  %-10s ", cli_get(scene, "name"));
        if (size)
            at += printf("%gx%g: ", json_number_value(json_array_get(size, 0)),
                         json_number_value(json_array_get(size, 1)));
        cli_wrap(stdout, at, size ? 25 : 13, cli_get(scene, "title"));
        print_knobs("", cli_array(scene, "knobs"), 4);
    }
}

int cli_list(int argc, char **argv) {
    int as_json = 0, status = CLI_DONE;
    cli_text text = {0};
    json_t *list = NULL;
    strata *s = NULL;
    if (argp_parse(&argp, argc, argv, 0, NULL, &as_json) != 0)
        return CLI_USAGE;
    strata_result result = strata_open(NULL, &s);
    if (result == STRATA_OK)
        result = strata_list(s, cli_text_write, &text);
    if (result != STRATA_OK)
        status = cli_fail_result(s, result);
    else if (as_json)
        status = cli_text_print(&text);
    else
        status = cli_text_parse(&text, &list);
    if (list) {
        printf("strata %s\n\n", cli_get(list, "version"));
        print_modules(list);
        print_devices(list);
        print_scenes(list);
    }
    json_decref(list);
    free(text.data);
    strata_close(s);
    return status;
}
