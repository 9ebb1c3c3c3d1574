#include "coordinator/rpc/workers/output_check.h"

#include <fmt/core.h>

#include <map>

#include "common/base/hash.h"

namespace parallax {
namespace {

constexpr int64_t kMostSampledBytes = int64_t{64} << 20;

// "ab/ab12.../.attempt-7" of "ab/ab12.../.attempt-7/003/left.png"; empty without.
std::string AttemptFolderOf(const std::string& path) {
  const size_t at = path.find("/.attempt-");
  const size_t end = at == std::string::npos ? at : path.find('/', at + 1);
  return end == std::string::npos ? "" : path.substr(0, end);
}

}  // namespace

absl::StatusOr<std::string> WhyNotInStore(const Store& store,
                                          const std::vector<JobKind::OutputFile>& files) {
  return WhyNotListed([&store](const std::string& folder) { return store.List(folder); }, files);
}

absl::StatusOr<std::string> WhyNotListed(const FolderLister& list,
                                         const std::vector<JobKind::OutputFile>& files) {
  std::map<std::string, std::map<std::string, int64_t>> folders;  // Sizes by path, by folder.
  for (const JobKind::OutputFile& file : files) {
    const std::string folder = AttemptFolderOf(file.path);
    if (folder.empty() || !CheckStorePath(folder).ok()) continue;
    const auto [sizes, is_new] = folders.try_emplace(folder);
    if (is_new) {
      ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, list(folder));
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

absl::StatusOr<std::string> WhyNotAsHashed(const Store& store,
                                           const std::vector<JobKind::OutputFile>& files,
                                           uint64_t draw) {
  std::vector<const JobKind::OutputFile*> small;
  for (const JobKind::OutputFile& file : files) {
    if (file.size <= kMostSampledBytes) small.push_back(&file);
  }
  if (small.empty()) return std::string();
  const JobKind::OutputFile& file = *small[draw % small.size()];
  ASSIGN_OR_RETURN(const std::string bytes, store.Get(file.path));
  if (Sha256Hex(bytes) == file.sha256) return std::string();
  return file.path + ": its content has another SHA-256 than its worker says";
}

}  // namespace parallax
