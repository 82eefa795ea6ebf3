/* SPDX-License-Identifier: MIT
 *
 * Effect module `over`: plain transparency. One premultiplied colour a fragment, one transmittance
 * for all channels. Called for by materials with alphaMode BLEND.
 */
#include "over_glsl.h"
#include "strata/strata.h"

static const strata_field color = {
    .struct_size = sizeof(strata_field), .channels = 4, .name = "color"};
static const strata_field *const payload[] = {&color};

static const strata_need blend = {
    .struct_size = sizeof(strata_need), .fact = "materials.blend", .threshold = 1};
static const strata_need *const needs[] = {&blend};

static const strata_effect over = {
    .struct_size = sizeof(strata_effect),
    .flags = STRATA_EFFECT_AFFINE | STRATA_EFFECT_COVERS,
    .id = "over",
    .title = "transparency: surfaces cover what lies behind them in part",
    .reference = "Porter and Duff, Compositing Digital Images, SIGGRAPH 1984",
    .transmittance_channels = 1,
    .payload = payload,
    .field_count = 1,
    .called_for_by = needs,
    .need_count = 1,
    .priority = 0,
    .glsl = &over_glsl,
};
static const strata_effect *const effects[] = {&over};

STRATA_EXPORT extern const strata_module strata_module_v1;
const strata_module strata_module_v1 = {
    .struct_size = sizeof(strata_module),
    .abi_version = STRATA_ABI_VERSION,
    .min_host_version = STRATA_VERSION(1, 0),
    .id = "over",
    .title = "Plain transparency",
    .version = "1.0",
    .licence = "MIT",
    .effects = effects,
    .effect_count = 1,
};
