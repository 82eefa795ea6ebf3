/* SPDX-License-Identifier: MIT
 *
 * strata/base.h - what every other SDK header builds on: versions, results, text callbacks and the
 * rules that all structs follow.
 *
 * Rules, for the whole of abi/strata:
 *  - Every struct begins with `uint32_t struct_size`, set by whoever fills it to sizeof(that struct).
 *    Structs grow only at their end. A reader uses the smaller of the sender's and its own size and
 *    takes what is missing as zero; zero is a sensible default everywhere. Members that a reader does
 *    not know and that are not zero it refuses, INVALID_ARGUMENT: nothing is ignored in silence.
 *    No struct is shorter than in ABI 1.0, and one that is may be refused. Handles, which are one number, and
 *    strata_glsl never grow and have no struct_size.
 *  - Arrays of structs are arrays of pointers, or stand beside the bytes from one element to the next
 *    (the binds and attachments of a pass); nothing that may grow is embedded by value.
 *  - Fixed-width integers, float, double and pointers only; padding is explicit and zero.
 *  - Text is UTF-8 and NUL-terminated. A `const char *` that is passed in is read during the call
 *    only, unless its comment says otherwise.
 *  - A call that can fail returns strata_result; neither side aborts, exits, raises signals or
 *    changes the locale, the floating-point environment or the working directory.
 *  - Unless a comment says otherwise, functions of one instance are called one at a time, not always
 *    on the same thread; what a module is called for, it is called on the thread of that call.
 */
#ifndef STRATA_BASE_H
#define STRATA_BASE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define STRATA_EXTERN_C extern "C"
#define STRATA_STATIC_ASSERT(condition, text) static_assert(condition, text)
extern "C" {
#else
#define STRATA_EXTERN_C extern
#define STRATA_STATIC_ASSERT(condition, text) _Static_assert(condition, text)
#endif

/* Visible outside a shared object that is otherwise compiled with hidden visibility. */
#define STRATA_EXPORT __attribute__((visibility("default")))

/* Versions are major << 16 | minor. The ABI's major changes only together with the name of the
 * exported symbol; the minor counts additions. */
#define STRATA_VERSION(major, minor) (((uint32_t)(major) << 16) | (uint32_t)(minor))
#define STRATA_VERSION_MAJOR(version) ((uint32_t)(version) >> 16)
#define STRATA_VERSION_MINOR(version) ((uint32_t)(version)&0xffffu)
#define STRATA_ABI_VERSION STRATA_VERSION(1, 0)

/* Outcome of a call. Values are stable; new ones are added at either end of their range. */
typedef int32_t strata_result;
#define STRATA_OK 0
#define STRATA_RETRY 1    /* verify(): something overflowed and was counted; record the frame again */
#define STRATA_PARTIAL 2  /* done, but less than was asked for; the account says what */
#define STRATA_ERROR_INVALID_ARGUMENT (-1)
#define STRATA_ERROR_INVALID_STATE (-2)       /* not callable now; see the function's comment */
#define STRATA_ERROR_OUT_OF_HOST_MEMORY (-3)
#define STRATA_ERROR_OUT_OF_DEVICE_MEMORY (-4)
#define STRATA_ERROR_DEVICE_LOST (-5)
#define STRATA_ERROR_OVERFLOW (-6)            /* more than a limit holds, and nothing can be done */
#define STRATA_ERROR_UNSUPPORTED (-7)         /* the device or the host cannot do this */
#define STRATA_ERROR_NOT_FOUND (-8)           /* no such file, module, name */
#define STRATA_ERROR_BAD_FILE (-9)            /* a file is malformed; the text names it and the place */
#define STRATA_ERROR_IO (-10)                 /* the system refused to read or write */
#define STRATA_ERROR_SHADER (-11)             /* GLSL did not compile or link */
#define STRATA_ERROR_VERSION (-12)            /* host and module share no version */
#define STRATA_ERROR_MODULE (-13)             /* a module broke a rule of this ABI */
#define STRATA_ERROR_CANCELLED (-14)          /* the caller asked to stop */
#define STRATA_ERROR_INTERNAL (-15)           /* a defect in the host */

/* Receives text in pieces, in order; `size` bytes without a terminator. Returns STRATA_OK to go on;
 * anything else stops the sender, which returns that value. Called on the thread of the call that
 * was given it, never after that call returned. */
typedef strata_result (*strata_write_fn)(void *user, const char *bytes, size_t size);

/* strata_settings: named values, resolved from the defaults of knobs and what the user set. */
#define STRATA_KNOB_INT 0u    /* int64, within [minimum, maximum] */
#define STRATA_KNOB_FLOAT 1u  /* double, finite, within [minimum, maximum] */
#define STRATA_KNOB_CHOICE 2u /* an index into the knob's choices */

/* A setting that a technique offers. Constant data of a module; lives as long as the module. */
typedef struct strata_knob {
    uint32_t struct_size;
    uint32_t type;        /* STRATA_KNOB_* */
    const char *name;     /* set from outside as TECHNIQUE.NAME=VALUE */
    const char *title;    /* one line for a person */
    const char *unit;     /* "fragments", "bytes", ... or NULL */
    double minimum, maximum, preset; /* preset: the default; of a choice, its index */
    const char *const *choices;      /* STRATA_KNOB_CHOICE: NULL-terminated names; else NULL */
    uint32_t trades_accuracy;        /* 1: a value changes accuracy as well as time */
    uint32_t reserved;
} strata_knob;

/* The values of one technique's knobs, in the order of its knob array. Read-only to the technique;
 * valid during the call that hands it over. */
typedef struct strata_settings {
    uint32_t struct_size;
    uint32_t count;
    const double *values; /* integers and choice indices are exact in a double */
} strata_settings;

#ifdef __cplusplus
}
#endif
#endif
