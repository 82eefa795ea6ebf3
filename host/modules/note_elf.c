/* SPDX-License-Identifier: MIT
 *
 * Finds the Strata note of a shared object by its program headers, with plain reads: the file is
 * never mapped or opened by the dynamic linker, and every offset and size in it is distrusted.
 */
#define _POSIX_C_SOURCE 200809L
#include "modules/modules_internal.h"

#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define HEADERS_MAX 1024u     /* program headers; real files have about ten */
#define SEGMENT_MAX 0x200000u /* bytes of one note segment */

typedef struct elf_file {
    const char *path;
    int fd;
    uint64_t size;
} elf_file;

static strata_result elf_fail(const elf_file *file, const char *what, base_error *err) {
    return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: %s", file->path, what);
}

/* Reads exactly `size` bytes at `offset`, both from the file and so distrusted. */
static strata_result elf_read(const elf_file *file, uint64_t offset, void *data, uint64_t size,
                              const char *what, base_error *err) {
    if (offset > file->size || size > file->size - offset)
        return base_fail(err, STRATA_ERROR_BAD_FILE, "%s: %s reaches beyond the end of the file",
                         file->path, what);
    unsigned char *to = data;
    while (size > 0) {
        ssize_t got = pread(file->fd, to, size, (off_t)offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return base_fail(err, STRATA_ERROR_IO, "%s: cannot read %s: %s", file->path, what,
                             got < 0 ? strerror(errno) : "the file became shorter");
        to += got;
        offset += (uint64_t)got;
        size -= (uint64_t)got;
    }
    return STRATA_OK;
}

static strata_result elf_check_header(const elf_file *file, const Elf64_Ehdr *header,
                                      base_error *err) {
    const uint16_t one = 1;
    unsigned char little = *(const unsigned char *)&one;
    if (memcmp(header->e_ident, ELFMAG, SELFMAG) != 0)
        return elf_fail(file, "not an ELF file", err);
    if (header->e_ident[EI_CLASS] != (sizeof(void *) == 8 ? ELFCLASS64 : ELFCLASS32) ||
        header->e_ident[EI_DATA] != (little ? ELFDATA2LSB : ELFDATA2MSB))
        return elf_fail(file, "an ELF file for another kind of machine", err);
    if (header->e_ident[EI_VERSION] != EV_CURRENT || header->e_type != ET_DYN)
        return elf_fail(file, "an ELF file, but not a shared object", err);
    if (header->e_phnum == 0 || header->e_phnum > HEADERS_MAX ||
        header->e_phentsize != sizeof(Elf64_Phdr))
        return elf_fail(file, "ELF program headers of an impossible number or size", err);
    return STRATA_OK;
}

/* Looks through the notes in `data`. STRATA_OK with *text NULL: none of them is ours. */
static strata_result elf_scan_notes(const elf_file *file, const unsigned char *data, uint64_t size,
                                    char **text, base_error *err) {
    uint64_t at = 0;
    while (size - at >= sizeof(Elf64_Nhdr)) {
        Elf64_Nhdr note;
        memcpy(&note, data + at, sizeof note);
        at += sizeof note;
        /* Sums of two 32-bit sizes and their padding to 4 bytes fit 64 bits. */
        uint64_t name_room = ((uint64_t)note.n_namesz + 3) & ~UINT64_C(3);
        uint64_t desc_room = ((uint64_t)note.n_descsz + 3) & ~UINT64_C(3);
        if (name_room > size - at || note.n_descsz > size - at - name_room)
            return elf_fail(file, "an ELF note reaches beyond its segment", err);
        const char *name = (const char *)data + at;
        const char *desc = name + name_room;
        if (note.n_type == NOTE_TYPE && note.n_namesz == sizeof NOTE_NAME &&
            memcmp(name, NOTE_NAME, sizeof NOTE_NAME) == 0) {
            if (note.n_descsz == 0 || note.n_descsz > NOTE_SIZE_MAX ||
                memchr(desc, 0, note.n_descsz))
                return elf_fail(file, "the Strata note is empty, too long or not text", err);
            *text = base_calloc((size_t)note.n_descsz + 1, 1);
            if (!*text)
                return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: out of memory",
                                 file->path);
            memcpy(*text, desc, note.n_descsz);
            return STRATA_OK;
        }
        at += name_room;
        at += desc_room < size - at ? desc_room : size - at;
    }
    return STRATA_OK;
}

static strata_result elf_scan_segment(const elf_file *file, const Elf64_Phdr *segment, char **text,
                                      base_error *err) {
    if (segment->p_filesz > SEGMENT_MAX)
        return elf_fail(file, "an ELF note segment is too long", err);
    /* Other notes may share a segment of 8-byte alignment; ours is aligned to 4. */
    if (segment->p_filesz < sizeof(Elf64_Nhdr) || segment->p_align > 4)
        return STRATA_OK;
    unsigned char *data = base_calloc((size_t)segment->p_filesz, 1);
    if (!data)
        return base_fail(err, STRATA_ERROR_OUT_OF_HOST_MEMORY, "%s: out of memory", file->path);
    strata_result result =
        elf_read(file, segment->p_offset, data, segment->p_filesz, "an ELF note segment", err);
    if (result == STRATA_OK)
        result = elf_scan_notes(file, data, segment->p_filesz, text, err);
    free(data);
    return result;
}

static strata_result elf_find(const elf_file *file, char **text, base_error *err) {
    Elf64_Ehdr header = {0};
    strata_result result = elf_read(file, 0, &header, sizeof header, "the ELF header", err);
    if (result == STRATA_OK)
        result = elf_check_header(file, &header, err);
    for (uint32_t i = 0; result == STRATA_OK && i < header.e_phnum; i++) {
        Elf64_Phdr segment = {0};
        uint64_t offset;
        if (__builtin_add_overflow(header.e_phoff, (uint64_t)i * sizeof segment, &offset))
            result =
                elf_fail(file, "the ELF program headers reach beyond the end of the file", err);
        if (result == STRATA_OK)
            result = elf_read(file, offset, &segment, sizeof segment, "an ELF program header", err);
        /* The dynamic linker maps what is not there and dies of it, so look here. */
        if (result == STRATA_OK && segment.p_type == PT_LOAD &&
            (segment.p_offset > file->size || segment.p_filesz > file->size - segment.p_offset))
            result = elf_fail(file, "cut off: a segment reaches beyond the end of the file", err);
        if (result == STRATA_OK && segment.p_type == PT_NOTE && !*text)
            result = elf_scan_segment(file, &segment, text, err);
    }
    if (result == STRATA_OK && !*text)
        result =
            base_fail(err, STRATA_ERROR_NOT_FOUND,
                      "%s: has no Strata note; was it built with strata_add_module?", file->path);
    return result;
}

strata_result note_elf_read(const char *path, char **text, base_error *err) {
    *text = NULL;
    elf_file file = {.path = path, .fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file.fd < 0)
        return base_fail(err, errno == ENOENT ? STRATA_ERROR_NOT_FOUND : STRATA_ERROR_IO, "%s: %s",
                         path, strerror(errno));
    strata_result result;
    struct stat status;
    if (fstat(file.fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        result = elf_fail(&file, "not a regular file", err);
    } else {
        file.size = (uint64_t)status.st_size;
        result = elf_find(&file, text, err);
    }
    close(file.fd);
    if (result != STRATA_OK) {
        free(*text);
        *text = NULL;
    }
    return result;
}
