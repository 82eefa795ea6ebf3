/* SPDX-License-Identifier: MIT
 *
 * chart TABLE.json [Y]: a table of the benchmark as an SVG on stdout. One line a configuration and
 * backend, logarithmic axes; Y is the figure of each result to show, `x_floor` by default.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <jansson.h>

enum {
    MAX_SERIES = 24,
    MAX_POINTS = 64,
    WIDTH = 980,
    HEIGHT = 520,
    LEFT = 70,
    RIGHT = 560,
    TOP = 50,
    BOTTOM = 460
};

typedef struct series {
    char name[224];
    double x[MAX_POINTS], y[MAX_POINTS];
    size_t count;
} series;

typedef struct axis {
    double low, high; /* log10 */
    double from, to;  /* pixels */
} axis;

static const char *const colors[] = {"#1f77b4", "#d62728", "#2ca02c", "#9467bd",
                                     "#ff7f0e", "#17becf", "#8c564b", "#000000"};
static const char *const dashes[] = {"none", "7 4", "2 3"};

static void print_text(const char *text) {
    for (; *text; ++text) {
        if (*text == '<')
            fputs("&lt;", stdout);
        else if (*text == '>')
            fputs("&gt;", stdout);
        else if (*text == '&')
            fputs("&amp;", stdout);
        else
            putchar(*text);
    }
}

static const char *string_of(const json_t *object, const char *key) {
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static series *find_series(series *all, size_t *count, const char *name) {
    for (size_t i = 0; i < *count; ++i)
        if (strcmp(all[i].name, name) == 0)
            return &all[i];
    if (*count == MAX_SERIES)
        return NULL;
    series *s = &all[(*count)++];
    snprintf(s->name, sizeof s->name, "%s", name);
    return s;
}

/* Figures that are not above zero have no place on a logarithmic axis and are left out. */
static size_t collect(const json_t *table, const char *figure, series *all) {
    size_t count = 0, i, k;
    json_t *row, *result;
    json_array_foreach(json_object_get(table, "rows"), i, row) {
        const double x = json_number_value(json_object_get(row, "x"));
        json_array_foreach(json_object_get(json_object_get(row, "bench"), "results"), k, result) {
            char name[224];
            const double y = json_number_value(json_object_get(result, figure));
            snprintf(name, sizeof name, "%s, %s", string_of(result, "name"),
                     string_of(result, "backend"));
            series *s = x > 0 && y > 0 ? find_series(all, &count, name) : NULL;
            if (s && s->count < MAX_POINTS) {
                s->x[s->count] = x;
                s->y[s->count++] = y;
            }
        }
    }
    return count;
}

static axis make_axis(const series *all, size_t count, int vertical) {
    axis a = {.low = HUGE_VAL,
              .high = -HUGE_VAL,
              .from = vertical ? BOTTOM : LEFT,
              .to = vertical ? TOP : RIGHT};
    for (size_t i = 0; i < count; ++i)
        for (size_t k = 0; k < all[i].count; ++k) {
            const double v = log10(vertical ? all[i].y[k] : all[i].x[k]);
            a.low = fmin(a.low, v);
            a.high = fmax(a.high, v);
        }
    const double margin = fmax(0.04 * (a.high - a.low), 0.02);
    a.low -= margin;
    a.high += margin;
    return a;
}

static double place(const axis *a, double value) {
    return a->from + (log10(value) - a->low) / (a->high - a->low) * (a->to - a->from);
}

/* At 1, 2 and 5 of each decade; at 1 alone when the axis is long. */
static void draw_ticks(const axis *a, int vertical) {
    static const double steps[] = {1, 2, 5};
    const size_t used = a->high - a->low > 3 ? 1 : 3;
    for (int decade = (int)floor(a->low); decade <= (int)ceil(a->high); ++decade)
        for (size_t i = 0; i < used; ++i) {
            const double value = steps[i] * pow(10, decade), at = log10(value);
            if (at < a->low || at > a->high)
                continue;
            const double p = place(a, value);
            if (vertical)
                printf("<line x1='%d' x2='%d' y1='%.1f' y2='%.1f' stroke='#ddd'/>"
                       "<text x='%d' y='%.1f' text-anchor='end'>%g</text>\n",
                       LEFT, RIGHT, p, p, LEFT - 6, p + 4, value);
            else
                printf("<line x1='%.1f' x2='%.1f' y1='%d' y2='%d' stroke='#ddd'/>"
                       "<text x='%.1f' y='%d' text-anchor='middle'>%g</text>\n",
                       p, p, TOP, BOTTOM, p, BOTTOM + 18, value);
        }
}

static void draw_series(const series *s, size_t index, const axis *x, const axis *y) {
    const char *color = colors[index % 8], *dash = dashes[index / 8 % 3];
    printf("<polyline fill='none' stroke='%s' stroke-width='1.8' stroke-dasharray='%s' points='",
           color, dash);
    for (size_t i = 0; i < s->count; ++i)
        printf("%.1f,%.1f ", place(x, s->x[i]), place(y, s->y[i]));
    puts("'/>");
    for (size_t i = 0; i < s->count; ++i)
        printf("<circle cx='%.1f' cy='%.1f' r='3.2' fill='%s'><title>%g: %g</title></circle>\n",
               place(x, s->x[i]), place(y, s->y[i]), color, s->x[i], s->y[i]);
    const int line = TOP + 10 + 18 * (int)index;
    printf("<line x1='%d' x2='%d' y1='%d' y2='%d' stroke='%s' stroke-width='1.8' "
           "stroke-dasharray='%s'/><text x='%d' y='%d'>",
           RIGHT + 14, RIGHT + 40, line, line, color, dash, RIGHT + 46, line + 4);
    print_text(s->name);
    puts("</text>");
}

int main(int argc, char **argv) {
    static series all[MAX_SERIES];
    json_error_t error;
    if (argc < 2 || argc > 3) {
        fputs("usage: chart TABLE.json [FIGURE]\n", stderr);
        return 2;
    }
    const char *figure = argc == 3 ? argv[2] : "x_floor";
    json_t *table = json_load_file(argv[1], 0, &error);
    if (!table) {
        fprintf(stderr, "chart: %s:%d: %s\n", argv[1], error.line, error.text);
        return 1;
    }
    const size_t count = collect(table, figure, all);
    if (count == 0) {
        fprintf(stderr, "chart: %s: no result has a %s above zero\n", argv[1], figure);
        json_decref(table);
        return 1;
    }
    const axis x = make_axis(all, count, 0), y = make_axis(all, count, 1);
    printf("<svg xmlns='http://www.w3.org/2000/svg' width='%d' height='%d' "
           "font-family='sans-serif' font-size='12'>\n<rect width='100%%' height='100%%' "
           "fill='white'/>\n<text x='%d' y='26' font-size='15'>",
           WIDTH, HEIGHT, LEFT);
    print_text(string_of(table, "title"));
    puts("</text>");
    draw_ticks(&x, 0);
    draw_ticks(&y, 1);
    printf("<rect x='%d' y='%d' width='%d' height='%d' fill='none' stroke='#444'/>\n"
           "<text x='%d' y='%d' text-anchor='middle'>",
           LEFT, TOP, RIGHT - LEFT, BOTTOM - TOP, (LEFT + RIGHT) / 2, BOTTOM + 40);
    print_text(string_of(table, "x"));
    printf("</text>\n<text x='%d' y='%d' transform='rotate(-90 18 %d)' text-anchor='middle'>", 18,
           (TOP + BOTTOM) / 2, (TOP + BOTTOM) / 2);
    print_text(figure);
    puts("</text>");
    for (size_t i = 0; i < count; ++i)
        draw_series(&all[i], i, &x, &y);
    puts("</svg>");
    json_decref(table);
    return 0;
}
