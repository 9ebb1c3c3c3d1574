#include "coordinator/rpc/janitor.h"

#include "common/base/log.h"

namespace parallax {
namespace {

constexpr int kPathsAtOnce = 200;

}  // namespace

Janitor::Janitor(JobQueue& queue, Store& store, const JanitorOptions& options)
    : queue_(queue), store_(store), options_(options) {
  if (options_.every_s > 0) thread_ = std::thread([this] { Loop(); });
}

Janitor::~Janitor() {
  {
    const std::lock_guard lock(mu_);
    stopping_ = true;
  }
  stop_.notify_all();
  if (thread_.joinable()) thread_.join();
}

absl::StatusOr<int> Janitor::Sweep() const {
  int removed = 0;
  while (true) {
    ASSIGN_OR_RETURN(const std::vector<std::string> paths,
                     queue_.ListLitter(options_.leases * options_.lease_s, kPathsAtOnce));
    std::vector<std::string> gone;
    for (const std::string& path : paths) {
      {
        const std::lock_guard lock(mu_);
        if (stopping_) break;
      }
      absl::Status status = store_.RemoveTree(path);
      if (status.ok()) status = RemoveEmptyAttempt(path);
      if (status.ok() || absl::IsNotFound(status)) {
        gone.push_back(path);
      } else {
        LogWarning("litter can't be removed", {{"path", path}, {"error", status}});
      }
    }
    if (!gone.empty()) RETURN_IF_ERROR(queue_.ForgetLitter(gone));
    removed += static_cast<int>(gone.size());
    if (gone.size() < kPathsAtOnce) return removed;
  }
}

// The folder of the attempt above a frame's, once its last frame is gone. An attempt that is over
// writes nothing more, and no other one ever writes there.
absl::Status Janitor::RemoveEmptyAttempt(const std::string& path) const {
  const std::string above = path.substr(0, path.rfind('/'));
  if (above.find("/.attempt-") == std::string::npos) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<StoreEntry> left, store_.List(above));
  return left.empty() ? store_.RemoveTree(above) : absl::OkStatus();
}

void Janitor::Loop() {
  std::unique_lock lock(mu_);
  while (!stopping_) {
    lock.unlock();
    const absl::StatusOr<int> removed = Sweep();
    if (!removed.ok()) {
      LogWarning("litter is not removed", {{"error", removed.status()}});
    } else if (*removed > 0) {
      LogInfo("litter removed from the store", {{"folders", *removed}});
    }
    lock.lock();
    stop_.wait_for(lock, std::chrono::duration<double>(options_.every_s),
                   [this] { return stopping_; });
  }
}

}  // namespace parallax
