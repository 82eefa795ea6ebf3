/* SPDX-License-Identifier: MIT
 *
 * From an author's GLSL to one text that the compiler takes: #version, what differs between targets
 * (strata/compat.glsl), defines, and #include pasted in, with #line so that an error names the
 * author's file and line. Includes are found in the shared library, then among the runtime ones,
 * then among the module's own; guards in the files make them once-only.
 */
#include "gpu/gpu_internal.h"

#include <stdlib.h>
#include <string.h>

#include "library_glsl.h"

#define DEEPEST_INCLUDE 32
#define LONGEST_TEXT    ((size_t)16 << 20)

typedef struct expansion {
    gpu *g;
    gpu_source *out;
    const strata_glsl *const *own;      /* NULL-terminated, or NULL */
    const char *stack[DEEPEST_INCLUDE]; /* paths that are being pasted */
    uint32_t depth;
    base_error *err;
} expansion;

const strata_glsl *const *gpu_library(void) {
    return library_glsl_all;
}

const strata_glsl *gpu_library_find(const char *path) {
    for (const strata_glsl *const *entry = library_glsl_all; *entry; entry++)
        if (strcmp((*entry)->path, path) == 0)
            return *entry;
    return NULL;
}

void gpu_source_free(gpu_source *source) {
    for (size_t i = 0; i < source->path_count; i++)
        free(source->paths[i]);
    free(source->paths);
    base_text_free(&source->text);
    *source = (gpu_source){0};
}

/* Number of the source, as #line names it; files that come again keep their number. */
static strata_result add_path(expansion *e, const char *path, uint32_t *number) {
    gpu_source *out = e->out;
    for (size_t i = 0; i < out->path_count; i++)
        if (strcmp(out->paths[i], path) == 0) {
            *number = (uint32_t)i;
            return STRATA_OK;
        }
    char **paths = base_grow(out->paths, &out->path_capacity, out->path_count, sizeof *paths);
    if (paths)
        out->paths = paths;
    char *copy = paths ? base_strdup(path) : NULL;
    if (!copy)
        return base_fail(e->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", path);
    *number = (uint32_t)out->path_count;
    out->paths[out->path_count++] = copy;
    return STRATA_OK;
}

/* ---- finding -------------------------------------------------------------------------------- */

static int ends_with_name(const char *path, const char *name) {
    size_t length = strlen(path), tail = strlen(name);
    return length >= tail && strcmp(path + length - tail, name) == 0 &&
           (length == tail || path[length - tail - 1] == '/');
}

static int find_include(const expansion *e, const char *name, strata_glsl *found) {
    for (const strata_glsl *const *entry = gpu_library(); *entry; entry++)
        if (strcmp((*entry)->path, name) == 0) {
            *found = **entry;
            return 1;
        }
    for (const gpu_text *text = e->g->includes; text; text = text->next)
        if (strcmp(text->name, name) == 0) {
            *found = (strata_glsl){.text = text->text, .path = text->name};
            return 1;
        }
    for (const strata_glsl *const *entry = e->own; entry && *entry; entry++)
        if (ends_with_name((*entry)->path, name)) {
            *found = **entry;
            return 1;
        }
    return 0;
}

/* Where a comment that spans lines leaves the text: 1 inside, 0 outside, after this line. */
static int comment_after(const char *line, const char *end, int inside) {
    for (const char *at = line; at < end; at++) {
        if (inside) {
            if (at[0] == '*' && at + 1 < end && at[1] == '/') {
                inside = 0;
                at++;
            }
        } else if (at[0] == '/' && at + 1 < end && at[1] == '/') {
            return 0;
        } else if (at[0] == '/' && at + 1 < end && at[1] == '*') {
            inside = 1;
            at++;
        }
    }
    return inside;
}

static const char *skip_blanks(const char *at, const char *end) {
    while (at < end && (*at == ' ' || *at == '\t'))
        at++;
    return at;
}

/* 1: the line is an include and *name has what it names; -1: it is malformed; 0: another line. */
static int parse_include(const char *line, const char *end, char *name, size_t size) {
    const char *at = skip_blanks(line, end);
    if (at == end || *at != '#')
        return 0;
    at = skip_blanks(at + 1, end);
    if (end - at < 7 || strncmp(at, "include", 7) != 0)
        return 0;
    at = skip_blanks(at + 7, end);
    if (at == end || (*at != '"' && *at != '<'))
        return -1;
    const char *close = memchr(at + 1, *at == '"' ? '"' : '>', (size_t)(end - at - 1));
    size_t length = close ? (size_t)(close - at - 1) : 0;
    if (length == 0 || length >= size)
        return -1;
    memcpy(name, at + 1, length);
    name[length] = '\0';
    return 1;
}

/* ---- pasting -------------------------------------------------------------------------------- */

static strata_result paste(expansion *e, const strata_glsl *glsl);

static strata_result paste_include(expansion *e, const char *path, uint32_t line,
                                   const char *name) {
    strata_glsl found;
    if (!find_include(e, name, &found))
        return base_fail(e->err, STRATA_ERROR_SHADER, "%s:%u: include \"%s\" is not found", path,
                         line, name);
    for (uint32_t i = 0; i < e->depth; i++)
        if (strcmp(e->stack[i], found.path) == 0)
            return base_fail(e->err, STRATA_ERROR_SHADER, "%s:%u: \"%s\" includes itself", path,
                             line, name);
    if (e->depth == DEEPEST_INCLUDE)
        return base_fail(e->err, STRATA_ERROR_SHADER,
                         "%s:%u: includes are more than %d deep at \"%s\"", path, line,
                         DEEPEST_INCLUDE, name);
    return paste(e, &found);
}

static strata_result paste_lines(expansion *e, const strata_glsl *glsl, uint32_t number) {
    base_text *text = &e->out->text;
    char name[256];
    int comment = 0;
    uint32_t line_number = 1;
    for (const char *line = glsl->text; *line; line_number++) {
        size_t length = strcspn(line, "\n");
        const char *end = line + length;
        int include = comment ? 0 : parse_include(line, end, name, sizeof name);
        comment = comment_after(line, end, comment);
        if (include < 0)
            return base_fail(e->err, STRATA_ERROR_SHADER, "%s:%u: malformed #include", glsl->path,
                             line_number);
        if (include) {
            strata_result result = paste_include(e, glsl->path, line_number, name);
            if (result != STRATA_OK)
                return result;
            base_text_add(text, "#line %u %u\n", line_number + 1, number);
        } else {
            base_text_append(text, line, length);
            base_text_append(text, "\n", 1);
        }
        line = *end ? end + 1 : end;
    }
    return STRATA_OK;
}

static strata_result paste(expansion *e, const strata_glsl *glsl) {
    uint32_t number = 0;
    strata_result result = add_path(e, glsl->path, &number);
    if (result != STRATA_OK)
        return result;
    e->stack[e->depth++] = glsl->path;
    base_text_add(&e->out->text, "#line 1 %u\n", number);
    result = paste_lines(e, glsl, number);
    e->depth--;
    if (result == STRATA_OK && e->out->text.length > LONGEST_TEXT)
        return base_fail(e->err, STRATA_ERROR_SHADER, "%s: too long with its includes", glsl->path);
    return result;
}

static strata_result paste_library(expansion *e, const char *path) {
    strata_glsl found;
    for (const strata_glsl *const *entry = gpu_library(); *entry; entry++)
        if (strcmp((*entry)->path, path) == 0)
            return paste(e, *entry);
    if (find_include(e, path, &found)) /* tests bring a vertex stage of their own */
        return paste(e, &found);
    return base_fail(e->err, STRATA_ERROR_NOT_FOUND, "%s: not in the shader library", path);
}

static strata_result add_define(expansion *e, const char *define) {
    const char *equals = define ? strchr(define, '=') : NULL;
    size_t length = !define ? 0 : equals ? (size_t)(equals - define) : strlen(define);
    if (length == 0 || strcspn(define, " \t\r\n") < length || strpbrk(define, "\r\n"))
        return gpu_fail(e->g, e->err, GPU_ERROR_VALUE, "define '%s'", define ? define : "");
    base_text_add(&e->out->text, "#define %.*s %s\n", (int)length, define,
                  equals ? equals + 1 : "1");
    return STRATA_OK;
}

static strata_result add_prologue(expansion *e, const strata_program_desc *desc, uint32_t stage) {
    uint32_t number;
    base_text *text = &e->out->text;
    strata_result result = add_path(e, desc->label, &number);
    base_text_add(text, "#version 460\n#define STRATA_STAGE_%s 1\n#line 1 0\n",
                  stage == GPU_STAGE_VERTEX     ? "VERTEX"
                  : stage == GPU_STAGE_FRAGMENT ? "FRAGMENT"
                                                : "COMPUTE");
    if (stage == GPU_STAGE_FRAGMENT && e->g->caps.fragment_interlock)
        base_text_add(text, "#define STRATA_HAS_INTERLOCK 1\n");
    if (gpu_reads_texels(e->g))
        base_text_add(text, "#define STRATA_TEXELS 1\n");
    if (desc->kind == STRATA_PROGRAM_SCENE && gpu_fact(e->g, "device.software"))
        base_text_add(text, "#define STRATA_FLAT 1\n");
    for (const gpu_text *define = e->g->defines; define; define = define->next)
        base_text_add(text, "#define %s %s\n", define->name, define->text);
    for (uint32_t i = 0; result == STRATA_OK && i < desc->define_count; i++)
        result = add_define(e, desc->defines[i]);
    return result == STRATA_OK ? paste_library(e, "strata/compat.glsl") : result;
}

strata_result gpu_shader_expand(gpu *g, const strata_program_desc *desc, uint32_t stage,
                                gpu_source *out, base_error *err) {
    expansion e = {.g = g, .out = out, .own = desc->includes, .err = err};
    strata_result result = add_prologue(&e, desc, stage);
    if (result == STRATA_OK) {
        if (stage != GPU_STAGE_VERTEX)
            result = paste(&e, desc->source);
        else if (desc->kind == STRATA_PROGRAM_SCENE)
            result = paste_library(&e, "strata/vertex.glsl");
        else
            result = paste_library(&e, "strata/fullscreen.glsl");
    }
    if (result == STRATA_OK && out->text.failed)
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", desc->label);
    if (result != STRATA_OK)
        gpu_source_free(out);
    return result;
}
