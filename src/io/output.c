#define _GNU_SOURCE
#include "io/output.h"
#include "core/part.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* Longest part of the file's own name in a temporary name: the rest of the 255 bytes that file
 * systems allow is for the process and a number. */
#define STEM_MAX    200
#define NAME_TRIES  100
#define BUFFER_SIZE 65536

/* ---- signals ------------------------------------------------------------------------------ */

/* The one thing a signal handler can reach. */
static char *volatile unfinished[BTG_OUTPUT_MAX];

static void end_by_signal(int number) {
    for (int i = 0; i < BTG_OUTPUT_MAX; i++) {
        if (unfinished[i]) unlink(unfinished[i]);
    }
    signal(number, SIG_DFL);
    raise(number);
}

void btg_output_guard(void) {
    const int ends[3] = {SIGINT, SIGTERM, SIGHUP};
    for (int i = 0; i < 3; i++) {
        struct sigaction action = {0};
        if (sigaction(ends[i], NULL, &action) != 0 || action.sa_handler == SIG_IGN) continue;
        action.sa_handler = end_by_signal;
        action.sa_flags = 0;
        sigaction(ends[i], &action, NULL);
    }
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);
    /* A closed standard stream must not become the first file opened; writing to it fails. */
    for (int fd = 0; fd <= 2; fd++) {
        if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDONLY) < 0) return;
    }
}

/* ---- where -------------------------------------------------------------------------------- */

/* Number of the descriptor that the path names, or -1. */
static int descriptor(const char *path) {
    const char *const prefix[2] = {"/dev/fd/", "/proc/self/fd/"};
    if (strcmp(path, "-") == 0 || strcmp(path, "/dev/stdout") == 0) return STDOUT_FILENO;
    if (strcmp(path, "/dev/stderr") == 0) return STDERR_FILENO;
    for (int i = 0; i < 2; i++) {
        size_t n = strlen(prefix[i]);
        if (strncmp(path, prefix[i], n) != 0) continue;
        char *end;
        long number = strtol(path + n, &end, 10);
        if (end != path + n && *end == '\0' && number >= 0 && number < INT_MAX) return (int)number;
    }
    return -1;
}

static btg_status fail(const char *path, int error, btg_message *message) {
    const char *reason = strerror(error), *remedy = "write elsewhere";
    if (error == ENOSPC || error == EDQUOT || error == EFBIG)
        remedy = "make room or write elsewhere";
    if (error == ENOENT) remedy = "make its directory first";
    if (error == EACCES || error == EPERM || error == EROFS) {
        remedy = "change the permissions or write elsewhere";
    }
    /* A standard stream that is closed stands as one to read from (btg_output_guard). */
    if (error == EBADF || (error == EINVAL && descriptor(path) >= 0)) {
        reason = "it is not open for writing";
        remedy = "open it or write to a file";
    }
    if (strcmp(path, "-") == 0) path = "standard output";
    return btg_fail(message, BTG_ERROR_FILE, "%.256s: cannot write: %s; %s", path, reason, remedy);
}

static btg_status adopt(btg_output *o, int fd, btg_message *message) {
    o->file = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (!o->file) {
        int error = errno;
        if (fd >= 0) close(fd);
        return fail(o->path, error, message);
    }
    setvbuf(o->file, NULL, _IOFBF, BUFFER_SIZE);
    return BTG_OK;
}

static bool same_place(int fd, int other) {
    struct stat a, b, null;
    if (fstat(fd, &a) != 0 || fstat(other, &b) != 0) return false;
    if (stat("/dev/null", &null) == 0 && S_ISCHR(a.st_mode) && a.st_rdev == null.st_rdev) {
        return false;
    }
    return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

static btg_status open_directly(btg_output *o, int fd, btg_message *message) {
    if (fd >= 0) o->standard = same_place(fd, STDOUT_FILENO);
    return adopt(o, fd, message);
}

/* ---- regular files ------------------------------------------------------------------------ */

static char *temporary_name(const char *path, int try) {
    const char *slash = strrchr(path, '/');
    int folder = slash ? (int)(slash - path) + 1 : 0;
    size_t size = (size_t)folder + STEM_MAX + 64;
    char *name = malloc(size);
    if (!name) return NULL;
    snprintf(name, size, "%.*s.%.*s.%ld-%d.tmp", folder, path, STEM_MAX, path + folder,
             (long)getpid(), try);
    return name;
}

/* The name is in the handler's list before the file exists. */
static int create(btg_output *o, mode_t mode) {
    for (int i = 0; i < NAME_TRIES; i++) {
        o->temporary = temporary_name(o->path, i);
        if (!o->temporary) return -1;
        unfinished[o->slot] = o->temporary;
        int fd = open(o->temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (fd >= 0) return fd;
        int error = errno;
        unfinished[o->slot] = NULL;
        free(o->temporary);
        o->temporary = NULL;
        errno = error;
        if (error != EEXIST) return -1;
    }
    return -1;
}

static btg_status open_beside(btg_output *o, const struct stat *old, btg_message *message) {
    o->slot = 0;
    while (o->slot < BTG_OUTPUT_MAX && unfinished[o->slot])
        o->slot++;
    if (o->slot == BTG_OUTPUT_MAX) return fail(o->path, EMFILE, message);
    int fd = create(o, 0666);
    if (fd >= 0 && old && fchmod(fd, old->st_mode & 07777) != 0) {
        /* The new file keeps the usual permissions. */
    }
    return adopt(o, fd, message);
}

static btg_status open_path(btg_output *o, const char *path, btg_message *message) {
    struct stat old;
    int fd = descriptor(path);
    if (fd >= 0) return open_directly(o, dup(fd), message);
    bool exists = stat(path, &old) == 0;
    if (!exists && (errno != ENOENT || lstat(path, &old) == 0)) return fail(path, errno, message);
    if (!exists) return open_beside(o, NULL, message);
    if (S_ISDIR(old.st_mode)) return fail(path, EISDIR, message);
    if (!S_ISREG(old.st_mode)) return open_directly(o, open(path, O_WRONLY | O_CLOEXEC), message);
    if (access(path, W_OK) != 0) return fail(path, errno, message);
    char *real = realpath(path, NULL);
    if (!real) return fail(path, errno, message);
    free(o->path);
    o->path = real;
    return open_beside(o, &old, message);
}

btg_status btg_output_open(btg_output *output, const char *path, btg_message *message) {
    btg_output o = {.path = strdup(path)};
    btg_status status = o.path ? open_path(&o, path, message) : fail(path, ENOMEM, message);
    if (status != BTG_OK) {
        btg_output_discard(&o);
        return status;
    }
    *output = o;
    return BTG_OK;
}

btg_output btg_output_borrow(FILE *file) {
    return (btg_output){.file = file, .standard = true};
}

/* ---- content ------------------------------------------------------------------------------ */

static void latch(btg_output *o) {
    if (o->error == 0) o->error = errno ? errno : EIO;
}

void btg_output_write(btg_output *output, const char *text, size_t size) {
    if (output->error) return;
    errno = 0;
    if (fwrite(text, 1, size, output->file) != size) latch(output);
}

void btg_output_text(btg_output *output, const char *text) {
    btg_output_write(output, text, strlen(text));
}

void btg_output_format(btg_output *output, const char *format, ...) {
    if (output->error) return;
    va_list arguments;
    va_start(arguments, format);
    errno = 0;
    if (vfprintf(output->file, format, arguments) < 0) latch(output);
    va_end(arguments);
}

btg_status btg_output_check(const btg_output *output, btg_message *message) {
    if (output->error == 0) return BTG_OK;
    return fail(output->path ? output->path : "standard output", output->error, message);
}

btg_status btg_output_finish(btg_output *output, btg_message *message) {
    errno = 0;
    if (fflush(output->file) != 0 || ferror(output->file)) latch(output);
    if (output->temporary && output->error == 0 && fsync(fileno(output->file)) != 0) {
        /* Not every file system can; those that can tell a full disk here. */
        if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) latch(output);
    }
    if (output->path) {
        errno = 0;
        if (fclose(output->file) != 0) latch(output);
        output->file = NULL;
    }
    return btg_output_check(output, message);
}

btg_status btg_output_commit(btg_output *output, btg_message *message) {
    if (!output->temporary) return BTG_OK;
    if (rename(output->temporary, output->path) != 0) return fail(output->path, errno, message);
    unfinished[output->slot] = NULL;
    free(output->temporary);
    output->temporary = NULL;
    return BTG_OK;
}

void btg_output_discard(btg_output *output) {
    if (output->file && output->path) fclose(output->file);
    if (output->temporary) {
        unlink(output->temporary);
        unfinished[output->slot] = NULL;
        free(output->temporary);
    }
    free(output->path);
    *output = (btg_output){0};
}
