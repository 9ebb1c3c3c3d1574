// Addresses of gRPC endpoints: "HOST:PORT", "[IPV6]:PORT" or "unix:/absolute/path".
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"

namespace parallax {

struct RpcAddress {
  std::string unix_path;  // Not empty: a Unix socket; host and port are unused.
  std::string host;       // Without brackets.
  int port = 0;           // 0, for listening only: any free port.

  bool is_unix() const { return !unix_path.empty(); }
  // Returns whether the address can be reached from this machine only: a Unix socket, "localhost",
  // 127.0.0.0/8 or ::1.
  bool is_local() const;
  // Returns the form that ParseRpcAddress and gRPC read.
  std::string ToString() const;
};

// Returns whether `host`, without brackets, is an IPv4 or IPv6 address in full and no name.
bool IsIpAddress(const std::string& host);
// Returns whether `host`, without brackets, is "localhost" or an address of 127.0.0.0/8 or ::1. It
// is parsed: "127.example.org" and "127.1" are names.
bool IsLoopbackHost(const std::string& host);

// Parses an address. Errors: kInvalidArgument that says what was seen and what is wanted.
absl::StatusOr<RpcAddress> ParseRpcAddress(std::string_view text);

}  // namespace parallax
