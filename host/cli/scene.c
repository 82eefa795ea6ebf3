/* SPDX-License-Identifier: MIT
 *
 * strata scene: a procedural scene as a GLB file, for tests and benchmarks.
 */
#include "cli/cli.h"

#include <stdlib.h>
#include <string.h>

enum { KEY_SET = 512 };

static const struct argp_option options[] = {
    {"output", 'o', "OUT.glb", 0, "The file; required", 0},
    {"set", KEY_SET, "K=V", 0, "A knob of the scene; may be repeated", 0},
    {0},
};

typedef struct request {
    const char *name, *output;
    const char **knobs;
    uint32_t knob_count;
} request;

static error_t parse(int key, char *text, struct argp_state *state) {
    request *r = state->input;
    switch (key) {
    case 'o':
        if (!cli_has_suffix(text, ".glb"))
            argp_error(state, "-o %s: the name ends in .glb", text);
        r->output = text;
        return 0;
    case KEY_SET:
        if (!strchr(text, '=') || text[0] == '=')
            argp_error(state, "--set %s: expected K=V", text);
        r->knobs[r->knob_count++] = text;
        return 0;
    case ARGP_KEY_ARG:
        if (r->name)
            argp_error(state, "%s: one scene at a time", text);
        r->name = text;
        return 0;
    case ARGP_KEY_END:
        if (!r->name)
            argp_error(state, "NAME is missing: strata list shows the scenes and their knobs");
        else if (!r->output)
            argp_error(state, "-o is missing: a .glb file");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "NAME",
    .doc = "Write the procedural scene NAME, or the hard case hard:NAME, as GLB. `strata list' "
           "shows the "
           "names and their knobs.",
};

int cli_scene(int argc, char **argv) {
    request r = {0};
    strata *s = NULL;
    strata_scene *scene = NULL;
    int status = CLI_DONE;
    r.knobs = calloc((size_t)argc + 1, sizeof *r.knobs);
    if (!r.knobs)
        return cli_fail(CLI_FAILED, "out of memory");
    if (argp_parse(&argp, argc, argv, 0, NULL, &r) != 0)
        status = CLI_USAGE;
    cli_catch_interrupt();
    if (status == CLI_DONE)
        status = cli_check_output(r.output);
    if (status == CLI_DONE) {
        strata_result result = strata_open(NULL, &s);
        if (result == STRATA_OK)
            result = strata_scene_generate(s, r.name, r.knobs, r.knob_count, &scene);
        if (result == STRATA_OK && cli_interrupted())
            status = cli_fail(CLI_FAILED, "stopped");
        else if (result == STRATA_OK)
            result = strata_scene_save(scene, r.output);
        if (result != STRATA_OK)
            status = cli_fail_result(s, result);
    }
    strata_scene_close(scene);
    strata_close(s);
    free(r.knobs);
    return status;
}
