#include "worker/jobs/files/kept_files.h"

#include <filesystem>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/store/store.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace fs = std::filesystem;

absl::StatusOr<std::string> KeptFiles::Keep(const std::string& from, const std::string& name) {
  const std::string to = folder_.dir + "/" + name;
  RETURN_IF_ERROR(MakeFolders(folder_.dir));
  std::error_code error;
  fs::copy_file(from, to, fs::copy_options::overwrite_existing, error);
  if (error) return ErrnoError(error.value(), "keep " + to);
  RETURN_IF_ERROR(SyncPath(to));
  RETURN_IF_ERROR(SyncPath(folder_.dir));
  ASSIGN_OR_RETURN(std::string hash, Sha256HexOfFile(to));
  RETURN_IF_ERROR(Note(name, hash));
  return hash;
}

absl::Status KeptFiles::KeepText(const std::string& text, const std::string& name) {
  RETURN_IF_ERROR(MakeFolders(folder_.dir));
  RETURN_IF_ERROR(WriteFileAtomically(folder_.dir + "/" + name, text));
  return Note(name, Sha256Hex(text));
}

absl::Status KeptFiles::Note(const std::string& name, const std::string& sha256) {
  std::error_code error;
  const uintmax_t size = fs::file_size(folder_.dir + "/" + name, error);
  if (error) return ErrnoError(error.value(), "keep " + name);
  v1::FileEntry& entry = *entries_.Add();
  entry.set_name(name);
  entry.set_size(static_cast<int64_t>(size));
  entry.set_sha256(sha256);
  return absl::OkStatus();
}

std::vector<OutputFile> KeptFiles::outputs() const {
  std::vector<OutputFile> files;
  for (const v1::FileEntry& entry : entries_) {
    files.push_back({entry.name(), entry.size(), entry.sha256()});
  }
  return files;
}

}  // namespace parallax
