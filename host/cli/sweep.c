/* SPDX-License-Identifier: MIT
 *
 * strata sweep: every way to render a scene, measured: time against error. Options, the cases, and
 * what is said at the end. The rest is in the files that sweep.h lists.
 */
#define _POSIX_C_SOURCE 200809L
#include "cli/sweep.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum { KEY_REPEAT = 512, KEY_RESUME, KEY_ALSO, KEY_ONLY, KEY_ALL };

static const struct argp_option options[] = {
    {.doc = "What comes out:", .group = 1},
    {"output", 'o', "DIR", 0, "A folder for results.json, report.html and pictures; sweep", 1},
    {"repeat", KEY_REPEAT, "N", 0, "Frames measured of each configuration that may matter; 12", 1},
    {"resume", KEY_RESUME, NULL, 0, "Go on with the sweep that DIR holds", 1},
    {"also", KEY_ALSO, "SCENE|WxH", 0,
     "Measure another scene, or the first one at another size, too: how costs grow. May be "
     "repeated",
     1},
    {"only", KEY_ONLY, "TEXT", 0,
     "Only configurations whose name holds TEXT (\"kplus k=8 + ppc\"). May be repeated", 1},
    {"all", KEY_ALL, NULL, 0, "Turn knobs that do not trade accuracy, too", 1},
    {0},
};

/* ---- options --------------------------------------------------------------------------------- */

static void check(struct argp_state *state, const sweep_options *o) {
    const strata_render_options *r = &o->common.render;
    const int set = r->setting_count || r->bands || r->shuffle || r->turn != 0;
    const char *wrong = r->use             ? "--use"
                        : r->tolerance > 0 ? "--tolerance"
                        : r->budget > 0    ? "--budget"
                        : set              ? "--set"
                                           : NULL;
    if (o->common.open.backend && strcmp(o->common.open.backend, "null") == 0)
        argp_error(state, "--backend null draws nothing that could be measured");
    else if (wrong)
        argp_error(state, "%s does not go with a sweep, which tries all; see --only", wrong);
}

static error_t parse(int key, char *text, struct argp_state *state) {
    sweep_options *o = state->input;
    uint64_t count;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &o->common;
        return 0;
    case 'o':
        o->folder = text;
        return 0;
    case KEY_REPEAT:
        if (!cli_parse_whole(text, 1, 1000, &count))
            argp_error(state, "--repeat %s: expected a whole number from 1 to 1000", text);
        else
            o->frames = (uint32_t)count;
        return 0;
    case KEY_RESUME:
        o->resume = 1;
        return 0;
    case KEY_ALL:
        o->all = 1;
        return 0;
    case KEY_ALSO:
        if (o->also_count + 1 >= SWEEP_MAX_CASES)
            argp_error(state, "--also: %d at most", SWEEP_MAX_CASES - 1);
        else
            o->also[o->also_count++] = text;
        return 0;
    case KEY_ONLY:
        o->only[o->only_count++] = text;
        return 0;
    case ARGP_KEY_SUCCESS:
        check(state, o);
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
    .doc = "Measure what accuracy costs in time: SCENE by every installed technique, in every "
           "combination that fits, over the knobs that trade accuracy; in multiples of the floor, "
           "against the exact image. Writes results.json and report.html.",
    .children = children,
};

/* "WxH"; 0: something else, a scene. */
static int as_size(const char *text, sweep_place *place) {
    char extra;
    return sscanf(text, "%5ux%5u%c", &place->width, &place->height, &extra) == 2 && place->width &&
           place->height && strspn(text, "0123456789x") == strlen(text);
}

static void make_places(sweep_options *o) {
    const strata_render_options *r = &o->common.render;
    const sweep_place first = {o->common.scene, r->width ? r->width : 800,
                               r->height ? r->height : 600};
    o->places[o->place_count++] = first;
    for (uint32_t i = 0; i < o->also_count; i++) {
        sweep_place place = first;
        if (!as_size(o->also[i], &place))
            place = (sweep_place){o->also[i], first.width, first.height};
        o->places[o->place_count++] = place;
    }
}

/* ---- progress -------------------------------------------------------------------------------- */

double sweep_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

uint32_t sweep_rounds(const sweep_options *o) {
    return (o->frames + SWEEP_VISIT - 1) / SWEEP_VISIT;
}

strata_result sweep_keep_going(void *user, double done) {
    (void)user, (void)done;
    return cli_interrupted() ? STRATA_ERROR_CANCELLED : STRATA_OK;
}

void sweep_progress(const sweep *w, const char *what) {
    char left[40] = "", line[128];
    const double spent = sweep_seconds() - w->began;
    if (w->done > 0 && spent > 5) {
        const double seconds = spent / w->done * (w->total - w->done);
        snprintf(left, sizeof left, seconds < 90 ? ", %.0f s left" : ", %.0f min left",
                 seconds < 90 ? seconds : seconds / 60);
    }
    snprintf(line, sizeof line, "%3.0f %%%-18s %.74s", w->total > 0 ? 100 * w->done / w->total : 0,
             left, what);
    cli_progress_line(line);
}

/* ---- the command ----------------------------------------------------------------------------- */

static int make_folder(const char *path) {
    struct stat info;
    if (mkdir(path, 0777) == 0 ||
        (errno == EEXIST && stat(path, &info) == 0 && S_ISDIR(info.st_mode)))
        return CLI_DONE;
    return cli_fail(CLI_FAILED, "%s: cannot make the folder: %s", path, strerror(errno));
}

/* One that cannot be measured is found before hours went into the others. */
static int check_places(sweep *w) {
    const sweep_options *o = w->options;
    int status = CLI_DONE;
    for (size_t i = 0; i < o->place_count && status == CLI_DONE; i++)
        if (i == 0 || strcmp(o->places[i].scene, o->places[0].scene) != 0)
            status = sweep_reopen(w, &o->places[i]);
    return status;
}

static int is_utf8(const char *text) {
    json_t *value = json_string(text);
    json_decref(value);
    return value != NULL;
}

/* JSON is UTF-8. NULL: all that comes into the results is. */
static const char *find_bad_text(const sweep_options *o) {
    const strata_render_options *r = &o->common.render;
    const char *const texts[] = {r->camera, r->effects, r->filter, o->common.open.device};
    const char *bad = NULL;
    for (size_t i = 0; i < sizeof texts / sizeof *texts && !bad; i++)
        bad = texts[i] && !is_utf8(texts[i]) ? texts[i] : NULL;
    for (size_t i = 0; i < o->place_count && !bad; i++)
        bad = is_utf8(o->places[i].scene) ? NULL : o->places[i].scene;
    for (size_t i = 0; i < o->only_count && !bad; i++)
        bad = is_utf8(o->only[i]) ? NULL : o->only[i];
    return bad;
}

static int begin(sweep *w) {
    const sweep_options *o = w->options;
    char path[4096];
    const char *bad = find_bad_text(o);
    int status = CLI_DONE;
    if (snprintf(path, sizeof path, "%s/results.json", o->folder) >= (int)sizeof path - 64)
        return cli_fail(CLI_FAILED, "%.64s...: the path is too long", o->folder);
    if (bad)
        return cli_fail(CLI_FAILED, "%s: it is not UTF-8, which results.json is", bad);
    if (o->resume)
        status = sweep_load(o, &w->root);
    else if (access(path, F_OK) == 0)
        status = cli_fail(CLI_FAILED, "%s: there is one already; --resume goes on with it", path);
    if (status == CLI_DONE)
        status = check_places(w);
    if (status == CLI_DONE && !o->resume)
        status = make_folder(o->folder);
    snprintf(path, sizeof path, "%s/pictures", o->folder);
    if (status == CLI_DONE)
        status = make_folder(path);
    if (status == CLI_DONE && !w->root && !(w->root = sweep_begin(o)))
        status = cli_fail(CLI_FAILED, "out of memory");
    return status;
}

static void print_words(const json_t *root) {
    size_t i, k;
    const json_t *one, *line;
    json_array_foreach(cli_array(root, "cases"), i, one) {
        const json_t *size = json_object_get(one, "size");
        printf("%s, %.0fx%.0f\n", cli_get(one, "scene"), json_number_value(json_array_get(size, 0)),
               json_number_value(json_array_get(size, 1)));
        json_array_foreach(cli_array(one, "words"), k, line) {
            printf("  ");
            cli_wrap(stdout, 2, 4, json_string_value(line) ? json_string_value(line) : "");
        }
    }
}

/* What does not hold, a line each; what failed makes less than was asked for. */
static int verdict(const json_t *root) {
    const json_t *violations = cli_array(root, "violations");
    for (size_t i = 0; i < json_array_size(violations); i++) {
        const char *line = json_string_value(json_array_get(violations, i));
        cli_fail(0, "does not hold: %s", line ? line : "");
    }
    return json_array_size(violations) > 0  ? CLI_FAILED
           : cli_number(root, "failed") > 0 ? CLI_PARTIAL
                                            : CLI_DONE;
}

static int run(sweep *w) {
    const sweep_options *o = w->options;
    int status = begin(w);
    w->began = sweep_seconds();
    for (size_t i = 0; i < o->place_count && status == CLI_DONE; i++)
        status = sweep_case(w, i);
    cli_progress_end();
    if (status == CLI_DONE) {
        json_object_set_new(w->root, "complete", json_true());
        sweep_judge(w->root);
        status = sweep_save(w);
    }
    if (status == CLI_DONE)
        status = sweep_report(w);
    if (status != CLI_DONE)
        return status;
    print_words(w->root);
    printf("%s/report.html, %s/results.json\n", o->folder, o->folder);
    return verdict(w->root);
}

int cli_sweep(int argc, char **argv) {
    sweep_options o = {.folder = "sweep", .frames = 12};
    sweep w = {.options = &o};
    int status = cli_options_init(&o.common, argc);
    o.only = calloc((size_t)argc + 1, sizeof *o.only);
    if (status == CLI_DONE && !o.only)
        status = cli_fail(CLI_FAILED, "out of memory");
    if (status == CLI_DONE && argp_parse(&argp, argc, argv, 0, NULL, &o) != 0)
        status = CLI_USAGE;
    cli_catch_interrupt();
    if (status == CLI_DONE) {
        make_places(&o);
        status = run(&w);
    }
    strata_scene_close(w.scene);
    strata_close(w.s);
    json_decref(w.root);
    free(o.only);
    cli_options_free(&o.common);
    return status;
}
