// SPDX-License-Identifier: MIT
//
// kplus, max-array on software rasterisers, which gather texels as vectors, and words of a buffer one by
// one: the keys of a pixel's slots as texels besides, and as place k what else is known of it. Of a block of
// pixels (slots.glsl) first all texels of place 0, then of place 1 ..; rows mean nothing.
layout(r32ui) uniform uimage2D placed;

const uint PLACED_ROW = 4096u; // as in kplus.c

struct Places {
    uint first, step;
};
Places places_of(uvec2 position) {
    Block block = block_of(position);
    return Places(block.first * (params.k + 1u) + block.inner, block.pixels);
}

uint texel_of(Places places, uint place) { return places.first + place * places.step; }
ivec2 place_texel(uint at) { return ivec2(at % PLACED_ROW, at / PLACED_ROW); }

uint placed_at(uint at) { return imageLoad(placed, place_texel(at)).x; }

void put_placed(uint at, uint word) { imageStore(placed, place_texel(at), uvec4(word)); }
