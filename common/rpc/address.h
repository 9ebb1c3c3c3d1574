// Where a gRPC endpoint is: "HOST:PORT", "[IPV6]:PORT" or "unix:/absolute/path".
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

struct RpcAddress {
  std::string unix_path;  // Not empty: a Unix socket, and the rest is unused.
  std::string host;       // Without brackets.
  int port = 0;           // 0 only for listening: any free port.

  bool is_unix() const { return !unix_path.empty(); }
  // Reachable from this machine only: a Unix socket, "localhost", 127.0.0.0/8 or ::1.
  bool is_local() const;
  // As ParseRpcAddress reads it; gRPC takes the same form.
  std::string ToString() const;
};

// Errors: kInvalidArgument, saying what was seen and what is wanted.
absl::StatusOr<RpcAddress> ParseRpcAddress(std::string_view text);

}  // namespace parallax
