// From an attempt's error to what the coordinator is told.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

struct Failure {
  std::string error;        // One line, at most 1,000 bytes.
  std::string fingerprint;  // Equal for equal causes on whatever worker and seed: code + place,
                            // without numbers.
  bool retryable = false;   // Another try, perhaps elsewhere, may succeed.
};

// `status` with the end of a program's log for the coordinator: its last 200 lines, at most 16 kB.
// Errors: `status` itself.
absl::Status WithLogTail(absl::Status status, std::string_view log);
// Empty if there is none.
std::string LogTailOf(const absl::Status& status);

// `status` is not OK. `place` says where it happened: "solve", "render/trace".
Failure DescribeFailure(const absl::Status& status, std::string_view place);

// The only place where a code decides whether work is tried again.
bool IsRetryable(absl::StatusCode code);

}  // namespace parallax
