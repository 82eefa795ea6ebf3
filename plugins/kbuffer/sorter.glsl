// SPDX-License-Identifier: MIT
//
// kbuffer: what a pixel holds, in WORDS words, and the streaming sorter over them. All zero is the empty
// state, so that a clear makes it.
//
//   0        fragments that arrived
//   1, 2     key and order of the last fragment folded; bit 31 of the key: the order was lost
//   3..6     colour of the walk
//   7..      its transmittance: bits against those of 1.0, one word or three
//   ERRORS.. the bounds of its errors, four words and one or three, where a certificate is asked for
//   STATE..  K entries, nearest first, the empty ones last: complement of the key, order, payload
#include "strata/fold.glsl"
#include "strata/key.glsl"

const uint LOST = 0x80000000u;
const uint ONE = 0x3f800000u;
#define ERRORS (7 + STRATA_CHANNELS)
#ifdef STRATA_BOUND
#define STATE (ERRORS + 4 + STRATA_CHANNELS)
#else
#define STATE ERRORS
#endif
#define ENTRY (2 + STRATA_PAYLOAD_WORDS)
#define WORDS (STATE + K * ENTRY)
#ifdef ATTACHMENTS
#define STRATA_EACH_COUNT ((WORDS + 3) / 4)
#include "strata/each.glsl"
#endif

uint words[WORDS];

// Words first .. first + 3 from a texel, as far as there are any.
#define WORDS_PUT(first, texel)                                                                    \
    {                                                                                              \
        uvec4 four = texel;                                                                        \
        for (int w = 0; w < 4; ++w)                                                                \
            if (first + w < WORDS)                                                                 \
                words[min(first + w, WORDS - 1)] = four[w];                                        \
    }

uvec2 entry_id(int i) { return uvec2(~words[STATE + i * ENTRY], words[STATE + i * ENTRY + 1]); }

#if STRATA_CHANNELS == 3
#define TRANSMITTANCE_LOAD(at, zero)                                                               \
    uintBitsToFloat(uvec3(words[at], words[at + 1], words[at + 2]) ^ zero)
#define TRANSMITTANCE_STORE(at, value, zero)                                                       \
    for (int c = 0; c < 3; ++c)                                                                    \
        words[at + c] = floatBitsToUint(value[c]) ^ zero;
#else
#define TRANSMITTANCE_LOAD(at, zero) uintBitsToFloat(words[at] ^ zero)
#define TRANSMITTANCE_STORE(at, value, zero) words[at] = floatBitsToUint(value) ^ zero;
#endif

vec4 color_load(int at) {
    return uintBitsToFloat(uvec4(words[at], words[at + 1], words[at + 2], words[at + 3]));
}

void color_store(int at, vec4 value) {
    for (int c = 0; c < 4; ++c)
        words[at + c] = floatBitsToUint(value[c]);
}

StrataElement walk_load() {
    StrataElement walk;
    walk.color = color_load(3);
    walk.transmittance = TRANSMITTANCE_LOAD(7, ONE);
#ifdef STRATA_BOUND
    walk.color_error = color_load(ERRORS);
    walk.transmittance_error = TRANSMITTANCE_LOAD(ERRORS + 4, 0u);
#endif
    return walk;
}

void walk_store(StrataElement walk) {
    color_store(3, walk.color);
    TRANSMITTANCE_STORE(7, walk.transmittance, ONE)
#ifdef STRATA_BOUND
    color_store(ERRORS, walk.color_error);
    TRANSMITTANCE_STORE(ERRORS + 4, walk.transmittance_error, 0u)
#endif
}

// Entry i is the next of the walk. One that lies in front of the last was folded too late.
void fold_entry(int i, inout StrataElement walk) {
    uvec2 id = entry_id(i);
    bool lost = strata_before(id, uvec2(words[1] & ~LOST, words[2])) || (words[1] & LOST) != 0u;
    words[1] = id.x | (lost ? LOST : 0u);
    words[2] = id.y;
    uint payload[STRATA_PAYLOAD_WORDS];
    for (int w = 0; w < STRATA_PAYLOAD_WORDS; ++w)
        payload[w] = words[STATE + i * ENTRY + 2 + w];
    strata_fold_step(walk, strata_event(strata_payload_decode(payload)));
}

// The nearest of the K entries and the incoming one goes into the walk, once there are K + 1.
void sorter_insert(uvec2 id, uint payload[STRATA_PAYLOAD_WORDS]) {
    uint incoming[ENTRY];
    incoming[0] = ~id.x;
    incoming[1] = id.y;
    for (int w = 0; w < STRATA_PAYLOAD_WORDS; ++w)
        incoming[2 + w] = payload[w];
    words[0] += 1u;
    for (int i = 0; i < K; ++i) {
        bool nearer = strata_before(uvec2(~incoming[0], incoming[1]), entry_id(i));
        for (int w = 0; w < ENTRY; ++w) {
            uint other = words[STATE + i * ENTRY + w];
            words[STATE + i * ENTRY + w] = nearer ? incoming[w] : other;
            incoming[w] = nearer ? other : incoming[w];
        }
    }
    if (~incoming[0] == STRATA_NO_KEY)
        return; // an entry was empty
    StrataElement walk = walk_load();
    fold_entry(0, walk);
    walk_store(walk);
    for (int w = 0; w < (K - 1) * ENTRY; ++w)
        words[STATE + w] = words[STATE + ENTRY + w];
    for (int w = 0; w < ENTRY; ++w)
        words[STATE + (K - 1) * ENTRY + w] = incoming[w];
}

// What is left at the end of the stream.
StrataElement sorter_flush() {
    StrataElement walk = walk_load();
    for (int i = 0; i < K; ++i)
        if (entry_id(i).x != STRATA_NO_KEY)
            fold_entry(i, walk);
    return walk;
}
