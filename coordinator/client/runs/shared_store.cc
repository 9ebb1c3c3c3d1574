#include "coordinator/client/runs/shared_store.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include "common/base/system/file.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

constexpr char kNote[] = "/shared_store";  // Holds the path of the folder that is shared.

std::string HolderOf(int descriptor) {
  char text[64] = {};
  const ssize_t size = pread(descriptor, text, sizeof text - 1, 0);
  return size > 0 ? FirstLine(text) : "unknown";
}

std::string Variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string UsualPlace() {
  const std::string cache = Variable("XDG_CACHE_HOME"), home = Variable("HOME");
  if (cache.starts_with('/')) return cache + "/parallax/store";
  return home.empty() ? "" : home + "/.cache/parallax/store";
}

}  // namespace

absl::StatusOr<FolderLock> FolderLock::Take(const std::string& dir, const std::string& shown,
                                            const std::string& hint) {
  const std::string path = dir + "/lock";
  FolderLock lock(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (lock.descriptor_ < 0) return ErrnoError(errno, "can't open " + path);
  if (flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return ErrnoError(errno, "can't lock " + path);
    return FailedPrecondition(
        "{} is in use by another parallax (process {}); wait for it to end, {}", shown,
        HolderOf(lock.descriptor_), hint);
  }
  const std::string self = fmt::format("{}\n", getpid());
  if (ftruncate(lock.descriptor_, 0) != 0 ||
      pwrite(lock.descriptor_, self.data(), self.size(), 0) != static_cast<ssize_t>(self.size())) {
    return ErrnoError(errno, "can't write " + path);
  }
  return lock;
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

std::string UsersStore() {
  const std::string named = Variable("PARALLAX_STORE");
  if (!named.empty()) return named;
  std::error_code error;
  const std::string usual = UsualPlace();
  return fs::is_directory(usual, error) ? usual : "";
}

std::string StoreOf(const std::string& work_dir) {
  const std::string shared = ReadFile(work_dir + kNote, 4096).value_or("");
  return shared.empty() ? work_dir : shared;
}

absl::StatusOr<std::string> ChooseStore(const std::string& given, const std::string& work_dir) {
  std::error_code error;
  std::string store = given.empty() ? StoreOf(work_dir) : given;
  if (store == work_dir && !fs::exists(work_dir + "/queue.db", error)) store = UsersStore();
  if (store.empty() || store == work_dir) return work_dir;
  store = fs::absolute(store, error).lexically_normal();
  while (store.size() > 1 && store.back() == '/') store.pop_back();
  if (store == work_dir) return work_dir;
  fs::create_directories(store, error);
  if (error) return ErrnoError(error.value(), "can't make the folder of --store, " + store);
  RETURN_IF_ERROR(WriteFileAtomically(work_dir + kNote, store));
  return store;
}

std::string DescribeUsersStore() {
  const std::string store = UsersStore();
  if (!store.empty()) {
    return store + ", which your datasets share (its pairs stay when a dataset is removed)";
  }
  return "in the dataset's own folder; --store DIR, $PARALLAX_STORE or a folder " + UsualPlace() +
         " lets datasets share pairs";
}

}  // namespace parallax::client
