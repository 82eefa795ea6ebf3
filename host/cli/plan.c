/* SPDX-License-Identifier: MIT
 *
 * strata plan: what a scene calls for, what would run, what would not, and why; as JSON or as text
 * made from that JSON.
 */
#include "cli/cli.h"

#include <string.h>

enum { KEY_JSON = 512 };

static const struct argp_option options[] = {
    {.doc = "What comes out:", .group = 1},
    {"json", KEY_JSON, NULL, 0, "One JSON object instead of text", 1},
    {0},
};

typedef struct request {
    cli_options common;
    int json;
} request;

static error_t parse(int key, char *text, struct argp_state *state) {
    request *r = state->input;
    (void)text;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &r->common;
        return 0;
    case KEY_JSON:
        r->json = 1;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_child children[] = {{.argp = &cli_options_argp}, {0}};
static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "SCENE",
    .doc = "Say what SCENE calls for, which techniques would render it, and why no others.",
    .children = children,
};

/* ---- text ------------------------------------------------------------------------------------ */

static void print_head(const json_t *plan) {
    const json_t *size = cli_array(plan, "size"), *device = json_object_get(plan, "device");
    printf("scene       %s\n", cli_get(plan, "scene"));
    printf("image       %.0f x %.0f", json_number_value(json_array_get(size, 0)),
           json_number_value(json_array_get(size, 1)));
    if (cli_number(plan, "samples") > 1)
        printf(", %.0f samples a pixel, %s filter", cli_number(plan, "samples"),
               cli_get(plan, "filter"));
    puts("");
    if (json_is_object(device))
        printf("device      %s (%s, %s)\n", cli_get(device, "name"), cli_get(device, "backend"),
               cli_get(device, "driver"));
    else
        printf("device      none could be opened\n");
}

static void print_estimate(const json_t *plan) {
    const json_t *e = json_object_get(plan, "estimate");
    char a[40], b[40];
    printf("draws       %s opaque, ", cli_count(cli_number(e, "opaque_draws"), a));
    printf("%s transparent\n", cli_count(cli_number(e, "transparent_draws"), a));
    if (cli_number(e, "transparent_fragments") > 0)
        printf("estimate    %s transparent fragments over %s pixels, %.1f deep on average, %.0f at "
               "most\n",
               cli_count(cli_number(e, "transparent_fragments"), a),
               cli_count(cli_number(e, "covered_pixels"), b), cli_number(e, "mean_depth"),
               cli_number(e, "largest_depth"));
}

static void print_effects(const json_t *plan) {
    const json_t *effects = cli_array(plan, "effects");
    puts("\neffects");
    if (json_array_size(effects) == 0)
        puts("  none is installed");
    for (size_t i = 0; i < json_array_size(effects); i++) {
        const json_t *e = json_array_get(effects, i);
        const char *evidence = cli_get(e, "evidence");
        char line[512];
        snprintf(line, sizeof line, "%s%s%s%s", cli_get(e, "reason"), evidence[0] ? " (" : "",
                 evidence, evidence[0] ? ")" : "");
        int at = printf("  %-14s %-4s", cli_get(e, "id"),
                        json_is_true(json_object_get(e, "active")) ? "on" : "off");
        cli_wrap(stdout, at, 22, line);
    }
}

static void print_settings(const json_t *technique) {
    const char *name;
    json_t *value;
    const char *id = cli_get(technique, "technique");
    json_object_foreach(json_object_get(technique, "settings"), name, value) {
        if (json_is_string(value))
            printf("%22s%s.%s=%s\n", "", id, name, json_string_value(value));
        else
            printf("%22s%s.%s=%.10g\n", "", id, name, json_number_value(value));
    }
}

/* Where its cost comes from, when anything on the device was measured. */
static void print_cost(const json_t *technique) {
    const double points = cli_number(technique, "points");
    if (points > 0)
        printf("%22sits cost rests on %.0f measured point%s\n", "", points, points == 1 ? "" : "s");
}

static void print_techniques(const json_t *plan, const char *key, const char *title) {
    const json_t *techniques = cli_array(plan, key);
    printf("\n%s\n", title);
    if (json_array_size(techniques) == 0)
        puts("  none");
    for (size_t i = 0; i < json_array_size(techniques); i++) {
        const json_t *t = json_array_get(techniques, i);
        int at = printf("  %-10s %-8s ", cli_get(t, "technique"), cli_get(t, "stage"));
        cli_wrap(stdout, at, 22, cli_get(t, "reason"));
        print_cost(t);
        print_settings(t);
    }
}

static void print_fragments(const json_t *plan) {
    const json_t *f = json_object_get(plan, "fragments"), *fields = cli_array(f, "fields");
    char bytes[40];
    if (!json_is_object(f))
        return;
    fputs("\nfragments\n  ", stdout);
    if (cli_get(f, "layout")[0])
        printf("%s records of %.0f bytes, about %s bytes in all; ", cli_get(f, "layout"),
               cli_number(f, "bytes_per_fragment"), cli_count(cli_number(f, "bytes"), bytes));
    if (cli_number(f, "bands") > 1)
        printf("about %.0f bands; ", cli_number(f, "bands"));
    printf("%s payload:", cli_get(f, "payload"));
    for (size_t i = 0; i < json_array_size(fields); i++) {
        const json_t *field = json_array_get(fields, i);
        printf("%s %s (%.0f%s)", i ? "," : "", cli_get(field, "name"),
               cli_number(field, "channels"),
               json_is_true(json_object_get(field, "exact")) ? ", exact" : "");
    }
    puts("");
}

static void print_warnings(const json_t *plan) {
    const json_t *warnings = cli_array(plan, "warnings");
    if (json_array_size(warnings) > 0)
        puts("\nwarnings");
    for (size_t i = 0; i < json_array_size(warnings); i++) {
        const char *line = json_string_value(json_array_get(warnings, i));
        cli_wrap(stdout, 0, 2, line ? line : "");
    }
}

static void print_cost_of_all(const json_t *plan) {
    if (!json_is_number(json_object_get(plan, "cost")))
        return;
    printf("  estimated cost: %.3g x floor", cli_number(plan, "cost"));
    if (json_is_number(json_object_get(plan, "ms")))
        printf(", about %.3g ms, as measured on this device\n", cli_number(plan, "ms"));
    else
        puts(" by the modules' coefficients; nothing was measured on this device");
}

static void print_plan(const json_t *plan) {
    print_head(plan);
    print_estimate(plan);
    print_effects(plan);
    print_techniques(plan, "techniques", "techniques, as they run");
    print_cost_of_all(plan);
    print_fragments(plan);
    print_techniques(plan, "left_out", "left out");
    print_warnings(plan);
}

static int tell(strata *s, strata_scene *scene, const request *r) {
    cli_text text = {0};
    json_t *plan = NULL;
    strata_result result = strata_plan(s, scene, &r->common.render, cli_text_write, &text);
    int status = CLI_DONE;
    if (result != STRATA_OK)
        status = cli_fail_result(s, result);
    else if (r->json)
        status = cli_text_print(&text);
    else
        status = cli_text_parse(&text, &plan);
    if (plan)
        print_plan(plan);
    json_decref(plan);
    free(text.data);
    return status;
}

int cli_plan(int argc, char **argv) {
    request r = {0};
    strata *s = NULL;
    strata_scene *scene = NULL;
    int status = cli_options_init(&r.common, argc);
    if (status != CLI_DONE)
        return status;
    if (argp_parse(&argp, argc, argv, 0, NULL, &r) != 0)
        status = CLI_USAGE;
    if (status == CLI_DONE)
        status = cli_options_open(&r.common, &s, &scene);
    if (status == CLI_DONE)
        status = tell(s, scene, &r);
    strata_scene_close(scene);
    strata_close(s);
    cli_options_free(&r.common);
    return status;
}
