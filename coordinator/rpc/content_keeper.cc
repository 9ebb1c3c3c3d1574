#include "coordinator/rpc/content_keeper.h"

#include <chrono>
#include <set>

#include "common/base/log.h"
#include "common/store/content.h"
#include "common/store/store.h"

namespace parallax {

void ContentKeeper::Note(const std::string& sha256) {
  const std::lock_guard lock(mu_);
  unused_since_.erase(sha256);
}

absl::Status ContentKeeper::TakeRoom(int64_t bytes) {
  const std::lock_guard lock(mu_);
  if (bytes_ < 0) {
    ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_.List(kContentFolder));
    bytes_ = 0;
    for (const StoreEntry& entry : entries) bytes_ += entry.size;
  }
  if (bytes_ + bytes > options_.most_bytes) {
    return ResourceExhausted(
        "users' content in the store has {} bytes, {} more are wanted, and {} are allowed; content "
        "goes a day after the last study that names it is forgotten (`parallax forget STUDY`)",
        bytes_, bytes, options_.most_bytes);
  }
  bytes_ += bytes;
  return absl::OkStatus();
}

void ContentKeeper::GiveRoomBack(int64_t bytes) {
  const std::lock_guard lock(mu_);
  if (bytes_ >= 0) bytes_ -= bytes;
}

absl::StatusOr<int> ContentKeeper::Sweep(const std::vector<std::string>& lists) {
  ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store_.List(kContentFolder));
  if (entries.empty()) return 0;
  std::set<std::string> used(lists.begin(), lists.end());
  for (const std::string& list : lists) {
    const absl::StatusOr<std::string> text = store_.Get(ContentPath(list));
    if (!text.ok() && !absl::IsNotFound(text.status())) return text.status();
    const auto files = text.ok() ? ParseContentList(*text)
                                 : absl::StatusOr<std::vector<ContentFile>>(text.status());
    if (!files.ok()) {
      LogWarning("a study names a list of content that can't be read; its files are not kept",
                 {{"list", list}, {"error", files.status()}});
      continue;
    }
    for (const ContentFile& file : *files) used.insert(file.sha256);
  }
  const SteadyTime now = options_.clock->Steady();
  int removed = 0;
  for (const StoreEntry& entry : entries) {
    const std::string sha256 = entry.path.substr(entry.path.rfind('/') + 1);
    const std::lock_guard lock(mu_);
    if (used.count(sha256) > 0) {
      unused_since_.erase(sha256);
      continue;
    }
    // Who notes the file after this finds it gone, and puts it again.
    const SteadyTime since = unused_since_.try_emplace(sha256, now).first->second;
    if (std::chrono::duration<double>(now - since).count() < options_.keep_s) continue;
    RETURN_IF_ERROR(store_.RemoveTree(entry.path));
    unused_since_.erase(sha256);
    if (bytes_ >= 0) bytes_ -= entry.size;
    ++removed;
  }
  return removed;
}

}  // namespace parallax
