#include "coordinator/rpc/janitor.h"

#include <filesystem>

#include "common/base/system/log.h"
#include "common/store/content.h"
#include "coordinator/rpc/storage/unknown_folders.h"

namespace parallax {
namespace {

constexpr int kPathsAtOnce = 200;
constexpr char kActor[] = "coordinator";  // In the audit.

}  // namespace

Janitor::Janitor(JobQueue& queue, Store& store, ContentKeeper* content,
                 const JanitorOptions& options)
    : queue_(queue), store_(store), content_(content), options_(options) {
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
  RETURN_IF_ERROR(store_.CheckMarker());  // On a disk that is gone there is nothing to remove.
  int removed = 0;
  while (true) {
    ASSIGN_OR_RETURN(const std::vector<std::string> paths,
                     queue_.ListLitter(options_.leases * options_.lease_s, kPathsAtOnce));
    std::vector<std::string> gone;
    for (const std::string& path : paths) {
      if (IsStopping()) break;
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

absl::StatusOr<int> Janitor::SweepContent() const {
  if (content_ == nullptr) return 0;
  ASSIGN_OR_RETURN(const std::vector<std::string> folders, queue_.ListContentFolders());
  std::vector<std::string> lists;
  for (const std::string& folder : folders) {
    const std::optional<ContentReference> reference = FindContentReference(folder);
    if (reference) lists.push_back(reference->sha256);
  }
  return content_->Sweep(lists);
}

absl::StatusOr<int> Janitor::SweepUnknown() const {
  if (options_.unknown_s <= 0) return 0;
  return RemoveUnknownFolders(queue_, store_, options_.unknown_s, Clock::System().UnixSeconds(),
                              [this] { return IsStopping(); });
}

absl::StatusOr<int> Janitor::Retain() {
  RETURN_IF_ERROR(use_.Follow(queue_));
  {
    const std::lock_guard lock(mu_);
    space_.results_bytes = use_.Bytes();
  }
  RETURN_IF_ERROR(store_.CheckMarker());
  int forgotten = 0;
  for (const ForgetDue& due : use_.Due(options_.keep, options_.clock->UnixSeconds())) {
    if (IsStopping()) break;
    const auto had = queue_.Forget(due.study, due.reason, kActor);
    // Somebody else has forgotten it, or a repair made it unfinished.
    if (absl::IsNotFound(had.status()) || absl::IsFailedPrecondition(had.status())) continue;
    RETURN_IF_ERROR(had.status());
    LogInfo("study forgotten", {{"study", due.study.value}, {"reason", due.reason}});
    ++forgotten;
  }
  return forgotten;
}

FarmSpace Janitor::space() const {
  const std::lock_guard lock(mu_);
  return space_;
}

// A shared disk may hang, so that nobody but this thread asks it.
void Janitor::MeasureDisks() {
  std::vector<std::pair<std::string, DiskSpace>> disks;
  const auto add = [&](const char* name, const std::filesystem::path& file) {
    const auto space = SpaceOfDisk(file.parent_path().string());
    if (space.ok()) disks.emplace_back(name, *space);
  };
  if (const auto file = store_.LocalPath("file"); file.ok()) add("store", *file);
  if (!options_.database.empty()) add("database", std::filesystem::absolute(options_.database));
  const std::lock_guard lock(mu_);
  space_.disks = std::move(disks);
}

bool Janitor::IsStopping() const {
  const std::lock_guard lock(mu_);
  return stopping_;
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
  const auto log = [](const absl::StatusOr<int>& removed, std::string_view what) {
    if (!removed.ok()) {
      LogWarning("nothing is removed from the store", {{"of", what}, {"error", removed.status()}});
    } else if (*removed > 0) {
      LogInfo("removed from the store", {{"of", what}, {"paths", *removed}});
    }
  };
  std::unique_lock lock(mu_);
  for (int sweep = 0; !stopping_; ++sweep) {
    lock.unlock();
    log(Sweep(), "litter");
    MeasureDisks();
    if (sweep % options_.content_every == 0) log(SweepContent(), "users' content");
    if (sweep % options_.unknown_every == 0) use_.Restart();
    if (const auto forgotten = Retain(); !forgotten.ok()) {
      LogWarning("no study is forgotten", {{"error", forgotten.status()}});
    }
    if (sweep % options_.unknown_every == 0) log(SweepUnknown(), "folders of no attempt");
    lock.lock();
    stop_.wait_for(lock, std::chrono::duration<double>(options_.every_s),
                   [this] { return stopping_; });
  }
}

}  // namespace parallax
