/* SPDX-License-Identifier: MIT
 *
 * report.html of a sweep: one file with everything in it, for reading without a network. The page
 * is report/report.html; here its holes are filled: results and pictures as JSON that no text in
 * them can break out of, the style, the script and the library that draws plots.
 */
#include "cli/sweep.h"

#include <string.h>

#include "report_assets.h"

extern const char report_library_text[]; /* of the program that this becomes part of; "": none */

#define PICTURE_BUDGET ((size_t)12 << 20) /* bytes of PNG in one report */
#define MAX_PICTURE    (8 << 20)

/* ---- texts ----------------------------------------------------------------------------------- */

static int add(cli_text *page, const char *text) {
    return cli_text_write(page, text, strlen(text)) == STRATA_OK;
}

/* JSON inside <script>: what could end the element, or begin a comment, as \u escapes. */
static int add_json(cli_text *page, const json_t *value) {
    char *text = json_dumps(value, JSON_COMPACT | JSON_ENSURE_ASCII | JSON_REAL_PRECISION(7));
    int ok = text != NULL;
    for (const char *at = text; ok && *at;) {
        const size_t plain = strcspn(at, "<>&");
        ok = cli_text_write(page, at, plain) == STRATA_OK;
        at += plain;
        if (ok && *at)
            ok = add(page, *at == '<' ? "\\u003c" : *at == '>' ? "\\u003e" : "\\u0026");
        at += *at != '\0';
    }
    free(text);
    return ok;
}

/* ---- pictures -------------------------------------------------------------------------------- */

static char *base64(const unsigned char *data, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    static const char head[] = "data:image/png;base64,";
    char *text = malloc(sizeof head + (size + 2) / 3 * 4);
    if (!text)
        return NULL;
    memcpy(text, head, sizeof head - 1);
    char *out = text + sizeof head - 1;
    for (size_t i = 0; i < size; i += 3) {
        const unsigned a = data[i], b = i + 1 < size ? data[i + 1] : 0,
                       c = i + 2 < size ? data[i + 2] : 0;
        *out++ = digits[a >> 2];
        *out++ = digits[(a & 3) << 4 | b >> 4];
        *out++ = i + 1 < size ? digits[(b & 15) << 2 | c >> 6] : '=';
        *out++ = i + 2 < size ? digits[c & 63] : '=';
    }
    *out = '\0';
    return text;
}

/* NULL: there is none, or it is too large for what is left. */
static json_t *picture(const sweep *w, size_t at_case, size_t at, const char *kind, size_t *left) {
    char path[4096];
    FILE *file = sweep_picture(w->options, at_case, at, kind, path) ? fopen(path, "rb") : NULL;
    unsigned char *data = file ? malloc(MAX_PICTURE) : NULL;
    const size_t size = data ? fread(data, 1, MAX_PICTURE, file) : 0;
    json_t *value = NULL;
    if (size > 0 && size < MAX_PICTURE && size <= *left) {
        char *text = base64(data, size);
        value = json_string(text ? text : "");
        free(text);
        *left -= size;
    }
    free(data);
    if (file)
        fclose(file);
    return value;
}

/* Those that look different from the exact one, in the order of `front` first. */
static int add_pictures_of(const sweep *w, size_t at_case, const json_t *one, int front,
                           json_t *pictures, size_t *left) {
    static const char *const kinds[] = {"", "heat", "flip"};
    size_t i;
    int left_out = 0;
    const json_t *c;
    json_array_foreach(json_object_get(one, "configurations"), i, c) {
        const json_t *error = json_object_get(c, "error");
        if (json_is_true(json_object_get(c, "front")) != front || !json_is_object(error) ||
            cli_number(error, "differing") == 0)
            continue;
        json_t *all = json_object();
        for (size_t k = 0; k < 3; k++) {
            json_t *value = picture(w, at_case, i, kinds[k], left);
            if (value)
                json_object_set_new(all, *kinds[k] ? kinds[k] : "color", value);
        }
        if (json_object_size(all) == 3)
            json_array_append_new(
                pictures, json_pack("{s:I, s:o}", "at", (json_int_t)i, "kinds", json_incref(all)));
        left_out += json_object_size(all) != 3;
        json_decref(all);
    }
    return left_out;
}

/* [{"exact": URI, "others": [{"at", "kinds"}], "left_out": n}] for each case. */
static json_t *pictures_of(const sweep *w) {
    json_t *list = json_array();
    const json_t *cases = json_object_get(w->root, "cases");
    size_t i;
    const json_t *one;
    json_array_foreach(cases, i, one) {
        size_t left = PICTURE_BUDGET / json_array_size(cases);
        json_t *others = json_array(), *exact = picture(w, i, 0, "exact", &left);
        int left_out = add_pictures_of(w, i, one, 1, others, &left);
        left_out += add_pictures_of(w, i, one, 0, others, &left);
        json_array_append_new(list,
                              json_pack("{s:o, s:o, s:i}", "exact", exact ? exact : json_null(),
                                        "others", others, "left_out", left_out));
    }
    return list;
}

/* ---- the page -------------------------------------------------------------------------------- */

/* What stands for @NAME@ in the page. */
static int fill(cli_text *page, const char *name, const sweep *w, const json_t *pictures) {
    if (strcmp(name, "STYLE") == 0)
        return add(page, report_css_text);
    if (strcmp(name, "LIBRARY") == 0)
        return add(page, report_library_text);
    if (strcmp(name, "SCRIPT") == 0)
        return add(page, report_core_js_text) && add(page, report_plots_js_text) &&
               add(page, report_page_js_text);
    return strcmp(name, "RESULTS") == 0 ? add_json(page, w->root) : add_json(page, pictures);
}

static int make_page(cli_text *page, const sweep *w, const json_t *pictures) {
    const char *at = report_html_text;
    int ok = 1;
    while (ok && *at) {
        char name[16];
        const size_t plain = strcspn(at, "@");
        const char *end = at[plain] ? strchr(at + plain + 1, '@') : NULL;
        ok = cli_text_write(page, at, plain) == STRATA_OK;
        if (!end)
            return ok;
        snprintf(name, sizeof name, "%.*s", (int)(end - at - (ptrdiff_t)plain - 1), at + plain + 1);
        ok = ok && fill(page, name, w, pictures);
        at = end + 1;
    }
    return ok;
}

int sweep_report(const sweep *w) {
    char path[4096];
    cli_text page = {0};
    json_t *pictures = pictures_of(w);
    snprintf(path, sizeof path, "%s/report.html", w->options->folder);
    const int status = make_page(&page, w, pictures)
                           ? cli_text_save(&page, path)
                           : cli_fail(CLI_FAILED, "%s: out of memory", path);
    free(page.data);
    json_decref(pictures);
    return status;
}
