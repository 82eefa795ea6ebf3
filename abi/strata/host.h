/* SPDX-License-Identifier: MIT
 *
 * strata/host.h - embedding Strata: open an instance, load or generate a scene, plan, render, read
 * the image and the account. The command line is a client of this header and of nothing else.
 *
 *     strata *s; strata_open(NULL, &s);
 *     strata_scene *scene; strata_scene_load(s, "scene.gltf", &scene);
 *     strata_render(s, scene, &(strata_render_options){.struct_size = sizeof(strata_render_options)});
 *     strata_save(s, STRATA_OUTPUT_COLOR, "image.png");
 *     strata_scene_close(scene); strata_close(s);
 *
 * Instances are independent of each other and may live on different threads; one instance and its
 * scenes are used by one thread at a time. After a failure strata_error() has one line.
 */
#ifndef STRATA_HOST_H
#define STRATA_HOST_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct strata strata;             /* an instance: device, modules, caches */
typedef struct strata_scene strata_scene; /* a scene, loaded or generated */

typedef struct strata_open_options {
    uint32_t struct_size;
    uint32_t check;           /* 1: validation layers of the driver; also STRATA_CHECK=1 */
    const char *backend;      /* "vulkan", "gl" or "null"; NULL = vulkan, else gl */
    const char *device;       /* index, or a part of the device's name; NULL = the first */
    const char *module_path;  /* folders, ':'-separated; NULL = STRATA_MODULE_PATH, else the installed */
    const char *cache_dir;    /* NULL = STRATA_CACHE_DIR, else the user's cache; "" = none */
    uint64_t memory;          /* bytes of device memory that techniques may take; 0 = what is there */
    const char *inject;       /* faults for tests: "allocation:N", "lost:N", "lacks:FACT" and
                                 "claims:FACT" with commas between, or NULL */
} strata_open_options;

/* Opens an instance; the device is opened at the first render, so that listing and planning need
 * none. options NULL = defaults. The caller owns *out and ends it with strata_close. */
STRATA_EXPORT strata_result strata_open(const strata_open_options *options, strata **out);
STRATA_EXPORT void strata_close(strata *s); /* NULL is fine; its scenes must be closed before */

/* The line of the last failure on this instance, "" if none; valid until the next call. s NULL: of
 * the last strata_open that failed on this thread. */
STRATA_EXPORT const char *strata_error(const strata *s);

STRATA_EXPORT uint32_t strata_version(void);    /* STRATA_ABI_VERSION of the library */
STRATA_EXPORT const char *strata_release(void); /* and its release, "0.1.0", static */

/* For programs whose device may be the processor, once, before anything else: blocks of up to 32 MiB
 * that were freed stay with the process (up to 512 MiB of them), for all that runs there. Mesa's
 * software drivers take and free the vertices of every draw, and where those pages go back to the
 * system in between, faulting them in again can cost a third of a frame, by how blocks happen to lie.
 * Nothing where the C library is not glibc. */
STRATA_EXPORT void strata_keep_memory(void);

/* ---- scenes ----------------------------------------------------------------------------------- */

/* Reads .gltf or .glb, or generates a procedural scene when path is "scene:NAME[?K=V[&K=V]..]",
 * or a hard case when it is "hard:NAME".
 * NOT_FOUND, BAD_FILE, IO, OUT_OF_HOST_MEMORY. The caller owns *out. */
STRATA_EXPORT strata_result strata_scene_load(strata *s, const char *path, strata_scene **out);
/* knobs: `count` strings "K=V". "hard:NAME" is a name too, without knobs. */
STRATA_EXPORT strata_result strata_scene_generate(strata *s, const char *name,
                                                  const char *const *knobs, uint32_t count,
                                                  strata_scene **out);
STRATA_EXPORT strata_result strata_scene_save(strata_scene *scene, const char *path); /* GLB */
STRATA_EXPORT void strata_scene_close(strata_scene *scene);

/* Edits, seen by the next render. Instances are numbered in file order. */
STRATA_EXPORT strata_result strata_scene_set_time(strata_scene *scene, double seconds);
STRATA_EXPORT strata_result strata_scene_set_transform(strata_scene *scene, uint32_t instance,
                                                       const float world[16]);
STRATA_EXPORT strata_result strata_scene_set_visible(strata_scene *scene, uint32_t instance,
                                                     uint32_t visible);

/* ---- cameras ---------------------------------------------------------------------------------- */

/* Where a camera stands and what it sees. Numbers are finite and within 1e30. */
typedef struct strata_camera_pose {
    uint32_t struct_size;
    uint32_t reserved;        /* 0 */
    double eye[3], target[3]; /* world; they differ */
    double up[3];             /* need not be perpendicular to the view; (0, 0, 0), or along it: an
                                 axis of the world stands in, +y where it can */
    double yfov;              /* degrees, below 180, over the picture's height; 0 = 45 */
    double height;            /* above 0: orthographic, so many scene units high */
    double near, far;         /* along the view; 0 = by the scene's size, and infinite */
} strata_camera_pose;

/* The pose of a camera as named in strata_render_options.camera, at the scene's present time, for a
 * picture of this size. *out is the caller's, its struct_size set. NOT_FOUND, INVALID_ARGUMENT. */
STRATA_EXPORT strata_result strata_scene_camera(strata_scene *scene, const char *camera,
                                                uint32_t width, uint32_t height,
                                                strata_camera_pose *out);

/* ---- rendering -------------------------------------------------------------------------------- */

#define STRATA_OUTPUT_COLOR 1u /* linear float RGBA, premultiplied */
#define STRATA_OUTPUT_DEPTH 2u /* eye depth of the opaque surface in R, +inf where there is none; of
                                  several sub-pixels the nearest */
#define STRATA_OUTPUT_BOUND 4u /* certified error for each channel, +inf = uncertified */
#define STRATA_OUTPUT_DEEP 8u  /* every fragment; saved as deep EXR only; one sample a pixel */

typedef struct strata_render_options {
    uint32_t struct_size;
    uint32_t width, height;     /* pixels; 0 = 800 x 600 */
    uint32_t outputs;           /* STRATA_OUTPUT_* beside colour, ORed */
    const char *use;            /* techniques to use, "id,id"; NULL = the plan decides */
    const char *effects;        /* "auto" (or NULL), "none", or "id,id" */
    const char *const *settings; /* "ID.KNOB=VALUE" */
    uint32_t setting_count;
    uint32_t samples;           /* sub-pixels a pixel, on a regular grid: 1, 4, 9, .. 1024; 0 = 1 */
    const char *camera;         /* name, index or "orbit:AZIMUTH,ELEVATION" in degrees; NULL = first, else orbit */
    float background[4];        /* linear, premultiplied RGBA, used when has_background is 1 */
    uint32_t has_background;    /* 0: opaque (0.2, 0.2, 0.2) */
    uint32_t repeat;            /* frames to render, 0 = 1; the last is kept, all are accounted */
    uint32_t bands;             /* at least this many bands, 0 = as memory asks; for tests */
    uint32_t shuffle;           /* not 0: seed that permutes draws and triangles as submitted; for tests */
    double angle;               /* degrees that the camera is turned about the scene's vertical axis */
    double turn;                /* and by how many more each frame of a repeat */
    double tolerance;           /* largest certified error asked for; 0 = exact techniques */
    /* Progress of long work, 0..1; return not OK to stop (CANCELLED). NULL = none. */
    strata_result (*progress)(void *user, double done);
    void *user;
    const char *filter;         /* of sub-pixels: "box" (or NULL), "tent", "gaussian" */
    const strata_camera_pose *pose; /* NULL: `camera` says where it stands */
    /* 1: the next frame of the sequence that began with the last render of this scene without it.
     * What the frames of a sequence share: the plan, which is made once while the scene calls for
     * the same effects, the options ask for the same and nothing fails (so that techniques keep what
     * they learned, whatever the camera does); the key light of scenes without lights; the bounds
     * that an orbit frames and `angle` turns about. Without a frame to follow it begins a sequence. */
    uint32_t continues;
    /* 1: what the techniques of these frames cost is added to what is known of this device, in the
     * cache; later plans go by it, also those of other instances. Frames that prepared, were recorded
     * again or certified are not typical and teach nothing; nor do those of a sequence whose camera,
     * `angle` or scene are no longer what the plan was made for (`turn` within a repeat is taken to
     * change little), and what draws behind culled objects. */
    uint32_t learn;
    /* Milliseconds that a frame may take, 0 = any time. The most accurate technique that is expected
     * to need no more; then, over the frames of a `repeat` or of a sequence, what they took decides.
     * It counts as met up to 15 % above. Under a tolerance it changes nothing. */
    double budget;
    /* With learn: how many times as long as usual frames take at present, above 0, by what the caller
     * renders beside them; what is learnt is divided by it. 0 = 1. */
    double pace;
} strata_render_options;

/* Renders a scene of this instance. options NULL = defaults. The image stays with the instance until
 * the next render, also when the scene is closed.
 * PARTIAL: done, but less than was asked for; the account says what. */
STRATA_EXPORT strata_result strata_render(strata *s, strata_scene *scene,
                                          const strata_render_options *options);

/* Copies the rendered pixels: width * height * 4 floats, row 0 the top of the picture. size is in
 * bytes and must fit exactly. INVALID_STATE before the first render or for an output not asked for. */
STRATA_EXPORT strata_result strata_read(strata *s, uint32_t output, float *pixels, size_t size);
STRATA_EXPORT strata_result strata_size(const strata *s, uint32_t *width, uint32_t *height);

/* Saves an output; the suffix chooses .png (sRGB, 8 bit) or .exr (linear float; deep for DEEP). */
STRATA_EXPORT strata_result strata_save(strata *s, uint32_t output, const char *path);

/* ---- text: JSON, one object, through a callback ----------------------------------------------- */

/* Of the last render; INVALID_STATE before the first and when its scene was closed since. */
STRATA_EXPORT strata_result strata_account(strata *s, strata_write_fn write, void *user);
/* What the scene calls for, what would run, what would not, and why. options as for strata_render. */
STRATA_EXPORT strata_result strata_plan(strata *s, strata_scene *scene,
                                        const strata_render_options *options,
                                        strata_write_fn write, void *user);
/* Installed modules, techniques, effects, knobs; devices; procedural scenes. */
STRATA_EXPORT strata_result strata_list(strata *s, strata_write_fn write, void *user);

/* Every way to render this scene: the installed techniques with the knobs that trade accuracy (all
 * not 0: with the others too) at values that matter for the scene, in all combinations that the slots
 * allow and the plan accepts on this device. options: as for strata_render, without use, settings,
 * tolerance and budget. */
STRATA_EXPORT strata_result strata_configurations(strata *s, strata_scene *scene,
                                                  const strata_render_options *options, uint32_t all,
                                                  strata_write_fn write, void *user);

/* ---- comparing -------------------------------------------------------------------------------- */

/* Maps are PNG files; NULL: none. Zero = default. */
typedef struct strata_compare_options {
    uint32_t struct_size;
    uint32_t longest;         /* maps are made smaller until no side is longer; 0 = as they are */
    const char *heat;         /* the largest difference of each pixel's channels */
    const char *flip;         /* FLIP of each pixel */
    double pixels_per_degree; /* of vision, for FLIP; 0 = 67 */
} strata_compare_options;

/* How far b is from a, the reference: {"max", "rmse", "psnr", "differing", "broken"} in linear light
 * and "flip" in display space. Two image files of one size; or pixels as strata_read gives them.
 * options NULL = defaults. INVALID_ARGUMENT: the sizes differ. */
STRATA_EXPORT strata_result strata_compare(strata *s, const char *a, const char *b,
                                           const strata_compare_options *options,
                                           strata_write_fn write, void *user);
STRATA_EXPORT strata_result strata_compare_pixels(strata *s, uint32_t width, uint32_t height,
                                                  const float *a, const float *b,
                                                  const strata_compare_options *options,
                                                  strata_write_fn write, void *user);

/* Saves pixels as strata_read gives them as PNG, made smaller until no side is longer (0: as they
 * are). */
STRATA_EXPORT strata_result strata_save_pixels(strata *s, uint32_t width, uint32_t height,
                                               const float *pixels, uint32_t longest,
                                               const char *path);

#ifdef __cplusplus
}
#endif
#endif
