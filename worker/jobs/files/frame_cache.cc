#include "worker/jobs/files/frame_cache.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

// The file "<name>~<hash>" of an earlier fetch, if its content still has that hash.
std::string KeptFile(const std::string& dir, const std::string& name, int64_t size) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(dir, error)) {
    const std::string file = entry.path().filename();
    if (file.rfind(name + "~", 0) != 0) continue;
    const absl::StatusOr<std::string> hash = Sha256HexOfFile(entry.path());
    const bool intact = hash.ok() && file == name + "~" + *hash &&
                        static_cast<int64_t>(entry.file_size(error)) == size;
    if (intact) return entry.path();
    fs::remove(entry.path(), error);
  }
  return "";
}

}  // namespace

absl::StatusOr<LocalFile> FrameCache::FetchFile(const Store& store, const std::string& path,
                                                int64_t size, const std::string& dir,
                                                const std::string& name) const {
  const std::string kept = KeptFile(dir, name, size);
  if (!kept.empty()) return LocalFile{kept, size, kept.substr(kept.rfind('~') + 1)};
  ASSIGN_OR_RETURN(const std::string bytes, GetWhole(store, path, size));
  LocalFile file{"", size, Sha256Hex(bytes)};
  file.path = dir + "/" + name + "~" + file.sha256;
  RETURN_IF_ERROR(WriteFileAtomically(file.path, bytes));
  return file;
}

absl::StatusOr<std::map<std::string, LocalFile>> FrameCache::Fetch(
    const Store& store, const std::string& path, const std::vector<std::string>& names) const {
  RETURN_IF_ERROR(CheckStorePath(path));
  const std::string dir = options_.dir + "/" + path;
  RETURN_IF_ERROR(MakeFolders(dir));
  ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store.List(path));
  std::map<std::string, LocalFile> files;
  for (const StoreEntry& entry : entries) {
    const std::string name = fs::path(entry.path).filename();
    if (std::find(names.begin(), names.end(), name) == names.end()) continue;
    ASSIGN_OR_RETURN(files[name], FetchFile(store, entry.path, entry.size, dir, name));
  }
  if (files.empty()) {
    return NotFound("the store has no frame {}", path);
  }
  std::error_code error;
  fs::last_write_time(dir, fs::file_time_type::clock::now(), error);
  return files;
}

void FrameCache::Trim() const {
  struct Frame {
    fs::file_time_type used;
    std::string dir;
    int64_t bytes = 0;
  };
  std::map<std::string, Frame> frames;
  int64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(options_.dir, error), end; it != end;
       it.increment(error)) {
    if (error) break;
    if (!it->is_regular_file(error)) continue;
    const std::string dir = it->path().parent_path();
    Frame& frame = frames[dir];
    frame.dir = dir;
    frame.used = fs::last_write_time(dir, error);
    frame.bytes += static_cast<int64_t>(it->file_size(error));
    bytes += static_cast<int64_t>(it->file_size(error));
  }
  std::vector<Frame> oldest;
  for (auto& [dir, frame] : frames) oldest.push_back(std::move(frame));
  std::sort(oldest.begin(), oldest.end(),
            [](const Frame& a, const Frame& b) { return a.used < b.used; });
  for (const Frame& frame : oldest) {
    if (bytes <= options_.max_bytes) return;
    fs::remove_all(frame.dir, error);
    bytes -= frame.bytes;
  }
}

absl::StatusOr<std::map<std::string, LocalFile>> FilesOfFrame(
    const std::string& dir, const std::vector<std::string>& names) {
  std::map<std::string, LocalFile> files;
  std::error_code error;
  for (const std::string& name : names) {
    const std::string path = dir + "/" + name;
    if (!fs::exists(path, error)) continue;
    ASSIGN_OR_RETURN(const std::string hash, Sha256HexOfFile(path));
    files[name] = {path, static_cast<int64_t>(fs::file_size(path, error)), hash};
  }
  if (files.empty()) {
    return NotFound("the store has no frame {}", dir);
  }
  return files;
}

}  // namespace parallax
