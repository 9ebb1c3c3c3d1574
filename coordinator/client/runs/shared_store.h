// Where `run` keeps database and store: in the dataset's own folder, or in a folder that several
// datasets share, so that one uses the pairs of the others.
#pragma once

#include <string>

#include "common/base/status.h"

namespace parallax::client {

// Holds the lock of a folder that one process at a time may write to. Movable.
class FolderLock {
 public:
  // Locks `dir`/lock; `hint` says what the user may do if another process holds it. Errors:
  // kFailedPrecondition naming `shown` and that process; those of the disk.
  static absl::StatusOr<FolderLock> Take(const std::string& dir, const std::string& shown,
                                         const std::string& hint);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

// Returns the folder that this user's datasets share unless they are told otherwise:
// $PARALLAX_STORE or, if the user has made it, parallax/store in $XDG_CACHE_HOME (~/.cache). Empty
// if none exists: Parallax never makes it by itself, because what is in it stays when a dataset
// is removed.
std::string UsersStore();

// Returns the folder of database and store with which the dataset of this `work_dir` began.
std::string StoreOf(const std::string& work_dir);

// Returns the folder for database and store of the dataset whose own folder for them is `work_dir`:
// `given`, the option --store; else where the dataset began; else UsersStore; else `work_dir`.
// Makes the folder, and notes it in `work_dir`. Errors: those of the disk.
absl::StatusOr<std::string> ChooseStore(const std::string& given, const std::string& work_dir);

// Says for people where UsersStore is, and how to share one.
std::string DescribeUsersStore();

}  // namespace parallax::client
