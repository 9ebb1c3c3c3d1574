#include "worker/jobs/files/content_cache.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/base/system/log.h"
#include "common/config/content_folders.h"
#include "common/store/store.h"
#include "worker/materials/pictures/picture_folder.h"
#include "worker/materials/pictures/user_picture.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;

constexpr size_t kContentPiece = 1 << 20;
constexpr std::chrono::hours kInUse{1};

// One fetch at a time in this process: two jobs may want the same.
std::timed_mutex& FetchMutex() {
  static auto* mutex = new std::timed_mutex;
  return *mutex;
}

absl::StatusOr<std::unique_lock<std::timed_mutex>> LockFetches(const FetchContext& context) {
  std::unique_lock<std::timed_mutex> lock(FetchMutex(), std::defer_lock);
  while (!lock.try_lock_for(std::chrono::milliseconds(100))) {
    if (context.cancel.cancelled()) return Cancelled("while content was waited for");
    context.progress();
  }
  return lock;
}

// Whether `dir` has all of the files, with their content. Hashes are remembered by the files'
// times.
bool HasAll(const std::string& dir, const std::vector<ContentFile>& files) {
  return std::all_of(files.begin(), files.end(), [&dir](const ContentFile& file) {
    return FindPicture(dir, file.name, file.sha256).ok();
  });
}

absl::Status MakeParents(const fs::path& file) {
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  return error ? ErrnoError(error.value(), "make " + file.parent_path().string())
               : absl::OkStatus();
}

// Piece by piece: a file may be large. What comes is hashed on its way.
absl::Status FetchContentFile(const Store& store, const ContentFile& file, const std::string& to,
                              const FetchContext& context) {
  RETURN_IF_ERROR(MakeParents(to));
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(std::fopen(to.c_str(), "wbxe"),
                                                            &std::fclose);
  if (out == nullptr) return ErrnoError(errno, "create " + to);
  const std::string from = ContentPath(file.sha256);
  Sha256 hash;
  int64_t size = 0;
  while (size <= file.size) {
    if (context.cancel.cancelled()) return Cancelled("while content was fetched");
    context.progress();
    ASSIGN_OR_RETURN(const std::string piece, store.GetPiece(from, size, kContentPiece));
    if (piece.empty()) break;
    hash.Update(piece);
    size += static_cast<int64_t>(piece.size());
    if (std::fwrite(piece.data(), 1, piece.size(), out.get()) != piece.size()) {
      return ErrnoError(errno, "write " + to);
    }
  }
  if (std::fflush(out.get()) != 0) return ErrnoError(errno, "write " + to);
  if (size == file.size && HexOf(hash.Finish()) == file.sha256) return absl::OkStatus();
  return DataLoss(
      "{}: what the store has is not the content of {} that the study was submitted with", from,
      file.name);
}

int64_t BytesOf(const std::vector<ContentFile>& files) {
  int64_t bytes = 0;
  for (const ContentFile& file : files) bytes += file.size;
  return bytes;
}

int64_t BytesBelow(const fs::path& dir) {
  int64_t bytes = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(dir, error), end; !error && it != end;
       it.increment(error)) {
    if (it->is_regular_file(error)) bytes += static_cast<int64_t>(it->file_size(error));
  }
  return bytes;
}

// The last part of a path: the class of meshes that lie in it.
std::string LastPart(const std::string& path) {
  const std::string name = fs::path(path).filename();
  return name.empty() || name.front() == '.' ? "content" : name;
}

absl::StatusOr<std::string> GetList(const Store& store, const std::string& path) {
  std::string text;
  while (text.size() <= kMostContentListBytes) {
    ASSIGN_OR_RETURN(const std::string piece,
                     store.GetPiece(path, static_cast<int64_t>(text.size()), kContentPiece));
    if (piece.empty()) return text;
    text += piece;
  }
  return InvalidArgument("{}: too long for a list of content", path);
}

std::string TemporaryName(const std::string& sha256) {
  static std::atomic<int> number{0};
  return fmt::format(".new-{}-{}-{}", sha256.substr(0, 16), getpid(), ++number);
}

}  // namespace

absl::StatusOr<std::vector<ContentFile>> ContentCache::ListOf(const Store& store,
                                                              const std::string& sha256,
                                                              const std::string& kept) const {
  absl::StatusOr<std::string> text = ReadFile(kept, kMostContentListBytes);
  if (text.ok() && Sha256Hex(*text) == sha256) return ParseContentList(*text);
  text = GetList(store, ContentPath(sha256));
  RETURN_IF_ERROR(text.status());
  if (Sha256Hex(*text) != sha256) {
    return DataLoss("{}: the store's list of content is not of this hash", ContentPath(sha256));
  }
  return ParseContentList(*text);
}

absl::Status ContentCache::MakeRoom(int64_t bytes, const std::string& keep) const {
  if (bytes > options_.max_bytes) {
    return ResourceExhausted(
        "own content of {} bytes, and this worker's cache {} may have {} (worker --cache-gb)",
        bytes, options_.dir, options_.max_bytes);
  }
  struct Kept {
    fs::file_time_type used;
    fs::path dir;
    int64_t bytes = 0;
  };
  std::vector<Kept> all;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(options_.dir, error)) {
    if (!entry.is_directory(error) || entry.path().filename() == keep) continue;
    all.push_back(
        {fs::last_write_time(entry.path(), error), entry.path(), BytesBelow(entry.path())});
    bytes += all.back().bytes;
  }
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  const auto oldest_in_use = fs::file_time_type::clock::now() - kInUse;
  for (const Kept& kept : all) {
    if (bytes <= options_.max_bytes || kept.used > oldest_in_use) break;
    fs::remove_all(kept.dir, error);
    bytes -= kept.bytes;
  }
  return absl::OkStatus();
}

absl::Status ContentCache::Fetch(const Store& store, const std::vector<ContentFile>& files,
                                 const std::string& dir, const FetchContext& context) const {
  for (const ContentFile& file : files) {
    RETURN_IF_ERROR(FetchContentFile(store, file, dir + "/" + file.name, context));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> ContentCache::Bring(const Store& store, const std::string& name,
                                                const FetchContext& context) const {
  const std::optional<ContentReference> reference = FindContentReference(name);
  if (!reference) return name;
  ASSIGN_OR_RETURN(const auto lock, LockFetches(context));
  const std::string last = LastPart(reference->path);
  const std::string key = reference->sha256 + "-" + last.substr(0, 100);
  const std::string place = options_.dir + "/" + key, dir = place + "/" + last;
  const absl::StatusOr<std::vector<ContentFile>> files =
      ListOf(store, reference->sha256, place + "/.list");
  if (absl::IsNotFound(files.status())) return reference->path;
  if (!files.ok()) return WithContext(files.status(), reference->path);
  const absl::StatusOr<std::string> own = BelowPictureRoot(reference->path);
  if (own.ok() && HasAll(*own, *files)) return reference->path;

  std::error_code error;
  if (HasAll(dir, *files)) {
    fs::last_write_time(place, fs::file_time_type::clock::now(), error);
    return dir;
  }
  fs::create_directories(options_.dir, error);
  if (error) return ErrnoError(error.value(), "make " + options_.dir);
  RETURN_IF_ERROR(MakeRoom(BytesOf(*files), key));
  const std::string made = options_.dir + "/" + TemporaryName(reference->sha256);
  absl::Status status = Fetch(store, *files, made + "/" + last, context);
  if (status.ok()) status = WriteFile(made + "/.list", ContentListText(*files));
  if (status.ok()) {
    // One that was damaged goes; another worker may have been quicker, and its copy is as good.
    if (!HasAll(dir, *files)) fs::remove_all(place, error);
    fs::rename(made, place, error);
    if (!HasAll(dir, *files)) {
      status = Unavailable("own content could not be put in {}", place);
    }
  }
  fs::remove_all(made, error);
  RETURN_IF_ERROR(status);
  LogInfo("own content is here", {{"folder", reference->path}, {"files", files->size()}});
  return dir;
}

namespace {

using BringOne = std::function<absl::StatusOr<std::string>(const std::string&)>;

absl::Status BringInto(const BringOne& bring, std::string* folder) {
  if (folder->empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(*folder, bring(*folder));
  return absl::OkStatus();
}

}  // namespace

absl::Status BringContent(const ContentCache& cache, const Store& store,
                          const FetchContext& context, v1::SolveJob& job) {
  const BringOne bring = [&](const std::string& name) { return cache.Bring(store, name, context); };
  if (!job.has_config()) return absl::OkStatus();
  for (std::string* folder : ContentFoldersOf(*job.mutable_config())) {
    RETURN_IF_ERROR(BringInto(bring, folder));
  }
  return absl::OkStatus();
}

absl::Status BringContent(const ContentCache& cache, const Store& store,
                          const FetchContext& context, v1::RenderJob& job) {
  const BringOne bring = [&](const std::string& name) { return cache.Bring(store, name, context); };
  RETURN_IF_ERROR(BringInto(bring, job.mutable_picture_dir()));
  RETURN_IF_ERROR(BringInto(bring, job.mutable_texture_dir()));
  RETURN_IF_ERROR(BringInto(bring, job.mutable_hdri_dir()));
  for (std::string& folder : *job.mutable_include()) RETURN_IF_ERROR(BringInto(bring, &folder));
  return absl::OkStatus();
}

}  // namespace parallax
