/* SPDX-License-Identifier: MIT
 *
 * Whole-file reading, and writing beside-then-rename. Temporaries that are still open are listed in
 * a fixed table, so that a signal handler can remove them with nothing but unlink(2).
 */
#define _POSIX_C_SOURCE 200809L
#include "base/base.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- temporaries --------------------------------------------------------------------------- */

enum { SLOT_FREE, SLOT_CLAIMED, SLOT_ARMED };

static struct {
    atomic_int state; /* path may be read by a handler only while SLOT_ARMED */
    char path[4096];
} open_temporaries[32];

static int claim_slot(const char *path) {
    for (int i = 0; i < (int)BASE_COUNT(open_temporaries); i++) {
        int expected = SLOT_FREE;
        if (!atomic_compare_exchange_strong(&open_temporaries[i].state, &expected, SLOT_CLAIMED))
            continue;
        snprintf(open_temporaries[i].path, sizeof open_temporaries[i].path, "%s", path);
        return i;
    }
    return -1;
}

static void release_slot(const char *path) {
    for (size_t i = 0; i < BASE_COUNT(open_temporaries); i++)
        if (atomic_load(&open_temporaries[i].state) == SLOT_ARMED &&
            strcmp(open_temporaries[i].path, path) == 0)
            atomic_store(&open_temporaries[i].state, SLOT_FREE);
}

void base_files_abort_all(void) {
    int saved = errno;
    for (size_t i = 0; i < BASE_COUNT(open_temporaries); i++)
        if (atomic_load(&open_temporaries[i].state) == SLOT_ARMED) {
            unlink(open_temporaries[i].path);
            atomic_store(&open_temporaries[i].state, SLOT_FREE);
        }
    errno = saved;
}

/* Creates out->temporary, which must not exist, and arms its slot; no signal comes in between. */
static int create_temporary(base_output *out) {
    int slot = claim_slot(out->temporary);
    if (slot < 0) {
        errno = EMFILE;
        return -1;
    }
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_BLOCK, &all, &before);
    int fd = open(out->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    int saved = errno;
    atomic_store(&open_temporaries[slot].state, fd >= 0 ? SLOT_ARMED : SLOT_FREE);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    errno = saved;
    return fd;
}

static strata_result fail_system(base_error *err, const char *path, const char *verb, int reason) {
    strata_result result =
        reason == ENOENT || reason == ENOTDIR ? STRATA_ERROR_NOT_FOUND : STRATA_ERROR_IO;
    return base_fail(err, result, "%s: cannot %s: %s", path, verb, strerror(reason));
}

/* ---- reading ------------------------------------------------------------------------------- */

static strata_result read_all(int fd, const char *path, unsigned char *data, size_t wanted,
                              size_t *size, base_error *err) {
    *size = 0;
    while (*size < wanted) {
        ssize_t got = read(fd, data + *size, wanted - *size);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return fail_system(err, path, "read", errno);
        if (got == 0)
            break; /* it shrank meanwhile */
        *size += (size_t)got;
    }
    data[*size] = '\0';
    return STRATA_OK;
}

strata_result base_file_read(const char *path, size_t limit, unsigned char **data, size_t *size,
                             base_error *err) {
    strata_result result;
    struct stat info;
    unsigned char *bytes = NULL;

    *data = NULL;
    *size = 0;
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a FIFO must not block us */
    if (fd < 0)
        return fail_system(err, path, "open", errno);
    if (fstat(fd, &info) != 0) {
        result = fail_system(err, path, "read", errno);
        goto cleanup;
    }
    if (!S_ISREG(info.st_mode)) {
        result = base_fail(err, STRATA_ERROR_IO, "%s: is not a regular file", path);
        goto cleanup;
    }
    if (info.st_size < 0 || (uintmax_t)info.st_size > limit ||
        (uintmax_t)info.st_size >= SIZE_MAX) {
        result =
            base_fail(err, STRATA_ERROR_BAD_FILE, "%s: has %jd bytes, more than the limit of %zu",
                      path, (intmax_t)info.st_size, limit);
        goto cleanup;
    }
    bytes = malloc((size_t)info.st_size + 1);
    if (!bytes) {
        result = base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: no memory for %jd bytes",
                           path, (intmax_t)info.st_size);
        goto cleanup;
    }
    result = read_all(fd, path, bytes, (size_t)info.st_size, size, err);
    if (result == STRATA_OK) {
        *data = bytes;
        bytes = NULL;
    }
cleanup:
    free(bytes);
    close(fd);
    return result;
}

/* ---- writing ------------------------------------------------------------------------------- */

strata_result base_output_open(base_output *out, const char *path, base_error *err) {
    static atomic_uint serial;
    struct stat info;

    *out = (base_output){.fd = -1};
    if (!path[0])
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "the name of an output file is empty");
    if ((size_t)snprintf(out->path, sizeof out->path, "%s", path) >= sizeof out->path)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%.64s...: the path is too long",
                         path);
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return fail_system(err, path, "write", EISDIR);
    if (stat(path, &info) == 0 && !S_ISREG(info.st_mode)) {
        /* A device or a pipe is written to; renaming over it would replace it. */
        out->fd = open(path, O_WRONLY | O_CLOEXEC);
        return out->fd < 0 ? fail_system(err, path, "write", errno) : STRATA_OK;
    }
    for (int attempt = 0; attempt < 100 && out->fd < 0; attempt++) {
        int length = snprintf(out->temporary, sizeof out->temporary, "%s.%ld-%u.part", path,
                              (long)getpid(), atomic_fetch_add(&serial, 1));
        if (length < 0 || (size_t)length >= sizeof out->temporary) {
            errno = ENAMETOOLONG;
            break;
        }
        out->fd = create_temporary(out);
        if (out->fd < 0 && errno != EEXIST)
            break;
    }
    if (out->fd < 0) {
        out->temporary[0] = '\0';
        return fail_system(err, path, "write", errno);
    }
    return STRATA_OK;
}

strata_result base_output_write(base_output *out, const void *data, size_t size, base_error *err) {
    const char *rest = data;
    while (size > 0) {
        ssize_t wrote = write(out->fd, rest, size);
        if (wrote < 0 && errno == EINTR)
            continue;
        if (wrote < 0)
            return fail_system(err, out->path, "write", errno);
        rest += wrote;
        size -= (size_t)wrote;
    }
    return STRATA_OK;
}

strata_result base_output_commit(base_output *out, base_error *err) {
    int fd = out->fd;
    out->fd = -1;
    int failed = fd < 0 ? EBADF : close(fd) != 0 ? errno : 0;
    if (!failed && out->temporary[0] && rename(out->temporary, out->path) != 0)
        failed = errno;
    if (failed) {
        base_output_abort(out);
        return fail_system(err, out->path, "write", failed);
    }
    release_slot(out->temporary);
    out->temporary[0] = '\0';
    return STRATA_OK;
}

void base_output_abort(base_output *out) {
    if (out->path[0] && out->fd >= 0) /* an all-zero output was never opened */
        close(out->fd);
    out->fd = -1;
    if (out->temporary[0]) {
        unlink(out->temporary);
        release_slot(out->temporary);
    }
    out->temporary[0] = '\0';
}

strata_result base_make_folders(const char *path, base_error *err) {
    char part[4096];
    struct stat info;

    size_t length = strlen(path);
    if (length == 0 || length >= sizeof part)
        return base_fail(err, STRATA_ERROR_INVALID_ARGUMENT, "%.64s: not the path of a folder",
                         path);
    memcpy(part, path, length + 1);
    for (size_t i = 1; i <= length; i++) {
        if (part[i] != '/' && part[i] != '\0')
            continue;
        char kept = part[i];
        part[i] = '\0';
        if (mkdir(part, 0777) != 0 && (errno != EEXIST || stat(part, &info) != 0))
            return fail_system(err, part, "create the folder", errno);
        part[i] = kept;
    }
    if (stat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return base_fail(err, STRATA_ERROR_IO, "%s: is not a folder", path);
    return STRATA_OK;
}
