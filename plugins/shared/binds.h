/* SPDX-License-Identifier: MIT
 *
 * The resources of a pass, gathered one by one: programs differ in what they use, so each pass
 * lists its own.
 */
#ifndef STRATA_PLUGINS_BINDS_H
#define STRATA_PLUGINS_BINDS_H

#include "strata/strata.h"

enum { BINDS_MAX = 16 };

typedef struct binds {
    strata_bind at[BINDS_MAX];
    uint32_t count;
} binds;

static inline strata_bind bind_buffer(const char *name, strata_buffer buffer) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .buffer = buffer};
}

static inline strata_bind bind_image(const char *name, strata_image image) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .name = name, .image = image};
}

static inline strata_bind bind_pool(strata_pool pool) {
    return (strata_bind){.struct_size = sizeof(strata_bind), .pool = pool};
}

static inline void binds_buffer(binds *b, const char *name, strata_buffer buffer) {
    b->at[b->count++] = bind_buffer(name, buffer);
}

static inline void binds_image(binds *b, const char *name, strata_image image) {
    b->at[b->count++] = bind_image(name, image);
}

static inline void binds_pool(binds *b, strata_pool pool) {
    b->at[b->count++] = bind_pool(pool);
}

#endif
