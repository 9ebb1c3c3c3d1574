// grpc::Status <-> absl::Status. The codes are the same numbers.
#pragma once

#include "common/base/status.h"

namespace grpc {
class Status;
}

namespace parallax {

// Errors: the code and message of `status`.
absl::Status FromGrpc(const grpc::Status& status);
// The message is cut at 2,000 bytes: it travels in a header, whose size is bounded.
grpc::Status ToGrpc(const absl::Status& status);

}  // namespace parallax
