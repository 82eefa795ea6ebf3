/* SPDX-License-Identifier: MIT
 *
 * The list of modules as modules.c fills it and open.c opens from it. Not for other folders.
 */
#ifndef STRATA_HOST_MODULES_LIST_H
#define STRATA_HOST_MODULES_LIST_H

#include "modules/modules_internal.h"

#include <sys/types.h>

/* One usable file. Stays listed when refused later, because its note may still be in use. */
typedef struct modules_entry {
    char *path;
    note_arena arena; /* what `note` points to */
    modules_note note;
    dev_t device; /* with inode: which file this is */
    ino_t inode;
    void *handle; /* of dlopen, or NULL */
    const strata_module *descriptor;
    int refused;
} modules_entry;

struct modules {
    modules_entry **entries; /* sorted by id once the scan is over */
    size_t count, capacity;
    modules_refusal *refused;
    size_t refused_count, refused_capacity;
    const char **opened; /* ids, in order; they belong to the notes */
    size_t opened_count, opened_capacity;
    note_arena texts; /* of the refusals */
};

strata_result modules_list_refuse(modules *m, const char *path, const char *reason,
                                  base_error *err);

#endif
