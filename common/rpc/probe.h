// Asks whether gRPC answers at an address of this process. Private to common/rpc.
#pragma once

#include <functional>
#include <string>

#include "common/base/status.h"
#include "common/rpc/address.h"

namespace parallax {

// Connects to `address` over its own socket and waits for the first bytes that only a live server
// sends: its whole part of a TLS handshake or, without TLS, its first frame of HTTP/2. Addresses
// of all interfaces are asked on loopback. `expect` is called with the connection's own name, as
// Listener::Take has it, before it connects; not for Unix sockets. Returns after at most a few
// seconds. Errors: kUnavailable that names the address and what failed.
absl::Status CheckRpcAnswers(const RpcAddress& address, bool tls,
                             const std::function<void(const std::string& peer)>& expect);

}  // namespace parallax
