#include "coordinator/client/preview/watch_loop.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <future>

namespace parallax::client {
namespace {

namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kBusyLook(50), kIdleLook(150);
constexpr int kMostEntries = 20'000;  // The most entries of a folder that are watched.

size_t Mix(size_t a, size_t b) { return (a ^ b) * 0x9e3779b97f4a7c15u; }

size_t StampOfEntry(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return 0;
  if (S_ISDIR(info.st_mode)) return 1;  // The stamps of its entries show changes.
  size_t stamp = Mix(1, static_cast<size_t>(info.st_ino));
  stamp = Mix(stamp, static_cast<size_t>(info.st_mtim.tv_sec));
  stamp = Mix(stamp, static_cast<size_t>(info.st_mtim.tv_nsec));
  return Mix(stamp, static_cast<size_t>(info.st_size));
}

}  // namespace

size_t WatchedFiles::StampOf(const std::string& path) const {
  size_t stamp = StampOfEntry(path);
  std::error_code error;
  if (!fs::is_directory(path, error)) return stamp;
  int entries = 0;
  fs::recursive_directory_iterator entry(path, error), end;
  for (; !error && entry != end && entries < kMostEntries; entry.increment(error), ++entries) {
    const std::string& name = entry->path().native();
    if (std::find(ignored_.begin(), ignored_.end(), name) != ignored_.end()) continue;
    // A sum: the order of entries does not matter.
    stamp += Mix(std::hash<std::string>()(name), StampOfEntry(name));
  }
  return stamp;
}

void WatchedFiles::Watch(const std::vector<std::string>& paths) {
  const std::lock_guard lock(mutex_);
  Stamps now;
  for (const std::string& path : paths) {
    const auto known = told_.find(path);
    now[path] = known == told_.end() ? StampOf(path) : known->second;
  }
  told_ = std::move(now);
  seen_ = told_;
}

bool WatchedFiles::Changed() {
  const std::lock_guard lock(mutex_);
  Stamps now;
  for (const auto& [path, stamp] : told_) now[path] = StampOf(path);
  const bool still = now == seen_;
  seen_ = std::move(now);
  if (!still || seen_ == told_) return false;
  told_ = seen_;
  return true;
}

size_t WatchedFiles::size() const {
  const std::lock_guard lock(mutex_);
  return told_.size();
}

bool RunWatchLoop(const WatchLoop& loop, WatchedFiles& files) {
  while (true) {
    const CancelToken cancel;
    const auto work = std::async(std::launch::async, [&] { loop.work(cancel); });
    bool ended = false, changed = false;
    while (work.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
      if (loop.busy) loop.busy();
      ended = loop.wait(kBusyLook) || ended;
      changed = changed || (loop.again && files.Changed());
      if (ended || changed) cancel.Cancel();
    }
    while (loop.again && !ended && !changed) {
      ended = loop.wait(kIdleLook);
      changed = files.Changed();
    }
    if (ended || !loop.again) return ended;
  }
}

}  // namespace parallax::client
