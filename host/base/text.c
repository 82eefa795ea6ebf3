/* SPDX-License-Identifier: MIT
 *
 * The error line, checked allocation and growing text of base.h. Nothing here fails silently: an
 * overflowing size or an exhausted heap is a NULL or a flag, and an error line is always printable.
 */
#include "base/base.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Length of the longest prefix of text[0..length) that does not end inside a UTF-8 sequence. */
static size_t whole_characters(const char *text, size_t length) {
    size_t start = length;
    while (start > 0 && ((unsigned char)text[start - 1] & 0xc0u) == 0x80u)
        start--;
    if (start == 0)
        return length;
    unsigned char lead = (unsigned char)text[start - 1];
    size_t need = lead >= 0xf0u ? 4 : lead >= 0xe0u ? 3 : lead >= 0xc0u ? 2 : 1;
    return length - (start - 1) < need ? start - 1 : length;
}

strata_result base_fail(base_error *err, strata_result result, const char *format, ...) {
    if (!err || err->result != STRATA_OK)
        return result;
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(err->text, sizeof err->text, format, arguments);
    va_end(arguments);
    if (length < 0)
        err->text[0] = '\0';
    if (length >= (int)sizeof err->text) {
        size_t keep = whole_characters(err->text, sizeof err->text - 4);
        memcpy(err->text + keep, "...", 4);
    }
    for (char *c = err->text; *c; c++)
        if ((unsigned char)*c < 0x20u || *c == 0x7f)
            *c = '?';
    err->result = result;
    return result;
}

void *base_calloc(size_t count, size_t size) {
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes))
        return NULL;
    return calloc(bytes ? bytes : 1, 1);
}

void *base_realloc(void *old, size_t count, size_t size) {
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes))
        return NULL;
    return realloc(old, bytes ? bytes : 1);
}

char *base_strdup(const char *text) {
    size_t size = strlen(text) + 1;
    char *copy = malloc(size);
    return copy ? memcpy(copy, text, size) : NULL;
}

char *base_format(const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    char *text = length < 0 ? NULL : malloc((size_t)length + 1);
    if (text)
        vsnprintf(text, (size_t)length + 1, format, again);
    va_end(again);
    va_end(arguments);
    return text;
}

#define LARGEST_STRUCT 65536u

int base_take(void *out, size_t size, const void *given) {
    const uint32_t known = (uint32_t)size;
    uint32_t there;
    memcpy(&there, given, sizeof there);
    if (there < sizeof there || there > LARGEST_STRUCT)
        return 0;
    for (size_t i = size; i < there; ++i)
        if (((const unsigned char *)given)[i])
            return 0;
    memcpy(out, given, there < size ? there : size);
    memcpy(out, &known, sizeof known);
    return 1;
}

void *base_grow(void *array, size_t *capacity, size_t count, size_t size) {
    if (array && count < *capacity)
        return array;
    size_t wanted = *capacity < 8 ? 8 : *capacity;
    while (wanted <= count)
        if (__builtin_mul_overflow(wanted, (size_t)2, &wanted))
            return NULL;
    void *larger = base_realloc(array, wanted, size);
    if (larger)
        *capacity = wanted;
    return larger;
}

/* Room for `more` bytes and the terminator; 0 and text->failed when there is none. */
static int text_reserve(base_text *text, size_t more) {
    size_t need;
    if (text->failed)
        return 0;
    if (__builtin_add_overflow(text->length, more, &need)) {
        text->failed = 1;
        return 0;
    }
    char *data = base_grow(text->data, &text->capacity, need, 1);
    if (!data) {
        text->failed = 1;
        return 0;
    }
    text->data = data;
    return 1;
}

void base_text_append(base_text *text, const char *bytes, size_t length) {
    if (!text_reserve(text, length))
        return;
    if (length)
        memcpy(text->data + text->length, bytes, length);
    text->length += length;
    text->data[text->length] = '\0';
}

void base_text_add(base_text *text, const char *format, ...) {
    va_list arguments, again;
    va_start(arguments, format);
    va_copy(again, arguments);
    int length = vsnprintf(NULL, 0, format, arguments);
    if (length < 0) {
        text->failed = 1;
    } else if (text_reserve(text, (size_t)length)) {
        vsnprintf(text->data + text->length, (size_t)length + 1, format, again);
        text->length += (size_t)length;
    }
    va_end(again);
    va_end(arguments);
}

void base_text_free(base_text *text) {
    free(text->data);
    *text = (base_text){0};
}
