// SPDX-License-Identifier: MIT
//
// fpc: how the first passes share the pixels of a band out, and what a pixel adds to the four sums:
// itself, its elements, its chunks, and its joints if it has more than one chunk.

uint pixel_at(uint i) { return strata_item() * PIXELS_PER_INVOCATION + i; }

uint group_count() {
    uint pixels_a_group = PIXELS_PER_INVOCATION * STRATA_GROUP;
    return (strata_pixel_count() + pixels_a_group - 1u) / pixels_a_group;
}

// Fragments of a pixel that fpc folds; 0 for pixels that are not its business.
uint count_of(uint pixel) {
    uint count = pixel < strata_pixel_count() ? strata_range_at(pixel).y : 0u;
    return count >= FPC_LEAST ? count : 0u;
}

uvec4 share_of(uint count) {
    uint parts = count / CHUNK + uint(count % CHUNK != 0u);
    return uvec4(uint(count > 0u), count, parts, parts > 1u ? parts : 0u);
}

uvec4 add(uvec4 a, uvec4 b) {
    return uvec4(strata_add(a.x, b.x), strata_add(a.y, b.y), strata_add(a.z, b.z),
                 strata_add(a.w, b.w));
}

uvec4 scan(uvec4 value, out uvec4 total) {
    uvec4 before;
    before.x = strata_scan(value.x, total.x);
    before.y = strata_scan(value.y, total.y);
    before.z = strata_scan(value.z, total.z);
    before.w = strata_scan(value.w, total.w);
    return before;
}
