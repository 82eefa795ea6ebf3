/* SPDX-License-Identifier: MIT
 *
 * How long a pass took on OpenGL: the driver's timer queries where they are sound, else the
 * monotonic clock around a finished device. Soundness is measured once, against the clock, on a
 * draw made heavy enough: software rasterisers answer when they have queued the work, not when it
 * is done.
 */
#include "gpu/gl/gl_internal.h"

#include <stdlib.h>

#define HEAVY_SIZE    128    /* pixels along a side of the draw that is measured */
#define HEAVY_MS      8.0    /* what it has to last at least */
#define HEAVY_REPEATS 3u     /* times that query and clock have to agree */
#define HEAVY_LIMIT   65536u /* draws at most */

static const char heavy_vertex[] =
    "#version 450\n"
    "void main() {\n"
    "    vec2 p = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;\n"
    "    gl_Position = vec4(p, 0.5, 1.0);\n"
    "}\n";
static const char heavy_fragment[] = "#version 450\n"
                                     "layout(location = 0) out vec4 color;\n"
                                     "void main() {\n"
                                     "    vec4 v = gl_FragCoord;\n"
                                     "    for (int i = 0; i < 512; i++)\n"
                                     "        v = v.yzwx * 0.75 + fract(v * v + 0.25);\n"
                                     "    color = v;\n"
                                     "}\n";

static GLuint heavy_program(gl *g) {
    static const GLenum stages[2] = {GL_VERTEX_SHADER, GL_FRAGMENT_SHADER};
    const char *const sources[2] = {heavy_vertex, heavy_fragment};
    GLuint shaders[2];
    for (uint32_t i = 0; i < 2; i++) {
        shaders[i] = g->fn.CreateShader(stages[i]);
        g->fn.ShaderSource(shaders[i], 1, &sources[i], NULL);
        g->fn.CompileShader(shaders[i]);
    }
    return gl_link(g, shaders, 2, "timer self-test", NULL);
}

/* Time of `count` draws by the clock; by the query in *query_ms. */
static double heavy_measure(gl *g, GLuint query, uint32_t count, double *query_ms) {
    GLuint64 ns = 0;
    g->fn.Finish();
    double start = base_now_ms();
    g->fn.BeginQuery(GL_TIME_ELAPSED, query);
    for (uint32_t i = 0; i < count; i++)
        g->fn.DrawArrays(GL_TRIANGLES, 0, 3);
    g->fn.EndQuery(GL_TIME_ELAPSED);
    g->fn.Finish();
    double ms = base_now_ms() - start;
    g->fn.GetQueryObjectui64v(query, GL_QUERY_RESULT, &ns);
    *query_ms = (double)ns * 1e-6;
    return ms;
}

static gl_timer_trust timer_test(gl *g) {
    strata_image_desc desc = {.struct_size = sizeof desc,
                              .format = STRATA_FORMAT_RGBA8,
                              .label = "timer self-test",
                              .width = HEAVY_SIZE,
                              .height = HEAVY_SIZE};
    void *image = NULL;
    GLuint program = heavy_program(g), query = 0;
    double clock = 0, queried = 0;
    gl_timer_trust trust = GPU_GL_TIMER_UNSOUND;
    if (!program || gl_image_create(g, &desc, &image, NULL) != STRATA_OK)
        goto cleanup;
    strata_pass pass = {.struct_size = sizeof pass, .label = desc.label, .color_count = 1};
    gpu_native_pass native = {
        .pass = &pass, .color = {image}, .width = HEAVY_SIZE, .height = HEAVY_SIZE};
    GLuint target = gl_target_get(g, &native);
    if (!target)
        goto cleanup;
    g->fn.CreateQueries(GL_TIME_ELAPSED, 1, &query);
    g->fn.BindFramebuffer(GL_DRAW_FRAMEBUFFER, target);
    g->fn.Viewport(0, 0, HEAVY_SIZE, HEAVY_SIZE);
    g->fn.Scissor(0, 0, HEAVY_SIZE, HEAVY_SIZE);
    g->fn.Disable(GL_DEPTH_TEST);
    g->fn.Disable(GL_STENCIL_TEST);
    g->fn.Disable(GL_CULL_FACE);
    g->fn.Disablei(GL_BLEND, 0);
    g->fn.ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    g->fn.UseProgram(program);
    heavy_measure(g, query, 1, &queried); /* the driver's own compiling */
    uint32_t count = 1, agreed = 0;
    while ((clock = heavy_measure(g, query, count, &queried)) < HEAVY_MS && count < HEAVY_LIMIT)
        count *= 2;
    while (clock >= HEAVY_MS && queried > 0.85 * clock && queried < 1.05 * clock &&
           agreed++ < HEAVY_REPEATS)
        clock = heavy_measure(g, query, count, &queried);
    if (agreed > HEAVY_REPEATS)
        trust = GPU_GL_TIMER_SOUND;
    base_log(BASE_LOG_DEBUG, "gl: timer query %.2f ms where the clock saw %.2f: %s", queried, clock,
             trust == GPU_GL_TIMER_SOUND ? "used" : "not used");
cleanup:
    g->fn.UseProgram(0);
    g->fn.DeleteQueries(query ? 1 : 0, &query);
    g->fn.DeleteProgram(program);
    gl_image_destroy(g, image);
    return trust;
}

static GLuint query_next(gl *g) {
    if (g->query_used == g->query_count) {
        GLuint *queries =
            base_grow(g->queries, &g->query_capacity, g->query_count, sizeof *queries);
        if (!queries)
            return 0;
        g->queries = queries;
        g->fn.CreateQueries(GL_TIME_ELAPSED, 1, &queries[g->query_count++]);
    }
    return g->queries[g->query_used++];
}

void gl_timer_begin(gl *g, uint32_t timed) {
    g->timing = 0;
    if (!timed)
        return;
    if (g->timer == GPU_GL_TIMER_UNTESTED)
        g->timer = timer_test(g);
    gl_sample *samples =
        base_grow(g->samples, &g->sample_capacity, g->sample_count, sizeof *samples);
    if (!samples)
        return;
    g->samples = samples;
    gl_sample *sample = &samples[g->sample_count++];
    *sample = (gl_sample){.timed = timed};
    g->timing = 1;
    if (g->timer == GPU_GL_TIMER_SOUND)
        sample->query = query_next(g);
    if (sample->query) {
        g->fn.BeginQuery(GL_TIME_ELAPSED, sample->query);
    } else {
        g->fn.Finish();
        sample->ms = base_now_ms();
    }
}

void gl_timer_end(gl *g) {
    if (!g->timing)
        return;
    gl_sample *sample = &g->samples[g->sample_count - 1];
    g->timing = 0;
    if (sample->query) {
        g->fn.EndQuery(GL_TIME_ELAPSED);
    } else {
        g->fn.Finish();
        sample->ms = base_now_ms() - sample->ms;
    }
}

void gl_timers_collect(gl *g, double *ms, uint32_t count) {
    for (size_t i = 0; i < g->sample_count; i++) {
        gl_sample *sample = &g->samples[i];
        if (sample->query) {
            GLuint64 ns = 0;
            g->fn.GetQueryObjectui64v(sample->query, GL_QUERY_RESULT, &ns);
            sample->ms = (double)ns * 1e-6;
        }
        if (sample->timed <= count)
            ms[sample->timed - 1] = sample->ms;
    }
    g->sample_count = 0;
    g->query_used = 0;
}
