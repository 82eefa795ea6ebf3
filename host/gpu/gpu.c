/* SPDX-License-Identifier: MIT
 *
 * The device in front of its backends: opening and closing, facts, runtime includes and defines,
 * and the wording of errors. Objects, passes and programs are in the files beside this one.
 */
#include "gpu/gpu_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- errors --------------------------------------------------------------------------------- */

const char *gpu_code_text(gpu_code code) {
    static const char *const texts[] = {
#define X(name, text) text,
        GPU_ERRORS(X)
#undef X
    };
    return (size_t)code < BASE_COUNT(texts) ? texts[code] : "unknown error";
}

strata_result gpu_code_result(gpu_code code) {
    switch (code) {
    case GPU_ERROR_NONE:
        return STRATA_OK;
    case GPU_ERROR_STATE:
        return STRATA_ERROR_INVALID_STATE;
    case GPU_ERROR_BUFFER_LIMIT:
        return STRATA_ERROR_OVERFLOW;
    case GPU_ERROR_PROGRAM_COMPILE:
        return STRATA_ERROR_SHADER;
    case GPU_ERROR_PROGRAM_BLOCKS:
    case GPU_ERROR_ORDERED_MISSING:
        return STRATA_ERROR_UNSUPPORTED;
    case GPU_ERROR_MEMORY:
        return STRATA_ERROR_OUT_OF_DEVICE_MEMORY;
    case GPU_ERROR_LOST:
        return STRATA_ERROR_DEVICE_LOST;
    default:
        return STRATA_ERROR_INVALID_ARGUMENT;
    }
}

strata_result gpu_fail(gpu *g, base_error *err, gpu_code code, const char *format, ...) {
    char detail[384];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    g->last_code = code;
    return base_fail(err, gpu_code_result(code), "%s: %s", detail, gpu_code_text(code));
}

void gpu_record_fail(gpu *g, gpu_code code, const char *format, ...) {
    char detail[256];
    va_list arguments;
    if (g->frame_error.result != STRATA_OK)
        return;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    g->last_code = g->frame_code = code;
    base_fail(&g->frame_error, gpu_code_result(code), "%s: pass '%s': %s: %s", g->where_owner,
              g->where_label, detail, gpu_code_text(code));
}

strata_result gpu_backend_result(gpu *g, base_error *err, strata_result result) {
    if (result == STRATA_OK)
        return STRATA_OK;
    if (result == STRATA_ERROR_DEVICE_LOST) {
        g->lost = 1;
        g->last_code = GPU_ERROR_LOST;
    } else if (result == STRATA_ERROR_OUT_OF_DEVICE_MEMORY ||
               result == STRATA_ERROR_OUT_OF_HOST_MEMORY) {
        g->last_code = GPU_ERROR_MEMORY;
    } else if (result == STRATA_ERROR_SHADER) {
        g->last_code = GPU_ERROR_PROGRAM_COMPILE;
    }
    return base_fail(err, result, "%s: the driver failed (%d)", g->backend->name, (int)result);
}

strata_result gpu_take(gpu *g, base_error *err, const void *from, void *to, size_t size,
                       const char *name) {
    uint32_t given = 0;
    if (!from)
        return gpu_fail(g, err, GPU_ERROR_VALUE, "%s is NULL", name);
    memcpy(&given, from, sizeof given);
    if (given < size || given > 65536)
        return gpu_fail(g, err, GPU_ERROR_STRUCT_SIZE, "%s of %u bytes", name, given);
    for (size_t i = size; i < given; i++)
        if (((const unsigned char *)from)[i])
            return gpu_fail(g, err, GPU_ERROR_STRUCT_SIZE, "%s: byte %zu of %u", name, i, given);
    memcpy(to, from, size);
    return STRATA_OK;
}

/* ---- open and close ------------------------------------------------------------------------- */

static const gpu_backend *const backends[] = {
    &gpu_backend_vulkan,
    &gpu_backend_gl,
    &gpu_backend_null,
};

static int names_match(const char *wanted, const char *name) {
    return wanted ? strcmp(wanted, name) == 0 : strcmp(name, "null") != 0;
}

/* Without a name: the first that opens, in the order of the table, but never null. */
static strata_result open_backend(gpu *g, const gpu_open_info *info, base_error *err) {
    base_error first = {0};
    for (size_t i = 0; i < BASE_COUNT(backends); i++) {
        base_error attempt = {0};
        if (!names_match(info->backend, backends[i]->name))
            continue;
        g->backend = backends[i];
        strata_result result = g->backend->open(info, &g->self, &g->caps, &attempt);
        if (result == STRATA_OK)
            return STRATA_OK;
        g->self = NULL;
        base_fail(&first, result, "%s: %s", backends[i]->name,
                  attempt.text[0] ? attempt.text : "cannot be opened");
    }
    if (first.result != STRATA_OK)
        return base_fail(err, first.result, "%s", first.text);
    return base_fail(err, STRATA_ERROR_NOT_FOUND, "backend '%s' is not known",
                     info->backend ? info->backend : "");
}

static const char *const fact_words[] = {"lacks:", "claims:"}; /* by the value that they give */

/* Splits the first of "lacks:FACT,claims:FACT.." off: where its fact begins and how long it is. The
 * value that the fact gets, or -1 where this is none. */
static int split_fact(const char *text, const char **fact, size_t *length) {
    for (int value = 0; value < 2; value++) {
        const size_t skipped = strlen(fact_words[value]);
        if (strncmp(text, fact_words[value], skipped) == 0) {
            *fact = text + skipped;
            *length = strcspn(*fact, ",");
            return *length > 0 ? value : -1;
        }
    }
    return -1;
}

static int are_facts(const char *text) {
    const char *fact;
    size_t length;
    while (split_fact(text, &fact, &length) >= 0) {
        if (fact[length] == '\0')
            return 1;
        text = fact + length + 1;
    }
    return 0;
}

/* What was injected for this fact: 0 or 1, or -1 for nothing. */
static int injected_fact(const gpu *g, const char *id) {
    const char *text = g->injected_facts, *fact;
    size_t length;
    int value;
    while ((value = split_fact(text, &fact, &length)) >= 0) {
        if (strlen(id) == length && strncmp(fact, id, length) == 0)
            return value;
        text = fact + length + (fact[length] == ',');
    }
    return -1;
}

/* "allocation:N" or "lost:N", N >= 1, or facts. */
static strata_result parse_inject(gpu *g, const char *text, base_error *err) {
    static const struct {
        const char *name;
        gpu_inject inject;
    } counted[] = {{"allocation:", GPU_INJECT_ALLOCATION}, {"lost:", GPU_INJECT_LOST}};
    if (!text || !text[0])
        return STRATA_OK;
    if (are_facts(text) && strlen(text) < sizeof g->injected_facts) {
        snprintf(g->injected_facts, sizeof g->injected_facts, "%s", text);
        return STRATA_OK;
    }
    for (size_t i = 0; i < BASE_COUNT(counted); i++) {
        const size_t length = strlen(counted[i].name);
        char *end = NULL;
        if (strncmp(text, counted[i].name, length) != 0 || text[length] < '0' || text[length] > '9')
            continue;
        g->inject = counted[i].inject;
        g->inject_at = strtoull(text + length, &end, 10);
        if (g->inject_at > 0 && !*end)
            return STRATA_OK;
    }
    return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT,
                     "inject '%s' is none of allocation:N, lost:N, lacks:FACT and claims:FACT",
                     text);
}

static strata_result keep_text(const char *text, char **copy, base_error *err) {
    *copy = text ? base_strdup(text) : NULL;
    return text && !*copy ? base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory")
                          : STRATA_OK;
}

strata_result gpu_open(const gpu_open_info *info, gpu **out, base_error *err) {
    *out = NULL;
    gpu *g = base_calloc(1, sizeof *g);
    if (!g)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a device");
    g->profile = info->profile;
    g->where_owner = g->where_label = "";
    memset(g->selftests, -1, sizeof g->selftests);
    strata_result result = parse_inject(g, info->inject, err);
    if (result == STRATA_OK)
        result = keep_text(info->cache_dir, &g->cache_dir, err);
    if (result == STRATA_OK)
        result = keep_text(info->device, &g->device_name, err);
    if (result == STRATA_OK)
        result = open_backend(g, info, err);
    if (result != STRATA_OK) {
        free(g->cache_dir);
        free(g->device_name);
        free(g);
        return result;
    }
    *out = g;
    return STRATA_OK;
}

static void free_texts(gpu_text *text) {
    while (text) {
        gpu_text *next = text->next;
        free(text->name);
        free(text->text);
        free(text);
        text = next;
    }
}

static void free_globals(gpu_global *global) {
    while (global) {
        gpu_global *next = global->next;
        free(global);
        global = next;
    }
}

static void free_owners(gpu_owner *owner) {
    while (owner) { /* history went with the owner's last scope */
        gpu_owner *next = owner->next;
        free(owner);
        owner = next;
    }
}

void gpu_close(gpu *g) {
    if (!g)
        return;
    if (g->open)
        gpu_flush(g);
    while (g->scopes)
        gpu_scope_end(g->scopes);
    gpu_programs_free(g);
    g->backend->close(g->self);
    free_texts(g->includes);
    free_texts(g->defines);
    free_globals(g->globals);
    free_owners(g->owners);
    free(g->slots);
    free(g->timings);
    free(g->cache_dir);
    free(g->device_name);
    free(g);
}

void gpu_describe(const gpu *g, gpu_device_info *info) {
    *info = (gpu_device_info){0};
    snprintf(info->backend, sizeof info->backend, "%s", g->backend->name);
    snprintf(info->name, sizeof info->name, "%s", g->caps.name);
    snprintf(info->driver, sizeof info->driver, "%s", g->caps.driver);
}

void gpu_enumerate(void (*found)(void *user, const gpu_device_info *info, uint32_t index),
                   void *user) {
    for (size_t i = 0; i < BASE_COUNT(backends); i++)
        if (backends[i]->enumerate && backends[i] != &gpu_backend_null)
            backends[i]->enumerate(found, user);
}

const char *gpu_null_log(const gpu *g) {
    return g->backend->log ? g->backend->log(g->self) : NULL;
}

/* ---- facts ---------------------------------------------------------------------------------- */

/* The null backend only logs; nothing is to be found out there. */
static int has_ordered_attachments(gpu *g) {
    if (!g->caps.raster_order_attachments && !g->caps.framebuffer_fetch)
        return 0;
    return g->backend == &gpu_backend_null || g->selftest_running ||
           gpu_selftest(g, "selftest.ordered_attachments");
}

uint64_t gpu_fact(gpu *g, const char *id) {
    const gpu_backend_caps *caps = &g->caps;
    const struct {
        const char *id;
        uint64_t value;
    } facts[] = {
        {"limit.storage_range", caps->storage_range},
        {"limit.texels", caps->texels},
        {"limit.image_size", caps->image_size},
        {"limit.groups", caps->groups},
        {"limit.memory", caps->memory},
        {"limit.subgroup", caps->subgroup},
        {"limit.samples", caps->samples},
        {"limit.storage_blocks", caps->storage_blocks},
        {"device.software", caps->software},
        {"feature.int64", caps->int64},
        {"feature.int64_atomics", caps->int64_atomics},
        {"feature.fragment_interlock", caps->fragment_interlock},
        {"feature.raster_order_attachments", caps->raster_order_attachments},
        {"feature.framebuffer_fetch", caps->framebuffer_fetch},
        {"feature.subgroup_ballot", caps->subgroup_ballot},
        {"feature.stencil_export", caps->stencil_export},
    };
    const int injected = id ? injected_fact(g, id) : 0;
    if (injected >= 0)
        return (uint64_t)injected;
    if (strcmp(id, "ordered_attachments") == 0)
        return (uint64_t)has_ordered_attachments(g);
    if (strcmp(id, "ordered_access") == 0)
        return gpu_fact(g, "ordered_attachments") || gpu_fact(g, "selftest.ordered_rmw") ||
               gpu_fact(g, "selftest.interlock");
    for (size_t i = 0; i < BASE_COUNT(facts); i++)
        if (strcmp(id, facts[i].id) == 0)
            return facts[i].value;
    if (strncmp(id, "selftest.", 9) == 0)
        return (uint64_t)gpu_selftest(g, id);
    return 0;
}

int gpu_reads_texels(gpu *g) {
    return gpu_fact(g, "device.software") && g->caps.texels >= g->caps.storage_range / 4;
}

/* ---- runtime includes, defines, globals ------------------------------------------------------ */

/* Sets, replaces or (text NULL) removes an entry; order of first setting is kept. */
static strata_result set_text(gpu_text **list, const char *name, const char *text,
                              base_error *err) {
    gpu_text **at = list;
    while (*at && strcmp((*at)->name, name) != 0)
        at = &(*at)->next;
    if (!text) {
        gpu_text *gone = *at;
        if (gone) {
            *at = gone->next;
            gone->next = NULL;
            free_texts(gone);
        }
        return STRATA_OK;
    }
    char *copy = base_strdup(text);
    if (*at && copy) {
        free((*at)->text);
        (*at)->text = copy;
        return STRATA_OK;
    }
    gpu_text *entry = copy ? base_calloc(1, sizeof *entry) : NULL;
    if (entry)
        entry->name = base_strdup(name);
    if (!entry || !entry->name) {
        free(entry);
        free(copy);
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory", name);
    }
    entry->text = copy;
    *at = entry;
    return STRATA_OK;
}

strata_result gpu_set_include(gpu *g, const char *name, const char *text, base_error *err) {
    if (!name || !name[0])
        return gpu_fail(g, err, GPU_ERROR_VALUE, "the name of an include");
    return set_text(&g->includes, name, text, err);
}

strata_result gpu_set_define(gpu *g, const char *name, const char *value, base_error *err) {
    if (!name || !name[0] || strpbrk(name, " \t\r\n=") || (value && strpbrk(value, "\r\n")))
        return gpu_fail(g, err, GPU_ERROR_VALUE, "define '%s'", name ? name : "");
    return set_text(&g->defines, name, value, err);
}

strata_result gpu_set_global(gpu *g, const char *name, const strata_bind *bind, base_error *err) {
    gpu_global *global = base_calloc(1, sizeof *global);
    strata_result result;
    if (!global)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a global");
    if (!name || !name[0] || strlen(name) >= sizeof global->name)
        result = gpu_fail(g, err, GPU_ERROR_VALUE, "the name of a global");
    else
        result = bind ? gpu_take(g, err, bind, &global->bind, sizeof *bind, name) : STRATA_OK;
    if (result != STRATA_OK) {
        free(global);
        return result;
    }
    gpu_global **at = &g->globals;
    while (*at && strcmp((*at)->name, name) != 0)
        at = &(*at)->next;
    if (*at) {
        gpu_global *old = *at;
        *at = old->next;
        free(old);
    }
    if (!bind) {
        free(global);
        return STRATA_OK;
    }
    snprintf(global->name, sizeof global->name, "%s", name);
    global->bind.name = global->name;
    global->next = g->globals;
    g->globals = global;
    return STRATA_OK;
}
