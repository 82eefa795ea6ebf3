/* SPDX-License-Identifier: MIT
 *
 * strata render: a scene to a picture, and on request its fragments and its account.
 */
#include "cli/cli.h"

#include <string.h>

#define MAX_FRAMES 100000u

enum {
    KEY_BACKGROUND = 512,
    KEY_REPEAT,
    KEY_DEEP,
    KEY_BOUND,
    KEY_ACCOUNT,
    KEY_FRAMES,
    KEY_PATH,
    KEY_FPS,
    KEY_LEARN
};

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
    {"learn", KEY_LEARN, NULL, 0,
     "Add what techniques cost in these frames to what is known of this device; later plans "
     "go "
     "by it. Wants --repeat: frames that prepare teach nothing",
     2},
    {.doc = "A sequence, with history kept from frame to frame:", .group = 3},
    {"frames", KEY_FRAMES, "N", 0,
     "Render N frames; a %d or %04d in -o, --deep or --bound numbers their files, from 0 on; names "
     "without are the last frame's",
     3},
    {"path", KEY_PATH, "FILE|orbit[:TURNS]", 0,
     "Move the camera: key poses in a JSON file, or once (TURNS times) about the scene", 3},
    {"fps", KEY_FPS, "F", 0,
     "Advance the scene, and the path from its first key, by 1/F s a frame; else the scene stands "
     "still and the path is spread over all frames",
     3},
    {0},
};

typedef struct request {
    cli_options common;
    cli_outputs outputs;
    cli_sequence sequence;
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

static void check_sequence(struct argp_state *state, const request *r) {
    const cli_sequence *q = &r->sequence;
    const strata_render_options *o = &r->common.render;
    double turns;
    if (q->frames == 0 && (q->path || q->fps > 0))
        argp_error(state, "%s goes with --frames", q->path ? "--path" : "--fps");
    else if (q->frames > 0 && (o->repeat || o->turn != 0))
        argp_error(state, "--frames does not go with %s", o->repeat ? "--repeat" : "frame.turn");
    else if (q->path && cli_path_is_orbit(q->path, &turns) < 0)
        argp_error(state, "--path %s: expected orbit:TURNS, from -1000 to 1000", q->path);
    else if (q->path && o->camera && !cli_path_is_orbit(q->path, &turns))
        argp_error(state, "--camera does not go with --path FILE, which says where it stands");
}

static void check(struct argp_state *state, const request *r) {
    const cli_outputs *o = &r->outputs;
    char line[CLI_LINE];
    if (!o->color)
        argp_error(state, "-o is missing: a .png or .exr file");
    else if (!cli_has_suffix(o->color, ".png") && !cli_has_suffix(o->color, ".exr"))
        argp_error(state, "-o %s: the name ends in .png or .exr", o->color);
    else if (o->deep && !cli_has_suffix(o->deep, ".exr"))
        argp_error(state, "--deep %s: the name ends in .exr", o->deep);
    else if (o->bound && !cli_has_suffix(o->bound, ".exr"))
        argp_error(state, "--bound %s: the name ends in .exr", o->bound);
    else if (!cli_check_names(o, r->sequence.frames, line))
        argp_error(state, "%s", line);
    else
        check_sequence(state, r);
}

static error_t parse(int key, char *text, struct argp_state *state) {
    request *r = state->input;
    uint64_t count;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &r->common;
        return 0;
    case 'o':
        r->outputs.color = text;
        return 0;
    case KEY_DEEP:
        r->outputs.deep = text;
        return 0;
    case KEY_BOUND:
        r->outputs.bound = text;
        return 0;
    case KEY_ACCOUNT:
        r->outputs.account = text;
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
    case KEY_FRAMES:
        if (!cli_parse_whole(text, 1, MAX_FRAMES, &count))
            argp_error(state, "--frames %s: expected a whole number from 1 to %u", text,
                       MAX_FRAMES);
        else
            r->sequence.frames = (uint32_t)count;
        return 0;
    case KEY_LEARN:
        r->common.render.learn = 1;
        return 0;
    case KEY_PATH:
        r->sequence.path = text;
        return 0;
    case KEY_FPS:
        if (!cli_parse_number(text, 1e-3, 1e6, &r->sequence.fps))
            argp_error(state, "--fps %s: expected frames a second from 0.001 to 1e6", text);
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
    .doc = "Render SCENE, a .gltf or .glb file, scene:NAME?K=V&K=V or hard:NAME, to a picture.",
    .children = children,
};

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
        (r.outputs.deep ? STRATA_OUTPUT_DEEP : 0) | (r.outputs.bound ? STRATA_OUTPUT_BOUND : 0);
    cli_catch_interrupt();
    if (status == CLI_DONE)
        status = cli_check_outputs(&r.outputs, r.sequence.frames);
    if (status == CLI_DONE)
        status = cli_options_open(&r.common, &s, &scene);
    if (status == CLI_DONE)
        status = cli_render_frames(s, scene, &r.common, &r.outputs, &r.sequence);
    strata_scene_close(scene);
    strata_close(s);
    cli_options_free(&r.common);
    return status;
}
