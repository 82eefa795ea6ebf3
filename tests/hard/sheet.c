/* SPDX-License-Identifier: MIT
 *
 * One page of all hard cases: a picture of each, how many fragments it holds, and what is certified
 * for it. `hard_sheet OUT.html`: a single file, readable offline.
 */
#define _DEFAULT_SOURCE
#include "hard/hard.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct {
    const char *title, *use, *setting;
} columns[] = {
    {"float", "abuffer,ppc", "abuffer.payload=float"},
    {"half", "abuffer,ppc", "abuffer.payload=half"},
    {"unorm8", "abuffer,ppc", "abuffer.payload=unorm8"},
    {"as a tree", "abuffer,fpc", "fpc.mode=fragments"},
    {"nearest 4", "kplus,ppc", "kplus.k=4"},
};

static void put_base64(FILE *out, const unsigned char *data, size_t size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; k++)
            bits = bits << 8 | (i + k < size ? data[i + k] : 0);
        for (size_t k = 0; k < 4; k++)
            fputc(i + k > size ? '=' : digits[bits >> (18 - 6 * k) & 63], out);
    }
}

/* The picture of the last render. */
static void put_picture(FILE *out, strata *instance, const char *name) {
    char path[] = "/tmp/strata-sheet-XXXXXX.png";
    unsigned char *data = NULL;
    size_t size = 0;
    base_error err = {0};
    const int fd = mkstemps(path, 4);
    if (fd < 0 || strata_save(instance, STRATA_OUTPUT_COLOR, path) != STRATA_OK ||
        base_file_read(path, 1 << 24, &data, &size, &err) != STRATA_OK) {
        fprintf(stderr, "%s: %s%s\n", name, strata_error(instance), err.text);
        exit(1);
    }
    close(fd);
    unlink(path);
    fputs("<img alt=\"\" src=\"data:image/png;base64,", out);
    put_base64(out, data, size);
    fputs("\">", out);
    free(data);
}

static void put_holds(FILE *out, const hard_row *row) {
    static const char *const names[] = {"split and merged", "translated", "rotated",
                                        "fold oracle",      "ray oracle", "from its file"};
    for (size_t i = 0; i < BASE_COUNT(names); i++)
        if (row->holds >> i & 1)
            fprintf(out, "%s, ", names[i]);
    if (row->holds & HARD_REFUSED) {
        fputs("the line names the mesh", out);
        return;
    }
    fputs(row->holds & HARD_LARGE ? "every way and backend (large)" : "every way and backend", out);
}

static int certify(strata *instance, strata_scene *sc, const scene_hard_case *k, size_t column) {
    const strata_render_options options = {.struct_size = sizeof options,
                                           .width = k->width,
                                           .height = k->height,
                                           .use = columns[column].use,
                                           .settings = &columns[column].setting,
                                           .setting_count = 1,
                                           .outputs = STRATA_OUTPUT_BOUND};
    return strata_render(instance, sc, &options) == STRATA_OK;
}

static void put_row(FILE *out, strata *instance, const hard_row *row) {
    const scene_hard_case *k = hard_case(row->name);
    strata_scene *sc = NULL;
    const int loaded = strata_scene_load(instance, k->name, &sc) == STRATA_OK;
    fputs("<tr><td>", out);
    if (loaded && certify(instance, sc, k, 0))
        put_picture(out, instance, k->name);
    fprintf(out, "</td><td><b>%s</b><br>%s<br><i>%s</i></td>", k->name, k->title,
            loaded ? "" : strata_error(instance));
    if (loaded)
        fprintf(out, "<td>%llu</td><td>%llu</td>",
                (unsigned long long)instance->result.report.total,
                (unsigned long long)instance->result.report.largest);
    for (size_t i = 0; loaded && i < BASE_COUNT(columns); i++) {
        const int done = certify(instance, sc, k, i);
        const render_bound *bound = &instance->result.bound;
        if (!done)
            fprintf(out, "<td>%s</td>", strata_error(instance));
        else if (bound->uncertified)
            fprintf(out, "<td>%.2g; none for %llu pixels</td>", bound->max,
                    (unsigned long long)bound->uncertified);
        else
            fprintf(out, "<td>%.2g</td>", bound->max);
    }
    if (!loaded)
        fprintf(out, "<td colspan=%zu>refused</td>", 2 + BASE_COUNT(columns));
    fputs("<td>", out);
    put_holds(out, row);
    fprintf(out, "</td><td>%s</td></tr>\n", row->kills);
    strata_scene_close(sc);
}

static void put_head(FILE *out, const strata *instance) {
    fprintf(
        out,
        "<!DOCTYPE html><html lang=en><meta charset=utf-8><meta name=viewport "
        "content=\"width=device-width\"><title>Hard cases</title><style>\n"
        "body{font:14px sans-serif;margin:1em}table{border-collapse:collapse}"
        "td,th{border:1px solid #ccc;padding:4px;text-align:left;vertical-align:top}"
        "img{width:128px;image-rendering:pixelated}.wide{overflow-x:auto}</style>\n"
        "<h1>Hard cases</h1><p>Fixed scenes that ask one hard question each, rendered by %s. The "
        "error columns are the largest certified error of a channel, for colours as they are "
        "(up to 1e6 in hard:hdr-million).</p><div class=wide><table><tr><th><th>case<th>"
        "fragments<th>deepest pixel",
        instance->backend);
    for (size_t i = 0; i < BASE_COUNT(columns); i++)
        fprintf(out, "<th>error, %s", columns[i].title);
    fputs("<th>what holds<th>mutation it finds</tr>\n", out);
}

int main(int argc, char **argv) {
    strata *instance = picture_instance("vulkan");
    if (!instance)
        instance = picture_instance("gl");
    FILE *out = argc == 2 && instance ? fopen(argv[1], "w") : NULL;
    if (!out) {
        fprintf(stderr, "usage: hard_sheet OUT.html, with a device\n");
        return 2;
    }
    put_head(out, instance);
    for (size_t i = 0; i < hard_row_count; i++) {
        put_row(out, instance, &hard_rows[i]);
        fprintf(stderr, "%zu of %zu\r", i + 1, hard_row_count);
    }
    fputs("</table></div><h2>Limits</h2><ul>\n", out);
    for (size_t i = 0; i < hard_limit_count; i++)
        fprintf(out, "<li><b>%s</b>; the mutation it finds: %s\n", hard_limits[i].name,
                hard_limits[i].kills);
    fputs("</ul></html>\n", out);
    picture_close();
    return fclose(out) == 0 ? 0 : 1;
}
