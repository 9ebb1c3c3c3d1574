// bin/NAME of a package: starts ../libexec/NAME with the loader and the C library in ../lib, so
// that the programs run whatever C library the system has. Linked statically, against musl.
//
// libexec/NAME names its loader as the open file kLoader of the process that starts it. The kernel
// opens that file while it still has our descriptors, and closes ours afterwards. So the process is
// libexec/NAME in every respect: /proc/self/exe, its name in ps, its arguments. Nothing is added to
// the environment that its children inherit.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { kLoader = 241, kCannotRun = 127 };  // package.sh writes /proc/self/fd/241 into libexec/NAME.

static int Fail(const char* what) {
  fprintf(stderr, "%s: %s\n", what, strerror(errno));
  return kCannotRun;
}

int main(int argc, char** argv) {
  (void)argc;
  char self[PATH_MAX], path[PATH_MAX + 64];
  const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
  if (length < 0) return Fail("/proc/self/exe");
  self[length] = '\0';
  char* const name = strrchr(self, '/') + 1;
  name[-1] = '\0';
  *strrchr(self, '/') = '\0';  // The package's root; empty if that is the file system's.

  snprintf(path, sizeof path, "%s/lib/ld-linux-x86-64.so.2", self);
  const int loader = open(path, O_RDONLY | O_CLOEXEC);
  if (loader < 0) return Fail(path);
  if (loader != kLoader && dup3(loader, kLoader, O_CLOEXEC) < 0) return Fail("file number 241");
  snprintf(path, sizeof path, "%s/libexec/%s", self, name);
  execv(path, argv);
  return Fail(path);
}
