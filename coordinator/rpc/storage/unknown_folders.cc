#include "coordinator/rpc/storage/unknown_folders.h"

#include <fmt/core.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

namespace parallax {
namespace {

constexpr int kPrefixes = 256;  // Results lie below two hex digits.

// The time of the newest file in each attempt's folder below a prefix; 0 if one is not known.
absl::StatusOr<std::map<std::string, double>> AttemptsBelow(const Store& store,
                                                            const std::string& prefix) {
  ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store.List(prefix));
  std::map<std::string, double> newest;
  for (const StoreEntry& entry : entries) {
    const size_t at = entry.path.find("/.attempt-");
    const size_t end = at == std::string::npos ? at : entry.path.find('/', at + 1);
    if (end == std::string::npos) continue;
    const auto [known, is_new] =
        newest.try_emplace(entry.path.substr(0, end), entry.modified_unix_s);
    if (is_new || known->second == 0) continue;
    known->second = entry.modified_unix_s == 0 ? 0 : std::max(known->second, entry.modified_unix_s);
  }
  return newest;
}

}  // namespace

absl::StatusOr<int> RemoveUnknownFolders(JobQueue& queue, Store& store, double older_than_s,
                                         double now_unix_s, const std::function<bool()>& stopping) {
  RETURN_IF_ERROR(store.CheckMarker());
  ASSIGN_OR_RETURN(const std::string owner, store.Owner());
  if (owner != queue.database_id()) return 0;
  std::vector<std::string> old;
  for (int prefix = 0; prefix < kPrefixes && !stopping(); ++prefix) {
    ASSIGN_OR_RETURN(const auto attempts, AttemptsBelow(store, fmt::format("{:02x}", prefix)));
    for (const auto& [folder, newest] : attempts) {
      if (newest > 0 && now_unix_s - newest >= older_than_s) old.push_back(folder);
    }
  }
  if (old.empty()) return 0;
  // Asked after the listing: what was published meanwhile is known.
  ASSIGN_OR_RETURN(const std::set<std::string> known, queue.ListAttemptFolders());
  int removed = 0;
  for (const std::string& folder : old) {
    if (stopping()) break;
    if (known.count(folder) > 0) continue;
    RETURN_IF_ERROR(store.RemoveTree(folder));
    ++removed;
  }
  return removed;
}

}  // namespace parallax
