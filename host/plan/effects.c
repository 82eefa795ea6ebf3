/* SPDX-License-Identifier: MIT
 *
 * Which effects are active: those that the scene calls for, unless the user says otherwise; and
 * which of them a material belongs to.
 */
#include "plan/plan_internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int by_id(const void *a, const void *b) {
    const plan_effect *left = a, *right = b;
    return strcmp(left->effect->id, right->effect->id);
}

/* Fills called_for and evidence; of an effect that is not called for, what would call for it. */
static void look_for_evidence(const plan_input *in, plan_effect *e) {
    size_t length = 0;
    for (uint32_t i = 0; i < e->effect->need_count; i++) {
        const strata_need *need = e->effect->called_for_by[i];
        const demand_fact *fact = demand_find(in->demand, need->fact);
        if (!fact || fact->value == 0 || (double)fact->value < need->threshold)
            continue;
        e->called_for = 1;
        if (length < sizeof e->evidence)
            length += (size_t)snprintf(e->evidence + length, sizeof e->evidence - length, "%s%s",
                                       length ? "; " : "", fact->evidence);
    }
    if (e->called_for || e->effect->need_count == 0)
        return;
    const strata_need *need = e->effect->called_for_by[0];
    const demand_fact *fact = demand_find(in->demand, need->fact);
    if (!fact)
        snprintf(e->reason, sizeof e->reason, "nothing calls for it: this host knows no fact '%s'",
                 need->fact);
    else
        snprintf(e->reason, sizeof e->reason, "nothing calls for it: %s is %llu of at least %g",
                 need->fact, (unsigned long long)fact->value,
                 need->threshold > 1.0 ? need->threshold : 1.0);
}

static void decide_automatic(plan_effect *e) {
    e->active = e->called_for;
    if (e->called_for)
        snprintf(e->reason, sizeof e->reason, "the scene calls for it");
    else if (!e->reason[0])
        snprintf(e->reason, sizeof e->reason, "nothing calls for it; --effects may name it");
}

static void decide_by_hand(plan_effect *e, int named, const char *list) {
    e->active = (uint32_t)named;
    e->forced = e->active != e->called_for;
    if (named)
        snprintf(e->reason, sizeof e->reason, "%s",
                 e->called_for ? "named in --effects; the scene calls for it"
                               : "named in --effects, though nothing in the scene calls for it");
    else if (e->called_for)
        snprintf(e->reason, sizeof e->reason, "switched off by --effects %.64s", list);
    else if (!e->reason[0])
        snprintf(e->reason, sizeof e->reason, "nothing calls for it");
}

typedef struct naming {
    const plan *plan;
    unsigned char *named;
    base_error *err;
} naming;

static strata_result name_effect(void *user, const char *id) {
    naming *n = user;
    for (uint32_t i = 0; i < n->plan->effect_count; i++) {
        if (strcmp(n->plan->effects[i].effect->id, id) == 0) {
            n->named[i] = 1;
            return STRATA_OK;
        }
    }
    if (strcmp(id, "auto") == 0 || strcmp(id, "none") == 0)
        return base_fail(n->err, STRATA_ERROR_INVALID_ARGUMENT,
                         "--effects: '%s' stands alone, not in a list", id);
    return plan_unknown_effect(n->plan, "--effects", id, n->err);
}

static strata_result collect_effects(const plan_input *in, plan *out, base_error *err) {
    uint32_t count = 0;
    for (uint32_t i = 0; i < in->module_count; i++)
        count += in->modules[i]->effect_count;
    out->effects = base_calloc(count, sizeof *out->effects);
    if (!out->effects)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    for (uint32_t i = 0; i < in->module_count; i++)
        for (uint32_t k = 0; k < in->modules[i]->effect_count; k++)
            out->effects[out->effect_count++].effect = &in->modules[i]->effects[k];
    qsort(out->effects, out->effect_count, sizeof *out->effects, by_id);
    return STRATA_OK;
}

strata_result plan_decide_effects(const plan_input *in, plan *out, base_error *err) {
    const char *list = in->effects ? in->effects : "auto";
    strata_result result = collect_effects(in, out, err);
    if (result != STRATA_OK)
        return result;
    unsigned char *named = base_calloc(out->effect_count, 1);
    if (!named)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    int automatic = strcmp(list, "auto") == 0;
    if (!automatic && strcmp(list, "none") != 0)
        result = plan_split(list, "--effects", name_effect, &(naming){out, named, err}, err);
    for (uint32_t i = 0; i < out->effect_count && result == STRATA_OK; i++) {
        plan_effect *e = &out->effects[i];
        look_for_evidence(in, e);
        if (automatic)
            decide_automatic(e);
        else
            decide_by_hand(e, named[i], list);
        if (e->active)
            e->index = out->active_effects++;
    }
    free(named);
    return result;
}

static int calls_for(const scene_material *material, const modules_effect_note *effect) {
    for (uint32_t i = 0; i < effect->need_count; i++)
        if (demand_material_counts(material, effect->called_for_by[i]->fact))
            return 1;
    return 0;
}

const plan_effect *plan_material_effect(const plan *p, const scene_material *material) {
    const plan_effect *best = NULL;
    for (uint32_t i = 0; i < p->effect_count; i++) {
        const plan_effect *e = &p->effects[i];
        if (!e->active || !calls_for(material, e->effect))
            continue;
        if (!best || e->effect->priority > best->effect->priority)
            best = e;
    }
    return best;
}

strata_result plan_transparent_materials(const plan_input *input, const scene *s,
                                         unsigned char *out, base_error *err) {
    plan half = {0};
    strata_result result = plan_decide_effects(input, &half, err);
    for (uint32_t i = 0; i < s->material_count && result == STRATA_OK; i++)
        out[i] = plan_material_effect(&half, &s->materials[i]) != NULL;
    free(half.effects);
    return result;
}
