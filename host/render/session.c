/* SPDX-License-Identifier: MIT
 *
 * The session: the techniques of a plan as instances, the images that fill the slots, the bands.
 * Here stands what a technique sees of the host: strata_gpu for creation, strata_view for
 * prepare().
 */
#include "render/render.h"

#include <stdlib.h>
#include <string.h>

/* ---- strata_gpu: creation, in the scope of the moment ---------------------------------------- */

static strata_result allowed(render_technique *t) {
    if (t->scope)
        return STRATA_OK;
    return base_fail(&t->error, STRATA_ERROR_INVALID_STATE,
                     "%s: creates an object outside create() and prepare()",
                     t->planned->technique->id);
}

/* A struct of a technique's, of this or another version; *out has the size known here. */
static strata_result take(render_technique *t, void *out, size_t size, const void *given,
                          const char *name) {
    if (given && base_take(out, size, given))
        return STRATA_OK;
    return base_fail(&t->error, STRATA_ERROR_INVALID_ARGUMENT, "%s: %s %s",
                     t->planned->technique->id, name,
                     given ? "has no struct_size, or is of a later version" : "is NULL");
}

static strata_result technique_buffer(void *self, const strata_buffer_desc *desc,
                                      strata_buffer *out) {
    render_technique *t = self;
    strata_result r = allowed(t);
    *out = (strata_buffer){0};
    return r == STRATA_OK ? gpu_buffer_create(t->scope, desc, out, &t->error) : r;
}

static strata_result technique_image(void *self, const strata_image_desc *desc, strata_image *out) {
    render_technique *t = self;
    strata_image_desc sized = {.struct_size = sizeof sized};
    strata_result r = allowed(t);
    *out = (strata_image){0};
    if (r == STRATA_OK)
        r = take(t, &sized, sizeof sized, desc, "strata_image_desc");
    if (r != STRATA_OK)
        return r;
    if (sized.width == 0)
        sized.width = t->session->width;
    if (sized.height == 0)
        sized.height = t->session->height;
    return gpu_image_create(t->scope, &sized, out, &t->error);
}

/* A pool begins with what it had before the last prepare(), or has grown to since. */
static strata_result technique_pool(void *self, const strata_pool_desc *desc, strata_pool *out) {
    render_technique *t = self;
    strata_result r = allowed(t);
    *out = (strata_pool){0};
    if (r == STRATA_OK && t->scope != t->prepare_scope)
        r = base_fail(&t->error, STRATA_ERROR_INVALID_STATE, "creates a pool outside prepare()");
    if (r != STRATA_OK)
        return r;
    if (t->pool_count == RENDER_MAX_POOLS)
        return base_fail(&t->error, STRATA_ERROR_OVERFLOW, "%s: more than %u pools",
                         t->planned->technique->id, RENDER_MAX_POOLS);
    strata_pool_desc sized = {.struct_size = sizeof sized};
    r = take(t, &sized, sizeof sized, desc, "strata_pool_desc");
    if (r != STRATA_OK)
        return r;
    const uint32_t i = t->pool_count;
    if (t->pool_capacity[i] > sized.expected)
        sized.expected = t->pool_capacity[i];
    base_error failure = {0};
    r = gpu_pool_create(t->scope, &sized, out, &failure);
    if (r == STRATA_ERROR_OUT_OF_DEVICE_MEMORY) { /* then small, and in bands where it must grow */
        sized.expected = 0;
        r = gpu_pool_create(t->scope, &sized, out, &t->error);
    } else if (r != STRATA_OK) {
        base_fail(&t->error, r, "%s", failure.text);
    }
    if (r == STRATA_OK)
        t->pools[t->pool_count++] = *out;
    return r;
}

static strata_result technique_program(void *self, const strata_program_desc *desc,
                                       strata_program *out) {
    render_technique *t = self;
    strata_result r = allowed(t);
    *out = (strata_program){0};
    return r == STRATA_OK ? gpu_program_create(t->scope, desc, out, &t->error) : r;
}

static uint64_t technique_fact(void *self, const char *id) {
    return gpu_fact(((render_technique *)self)->session->owner->gpu, id);
}

static uint64_t technique_capacity(void *self, strata_pool pool) {
    return gpu_pool_capacity(((render_technique *)self)->session->owner->gpu, pool);
}

static const char *technique_error(void *self) {
    const render_technique *t = self;
    return t->error.text;
}

/* ---- strata_host ----------------------------------------------------------------------------- */

static void technique_log(void *self, uint32_t level, const char *text) {
    const render_technique *t = self;
    base_log((base_level)(level > BASE_LOG_DEBUG ? BASE_LOG_DEBUG : level), "%s: %s",
             t->planned->technique->id, text);
}

static const void *technique_extension(void *self, const char *id) {
    return render_extension(((render_technique *)self)->session->owner->gpu, id);
}

/* ---- strata_view ----------------------------------------------------------------------------- */

static int names_slot(const render_technique *t, const char *slot, uint32_t use) {
    return modules_slot(t->planned->technique, slot, use) != NULL;
}

static strata_image view_image(void *self, const char *slot) {
    const render_technique *t = self;
    if (!names_slot(t, slot, 0))
        return (strata_image){0};
    if (strcmp(slot, "color/1") == 0)
        return t->session->color;
    if (strcmp(slot, "depth/1") == 0)
        return t->session->depth;
    if (strcmp(slot, "limit/1") == 0)
        return t->session->limit;
    if (strcmp(slot, "bound/1") == 0)
        return t->session->bound;
    if (t->session->plan->image != t->planned->technique &&
        names_slot(t, slot, STRATA_SLOT_PRODUCES))
        return (strata_image){0}; /* another one fills it */
    if (strcmp(slot, "image/1") == 0)
        return t->session->image;
    return strcmp(slot, "image.bound/1") == 0 ? t->session->image_bound : (strata_image){0};
}

static strata_draws view_draws(void *self, const char *slot) {
    const render_technique *t = self;
    const render_session *session = t->session;
    if (!names_slot(t, slot, 0))
        return (strata_draws){0};
    const uint32_t list = strcmp(slot, "draws.transparent/1") == 0;
    if ((list || strcmp(slot, "draws.opaque/1") == 0) && session->draws[list].id)
        return session->draws[list];
    return upload_draws(session->upload, slot);
}

static strata_result view_publish_draws(void *self, const char *slot,
                                        const strata_draws_desc *desc) {
    render_technique *t = self;
    strata_draws_desc taken = {.struct_size = sizeof taken};
    const int transparent = strcmp(slot, "draws.transparent/1") == 0;
    if (!names_slot(t, slot, STRATA_SLOT_UPDATES) ||
        (!transparent && strcmp(slot, "draws.opaque/1") != 0))
        return base_fail(&t->error, STRATA_ERROR_INVALID_ARGUMENT,
                         "%s: publishes %s, which it does not update", t->planned->technique->id,
                         slot);
    strata_result r = take(t, &taken, sizeof taken, desc, "strata_draws_desc");
    if (r != STRATA_OK)
        return r;
    const gpu_draws_desc draws = {.commands = taken.commands,
                                  .count = taken.count,
                                  .indices = upload_indices(t->session->upload),
                                  .capacity = taken.capacity};
    return gpu_draws_create(t->scope, &draws, &t->session->draws[transparent], &t->error);
}

static strata_result view_publish_image(void *self, const char *slot, strata_image published) {
    render_technique *t = self;
    if (!names_slot(t, slot, STRATA_SLOT_PRODUCES) || strcmp(slot, "limit/1") != 0)
        return base_fail(&t->error, STRATA_ERROR_INVALID_ARGUMENT,
                         "%s: publishes %s, which it does not produce", t->planned->technique->id,
                         slot);
    t->session->limit = published;
    return STRATA_OK;
}

static strata_result view_publish_fragments(void *self, const strata_fragments *fragments) {
    render_technique *t = self;
    if (!names_slot(t, "fragments/1", STRATA_SLOT_PRODUCES))
        return base_fail(&t->error, STRATA_ERROR_INVALID_ARGUMENT,
                         "%s: publishes fragments/1, which it does not produce",
                         t->planned->technique->id);
    strata_fragments taken = {.struct_size = sizeof taken};
    strata_result r = take(t, &taken, sizeof taken, fragments, "strata_fragments");
    if (r != STRATA_OK)
        return r;
    if (taken.layout != t->session->plan->layout)
        return base_fail(&t->error, STRATA_ERROR_MODULE,
                         "%s: publishes fragments/1 in another layout than its mode says",
                         t->planned->technique->id);
    t->session->fragments = taken;
    t->session->has_fragments = 1;
    return STRATA_OK;
}

static const strata_fragments *view_fragments(void *self) {
    const render_technique *t = self;
    return t->session->has_fragments && names_slot(t, "fragments/1", STRATA_SLOT_CONSUMES)
               ? &t->session->fragments
               : NULL;
}

/* What failed half-way is destroyed at once, so that it may be tried again. */
static strata_result create_technique(render_technique *t) {
    gpu *g = t->session->owner->gpu;
    if (!t->create_scope)
        t->create_scope = gpu_scope_create(g, t->planned->technique->id);
    if (!t->create_scope)
        return base_fail(&t->error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    t->scope = t->create_scope;
    strata_result r = t->technique->create(t->state, &t->host, &t->gpu);
    t->scope = NULL;
    t->created = r == STRATA_OK;
    if (r != STRATA_OK) {
        t->technique->destroy(t->state);
        memset(t->state, 0, t->technique->state_size);
        gpu_scope_end(t->create_scope);
        t->create_scope = NULL;
    }
    return r;
}

static strata_result prepare_technique(render_technique *t) {
    render_session *session = t->session;
    const plan *p = session->plan;
    strata_view view = {.struct_size = sizeof view,
                        .changed = session->changed,
                        .self = t,
                        .width = session->width,
                        .height = session->height,
                        .band_width = session->band_width,
                        .band_height = session->band_height,
                        .samples = session->samples,
                        .filter = session->filter,
                        .transmittance_channels = p->transmittance_channels,
                        .payload = p->payload.precision,
                        .layout = p->layout,
                        .payload_plane_count = p->payload.plane_count,
                        .nearest = p->nearest,
                        .scene_revision = session->scene_revision,
                        .settings = &t->planned->settings,
                        .stats = &session->stats,
                        .image = view_image,
                        .draws = view_draws,
                        .publish_image = view_publish_image,
                        .publish_fragments = view_publish_fragments,
                        .fragments = view_fragments,
                        .publish_draws = view_publish_draws,
                        .object_count = upload_count(session->upload).objects,
                        .certify = session->certify,
                        .tolerance = session->tolerance};
    memcpy(view.payload_plane_strides, p->payload.plane_strides, sizeof view.payload_plane_strides);
    for (uint32_t i = 0; i < t->pool_count; ++i)
        t->pool_capacity[i] =
            t->pools_begin_small ? 0 : gpu_pool_capacity(session->owner->gpu, t->pools[i]);
    t->pools_begin_small = 0;
    t->pool_count = 0;
    gpu_scope_end(t->prepare_scope);
    t->prepare_scope = gpu_scope_create(session->owner->gpu, t->planned->technique->id);
    if (!t->prepare_scope)
        return base_fail(&t->error, STRATA_ERROR_OUT_OF_HOST_MEMORY, "out of memory");
    t->scope = t->prepare_scope;
    strata_result r = t->technique->prepare(t->state, &view);
    t->scope = NULL;
    if (r == STRATA_OK && strcmp(t->planned->technique->stage, "capture") == 0 &&
        !session->has_fragments)
        return base_fail(&t->error, STRATA_ERROR_MODULE, "it published no fragments/1");
    return r;
}

/* What a technique returned, worded with what the host saw. */
static strata_result technique_failed(const render_technique *t, const char *call, strata_result r,
                                      const char **failed, base_error *err) {
    *failed = t->planned->technique->id;
    if (t->error.result != STRATA_OK) /* what it returned decides: others it may have handled */
        return base_fail(err, r < 0 ? r : STRATA_ERROR_MODULE, "%s: %s: %s",
                         t->planned->technique->id, call, t->error.text);
    if (r == STRATA_ERROR_UNSUPPORTED)
        return base_fail(err, r, "%s: its settings ask for what this device does not have",
                         t->planned->technique->id);
    return base_fail(err, r < 0 ? r : STRATA_ERROR_MODULE, "%s: %s failed (%d)",
                     t->planned->technique->id, call, (int)r);
}

strata_result render_session_prepare(render_session *session, const char **failed,
                                     base_error *err) {
    *failed = NULL;
    if (session->prepared)
        return STRATA_OK;
    session->limit = session->depth;
    session->draws[0] = session->draws[1] = (strata_draws){0};
    session->has_fragments = 0;
    strata_result prepared = render_bound_prepare(session, err);
    if (prepared != STRATA_OK)
        return prepared;
    for (uint32_t i = 0; i < session->technique_count; ++i) {
        render_technique *t = &session->techniques[i];
        t->error = (base_error){0};
        strata_result r = t->created ? STRATA_OK : create_technique(t);
        if (r != STRATA_OK)
            return technique_failed(t, "create", r, failed, err);
        r = prepare_technique(t);
        if (r != STRATA_OK)
            return technique_failed(t, "prepare", r, failed, err);
    }
    session->prepared = 1;
    session->owner->result.prepared++;
    session->changed = 0;
    return STRATA_OK;
}

/* ---- bands ----------------------------------------------------------------------------------- */

strata_result render_bands(render_session *session, uint32_t count, base_error *err) {
    const uint32_t rows = count < session->height ? count : session->height;
    const uint64_t wanted = ((uint64_t)count + rows - 1) / rows;
    const uint32_t columns = wanted < session->width ? (uint32_t)wanted : session->width;
    if ((uint64_t)rows * columns > RENDER_MAX_BANDS)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                         "the frame would need more than %u bands", RENDER_MAX_BANDS);
    render_rect *bands = base_calloc((size_t)rows * columns, sizeof *bands);
    if (!bands)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "bands: out of memory");
    session->band_width = session->band_height = 0;
    for (uint32_t y = 0; y < rows; ++y)
        for (uint32_t x = 0; x < columns; ++x) {
            render_rect *b = &bands[y * columns + x];
            b->x = (uint32_t)((uint64_t)session->width * x / columns);
            b->y = (uint32_t)((uint64_t)session->height * y / rows);
            b->width = (uint32_t)((uint64_t)session->width * (x + 1) / columns) - b->x;
            b->height = (uint32_t)((uint64_t)session->height * (y + 1) / rows) - b->y;
            if (b->width > session->band_width)
                session->band_width = b->width;
            if (b->height > session->band_height)
                session->band_height = b->height;
        }
    free(session->bands);
    session->bands = bands;
    session->band_count = rows * columns;
    session->prepared = 0;
    session->changed |= STRATA_CHANGED_BANDS;
    return STRATA_OK;
}

/* ---- making and ending ----------------------------------------------------------------------- */

static strata_result open_technique(render_session *session, uint32_t index, base_error *err) {
    render_technique *t = &session->techniques[index];
    const plan_technique *planned = &session->plan->techniques[index];
    *t = (render_technique){.session = session,
                            .planned = planned,
                            .gpu = {.struct_size = sizeof(strata_gpu),
                                    .self = t,
                                    .buffer_create = technique_buffer,
                                    .image_create = technique_image,
                                    .pool_create = technique_pool,
                                    .program_create = technique_program,
                                    .fact = technique_fact,
                                    .pool_capacity = technique_capacity,
                                    .error = technique_error},
                            .host = {.struct_size = sizeof(strata_host),
                                     .abi_version = STRATA_ABI_VERSION,
                                     .self = t,
                                     .log = technique_log,
                                     .extension = technique_extension}};
    strata_result r =
        modules_open_technique(session->owner->modules, planned->technique->id, &t->technique, err);
    if (r != STRATA_OK)
        return r;
    t->state = base_calloc(1, t->technique->state_size ? t->technique->state_size : 1);
    if (!t->state)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: out of memory",
                         planned->technique->id);
    return STRATA_OK;
}

static strata_result create_targets(render_session *session, base_error *err) {
    const strata_image_desc color = {.struct_size = sizeof color,
                                     .label = "color/1",
                                     .format = STRATA_FORMAT_RGBA32F,
                                     .width = session->width,
                                     .height = session->height};
    strata_image_desc depth = color, pixels = color;
    depth.label = "depth/1";
    depth.format = STRATA_FORMAT_D32F;
    pixels.label = "image/1";
    pixels.width /= session->side;
    pixels.height /= session->side;
    strata_result r = gpu_image_create(session->scope, &color, &session->color, err);
    if (r == STRATA_OK)
        r = gpu_image_create(session->scope, &depth, &session->depth, err);
    if (r == STRATA_OK && session->samples > 1)
        r = gpu_image_create(session->scope, &pixels, &session->image, err);
    if (r == STRATA_OK)
        r = gpu_buffer_create(session->scope,
                              &(strata_buffer_desc){.struct_size = sizeof(strata_buffer_desc),
                                                    .label = "frame",
                                                    .size = sizeof(render_frame_block)},
                              &session->frame_block, err);
    if (r == STRATA_OK)
        r = gpu_set_global(session->owner->gpu, "StrataFrame",
                           &(strata_bind){.struct_size = sizeof(strata_bind),
                                          .name = "StrataFrame",
                                          .buffer = session->frame_block},
                           err);
    return r;
}

/* Whether a technique of this stage (NULL: of any) names the slot. */
static uint32_t someone_names(const render_session *session, const char *stage, const char *slot) {
    for (uint32_t i = 0; i < session->plan->technique_count; ++i) {
        const modules_technique_note *note = session->plan->techniques[i].technique;
        if ((!stage || strcmp(note->stage, stage) == 0) && modules_slot(note, slot, 0))
            return 1;
    }
    return 0;
}

/* Materials that draws.transparent/1 holds: those for which an active effect emits. */
static strata_result create_upload(render_session *session, base_error *err) {
    const scene *sc = session->scene;
    unsigned char *transparent = base_calloc(sc->material_count + 1, 1);
    if (!transparent)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "scene: out of memory");
    for (uint32_t i = 0; i < sc->material_count; ++i)
        transparent[i] = plan_material_effect(session->plan, &sc->materials[i]) != NULL;
    const upload_options options = {.transparent = transparent,
                                    .shuffle_seed = session->shuffle,
                                    .objects = someone_names(session, NULL, "objects/1")};
    strata_result r = upload_create(session->owner->gpu, sc, &options, &session->upload, err);
    free(transparent);
    return r;
}

strata_result render_session_create(strata *s, scene *sc, const strata_render_options *options,
                                    plan *p, render_session **out, base_error *err) {
    render_session *session = base_calloc(1, sizeof *session);
    strata_result r = STRATA_ERROR_OUT_OF_HOST_MEMORY;
    *out = session;
    if (!session) {
        plan_free(p);
        return base_fail(err, r, "session: out of memory");
    }
    *session = (render_session){.owner = s,
                                .scene = sc,
                                .scene_revision = sc->revision,
                                .width = options->width * render_side(options),
                                .height = options->height * render_side(options),
                                .samples = options->samples,
                                .side = render_side(options),
                                .filter = render_filter(options),
                                .shuffle = options->shuffle,
                                .certify = (uint32_t)render_certify(options),
                                .tolerance = options->tolerance,
                                .plan = p,
                                .stats = p->stats,
                                .changed = 0xffffffffu};
    session->scope = gpu_scope_create(s->gpu, "host");
    session->techniques = base_calloc(p->technique_count + 1, sizeof *session->techniques);
    session->rounds = 1 + someone_names(session, "draws", "depth/1");
    if (!session->scope || !session->techniques)
        return base_fail(err, r, "session: out of memory");
    r = create_targets(session, err);
    if (r == STRATA_OK)
        r = render_bound_create(session, err);
    if (r == STRATA_OK)
        r = create_upload(session, err);
    if (r == STRATA_OK)
        r = render_effects(session, err);
    if (r == STRATA_OK)
        r = render_bands(session, options->bands ? options->bands : 1, err);
    for (uint32_t i = 0; i < p->technique_count && r == STRATA_OK; ++i) {
        session->technique_count = i + 1;
        r = open_technique(session, i, err);
    }
    return r;
}

void render_session_free(render_session *session) {
    if (!session)
        return;
    for (uint32_t i = session->technique_count; i-- > 0;) {
        render_technique *t = &session->techniques[i];
        if (t->created && t->technique)
            t->technique->destroy(t->state);
        gpu_scope_end(t->prepare_scope);
        gpu_scope_end(t->create_scope);
        free(t->state);
    }
    free(session->techniques);
    upload_free(session->upload);
    gpu_scope_end(session->loss_scope);
    gpu_scope_end(session->scope);
    free(session->bands);
    free(session->plan_text);
    free(session->request);
    plan_free(session->plan);
    free(session);
}
