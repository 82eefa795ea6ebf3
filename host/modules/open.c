/* SPDX-License-Identifier: MIT
 *
 * Opening a module that the plan chose, and the checks that make what it says at run time equal to
 * what the plan read in its note. A module that fails them is closed and refused.
 */
#define _POSIX_C_SOURCE 200809L
#include "modules/modules_list.h"

#include <dlfcn.h>
#include <stdlib.h>
#include <string.h>

/* Descriptor and note must say the same. Both are written as JSON by this host, so that members
 * which only a newer SDK knows do not count as a difference. */
static strata_result compare_note(const modules_entry *entry, const strata_module *descriptor,
                                  base_error *err) {
    note_arena arena = {0};
    modules_note note;
    char *listed = NULL, *opened = NULL;
    strata_result result = descriptor_note(descriptor, entry->path, &arena, &note, err);
    if (result == STRATA_OK) {
        listed = note_json(&entry->note, err);
        opened = note_json(&note, err);
        if (!listed || !opened)
            result = STRATA_ERROR_OUT_OF_HOST_MEMORY;
    }
    if (result == STRATA_OK && strcmp(listed, opened) != 0) {
        size_t at = 0;
        while (listed[at] == opened[at])
            at++;
        size_t from = at > 40 ? at - 40 : 0;
        result = base_fail(err, STRATA_ERROR_MODULE,
                           "the note differs from the descriptor: \"%.60s\" in the note, \"%.60s\" "
                           "in the descriptor",
                           listed + from, opened + from);
    }
    free(listed);
    free(opened);
    note_arena_free(&arena);
    return result;
}

/* Fills entry->handle and descriptor, or neither. */
static strata_result open_file(modules_entry *entry, base_error *err) {
    char *place = base_format("%s%s", strchr(entry->path, '/') ? "" : "./", entry->path);
    if (!place)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    void *handle = dlopen(place, RTLD_NOW | RTLD_LOCAL);
    free(place);
    if (!handle)
        return base_fail(err, STRATA_ERROR_MODULE, "%s", dlerror());
    const strata_module *descriptor = dlsym(handle, STRATA_MODULE_SYMBOL);
    strata_result result = descriptor ? compare_note(entry, descriptor, err)
                                      : base_fail(err, STRATA_ERROR_MODULE, "%s", dlerror());
    if (result != STRATA_OK) {
        dlclose(handle);
        return result;
    }
    entry->handle = handle;
    entry->descriptor = descriptor;
    return STRATA_OK;
}

static strata_result refuse_entry(modules *m, modules_entry *entry, const char *reason,
                                  base_error *err) {
    entry->refused = 1;
    return modules_list_refuse(m, entry->path, reason, err);
}

/* Opens the entry that holds `note`, unless it is open, and logs it. */
static strata_result open_entry(modules *m, const modules_note *note, modules_entry **out,
                                base_error *err) {
    modules_entry *entry = NULL;
    for (size_t i = 0; i < m->count; i++)
        if (&m->entries[i]->note == note)
            entry = m->entries[i];
    *out = entry;
    if (!entry) {
        base_fail(err, STRATA_ERROR_INTERNAL, "modules: a note without an entry");
        return STRATA_ERROR_INTERNAL;
    }
    if (entry->handle)
        return STRATA_OK;
    const char **opened =
        base_grow(m->opened, &m->opened_capacity, m->opened_count, sizeof *opened);
    if (!opened)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "modules: out of memory");
    m->opened = opened;
    base_error reason = {0};
    strata_result result = open_file(entry, &reason);
    if (result != STRATA_OK) {
        if (result != STRATA_ERROR_OUT_OF_HOST_MEMORY)
            refuse_entry(m, entry, reason.text, err);
        return base_fail(err, result, "module %s: %s: %s", note->id, entry->path, reason.text);
    }
    m->opened[m->opened_count++] = note->id;
    base_log(BASE_LOG_INFO, "module opened: %s: %s", note->id, entry->path);
    return STRATA_OK;
}

strata_result modules_open_technique(modules *m, const char *id, const strata_technique **out,
                                     base_error *err) {
    *out = NULL;
    const modules_technique_note *note = modules_find_technique(m, id);
    if (!note)
        return base_fail(err, STRATA_ERROR_NOT_FOUND, "no module offers the technique \"%.80s\"",
                         id);
    modules_entry *entry;
    strata_result result = open_entry(m, note->module, &entry, err);
    /* Equal to the note, so the index is valid there too. */
    if (result == STRATA_OK)
        *out = entry->descriptor->techniques[note - note->module->techniques];
    return result;
}

strata_result modules_open_effect(modules *m, const char *id, const strata_effect **out,
                                  base_error *err) {
    *out = NULL;
    const modules_effect_note *note = modules_find_effect(m, id);
    if (!note)
        return base_fail(err, STRATA_ERROR_NOT_FOUND, "no module offers the effect \"%.80s\"", id);
    modules_entry *entry;
    strata_result result = open_entry(m, note->module, &entry, err);
    if (result == STRATA_OK)
        *out = entry->descriptor->effects[note - note->module->effects];
    return result;
}

strata_result modules_refuse(modules *m, const char *module_id, const char *reason,
                             base_error *err) {
    for (size_t i = 0; i < m->count; i++)
        if (!m->entries[i]->refused && strcmp(m->entries[i]->note.id, module_id) == 0)
            return refuse_entry(m, m->entries[i], reason, err);
    return base_fail(err, STRATA_ERROR_NOT_FOUND, "no module \"%.80s\"", module_id);
}
