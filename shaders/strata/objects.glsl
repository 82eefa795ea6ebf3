// SPDX-License-Identifier: MIT
//
// objects/1: what can be culled one by one, an instance of a mesh or of one of its clusters. Object i
// is drawn with StrataRecords[i]. Written by host/scene/upload*.c, whose structs mirror these; there
// for techniques that name the slot. STRATA_STATES: qualifier of the states.
#ifndef STRATA_OBJECTS_GLSL
#define STRATA_OBJECTS_GLSL

// StrataObject.flags
const uint STRATA_OBJECT_TRANSPARENT = 1u; // drawn with draws.transparent/1, else draws.opaque/1
const uint STRATA_OBJECT_UNBOUNDED = 2u;   // its bounds are not known
const uint STRATA_OBJECT_NEXT = 4u;        // the same indices as the object before it
const uint STRATA_OBJECT_CONTINUES = 8u;   // the indices that follow those of the object before it

struct StrataObject {
    vec3 lower; // bounds of its vertices in object space, exact
    uint flags;
    vec3 upper;
    uint first_index;
    uint index_count;
    uint clusters; // of its instance, from this one on; draws of all name the first one's record
    uint reserved[2];
};

layout(std430) readonly buffer StrataObjects { StrataObject strata_objects[]; };

// Why an object was drawn or culled in this frame; those from STRATA_OUTSIDE on are culled.
const uint STRATA_UNTESTED = 0u; // nobody culls it
const uint STRATA_KEPT = 1u;     // drawn first: seen in the last frame, or large
const uint STRATA_APPEARED = 2u; // drawn second: nothing that was drawn first hides it
const uint STRATA_TOO_NEAR = 3u; // drawn untested: it reaches the eye's plane, or has no bounds
const uint STRATA_OUTSIDE = 4u;  // of the view
const uint STRATA_SLIPPED = 5u;  // between the pixels' centres
const uint STRATA_OCCLUDED = 6u;

#ifndef STRATA_STATES
#define STRATA_STATES readonly
#endif
layout(std430) STRATA_STATES buffer StrataObjectStates { uint strata_object_states[]; };

#endif
