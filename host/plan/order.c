/* SPDX-License-Identifier: MIT
 *
 * The order of a frame: producers of a slot before its updaters before its consumers, and beyond
 * that by stage, then id.
 */
#include "plan/plan_internal.h"

#include <stdlib.h>
#include <string.h>

/* What orders nothing. The one declared feedback: techniques that choose draws read the depth that
 * surface leaves, in a second round of the same frame. And captures read colours as surface left
 * them, before anything is folded: their stage says so. */
static int is_unordered(const plan_candidate *c, const strata_slot_use *use) {
    if (use->use != STRATA_SLOT_CONSUMES)
        return 0;
    return (c->role == PLAN_DRAWS && strcmp(use->slot, "depth/1") == 0) ||
           (c->role == PLAN_CAPTURE && strcmp(use->slot, "color/1") == 0);
}

static int rank(uint32_t use) {
    return use == STRATA_SLOT_PRODUCES ? 0 : use == STRATA_SLOT_UPDATES ? 1 : 2;
}

/* Whether some slot demands that a runs before b. Updaters of one slot follow their stages. */
static int precedes(const plan_candidate *a, const plan_candidate *b) {
    for (uint32_t i = 0; i < a->note->slot_count; i++) {
        const strata_slot_use *first = a->note->slots[i];
        for (uint32_t k = 0; k < b->note->slot_count; k++) {
            const strata_slot_use *second = b->note->slots[k];
            if (strcmp(first->slot, second->slot) != 0 || is_unordered(a, first) ||
                is_unordered(b, second))
                continue;
            if (rank(first->use) < rank(second->use))
                return 1;
            if (first->use == STRATA_SLOT_UPDATES && second->use == STRATA_SLOT_UPDATES &&
                a->role < b->role)
                return 1;
        }
    }
    return 0;
}

/* Names the techniques that wait for each other, by walking back from one that waits. */
static strata_result fail_cycle(const plan_work *w, const uint32_t *nodes, uint32_t count,
                                const unsigned char *placed) {
    base_text text = {0};
    uint32_t at = 0, steps = 0;
    unsigned char *seen = base_calloc(count, 1);
    if (!seen)
        return base_fail(w->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
    while (placed[at])
        at++;
    for (; !seen[at] || steps < count; steps++) { /* after count steps it is on the cycle */
        if (steps >= count)
            seen[at] = 1;
        uint32_t before = 0;
        while (placed[before] || before == at ||
               !precedes(&w->candidates[nodes[before]], &w->candidates[nodes[at]]))
            before++;
        if (steps >= count)
            base_text_add(&text, "%s%s", text.length ? " waits for " : "",
                          w->candidates[nodes[at]].note->id);
        at = before;
    }
    base_text_add(&text, " waits for %s", w->candidates[nodes[at]].note->id);
    strata_result result =
        base_fail(w->err, STRATA_ERROR_INVALID_ARGUMENT,
                  "these techniques cannot be ordered by their slots: %s", text.data);
    base_text_free(&text);
    free(seen);
    return result;
}

strata_result plan_order(const plan_work *w, uint32_t *order, uint32_t *count) {
    strata_result result = STRATA_OK;
    uint32_t nodes_count = 0;
    uint32_t *nodes = base_calloc(w->count, sizeof *nodes);
    unsigned char *placed = base_calloc(w->count, 1);
    *count = 0;
    if (!nodes || !placed) {
        result = base_fail(w->err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "no memory for a plan");
        goto cleanup;
    }
    for (uint32_t i = 0; i < w->count; i++)
        if (w->candidates[i].chosen)
            nodes[nodes_count++] = i;
    while (*count < nodes_count) {
        uint32_t next = nodes_count;
        for (uint32_t i = 0; i < nodes_count && next == nodes_count; i++) {
            int waits = placed[i];
            for (uint32_t k = 0; k < nodes_count && !waits; k++)
                waits = k != i && !placed[k] &&
                        precedes(&w->candidates[nodes[k]], &w->candidates[nodes[i]]);
            if (!waits)
                next = i;
        }
        if (next == nodes_count) {
            result = fail_cycle(w, nodes, nodes_count, placed);
            goto cleanup;
        }
        placed[next] = 1;
        order[(*count)++] = nodes[next];
    }
cleanup:
    free(nodes);
    free(placed);
    return result;
}
