/* SPDX-License-Identifier: MIT
 *
 * Uses of slots that many techniques have in common.
 */
#ifndef STRATA_PLUGINS_SLOTS_H
#define STRATA_PLUGINS_SLOTS_H

#include "strata/strata.h"

/* Of whoever draws the transparent geometry, and of whoever folds it. */
static const strata_slot_use slots_draws = {.struct_size = sizeof(strata_slot_use),
                                            .use = STRATA_SLOT_CONSUMES,
                                            .slot = "draws.transparent/1"};
static const strata_slot_use slots_limit = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_CONSUMES, .slot = "limit/1"};
static const strata_slot_use slots_fragments = {.struct_size = sizeof(strata_slot_use),
                                                .use = STRATA_SLOT_CONSUMES,
                                                .slot = "fragments/1",
                                                .layouts = 1u << STRATA_FRAGMENTS_CONTIGUOUS |
                                                           1u << STRATA_FRAGMENTS_LINKED};
static const strata_slot_use slots_color = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_UPDATES, .slot = "color/1"};
static const strata_slot_use slots_bound = {.struct_size = sizeof(strata_slot_use),
                                            .use = STRATA_SLOT_UPDATES,
                                            .slot = "bound/1",
                                            .optional = 1};
/* Of whoever turns sub-pixels into pixels (shared/filtering.h). */
static const strata_slot_use slots_image = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_PRODUCES, .slot = "image/1"};
static const strata_slot_use slots_image_bound = {
    .struct_size = sizeof(strata_slot_use), .use = STRATA_SLOT_PRODUCES, .slot = "image.bound/1"};

#endif
