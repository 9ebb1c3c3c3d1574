// Converts an attempt's error into the failure that the coordinator stores.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

// A failed attempt as it is reported.
struct Failure {
  // One line of UTF-8 with at most 1,000 bytes.
  std::string error;
  // Equal for equal causes, whatever the worker and the seed. UTF-8 with at most 200 bytes.
  std::string fingerprint;
  bool retryable = false;  // Whether another try, perhaps elsewhere, may succeed.
};

// Returns the end of a log: at most 200 lines and `most_bytes` bytes. Characters that are neither
// ASCII nor line ends become "?", because messages must be UTF-8 and programs may print anything.
std::string EndOfLog(std::string_view log, size_t most_bytes);
// Attaches the end of a program's log to `status` for the coordinator: its last 200 lines, at most
// 16 kB. Errors: `status` itself.
absl::Status WithLogTail(absl::Status status, std::string_view log);
// Returns the log attached by WithLogTail; empty if none exists.
std::string LogTailOf(const absl::Status& status);

// Describes an error. `status` is not OK; `place` says where it happened: "solve", "render/trace".
Failure DescribeFailure(const absl::Status& status, std::string_view place);

// Returns whether work that failed with this status code is tried again. Only this function decides
// that.
bool IsRetryable(absl::StatusCode code);

}  // namespace parallax
