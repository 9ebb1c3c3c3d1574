// The folder that `run` and `fetch` write to. It is checked before any work begins, and only one
// process at a time may write to it.
//
//   DIR/.parallax/lock      held while a process writes to DIR
//   DIR/.parallax/queue.db  DIR/.parallax/store/  DIR/.parallax/logs/    what `run` keeps to go on
//   later
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "coordinator/client/runs/shared_store.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// With less free space than this, no work is begun and running work is stopped, so that the
// database can still commit.
inline constexpr int64_t kLeastFreeBytes = 64'000'000;

// Returns the bytes that can still be written to the disk of `path`; -1 if unknown.
int64_t FreeBytesOf(const std::string& path);
// Checks that there is room to go on. Errors: kResourceExhausted below kLeastFreeBytes.
absl::Status CheckFreeSpaceOf(const std::string& path);

class OutDir {
 public:
  // Makes DIR and DIR/.parallax if absent, writes a probe file and takes the lock. Errors:
  // kFailedPrecondition if another process holds the lock (names its pid), the path is not a
  // folder, or it lies in another dataset; kPermissionDenied and kResourceExhausted from the disk,
  // naming DIR.
  static absl::StatusOr<std::unique_ptr<OutDir>> Open(const std::string& path);
  OutDir(const OutDir&) = delete;
  OutDir& operator=(const OutDir&) = delete;

  const std::string& path() const { return path_; }  // Absolute.
  std::string work_dir() const { return path_ + "/.parallax"; }
  int64_t FreeBytes() const { return FreeBytesOf(path_); }
  // Errors: those of CheckFreeSpaceOf.
  absl::Status CheckFreeSpace() const { return CheckFreeSpaceOf(path_); }

 private:
  OutDir(std::string path, FolderLock lock) : path_(std::move(path)), lock_(std::move(lock)) {}

  std::string path_;
  FolderLock lock_;
};

// Returns whether the folder holds other files than a dataset of ours. False if it is absent or
// empty.
bool HoldsForeignFiles(const std::string& path);

// Checks that no folder above `path` holds a dataset, unless `path` is one itself already. Errors:
// kFailedPrecondition naming that dataset.
absl::Status CheckNotInDataset(const std::string& path);

// Estimates the bytes that a study's pairs will take on disk, from the size of its images and the
// maps that it writes.
int64_t EstimateBytes(const v1::StudySpec& study);
// Estimates the bytes that the study takes beside the pairs that the dataset in `out_dir` has with
// these settings.
int64_t EstimateMissingBytes(const v1::StudySpec& study, const std::string& out_dir);

}  // namespace parallax::client
