// Preloaded into a daemon (LD_PRELOAD): counts what it does to files below one folder, writes each
// operation to a log, and kills the process just before the one that is asked for; a write gets as
// far as half of its bytes. By environment:
//   PARALLAX_FILE_POINT_UNDER=DIR  the folder; without it nothing is counted
//   PARALLAX_FILE_POINT_LOG=FILE   "<operation> <path>" a line, "rename <from> <to>", with "failed
//   "
//                                  before it where it did; outside of DIR
//   PARALLAX_FILE_POINT_DIE=N      from 1; 0 or absent: never
// One lock around operation and line, so that the log has the order in which things happened.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>

namespace {

struct State {
  std::string under;
  long die_at = 0;
  long count = 0;  // Guarded by mu.
  int log = -1;
  std::mutex mu;
};

State& TheState() {
  static State* const state = [] {
    auto* made = new State;
    const char* under = std::getenv("PARALLAX_FILE_POINT_UNDER");
    const char* log = std::getenv("PARALLAX_FILE_POINT_LOG");
    const char* die_at = std::getenv("PARALLAX_FILE_POINT_DIE");
    if (under != nullptr && log != nullptr) {
      made->log = static_cast<int>(
          syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644));
      if (made->log >= 0) made->under = std::string(under) + "/";
    }
    if (die_at != nullptr) made->die_at = std::atol(die_at);
    return made;
  }();
  return *state;
}

std::string PathOfDescriptor(int fd) {
  char target[PATH_MAX];
  const std::string link = "/proc/self/fd/" + std::to_string(fd);
  const ssize_t size = readlink(link.c_str(), target, sizeof target);
  return size > 0 ? std::string(target, static_cast<size_t>(size)) : "";
}

std::string Absolute(int dir, const char* path) {
  if (path == nullptr || path[0] == '/') return path == nullptr ? "" : path;
  std::string from;
  if (dir == AT_FDCWD) {
    char current[PATH_MAX];
    if (getcwd(current, sizeof current) != nullptr) from = current;
  } else {
    from = PathOfDescriptor(dir);
  }
  return from + "/" + path;
}

bool Counts(const std::string& path) {
  const State& state = TheState();
  return !state.under.empty() && path.compare(0, state.under.size(), state.under) == 0;
}

void Note(const std::string& line) {
  const std::string text = line + "\n";
  syscall(SYS_write, TheState().log, text.data(), text.size());
}

// Runs `operation`, or dies. `torn`: what of it happens all the same.
template <typename Operation, typename Torn>
auto Point(const std::string& line, const Operation& operation, const Torn& torn) {
  State& state = TheState();
  const std::lock_guard lock(state.mu);
  if (++state.count == state.die_at) {
    torn();
    kill(getpid(), SIGKILL);
    while (true) pause();
  }
  const auto result = operation();
  const int error = errno;
  Note(result == static_cast<decltype(result)>(-1) ? "failed " + line : line);
  errno = error;
  return result;
}
template <typename Operation>
auto Point(const std::string& line, const Operation& operation) {
  return Point(line, operation, [] {});
}

template <typename Function>
Function* Real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int Open(int dir, const char* path, int flags, mode_t mode) {
  const auto open = [&] { return static_cast<int>(syscall(SYS_openat, dir, path, flags, mode)); };
  const std::string whole = Absolute(dir, path);
  if ((flags & (O_CREAT | O_TRUNC)) == 0 || !Counts(whole)) return open();
  return Point("create " + whole, open);
}

FILE* OpenStream(const char* path, const char* mode, const char* name) {
  static auto* const real = Real<FILE*(const char*, const char*)>(name);
  const std::string whole = Absolute(AT_FDCWD, path);
  if (mode[0] == 'r' || !Counts(whole)) return real(path, mode);
  FILE* stream = nullptr;
  Point("create " + whole, [&] {
    stream = real(path, mode);
    return stream == nullptr ? -1 : 0;
  });
  return stream;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return Open(AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return Open(AT_FDCWD, path, flags, mode);
}
int openat(int dir, const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return Open(dir, path, flags, mode);
}
int openat64(int dir, const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return Open(dir, path, flags, mode);
}
int creat(const char* path, mode_t mode) {
  return Open(AT_FDCWD, path, O_WRONLY | O_CREAT | O_TRUNC, mode);
}
FILE* fopen(const char* path, const char* mode) { return OpenStream(path, mode, "fopen"); }
FILE* fopen64(const char* path, const char* mode) { return OpenStream(path, mode, "fopen64"); }

ssize_t write(int fd, const void* bytes, size_t size) {
  const auto part = [&](size_t n) { return syscall(SYS_write, fd, bytes, n); };
  const std::string path = TheState().under.empty() ? "" : PathOfDescriptor(fd);
  if (!Counts(path)) return part(size);
  return Point(
      "write " + path, [&] { return part(size); }, [&] { part(size / 2); });
}
ssize_t writev(int fd, const iovec* pieces, int count) {
  const auto part = [&](int n) { return syscall(SYS_writev, fd, pieces, n); };
  const std::string path = TheState().under.empty() ? "" : PathOfDescriptor(fd);
  if (!Counts(path)) return part(count);
  return Point(
      "write " + path, [&] { return part(count); }, [&] { part(count / 2); });
}
ssize_t pwrite(int fd, const void* bytes, size_t size, off_t at) {
  const auto part = [&](size_t n) { return syscall(SYS_pwrite64, fd, bytes, n, at); };
  const std::string path = TheState().under.empty() ? "" : PathOfDescriptor(fd);
  if (!Counts(path)) return part(size);
  return Point(
      "write " + path, [&] { return part(size); }, [&] { part(size / 2); });
}
ssize_t pwrite64(int fd, const void* bytes, size_t size, off64_t at) {
  return pwrite(fd, bytes, size, at);
}

int fsync(int fd) {
  const auto sync = [&] { return static_cast<int>(syscall(SYS_fsync, fd)); };
  const std::string path = TheState().under.empty() ? "" : PathOfDescriptor(fd);
  // The folder itself counts too: its entries are.
  return Counts(path + "/") ? Point("sync " + path, sync) : sync();
}
int fdatasync(int fd) { return fsync(fd); }

int renameat(int from_dir, const char* from, int to_dir, const char* to) {
  const auto move = [&] {
    return static_cast<int>(syscall(SYS_renameat2, from_dir, from, to_dir, to, 0));
  };
  const std::string whole = Absolute(to_dir, to);
  if (!Counts(whole)) return move();
  return Point("rename " + Absolute(from_dir, from) + " " + whole, move);
}
int rename(const char* from, const char* to) { return renameat(AT_FDCWD, from, AT_FDCWD, to); }

int linkat(int from_dir, const char* from, int to_dir, const char* to, int flags) {
  const auto make = [&] {
    return static_cast<int>(syscall(SYS_linkat, from_dir, from, to_dir, to, flags));
  };
  const std::string whole = Absolute(to_dir, to);
  return Counts(whole) ? Point("link " + whole, make) : make();
}
int link(const char* from, const char* to) { return linkat(AT_FDCWD, from, AT_FDCWD, to, 0); }

int unlinkat(int dir, const char* path, int flags) {
  const auto remove = [&] { return static_cast<int>(syscall(SYS_unlinkat, dir, path, flags)); };
  const std::string whole = Absolute(dir, path);
  return Counts(whole) ? Point("remove " + whole, remove) : remove();
}
int unlink(const char* path) { return unlinkat(AT_FDCWD, path, 0); }
int rmdir(const char* path) { return unlinkat(AT_FDCWD, path, AT_REMOVEDIR); }
int remove(const char* path) {
  const int result = unlinkat(AT_FDCWD, path, 0);
  return result != 0 && (errno == EISDIR || errno == EPERM) ? unlinkat(AT_FDCWD, path, AT_REMOVEDIR)
                                                            : result;
}

int mkdirat(int dir, const char* path, mode_t mode) {
  const auto make = [&] { return static_cast<int>(syscall(SYS_mkdirat, dir, path, mode)); };
  const std::string whole = Absolute(dir, path);
  return Counts(whole) ? Point("mkdir " + whole, make) : make();
}
int mkdir(const char* path, mode_t mode) { return mkdirat(AT_FDCWD, path, mode); }

}  // extern "C"
