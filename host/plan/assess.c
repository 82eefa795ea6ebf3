/* SPDX-License-Identifier: MIT
 *
 * What each installed technique could do in this frame, before any is chosen: its role, its cost,
 * measured or by the module's coefficients, whether the user named it, and what keeps it from
 * running here.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Stages in their order, each with the slot use that makes it one. */
static const struct stage_row {
    const char *stage, *slot;
    uint32_t use;
} stages[PLAN_ROLES] = {
    [PLAN_DRAWS] = {"draws", NULL, 0},
    [PLAN_SURFACE] = {"surface", "color/1", STRATA_SLOT_UPDATES},
    [PLAN_CLIP] = {"clip", "limit/1", STRATA_SLOT_PRODUCES},
    [PLAN_CAPTURE] = {"capture", "fragments/1", STRATA_SLOT_PRODUCES},
    [PLAN_RESOLVE] = {"resolve", "fragments/1", STRATA_SLOT_CONSUMES},
    [PLAN_STREAM] = {"stream", "color/1", STRATA_SLOT_UPDATES},
    [PLAN_FILTER] = {"filter", "image/1", STRATA_SLOT_PRODUCES},
    [PLAN_CERTIFICATE] = {"certificate", "bound/1", STRATA_SLOT_UPDATES},
};

static const char *const uses[] = {"", "consume", "produce", "update"};

int plan_host_fills(const char *slot) {
    static const char *const filled[] = {"draws.opaque/1",
                                         "draws.transparent/1",
                                         "draws.opaque.all/1",
                                         "draws.transparent.all/1",
                                         "objects/1",
                                         "color/1",
                                         "depth/1",
                                         "limit/1",
                                         "bound/1"};
    for (size_t i = 0; i < BASE_COUNT(filled); i++)
        if (strcmp(filled[i], slot) == 0)
            return 1;
    return 0;
}

void plan_reason(plan_candidate *c, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(c->reason, sizeof c->reason, format, arguments);
    va_end(arguments);
}

plan_candidate *plan_candidate_find(const plan_work *w, const char *id) {
    for (uint32_t i = 0; i < w->count; i++)
        if (strcmp(w->candidates[i].note->id, id) == 0)
            return &w->candidates[i];
    return NULL;
}

/* ---- collecting ------------------------------------------------------------------------------ */

static int by_stage(const void *a, const void *b) {
    const plan_candidate *left = a, *right = b;
    if (left->role != right->role)
        return left->role < right->role ? -1 : 1;
    return strcmp(left->note->id, right->note->id);
}

static plan_role role_of(const modules_technique_note *note) {
    for (int i = 0; i < PLAN_ROLES; i++)
        if (strcmp(stages[i].stage, note->stage) == 0)
            return (plan_role)i;
    return PLAN_ROLES;
}

const plan_price_in *plan_price_at(const plan_candidate *c, costs_form form) {
    return &c->price[form.clipped ? 1 : 0][form.layout < COSTS_LAYOUTS ? form.layout : 0]
                    [form.payload < COSTS_PAYLOADS ? form.payload : 0];
}

double plan_cost(const plan_work *w, const plan_candidate *c, costs_form form, double nearest) {
    const plan_price_in *price = plan_price_at(c, form);
    double terms[COSTS_TERMS];
    costs_terms(c->note, w->in->stats, nearest, terms);
    const double cost = costs_expect(w->in->costs, c->note, form, price->coefficients, terms);
    return price->points >= 0 && isfinite(cost) && cost >= 0.0 ? cost : PLAN_NO_COST;
}

double plan_kept(const plan_candidate *holder) {
    const int knob = costs_count_knob(holder->note);
    return knob >= 0 && holder->values ? holder->values[knob] : 0.0;
}

uint32_t plan_stored(const plan_candidate *holder) {
    const int knob = costs_payload_knob(holder->note);
    return knob >= 0 && holder->values ? (uint32_t)holder->values[knob] : STRATA_PAYLOAD_FLOAT;
}

static void price_in(const plan_work *w, plan_candidate *c, costs_form form) {
    plan_price_in *price = &c->price[form.clipped][form.layout][form.payload];
    price->points = costs_of(w->in->costs, c->note, form, price->coefficients);
}

/* With its settings, before it is known what stands beside it. */
strata_result plan_price(plan_work *w) {
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        for (uint32_t form = 0; form < COSTS_CLIPPED * COSTS_LAYOUTS * COSTS_PAYLOADS; form++)
            price_in(w, c,
                     (costs_form){.clipped = form / (COSTS_LAYOUTS * COSTS_PAYLOADS),
                                  .layout = form / COSTS_PAYLOADS % COSTS_LAYOUTS,
                                  .payload = form % COSTS_PAYLOADS});
        c->cost = plan_cost(w, c, (costs_form){.payload = plan_stored(c)}, plan_kept(c));
    }
    return STRATA_OK;
}

strata_result plan_collect(plan_work *w) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < w->in->module_count; i++)
        count += w->in->modules[i]->technique_count;
    w->candidates = base_calloc(count, sizeof *w->candidates);
    if (!w->candidates)
        return base_fail(w->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    for (uint32_t i = 0; i < w->in->module_count; i++) {
        const modules_note *module = w->in->modules[i];
        for (uint32_t k = 0; k < module->technique_count; k++) {
            plan_candidate *c = &w->candidates[w->count++];
            *c = (plan_candidate){.note = &module->techniques[k], .compared = PLAN_NO_COST};
            c->role = role_of(c->note);
        }
    }
    qsort(w->candidates, w->count, sizeof *w->candidates, by_stage);
    return STRATA_OK;
}

/* ---- what keeps a technique from running ----------------------------------------------------- */

static void block(plan_candidate *c) {
    c->blocked = 1;
}

static void check_exclusion(const plan_work *w, plan_candidate *c) {
    for (uint32_t i = 0; i < w->in->exclusion_count && !c->blocked; i++) {
        const plan_exclusion *e = &w->in->exclusions[i];
        if (strcmp(e->technique, c->note->id) != 0)
            continue;
        plan_reason(c, "it failed: %s", e->reason ? e->reason : "no reason is known");
        block(c);
    }
}

static void check_stage(plan_candidate *c) {
    if (c->role == PLAN_ROLES) {
        plan_reason(c, "this host knows no stage '%s'", c->note->stage);
        block(c);
        return;
    }
    const struct stage_row *row = &stages[c->role];
    if (row->slot && !modules_slot(c->note, row->slot, row->use)) {
        plan_reason(c, "its stage is %s, but it does not %s %s", row->stage, uses[row->use],
                    row->slot);
        block(c);
    }
}

static void check_needs(const plan_work *w, plan_candidate *c) {
    if (!w->in->fact || !c->note->needs)
        return;
    for (const char *const *need = c->note->needs; *need && !c->blocked; need++) {
        if (w->in->fact(w->in->user, *need) != 0)
            continue;
        plan_reason(c, "needs %s, which this device does not have", *need);
        block(c);
    }
}

static int someone_produces(const plan_work *w, const plan_candidate *self, const char *slot) {
    for (uint32_t i = 0; i < w->count; i++)
        if (&w->candidates[i] != self && !w->candidates[i].blocked &&
            modules_slot(w->candidates[i].note, slot, STRATA_SLOT_PRODUCES))
            return 1;
    return 0;
}

/* Returns 1 when it found something that blocks c. */
static int check_slots(const plan_work *w, plan_candidate *c) {
    for (uint32_t i = 0; i < c->note->slot_count; i++) {
        const strata_slot_use *use = c->note->slots[i];
        if (use->use == STRATA_SLOT_PRODUCES) {
            if (!plan_host_fills(use->slot) || strcmp(use->slot, "limit/1") == 0)
                continue;
            plan_reason(c, "produces %s, which the host fills itself", use->slot);
        } else {
            if (use->optional || plan_host_fills(use->slot) || someone_produces(w, c, use->slot))
                continue;
            plan_reason(c, "%ss %s, which nothing that can run here produces", uses[use->use],
                        use->slot);
        }
        block(c);
        return 1;
    }
    return 0;
}

static strata_result name_technique(void *user, const char *id) {
    plan_work *w = user;
    plan_candidate *c = plan_candidate_find(w, id);
    if (!c)
        return plan_unknown_technique(w, "--use", id);
    c->named = 1;
    return STRATA_OK;
}

strata_result plan_assess(plan_work *w) {
    strata_result result = STRATA_OK;
    if (w->in->use)
        result = plan_split(w->in->use, "--use", name_technique, w, w->err);
    for (uint32_t i = 0; i < w->count; i++) {
        plan_candidate *c = &w->candidates[i];
        check_exclusion(w, c);
        if (!c->blocked)
            check_stage(c);
        if (!c->blocked)
            check_needs(w, c);
    }
    for (int again = 1; again;) { /* one that is blocked may leave others without their slot */
        again = 0;
        for (uint32_t i = 0; i < w->count; i++)
            if (!w->candidates[i].blocked && check_slots(w, &w->candidates[i]))
                again = 1;
    }
    for (uint32_t i = 0; i < w->count && result == STRATA_OK; i++)
        if (w->candidates[i].named && w->candidates[i].blocked)
            result = base_fail(w->err, STRATA_ERROR_UNSUPPORTED, "--use: %s cannot run: %s",
                               w->candidates[i].note->id, w->candidates[i].reason);
    return result;
}
