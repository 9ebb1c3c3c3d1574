#include "coordinator/rpc/workers/output_check.h"

#include <fmt/core.h>

#include <map>

namespace parallax {
namespace {

// "ab/ab12.../.attempt-7" of "ab/ab12.../.attempt-7/003/left.png"; empty without.
std::string AttemptFolderOf(const std::string& path) {
  const size_t at = path.find("/.attempt-");
  const size_t end = at == std::string::npos ? at : path.find('/', at + 1);
  return end == std::string::npos ? "" : path.substr(0, end);
}

}  // namespace

absl::StatusOr<std::string> WhyNotInStore(const Store& store,
                                          const std::vector<JobKind::OutputFile>& files) {
  std::map<std::string, std::map<std::string, int64_t>> folders;  // Sizes by path, by folder.
  for (const JobKind::OutputFile& file : files) {
    const std::string folder = AttemptFolderOf(file.path);
    if (folder.empty() || !CheckStorePath(folder).ok()) continue;
    const auto [sizes, is_new] = folders.try_emplace(folder);
    if (is_new) {
      ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store.List(folder));
      for (const StoreEntry& entry : entries) sizes->second[entry.path] = entry.size;
    }
    const auto found = sizes->second.find(file.path);
    if (found == sizes->second.end()) return file.path + ": is not in the store";
    if (found->second != file.size) {
      return fmt::format("{}: has {} bytes, not {}", file.path, found->second, file.size);
    }
  }
  return std::string();
}

}  // namespace parallax
