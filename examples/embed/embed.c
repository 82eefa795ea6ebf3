/* SPDX-License-Identifier: MIT
 *
 * A program that embeds Strata through strata/host.h alone: loads a scene, lets it turn and move,
 * takes the pixels, and asks what the frame cost. Usage: embed [SCENE [BACKEND]]
 */
#include <stdio.h>
#include <stdlib.h>

#include <strata/host.h>

enum { WIDTH = 320, HEIGHT = 240, FRAMES = 8 };

/* The mean of each channel: proof enough that the pixels are here. */
static void print_mean(const float *pixels, int frame) {
    double mean[4] = {0, 0, 0, 0};
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        for (int c = 0; c < 4; ++c)
            mean[c] += (double)pixels[4 * i + c] / (WIDTH * HEIGHT);
    printf("frame %d: mean colour %.4f %.4f %.4f, alpha %.4f\n", frame, mean[0], mean[1], mean[2],
           mean[3]);
}

static strata_result print(void *user, const char *bytes, size_t size) {
    return fwrite(bytes, 1, size, user) == size ? STRATA_OK : STRATA_ERROR_IO;
}

/* Renders around the scene; its first instance rises a little with every frame. */
static strata_result turn(strata *s, strata_scene *scene, float *pixels) {
    strata_result result = STRATA_OK;
    for (int frame = 0; frame < FRAMES && result == STRATA_OK; ++frame) {
        const float lifted[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.02f * (float)frame,
                                  0, 1};
        const strata_render_options options = {.struct_size = sizeof options,
                                               .width = WIDTH,
                                               .height = HEIGHT,
                                               .angle = 360.0 * frame / FRAMES,
                                               .continues = frame > 0}; /* one sequence */
        /* In place of the transform that the instance has in the scene. */
        result = strata_scene_set_transform(scene, 0, lifted);
        if (result == STRATA_OK)
            result = strata_render(s, scene, &options);
        if (result == STRATA_OK)
            result =
                strata_read(s, STRATA_OUTPUT_COLOR, pixels, sizeof(float) * 4 * WIDTH * HEIGHT);
        if (result == STRATA_OK)
            print_mean(pixels, frame);
    }
    return result;
}

int main(int argc, char **argv) {
    const strata_open_options open = {.struct_size = sizeof open,
                                      .backend = argc > 2 ? argv[2] : NULL};
    strata_keep_memory(); /* the device may be the processor */
    strata *s = NULL;
    strata_scene *scene = NULL;
    float *pixels = malloc(sizeof(float) * 4 * WIDTH * HEIGHT);
    strata_result result = pixels ? strata_open(&open, &s) : STRATA_ERROR_OUT_OF_HOST_MEMORY;
    if (result == STRATA_OK)
        result = strata_scene_load(s, argc > 1 ? argv[1] : "scene:shells", &scene);
    if (result == STRATA_OK)
        result = turn(s, scene, pixels);
    if (result == STRATA_OK)
        result = strata_account(s, print, stdout);
    if (result == STRATA_OK)
        result = strata_save(s, STRATA_OUTPUT_COLOR, "embed.png");
    if (result != STRATA_OK)
        fprintf(stderr, "embed: %s\n", strata_error(s));
    strata_scene_close(scene);
    strata_close(s);
    free(pixels);
    return result == STRATA_OK ? 0 : 1;
}
