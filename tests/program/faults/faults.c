/* Preloaded into the program: makes it fail to change files below a directory.
 *
 *   FAULTS_BELOW   the directory, as a path without links; nothing happens without it
 *   FAULTS_AT      which of the calls there fails, counted from 1; 0 for none
 *   FAULTS_NAME    all calls fail whose path ends with this
 *   FAULTS_KIND    EIO or ENOSPC: the call fails with it, and changes nothing
 *                  SHORT: a write takes half of its bytes, and the file's next write fails with ENOSPC
 *                  KILL: the process is killed instead
 *   FAULTS_SPACE   so many bytes can be written there, and then no more, as on a full disk
 *   FAULTS_COUNT   a file that gets the number of calls when the program ends
 *   FAULTS_REPORT  a file that is written when a call fails: its name, a space, and the path
 *
 * Syncs that don't fail do nothing: what is tested is what the program does, not the disk.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static const char *below, *kind = "EIO", *name, *report;
static long at;
static atomic_long calls, space = LONG_MAX;
static atomic_int full = -1; /* the file whose next write fails */

/* Writes how many calls there were, if that is asked for. */
__attribute__((destructor)) static void end(void) {
    const char *count = getenv("FAULTS_COUNT");
    FILE *file = count ? fopen(count, "w") : NULL;
    if (!file) return;
    fprintf(file, "%ld", atomic_load(&calls));
    fclose(file);
}

__attribute__((constructor)) static void begin(void) {
    const char *text;
    below = getenv("FAULTS_BELOW");
    report = getenv("FAULTS_REPORT");
    name = getenv("FAULTS_NAME");
    if ((text = getenv("FAULTS_AT"))) at = atol(text);
    if ((text = getenv("FAULTS_KIND"))) kind = text;
    if ((text = getenv("FAULTS_SPACE"))) space = atol(text);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int is_below(const char *path) {
    size_t length;
    if (!below || !path) return 0;
    length = strlen(below);
    return strncmp(path, below, length) == 0 && (path[length] == '/' || path[length] == 0);
}

static const char *path_of(int file, char *path) {
    char link[64];
    ssize_t length;
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    length = readlink(link, path, PATH_MAX - 1);
    if (length < 0) return NULL;
    path[length] = 0;
    return path;
}

static void tell(const char *call, const char *path) {
    int file = report ? REAL(open)(report, O_WRONLY | O_CREAT | O_TRUNC, 0666) : -1;
    if (file < 0) return;
    REAL(write)(file, call, strlen(call));
    REAL(write)(file, " ", 1);
    REAL(write)(file, path, strlen(path));
    close(file);
}

static int is_named(const char *path) {
    size_t own = name ? strlen(name) : 0, length = strlen(path);
    return own && own <= length && strcmp(path + length - own, name) == 0;
}

/* Counts a call. Whether it is one that fails, with errno set. */
static int fails(const char *call, const char *path) {
    if (!is_below(path) || (atomic_fetch_add(&calls, 1) + 1 != at && !is_named(path))) return 0;
    tell(call, path);
    if (strcmp(kind, "KILL") == 0) raise(SIGKILL);
    errno = strcmp(kind, "EIO") == 0 ? EIO : ENOSPC;
    return 1;
}

/* How many bytes a write may take; -1 if it fails. */
static ssize_t room(const char *call, int file, size_t count) {
    char path[PATH_MAX];
    long left;
    if (!is_below(path_of(file, path))) return count;
    if (atomic_load(&full) == file) {
        atomic_store(&full, -1);
        errno = ENOSPC;
        return -1;
    }
    if (fails(call, path)) {
        if (strcmp(kind, "SHORT") != 0 || count < 2) return -1;
        atomic_store(&full, file);
        return count / 2;
    }
    left = atomic_fetch_sub(&space, count);
    if (left >= (long)count) return count;
    if (left > 0) return left;
    tell(call, path);
    errno = ENOSPC;
    return -1;
}

ssize_t write(int file, const void *bytes, size_t count) {
    ssize_t some = room("write", file, count);
    return some < 0 ? some : REAL(write)(file, bytes, some);
}

ssize_t pwrite(int file, const void *bytes, size_t count, off_t from) {
    ssize_t some = room("pwrite", file, count);
    return some < 0 ? some : REAL(pwrite)(file, bytes, some, from);
}

ssize_t pwrite64(int file, const void *bytes, size_t count, off64_t from) {
    ssize_t some = room("pwrite", file, count);
    return some < 0 ? some : REAL(pwrite64)(file, bytes, some, from);
}

ssize_t writev(int file, const struct iovec *parts, int count) {
    size_t whole = 0;
    ssize_t some;
    for (int i = 0; i < count; i++) whole += parts[i].iov_len;
    some = room("writev", file, whole);
    if (some < 0 || (size_t)some == whole) return some < 0 ? some : REAL(writev)(file, parts, count);
    return REAL(write)(file, parts[0].iov_base, (size_t)some < parts[0].iov_len ? (size_t)some : parts[0].iov_len);
}

static int changes(int flags) {
    return (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT) != 0;
}

#define OPEN(name)                                                                                  \
    int name(const char *path, int flags, ...) {                                                    \
        va_list more;                                                                               \
        mode_t mode;                                                                                \
        va_start(more, flags);                                                                      \
        mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;                            \
        va_end(more);                                                                               \
        return changes(flags) && fails("open", path) ? -1 : REAL(name)(path, flags, mode);          \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                                                \
    int name(int directory, const char *path, int flags, ...) {                                     \
        va_list more;                                                                               \
        mode_t mode;                                                                                \
        va_start(more, flags);                                                                      \
        mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(more, mode_t) : 0;                            \
        va_end(more);                                                                               \
        return changes(flags) && fails("open", path) ? -1 : REAL(name)(directory, path, flags, mode); \
    }
OPENAT(openat)
OPENAT(openat64)

#define SYNC(name)                                                                                  \
    int name(int file) {                                                                            \
        char path[PATH_MAX];                                                                        \
        if (!is_below(path_of(file, path))) return REAL(name)(file);                                \
        return fails(#name, path) ? -1 : 0;                                                         \
    }
SYNC(fsync)
SYNC(fdatasync)

#define CUT(name, offset)                                                                           \
    int name(int file, offset length) {                                                             \
        char path[PATH_MAX];                                                                        \
        return fails("ftruncate", path_of(file, path)) ? -1 : REAL(name)(file, length);             \
    }
CUT(ftruncate, off_t)
CUT(ftruncate64, off64_t)

int rename(const char *from, const char *to) {
    return fails("rename", to) ? -1 : REAL(rename)(from, to);
}

int link(const char *from, const char *to) {
    return fails("link", to) ? -1 : REAL(link)(from, to);
}

int linkat(int old, const char *from, int new, const char *to, int flags) {
    return fails("link", to) ? -1 : REAL(linkat)(old, from, new, to, flags);
}

int mkdir(const char *path, mode_t mode) {
    return fails("mkdir", path) ? -1 : REAL(mkdir)(path, mode);
}

int unlink(const char *path) {
    return fails("unlink", path) ? -1 : REAL(unlink)(path);
}
