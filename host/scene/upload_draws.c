/* SPDX-License-Identifier: MIT
 *
 * Records and commands: one record for each visible instance (for each of its clusters where
 * objects are wanted), in the order of submission; neighbours in it that share a mesh share a
 * command. What did not change is not written again.
 */
#include "scene/upload_internal.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- records --------------------------------------------------------------------------------- */

static double determinant(const float m[16]) {
    double a[9];
    for (int column = 0; column < 3; column++)
        for (int row = 0; row < 3; row++)
            a[column * 3 + row] = (double)m[column * 4 + row];
    return a[0] * (a[4] * a[8] - a[5] * a[7]) - a[3] * (a[1] * a[8] - a[2] * a[7]) +
           a[6] * (a[1] * a[5] - a[2] * a[4]);
}

static upload_record make_record(const scene_instance *instance, const scene_mesh *mesh,
                                 const upload_mesh *layout) {
    upload_record record = {.material = mesh->material,
                            .primitive_base = instance->primitive_base,
                            .primitive_map = layout->primitive_map,
                            .flags = layout->flags};
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++)
            record.world[row][column] = instance->world[column * 4 + row];
    memcpy(record.first, layout->first, sizeof record.first);
    double det = determinant(instance->world);
    if (det < 0.0 && mesh->topology == SCENE_TRIANGLES)
        record.flags |= UPLOAD_MIRRORED;
    record.scale = (float)fmin(cbrt(fabs(det)), 3e38);
    return record;
}

/* Writes [0, count) of a host copy, from its first change to its last. */
static strata_result write_changes(gpu *g, strata_buffer to, void *old, const void *now,
                                   uint32_t count, size_t size, uint32_t old_count,
                                   base_error *err) {
    unsigned char *was = old;
    const unsigned char *is = now;
    uint32_t both = old_count < count ? old_count : count, first = 0, last = count;
    while (first < both && memcmp(was + first * size, is + first * size, size) == 0)
        first++;
    while (last > first && last <= both &&
           memcmp(was + (last - 1) * size, is + (last - 1) * size, size) == 0)
        last--;
    if (first == last)
        return STRATA_OK;
    memcpy(was + first * size, is + first * size, (last - first) * size);
    return gpu_buffer_write(g, to, first * size, (last - first) * size, is + first * size, err);
}

static strata_result put_records(upload *u, const upload_record *records, uint32_t count,
                                 base_error *err) {
    uint64_t size = u->record_capacity * sizeof *records;
    uint64_t limit = gpu_fact(u->g, "limit.storage_range");
    strata_result result = STRATA_OK;
    if (!u->records.id && limit && size > limit)
        return base_fail(err, STRATA_ERROR_OVERFLOW, "%u instances exceed the device's limit of %u",
                         u->record_capacity, (uint32_t)(limit / sizeof *records));
    if (!u->records.id)
        result = upload_buffer(u, "StrataRecords", "records", NULL, size, &u->records, err);
    if (result == STRATA_OK)
        result = write_changes(u->g, u->records, u->record, records, count, sizeof *records,
                               u->record_count, err);
    return result;
}

static strata_result put_objects(upload *u, const upload_object *objects, uint32_t count,
                                 base_error *err) {
    strata_result result = STRATA_OK;
    if (!u->objects.id)
        result = upload_buffer(u, "StrataObjectStates", "object states", NULL,
                               u->record_capacity * sizeof(uint32_t), &u->states, err);
    if (result == STRATA_OK && !u->objects.id)
        result = upload_buffer(u, "StrataObjects", "objects", NULL,
                               u->record_capacity * sizeof *objects, &u->objects, err);
    if (result == STRATA_OK)
        result = write_changes(u->g, u->objects, u->object, objects, count, sizeof *objects,
                               u->record_count, err);
    return result;
}

/* ---- commands -------------------------------------------------------------------------------- */

static void end_list(upload_list *list) {
    if (list->scope)
        gpu_scope_end(list->scope);
    list->scope = NULL;
    list->commands = (strata_buffer){0};
    list->draws = (strata_draws){0};
}

/* New buffer and handle for `count` commands; a list of none has one that draws nothing. */
static strata_result make_list(upload *u, upload_list *list, const char *label,
                               const upload_command *commands, uint32_t count, base_error *err) {
    upload_command nothing = {0};
    end_list(list);
    list->scope = gpu_scope_create(u->g, "scene");
    if (!list->scope)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for draws");
    uint32_t capacity = count ? count : 1;
    strata_buffer_desc desc = {.struct_size = sizeof desc,
                               .label = label,
                               .size = capacity * sizeof *commands,
                               .data = count ? commands : &nothing};
    strata_result result = gpu_buffer_create(list->scope, &desc, &list->commands, err);
    gpu_draws_desc draws = {
        .commands = list->commands, .indices = u->indices, .capacity = capacity};
    return result == STRATA_OK ? gpu_draws_create(list->scope, &draws, &list->draws, err) : result;
}

static strata_result put_commands(upload *u, uint32_t which, const upload_command *commands,
                                  uint32_t count, base_error *err) {
    upload_list *list = &u->lists[which];
    const char *label = which ? "transparent draws" : "opaque draws";
    if (count > list->capacity) {
        upload_command *host = base_realloc(list->host, count, sizeof *host);
        if (!host)
            return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for draws");
        list->host = host;
        list->capacity = count;
    }
    strata_result result = STRATA_OK;
    if (count != list->count) {
        result = make_list(u, list, label, commands, count, err);
        memcpy(list->host, commands, count * sizeof *commands);
    } else {
        result = write_changes(u->g, list->commands, list->host, commands, count, sizeof *commands,
                               list->count, err);
    }
    list->count = count;
    list->triangles = 0;
    for (uint32_t i = 0; i < count; i++)
        list->triangles += (uint64_t)(commands[i].index_count / 3) * commands[i].instance_count;
    return result;
}

/* What a walk over the instances makes. */
typedef struct walk {
    upload_record *records;
    upload_object *objects; /* NULL: not wanted */
    upload_command *commands[2];
    uint32_t record_count, command_count[2];
} walk;

/* A record, and an object where they are wanted, for each cluster of an instance. */
static void walk_instance(const upload *u, const scene *s, const scene_instance *instance, walk *w,
                          int again) {
    const scene_mesh *mesh = &s->meshes[instance->mesh];
    const upload_mesh *layout = &u->meshes[instance->mesh];
    upload_record record = make_record(instance, mesh, layout);
    for (uint32_t i = 0; i < layout->cluster_count; i++) {
        const upload_cluster *cluster = &u->clusters[layout->first_cluster + i];
        w->records[w->record_count] = record;
        if (i > 0) /* clusters of several have a map */
            w->records[w->record_count].primitive_map +=
                (cluster->first_index - layout->first_index) / 3;
        if (w->objects) {
            upload_object *object = &w->objects[w->record_count];
            *object = upload_make_object(u, mesh, layout, i);
            if (again && layout->cluster_count == 1)
                object->flags |= UPLOAD_OBJECT_NEXT;
        }
        w->record_count++;
    }
}

static void walk_instances(const upload *u, const scene *s, walk *w) {
    uint32_t last_mesh = SCENE_NONE;
    for (uint32_t i = 0; i < u->instance_count; i++) {
        const scene_instance *instance = &s->instances[u->order[i]];
        const upload_mesh *mesh = &u->meshes[instance->mesh];
        if (!instance->visible || !mesh->used)
            continue;
        const int again = instance->mesh == last_mesh;
        uint32_t list = mesh->transparent;
        if (again && mesh->cluster_count == 1)
            w->commands[list][w->command_count[list] - 1].instance_count++;
        else
            w->commands[list][w->command_count[list]++] =
                (upload_command){.index_count = mesh->index_count,
                                 .instance_count = 1,
                                 .first_index = mesh->first_index,
                                 .first_instance = w->record_count};
        walk_instance(u, s, instance, w, again);
        last_mesh = instance->mesh;
    }
}

static strata_result put_walk(upload *u, const walk *w, base_error *err) {
    strata_result result = put_records(u, w->records, w->record_count, err);
    if (result == STRATA_OK && w->objects)
        result = put_objects(u, w->objects, w->record_count, err);
    u->record_count = w->record_count;
    for (uint32_t list = 0; list < 2 && result == STRATA_OK; list++)
        result = put_commands(u, list, w->commands[list], w->command_count[list], err);
    return result;
}

strata_result upload_records(upload *u, const scene *s, base_error *err) {
    size_t instances = u->instance_count ? u->instance_count : 1;
    walk w = {.records = base_calloc(u->record_capacity, sizeof *w.records),
              .commands = {base_calloc(instances, sizeof **w.commands),
                           base_calloc(instances, sizeof **w.commands)}};
    strata_result result = STRATA_OK;
    if (u->wants_objects)
        w.objects = base_calloc(u->record_capacity, sizeof *w.objects);
    if (w.records && w.commands[0] && w.commands[1] && (w.objects || !u->wants_objects)) {
        walk_instances(u, s, &w);
        result = put_walk(u, &w, err);
    } else {
        result =
            base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for its draws", s->path);
    }
    free(w.records);
    free(w.objects);
    free(w.commands[0]);
    free(w.commands[1]);
    return result;
}

strata_draws upload_draws(upload *u, const char *slot) {
    uint32_t which = strncmp(slot, "draws.transparent", 17) == 0;
    if (!which && strncmp(slot, "draws.opaque", 12) != 0)
        return (strata_draws){0};
    upload_list *list = &u->lists[which];
    if (!list->draws.id && make_list(u, list, which ? "transparent draws" : "opaque draws", NULL, 0,
                                     NULL) != STRATA_OK)
        end_list(list);
    return list->draws;
}

void upload_draws_free(upload *u) {
    for (uint32_t list = 0; list < 2; list++) {
        end_list(&u->lists[list]);
        free(u->lists[list].host);
    }
}
