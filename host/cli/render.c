/* SPDX-License-Identifier: MIT
 *
 * strata render: a scene to a picture, and on request its fragments and its account.
 */
#include "cli/cli.h"

#include <math.h>
#include <string.h>

enum { KEY_BACKGROUND = 512, KEY_REPEAT, KEY_DEEP, KEY_BOUND, KEY_ACCOUNT };

static const struct argp_option options[] = {
    {.doc = "What comes out:", .group = 1},
    {"output", 'o', "FILE", 0, "The picture: .png (sRGB, 8 bit) or .exr (linear float); required",
     1},
    {"deep", KEY_DEEP, "OUT.exr", 0, "Every fragment and the opaque surface, as deep EXR", 1},
    {"bound", KEY_BOUND, "OUT.exr", 0,
     "How wrong each channel may be at most, proved without a reference; inf: uncertified", 1},
    {"account", KEY_ACCOUNT, "OUT.json", 0, "What it cost and how right it is; - for stdout", 1},
    {"background", KEY_BACKGROUND, "R,G,B", 0, "Linear; 0.2,0.2,0.2", 2},
    {"repeat", KEY_REPEAT, "N", 0, "Render N frames and account for all; the last is kept", 2},
    {0},
};

typedef struct request {
    cli_options common;
    const char *output, *deep, *bound, *account;
} request;

static int parse_background(const char *text, strata_render_options *render) {
    char part[64];
    double value;
    for (int i = 0; i < 3; i++) {
        size_t length = strcspn(text, ",");
        if (length >= sizeof part || (i < 2) != (text[length] == ','))
            return 0;
        memcpy(part, text, length);
        part[length] = '\0';
        if (!cli_parse_number(part, 0.0, 65504.0, &value))
            return 0;
        render->background[i] = (float)value;
        text += length + (i < 2);
    }
    render->background[3] = 1.0f;
    render->has_background = 1;
    return 1;
}

/* Two outputs of one name would overwrite each other. */
static void check_names(struct argp_state *state, const request *r) {
    const char *const names[] = {"-o", "--deep", "--bound", "--account"};
    const char *const paths[] = {r->output, r->deep, r->bound, r->account};
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        for (size_t k = i + 1; paths[i] && k < sizeof paths / sizeof *paths; k++)
            if (paths[k] && strcmp(paths[i], paths[k]) == 0)
                argp_error(state, "%s and %s name the same file", names[i], names[k]);
}

static void check(struct argp_state *state, const request *r) {
    if (!r->output)
        argp_error(state, "-o is missing: a .png or .exr file");
    else if (!cli_has_suffix(r->output, ".png") && !cli_has_suffix(r->output, ".exr"))
        argp_error(state, "-o %s: the name ends in .png or .exr", r->output);
    else if (r->deep && !cli_has_suffix(r->deep, ".exr"))
        argp_error(state, "--deep %s: the name ends in .exr", r->deep);
    else if (r->bound && !cli_has_suffix(r->bound, ".exr"))
        argp_error(state, "--bound %s: the name ends in .exr", r->bound);
    else
        check_names(state, r);
}

static error_t parse(int key, char *text, struct argp_state *state) {
    request *r = state->input;
    uint64_t count;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &r->common;
        return 0;
    case 'o':
        r->output = text;
        return 0;
    case KEY_DEEP:
        r->deep = text;
        return 0;
    case KEY_BOUND:
        r->bound = text;
        return 0;
    case KEY_ACCOUNT:
        r->account = text;
        return 0;
    case KEY_BACKGROUND:
        if (!parse_background(text, &r->common.render))
            argp_error(state, "--background %s: expected R,G,B, each from 0 to 65504", text);
        return 0;
    case KEY_REPEAT:
        if (!cli_parse_whole(text, 1, 1000000, &count))
            argp_error(state, "--repeat %s: expected a whole number from 1 to 1000000", text);
        else
            r->common.render.repeat = (uint32_t)count;
        return 0;
    case ARGP_KEY_SUCCESS:
        check(state, r);
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
    .doc = "Render SCENE, a .gltf or .glb file or scene:NAME?K=V&K=V, to a picture.",
    .children = children,
};

static int check_outputs(const request *r) {
    const char *paths[] = {r->output, r->deep, r->bound, r->account};
    int status = CLI_DONE;
    for (size_t i = 0; i < sizeof paths / sizeof *paths && status == CLI_DONE; i++)
        if (paths[i] && strcmp(paths[i], "-") != 0)
            status = cli_check_output(paths[i]);
    return status;
}

/* Warnings to stderr, the account to its file. */
static int tell_account(strata *s, const request *r) {
    cli_text text = {0};
    json_t *account = NULL;
    strata_result result = strata_account(s, cli_text_write, &text);
    int status = result == STRATA_OK ? cli_text_parse(&text, &account) : cli_fail_result(s, result);
    if (status == CLI_DONE) {
        cli_warn(account);
        if (r->account)
            status = cli_text_save(&text, r->account);
    }
    json_decref(account);
    free(text.data);
    return status;
}

static int render_and_save(strata *s, strata_scene *scene, const request *r) {
    strata_result result = strata_render(s, scene, &r->common.render);
    cli_progress_end();
    if (result != STRATA_OK && result != STRATA_PARTIAL)
        return cli_fail_result(s, result);
    if (cli_interrupted())
        return cli_fail(CLI_FAILED, "stopped");
    int status = result == STRATA_PARTIAL ? CLI_PARTIAL : CLI_DONE;
    result = strata_save(s, STRATA_OUTPUT_COLOR, r->output);
    if (result == STRATA_OK && r->deep)
        result = strata_save(s, STRATA_OUTPUT_DEEP, r->deep);
    if (result == STRATA_OK && r->bound)
        result = strata_save(s, STRATA_OUTPUT_BOUND, r->bound);
    if (result != STRATA_OK)
        return cli_fail_result(s, result);
    int told = tell_account(s, r);
    if (told == CLI_DONE && status == CLI_PARTIAL)
        cli_fail(status, "done, but less than was asked for: see the account");
    return told != CLI_DONE ? told : status;
}

int cli_render(int argc, char **argv) {
    request r = {0};
    strata *s = NULL;
    strata_scene *scene = NULL;
    int status = cli_options_init(&r.common, argc);
    if (status != CLI_DONE)
        return status;
    if (argp_parse(&argp, argc, argv, 0, NULL, &r) != 0)
        status = CLI_USAGE;
    r.common.render.outputs =
        (r.deep ? STRATA_OUTPUT_DEEP : 0) | (r.bound ? STRATA_OUTPUT_BOUND : 0);
    r.common.render.progress = cli_progress;
    cli_catch_interrupt();
    if (status == CLI_DONE)
        status = check_outputs(&r);
    if (status == CLI_DONE)
        status = cli_options_open(&r.common, &s, &scene);
    if (status == CLI_DONE)
        status = render_and_save(s, scene, &r);
    strata_scene_close(scene);
    strata_close(s);
    cli_options_free(&r.common);
    return status;
}
