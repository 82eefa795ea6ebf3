/* SPDX-License-Identifier: MIT
 *
 * strata/frame.h - what a technique sees while it prepares (strata_view) and records
 * (strata_frame), and the fragments/1 slot, the exchange format between capture and resolve.
 */
#ifndef STRATA_FRAME_H
#define STRATA_FRAME_H

#include "gpu.h"
#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- fragments/1 ------------------------------------------------------------------------------
 * For each pixel of the band, row by row, the block StrataRanges holds uvec2(offset, count); records
 * lie in planes of at most 8 bytes: StrataKeys uvec2(key, order), StrataPayload0.. the payload words
 * that the active effects need, and for linked records StrataLinks uvec2(next, pixel).
 *  - contiguous: the records of a pixel are slots offset .. offset + count - 1, in any order unless
 *    `sorted`; count 0: offset is meaningless.
 *  - linked: offset is the slot of the first record, 0xffffffff when count is 0; `next` chains on.
 * key ascends from near to far; order breaks ties (later primitives in front); (key, order) is
 * unique within a pixel. Records hold all fragments in front of or level with limit/1, or the nearest
 * `nearest` of them. shaders/strata/fragments.glsl reads and writes this format. */
#define STRATA_FRAGMENTS_CONTIGUOUS 0u
#define STRATA_FRAGMENTS_LINKED 1u

#define STRATA_PAYLOAD_FLOAT 0u  /* 32 bits a channel */
#define STRATA_PAYLOAD_HALF 1u   /* 16, round to nearest even, overflow to the largest finite */
#define STRATA_PAYLOAD_UNORM8 2u /* 8, clamped to [0, 1], round to nearest */

typedef struct strata_fragments {
    uint32_t struct_size;
    uint32_t layout;        /* STRATA_FRAGMENTS_* */
    uint32_t sorted;        /* 1: ascending by (key, order) within a pixel; contiguous only */
    uint32_t nearest;       /* 0 = all; k = at most the nearest k */
    strata_buffer ranges;   /* uvec2 for each pixel of the largest band */
    strata_pool records;    /* the planes named above */
} strata_fragments;

/* ---- prepare ---------------------------------------------------------------------------------- */

/* How sub-pixels become pixels: weights by the distance from the pixel's centre on each axis,
 * multiplied, and divided by the sum of those that lie in the image. */
#define STRATA_FILTER_BOX 0u      /* the pixel's own sub-pixels, alike */
#define STRATA_FILTER_TENT 1u     /* falls to 0 one pixel away */
#define STRATA_FILTER_GAUSSIAN 2u /* standard deviation of half a pixel, cut off at three of them */

#define STRATA_CHANGED_SIZE 1u
#define STRATA_CHANGED_SCENE 2u /* the draws were replaced; edits in place show in scene_revision */
#define STRATA_CHANGED_EFFECTS 4u
#define STRATA_CHANGED_SETTINGS 8u
#define STRATA_CHANGED_BANDS 16u
#define STRATA_CHANGED_DEVICE 32u /* all earlier objects are gone */

/* Owned by the host, valid during prepare() only. */
typedef struct strata_view {
    uint32_t struct_size;
    uint32_t changed;                   /* STRATA_CHANGED_*; all bits the first time */
    void *self;                         /* first argument of the functions below */
    uint32_t width, height;             /* of the frame, in sub-pixels */
    uint32_t band_width, band_height;   /* of the largest band; those of the frame when not banded */
    uint32_t samples;                   /* sub-pixels a pixel */
    uint32_t transmittance_channels;    /* 1, or 3 when an active effect colours what it transmits */
    uint32_t payload;                   /* STRATA_PAYLOAD_*: fragments/1's precision */
    uint32_t layout;                    /* STRATA_FRAGMENTS_*: fragments/1's layout */
    uint32_t payload_plane_count;       /* planes of payload that a record has, 1.. */
    uint32_t payload_plane_strides[STRATA_MAX_PLANES]; /* bytes, 4 or 8 */
    /* At most the nearest k fragments of a pixel are kept by the frame's capture or stream: the value
     * of that technique's knob `k` where it promises STRATA_ORDER_NEAREST. 0: all are. */
    uint32_t nearest;
    uint64_t scene_revision;
    const strata_settings *settings;    /* this technique's knobs */
    const strata_scene_stats *stats;

    /* The image that fills a slot ("color/1", "depth/1", "limit/1", "bound/1", "image/1"); the zero
     * handle for a slot that this technique does not name in its slots or that is not in the frame.
     * A capture that consumes "color/1" reads what lies behind transparent fragments: it is recorded
     * before they are folded.
     * "image/1", width x height pixels (those above divided by the root of `samples`), is there when
     * `samples` is above 1, and of its producers for the one that fills it. A fold that produces it
     * filters as it folds; given the zero handle, it updates color/1 like any other. Who fills it also
     * fills "image.bound/1" where a certificate is asked for (+inf when the frame starts): bound/1
     * filtered alike, and the filter's own rounding. */
    strata_image (*image)(void *self, const char *slot);
    /* The draws that fill "draws.opaque/1" or "draws.transparent/1"; as above. Under
     * "draws.opaque.all/1" and "draws.transparent.all/1": before any technique updated them. */
    strata_draws (*draws)(void *self, const char *slot);
    /* Producers of a slot with an image of their own making (limit/1) hand it over here. */
    strata_result (*publish_image)(void *self, const char *slot, strata_image image);
    /* The producer of fragments/1 hands it over here; copied. Once in each prepare(); planes of
     * `records` in this order: StrataKeys, of linked ones StrataLinks, StrataPayload0... */
    strata_result (*publish_fragments)(void *self, const strata_fragments *fragments);
    /* fragments/1 for its consumers, NULL for others; valid until the next prepare(). */
    const strata_fragments *(*fragments)(void *self);
    /* 1: a certificate of error is asked for. Programs then have STRATA_BOUND defined, techniques
     * account for what they drop (shaders/strata/loss.glsl), and what folds fills bound/1 (slot use
     * UPDATES, optional; zero when the frame starts), +inf where nothing can be said. */
    uint32_t certify;
    uint32_t filter;                    /* STRATA_FILTER_*: for who fills image/1 */
    /* Techniques that update "draws.opaque/1" or "draws.transparent/1" hand over what is drawn from
     * now on in its place; buffers of the technique's own, which it fills in each round. */
    strata_result (*publish_draws)(void *self, const char *slot, const strata_draws_desc *desc);
    /* Objects of both draw lists, for those that name "objects/1" (strata/objects.glsl); else 0. The
     * number changes with STRATA_CHANGED_SCENE only. */
    uint32_t object_count;
    uint32_t reserved;
    /* The largest certified error that is accepted in any channel of a pixel; 0: none was given. With
     * one, `certify` is 1. Techniques may keep less where the certificate stays within it; the host
     * reads the certificate, whatever they did. */
    double tolerance;
} strata_view;

/* ---- record and verify ------------------------------------------------------------------------ */

/* What verify() reports; each at most once in a verify(), summed over bands by the host (MAX_: largest).
 * Who keeps fragments reports them, capture or stream. Of a clip technique the total alone counts: then
 * it is the frame's, with what limit/1 hides. */
#define STRATA_REPORT_FRAGMENTS_TOTAL 1u   /* fragments that reached the technique */
#define STRATA_REPORT_FRAGMENTS_KEPT 2u
#define STRATA_REPORT_FRAGMENTS_DROPPED 3u /* by design (k) or for want of room */
#define STRATA_REPORT_MAX_PER_PIXEL 4u
#define STRATA_REPORT_PIXELS_LOST 5u /* pixels whose order was lost, so that they are wrong */
/* Of techniques that cull objects/1. */
#define STRATA_REPORT_OBJECTS 6u          /* all that there are */
#define STRATA_REPORT_OBJECTS_OUTSIDE 7u  /* not drawn, outside of the view */
#define STRATA_REPORT_OBJECTS_OCCLUDED 8u /* not drawn, hidden by others */
#define STRATA_REPORT_OBJECTS_LATE 9u     /* drawn in a later round than the first */
#define STRATA_REPORT_OBJECTS_CERTIFIED 10u /* hidden, and checked to be so against the final depth */
#define STRATA_REPORT_OBJECTS_SLIPPED 14u /* not drawn, between the centres of pixels */
/* Of techniques that check whether others culled right. */
#define STRATA_REPORT_OBJECTS_VISIBLE 11u  /* a fragment is level with the opaque depth, or nearer */
#define STRATA_REPORT_OBJECTS_WRONG 12u    /* visible, and not drawn */
#define STRATA_REPORT_OBJECTS_OVERSHOT 13u /* not drawn, and visible only by a fragment that was
                                              interpolated nearer than any vertex */

/* Owned by the host, valid during record() or verify() only. record() is called once for each round
 * of each band; verify() once for each band after the GPU has finished that band. Stages draws,
 * surface (before all bands) and filter (after them) see one band, the whole frame. */
typedef struct strata_frame {
    uint32_t struct_size;
    /* Stages draws and surface have `rounds` rounds: one, or two when a technique of stage draws
     * consumes depth/1, which is what the rounds before left. Then those of stage draws are called
     * once more, with round == rounds, when all that is opaque has been drawn. */
    uint32_t round;
    void *self;
    uint32_t width, height;      /* of the frame, in sub-pixels, like all below */
    uint32_t band, band_count;
    uint32_t x, y, band_width, band_height; /* this band's rectangle */
    uint64_t index;              /* frames since create(), retries not counted */
    uint32_t attempt;            /* 0, or how often this frame was recorded before */
    uint32_t rounds;
    uint64_t scene_revision;     /* grows with every edit of the scene */
    const strata_gpu *gpu;

    /* record() only. Records a pass; a bad one is reported with technique, pass and binding named,
     * fails the frame, and later calls do nothing. */
    void (*pass)(void *self, const strata_pass *pass);
    /* record() only. Fills words of a buffer; size 0 = to the end. */
    void (*fill)(void *self, strata_buffer buffer, uint64_t offset, uint64_t size, uint32_t value);
    /* record() only. Copies bytes between buffers, offsets and size multiples of 4. */
    void (*copy)(void *self, strata_buffer to, uint64_t to_offset, strata_buffer from,
                 uint64_t from_offset, uint64_t size);
    /* Reads a buffer. In verify() free; in record() it submits, waits and is accounted as a stall.
     * INVALID_ARGUMENT, DEVICE_LOST. */
    strata_result (*read)(void *self, strata_buffer buffer, uint64_t offset, uint64_t size,
                          void *data);
    /* verify() only: elements of a pool that this band asked for; what exceeds its capacity the host
     * has seen already. */
    uint64_t (*needed)(void *self, strata_pool pool);
    /* verify() only. */
    void (*report)(void *self, uint32_t what, uint64_t value);
    /* Any time: the frame fails with this result (< 0) and line, unless it failed before. */
    void (*fail)(void *self, strata_result result, const char *text);
} strata_frame;

#ifdef __cplusplus
}
#endif
#endif
