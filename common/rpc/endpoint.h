// Making gRPC channels and servers, so that limits, keepalive and security are the same everywhere.
//
// Without TLS only this machine is reachable (loopback, Unix sockets), unless the user asked for
// `insecure`.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/address.h"

namespace grpc {
class Channel;
class ClientContext;
class Server;
class Service;
}  // namespace grpc

namespace parallax {

// Bound of one message in either direction.
inline constexpr int kMaxRpcMessageBytes = 64 << 20;

// How an endpoint is secured. Certificates become fields of this struct: whoever connects or
// listens passes it on.
struct RpcSecurity {
  bool insecure = false;  // Plain text to and from other machines.
};

// kFailedPrecondition when `address` may not be used with `security`.
absl::Status CheckRpcSecurity(const RpcAddress& address, const RpcSecurity& security);

// A channel that connects when first used, and again after losses. Errors: those of
// CheckRpcSecurity; kInvalidArgument for port 0.
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectRpc(const RpcAddress& address,
                                                          const RpcSecurity& security);

// A deadline from now on. Every unary call has one.
void SetRpcTimeout(grpc::ClientContext& context, std::chrono::duration<double> timeout);

// A listening server. Thread-safe.
class RpcServer {
 public:
  // Listens on all addresses or on none. `service` outlives the server. A port is never shared with
  // another process, and a Unix socket that another process serves is not taken away from it; only
  // its owner may connect to it. Errors: kAlreadyExists for an address in use; kPermissionDenied,
  // kNotFound... from the socket, each naming the address; those of CheckRpcSecurity.
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(const std::vector<RpcAddress>& addresses,
                                                          const RpcSecurity& security,
                                                          grpc::Service& service);
  ~RpcServer();  // Shuts down at once.

  // With the ports that port 0 became.
  const std::vector<RpcAddress>& addresses() const { return addresses_; }

  // No new calls; calls in progress may end within `grace`, then they are cancelled. Waits.
  // Idempotent.
  void Shutdown(std::chrono::duration<double> grace);

 private:
  RpcServer(std::unique_ptr<grpc::Server> server, std::vector<RpcAddress> addresses);

  std::unique_ptr<grpc::Server> server_;
  std::vector<RpcAddress> addresses_;
};

}  // namespace parallax
