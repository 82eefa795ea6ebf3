/* SPDX-License-Identifier: MIT
 *
 * The plan and the installed modules as JSON, in the shapes that the guide documents.
 */
#include "plan/plan_internal.h"

#include <math.h>
#include <string.h>

static const char *const layouts[] = {"contiguous", "linked"};

/* Strings of modules and files are not to be trusted with their encoding. */
static json_t *text(const char *value) {
    if (!value)
        return json_null();
    json_t *valid = json_string(value);
    return valid ? valid : json_string("?");
}

static json_t *number(double value) {
    if (!isfinite(value))
        return json_null();
    if (floor(value) == value && fabs(value) < 9007199254740992.0)
        return json_integer((json_int_t)value);
    return json_real(value);
}

static json_t *floors(const plan *p, double cost) {
    double value = plan_floors(p, cost);
    return value == PLAN_NO_COST ? json_null() : number(value);
}

static json_t *knob_value(const strata_knob *knob, double value) {
    if (knob->type != STRATA_KNOB_CHOICE)
        return number(value);
    uint32_t count = 0;
    while (knob->choices && knob->choices[count])
        count++;
    return value >= 0.0 && value < (double)count ? text(knob->choices[(uint32_t)value])
                                                 : json_null();
}

/* ---- the plan -------------------------------------------------------------------------------- */

json_t *plan_json_effects(const plan *p) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < p->effect_count; i++) {
        const plan_effect *e = &p->effects[i];
        json_array_append_new(
            array, json_pack("{so so so sb sb sb so so}", "id", text(e->effect->id), "title",
                             text(e->effect->title), "module", text(e->effect->module->id),
                             "called_for", (int)e->called_for, "active", (int)e->active, "forced",
                             (int)e->forced, "evidence", text(e->evidence[0] ? e->evidence : NULL),
                             "reason", text(e->reason)));
    }
    return array;
}

json_t *plan_json_techniques(const plan *p) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < p->technique_count; i++) {
        const plan_technique *t = &p->techniques[i];
        json_t *settings = json_object();
        for (uint32_t k = 0; k < t->technique->knob_count; k++)
            json_object_set_new(settings, t->technique->knobs[k]->name,
                                knob_value(t->technique->knobs[k], t->values[k]));
        json_array_append_new(
            array,
            json_pack("{so so so so so so si so}", "technique", text(t->technique->id), "module",
                      text(t->technique->module->id), "stage", text(t->technique->stage), "title",
                      text(t->technique->title), "settings", settings, "cost", floors(p, t->cost),
                      "points", (int)t->points, "reason", text(t->reason)));
    }
    return array;
}

static json_t *left_out_json(const plan *p) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < p->left_out_count; i++) {
        const plan_left_out *l = &p->left_out[i];
        json_array_append_new(array,
                              json_pack("{so so so so si so}", "technique", text(l->technique->id),
                                        "module", text(l->technique->module->id), "stage",
                                        text(l->technique->stage), "cost", floors(p, l->cost),
                                        "points", (int)l->points, "reason", text(l->reason)));
    }
    return array;
}

static json_t *fragments_json(const plan *p) {
    if (!p->transparent)
        return json_null();
    json_t *planes = json_array(), *fields = json_array();
    for (uint32_t i = 0; i < p->payload.plane_count; i++)
        json_array_append_new(planes, json_integer(p->payload.plane_strides[i]));
    for (uint32_t i = 0; i < p->payload.field_count; i++) {
        const plan_field *f = &p->payload.fields[i];
        json_array_append_new(fields, json_pack("{so si sb}", "name", text(f->name), "channels",
                                                (int)f->channels, "exact", (int)f->exact));
    }
    double bytes = ceil(p->stats.transparent_fragments) * (double)p->bytes_per_fragment;
    return json_pack(
        "{so so si so so so so so}", "layout", text(p->captures ? layouts[p->layout] : NULL),
        "payload", text(costs_payload_name(p->payload.precision)), "transmittance_channels",
        (int)p->transmittance_channels, "bytes_per_fragment",
        p->captures ? number(p->bytes_per_fragment) : json_null(), "bytes",
        p->captures ? number(bytes) : json_null(), "bands",
        p->captures ? number(p->expected_bands) : json_null(), "planes", planes, "fields", fields);
}

static json_t *estimate_json(const strata_scene_stats *s) {
    return json_pack(
        "{so so so so so so so so so so so so so so}", "instances", number(s->instances),
        "opaque_draws", number((double)s->opaque_draws), "transparent_draws",
        number((double)s->transparent_draws), "opaque_triangles",
        number((double)s->opaque_triangles), "transparent_triangles",
        number((double)s->transparent_triangles), "transparent_fragments",
        number(round(s->transparent_fragments)), "covered_pixels", number(round(s->covered_pixels)),
        "mean_depth", number(s->mean_depth), "largest_depth", number(s->largest_depth),
        "opaque_objects", number((double)s->opaque_objects), "hidden_triangles",
        number(round(s->hidden_triangles)), "outside_triangles",
        number(round(s->outside_triangles)), "opaque_overdraw", number(round(s->opaque_overdraw)),
        "mean_optical_depth", number(s->mean_optical_depth));
}

/* What a budget turns, null when it turns nothing. */
static json_t *turned_json(const plan *p) {
    if (!p->turned)
        return json_null();
    return json_pack("{so so so so so}", "technique", text(p->turned->id), "knob",
                     text(p->turned->knobs[p->turned_knob]->name), "value", number(plan_turned(p)),
                     "least", number(p->turned_least), "most", number(p->turned_most));
}

json_t *plan_json(const plan *p) {
    json_t *facts = json_object(), *warnings = json_array();
    for (uint32_t i = 0; i < p->demand.count; i++)
        json_object_set_new(facts, p->demand.facts[i].id,
                            json_integer((json_int_t)p->demand.facts[i].value));
    for (uint32_t i = 0; i < p->warning_count; i++)
        json_array_append_new(warnings, text(p->warnings[i]));
    return json_pack("{so so so so so so so so so so so}", "facts", facts, "effects",
                     plan_json_effects(p), "estimate", estimate_json(&p->stats), "fragments",
                     fragments_json(p), "techniques", plan_json_techniques(p), "left_out",
                     left_out_json(p), "cost", floors(p, p->cost), "ms",
                     p->ms == PLAN_NO_COST ? json_null() : number(p->ms), "measured_on",
                     text(p->measured_on[0] ? p->measured_on : NULL), "turned", turned_json(p),
                     "warnings", warnings);
}

/* ---- installed modules ----------------------------------------------------------------------- */

static json_t *slots_json(const modules_technique_note *t) {
    static const char *const uses[] = {NULL, "consumes", "produces", "updates"};
    json_t *array = json_array();
    for (uint32_t i = 0; i < t->slot_count; i++) {
        const strata_slot_use *s = t->slots[i];
        json_t *read = json_array();
        for (uint32_t k = 0; k < BASE_COUNT(layouts); k++)
            if (s->layouts & (1u << k))
                json_array_append_new(read, text(layouts[k]));
        json_array_append_new(array, json_pack("{so so so sb}", "slot", text(s->slot), "use",
                                               text(s->use <= 3 ? uses[s->use] : NULL), "layouts",
                                               read, "optional", (int)s->optional));
    }
    return array;
}

static json_t *knobs_json(const modules_technique_note *t) {
    static const char *const types[] = {"int", "float", "choice"};
    json_t *array = json_array();
    for (uint32_t i = 0; i < t->knob_count; i++) {
        const strata_knob *k = t->knobs[i];
        json_t *knob = json_pack(
            "{so so so so so sb}", "name", text(k->name), "title", text(k->title), "type",
            text(k->type <= STRATA_KNOB_CHOICE ? types[k->type] : NULL), "unit", text(k->unit),
            "default", knob_value(k, k->preset), "trades_accuracy", (int)(k->trades_accuracy != 0));
        if (k->type == STRATA_KNOB_CHOICE) {
            json_t *choices = json_array();
            for (uint32_t c = 0; k->choices && k->choices[c]; c++)
                json_array_append_new(choices, text(k->choices[c]));
            json_object_set_new(knob, "choices", choices);
        } else {
            json_object_set_new(knob, "minimum", number(k->minimum));
            json_object_set_new(knob, "maximum", number(k->maximum));
        }
        json_array_append_new(array, knob);
    }
    return array;
}

static json_t *names_json(const char *const *names) {
    json_t *array = json_array();
    for (; names && *names; names++)
        json_array_append_new(array, text(*names));
    return array;
}

static json_t *promises_json(const strata_promises *p) {
    static const char *const orders[] = {"exact", "nearest", "approximate"};
    static const char *const determinisms[] = {"bit", "bounded"};
    if (!p)
        return json_null();
    return json_pack(
        "{so so so so}", "order",
        text(p->order <= STRATA_ORDER_APPROXIMATE ? orders[p->order] : NULL), "determinism",
        text(p->determinism <= STRATA_DETERMINISM_BOUNDED ? determinisms[p->determinism] : NULL),
        "largest_depth", p->largest_depth ? number(p->largest_depth) : json_null(), "memory",
        text(p->memory));
}

static json_t *cost_json(const strata_cost_model *c) {
    if (!c)
        return json_null();
    return json_pack("{so so so so so so so so so so}", "frame", number(c->frame), "per_pixel",
                     number(c->per_pixel), "per_fragment", number(c->per_fragment),
                     "per_fragment_log2_depth", number(c->per_fragment_log2_depth), "per_triangle",
                     number(c->per_triangle), "per_depth", number(c->per_depth), "per_depth_pixel",
                     number(c->per_depth_pixel), "per_depth_fragment",
                     number(c->per_depth_fragment), "per_depth_triangle",
                     number(c->per_depth_triangle), "per_object", number(c->per_object));
}

static json_t *technique_json(const modules_technique_note *t) {
    return json_pack("{so so so so so so so so so so}", "id", text(t->id), "title", text(t->title),
                     "reference", text(t->reference), "stage", text(t->stage), "slots",
                     slots_json(t), "knobs", knobs_json(t), "promises", promises_json(t->promises),
                     "cost", cost_json(t->cost), "needs", names_json(t->needs), "prefers",
                     names_json(t->prefers));
}

static json_t *effect_json(const modules_effect_note *e) {
    json_t *payload = json_array(), *needs = json_array();
    for (uint32_t i = 0; i < e->field_count; i++)
        json_array_append_new(payload, json_pack("{so si sb}", "name", text(e->payload[i]->name),
                                                 "channels", (int)e->payload[i]->channels, "exact",
                                                 (int)e->payload[i]->exact));
    for (uint32_t i = 0; i < e->need_count; i++)
        json_array_append_new(needs,
                              json_pack("{so so}", "fact", text(e->called_for_by[i]->fact),
                                        "threshold", number(e->called_for_by[i]->threshold)));
    return json_pack("{so so so si sb si so so}", "id", text(e->id), "title", text(e->title),
                     "reference", text(e->reference), "transmittance_channels",
                     (int)e->transmittance_channels, "sequential",
                     (int)((e->flags & STRATA_EFFECT_SEQUENTIAL) != 0), "priority",
                     (int)e->priority, "payload", payload, "called_for_by", needs);
}

json_t *plan_json_modules(const modules_note *const *notes, uint32_t count) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) {
        const modules_note *m = notes[i];
        json_t *techniques = json_array(), *effects = json_array();
        for (uint32_t k = 0; k < m->technique_count; k++)
            json_array_append_new(techniques, technique_json(&m->techniques[k]));
        for (uint32_t k = 0; k < m->effect_count; k++)
            json_array_append_new(effects, effect_json(&m->effects[k]));
        json_array_append_new(array, json_pack("{so so so so so so so}", "id", text(m->id), "title",
                                               text(m->title), "version", text(m->version),
                                               "licence", text(m->licence), "path", text(m->path),
                                               "techniques", techniques, "effects", effects));
    }
    return array;
}
