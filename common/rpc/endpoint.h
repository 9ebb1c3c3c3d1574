// Making gRPC channels and servers, so that limits, keepalive and security are the same everywhere.
//
// Without TLS only this machine is reachable (loopback, Unix sockets), unless the user asked for
// `insecure`. With TLS both sides show a certificate of the same authority, on every TCP address;
// Unix sockets stay plain, the file system guards them.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/address.h"
#include "common/rpc/certificate.h"

namespace grpc {
class AuthContext;
class Channel;
class ClientContext;
class Server;
class ServerContextBase;
class Service;
}  // namespace grpc

namespace parallax {

// Bound of one message in either direction.
inline constexpr int kMaxRpcMessageBytes = 64 << 20;

// How an endpoint is secured: whoever connects or listens passes it on.
struct RpcSecurity {
  bool insecure = false;  // Plain text to and from other machines.
  std::shared_ptr<const TlsIdentity> tls = nullptr;
};

// Reads the TLS folder `tls_dir` ("": none). Errors: those of LoadTlsIdentity; kInvalidArgument for
// both at a time.
absl::StatusOr<RpcSecurity> MakeRpcSecurity(bool insecure, const std::string& tls_dir,
                                            Clock& clock);

// Whether `address` may be used with `security`. Errors: kFailedPrecondition, saying what is
// needed.
absl::Status CheckRpcSecurity(const RpcAddress& address, const RpcSecurity& security);

// A channel that connects when first used, and again after losses. Errors: those of
// CheckRpcSecurity; kInvalidArgument for port 0.
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectRpc(const RpcAddress& address,
                                                          const RpcSecurity& security);

// Why a connection to `address` fails for reasons of security: no TLS on one side, a wrong
// authority, an expired certificate, a wrong host name, a refused certificate. OK when there is
// nothing wrong or nobody answers. Errors: kUnauthenticated, saying what to do. Connects once more
// by hand, at most a few seconds: for the moment after a failure.
absl::Status ExplainRpcSecurity(const RpcAddress& address, const RpcSecurity& security);

// A deadline from now on. Every unary call has one.
void SetRpcTimeout(grpc::ClientContext& context, std::chrono::duration<double> timeout);

// Who calls. A caller without certificate comes from this machine (or through `insecure`): it has
// all roles.
struct RpcCaller {
  bool has_certificate = false;
  std::string name;          // Of the certificate.
  std::string sha256;        // Its fingerprint.
  std::optional<Role> role;  // Absent in a certificate that isn't for clients.

  bool Is(Role wanted) const { return !has_certificate || role == wanted; }
};
RpcCaller CallerOf(const grpc::ServerContextBase& context);
// For the audit table: "submitter ada ipv4:10.0.0.7:4711", or the address alone.
std::string ActorOf(const grpc::ServerContextBase& context);

// Whether a caller with a certificate may call "/package.Service/Method".
using RpcGate = std::function<absl::Status(const RpcCaller& caller, std::string_view method)>;

// A listening server. Thread-safe.
class RpcServer {
 public:
  // Listens on all addresses or on none. `services` outlive the server. Every call with a
  // certificate passes `gate` before its message is read; without a gate it is refused. A port is
  // never shared with another process, and a Unix socket that another process serves is not taken
  // away from it; only its owner may connect to it. Errors: kAlreadyExists for an address in use;
  // kPermissionDenied, kNotFound... from the socket, each naming the address; those of
  // CheckRpcSecurity.
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(
      const std::vector<RpcAddress>& addresses, const RpcSecurity& security,
      const std::vector<grpc::Service*>& services, RpcGate gate = nullptr);
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(const std::vector<RpcAddress>& addresses,
                                                          const RpcSecurity& security,
                                                          grpc::Service& service) {
    return Start(addresses, security, std::vector<grpc::Service*>{&service});
  }
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
