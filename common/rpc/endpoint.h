// Makes gRPC channels and servers with the same limits, keepalive and security everywhere.
//
// Without TLS, only endpoints of this machine are allowed (loopback, Unix sockets), unless the user
// asked for `insecure`. With TLS, both sides show a certificate of the same authority on every TCP
// address. Unix sockets have no TLS; the file system guards them.
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
#include "common/rpc/listener.h"

namespace grpc {
class AuthContext;
class Channel;
class ClientContext;
class Server;
class ServerContextBase;
class Service;
}  // namespace grpc

namespace parallax {

// Largest message in either direction, in bytes.
inline constexpr int kMaxRpcMessageBytes = 64 << 20;

// How an endpoint is secured.
struct RpcSecurity {
  bool insecure = false;  // Plain text to and from other machines.
  std::shared_ptr<const TlsIdentity> tls = nullptr;
};

// Reads the TLS folder `tls_dir`; "" for none. Errors: those of LoadTlsIdentity; kInvalidArgument
// if both `insecure` and a folder are given.
absl::StatusOr<RpcSecurity> MakeRpcSecurity(bool insecure, const std::string& tls_dir,
                                            Clock& clock);

// Checks that `address` may be used with `security`. Errors: kFailedPrecondition that says what is
// needed.
absl::Status CheckRpcSecurity(const RpcAddress& address, const RpcSecurity& security);

// Returns a channel that connects when it is first used and reconnects when the connection is lost.
// Errors: those of CheckRpcSecurity; kInvalidArgument for port 0.
absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectRpc(const RpcAddress& address,
                                                          const RpcSecurity& security);

// Waits for up to `span` until a channel whose last try to connect has failed is connected; at once
// otherwise. For callers that try again with pauses: gRPC connects only while somebody waits, and a
// call on such a channel fails without waiting, so that without this a server that is back may
// never be found.
void AwaitRpc(grpc::Channel& channel, std::chrono::duration<double> span);

// Explains why a connection to `address` fails, if security is the reason: no TLS on one side, a
// wrong authority, an expired certificate, a wrong host name, a refused certificate. Call it after
// a failure: it makes a connection of its own, for at most a few seconds. Returns OK if it finds no
// such reason or nobody answers. Errors: kUnauthenticated that says what to do.
absl::Status ExplainRpcSecurity(const RpcAddress& address, const RpcSecurity& security);

// Sets the deadline of a call to `timeout` from now. Every unary call has one.
void SetRpcTimeout(grpc::ClientContext& context, std::chrono::duration<double> timeout);

// The caller of an RPC. A caller without a certificate is on this machine (or came through
// `insecure`) and has all roles.
struct RpcCaller {
  bool has_certificate = false;
  std::string name;          // Common name of the certificate.
  std::string sha256;        // Its fingerprint.
  std::optional<Role> role;  // Absent in a certificate that isn't for clients.

  // Returns whether the caller has this role.
  bool Is(Role wanted) const { return !has_certificate || role == wanted; }
};
// Returns the caller of a call in progress.
RpcCaller CallerOf(const grpc::ServerContextBase& context);
// Returns the caller for the audit table: "submitter ada ipv4:10.0.0.7:4711", or the address alone
// without a certificate.
std::string ActorOf(const grpc::ServerContextBase& context);

// Decides whether a caller with a certificate may call "/package.Service/Method": OK if it may.
using RpcGate = std::function<absl::Status(const RpcCaller& caller, std::string_view method)>;

// A listening server. Callers without a certificate can't fill it: see listener.h. Thread-safe.
class RpcServer {
 public:
  // Listens on all addresses or on none. `services` must outlive the server. `gate` checks every
  // call with a certificate before its message is read; without a gate such calls are refused.
  // Errors: those of Listener::Bind and CheckRpcSecurity.
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(
      const std::vector<RpcAddress>& addresses, const RpcSecurity& security,
      const std::vector<grpc::Service*>& services, RpcGate gate = nullptr,
      const ListenerLimits& limits = {});
  static absl::StatusOr<std::unique_ptr<RpcServer>> Start(const std::vector<RpcAddress>& addresses,
                                                          const RpcSecurity& security,
                                                          grpc::Service& service) {
    return Start(addresses, security, std::vector<grpc::Service*>{&service});
  }
  ~RpcServer();  // Shuts down at once.

  // Returns the addresses of Start, with the actual port in place of port 0.
  const std::vector<RpcAddress>& addresses() const;

  // Connects to each of its own addresses as a client does, in a place that is kept for this, and
  // waits until gRPC answers there. Errors: kUnavailable that names the address.
  absl::Status CheckAnswers() const;

  // Refuses new calls, lets calls in progress end for up to `grace`, cancels the rest, and returns
  // when all have ended. Idempotent.
  void Shutdown(std::chrono::duration<double> grace);

 private:
  RpcServer(std::unique_ptr<Listener> listener, const RpcSecurity& security);

  const std::unique_ptr<Listener> listener_;
  const RpcSecurity security_;
  std::unique_ptr<grpc::Server> server_;  // Null only while it starts.
};

}  // namespace parallax
