/* SPDX-License-Identifier: MIT
 *
 * Records of fragments/1 as captures hold them, and the precision of their payload.
 */
#ifndef STRATA_PLUGINS_RECORDS_H
#define STRATA_PLUGINS_RECORDS_H

#include "strata/strata.h"

static const char *const records_payload_names[STRATA_MAX_PLANES] = {
    "StrataPayload0", "StrataPayload1", "StrataPayload2", "StrataPayload3",
    "StrataPayload4", "StrataPayload5", "StrataPayload6", "StrataPayload7"};

/* Bytes of plain transparency's payload, by STRATA_PAYLOAD_*; what estimate() reckons with. */
static const uint64_t records_payload_bytes[] = {16, 8, 4};

static const char *const records_payload_choices[] = {"float", "half", "unorm8", NULL};
static const strata_knob records_payload_knob = {.struct_size = sizeof(strata_knob),
                                                 .type = STRATA_KNOB_CHOICE,
                                                 .name = "payload",
                                                 .title = "precision of what a record holds",
                                                 .maximum = 2,
                                                 .choices = records_payload_choices,
                                                 .trades_accuracy = 1};

/* A pool with planes for keys, for one thing more of 8 bytes a record (a block's name, or NULL) and
 * for the payload. `expected`: records to begin with, 0 = the host's guess. */
static inline strata_result records_create(const strata_gpu *gpu, const strata_view *view,
                                           const char *more, uint64_t expected, strata_pool *out) {
    strata_pool_desc desc = {.struct_size = sizeof desc,
                             .label = "fragments",
                             .counter_name = "StrataFragmentPool",
                             .plane_names = {"StrataKeys", more},
                             .plane_strides = {8, more ? 8 : 0},
                             .plane_count = more ? 2 : 1,
                             .expected = expected};
    if (view->payload_plane_count > STRATA_MAX_PLANES - desc.plane_count)
        return STRATA_ERROR_UNSUPPORTED;
    for (uint32_t i = 0; i < view->payload_plane_count; ++i) {
        desc.plane_names[desc.plane_count] = records_payload_names[i];
        desc.plane_strides[desc.plane_count++] = view->payload_plane_strides[i];
    }
    return gpu->pool_create(gpu->self, &desc, out);
}

#endif
