// Converts between grpc::Status and absl::Status. Their codes are the same numbers.
#pragma once

#include "common/base/status.h"

namespace grpc {
class Status;
}

namespace parallax {

// Converts a status of gRPC. Errors: the code and message of `status`.
absl::Status FromGrpc(const grpc::Status& status);
// Returns the same code, and the message cut to 2,000 bytes: it travels in a header of bounded
// size.
grpc::Status ToGrpc(const absl::Status& status);

}  // namespace parallax
