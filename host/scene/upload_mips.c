/* SPDX-License-Identifier: MIT
 *
 * Mip levels on the CPU: an exact box filter for any size, in linear light for colours, which are
 * weighted by their alpha so that the colour of clear texels does not bleed into the covered ones.
 */
#include "scene/upload_internal.h"

#include <math.h>
#include <pthread.h>

#define START_COUNT 4096

static float linear_of[256];                      /* sRGB code to linear */
static float threshold[257];                      /* smallest linear value of each code */
static unsigned char start_code[START_COUNT + 1]; /* code at i / START_COUNT, or below it */
static pthread_once_t tables_once = PTHREAD_ONCE_INIT;

static double to_linear(double v) {
    return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
}

static void make_tables(void) {
    for (int i = 0; i < 256; i++) {
        linear_of[i] = (float)to_linear(i / 255.0);
        threshold[i] = i ? (float)to_linear((i - 0.5) / 255.0) : 0.0f;
    }
    threshold[256] = INFINITY;
    int code = 0;
    for (int i = 0; i <= START_COUNT; i++) {
        while (threshold[code + 1] <= (float)i / START_COUNT)
            code++;
        start_code[i] = (unsigned char)code;
    }
}

static unsigned char to_code(float linear) {
    float clamped = fminf(fmaxf(linear, 0.0f), 1.0f);
    int code = start_code[(int)(clamped * START_COUNT)];
    while (threshold[code + 1] <= clamped)
        code++;
    return (unsigned char)code;
}

/* The source texels that one texel of the next level covers along an axis, with the lengths of
 * overlap in units of 1 / next size: at most three. */
typedef struct span {
    uint32_t first, count;
    float weights[3];
} span;

static span cover(uint32_t index, uint32_t size, uint32_t next) {
    uint64_t low = (uint64_t)index * size, high = low + size;
    span s = {.first = (uint32_t)(low / next)};
    for (uint64_t i = s.first; i * next < high && s.count < 3; i++) {
        uint64_t from = i * next > low ? i * next : low;
        uint64_t to = (i + 1) * next < high ? (i + 1) * next : high;
        s.weights[s.count++] = (float)(to - from);
    }
    return s;
}

static void filter_texel(const unsigned char *from, uint32_t width, span x, span y, int colour,
                         unsigned char out[4]) {
    float plain[4] = {0}, covered[3] = {0}, total = 0.0f;
    for (uint32_t j = 0; j < y.count; j++)
        for (uint32_t i = 0; i < x.count; i++) {
            const unsigned char *texel = from + (((size_t)y.first + j) * width + x.first + i) * 4;
            float weight = x.weights[i] * y.weights[j];
            for (int c = 0; c < 3; c++) {
                float value = colour ? linear_of[texel[c]] : (float)texel[c];
                plain[c] += weight * value;
                covered[c] += weight * (float)texel[3] * value;
            }
            plain[3] += weight * (float)texel[3];
            total += weight;
        }
    for (int c = 0; c < 3; c++) {
        if (!colour)
            out[c] = (unsigned char)(plain[c] / total + 0.5f);
        else
            out[c] = to_code(plain[3] > 0.0f ? covered[c] / plain[3] : plain[c] / total);
    }
    out[3] = (unsigned char)(plain[3] / total + 0.5f);
}

void upload_next_level(const unsigned char *from, uint32_t width, uint32_t height, int colour,
                       unsigned char *to) {
    uint32_t next_width = width > 1 ? width / 2 : 1, next_height = height > 1 ? height / 2 : 1;
    pthread_once(&tables_once, make_tables);
    for (uint32_t y = 0; y < next_height; y++) {
        span rows = cover(y, height, next_height);
        for (uint32_t x = 0; x < next_width; x++)
            filter_texel(from, width, cover(x, width, next_width), rows, colour,
                         to + ((size_t)y * next_width + x) * 4);
    }
}
