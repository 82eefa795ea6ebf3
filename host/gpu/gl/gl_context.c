/* SPDX-License-Identifier: MIT
 *
 * EGL without windows: the displays of the machine's devices, an OpenGL 4.5 core context on one of
 * them, the functions it offers, and making it current without disturbing what the embedding
 * program has current. First file of the OpenGL backend.
 */
#include "gpu/gl/gl_internal.h"

#include <string.h>

static int text_has_word(const char *text, const char *word) {
    size_t length = strlen(word);
    for (const char *at = text; at && (at = strstr(at, word)); at += length)
        if ((at == text || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0'))
            return 1;
    return 0;
}

/* Displays are shared with whoever else asks for the same device in this process, and EGL does not
 * count: an initialised one is therefore never terminated. */
static int display_usable(EGLDisplay display) {
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, NULL, NULL))
        return 0;
    const char *extensions = eglQueryString(display, EGL_EXTENSIONS);
    return extensions && text_has_word(extensions, "EGL_KHR_surfaceless_context") &&
           text_has_word(extensions, "EGL_KHR_no_config_context");
}

uint32_t gl_displays(EGLDisplay displays[GPU_GL_MAX_DEVICES]) {
    uint32_t count = 0;
    const char *client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (!client)
        return 0;
    EGLDeviceEXT devices[GPU_GL_MAX_DEVICES];
    EGLint device_count = 0;
    PFNEGLQUERYDEVICESEXTPROC query_devices =
        (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    if (!text_has_word(client, "EGL_EXT_platform_device") || !query_devices ||
        !query_devices((EGLint)GPU_GL_MAX_DEVICES, devices, &device_count))
        device_count = 0;
    for (EGLint i = 0; i < device_count; i++) {
        EGLDisplay display = eglGetPlatformDisplay(EGL_PLATFORM_DEVICE_EXT, devices[i], NULL);
        if (display_usable(display))
            displays[count++] = display;
    }
    if (count == 0 && text_has_word(client, "EGL_MESA_platform_surfaceless")) {
        EGLDisplay display =
            eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL);
        if (display_usable(display))
            displays[count++] = display;
    }
    return count;
}

int gl_is_software(const gl *g) {
    PFNEGLQUERYDISPLAYATTRIBEXTPROC query_display =
        (PFNEGLQUERYDISPLAYATTRIBEXTPROC)eglGetProcAddress("eglQueryDisplayAttribEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC query_device =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    const char *client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    EGLAttrib device = 0;
    if (!text_has_word(client, "EGL_EXT_device_query") || !query_display || !query_device ||
        !query_display(g->display, EGL_DEVICE_EXT, &device))
        return 0;
    return text_has_word(query_device((EGLDeviceEXT)device, EGL_EXTENSIONS),
                         "EGL_MESA_device_software");
}

static void current_save(gl_saved *saved) {
    saved->api = eglQueryAPI();
    eglBindAPI(EGL_OPENGL_API);
    saved->display = eglGetCurrentDisplay();
    saved->context = eglGetCurrentContext();
    saved->draw = eglGetCurrentSurface(EGL_DRAW);
    saved->read = eglGetCurrentSurface(EGL_READ);
}

static void current_restore(const gl *g) {
    if (g->saved.context != EGL_NO_CONTEXT)
        eglMakeCurrent(g->saved.display, g->saved.draw, g->saved.read, g->saved.context);
    else
        eglMakeCurrent(g->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (g->saved.api != EGL_NONE)
        eglBindAPI(g->saved.api);
}

strata_result gl_enter(gl *g, base_error *err) {
    if (g->lost)
        return base_fail(err, STRATA_ERROR_DEVICE_LOST, "gl: the device was lost");
    if (g->entered == 0) {
        current_save(&g->saved);
        if (!eglMakeCurrent(g->display, EGL_NO_SURFACE, EGL_NO_SURFACE, g->context)) {
            int code = eglGetError();
            current_restore(g);
            g->lost = code == EGL_CONTEXT_LOST;
            return base_fail(err, g->lost ? STRATA_ERROR_DEVICE_LOST : STRATA_ERROR_INVALID_STATE,
                             "gl: the context cannot be made current (EGL error 0x%04x): is it, "
                             "or a context of another API, current in this or another thread?",
                             (unsigned)code);
        }
    }
    if (g->recording) /* what went wrong so far is the recording's own, not the caller's */
        gl_report(g, g->failure.result, "recording", &g->failure);
    g->entered++;
    return STRATA_OK;
}

void gl_leave(gl *g) {
    if (--g->entered == 0)
        current_restore(g);
}

static EGLContext context_make(EGLDisplay display, int check, int robust) {
    EGLint attributes[16] = {EGL_CONTEXT_MAJOR_VERSION,       4,
                             EGL_CONTEXT_MINOR_VERSION,       5,
                             EGL_CONTEXT_OPENGL_PROFILE_MASK, EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT};
    uint32_t used = 6;
    if (check) {
        attributes[used++] = EGL_CONTEXT_OPENGL_DEBUG;
        attributes[used++] = EGL_TRUE;
    }
    if (robust) {
        attributes[used++] = EGL_CONTEXT_OPENGL_ROBUST_ACCESS;
        attributes[used++] = EGL_TRUE;
        attributes[used++] = EGL_CONTEXT_OPENGL_RESET_NOTIFICATION_STRATEGY;
        attributes[used++] = EGL_LOSE_CONTEXT_ON_RESET;
    }
    attributes[used] = EGL_NONE;
    return eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
}

typedef void (*any_function)(void);

/* eglGetProcAddress may answer with a function that does nothing for a name that the driver lacks,
 * so what is optional is asked for by version and extension beforehand. */
static int functions_load(gl_functions *fn, int core_46) {
    static const struct {
        const char *name;
        size_t offset;
        int arb;
    } list[] = {
#define X(suffix, name) {"gl" #name, offsetof(gl_functions, name), 0},
        GPU_GL_FUNCTIONS(X)
#undef X
#define X(suffix, name) {"gl" #name, offsetof(gl_functions, name), 1},
            GPU_GL_FUNCTIONS_ARB(X)
#undef X
    };
    for (size_t i = 0; i < BASE_COUNT(list); i++) {
        char name[64] = "";
        strncat(name, list[i].name, sizeof name - 4);
        if (list[i].arb && !core_46)
            strcat(name, "ARB");
        any_function function = eglGetProcAddress(name);
        if (!function)
            return 0;
        memcpy((char *)fn + list[i].offset, &function, sizeof function);
    }
    return 1;
}

int gl_has(const gl *g, const char *extension) {
    GLint count = 0;
    g->fn.GetIntegerv(GL_NUM_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++) {
        const GLubyte *name = g->fn.GetStringi(GL_EXTENSIONS, (GLuint)i);
        if (name && strcmp((const char *)name, extension) == 0)
            return 1;
    }
    return 0;
}

int gl_has_spirv(const gl *g, const char *extension) {
    GLint count = 0;
    if (!gl_has(g, "GL_ARB_spirv_extensions"))
        return 0;
    g->fn.GetIntegerv(GL_NUM_SPIR_V_EXTENSIONS, &count);
    for (GLint i = 0; i < count; i++) {
        const GLubyte *name = g->fn.GetStringi(GL_SPIR_V_EXTENSIONS, (GLuint)i);
        if (name && strcmp((const char *)name, extension) == 0)
            return 1;
    }
    return 0;
}

static strata_result needs_check(gl *g, base_error *err) {
    static const char *const needed[] = {"GL_ARB_gl_spirv", "GL_ARB_indirect_parameters",
                                         "GL_ARB_shader_draw_parameters"};
    GLint major = 0, minor = 0;
    g->fn.GetIntegerv = (PFNGLGETINTEGERVPROC)eglGetProcAddress("glGetIntegerv");
    g->fn.GetStringi = (PFNGLGETSTRINGIPROC)eglGetProcAddress("glGetStringi");
    if (!g->fn.GetIntegerv || !g->fn.GetStringi)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "the driver offers no OpenGL functions");
    g->fn.GetIntegerv(GL_MAJOR_VERSION, &major);
    g->fn.GetIntegerv(GL_MINOR_VERSION, &minor);
    int core_46 = major > 4 || (major == 4 && minor >= 6);
    for (size_t i = 0; !core_46 && i < BASE_COUNT(needed); i++)
        if (!gl_has(g, needed[i]))
            return base_fail(err, STRATA_ERROR_UNSUPPORTED, "the driver lacks %s", needed[i]);
    if (!functions_load(&g->fn, core_46))
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "the driver lacks a function of 4.5");
    return STRATA_OK;
}

strata_result gl_context_create(gl *g, EGLDisplay display, base_error *err) {
    strata_result result = STRATA_OK;
    g->display = display;
    current_save(&g->saved);
    g->context = context_make(display, g->check, 1);
    if (g->context == EGL_NO_CONTEXT)
        g->context = context_make(display, g->check, 0);
    if (g->context == EGL_NO_CONTEXT)
        result =
            base_fail(err, STRATA_ERROR_UNSUPPORTED,
                      "no OpenGL 4.5 core context (EGL error 0x%04x)", (unsigned)eglGetError());
    else if (!eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, g->context))
        result = base_fail(err, STRATA_ERROR_UNSUPPORTED,
                           "the new context cannot be made current (EGL error 0x%04x)",
                           (unsigned)eglGetError());
    else
        result = needs_check(g, err);
    g->entered = 1;
    if (result != STRATA_OK)
        gl_context_destroy(g);
    return result;
}

void gl_context_destroy(gl *g) {
    current_restore(g);
    g->entered = 0;
    if (g->context != EGL_NO_CONTEXT)
        eglDestroyContext(g->display, g->context);
    g->context = EGL_NO_CONTEXT;
}
