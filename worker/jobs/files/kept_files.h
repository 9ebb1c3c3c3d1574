// The output files of a job in its attempt's folder. Not thread-safe.
#pragma once

#include <google/protobuf/repeated_ptr_field.h>

#include <string>

#include "common/base/status.h"
#include "parallax/v1/jobs.pb.h"
#include "worker/agent/attempts/job_handler.h"

namespace parallax {

// Copies files durably and lists them.
class KeptFiles {
 public:
  // `folder` must outlive the object.
  explicit KeptFiles(const AttemptFolder& folder) : folder_(folder) {}

  // Copies a file of this machine to `name` in the attempt's folder, durably. Returns its SHA-256.
  // Errors: the disk's.
  absl::StatusOr<std::string> Keep(const std::string& from, const std::string& name);
  // Writes `text` to `name` in the attempt's folder, durably. Errors: the disk's.
  absl::Status KeepText(const std::string& text, const std::string& name);

  // Return all files so far, in the form of results and in that of the agent.
  const google::protobuf::RepeatedPtrField<v1::FileEntry>& entries() const { return entries_; }
  std::vector<OutputFile> outputs() const;

 private:
  absl::Status Note(const std::string& name, const std::string& sha256);

  const AttemptFolder& folder_;
  google::protobuf::RepeatedPtrField<v1::FileEntry> entries_;
};

}  // namespace parallax
