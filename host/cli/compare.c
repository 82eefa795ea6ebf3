/* SPDX-License-Identifier: MIT
 *
 * strata compare: how far two pictures are apart, in linear light.
 */
#include "cli/cli.h"

enum { KEY_JSON = 512, KEY_HEAT, KEY_FLIP, KEY_PPD };

static const struct argp_option options[] = {
    {"json", KEY_JSON, NULL, 0, "One JSON object instead of text", 0},
    {"heat", KEY_HEAT, "OUT.png", 0, "A picture of where they differ", 0},
    {"flip", KEY_FLIP, "OUT.png", 0, "A picture of FLIP, from 0 (black) to 1 (white)", 0},
    {"ppd", KEY_PPD, "N", 0, "Pixels per degree of vision, for FLIP; 67", 0},
    {0},
};

typedef struct request {
    const char *files[2];
    strata_compare_options options;
    int count, json;
} request;

static error_t parse(int key, char *text, struct argp_state *state) {
    request *r = state->input;
    switch (key) {
    case KEY_JSON:
        r->json = 1;
        return 0;
    case KEY_HEAT:
        if (!cli_has_suffix(text, ".png"))
            argp_error(state, "--heat %s: the name ends in .png", text);
        r->options.heat = text;
        return 0;
    case KEY_FLIP:
        if (!cli_has_suffix(text, ".png"))
            argp_error(state, "--flip %s: the name ends in .png", text);
        r->options.flip = text;
        return 0;
    case KEY_PPD:
        if (!cli_parse_number(text, 1, 1000, &r->options.pixels_per_degree))
            argp_error(state, "--ppd %s: expected a number from 1 to 1000", text);
        return 0;
    case ARGP_KEY_ARG:
        if (r->count == 2)
            argp_error(state, "%s: two pictures are compared", text);
        else
            r->files[r->count++] = text;
        return 0;
    case ARGP_KEY_END:
        if (r->count < 2)
            argp_error(state, "two pictures are compared");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp argp = {
    .options = options,
    .parser = parse,
    .args_doc = "A B",
    .doc =
        "Compare two pictures of one size, .png or .exr: the largest difference, the root of the "
        "mean square and PSNR, in linear RGBA, and FLIP as seen on a display. A is the reference.",
};

static void print_difference(const json_t *d) {
    const json_t *psnr = json_object_get(d, "psnr");
    char count[40];
    printf("max        %.9g\n", cli_number(d, "max"));
    printf("rmse       %.9g\n", cli_number(d, "rmse"));
    if (json_is_number(psnr))
        printf("psnr       %.4f dB\n", json_number_value(psnr));
    else
        puts("psnr       infinite");
    const json_t *flip = json_object_get(d, "flip");
    printf("flip       %.6f mean, %.6f weighted median\n", cli_number(flip, "mean"),
           cli_number(flip, "weighted_median"));
    printf("differing  %s pixels\n", cli_count(cli_number(d, "differing"), count));
    if (cli_number(d, "broken") > 0)
        printf("broken     %s pixels that are not finite\n",
               cli_count(cli_number(d, "broken"), count));
}

int cli_compare(int argc, char **argv) {
    request r = {.options = {.struct_size = sizeof r.options}};
    cli_text text = {0};
    json_t *difference = NULL;
    strata *s = NULL;
    int status = CLI_DONE;
    if (argp_parse(&argp, argc, argv, 0, NULL, &r) != 0)
        return CLI_USAGE;
    strata_result result = strata_open(NULL, &s);
    if (result == STRATA_OK)
        result = strata_compare(s, r.files[0], r.files[1], &r.options, cli_text_write, &text);
    if (result != STRATA_OK)
        status = cli_fail(CLI_FAILED, "%s", strata_error(s));
    else if (r.json)
        status = cli_text_print(&text);
    else
        status = cli_text_parse(&text, &difference);
    if (difference)
        print_difference(difference);
    json_decref(difference);
    free(text.data);
    strata_close(s);
    return status;
}
