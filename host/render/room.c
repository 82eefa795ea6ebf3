/* SPDX-License-Identifier: MIT
 *
 * Room for the frame: pools that were too small grow, and where the memory or the range of a
 * storage buffer does not allow it, the frame is split into more bands, which takes less of both.
 */
#include "render/render.h"

#include <string.h>

#define POOL_STEP  256u   /* elements that capacities are rounded up to */
#define SMALL_POOL 65536u /* bytes */

/* Small pools are those of the odd pixels of a frame, which vary most and cost least. */
static int is_small(const render_technique *t, uint32_t pool, uint64_t needed) {
    const uint64_t bytes = t->session->owner->start.moving ? SMALL_POOL * 16 : SMALL_POOL;
    return needed * gpu_pool_element_bytes(t->session->owner->gpu, t->pools[pool]) < bytes;
}

/* First exactly what is needed, twice that for small pools. Where it moves there is a reserve: a
 * quarter, of small pools three times what is needed. */
static uint64_t with_reserve(const render_technique *t, uint32_t pool, uint64_t needed) {
    const uint32_t moving = t->session->owner->start.moving;
    if (!is_small(t, pool, needed))
        needed += moving ? needed / 4 : 0;
    else
        needed *= moving ? 4 : 2;
    return (needed + POOL_STEP - 1) / POOL_STEP * POOL_STEP;
}

/* Bytes that techniques hold: all but the scene's and those of the host's own targets. */
static uint64_t taken(const gpu *g) {
    return gpu_bytes(g, NULL) - gpu_bytes(g, "scene") - gpu_bytes(g, "host");
}

/* Elements that a pool may have: by storage range, and by the memory that techniques may take. */
static uint64_t room(const render_session *session, strata_pool pool) {
    const gpu *g = session->owner->gpu;
    const uint64_t element = gpu_pool_element_bytes(g, pool), memory = session->owner->memory;
    uint64_t most = gpu_pool_limit(g, pool);
    if (memory && element) {
        const uint64_t others = taken(g) - gpu_pool_capacity(g, pool) * element;
        const uint64_t left = memory > others ? (memory - others) / element : 0;
        most = left < most ? left : most;
    }
    return most;
}

/* At least `factor` times as many bands; pools begin small again, and learn what a band needs. */
static strata_result split(render_session *session, uint64_t factor, const char *why,
                           base_error *err) {
    const uint64_t pixels = (uint64_t)session->width * session->height;
    uint64_t count = factor < RENDER_MAX_BANDS ? factor * session->band_count : RENDER_MAX_BANDS;
    if (session->band_count >= pixels || session->band_count >= RENDER_MAX_BANDS)
        return base_fail(err, STRATA_ERROR_OUT_OF_DEVICE_MEMORY, "%s, in %u bands", why,
                         session->band_count);
    count = count < pixels ? count : pixels;
    count = count < RENDER_MAX_BANDS ? count : RENDER_MAX_BANDS;
    for (uint32_t i = 0; i < session->technique_count; ++i)
        session->techniques[i].pools_begin_small = 1;
    return render_bands(session, (uint32_t)count, err);
}

static strata_result grow(render_session *session, render_technique *t, uint32_t pool,
                          uint64_t needed, base_error *err) {
    gpu *g = session->owner->gpu;
    const uint64_t most = room(session, t->pools[pool]);
    base_error failure = {0};
    if (needed > most)
        return split(session, most ? needed / most + 1 : 2,
                     "the fragments exceed the memory or storage range allowed", err);
    uint64_t capacity = with_reserve(t, pool, needed);
    capacity = capacity < most ? capacity : most;
    strata_result r = gpu_pool_grow(g, t->pools[pool], capacity, &failure);
    if (r == STRATA_ERROR_OUT_OF_DEVICE_MEMORY && needed > 0 && needed < capacity) {
        failure = (base_error){0};
        capacity = needed;
        r = gpu_pool_grow(g, t->pools[pool], capacity, &failure);
    }
    if (r == STRATA_ERROR_OUT_OF_DEVICE_MEMORY)
        return split(session, 2, failure.text, err);
    if (r != STRATA_OK)
        return base_fail(err, r, "%s", failure.text);
    base_log(BASE_LOG_DEBUG, "%s: pool %u needs %llu elements, gets %llu",
             t->planned->technique->id, pool, (unsigned long long)needed,
             (unsigned long long)capacity);
    return STRATA_OK;
}

static int is_short(const render_technique *t, uint32_t pool, uint64_t needed) {
    return needed > gpu_pool_capacity(t->session->owner->gpu, t->pools[pool]);
}

/* Whether a pool that sufficed soon will not. */
static int is_close(const render_technique *t, uint32_t pool, uint64_t needed) {
    const render_session *session = t->session;
    const uint64_t more = is_small(t, pool, needed) ? needed : needed / 16;
    return session->owner->start.moving && is_short(t, pool, needed + more) &&
           with_reserve(t, pool, needed) <= room(session, t->pools[pool]);
}

static strata_result make_room(render_session *session, int ahead, base_error *err) {
    const uint32_t bands = session->band_count;
    strata_result r = STRATA_OK;
    for (uint32_t i = 0; i < session->technique_count && r == STRATA_OK; ++i) {
        render_technique *t = &session->techniques[i];
        for (uint32_t p = 0; p < t->pool_count && r == STRATA_OK; ++p) {
            const uint64_t needed = t->pool_needed[p];
            const int due = (!ahead && is_short(t, p, needed)) || is_close(t, p, needed);
            if (session->band_count == bands && due)
                r = grow(session, t, p, needed, err);
        }
    }
    return r;
}

strata_result render_make_room(render_session *session, base_error *err) {
    return make_room(session, 0, err);
}

void render_room_watch(render_session *session, const scene_view *view) {
    render_start *start = &session->owner->start;
    const int same = memcmp(start->seen, view->world_to_clip, sizeof start->seen) == 0 &&
                     start->seen_revision == session->scene_revision;
    start->moving |= start->frames++ > 0 && !same;
    memcpy(start->seen, view->world_to_clip, sizeof start->seen);
    start->seen_revision = session->scene_revision;
}

strata_result render_room_ahead(render_session *session, int *again, base_error *err) {
    if (!session->owner->start.moving)
        return STRATA_OK;
    strata_result r = make_room(session, 1, err);
    *again = r == STRATA_OK && !session->prepared;
    return r;
}

strata_result render_prepare_in_room(render_session *session, int *again, const char **failed,
                                     base_error *err) {
    const uint64_t memory = session->owner->memory;
    base_error failure = {0}, cannot = {0};
    strata_result r = render_session_prepare(session, failed, &failure);
    if (r == STRATA_OK && memory && taken(session->owner->gpu) > memory)
        r = base_fail(&failure, STRATA_ERROR_OUT_OF_DEVICE_MEMORY,
                      "techniques take %llu bytes, %llu are allowed",
                      (unsigned long long)taken(session->owner->gpu), (unsigned long long)memory);
    if (r != STRATA_ERROR_OUT_OF_DEVICE_MEMORY)
        return r == STRATA_OK ? r : base_fail(err, r, "%s", failure.text);
    r = split(session, 2, failure.text, &cannot);
    if (r != STRATA_OK)
        return base_fail(err, r, "%s", cannot.text);
    *failed = NULL;
    *again = 1;
    return STRATA_OK;
}
