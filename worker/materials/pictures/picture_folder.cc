#include "worker/materials/pictures/picture_folder.h"

#include <sys/stat.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <filesystem>
#include <map>
#include <mutex>

#include "common/base/hash.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPictures[] = {".png", ".jpg", ".jpeg"};

bool EndsIn(const fs::path& path, std::span<const std::string_view> endings) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

// The facts that change when a file is written again.
struct FileStamp {
  dev_t device = 0;
  ino_t inode = 0;
  off_t size = 0;
  int64_t modified_ns = 0, changed_ns = 0;
  bool operator==(const FileStamp&) const = default;
};

absl::StatusOr<FileStamp> StampOf(const std::string& path) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0) return ErrnoError(errno, "picture " + path);
  const auto nanoseconds = [](const timespec& t) {
    return int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec;
  };
  return FileStamp{info.st_dev, info.st_ino, info.st_size, nanoseconds(info.st_mtim),
                   nanoseconds(info.st_ctim)};
}

// Sha256HexOfFile, remembered by stamp.
absl::StatusOr<std::string> HashOf(const std::string& path) {
  static std::mutex mutex;
  static auto& known = *new std::map<std::string, std::pair<FileStamp, std::string>>;
  ASSIGN_OR_RETURN(const FileStamp stamp, StampOf(path));
  {
    std::lock_guard<std::mutex> lock(mutex);
    const auto found = known.find(path);
    if (found != known.end() && found->second.first == stamp) return found->second.second;
  }
  ASSIGN_OR_RETURN(std::string hash, Sha256HexOfFile(path));
  std::lock_guard<std::mutex> lock(mutex);
  known[path] = {stamp, hash};
  return hash;
}

// Returns the files below `dir` with these endings, in no order and without hashes. A `dir` that is
// no folder has none.
absl::StatusOr<std::vector<FolderFile>> NamesBelow(const std::string& dir,
                                                   std::span<const std::string_view> endings) {
  std::vector<FolderFile> files;
  std::error_code error, of_file;
  if (!fs::is_directory(dir, of_file)) return files;
  fs::recursive_directory_iterator at(dir, error);
  for (const fs::recursive_directory_iterator end; !error && at != end; at.increment(error)) {
    if (!at->is_regular_file(of_file) || !EndsIn(at->path(), endings)) continue;
    files.push_back({at->path().lexically_relative(dir).string(), ""});
  }
  if (error) return ErrnoError(error.value(), "walk " + dir);
  return files;
}

}  // namespace

absl::StatusOr<std::vector<FolderFile>> ReadContentFolder(
    const std::string& dir, std::span<const std::string_view> endings) {
  ASSIGN_OR_RETURN(std::vector<FolderFile> files, NamesBelow(dir, endings));
  if (files.empty()) {
    std::string wanted;
    for (const std::string_view ending : endings) {
      wanted += (wanted.empty() ? "" : ", ") + std::string(ending);
    }
    return NotFound("no file of {} in {}", wanted, dir);
  }
  std::sort(files.begin(), files.end(),
            [](const FolderFile& a, const FolderFile& b) { return a.name < b.name; });
  for (FolderFile& file : files) {
    ASSIGN_OR_RETURN(file.sha256, HashOf(dir + "/" + file.name));
  }
  return files;
}

absl::StatusOr<std::vector<FolderFile>> ReadPictureFolder(const std::string& dir) {
  absl::StatusOr<std::vector<FolderFile>> pictures = ReadContentFolder(dir, kPictures);
  if (absl::IsNotFound(pictures.status())) {
    return NotFound("picture_dir: no PNG or JPEG in {}", dir);
  }
  return pictures;
}

uint64_t ContentSeed(std::string_view sha256) {
  return std::stoull(std::string(sha256.substr(0, 16)), nullptr, 16);
}

std::string ContentHashOf(const std::vector<FolderFile>& pictures) {
  Sha256 hash;
  for (const FolderFile& picture : pictures) {
    // A name holds no 0 byte and a hash has one length: no two lists give the same bytes.
    hash.Update(picture.name).Update(std::string_view("\0", 1)).Update(picture.sha256);
  }
  return HexOf(hash.Finish());
}

absl::StatusOr<std::string> FindPicture(const std::string& dir, const std::string& name,
                                        const std::string& sha256) {
  const fs::path relative(name);
  if (relative.is_absolute() ||
      std::find(relative.begin(), relative.end(), "..") != relative.end()) {
    return InvalidArgument("picture {}: allowed is a name in the folder of pictures", name);
  }
  const std::string path = (fs::path(dir) / relative).string();
  ASSIGN_OR_RETURN(const std::string hash, HashOf(path));
  if (hash != sha256) {
    return DataLoss("picture {} is not the one that the scene was made with", path);
  }
  return path;
}

}  // namespace parallax
