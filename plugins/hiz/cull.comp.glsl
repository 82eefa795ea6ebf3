// SPDX-License-Identifier: MIT
//
// hiz: which objects are drawn in a round, one invocation an object.
//   HIZ_FIRST    opaque ones in the view, of them those that were seen in the last frame; or all of
//                them, where nothing is tested against depth (HIZ_FRUSTUM)
//   HIZ_SECOND   opaque ones that were not drawn and are not hidden by those that were
//   HIZ_LAST     transparent ones that are not hidden by any opaque one
// Whatever the first round does is right: what it left out the second tests against what it drew.
#define STRATA_STATES
#include "strata/objects.glsl"
#include "strata/scan.glsl"
#include "extent.glsl"
#include "marks.glsl"
#ifndef HIZ_FRUSTUM
#include "pyramid.glsl"
#endif
#ifdef HIZ_CERTIFY
#define HIZ_CERTIFICATES writeonly
#include "certificates.glsl"
#endif

const uint HIZ_KEEP = 0u, HIZ_NONE = 1u, HIZ_ALL = 2u, HIZ_RANDOM = 3u; // history

layout(std430) writeonly buffer Marks { uint marks[]; };
layout(std430) buffer Seen { uint ever, seen[]; }; // in the last frame; ever: there was one
STRATA_PARAMS {
    uint count, taps;
    uint history, frame; // HIZ_KEEP ..; number of the frame
    uvec4 offsets[4]; // of the levels of the pyramid
} params;

#ifndef HIZ_FRUSTUM
// The farthest depth of the texels of a level that cover first .. last.
float farthest(int level, ivec2 first, ivec2 last) {
    uint offset = params.offsets[level / 4][level % 4];
    float depth = 1.0;
    for (int y = first.y >> level; y <= last.y >> level; ++y)
        for (int x = first.x >> level; x <= last.x >> level; ++x)
            depth = min(depth, depth_at(level, offset, ivec2(x, y)));
    return depth;
}

// On the level where 2 x 2 texels cover it; if these do not hide it, on finer ones with more of them.
bool hidden(uint item, Extent e) {
    int wide = max(e.last.x - e.first.x, e.last.y - e.first.y);
    int level = wide > 0 ? findMSB(wide) : 0;
    if (any(greaterThan((e.last >> level) - (e.first >> level), ivec2(1))))
        ++level;
    for (uint taps = 2u; taps <= params.taps; taps *= 2u) {
        float depth = farthest(level, e.first, e.last);
        if (e.nearest < depth) {
#ifdef HIZ_CERTIFY
            certificates[item] = Certificate(uvec2(e.first), uvec2(e.last), e.nearest, depth,
                                             uint(level), 0u);
#endif
            return true;
        }
        if (--level < 0)
            break;
    }
    return false;
}
#endif

// Without a history: what covers much of the image is drawn first.
bool is_large(Extent e) {
    const int PARTS = 1024;
    ivec2 size = e.last - e.first + 1, frame = ivec2(strata_frame_size.xy);
    return size.x * size.y >= max(frame.x * frame.y / PARTS, 1);
}

#ifdef HIZ_FIRST
bool was_seen(uint item, Extent e) {
    if (params.history == HIZ_RANDOM) {
        uint h = (item ^ params.frame * 0x9e3779b9u) * 0x85ebca6bu;
        h = (h ^ h >> 15) * 0xc2b2ae35u;
        return (h ^ h >> 13) >> 31 != 0u;
    }
    if (params.history != HIZ_KEEP)
        return params.history == HIZ_ALL;
    return ever != 0u ? seen[item] != 0u : is_large(e);
}
#endif

uint judge(uint item, Extent e) {
    if (e.outside)
        return STRATA_OUTSIDE;
    if (e.near)
        return STRATA_TOO_NEAR;
    if (any(greaterThan(e.first, e.last)))
        return STRATA_SLIPPED;
#if defined(HIZ_FRUSTUM)
    return STRATA_KEPT;
#elif defined(HIZ_FIRST)
    return was_seen(item, e) ? STRATA_KEPT : STRATA_OCCLUDED;
#elif defined(HIZ_SECOND)
    return hidden(item, e) ? STRATA_OCCLUDED : STRATA_APPEARED;
#else
    return hidden(item, e) ? STRATA_OCCLUDED : STRATA_KEPT;
#endif
}

void main() {
    uint item = strata_item();
    if (item >= params.count)
        return;
    StrataObject object = strata_objects[item];
    bool transparent = (object.flags & STRATA_OBJECT_TRANSPARENT) != 0u;
    uint mark = (object.flags & (STRATA_OBJECT_NEXT | STRATA_OBJECT_CONTINUES)) != 0u ? JOINS : 0u;
#ifdef HIZ_LAST
    bool ours = transparent;
#else
    bool ours = !transparent;
#endif
#ifdef HIZ_SECOND
    if (item == 0u)
        ever = 1u;
#endif
    uint state = strata_object_states[item];
    if (ours) {
        bool bounded = (object.flags & STRATA_OBJECT_UNBOUNDED) == 0u;
        uint judged = STRATA_TOO_NEAR;
        if (bounded)
            judged = judge(item, extent_of(strata_record_at(item), object.lower, object.upper));
        bool draws = judged < STRATA_OUTSIDE;
#ifdef HIZ_SECOND
        bool drawn = state < STRATA_OUTSIDE;
        seen[item] = uint(draws);
        draws = draws && !drawn;
        if (drawn)
            judged = state;
#endif
        state = judged;
        if (draws)
            mark |= DRAWN;
        strata_object_states[item] = state;
    }
    marks[item] = mark;
}
