/* SPDX-License-Identifier: MIT
 *
 * An effect of a third party: materials that emit light add it and hide nothing. It gets the
 * materials that its need counts; one of a higher priority would take them away.
 */
#include "glow_glsl.h"
#include "strata/strata.h"

static const strata_field color = {
    .struct_size = sizeof(strata_field), .channels = 4, .name = "color"};
static const strata_field *const payload[] = {&color};

static const strata_need emissive = {
    .struct_size = sizeof(strata_need), .fact = "materials.emissive", .threshold = 1};
static const strata_need *const needs[] = {&emissive};

static const strata_effect glow = {
    .struct_size = sizeof(strata_effect),
    .id = "glow",
    .title = "surfaces add light",
    .transmittance_channels = 1,
    .payload = payload,
    .field_count = 1,
    .called_for_by = needs,
    .need_count = 1,
    .glsl = &glow_glsl,
};
static const strata_effect *const effects[] = {&glow};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "glow",
    .title = "Glow",
    .version = "1.0",
    .licence = "MIT",
    .effects = effects,
    .effect_count = 1,
};
