/* SPDX-License-Identifier: MIT
 *
 * The options that say what is rendered and by what: shared by render and plan, checked while they
 * are parsed. Ids and knobs are checked by the plan, which knows them.
 */
#include "cli/cli.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_SIDE    65536u
#define MAX_SAMPLES 1024u

enum {
    KEY_BACKEND = 256,
    KEY_SIZE,
    KEY_USE,
    KEY_SET,
    KEY_EFFECTS,
    KEY_CAMERA,
    KEY_TIME,
    KEY_DEVICE,
    KEY_MEMORY,
    KEY_TOLERANCE,
    KEY_BUDGET,
    KEY_SAMPLES,
    KEY_FILTER
};

static const struct argp_option options[] = {
    {.doc = "What is rendered:", .group = 2},
    {"size", KEY_SIZE, "WxH", 0, "Pixels; 800x600", 2},
    {"camera", KEY_CAMERA, "NAME|INDEX|orbit:AZ,EL", 0,
     "A camera of the scene, or one around it in degrees; the first, else an orbit", 2},
    {"time", KEY_TIME, "T", 0, "Seconds into the scene's animations; 0", 2},
    {"tolerance", KEY_TOLERANCE, "E", 0,
     "The largest certified error that is accepted, in linear radiance; 0: exact techniques", 2},
    {"budget", KEY_BUDGET, "MS", 0,
     "Milliseconds that a frame may take: the most accurate way that is expected to fit, then, "
     "over "
     "the frames of --repeat or --frames, as they turn out",
     2},
    {"samples", KEY_SAMPLES, "N", 0, "Sub-pixels a pixel, a square: 1, 4, 9, 16, ..; 1", 2},
    {"filter", KEY_FILTER, "box|tent|gaussian", 0, "Weights that turn them into pixels; box", 2},
    {.doc = "By what:", .group = 3},
    {"use", KEY_USE, "ID[,ID..]", 0, "Use these techniques; the plan fills what they leave open",
     3},
    {"set", KEY_SET, "ID.KNOB=VALUE", 0,
     "Set a technique's knob; may be repeated. For tests: frame.bands=N, frame.shuffle=SEED, "
     "frame.turn=DEGREES",
     3},
    {"effects", KEY_EFFECTS, "auto|none|ID[,ID..]", 0,
     "What the scene calls for, nothing, or exactly these", 3},
    {"backend", KEY_BACKEND, "vulkan|gl|null", 0, "Vulkan where there is one, else GL", 3},
    {"device", KEY_DEVICE, "NAME|INDEX", 0, "A part of the device's name, or its index; the first",
     3},
    {"memory", KEY_MEMORY, "BYTES", 0, "Device memory that techniques may take; K, M, G as suffix",
     3},
    {0},
};

/* ---- numbers --------------------------------------------------------------------------------- */

int cli_parse_number(const char *text, double low, double high, double *out) {
    char *end;
    if (!*text || !strchr("0123456789+-.", *text))
        return 0;
    double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value) || value < low || value > high)
        return 0;
    *out = value;
    return 1;
}

int cli_parse_whole(const char *text, uint64_t low, uint64_t high, uint64_t *out) {
    char *end;
    if (*text < '0' || *text > '9')
        return 0;
    errno = 0;
    unsigned long long value = strtoull(text, &end, 10);
    if (*end || errno || value < low || value > high)
        return 0;
    *out = value;
    return 1;
}

static int parse_size(const char *text, strata_render_options *render) {
    char width[16];
    uint64_t w, h;
    const char *cross = strchr(text, 'x');
    if (!cross || (size_t)(cross - text) >= sizeof width)
        return 0;
    memcpy(width, text, (size_t)(cross - text));
    width[cross - text] = '\0';
    if (!cli_parse_whole(width, 1, MAX_SIDE, &w) || !cli_parse_whole(cross + 1, 1, MAX_SIDE, &h))
        return 0;
    render->width = (uint32_t)w;
    render->height = (uint32_t)h;
    return 1;
}

/* A square, as a regular grid of sub-pixels is one. */
static int parse_samples(const char *text, uint32_t *samples) {
    uint64_t value, side = 1;
    if (!cli_parse_whole(text, 1, MAX_SAMPLES, &value))
        return 0;
    while (side * side < value)
        side++;
    *samples = (uint32_t)value;
    return side * side == value;
}

static int is_filter(const char *text) {
    return strcmp(text, "box") == 0 || strcmp(text, "tent") == 0 || strcmp(text, "gaussian") == 0;
}

static int parse_memory(const char *text, uint64_t *bytes) {
    static const char suffixes[] = "KMG";
    char digits[32];
    size_t length = strlen(text);
    const char *suffix = length ? strchr(suffixes, text[length - 1]) : NULL;
    unsigned shift = suffix && *suffix ? 10u * (unsigned)(suffix - suffixes + 1) : 0;
    if (shift)
        length--;
    if (length >= sizeof digits)
        return 0;
    memcpy(digits, text, length);
    digits[length] = '\0';
    if (!cli_parse_whole(digits, 1, UINT64_MAX >> shift, bytes))
        return 0;
    *bytes <<= shift;
    return 1;
}

/* ---- settings -------------------------------------------------------------------------------- */

/* Settings of the frame itself, which no technique has. */
static void set_frame(struct argp_state *state, cli_options *o, const char *text) {
    uint64_t value;
    const char *knob = text + strlen("frame.");
    if (strncmp(knob, "bands=", 6) == 0) {
        if (!cli_parse_whole(knob + 6, 1, 65536, &value))
            argp_error(state, "--set %s: expected a whole number from 1 to 65536", text);
        else
            o->render.bands = (uint32_t)value;
    } else if (strncmp(knob, "shuffle=", 8) == 0) {
        if (!cli_parse_whole(knob + 8, 0, UINT32_MAX, &value))
            argp_error(state, "--set %s: expected a whole number below 2^32", text);
        else
            o->render.shuffle = (uint32_t)value;
    } else if (strncmp(knob, "turn=", 5) == 0) {
        if (!cli_parse_number(knob + 5, -360, 360, &o->render.turn))
            argp_error(state, "--set %s: expected degrees from -360 to 360", text);
    } else {
        argp_error(state, "--set %s: the frame's knobs are bands, shuffle and turn", text);
    }
}

static void add_setting(struct argp_state *state, cli_options *o, const char *text) {
    const char *dot = strchr(text, '.'), *equals = strchr(text, '=');
    if (!dot || !equals || dot > equals || dot == text || dot + 1 == equals || !equals[1])
        argp_error(state, "--set %s: expected ID.KNOB=VALUE", text);
    else if (strncmp(text, "frame.", 6) == 0)
        set_frame(state, o, text);
    else
        o->settings[o->render.setting_count++] = text;
}

/* ---- argp ------------------------------------------------------------------------------------ */

static int is_backend(const char *text) {
    return strcmp(text, "vulkan") == 0 || strcmp(text, "gl") == 0 || strcmp(text, "null") == 0;
}

static error_t parse(int key, char *text, struct argp_state *state) {
    cli_options *o = state->input;
    switch (key) {
    case KEY_SIZE:
        if (!parse_size(text, &o->render))
            argp_error(state, "--size %s: expected WxH, each from 1 to %u", text, MAX_SIDE);
        return 0;
    case KEY_CAMERA:
        o->render.camera = text;
        return 0;
    case KEY_SAMPLES:
        if (!parse_samples(text, &o->render.samples))
            argp_error(state, "--samples %s: expected one of 1, 4, 9, 16, .. %u", text,
                       MAX_SAMPLES);
        return 0;
    case KEY_FILTER:
        if (!is_filter(text))
            argp_error(state, "--filter %s: expected box, tent or gaussian", text);
        o->render.filter = text;
        return 0;
    case KEY_TIME:
        o->has_time = cli_parse_number(text, -1e9, 1e9, &o->time);
        if (!o->has_time)
            argp_error(state, "--time %s: expected seconds", text);
        return 0;
    case KEY_USE:
        o->render.use = text;
        return 0;
    case KEY_SET:
        add_setting(state, o, text);
        return 0;
    case KEY_EFFECTS:
        o->render.effects = text;
        return 0;
    case KEY_BACKEND:
        if (!is_backend(text))
            argp_error(state, "--backend %s: expected vulkan, gl or null", text);
        o->open.backend = text;
        return 0;
    case KEY_DEVICE:
        o->open.device = text;
        return 0;
    case KEY_MEMORY:
        if (!parse_memory(text, &o->open.memory))
            argp_error(state, "--memory %s: expected bytes, with K, M or G as suffix", text);
        return 0;
    case KEY_TOLERANCE:
        if (!cli_parse_number(text, 0.0, 1e9, &o->render.tolerance))
            argp_error(state, "--tolerance %s: expected a number from 0 to 1e9", text);
        return 0;
    case KEY_BUDGET:
        if (!cli_parse_number(text, 1e-3, 1e9, &o->render.budget))
            argp_error(state, "--budget %s: expected milliseconds from 0.001 to 1e9", text);
        return 0;
    case ARGP_KEY_ARG:
        if (o->scene)
            argp_error(state, "%s: one scene at a time", text);
        o->scene = text;
        return 0;
    case ARGP_KEY_END:
        if (!o->scene)
            argp_error(state, "SCENE is missing: a .gltf or .glb file, scene:NAME or hard:NAME");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

const struct argp cli_options_argp = {.options = options, .parser = parse};

int cli_options_init(cli_options *o, int argc) {
    *o = (cli_options){
        .open = {.struct_size = sizeof o->open},
        .render = {.struct_size = sizeof o->render},
    };
    o->settings = calloc((size_t)argc + 1, sizeof *o->settings);
    o->render.settings = o->settings;
    return o->settings ? CLI_DONE : cli_fail(CLI_FAILED, "out of memory");
}

void cli_options_free(cli_options *o) {
    free(o->settings);
}

int cli_options_open(const cli_options *o, strata **s, strata_scene **scene) {
    *scene = NULL;
    strata_result result = strata_open(&o->open, s);
    if (result != STRATA_OK)
        return cli_fail_result(NULL, result);
    result = strata_scene_load(*s, o->scene, scene);
    if (result == STRATA_OK && o->has_time)
        result = strata_scene_set_time(*scene, o->time);
    if (result == STRATA_OK)
        return CLI_DONE;
    int status = cli_fail_result(*s, result);
    strata_scene_close(*scene);
    strata_close(*s);
    *s = NULL;
    *scene = NULL;
    return status;
}
