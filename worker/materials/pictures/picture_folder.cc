#include "worker/materials/pictures/picture_folder.h"

#include <sys/stat.h>

#include <algorithm>
#include <atomic>
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

std::atomic<bool> follows_links{false};

bool IsInside(const fs::path& file, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first ==
         folder.end();
}

// Walks a folder with the links in it.
class ContentWalk {
 public:
  ContentWalk(const std::string& dir, std::span<const std::string_view> endings)
      : dir_(dir), endings_(endings) {}

  absl::StatusOr<ContentNames> Walk() {
    std::error_code error;
    if (!fs::is_directory(dir_, error)) return std::move(found_);
    RETURN_IF_ERROR(WalkBelow(""));
    std::sort(found_.files.begin(), found_.files.end());
    std::sort(found_.left_out.begin(), found_.left_out.end());
    return std::move(found_);
  }

 private:
  // `below`: relative to the folder, "" or with a "/" at its end.
  absl::Status WalkBelow(const std::string& below) {
    std::error_code error;
    open_.push_back(fs::canonical(dir_ + "/" + below, error));
    fs::directory_iterator at;
    if (!error) at = fs::directory_iterator(dir_ + "/" + below, error);
    for (const fs::directory_iterator end; !error && at != end; at.increment(error)) {
      RETURN_IF_ERROR(Visit(*at, below + at->path().filename().string()));
    }
    if (error) return ErrnoError(error.value(), "walk " + dir_ + "/" + below);
    open_.pop_back();
    return absl::OkStatus();
  }

  absl::Status Visit(const fs::directory_entry& entry, const std::string& name) {
    std::error_code error;
    const bool is_folder = entry.is_directory(error);
    const bool is_foreign = IsForeignName(entry.path().filename().string());
    if (is_foreign || (!is_folder && !EndsIn(name, endings_))) {
      found_.left_out.push_back(name + (is_folder ? "/" : ""));
      return absl::OkStatus();
    }
    if (entry.is_symlink(error)) RETURN_IF_ERROR(CheckLink(name));
    if (is_folder) return WalkBelow(name + "/");
    if (entry.is_regular_file(error)) found_.files.push_back(name);
    return absl::OkStatus();
  }

  absl::Status CheckLink(const std::string& name) const {
    const std::string link = dir_ + "/" + name;
    std::error_code error;
    const fs::path target = fs::canonical(link, error);
    if (error) {
      return InvalidArgument("{}: a link to {}, which is not there", link,
                             fs::read_symlink(link, error).string());
    }
    if (std::find(open_.begin(), open_.end(), target) != open_.end()) {
      return InvalidArgument("{}: a link to {}, in which it lies", link, target.string());
    }
    if (FollowsLinks() || IsInside(target, open_.front())) return absl::OkStatus();
    return InvalidArgument("{}: a link to {}, outside of the folder; --follow-links allows it",
                           link, target.string());
  }

  const std::string& dir_;
  const std::span<const std::string_view> endings_;
  std::vector<fs::path> open_;  // Canonical; the folder itself first.
  ContentNames found_;
};

}  // namespace

bool IsForeignName(const std::string& name) {
  return name.starts_with('.') || name == "__MACOSX" || name == "@eaDir";
}

void SetFollowLinks(bool follows) { follows_links = follows; }
bool FollowsLinks() { return follows_links; }

absl::StatusOr<ContentNames> NamesOfContent(const std::string& dir,
                                            std::span<const std::string_view> endings) {
  return ContentWalk(dir, endings).Walk();
}

absl::StatusOr<std::vector<FolderFile>> ReadContentFolder(
    const std::string& dir, std::span<const std::string_view> endings) {
  ASSIGN_OR_RETURN(const ContentNames names, NamesOfContent(dir, endings));
  if (names.files.empty()) {
    std::string wanted;
    for (const std::string_view ending : endings) {
      wanted += (wanted.empty() ? "" : ", ") + std::string(ending);
    }
    return NotFound("no file of {} in {}", wanted, dir);
  }
  std::vector<FolderFile> files;
  for (const std::string& name : names.files) {
    ASSIGN_OR_RETURN(std::string sha256, HashOf(dir + "/" + name));
    files.push_back({name, std::move(sha256)});
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
