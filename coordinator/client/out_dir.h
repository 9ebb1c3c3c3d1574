// The folder that `run` and `fetch` write to: checked before any work begins, and held by one
// process at a time.
//
//   DIR/.parallax/lock      held while a process writes to DIR
//   DIR/.parallax/queue.db  DIR/.parallax/store/  DIR/.parallax/logs/    what `run` keeps to go on
//   later
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "parallax/v1/study.pb.h"

namespace parallax::client {

// Below this much free space nothing is begun, and what runs is stopped: the database must still be
// able to commit.
inline constexpr int64_t kLeastFreeBytes = 64'000'000;

class OutDir {
 public:
  // Makes DIR and DIR/.parallax, writes a probe file, takes the lock.
  // Errors: kFailedPrecondition when another process holds the lock (named by its pid) or the path
  // isn't a folder; kPermissionDenied and kResourceExhausted as the disk says, each naming DIR.
  static absl::StatusOr<std::unique_ptr<OutDir>> Open(const std::string& path);
  ~OutDir();  // Gives the lock back.
  OutDir(const OutDir&) = delete;
  OutDir& operator=(const OutDir&) = delete;

  const std::string& path() const { return path_; }  // Absolute.
  std::string work_dir() const { return path_ + "/.parallax"; }
  // Bytes that may still be written; -1 when unknown.
  int64_t FreeBytes() const;
  // Errors: kResourceExhausted below kLeastFreeBytes.
  absl::Status CheckFreeSpace() const;

 private:
  OutDir(std::string path, int lock_descriptor)
      : path_(std::move(path)), lock_descriptor_(lock_descriptor) {}

  std::string path_;
  int lock_descriptor_;
};

// Neither absent, empty nor a dataset of ours: something else lives there.
bool HoldsForeignFiles(const std::string& path);

// A rough figure of what a study's pairs will take on disk, from the sizes of its images and the
// maps written.
int64_t EstimateBytes(const v1::StudySpec& study);

}  // namespace parallax::client
