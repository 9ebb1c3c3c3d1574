// Does work again whenever the files change that it depends on.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "common/base/cancel.h"

namespace parallax::client {

// Looks whether files, and folders with all that is in them, change: whether they are there, and
// the size, inode and time of files. Thread-safe.
class WatchedFiles {
 public:
  // Changes of `ignored`, such as what the work writes itself, don't count.
  explicit WatchedFiles(std::vector<std::string> ignored = {}) : ignored_(std::move(ignored)) {}

  // Watches these paths from now on; for those that were watched already, the changes that nobody
  // has asked for yet still count.
  void Watch(const std::vector<std::string>& paths);
  // Returns whether something has changed since the last change that it told, and has since kept
  // still from one call to the next: half a save is none.
  bool Changed();
  size_t size() const;

 private:
  // What a path had; 0: it was not there.
  using Stamps = std::map<std::string, size_t>;
  size_t StampOf(const std::string& path) const;

  const std::vector<std::string> ignored_;
  mutable std::mutex mutex_;
  Stamps told_, seen_;  // Guarded by mutex_.
};

struct WatchLoop {
  // Does the work once, on a thread of its own. It may give `files` other paths to watch.
  std::function<void(const CancelToken& cancel)> work;
  // Waits so long. Returns true if the user wants the end.
  std::function<bool(std::chrono::milliseconds time)> wait;
  // Called now and then while the work is done. May be null.
  std::function<void()> busy;
  bool again = false;  // Whether to do the work again after changes, else once.
};

// Runs the loop. Work whose files change meanwhile is cancelled and begins anew. Returns true if
// the user ended it, whose work is then cancelled; false when work that is done once is done.
bool RunWatchLoop(const WatchLoop& loop, WatchedFiles& files);

}  // namespace parallax::client
