/* SPDX-License-Identifier: MIT
 *
 * From begin to submit on OpenGL: the context stays current meanwhile, the first failure is kept,
 * and submitting waits until the device is idle.
 */
#include "gpu/gl/gl_internal.h"

#include <string.h>

void gl_begin(void *self) {
    gl *g = self;
    if (g->recording)
        return;
    memset(&g->failure, 0, sizeof g->failure);
    g->writing_target = 0;
    if (gl_enter(g, &g->failure) == STRATA_OK)
        g->recording = 1;
}

int gl_recording(gl *g) {
    if (!g->recording && g->failure.result == STRATA_OK)
        gl_begin(g);
    return g->recording && g->failure.result == STRATA_OK;
}

strata_result gl_submit(void *self, double *ms, uint32_t timing_count, base_error *err) {
    gl *g = self;
    for (uint32_t i = 0; i < timing_count; i++)
        ms[i] = -1;
    if (g->recording) {
        g->fn.MemoryBarrier(GL_ALL_BARRIER_BITS);
        g->fn.Finish();
        gl_timers_collect(g, ms, timing_count);
        gl_report(g, g->failure.result, "submitting", &g->failure);
        g->ring_used = 0;
        g->recording = 0;
        gl_leave(g);
    }
    base_error failure = g->failure;
    memset(&g->failure, 0, sizeof g->failure);
    if (g->lost)
        return base_fail(err, STRATA_ERROR_DEVICE_LOST, "gl: the device was lost");
    return failure.result == STRATA_OK ? STRATA_OK
                                       : base_fail(err, failure.result, "%s", failure.text);
}
