// SPDX-License-Identifier: MIT
//
// kplus, max-heap: nodes (key, place) with the farthest at the root. Records stay where they were put, so
// that a step moves 8 bytes whatever the payload.
layout(std430) EXCLUDED buffer Nodes { STRATA_PAIR nodes[]; };

uvec2 node_at(uint at) { return STRATA_FROM_PAIR(nodes[at]); }
void put_node(uint at, uvec2 node) { nodes[at] = STRATA_TO_PAIR(node); }

// The farthest record and its place. The heap compares keys alone; where the root's children have its
// key, the last in order of all that have it is looked for, and given to the root.
uint farthest_place(uvec2 position, uvec2 slots, uvec2 record, out uvec2 farthest) {
    uvec2 root = node_at(slots.x);
    farthest = key_at(slots.x + root.y);
    if ((slots.y > 1u && node_at(slots.x + 1u).x == root.x) ||
        (slots.y > 2u && node_at(slots.x + 2u).x == root.x)) {
        uint at = 0u, place = root.y;
        for (uint i = 1u; i < slots.y; ++i) {
            uvec2 node = node_at(slots.x + i);
            if (node.x == root.x && key_at(slots.x + node.y).y > farthest.y) {
                farthest.y = key_at(slots.x + node.y).y;
                place = node.y;
                at = i;
            }
        }
        put_node(slots.x + at, root);
        root.y = place;
        put_node(slots.x, root);
    }
    return root.y;
}

// One more node: up from the end. The key of the root.
uint sift_up(uvec2 slots, uint count, uvec2 node) {
    uint at = count - 1u;
    while (at > 0u) {
        uvec2 parent = node_at(slots.x + (at - 1u) / 2u);
        if (node.x <= parent.x)
            break;
        put_node(slots.x + at, parent);
        at = (at - 1u) / 2u;
    }
    put_node(slots.x + at, node);
    return at == 0u ? node.x : node_at(slots.x).x;
}

// In place of the root: down from there. The key of the root.
uint sift_down(uvec2 slots, uvec2 node) {
    uint at = 0u, root = node.x;
    for (uint child = 1u; child < slots.y; child = 2u * at + 1u) {
        uvec2 larger = node_at(slots.x + child);
        if (child + 1u < slots.y) {
            uvec2 right = node_at(slots.x + child + 1u);
            if (right.x > larger.x) {
                larger = right;
                ++child;
            }
        }
        if (larger.x <= node.x)
            break;
        root = at == 0u ? larger.x : root;
        put_node(slots.x + at, larger);
        at = child;
    }
    put_node(slots.x + at, node);
    return root;
}

// After a record was stored at `place`: the key of the root.
uint settle(uvec2 slots, bool replaced, uint count, uint place, uvec2 record) {
    uvec2 node = uvec2(record.x, place);
    uint key;
    if (replaced)
        key = sift_down(slots, node);
    else
        key = sift_up(slots, count, node);
    return key;
}
