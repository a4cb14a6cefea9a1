/* For tests: kills a process, or simulates a full or failing disk, at one of the calls that change files. Preloaded before the C library.
 *
 * ONSET_POINT  number of the call, from 1; no disturbance if unset
 * ONSET_MODE   before: killed before the call; after: killed after it; cut: killed in the middle of a write;
 *              full: the disk is full from this call on; once: this call fails with EIO, as on faulty disks and networks;
 *              error: this and all following calls fail with EIO
 * ONSET_COUNT  file for the total number of calls
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

static long calls, point;
static char mode;

static __attribute__((constructor)) void begin(void) {
  const char *text = getenv("ONSET_POINT");
  point = text ? atol(text) : 0;
  text = getenv("ONSET_MODE");
  mode = text ? text[0] : 'n';
}

static __attribute__((destructor)) void end(void) {
  const char *path = getenv("ONSET_COUNT");
  if (!path) return;
  char text[32];
  int length = snprintf(text, sizeof text, "%ld", calls);
  int file = syscall(SYS_openat, AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (file >= 0) {
    syscall(SYS_write, file, text, length);
    syscall(SYS_close, file);
  }
}

static void die(void) {
  syscall(SYS_kill, getpid(), SIGKILL);
  for (;;) pause();
}

/* Returns true if this call is disturbed. */
static int enter(void) {
  long now = __atomic_add_fetch(&calls, 1, __ATOMIC_SEQ_CST);
  if (point && now == point && mode == 'b') die();
  return point && now == point;
}

static void leave(int is_the_one) {
  if (is_the_one && (mode == 'a' || mode == 'c')) die();
}

/* Error that replaces the call, or zero. */
static int refusal(int here, int needs_room) {
  if (here && mode == 'o') return EIO;
  if (!point || __atomic_load_n(&calls, __ATOMIC_SEQ_CST) < point) return 0;
  return mode == 'e' ? EIO : mode == 'f' && needs_room ? ENOSPC : 0;
}

#define REAL(type, name, ...) type (*real)(__VA_ARGS__) = (type (*)(__VA_ARGS__))dlsym(RTLD_NEXT, name)

#define CALL(name, needs_room, parameters, arguments, ...) \
  int name parameters {                                   \
    REAL(int, #name, __VA_ARGS__);                        \
    int here = enter();                                   \
    int refused = refusal(here, needs_room);              \
    if (refused) {                                        \
      errno = refused;                                    \
      return -1;                                          \
    }                                                     \
    int result = real arguments;                          \
    int error = errno;                                    \
    leave(here);                                          \
    errno = error;                                        \
    return result;                                        \
  }

/* Calls that need no disk space, and calls that do. */
#define FREE(name, ...) CALL(name, 0, __VA_ARGS__)
#define NEEDY(name, ...) CALL(name, 1, __VA_ARGS__)

FREE(rename, (const char *a, const char *b), (a, b), const char *, const char *)
FREE(unlink, (const char *a), (a), const char *)
FREE(unlinkat, (int d, const char *a, int f), (d, a, f), int, const char *, int)
FREE(rmdir, (const char *a), (a), const char *)
FREE(chmod, (const char *a, mode_t m), (a, m), const char *, mode_t)
FREE(fchmod, (int f, mode_t m), (f, m), int, mode_t)
NEEDY(link, (const char *a, const char *b), (a, b), const char *, const char *)
NEEDY(linkat, (int c, const char *a, int d, const char *b, int f), (c, a, d, b, f), int, const char *, int, const char *, int)
NEEDY(mkdir, (const char *a, mode_t m), (a, m), const char *, mode_t)
NEEDY(fsync, (int f), (f), int)
NEEDY(fdatasync, (int f), (f), int)

static int opened(const char *name, int folder, const char *path, int flags, mode_t rights, int is_at) {
  int changes = (flags & (O_CREAT | O_TRUNC)) != 0;
  int here = changes ? enter() : 0;
  int refused = changes ? refusal(here, 1) : 0;
  if (refused) {
    errno = refused;
    return -1;
  }
  int result;
  if (is_at) {
    REAL(int, name, int, const char *, int, ...);
    result = real(folder, path, flags, rights);
  } else {
    REAL(int, name, const char *, int, ...);
    result = real(path, flags, rights);
  }
  int error = errno;
  leave(here);
  errno = error;
  return result;
}

#define RIGHTS                                            \
  mode_t rights = 0;                                      \
  if (flags & (O_CREAT | __O_TMPFILE)) {                  \
    va_list more;                                         \
    va_start(more, flags);                                \
    rights = va_arg(more, mode_t);                        \
    va_end(more);                                         \
  }

int open(const char *path, int flags, ...) {
  RIGHTS
  return opened("open", 0, path, flags, rights, 0);
}
int open64(const char *path, int flags, ...) {
  RIGHTS
  return opened("open64", 0, path, flags, rights, 0);
}
int openat(int folder, const char *path, int flags, ...) {
  RIGHTS
  return opened("openat", folder, path, flags, rights, 1);
}
int openat64(int folder, const char *path, int flags, ...) {
  RIGHTS
  return opened("openat64", folder, path, flags, rights, 1);
}

ssize_t write(int file, const void *bytes, size_t count) {
  REAL(ssize_t, "write", int, const void *, size_t);
  struct stat found;
  if (fstat(file, &found) != 0 || !S_ISREG(found.st_mode)) return real(file, bytes, count);
  int here = enter();
  int refused = refusal(here, 1);
  if (refused) {
    errno = refused;
    return -1;
  }
  ssize_t result = real(file, bytes, here && mode == 'c' ? count / 2 : count);
  int error = errno;
  leave(here);
  errno = error;
  return result;
}
