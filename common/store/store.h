// The store of attempts' outputs: a tree of folders that workers fill, and that never changes after
// publication. Paths are relative ("<key>/.attempt-<fence>/003/left.png"), separated by '/', and
// cannot leave the store; see CheckStorePath.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"

namespace parallax {

// A file in a listing: its path in the store and its size in bytes.
struct StoreEntry {
  std::string path;
  int64_t size = 0;
  double modified_unix_s = 0;  // 0: not known.
};

// Size in bytes and hash of a file's content.
struct StoreFile {
  int64_t size = 0;
  std::string sha256;  // Lower-case hex.
};

// Thread-safe.
class Store {
 public:
  virtual ~Store() = default;
  // Returns the URI by which OpenStore opens this store: "file:///abs/dir",
  // "s3://bucket/prefix?...".
  virtual std::string Uri() const = 0;
  // Returns the id in the marker at the root of the store; "" for a store without a marker.
  virtual std::string Id() const { return ""; }
  // Looks whether the store is still under its name, with its id: a disk may be unmounted or
  // swapped at any time. Errors: kNotFound if there is no marker; kFailedPrecondition for another
  // store's; those of Put.
  virtual absl::Status CheckMarker() const { return absl::OkStatus(); }
  // Return and set the id of the database that the store belongs to; "" if it belongs to none.
  // Errors: those of Get and Put; kUnimplemented for a store without a marker.
  virtual absl::StatusOr<std::string> Owner() const { return std::string(); }
  virtual absl::Status SetOwner(const std::string& database_id);
  // Writes a file, whole or not at all. When it returns OK, data and directory entries are durable.
  // Errors of all methods: kInvalidArgument for a path that CheckStorePath refuses; kNotFound for a
  // missing file; kPermissionDenied, kResourceExhausted and kUnavailable from the disk or service.
  virtual absl::Status Put(std::string_view path, std::string_view bytes) = 0;
  // Puts a file of this machine whose size and hash are `facts`. Putting the same file again costs
  // little or nothing. With `may_move`, the local file may be gone afterwards. Errors: those of
  // Put; kDataLoss if the bytes that arrive differ from `facts`.
  virtual absl::Status PutFile(std::string_view path, const std::string& local_path,
                               const StoreFile& facts, bool may_move);
  // Returns the content of a file. Errors: those of Put; kNotFound.
  virtual absl::StatusOr<std::string> Get(std::string_view path) const = 0;
  // Returns at most `max_bytes` bytes from `offset` on; "" at the end. Errors: those of Get.
  virtual absl::StatusOr<std::string> GetPiece(std::string_view path, int64_t offset,
                                               size_t max_bytes) const = 0;
  // Returns whether there is this file, without reading more than a byte of it. Errors: those of
  // Put, except kNotFound.
  virtual absl::StatusOr<bool> Has(std::string_view path) const;
  // Returns the files below `prefix`; none if there is no such folder. Errors: those of Put.
  virtual absl::StatusOr<std::vector<StoreEntry>> List(std::string_view prefix) const = 0;
  // Removes a file, or a folder with all that is in it. Returns OK if none exists. Errors: those
  // of Put.
  virtual absl::Status RemoveTree(std::string_view path) = 0;
  // Returns the path in this machine's file system. Errors: kFailedPrecondition if the store is not
  // a folder of this machine.
  virtual absl::StatusOr<std::string> LocalPath(std::string_view path) const = 0;
};

// Returns whether an error of CheckMarker is certain: there is no marker, or it is another store's.
// A disk or server that does not answer for a moment may have all files.
inline bool IsStoreGone(const absl::Status& status) {
  return absl::IsNotFound(status) || absl::IsFailedPrecondition(status);
}

// Checks a path in a store. Errors: kInvalidArgument unless it is relative and normal, without
// "..", empty parts, NUL or backslash, and without the store's own names (".tmp-...",
// ".parallax-store", ".parallax-owner").
absl::Status CheckStorePath(std::string_view path);

// How a store is opened.
struct StoreOptions {
  // Make the folder and its marker if it is new. If false, a folder that is absent or has no marker
  // is refused: it is probably a shared disk that is not mounted.
  bool create = true;
  // Not empty: the marker must have this id.
  std::string id;
  // The store is only read: opening it does not try to write.
  bool read_only = false;
};

// Opens the store at "file:///abs/dir", a plain path, or "s3://bucket/prefix?endpoint=..." (see
// s3_store.h). Errors: each names the folder and the cause. kNotFound for an absent folder or
// marker; kFailedPrecondition for the marker of another store; those of Put if it can't be written.
absl::StatusOr<std::unique_ptr<Store>> OpenStore(std::string_view uri,
                                                 const StoreOptions& options = {});

// Makes a file or folder durable by fsync. Errors: those of open(2) and fsync(2), naming the path.
absl::Status SyncPath(const std::string& path);
// Writes a file whole or not at all: writes under a temporary name in the same folder, fsyncs,
// renames, and fsyncs the folder. Errors: those of WriteFile and rename(2), naming the path.
absl::Status WriteFileAtomically(const std::string& path, std::string_view bytes);

}  // namespace parallax
