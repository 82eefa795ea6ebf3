// SPDX-License-Identifier: MIT
//
// kplus, array and heap: one fragment into its pixel's slots, the k+-buffer itself. Exclusion is a lock
// a pixel (LOCK), the section of an interlock around insert() (STRATA_INTERLOCK), or none where the device
// orders read-modify-writes by itself. HEAP chooses the structure. StrataPayload and strata_payload_store
// are the including source's.
#include "strata/interlock.glsl"
#ifdef LOCK
#define EXCLUDED coherent
#else
#define EXCLUDED STRATA_INTERLOCKED
#endif
#define STRATA_RECORDS EXCLUDED
#define STRATA_KEYS STRATA_PAIR
#include "slots.glsl"
#define CELLS EXCLUDED
#include "cells.glsl"
#include "strata/loss.glsl"

// Devices that order a pixel's accesses by themselves need no fence; one of their drivers cannot compile
// it in a fragment shader.
#ifdef FENCES
#define EXCLUDE_FENCE memoryBarrierBuffer()
#else
#define EXCLUDE_FENCE
#endif

#ifdef LOCK
layout(std430) buffer Failures { uint failures; };
#endif

uvec2 key_at(uint slot) { return STRATA_FROM_PAIR(strata_keys[slot]); }

#ifdef HEAP
#include "heap.glsl"
#else
#include "array.glsl"
#endif

// Behind all records of a full pixel, as seen at any time: such a fragment can never come in. One at the
// farthest key may: its order decides.
bool culled(uvec2 cell, uvec2 record) { return record.x > cell.x || cell.y == CELL_CLOSED.y; }

void store_record(uvec2 position, uvec2 slots, uint place, uvec2 record, StrataPayload payload) {
    strata_keys[slots.x + place] = STRATA_TO_PAIR(record);
    strata_payload_store(slots.x + place, payload);
#ifdef TEXELS
    put_placed(texel_of(places_of(position), place), record.x);
#endif
}

// With the pixel excluded: its next state. Slots beyond the count were never written and are never read.
// Where a record is dropped, this one or the one whose place it takes, `payload` becomes that one's, for
// a certificate.
uvec2 place_record(uvec2 position, uvec2 cell, uvec2 record, inout StrataPayload payload,
                   inout bool drops) {
    uvec2 slots = slots_of(position);
    uint count = cell.y & CELL_COUNT, place = count, roomy = cell.y & CELL_ROOMY;
    bool full = cell.x != STRATA_NO_KEY;
    if (full) {
        uvec2 farthest;
        place = farthest_place(position, slots, record, farthest);
        drops = true;
        if (strata_before(farthest, record))
            return cell;
    } else {
        ++count;
    }
    StrataPayload kept = payload;
#ifdef STRATA_BOUND
    if (full)
        payload = strata_payload_load(slots.x + place);
#endif
    store_record(position, slots, place, record, kept);
    if (roomy != 0u)
        return uvec2(STRATA_NO_KEY, count | roomy);
    uint key = settle(slots, full, count, place, record);
    return uvec2(count < slots.y ? STRATA_NO_KEY : key, count);
}

// A fragment that culled() has let pass. Says whether one is dropped; `payload` as place_record() has it.
bool insert(uvec2 position, uvec2 cell, uvec2 record, inout StrataPayload payload) {
    bool drops = false;
#ifdef LOCK
    uint pixel = block_index(position);
    if ((cell.y & CELL_ROOMY) != 0u) { // every fragment has a slot: a place is all it takes
        uint place = atomicAdd(cells[pixel].y, 1u) & CELL_COUNT;
        store_record(position, slots_of(position), place, record, payload);
        return false;
    }
    bool waiting = true;
    for (uint i = 0u; i < params.tries && waiting; ++i) {
        cell.y = atomicOr(cells[pixel].y, CELL_LOCKED);
        if ((cell.y & CELL_LOCKED) == 0u) {
            EXCLUDE_FENCE;
            cell.x = cells[pixel].x;
            cell = place_record(position, cell, record, payload, drops);
            cells[pixel].x = cell.x;
            EXCLUDE_FENCE;
            atomicExchange(cells[pixel].y, cell.y);
            waiting = false;
        }
    }
    if (waiting)
        atomicAdd(failures, 1u);
#else
#ifdef STRATA_INTERLOCK // others were here since the cell was read
    cell = cell_at(position);
#endif
    put_cell(position, place_record(position, cell, record, payload, drops));
#endif
    return drops;
}
