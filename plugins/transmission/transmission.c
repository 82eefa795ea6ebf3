/* SPDX-License-Identifier: MIT
 *
 * Effect module `transmission`: thin coloured glass. Six channels a fragment (what it sends, what
 * it lets through), three transmittances. Called for by materials with KHR_materials_transmission.
 */
#include "strata/strata.h"
#include "transmission_glsl.h"

static const strata_field glow = {
    .struct_size = sizeof(strata_field), .channels = 3, .name = "glow"};
static const strata_field through = {
    .struct_size = sizeof(strata_field), .channels = 3, .name = "through"};
static const strata_field *const payload[] = {&glow, &through};

static const strata_need need = {
    .struct_size = sizeof(strata_need), .fact = "materials.transmission", .threshold = 1};
static const strata_need *const needs[] = {&need};

static const strata_effect transmission = {
    .struct_size = sizeof(strata_effect),
    .flags = STRATA_EFFECT_AFFINE | STRATA_EFFECT_COVERS,
    .id = "transmission",
    .title = "coloured transmission through thin sheets",
    .reference = "KHR_materials_transmission, glTF 2.0",
    .transmittance_channels = 3,
    .payload = payload,
    .field_count = 2,
    .called_for_by = needs,
    .need_count = 1,
    .priority = 1,
    .glsl = &transmission_glsl,
};
static const strata_effect *const effects[] = {&transmission};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "transmission",
    .title = "Coloured transmission",
    .version = "1.0",
    .licence = "MIT",
    .effects = effects,
    .effect_count = 1,
};
