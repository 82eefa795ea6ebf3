/* SPDX-License-Identifier: MIT
 *
 * Which object stands behind each resource of a program in one pass: the pass's own binds by name,
 * pools that bring several names, then the host's globals. Reports what is missing, unknown, bound
 * twice, of the wrong kind or out of range.
 */
#include "gpu/gpu_internal.h"

#include <string.h>

typedef struct bind_context {
    gpu *g;
    const gpu_program_state *program;
    const char *program_label;
    gpu_resolved *out;
    uint8_t bound[GPU_MAX_BINDINGS]; /* of the program's bindings */
} bind_context;

static int is_bound_by_name(const gpu_binding *binding) {
    return binding->kind != GPU_BINDING_PARAMS && binding->kind != GPU_BINDING_ATTACHMENT;
}

static int find_binding(const gpu_program_state *program, const char *name) {
    for (uint32_t i = 0; i < program->binding_count; i++)
        if (is_bound_by_name(&program->bindings[i]) && strcmp(program->bindings[i].name, name) == 0)
            return (int)i;
    return -1;
}

/* ---- what may stand behind a resource ------------------------------------------------------- */

static int check_buffer_range(gpu *g, const gpu_binding *binding, const gpu_object *object,
                              uint64_t offset, uint64_t size) {
    const int texels = binding->kind == GPU_BINDING_TEXELS;
    uint64_t limit = texels                                 ? g->caps.texels * 4
                     : binding->kind == GPU_BINDING_UNIFORM ? GPU_MAX_UNIFORM
                                                            : g->caps.storage_range;
    if (texels && (offset || size != object->buffer.size)) {
        gpu_record_fail(g, GPU_ERROR_BUFFER_RANGE,
                        "'%s': buffer '%s', %llu bytes at %llu; a usamplerBuffer reads all of it",
                        binding->name, object->label, (unsigned long long)size,
                        (unsigned long long)offset);
        return 0;
    }
    if (offset > object->buffer.size || size > object->buffer.size - offset || size == 0 ||
        offset % 256 || size < binding->size) {
        gpu_record_fail(g, GPU_ERROR_BUFFER_RANGE,
                        "'%s': buffer '%s' of %llu bytes, %llu at %llu; the block has %u",
                        binding->name, object->label, (unsigned long long)object->buffer.size,
                        (unsigned long long)size, (unsigned long long)offset, binding->size);
        return 0;
    }
    if (limit && size > limit) {
        gpu_record_fail(g, GPU_ERROR_BUFFER_LIMIT, "'%s': %llu bytes of buffer '%s', limit %llu",
                        binding->name, (unsigned long long)size, object->label,
                        (unsigned long long)limit);
        return 0;
    }
    return 1;
}

static int check_image_use(gpu *g, const gpu_binding *binding, const gpu_object *object) {
    const gpu_image_state *image = &object->image;
    if ((image->layers > 0) != (binding->arrayed != 0)) {
        gpu_record_fail(g, GPU_ERROR_BIND_KIND, "'%s': image '%s' %s layers", binding->name,
                        object->label, image->layers ? "has" : "is without");
        return 0;
    }
    if ((image->samples > 1) != (binding->multisampled != 0)) {
        gpu_record_fail(g, GPU_ERROR_IMAGE_SAMPLES, "'%s': image '%s' of %u samples", binding->name,
                        object->label, image->samples);
        return 0;
    }
    int fits = gpu_format_is_integer(image->format) == (binding->is_unsigned != 0);
    if (binding->kind == GPU_BINDING_STORAGE_IMAGE)
        fits = fits && !gpu_format_is_depth(image->format) &&
               image->format != STRATA_FORMAT_RGBA8_SRGB &&
               (!binding->format || binding->format == image->format);
    if (!fits)
        gpu_record_fail(g, GPU_ERROR_IMAGE_FORMAT, "'%s': image '%s' of format %u", binding->name,
                        object->label, image->format);
    return fits;
}

/* ---- resolving ------------------------------------------------------------------------------ */

static void add_native(bind_context *c, int index, gpu_storage *storage, uint64_t offset,
                       uint64_t size) {
    const gpu_binding *binding = &c->program->bindings[index];
    gpu_resolved *out = c->out;
    out->storages[out->count] = storage;
    out->binds[out->count++] = (gpu_native_bind){
        .binding = binding, .native = storage->native, .offset = offset, .size = size};
    gpu_uses_add(&out->uses, storage, binding->access, binding->stages);
    c->bound[index] = 1;
}

static int bind_buffer(bind_context *c, int index, gpu_object *object, uint64_t offset,
                       uint64_t size) {
    const gpu_binding *binding = &c->program->bindings[index];
    if (binding->kind != GPU_BINDING_UNIFORM && binding->kind != GPU_BINDING_STORAGE &&
        binding->kind != GPU_BINDING_TEXELS) {
        gpu_record_fail(c->g, GPU_ERROR_BIND_KIND, "'%s': buffer '%s'", binding->name,
                        object->label);
        return 0;
    }
    if (!object->buffer.storage) {
        gpu_record_fail(c->g, GPU_ERROR_MEMORY, "'%s': buffer '%s'", binding->name, object->label);
        return 0;
    }
    if (size == 0 && offset < object->buffer.size)
        size = object->buffer.size - offset;
    if (binding->kind == GPU_BINDING_UNIFORM && size > GPU_MAX_UNIFORM &&
        binding->size <= GPU_MAX_UNIFORM)
        size = binding->size; /* a part of a larger buffer: the block says how much */
    if (!check_buffer_range(c->g, binding, object, offset, size))
        return 0;
    add_native(c, index, object->buffer.storage, offset, size);
    return 1;
}

static int bind_image(bind_context *c, int index, gpu_object *object) {
    const gpu_binding *binding = &c->program->bindings[index];
    if (binding->kind != GPU_BINDING_SAMPLED && binding->kind != GPU_BINDING_STORAGE_IMAGE) {
        gpu_record_fail(c->g, GPU_ERROR_BIND_KIND, "'%s': image '%s'", binding->name,
                        object->label);
        return 0;
    }
    if (!check_image_use(c->g, binding, object))
        return 0;
    add_native(c, index, object->image.storage, 0, 0);
    return 1;
}

static int not_twice(bind_context *c, int index) {
    if (index < 0 || !c->bound[index])
        return 1;
    gpu_record_fail(c->g, GPU_ERROR_BIND_TWICE, "'%s'", c->program->bindings[index].name);
    return 0;
}

/* A pool brings its names; the program need not have all of them. */
static int bind_pool(bind_context *c, gpu_object *object) {
    const gpu_pool_state *pool = &object->pool;
    int used = 0;
    for (uint32_t i = 0; i <= pool->plane_count; i++) {
        int is_counter = i == pool->plane_count;
        int index = find_binding(c->program, is_counter ? pool->counter_name : pool->names[i]);
        if (index < 0)
            continue;
        used = 1;
        if (!not_twice(c, index) ||
            !bind_buffer(c, index, is_counter ? pool->counter : pool->planes[i], 0, 0))
            return 0;
    }
    if (used)
        c->out->pools[c->out->pool_count++] = object;
    return 1;
}

static gpu_object *find_bound(gpu *g, const strata_bind *bind, const char *name) {
    gpu_code code = GPU_ERROR_NONE;
    int set = (bind->buffer.id != 0) + (bind->image.id != 0) + (bind->pool.id != 0);
    gpu_object *object = NULL;
    if (set != 1)
        code = GPU_ERROR_BIND_KIND;
    else if (bind->buffer.id)
        object = gpu_object_find(g, bind->buffer.id, GPU_BUFFER, &code);
    else if (bind->image.id)
        object = gpu_object_find(g, bind->image.id, GPU_IMAGE, &code);
    else
        object = gpu_object_find(g, bind->pool.id, GPU_POOL, &code);
    if (!object)
        gpu_record_fail(g, code, "'%s'", name);
    return object;
}

/* What one bind of the pass names, and how messages call it. */
static gpu_object *find_own(gpu *g, const strata_bind *bind, uint32_t number, const char **name) {
    if (bind->pool.id == 0 && (!bind->name || !bind->name[0])) {
        gpu_record_fail(g, GPU_ERROR_VALUE, "bind %u has no name", number);
        return NULL;
    }
    *name = bind->pool.id ? "pool" : bind->name;
    return find_bound(g, bind, *name);
}

static int bind_own(bind_context *c, const strata_bind *bind, uint32_t number) {
    const char *name = NULL;
    gpu_object *object = find_own(c->g, bind, number, &name);
    if (!object)
        return 0;
    if (object->kind == GPU_POOL) {
        if (c->out->pool_count < GPU_MAX_BINDINGS)
            return bind_pool(c, object);
        gpu_record_fail(c->g, GPU_ERROR_VALUE, "bind %u", number);
        return 0;
    }
    int index = find_binding(c->program, name);
    if (index < 0) {
        gpu_record_fail(c->g, GPU_ERROR_BIND_UNKNOWN, "'%s' in program '%s'", name,
                        c->program_label);
        return 0;
    }
    if (!not_twice(c, index))
        return 0;
    return object->kind == GPU_BUFFER ? bind_buffer(c, index, object, bind->offset, bind->size)
                                      : bind_image(c, index, object);
}

/* Binds i-th element of the sender's array, which may have been built with another minor. */
static int take_bind(gpu *g, const strata_pass *pass, uint32_t i, strata_bind *out) {
    size_t stride = pass->bind_stride ? pass->bind_stride : sizeof(strata_bind);
    base_error failure = {0};
    const char *base = (const char *)pass->binds;
    if (gpu_take(g, &failure, base + i * stride, out, sizeof *out, "strata_bind") == STRATA_OK)
        return 1;
    gpu_record_fail(g, g->last_code, "bind %u", i);
    return 0;
}

static int bind_global(bind_context *c, int index) {
    const gpu_binding *binding = &c->program->bindings[index];
    for (const gpu_global *global = c->g->globals; global; global = global->next) {
        if (strcmp(global->name, binding->name) != 0)
            continue;
        gpu_object *object = find_bound(c->g, &global->bind, global->name);
        if (!object)
            return 0;
        if (object->kind == GPU_BUFFER)
            return bind_buffer(c, index, object, global->bind.offset, global->bind.size);
        if (object->kind == GPU_IMAGE)
            return bind_image(c, index, object);
        return bind_pool(c, object);
    }
    gpu_record_fail(c->g, GPU_ERROR_BIND_MISSING, "'%s' of program '%s'", binding->name,
                    c->program_label);
    return 0;
}

static int check_binds(gpu *g, const strata_pass *pass) {
    if (pass->bind_count && (!pass->binds || pass->bind_count > 2 * GPU_MAX_BINDINGS ||
                             (pass->bind_stride && pass->bind_stride < sizeof(strata_bind)))) {
        gpu_record_fail(g, GPU_ERROR_VALUE, "%u binds", pass->bind_count);
        return 0;
    }
    return 1;
}

int gpu_bind_resolve(gpu *g, const strata_pass *pass, const gpu_object *program,
                     gpu_resolved *out) {
    bind_context c = {
        .g = g, .program = program->program, .program_label = program->label, .out = out};
    out->count = out->pool_count = out->uses.count = 0;
    if (!check_binds(g, pass))
        return 0;
    for (uint32_t i = 0; i < pass->bind_count; i++) {
        strata_bind bind;
        if (!take_bind(g, pass, i, &bind) || !bind_own(&c, &bind, i))
            return 0;
    }
    for (uint32_t i = 0; i < c.program->binding_count; i++)
        if (!c.bound[i] && is_bound_by_name(&c.program->bindings[i]) && !bind_global(&c, (int)i))
            return 0;
    return 1;
}

/* ---- native passes: names are for messages alone --------------------------------------------- */

static int use_native(gpu *g, gpu_resolved *out, gpu_storage *storage, const char *name) {
    if (!storage) {
        gpu_record_fail(g, GPU_ERROR_MEMORY, "'%s'", name);
        return 0;
    }
    if (out->uses.count == GPU_MAX_BINDINGS) {
        gpu_record_fail(g, GPU_ERROR_VALUE, "'%s': more than %u resources", name, GPU_MAX_BINDINGS);
        return 0;
    }
    gpu_uses_add(&out->uses, storage, GPU_ACCESS_NATIVE, 0);
    return 1;
}

static int use_native_pool(gpu *g, gpu_resolved *out, gpu_object *object) {
    const gpu_pool_state *pool = &object->pool;
    for (uint32_t i = 0; i < pool->plane_count; i++)
        if (!use_native(g, out, pool->planes[i]->buffer.storage, pool->names[i]))
            return 0;
    if (!use_native(g, out, pool->counter->buffer.storage, pool->counter_name))
        return 0;
    if (out->pool_count < GPU_MAX_BINDINGS)
        out->pools[out->pool_count++] = object;
    return 1;
}

static int use_native_bind(gpu *g, gpu_resolved *out, const strata_bind *bind, uint32_t number) {
    const char *name = NULL;
    gpu_object *object = find_own(g, bind, number, &name);
    if (!object)
        return 0;
    if (object->kind == GPU_POOL)
        return use_native_pool(g, out, object);
    if (object->kind == GPU_IMAGE)
        return use_native(g, out, object->image.storage, name);
    if (bind->offset > object->buffer.size || bind->size > object->buffer.size - bind->offset) {
        gpu_record_fail(g, GPU_ERROR_BUFFER_RANGE, "'%s': buffer '%s' of %llu bytes, %llu at %llu",
                        name, object->label, (unsigned long long)object->buffer.size,
                        (unsigned long long)bind->size, (unsigned long long)bind->offset);
        return 0;
    }
    return use_native(g, out, object->buffer.storage, name);
}

int gpu_bind_native(gpu *g, const strata_pass *pass, gpu_resolved *out) {
    out->count = out->pool_count = out->uses.count = 0;
    if (!check_binds(g, pass))
        return 0;
    for (uint32_t i = 0; i < pass->bind_count; i++) {
        strata_bind bind;
        if (!take_bind(g, pass, i, &bind) || !use_native_bind(g, out, &bind, i))
            return 0;
    }
    return 1;
}
