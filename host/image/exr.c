/* SPDX-License-Identifier: MIT
 *
 * Flat EXR through OpenEXRCore, OpenEXR's C library. Files are written into a base_output with
 * pwrite, since the library fills in its chunk table last, and read from memory, so that neither
 * side ever opens a file by itself. deep.c writes deep files with the writer declared here.
 */
#define _POSIX_C_SOURCE 200809L
#include "image/image_internal.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* The library's latest message. It reports on the calling thread, but while holding the lock of a
 * context being written, so that even asking it for the user data would wait forever. */
static _Thread_local char message[256];

static void keep_message(exr_const_context_t context, exr_result_t code, const char *text) {
    (void)context;
    (void)code;
    snprintf(message, sizeof message, "%s", text);
}

static const char *explain(exr_result_t code) {
    return message[0] ? message : exr_get_default_error_message(code);
}

/* ---- writing -------------------------------------------------------------------------------- */

static int64_t write_at(exr_const_context_t context, void *user, const void *buffer, uint64_t size,
                        uint64_t offset, exr_stream_error_func_ptr_t report) {
    const image_exr_writer *writer = user;
    const char *bytes = buffer;
    uint64_t done = 0;
    while (done < size) {
        ssize_t wrote =
            pwrite(writer->output.fd, bytes + done, size - done, (off_t)(offset + done));
        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote <= 0) {
            report(context, EXR_ERR_WRITE_IO, "cannot write: %s", strerror(errno));
            return -1;
        }
        done += (uint64_t)wrote;
    }
    return (int64_t)size;
}

strata_result image_exr_check(const image_exr_writer *writer, exr_result_t code, base_error *err) {
    if (code == EXR_ERR_SUCCESS)
        return STRATA_OK;
    strata_result result =
        code == EXR_ERR_OUT_OF_MEMORY ? STRATA_ERROR_OUT_OF_HOST_MEMORY : STRATA_ERROR_IO;
    return base_fail(err, result, "%s: OpenEXR: %s", writer->output.path, explain(code));
}

strata_result image_exr_open(image_exr_writer *writer, const char *path, exr_storage_t storage,
                             exr_compression_t compression, uint32_t width, uint32_t height,
                             base_error *err) {
    *writer = (image_exr_writer){0};
    message[0] = '\0';
    if (width == 0 || height == 0 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE) {
        return base_fail(err, STRATA_ERROR_OVERFLOW, "%s: an EXR file of %u x %u", path, width,
                         height);
    }
    strata_result result = base_output_open(&writer->output, path, err);
    if (result != STRATA_OK)
        return result;
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.user_data = writer;
    setup.write_fn = write_at;
    setup.zip_level = 2; /* of 9; measured: half the time of the usual 4, 15 % larger */
    exr_result_t code = exr_start_write(&writer->context, path, EXR_WRITE_FILE_DIRECTLY, &setup);
    int part = 0;
    if (code == EXR_ERR_SUCCESS)
        code = exr_add_part(writer->context, NULL, storage, &part);
    if (code == EXR_ERR_SUCCESS) {
        code = exr_initialize_required_attr_simple(writer->context, part, (int32_t)width,
                                                   (int32_t)height, compression);
    }
    result = image_exr_check(writer, code, err);
    return result == STRATA_OK ? result : image_exr_close(writer, result, err);
}

strata_result image_exr_close(image_exr_writer *writer, strata_result result, base_error *err) {
    if (writer->context) {
        exr_result_t code = exr_finish(&writer->context);
        if (result == STRATA_OK)
            result = image_exr_check(writer, code, err);
    }
    if (result == STRATA_OK)
        result = base_output_commit(&writer->output, err);
    base_output_abort(&writer->output);
    return result;
}

/* What a flat file is made of: interleaved channels, the first row at the bottom. */
typedef struct exr_planes {
    const float *values;
    uint32_t width, height, channel_count;
    const char *names[4]; /* in the order of `values` */
} exr_planes;

/* Points each of the library's channels, which it has sorted by name, at its values in `rows`. */
static void aim_encoder(exr_encode_pipeline_t *encoder, const exr_planes *planes,
                        const float *rows) {
    for (int i = 0; i < encoder->channel_count; ++i) {
        exr_coding_channel_info_t *channel = &encoder->channels[i];
        uint32_t c = 0;
        while (c + 1 < planes->channel_count &&
               strcmp(channel->channel_name, planes->names[c]) != 0)
            ++c;
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = (int32_t)(planes->channel_count * sizeof(float));
        channel->user_line_stride = channel->user_pixel_stride * (int32_t)planes->width;
        channel->encode_from_ptr = (const uint8_t *)(rows + c);
    }
}

static exr_result_t encode_chunk(exr_context_t context, exr_encode_pipeline_t *encoder, uint32_t y,
                                 const exr_planes *planes, float *rows) {
    exr_chunk_info_t chunk;
    exr_result_t code = exr_write_scanline_chunk_info(context, 0, (int)y, &chunk);
    if (code != EXR_ERR_SUCCESS)
        return code;
    size_t row_values = (size_t)planes->width * planes->channel_count;
    for (uint32_t i = 0; i < (uint32_t)chunk.height && y + i < planes->height; ++i) {
        memcpy(rows + i * row_values, planes->values + (planes->height - 1 - y - i) * row_values,
               row_values * sizeof(float));
    }
    code = y == 0 ? exr_encoding_initialize(context, 0, &chunk, encoder)
                  : exr_encoding_update(context, 0, &chunk, encoder);
    if (code != EXR_ERR_SUCCESS)
        return code;
    aim_encoder(encoder, planes, rows);
    if (y == 0)
        code = exr_encoding_choose_default_routines(context, 0, encoder);
    return code == EXR_ERR_SUCCESS ? exr_encoding_run(context, 0, encoder) : code;
}

static strata_result write_planes(const exr_planes *planes, const char *path, base_error *err) {
    image_exr_writer writer;
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    float *rows = NULL;
    int32_t step = 0;
    strata_result result = image_exr_open(&writer, path, EXR_STORAGE_SCANLINE, EXR_COMPRESSION_ZIP,
                                          planes->width, planes->height, err);
    if (result != STRATA_OK)
        return result;
    exr_result_t code = EXR_ERR_SUCCESS;
    for (uint32_t c = 0; c < planes->channel_count && code == EXR_ERR_SUCCESS; ++c) {
        code = exr_add_channel(writer.context, 0, planes->names[c], EXR_PIXEL_FLOAT,
                               EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    }
    if (code == EXR_ERR_SUCCESS)
        code = exr_write_header(writer.context);
    if (code == EXR_ERR_SUCCESS)
        code = exr_get_scanlines_per_chunk(writer.context, 0, &step);
    if (code == EXR_ERR_SUCCESS) {
        rows = base_calloc((size_t)step * planes->width, planes->channel_count * sizeof(float));
        code = rows ? EXR_ERR_SUCCESS : EXR_ERR_OUT_OF_MEMORY;
    }
    for (uint32_t y = 0; y < planes->height && code == EXR_ERR_SUCCESS; y += (uint32_t)step)
        code = encode_chunk(writer.context, &encoder, y, planes, rows);
    exr_encoding_destroy(writer.context, &encoder);
    free(rows);
    return image_exr_close(&writer, image_exr_check(&writer, code, err), err);
}

strata_result image_write_exr(const image *im, const char *path, base_error *err) {
    const exr_planes planes = {.values = im->pixels,
                               .width = im->width,
                               .height = im->height,
                               .channel_count = 4,
                               .names = {"R", "G", "B", "A"}};
    return write_planes(&planes, path, err);
}

strata_result image_write_exr_plane(const float *values, uint32_t width, uint32_t height,
                                    const char *channel, const char *path, base_error *err) {
    const exr_planes planes = {
        .values = values, .width = width, .height = height, .channel_count = 1, .names = {channel}};
    return write_planes(&planes, path, err);
}

/* ---- reading -------------------------------------------------------------------------------- */

typedef struct exr_reader {
    exr_context_t context;
    const unsigned char *data;
    size_t size;
    exr_decode_pipeline_t decoder;
    int ready; /* the decoder's routines are chosen */
    int grey;  /* the only channel goes to R */
    image *out;
} exr_reader;

static int64_t read_at(exr_const_context_t context, void *user, void *buffer, uint64_t size,
                       uint64_t offset, exr_stream_error_func_ptr_t report) {
    const exr_reader *reader = user;
    (void)context;
    (void)report;
    if (offset >= reader->size)
        return 0;
    uint64_t left = reader->size - offset;
    uint64_t count = size < left ? size : left;
    memcpy(buffer, reader->data + offset, count);
    return (int64_t)count;
}

static int64_t read_size(exr_const_context_t context, void *user) {
    const exr_reader *reader = user;
    (void)context;
    return (int64_t)reader->size;
}

/* The place in RGBA that a channel fills, or -1. */
static int channel_slot(const exr_reader *reader, const char *name) {
    if (reader->grey)
        return 0;
    const char *found = strchr("RGBA", name[0]);
    return name[0] && !name[1] && found ? (int)(found - "RGBA") : -1;
}

/* Looks at storage, window and channels; makes the image. One line about what is not supported. */
static strata_result inspect(exr_reader *reader, exr_storage_t *storage, exr_attr_box2i_t *window,
                             base_error *err) {
    const exr_attr_chlist_t *channels = NULL;
    if (exr_get_storage(reader->context, 0, storage) != EXR_ERR_SUCCESS ||
        exr_get_data_window(reader->context, 0, window) != EXR_ERR_SUCCESS ||
        exr_get_channels(reader->context, 0, &channels) != EXR_ERR_SUCCESS || !channels)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "the header is incomplete");
    if (*storage != EXR_STORAGE_SCANLINE && *storage != EXR_STORAGE_TILED)
        return base_fail(err, STRATA_ERROR_UNSUPPORTED, "a deep image; flatten it first");
    unsigned found = 0;
    for (int i = 0; i < channels->num_channels; ++i) {
        const exr_attr_chlist_entry_t *entry = &channels->entries[i];
        if (entry->x_sampling != 1 || entry->y_sampling != 1) {
            return base_fail(err, STRATA_ERROR_UNSUPPORTED, "channel %s is sub-sampled",
                             entry->name.str);
        }
        int slot = channel_slot(reader, entry->name.str);
        found |= slot >= 0 ? 1u << slot : 0;
    }
    if ((found & 7) != 7) {
        if (channels->num_channels != 1)
            return base_fail(err, STRATA_ERROR_UNSUPPORTED, "no channels R, G and B");
        reader->grey = 1;
    }
    int64_t width = (int64_t)window->max.x - window->min.x + 1;
    int64_t height = (int64_t)window->max.y - window->min.y + 1;
    if (width < 1 || height < 1 || width > IMAGE_MAX_SIDE || height > IMAGE_MAX_SIDE) {
        return base_fail(err, STRATA_ERROR_OVERFLOW, "a data window of %lld x %lld",
                         (long long)width, (long long)height);
    }
    strata_result result = image_create((uint32_t)width, (uint32_t)height, reader->out, err);
    for (size_t i = 0; result == STRATA_OK && i < (size_t)width * (size_t)height; ++i)
        reader->out->pixels[i * 4 + 3] = 1;
    return result;
}

/* Decodes one chunk whose first pixel is (x, y), y counted from the top. */
static exr_result_t decode_chunk(exr_reader *reader, const exr_chunk_info_t *chunk, uint32_t x,
                                 uint32_t y) {
    exr_decode_pipeline_t *decoder = &reader->decoder;
    image *out = reader->out;
    if (chunk->width < 1 || chunk->height < 1 || (uint32_t)chunk->width > out->width - x ||
        (uint32_t)chunk->height > out->height - y)
        return EXR_ERR_CORRUPT_CHUNK;
    exr_result_t code = reader->ready ? exr_decoding_update(reader->context, 0, chunk, decoder)
                                      : exr_decoding_initialize(reader->context, 0, chunk, decoder);
    if (code != EXR_ERR_SUCCESS)
        return code;
    float *first = out->pixels + ((size_t)y * out->width + x) * 4;
    for (int i = 0; i < decoder->channel_count; ++i) {
        exr_coding_channel_info_t *channel = &decoder->channels[i];
        int slot = channel_slot(reader, channel->channel_name);
        channel->user_bytes_per_element = sizeof(float);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_pixel_stride = 4 * sizeof(float);
        channel->user_line_stride = (int32_t)(out->width * 4 * sizeof(float));
        channel->decode_to_ptr = slot < 0 ? NULL : (uint8_t *)(first + slot);
    }
    if (!reader->ready) {
        code = exr_decoding_choose_default_routines(reader->context, 0, decoder);
        reader->ready = 1;
    }
    return code == EXR_ERR_SUCCESS ? exr_decoding_run(reader->context, 0, decoder) : code;
}

static exr_result_t decode_scanlines(exr_reader *reader, int32_t first_line) {
    int32_t step = 0;
    exr_result_t code = exr_get_scanlines_per_chunk(reader->context, 0, &step);
    if (code == EXR_ERR_SUCCESS && step < 1)
        return EXR_ERR_CORRUPT_CHUNK;
    for (uint32_t y = 0; y < reader->out->height && code == EXR_ERR_SUCCESS; y += (uint32_t)step) {
        exr_chunk_info_t chunk = {0};
        code = exr_read_scanline_chunk_info(reader->context, 0, first_line + (int32_t)y, &chunk);
        if (code == EXR_ERR_SUCCESS)
            code = decode_chunk(reader, &chunk, 0, y);
    }
    return code;
}

static exr_result_t decode_tiles(exr_reader *reader) {
    int32_t width = 0, height = 0;
    exr_result_t code = exr_get_tile_sizes(reader->context, 0, 0, 0, &width, &height);
    if (code == EXR_ERR_SUCCESS && (width < 1 || height < 1))
        return EXR_ERR_CORRUPT_CHUNK;
    for (uint32_t y = 0; y < reader->out->height && code == EXR_ERR_SUCCESS;
         y += (uint32_t)height) {
        for (uint32_t x = 0; x < reader->out->width && code == EXR_ERR_SUCCESS;
             x += (uint32_t)width) {
            exr_chunk_info_t chunk = {0};
            code = exr_read_tile_chunk_info(reader->context, 0, (int)(x / (uint32_t)width),
                                            (int)(y / (uint32_t)height), 0, 0, &chunk);
            if (code == EXR_ERR_SUCCESS)
                code = decode_chunk(reader, &chunk, x, y);
        }
    }
    return code;
}

/* First row to the bottom; a grey value to all three channels. */
static void finish_pixels(image *out, int grey) {
    size_t row_values = (size_t)out->width * 4;
    for (uint32_t y = 0; y < out->height / 2; ++y) {
        float *low = out->pixels + y * row_values;
        float *high = out->pixels + (out->height - 1 - y) * row_values;
        for (size_t i = 0; i < row_values; ++i) {
            float kept = low[i];
            low[i] = high[i];
            high[i] = kept;
        }
    }
    for (size_t i = 0; grey && i < row_values * out->height; i += 4)
        out->pixels[i + 1] = out->pixels[i + 2] = out->pixels[i];
}

strata_result image_decode_exr(const char *name, const void *data, size_t size, image *out,
                               base_error *err) {
    exr_reader reader = {.data = data, .size = size, .out = out};
    *out = (image){0};
    message[0] = '\0';
    exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
    setup.error_handler_fn = keep_message;
    setup.user_data = &reader;
    setup.read_fn = read_at;
    setup.size_fn = read_size;
    setup.max_image_width = setup.max_image_height = (int)IMAGE_MAX_SIDE;
    setup.max_tile_width = setup.max_tile_height = 4096;
    setup.flags = EXR_CONTEXT_FLAG_STRICT_HEADER | EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;

    exr_storage_t storage = EXR_STORAGE_LAST_TYPE;
    exr_attr_box2i_t window = {0};
    base_error unsupported = {0};
    strata_result result = STRATA_OK;
    exr_result_t code = exr_start_read(&reader.context, name, &setup);
    if (code == EXR_ERR_SUCCESS)
        result = inspect(&reader, &storage, &window, &unsupported);
    if (code == EXR_ERR_SUCCESS && result == STRATA_OK) {
        code = storage == EXR_STORAGE_TILED ? decode_tiles(&reader)
                                            : decode_scanlines(&reader, window.min.y);
    }
    if (result != STRATA_OK) {
        result = base_fail(err, result, "%s: %s", name, unsupported.text);
    } else if (code != EXR_ERR_SUCCESS) {
        result = base_fail(err,
                           code == EXR_ERR_OUT_OF_MEMORY ? STRATA_ERROR_OUT_OF_HOST_MEMORY
                                                         : STRATA_ERROR_BAD_FILE,
                           "%s: OpenEXR: %s", name, explain(code));
    } else {
        finish_pixels(out, reader.grey);
    }
    if (reader.context) {
        exr_decoding_destroy(reader.context, &reader.decoder);
        exr_finish(&reader.context);
    }
    if (result != STRATA_OK)
        image_free(out);
    return result;
}
