// SPDX-License-Identifier: MIT
//
// kplus, max-array: records stay where they were put. One walk over the keys finds the farthest, which a
// nearer fragment replaces, and the farthest of the others, by which the pixel culls then. Faster than a
// heap for few slots.
#ifdef TEXELS
#define KEY(at) placed_at(at)
#else
#define KEY(at) key_at(at).x
#endif

uint other_key; // the farthest of the others, as the walk found it

// Of all records of a full pixel: the farthest and its place. Orders are read where they decide.
uint farthest_place(uvec2 position, uvec2 slots, uvec2 record, out uvec2 farthest) {
    uint place = 0u;
    farthest = uvec2(0u);
    other_key = 0u;
#ifdef TEXELS
    Places places = places_of(position);
    uint at = places.first, step = places.step;
#else
    uint at = slots.x, step = 1u;
#endif
    for (uint i = 0u; i < slots.y; ++i, at += step) {
        uint key = KEY(at);
        bool behind = key >= farthest.x;
        other_key = max(other_key, behind ? farthest.x : key);
        farthest.x = behind ? key : farthest.x;
        place = behind ? i : place;
    }
    if (farthest.x == other_key || farthest.x == record.x) {
        for (uint i = 0u; i < slots.y; ++i) {
            uvec2 key = key_at(slots.x + i);
            if (key.x == farthest.x && key.y >= farthest.y) {
                farthest.y = key.y;
                place = i;
            }
        }
    }
    return place;
}

// After a record was stored: the key that a full pixel culls by. One whose last slot was taken just now
// has not been walked over: it culls nothing yet.
uint settle(uvec2 slots, bool replaced, uint count, uint place, uvec2 record) {
    return replaced ? max(other_key, record.x) : STRATA_FAR_KEY;
}
