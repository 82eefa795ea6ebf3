/* SPDX-License-Identifier: MIT
 *
 * The command `strata`: finds the verb and hands the rest of the line to it.
 */
#include "cli/cli.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

static const struct verb {
    const char *name;
    int (*run)(int argc, char **argv);
} verbs[] = {
    {"render", cli_render},   {"plan", cli_plan},   {"list", cli_list},
    {"compare", cli_compare}, {"scene", cli_scene}, {"sweep", cli_sweep},
};

typedef struct choice {
    const struct verb *verb;
    int index; /* of the verb in argv */
} choice;

static void print_version(FILE *out, struct argp_state *state) {
    (void)state;
    uint32_t version = strata_version();
    fprintf(out, "strata %s, host ABI %u.%u\n", strata_release(), STRATA_VERSION_MAJOR(version),
            STRATA_VERSION_MINOR(version));
}

static error_t parse(int key, char *text, struct argp_state *state) {
    choice *c = state->input;
    switch (key) {
    case ARGP_KEY_ARG:
        for (size_t i = 0; i < sizeof verbs / sizeof *verbs; i++)
            if (strcmp(verbs[i].name, text) == 0)
                c->verb = &verbs[i];
        if (!c->verb)
            argp_error(state,
                       "'%s' is no command; there are render, plan, list, compare, sweep and scene",
                       text);
        c->index = state->next - 1;
        state->next = state->argc; /* what follows is the verb's */
        return 0;
    case ARGP_KEY_NO_ARGS:
        argp_error(state, "a command is missing");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    .parser = parse,
    .args_doc = "COMMAND ...",
    .doc = "Render scenes whose pixels hold many fragments.\n\n"
           "  strata render SCENE -o OUT.png   render a picture\n"
           "  strata plan SCENE                what would run, what would not, and why\n"
           "  strata list                      modules, techniques, knobs, devices, scenes\n"
           "  strata compare A B               how far two pictures are apart\n"
           "  strata sweep SCENE -o DIR        what accuracy costs in time: a report\n"
           "  strata scene NAME -o OUT.glb     write a procedural scene\n\n"
           "SCENE is a .gltf or .glb file, scene:NAME?K=V&K=V or hard:NAME. Each command has "
           "--help.\v"
           "Exit status: 0 done; 1 it failed, and one line says why; 2 bad usage; 3 done, but less "
           "than was asked for.\n\n"
           "Environment: STRATA_MODULE_PATH, STRATA_CACHE_DIR, STRATA_LOG, STRATA_CHECK; "
           "see strata(1).",
};

/* What argp and the library name themselves by: "strata VERB". */
static int run(const choice *c, int argc, char **argv) {
    char name[64];
    snprintf(name, sizeof name, "strata %s", c->verb->name);
    char **rest = calloc((size_t)(argc - c->index) + 1, sizeof *rest);
    if (!rest)
        return cli_fail(CLI_FAILED, "out of memory");
    memcpy(rest, argv + c->index, (size_t)(argc - c->index) * sizeof *rest);
    rest[0] = name;
    int status = c->verb->run(argc - c->index, rest);
    free(rest);
    return status;
}

int main(int argc, char **argv) {
    choice c = {0};
    strata_keep_memory();
    signal(SIGXFSZ, SIG_IGN); /* a file that may not grow is an error like a full disk */
    argp_err_exit_status = CLI_USAGE;
    argp_program_version_hook = print_version;
    if (argp_parse(&argp, argc, argv, ARGP_IN_ORDER, NULL, &c) != 0 || !c.verb)
        return CLI_USAGE;
    int status = run(&c, argc, argv);
    errno = 0;
    if ((fflush(stdout) != 0 || ferror(stdout)) && status == CLI_DONE)
        status = cli_fail(CLI_FAILED, "standard output: cannot write%s%s", errno ? ": " : "",
                          errno ? strerror(errno) : "");
    return status;
}
