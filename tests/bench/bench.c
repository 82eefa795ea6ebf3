/* SPDX-License-Identifier: MIT
 *
 * The benchmark: techniques as multiples of the floor, in one process, configurations interleaved
 * in shuffled order, the camera turned by a degree a frame. Prints one JSON object; see --help.
 */
#define _POSIX_C_SOURCE 200809L

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <jansson.h>

#include "strata/host.h"

enum { MAX_CONFIGS = 32, MAX_FRAMES = 1001, MAX_SETTINGS = 8 };

typedef struct config {
    const char *backend, *use, *settings[MAX_SETTINGS];
    uint32_t setting_count;
    char name[160], words[160];
    strata *instance;
    strata_scene *scene;
    double ms[MAX_FRAMES], cpu_ms[MAX_FRAMES], last_ms[MAX_FRAMES]; /* last: see last_technique */
    json_t *account, *first; /* of the last frame, and of the first, before the camera turned */
} config;

typedef struct options {
    const char *scene, *backends, *module_path;
    uint32_t width, height, frames, warmup;
    double turn;                    /* degrees a frame */
    const char *given[MAX_CONFIGS]; /* --config, beside the floor; none = the default ones */
    uint32_t given_count;
} options;

static double now_ms(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static int by_value(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return left < right ? -1 : left > right;
}

static double median(const double *values, uint32_t count) {
    double sorted[MAX_FRAMES];
    memcpy(sorted, values, count * sizeof *values);
    qsort(sorted, count, sizeof *sorted, by_value);
    return count % 2 ? sorted[count / 2] : (sorted[count / 2 - 1] + sorted[count / 2]) / 2;
}

static double deviation(const double *values, uint32_t count) {
    double away[MAX_FRAMES];
    const double middle = median(values, count);
    for (uint32_t i = 0; i < count; ++i)
        away[i] = values[i] > middle ? values[i] - middle : middle - values[i];
    return median(away, count);
}

static strata_result append(void *user, const char *bytes, size_t size) {
    json_t **text = user;
    json_t *longer = json_sprintf("%s%.*s", json_string_value(*text), (int)size, bytes);
    json_decref(*text);
    *text = longer;
    return longer ? STRATA_OK : STRATA_ERROR_OUT_OF_HOST_MEMORY;
}

static json_t *read_account(strata *s) {
    json_t *text = json_string("");
    json_t *account = NULL;
    if (strata_account(s, append, &text) == STRATA_OK)
        account = json_loads(json_string_value(text), 0, NULL);
    json_decref(text);
    return account;
}

/* Time of the last frame as the host saw it: planning and reading back are not part of it. */
static double last_frame(json_t *account) {
    json_t *frames = json_object_get(account, "frame_ms");
    return json_number_value(json_array_get(frames, json_array_size(frames) - 1));
}

/* Time of the technique that `use` names last, for a capture and its resolve the resolve. */
static double last_technique(json_t *account, const char *use) {
    const char *id = strrchr(use, ',') ? strrchr(use, ',') + 1 : use;
    double ms = 0;
    size_t i;
    json_t *pass;
    json_array_foreach(json_object_get(account, "passes"), i, pass) {
        const char *technique = json_string_value(json_object_get(pass, "technique"));
        if (technique && strcmp(technique, id) == 0)
            ms += json_number_value(json_object_get(pass, "gpu_ms"));
    }
    return ms;
}

static int open_config(config *c, const options *o) {
    const strata_open_options open = {
        .struct_size = sizeof open, .backend = c->backend, .module_path = o->module_path};
    if (strata_open(&open, &c->instance) != STRATA_OK ||
        strata_scene_load(c->instance, o->scene, &c->scene) != STRATA_OK) {
        fprintf(stderr, "bench: %s: %s\n", c->name, strata_error(c->instance));
        return 0;
    }
    return 1;
}

/* frame < 0: to warm up, not measured. */
static int run_frame(config *c, const options *o, int32_t frame, double turns) {
    const double cpu = now_ms(CLOCK_PROCESS_CPUTIME_ID);
    const strata_render_options render = {.struct_size = sizeof render,
                                          .width = o->width,
                                          .height = o->height,
                                          .use = c->use,
                                          .settings = c->settings,
                                          .setting_count = c->setting_count,
                                          .angle = turns * o->turn};
    if (strata_render(c->instance, c->scene, &render) != STRATA_OK) {
        fprintf(stderr, "bench: %s: %s\n", c->name, strata_error(c->instance));
        return 0;
    }
    json_decref(c->account);
    c->account = read_account(c->instance);
    if (!c->first)
        c->first = json_incref(c->account);
    if (frame >= 0) {
        c->ms[frame] = last_frame(c->account);
        c->last_ms[frame] = last_technique(c->account, c->use);
        c->cpu_ms[frame] = now_ms(CLOCK_PROCESS_CPUTIME_ID) - cpu;
    }
    return 1;
}

static void shuffle(uint32_t *order, uint32_t count, uint32_t *state) {
    for (uint32_t i = count; i > 1; --i) {
        *state = *state * 1664525u + 1013904223u;
        const uint32_t j = (*state >> 8) % i, swap = order[i - 1];
        order[i - 1] = order[j];
        order[j] = swap;
    }
}

static int run_all(config *configs, uint32_t count, const options *o) {
    uint32_t order[MAX_CONFIGS], state = 1;
    for (uint32_t i = 0; i < count; ++i)
        order[i] = i;
    for (uint32_t i = 0; i < count; ++i)
        for (uint32_t w = 0; w < o->warmup; ++w)
            /* through the angles to come, so that what a technique learns is learned before */
            if (!run_frame(&configs[i], o, -1, (double)w * o->frames / o->warmup))
                return 0;
    for (uint32_t frame = 0; frame < o->frames; ++frame) {
        shuffle(order, count, &state);
        for (uint32_t i = 0; i < count; ++i)
            if (!run_frame(&configs[order[i]], o, (int32_t)frame, frame))
                return 0;
        fprintf(stderr, "\rbench: frame %u of %u", frame + 1, o->frames);
    }
    fputc('\n', stderr);
    return 1;
}

/* ---- what to measure
 * ----------------------------------------------------------------------------- */

/* `text` is what to use and then settings, between blanks: "abuffer,ppc abuffer.payload=half". */
static int add(config *configs, uint32_t *count, const char *backend, const char *text) {
    if (*count == MAX_CONFIGS || strlen(text) >= sizeof configs->name)
        return 0;
    config *c = &configs[(*count)++];
    *c = (config){.backend = backend};
    memcpy(c->name, text, strlen(text) + 1);
    memcpy(c->words, text, strlen(text) + 1);
    char *rest = NULL;
    c->use = strtok_r(c->words, " ", &rest);
    for (char *word; c->use && (word = strtok_r(NULL, " ", &rest));) {
        if (c->setting_count == MAX_SETTINGS)
            return 0;
        c->settings[c->setting_count++] = word;
    }
    return c->use != NULL;
}

/* 0: too many of them, or one is malformed. */
static uint32_t make_configs(config *configs, const options *o) {
    static const char *const backends[] = {"vulkan", "gl"};
    static const char *const usual[] = {"abuffer,ppc", "abuffer,ppc abuffer.payload=half",
                                        "abuffer,ppc abuffer.payload=unorm8",
                                        "abuffer,ppc abuffer.mode=linked"};
    const char *const *texts = o->given_count ? o->given : usual;
    const uint32_t text_count =
        o->given_count ? o->given_count : (uint32_t)(sizeof usual / sizeof *usual);
    uint32_t count = 0;
    for (size_t b = 0; b < 2; ++b) {
        if (!strstr(o->backends, backends[b]))
            continue;
        int ok = add(configs, &count, backends[b], "floor");
        for (uint32_t i = 0; i < text_count && ok; ++i)
            ok = add(configs, &count, backends[b], texts[i]);
        if (!ok)
            return 0;
    }
    return count;
}

static double floor_of(const config *configs, uint32_t count, const char *backend,
                       uint32_t frames) {
    for (uint32_t i = 0; i < count; ++i)
        if (strcmp(configs[i].backend, backend) == 0 && strcmp(configs[i].use, "floor") == 0)
            return median(configs[i].ms, frames);
    return 0;
}

static double fragments_in(json_t *account) {
    return json_number_value(json_object_get(json_object_get(account, "fragments"), "total"));
}

/* Of the last frame; the floor does not count its fragments, the others do. */
static double fragments_of(const config *configs, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i)
        if (fragments_in(configs[i].account) > 0)
            return fragments_in(configs[i].account);
    return 0;
}

static json_t *result_of(const config *c, double floor_ms, double fragments, const options *o) {
    const double ms = median(c->ms, o->frames), last_ms = median(c->last_ms, o->frames);
    json_t *bytes = json_object_get(c->first, "bytes");
    const double first_fragments = fragments_in(c->first);
    const double stored = json_number_value(json_object_get(bytes, "abuffer")) +
                          json_number_value(json_object_get(bytes, "ppc"));
    const double pixels = (double)o->width * o->height;
    json_t *frames = json_array();
    for (uint32_t i = 0; i < o->frames; ++i)
        json_array_append_new(frames, json_real(c->ms[i]));
    return json_pack("{s:s, s:s, s:f, s:o, s:f, s:f, s:o, s:f, s:f, s:f, s:f, s:O, s:O, s:O}",
                     "name", c->name, "backend", c->backend, "ms", ms, "frame_ms", frames, "mad_ms",
                     deviation(c->ms, o->frames), "cpu_ms", median(c->cpu_ms, o->frames), "x_floor",
                     fragments > 0 && floor_ms > 0 ? json_real(ms / floor_ms) : json_null(),
                     "mfragments_s", fragments / ms / 1e3, "last_technique_ms", last_ms,
                     "last_technique_mfragments_s", last_ms > 0 ? fragments / last_ms / 1e3 : 0,
                     "bytes_a_fragment_beyond_16_a_pixel",
                     first_fragments > 0 ? (stored - 16 * pixels) / first_fragments : 0, "bytes",
                     bytes, "passes", json_object_get(c->account, "passes"), "device",
                     json_object_get(c->account, "device"));
}

static int print_results(const config *configs, uint32_t count, const options *o) {
    const double fragments = fragments_of(configs, count);
    json_t *results = json_array();
    for (uint32_t i = 0; i < count; ++i)
        json_array_append_new(
            results, result_of(&configs[i], floor_of(configs, count, configs[i].backend, o->frames),
                               fragments, o));
    json_t *root = json_pack("{s:s, s:[i,i], s:i, s:f, s:o}", "scene", o->scene, "size",
                             (int)o->width, (int)o->height, "frames", (int)o->frames, "fragments",
                             fragments, "results", results);
    const int failed = !root || json_dumpf(root, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(6));
    putchar('\n');
    json_decref(root);
    return !failed;
}

static int usage(int status) {
    fputs("usage: bench [--scene SCENE] [--size WxH] [--frames N] [--warmup N]\n"
          "             [--backends vulkan,gl] [--modules FOLDERS] [--turn DEGREES A FRAME]\n"
          "             [--config 'ID[,ID..] [ID.KNOB=VALUE]..']..\n"
          "Prints JSON: each technique's frame time as a multiple of the floor.\n"
          "Defaults: scene:soup, 512x512, 11 frames, 3 to warm up, both backends, 1 degree.\n",
          status ? stderr : stdout);
    return status;
}

int main(int argc, char **argv) {
    options o = {.scene = "scene:soup",
                 .backends = "vulkan,gl",
                 .module_path = BENCH_MODULES,
                 .width = 512,
                 .height = 512,
                 .frames = 11,
                 .warmup = 3,
                 .turn = 1};
    static config configs[MAX_CONFIGS];
    strata_keep_memory();
    for (int i = 1; i < argc; i += 2) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(argv[i], "--help") == 0)
            return usage(0);
        if (!value)
            return usage(2);
        if (strcmp(argv[i], "--scene") == 0)
            o.scene = value;
        else if (strcmp(argv[i], "--backends") == 0)
            o.backends = value;
        else if (strcmp(argv[i], "--modules") == 0)
            o.module_path = value;
        else if (strcmp(argv[i], "--turn") == 0)
            o.turn = strtod(value, NULL);
        else if (strcmp(argv[i], "--config") == 0 && o.given_count < MAX_CONFIGS)
            o.given[o.given_count++] = value;
        else if (strcmp(argv[i], "--frames") == 0)
            o.frames = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(argv[i], "--warmup") == 0)
            o.warmup = (uint32_t)strtoul(value, NULL, 10);
        else if (strcmp(argv[i], "--size") != 0 || sscanf(value, "%ux%u", &o.width, &o.height) != 2)
            return usage(2);
    }
    if (o.frames == 0 || o.frames > MAX_FRAMES)
        return usage(2);
    const uint32_t count = make_configs(configs, &o);
    if (count == 0)
        return usage(2);
    int ok = 1;
    for (uint32_t i = 0; i < count && ok; ++i)
        ok = open_config(&configs[i], &o);
    ok = ok && run_all(configs, count, &o) && print_results(configs, count, &o);
    for (uint32_t i = 0; i < count; ++i) {
        json_decref(configs[i].account);
        json_decref(configs[i].first);
        if (configs[i].instance)
            strata_close(configs[i].instance);
    }
    return ok ? 0 : 1;
}
