/* SPDX-License-Identifier: MIT
 *
 * Which techniques run: what the frame requires (a surface for opaque draws, one fold for
 * transparent ones, a filter for several samples), what the user named, and whatever else those
 * need to fill the slots they consume. Everyone else gets a reason.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- surface and filter: one of a role ------------------------------------------------------- */

static const struct single {
    plan_role role;
    const char *does, *idle;
} singles[] = {
    {PLAN_SURFACE, "draws opaque surfaces", "nothing opaque is drawn"},
    {PLAN_FILTER, "turns sub-pixels into pixels", "a pixel has one sample"},
};

static double known(double cost) {
    return cost == PLAN_NO_COST ? HUGE_VAL : cost;
}

static strata_result pick_single(plan_work *w, const struct single *row, const char *reason) {
    plan_candidate *named = NULL, *best = NULL;
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        if (c->role != row->role || c->blocked)
            continue;
        if (c->named && named)
            return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT,
                             "--use: %s and %s: a frame takes one that %s", named->note->id,
                             c->note->id, row->does);
        if (c->named)
            named = c;
        if (!best || known(c->cost) < known(best->cost))
            best = c;
    }
    if (!best)
        return base_fail(w->err, STRATA_ERROR_UNSUPPORTED, "nothing that can run here %s",
                         row->does);
    best = named ? named : best;
    best->chosen = 1;
    plan_reason(best, "%s%s", named ? "named in --use; " : "", reason);
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        if (c->role == row->role && !c->blocked && c != best)
            plan_reason(c, named ? "--use names %s" : "%s costs no more", best->note->id);
    }
    return STRATA_OK;
}

static strata_result leave_single(plan_work *w, const struct single *row) {
    strata_result result = STRATA_OK;
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++) {
        plan_candidate *c = &w->candidates[i];
        if (c->role != row->role || c->blocked)
            continue;
        plan_reason(c, "%s", row->idle);
        if (c->named)
            result = plan_warn(w, "--use %s: it does not run, for %s", c->note->id, row->idle);
    }
    return result;
}

static strata_result choose_surface(plan_work *w) {
    char reason[96], number[32];
    uint64_t draws = w->in->stats->opaque_draws;
    snprintf(reason, sizeof reason, "%s opaque draw%s", demand_number(draws, number),
             draws == 1 ? "" : "s");
    return draws ? pick_single(w, &singles[0], reason) : leave_single(w, &singles[0]);
}

double plan_filter_cost(const plan_work *w, const plan_candidate *fold) {
    double least = HUGE_VAL;
    int named = 0;
    for (uint32_t i = 0; i < w->count; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (c->role != PLAN_FILTER || c->blocked || c->cost == PLAN_NO_COST)
            continue;
        least = c->named ? c->cost : named ? least : fmin(least, c->cost);
        named |= c->named;
    }
    const int fuses = !named && modules_slot(fold->note, "image/1", STRATA_SLOT_PRODUCES);
    return w->in->samples > 1 && !fuses && least < HUGE_VAL ? least : 0.0;
}

/* The chosen technique that folds and could fill image/1 as it does so; NULL when there is none, or
 * --use names a filter of its own. */
static const plan_candidate *fusing_fold(const plan_work *w) {
    const plan_candidate *found = NULL;
    for (uint32_t i = 0; i < w->count; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (c->role == PLAN_FILTER && c->named)
            return NULL;
        if (c->chosen && c->role != PLAN_FILTER &&
            modules_slot(c->note, "image/1", STRATA_SLOT_PRODUCES))
            found = c;
    }
    return found;
}

/* After the fold was chosen. */
static strata_result choose_filter(plan_work *w) {
    const plan_candidate *fold = fusing_fold(w);
    char reason[128];
    if (w->in->samples <= 1)
        return leave_single(w, &singles[1]);
    if (fold) {
        struct single fused = singles[1];
        snprintf(reason, sizeof reason, "%.63s filters as it folds", fold->note->id);
        fused.idle = reason;
        w->out->image = fold->note;
        return leave_single(w, &fused);
    }
    snprintf(reason, sizeof reason, "%u samples a pixel", w->in->samples);
    strata_result result = pick_single(w, &singles[1], reason);
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++)
        if (w->candidates[i].chosen && w->candidates[i].role == PLAN_FILTER)
            w->out->image = w->candidates[i].note;
    return result;
}

/* ---- optional techniques: only if named, and only if someone uses what they make --------------
 * One that clips or culls may have been chosen, or left out, before (clip.c, cull.c). */

static int optional(const plan_candidate *c) {
    return c->role == PLAN_DRAWS || c->role == PLAN_CLIP || c->role == PLAN_CERTIFICATE;
}

/* Whether a chosen technique, or the host for what it hands out, reads `slot`. */
static int is_read(const plan_work *w, const char *slot) {
    if (strcmp(slot, "bound/1") == 0 || strcmp(slot, "image/1") == 0)
        return 1;
    for (uint32_t i = 0; i < w->count; i++) {
        const plan_candidate *c = &w->candidates[i];
        if (c->chosen && (modules_slot(c->note, slot, STRATA_SLOT_CONSUMES) ||
                          modules_slot(c->note, slot, STRATA_SLOT_UPDATES)))
            return 1;
    }
    return 0;
}

static int is_useful(const plan_work *w, const plan_candidate *c) {
    for (uint32_t i = 0; i < c->note->slot_count; i++)
        if (c->note->slots[i]->use != STRATA_SLOT_CONSUMES && is_read(w, c->note->slots[i]->slot))
            return 1;
    return 0;
}

static strata_result choose_optional(plan_work *w) {
    strata_result result = STRATA_OK;
    for (int again = 1; again;) { /* one that is chosen may give another its reader */
        again = 0;
        for (uint32_t i = 0; i < w->count; i++) {
            plan_candidate *c = &w->candidates[i];
            if (!optional(c) || !c->named || c->chosen || !is_useful(w, c))
                continue;
            c->chosen = again = 1;
            plan_reason(c, "named in --use");
        }
    }
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++) {
        plan_candidate *c = &w->candidates[i];
        if (!optional(c) || c->chosen || c->blocked || (c->reason[0] && !c->named))
            continue;
        plan_reason(c,
                    c->named ? "nothing in this frame uses what it makes" : "not named in --use");
        if (c->named)
            result = plan_warn(w, "--use %s: it does not run, for %s", c->note->id, c->reason);
    }
    return result;
}

/* ---- slots ----------------------------------------------------------------------------------- */

static const plan_candidate *chosen_producer(const plan_work *w, const char *slot) {
    for (uint32_t i = 0; i < w->count; i++)
        if (w->candidates[i].chosen &&
            modules_slot(w->candidates[i].note, slot, STRATA_SLOT_PRODUCES))
            return &w->candidates[i];
    return NULL;
}

static strata_result add_producer(plan_work *w, const plan_candidate *consumer, const char *slot) {
    plan_candidate *best = NULL;
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        if (c->blocked || c == consumer || c->role == PLAN_CAPTURE || c->role == PLAN_RESOLVE ||
            c->role == PLAN_STREAM || !modules_slot(c->note, slot, STRATA_SLOT_PRODUCES))
            continue;
        if (!best || (c->named && !best->named) ||
            (c->named == best->named && known(c->cost) < known(best->cost)))
            best = c;
    }
    if (!best)
        return base_fail(w->err, STRATA_ERROR_UNSUPPORTED,
                         "%s consumes %s, which no technique beside it in this frame can produce",
                         consumer->note->id, slot);
    best->chosen = 1;
    plan_reason(best, "produces %s, which %s consumes", slot, consumer->note->id);
    return STRATA_OK;
}

/* Adds producers until every slot that a chosen technique must have is filled. */
static strata_result fill_slots(plan_work *w) {
    for (int again = 1; again;) {
        again = 0;
        for (uint32_t i = 0; i < w->count; i++) {
            const plan_candidate *c = &w->candidates[i];
            for (uint32_t k = 0; c->chosen && k < c->note->slot_count; k++) {
                const strata_slot_use *use = c->note->slots[k];
                if (use->use == STRATA_SLOT_PRODUCES || use->optional ||
                    plan_host_fills(use->slot) || chosen_producer(w, use->slot))
                    continue;
                strata_result result = add_producer(w, c, use->slot);
                if (result != STRATA_OK)
                    return result;
                again = 1;
            }
        }
    }
    return STRATA_OK;
}

static strata_result check_single_producers(plan_work *w) {
    for (uint32_t i = 0; i < w->count; i++) {
        const plan_candidate *c = &w->candidates[i];
        for (uint32_t k = 0; c->chosen && k < c->note->slot_count; k++) {
            const strata_slot_use *use = c->note->slots[k];
            const plan_candidate *first = chosen_producer(w, use->slot);
            if (strcmp(use->slot, "image/1") == 0 || strcmp(use->slot, "image.bound/1") == 0)
                continue; /* plan.image is the one, and the others know that they are not */
            if (use->use == STRATA_SLOT_PRODUCES && first != c)
                return base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT,
                                 "%s and %s both produce %s; a slot has one producer",
                                 first->note->id, c->note->id, use->slot);
        }
    }
    return STRATA_OK;
}

strata_result plan_choose(plan_work *w) {
    strata_result result = choose_surface(w);
    if (result == STRATA_OK)
        plan_choose_cull(w);
    if (result == STRATA_OK)
        result = plan_choose_fold(w);
    if (result == STRATA_OK)
        result = choose_filter(w);
    if (result == STRATA_OK)
        result = plan_choose_clip(w);
    if (result == STRATA_OK)
        result = choose_optional(w);
    if (result == STRATA_OK)
        result = fill_slots(w);
    if (result == STRATA_OK)
        result = check_single_producers(w);
    if (result == STRATA_OK)
        plan_settle_clip(w);
    return result;
}
