/* SPDX-License-Identifier: MIT
 *
 * Scanning: from a search path to usable notes and refusals, with nothing opened. What is found
 * first counts; the order is the path's, then the file name's, so that it never depends on the file
 * system. Opening is in open.c.
 */
#define _GNU_SOURCE
#include "modules/modules_list.h"

#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define FILES_MAX 4096 /* shared objects in one folder */

static strata_result out_of_memory(base_error *err) {
    return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "modules: out of memory");
}

strata_result modules_list_refuse(modules *m, const char *path, const char *reason,
                                  base_error *err) {
    /* The reader's lines name the file themselves; here it stands beside the reason. */
    size_t prefix = strlen(path);
    if (strncmp(reason, path, prefix) == 0 && strncmp(reason + prefix, ": ", 2) == 0)
        reason += prefix + 2;
    modules_refusal *refused =
        base_grow(m->refused, &m->refused_capacity, m->refused_count, sizeof *refused);
    if (refused)
        m->refused = refused;
    size_t path_size = strlen(path) + 1, reason_size = strlen(reason) + 1;
    char *path_copy = note_alloc(&m->texts, path_size, 1);
    char *reason_copy = note_alloc(&m->texts, reason_size, 1);
    if (!refused || !path_copy || !reason_copy)
        return out_of_memory(err);
    memcpy(path_copy, path, path_size);
    memcpy(reason_copy, reason, reason_size);
    m->refused[m->refused_count++] = (modules_refusal){.path = path_copy, .reason = reason_copy};
    base_log(BASE_LOG_INFO, "module refused: %s: %s", path, reason);
    return STRATA_OK;
}

static void entry_free(modules_entry *entry) {
    if (!entry)
        return;
    note_arena_free(&entry->arena);
    free(entry->path);
    free(entry);
}

/* The first usable module whose id, or one of whose offers' ids, `note` has too. */
static strata_result check_unique(const modules *m, const modules_note *note, base_error *err) {
    for (size_t i = 0; i < m->count; i++) {
        const modules_note *other = &m->entries[i]->note;
        if (strcmp(other->id, note->id) == 0)
            return base_fail(err, STRATA_ERROR_MODULE, "module %s was already found at %s",
                             note->id, other->path);
    }
    for (uint32_t i = 0; i < note->technique_count; i++) {
        const modules_technique_note *other = modules_find_technique(m, note->techniques[i].id);
        if (other)
            return base_fail(err, STRATA_ERROR_MODULE, "technique %s is already offered by %s",
                             other->id, other->module->path);
    }
    for (uint32_t i = 0; i < note->effect_count; i++) {
        const modules_effect_note *other = modules_find_effect(m, note->effects[i].id);
        if (other)
            return base_fail(err, STRATA_ERROR_MODULE, "effect %s is already offered by %s",
                             other->id, other->module->path);
    }
    return STRATA_OK;
}

static int compare_entries(const void *a, const void *b) {
    const modules_entry *const *left = a, *const *right = b;
    return strcmp((*left)->note.id, (*right)->note.id);
}

/* Was this very file listed before, under another name? */
static int is_known_file(const modules *m, const struct stat *status) {
    for (size_t i = 0; i < m->count; i++)
        if (m->entries[i]->device == status->st_dev && m->entries[i]->inode == status->st_ino)
            return 1;
    return 0;
}

static strata_result read_entry(const modules *m, modules_entry *entry, base_error *reason) {
    char *text;
    strata_result result = note_elf_read(entry->path, &text, reason);
    if (result == STRATA_OK) {
        result = note_parse(text, entry->path, &entry->arena, &entry->note, reason);
        free(text);
    }
    if (result == STRATA_OK)
        result = note_check_version(entry->note.abi_version, entry->note.min_host_version,
                                    STRATA_ABI_VERSION, reason);
    return result == STRATA_OK ? check_unique(m, &entry->note, reason) : result;
}

/* Lists one file, as usable or as refused. Fails for want of memory only. */
static strata_result scan_file(modules *m, const char *folder, const char *name, base_error *err) {
    struct stat status;
    modules_entry *entry = base_calloc(1, sizeof *entry);
    if (entry)
        entry->path = base_format("%s/%s", folder, name);
    modules_entry **entries = base_grow(m->entries, &m->capacity, m->count, sizeof *entries);
    if (entries)
        m->entries = entries;
    if (!entry || !entry->path || !entries) {
        entry_free(entry);
        return out_of_memory(err);
    }
    base_error reason = {0};
    if (stat(entry->path, &status) != 0) {
        base_fail(&reason, STRATA_ERROR_IO, "%s: %s", entry->path, strerror(errno));
    } else if (is_known_file(m, &status)) {
        entry_free(entry);
        return STRATA_OK;
    } else {
        entry->device = status.st_dev;
        entry->inode = status.st_ino;
        read_entry(m, entry, &reason);
    }
    if (reason.result == STRATA_OK) {
        m->entries[m->count++] = entry;
        return STRATA_OK;
    }
    strata_result result = reason.result == STRATA_ERROR_OUT_OF_HOST_MEMORY
                               ? out_of_memory(err)
                               : modules_list_refuse(m, entry->path, reason.text, err);
    entry_free(entry);
    return result;
}

static int is_shared_object(const struct dirent *file) {
    size_t length = strlen(file->d_name);
    return length > 3 && file->d_name[0] != '.' && strcmp(file->d_name + length - 3, ".so") == 0;
}

static int compare_names(const struct dirent **a, const struct dirent **b) {
    return strcmp((*a)->d_name, (*b)->d_name);
}

static strata_result scan_folder(modules *m, const char *folder, base_error *err) {
    struct dirent **files;
    int count = scandir(folder, &files, is_shared_object, compare_names);
    if (count < 0)
        return base_fail(err, STRATA_ERROR_NOT_FOUND, "module folder %s: %s", folder,
                         strerror(errno));
    strata_result result = STRATA_OK;
    if (count > FILES_MAX)
        result = base_fail(err, STRATA_ERROR_OVERFLOW, "module folder %s: more than %d modules",
                           folder, FILES_MAX);
    for (int i = 0; i < count; i++) {
        if (result == STRATA_OK)
            result = scan_file(m, folder, files[i]->d_name, err);
        free(files[i]);
    }
    free(files);
    return result;
}

static strata_result scan_path(modules *m, const char *path, base_error *err) {
    char *copy = base_strdup(path);
    if (!copy)
        return out_of_memory(err);
    strata_result result = STRATA_OK;
    char *rest;
    for (char *folder = strtok_r(copy, ":", &rest); folder && result == STRATA_OK;
         folder = strtok_r(NULL, ":", &rest))
        result = scan_folder(m, folder, err);
    free(copy);
    return result;
}

/* The folder "strata" beside the shared object (or program) that this code is in: the installed
 * tree and the build tree have the same shape. There may be none, as for a program that compares
 * images only; the log says so. */
static strata_result scan_installed(modules *m, base_error *err) {
    Dl_info info;
    char *self = NULL;
    if (dladdr((void *)(uintptr_t)&modules_scan, &info) && info.dli_fname)
        self = realpath(info.dli_fname, NULL);
    char *slash = self ? strrchr(self, '/') : NULL;
    if (!slash) {
        free(self);
        base_log(BASE_LOG_WARNING, "modules: cannot tell where this library lies");
        return STRATA_OK;
    }
    *slash = '\0';
    char *folder = base_format("%s/strata", self);
    free(self);
    if (!folder)
        return out_of_memory(err);
    struct stat status;
    strata_result result = STRATA_OK;
    if (stat(folder, &status) == 0)
        result = scan_folder(m, folder, err);
    else
        base_log(BASE_LOG_WARNING, "modules: no folder %s", folder);
    free(folder);
    return result;
}

strata_result modules_scan(const char *path, modules **out, base_error *err) {
    *out = NULL;
    modules *m = base_calloc(1, sizeof *m);
    if (!m)
        return out_of_memory(err);
    if (!path)
        path = getenv("STRATA_MODULE_PATH");
    strata_result result = path && *path ? scan_path(m, path, err) : scan_installed(m, err);
    if (result != STRATA_OK) {
        modules_free(m);
        return result;
    }
    if (m->count)
        qsort(m->entries, m->count, sizeof(modules_entry *), compare_entries);
    *out = m;
    return STRATA_OK;
}

void modules_free(modules *m) {
    if (!m)
        return;
    for (size_t i = 0; i < m->count; i++) {
        if (m->entries[i]->handle)
            dlclose(m->entries[i]->handle);
        entry_free(m->entries[i]);
    }
    note_arena_free(&m->texts);
    free(m->entries);
    free(m->refused);
    free(m->opened);
    free(m);
}

uint32_t modules_count(const modules *m) {
    uint32_t count = 0;
    for (size_t i = 0; i < m->count; i++)
        count += !m->entries[i]->refused;
    return count;
}

const modules_note *modules_note_at(const modules *m, uint32_t index) {
    for (size_t i = 0; i < m->count; i++)
        if (!m->entries[i]->refused && index-- == 0)
            return &m->entries[i]->note;
    return NULL;
}

const modules_technique_note *modules_find_technique(const modules *m, const char *id) {
    for (size_t i = 0; i < m->count; i++) {
        const modules_note *note = &m->entries[i]->note;
        for (uint32_t j = 0; j < note->technique_count && !m->entries[i]->refused; j++)
            if (strcmp(note->techniques[j].id, id) == 0)
                return &note->techniques[j];
    }
    return NULL;
}

const modules_effect_note *modules_find_effect(const modules *m, const char *id) {
    for (size_t i = 0; i < m->count; i++) {
        const modules_note *note = &m->entries[i]->note;
        for (uint32_t j = 0; j < note->effect_count && !m->entries[i]->refused; j++)
            if (strcmp(note->effects[j].id, id) == 0)
                return &note->effects[j];
    }
    return NULL;
}

uint32_t modules_refused_count(const modules *m) {
    return (uint32_t)m->refused_count;
}

const modules_refusal *modules_refused_at(const modules *m, uint32_t index) {
    return index < m->refused_count ? &m->refused[index] : NULL;
}

const char *const *modules_opened(const modules *m, uint32_t *count) {
    *count = (uint32_t)m->opened_count;
    return m->opened;
}

const strata_slot_use *modules_slot(const modules_technique_note *note, const char *slot,
                                    uint32_t use) {
    for (uint32_t i = 0; i < note->slot_count; i++)
        if (strcmp(note->slots[i]->slot, slot) == 0 && (use == 0 || note->slots[i]->use == use))
            return note->slots[i];
    return NULL;
}
