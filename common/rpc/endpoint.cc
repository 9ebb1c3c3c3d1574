#include "common/rpc/endpoint.h"

#include <grpc/support/log.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/security/auth_metadata_processor.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "common/rpc/grpc_status.h"

namespace parallax {
namespace {

// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

absl::Status ListenError(const RpcAddress& address, int error_number) {
  if (error_number == EADDRINUSE) {
    return AlreadyExists("cannot listen on {}: address already in use", address.ToString());
  }
  return ErrnoError(error_number, "cannot listen on " + address.ToString());
}

// gRPC removes a socket file before it binds, even if it is served; so ask first whether a process
// answers there.
absl::Status CheckUnixSocketFree(const RpcAddress& address) {
  Descriptor fd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) return ListenError(address, errno);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, address.unix_path.c_str(), address.unix_path.size() + 1);
  if (connect(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof(name)) == 0) {
    return ListenError(address, EADDRINUSE);
  }
  return absl::OkStatus();
}

// gRPC says only that it could not bind. Binding once more by hand tells why; OK when nothing is
// wrong (any more).
absl::Status ProbeTcp(const RpcAddress& address) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_PASSIVE;
  addrinfo* found = nullptr;
  const int error =
      getaddrinfo(address.host.c_str(), std::to_string(address.port).c_str(), &hints, &found);
  if (error != 0) {
    return NotFound("cannot listen on {}: {}", address.ToString(), gai_strerror(error));
  }
  std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner(found, &freeaddrinfo);
  Descriptor fd(socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) return ListenError(address, errno);
  const int yes = 1;
  setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  if (bind(fd.get(), found->ai_addr, found->ai_addrlen) != 0) return ListenError(address, errno);
  if (listen(fd.get(), 1) != 0) return ListenError(address, errno);
  return absl::OkStatus();
}

absl::Status ProbeUnix(const RpcAddress& address) {
  Descriptor fd(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  if (fd.get() < 0) return ListenError(address, errno);
  sockaddr_un name{};
  name.sun_family = AF_UNIX;
  std::memcpy(name.sun_path, address.unix_path.c_str(), address.unix_path.size() + 1);
  if (bind(fd.get(), reinterpret_cast<sockaddr*>(&name), sizeof(name)) != 0) {
    return ListenError(address, errno);
  }
  unlink(address.unix_path.c_str());
  return absl::OkStatus();
}

// gRPC's own lines tell of what our statuses tell too. Who hunts a bug in gRPC sets GRPC_VERBOSITY.
void QuietGrpcLog() {
  static const bool done = [] {
    if (std::getenv("GRPC_VERBOSITY") == nullptr) {
      gpr_set_log_function([](gpr_log_func_args*) {});
    }
    return true;
  }();
  (void)done;
}

// Uses the monotonic clock, so the deadline holds when the wall clock jumps.
gpr_timespec DeadlineAfter(std::chrono::duration<double> span) {
  return gpr_time_add(gpr_now(GPR_CLOCK_MONOTONIC),
                      gpr_time_from_micros(static_cast<int64_t>(span.count() * 1e6), GPR_TIMESPAN));
}

RpcCaller CallerOf(const grpc::AuthContext& peer) {
  RpcCaller caller;
  caller.has_certificate = peer.IsPeerAuthenticated();
  if (!caller.has_certificate) return caller;
  const std::vector<grpc::string_ref> pem = peer.FindPropertyValues("x509_pem_cert");
  if (pem.empty()) return caller;
  const auto facts = ReadCertificate(std::string(pem[0].begin(), pem[0].end()));
  if (!facts.ok()) return caller;
  caller.name = facts->name;
  caller.sha256 = facts->sha256;
  caller.role = facts->role;
  return caller;
}

// Asks the gate before anything of a call is read.
class GateKeeper final : public grpc::AuthMetadataProcessor {
 public:
  explicit GateKeeper(RpcGate gate) : gate_(std::move(gate)) {}

  bool IsBlocking() const override { return false; }
  grpc::Status Process(const InputMetadata& metadata, grpc::AuthContext* peer, OutputMetadata*,
                       OutputMetadata*) override {
    const auto path = metadata.find(":path");
    if (path == metadata.end() || gate_ == nullptr) {
      return grpc::Status(grpc::StatusCode::PERMISSION_DENIED, "no rule allows this call");
    }
    return ToGrpc(gate_(CallerOf(*peer), {path->second.data(), path->second.size()}));
  }

 private:
  const RpcGate gate_;
};

std::shared_ptr<grpc::ChannelCredentials> ChannelCredentialsFor(const RpcAddress& address,
                                                                const RpcSecurity& security) {
  if (security.tls == nullptr || address.is_unix()) return grpc::InsecureChannelCredentials();
  grpc::SslCredentialsOptions options;
  options.pem_root_certs = security.tls->ca_pem;
  options.pem_private_key = security.tls->own.key_pem;
  options.pem_cert_chain = security.tls->own.certificate_pem;
  return grpc::SslCredentials(options);
}

std::shared_ptr<grpc::ServerCredentials> ServerCredentialsFor(const RpcAddress& address,
                                                              const RpcSecurity& security,
                                                              const RpcGate& gate) {
  if (security.tls == nullptr || address.is_unix()) return grpc::InsecureServerCredentials();
  grpc::SslServerCredentialsOptions options(
      GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  options.pem_root_certs = security.tls->ca_pem;
  options.pem_key_cert_pairs.push_back(
      {security.tls->own.key_pem, security.tls->own.certificate_pem});
  std::shared_ptr<grpc::ServerCredentials> credentials = grpc::SslServerCredentials(options);
  credentials->SetAuthMetadataProcessor(std::make_shared<GateKeeper>(gate));
  return credentials;
}

absl::Status WhyNotListening(const RpcAddress& address) {
  absl::Status why = address.is_unix() ? ProbeUnix(address) : ProbeTcp(address);
  if (!why.ok()) return why;
  return Unavailable("cannot listen on {}", address.ToString());
}

}  // namespace

absl::StatusOr<RpcSecurity> MakeRpcSecurity(bool insecure, const std::string& tls_dir,
                                            Clock& clock) {
  RpcSecurity security{.insecure = insecure};
  if (tls_dir.empty()) return security;
  if (insecure) return InvalidArgument("--tls and --insecure exclude each other");
  ASSIGN_OR_RETURN(security.tls, LoadTlsIdentity(tls_dir, clock));
  return security;
}

absl::Status CheckRpcSecurity(const RpcAddress& address, const RpcSecurity& security) {
  if (address.is_local() || security.insecure || security.tls != nullptr) return absl::OkStatus();
  return FailedPrecondition(
      "address {} is not of this machine, and the connection would be neither encrypted nor "
      "authenticated; use a loopback address or a Unix socket, give --tls DIR with a certificate "
      "from `coordinator init`, or allow it with --insecure",
      address.ToString());
}

absl::StatusOr<std::shared_ptr<grpc::Channel>> ConnectRpc(const RpcAddress& address,
                                                          const RpcSecurity& security) {
  RETURN_IF_ERROR(CheckRpcSecurity(address, security));
  if (!address.is_unix() && address.port == 0) {
    return InvalidArgument("address {}: port 0 is only for listening", address.ToString());
  }
  QuietGrpcLog();
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(kMaxRpcMessageBytes);
  arguments.SetMaxSendMessageSize(kMaxRpcMessageBytes);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Callers have their own back-off; the channel's must not hide a coordinator that is back.
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 100);
  // In spite of its name, this bounds the time of one try: a TLS handshake with a busy or far
  // machine needs more than the 100 ms between tries.
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 2'000);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2'000);
  // A proxy named by the environment is for the web, not for the machine's own sockets.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(address.ToString(), ChannelCredentialsFor(address, security),
                                   arguments);
}

RpcCaller CallerOf(const grpc::ServerContextBase& context) {
  const std::shared_ptr<const grpc::AuthContext> peer = context.auth_context();
  return peer == nullptr ? RpcCaller() : CallerOf(*peer);
}

std::string ActorOf(const grpc::ServerContextBase& context) {
  const RpcCaller caller = CallerOf(context);
  if (!caller.has_certificate) return context.peer();
  return std::string(caller.role ? RoleName(*caller.role) : "nobody") + " " + caller.name + " " +
         context.peer();
}

void SetRpcTimeout(grpc::ClientContext& context, std::chrono::duration<double> timeout) {
  context.set_deadline(DeadlineAfter(timeout));
}

RpcServer::RpcServer(std::unique_ptr<grpc::Server> server, std::vector<RpcAddress> addresses)
    : server_(std::move(server)), addresses_(std::move(addresses)) {}

RpcServer::~RpcServer() { Shutdown(std::chrono::seconds(0)); }

absl::StatusOr<std::unique_ptr<RpcServer>> RpcServer::Start(
    const std::vector<RpcAddress>& addresses, const RpcSecurity& security,
    const std::vector<grpc::Service*>& services, RpcGate gate) {
  if (addresses.empty()) return InvalidArgument("no address to listen on");
  for (const RpcAddress& address : addresses) {
    RETURN_IF_ERROR(CheckRpcSecurity(address, security));
    if (address.is_unix()) RETURN_IF_ERROR(CheckUnixSocketFree(address));
  }
  QuietGrpcLog();
  grpc::ServerBuilder builder;
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
  builder.SetMaxReceiveMessageSize(kMaxRpcMessageBytes);
  builder.SetMaxSendMessageSize(kMaxRpcMessageBytes);
  std::vector<int> ports(addresses.size(), 0);
  for (size_t i = 0; i < addresses.size(); ++i) {
    builder.AddListeningPort(addresses[i].ToString(),
                             ServerCredentialsFor(addresses[i], security, gate), &ports[i]);
  }
  for (grpc::Service* service : services) builder.RegisterService(service);
  std::unique_ptr<grpc::Server> server = builder.BuildAndStart();
  for (size_t i = 0; i < addresses.size(); ++i) {
    if (server == nullptr || ports[i] == 0) {
      // The first address that could not be bound keeps port 0, also when gRPC gave up on all of
      // them.
      if (ports[i] != 0) continue;
      server.reset();
      return WhyNotListening(addresses[i]);
    }
  }
  if (server == nullptr) return Internal("the gRPC server could not be started");
  std::vector<RpcAddress> bound = addresses;
  for (size_t i = 0; i < bound.size(); ++i) {
    if (!bound[i].is_unix()) {
      bound[i].port = ports[i];
    } else if (chmod(bound[i].unix_path.c_str(), 0600) != 0) {
      return ListenError(bound[i], errno);
    }
  }
  return std::unique_ptr<RpcServer>(new RpcServer(std::move(server), std::move(bound)));
}

void RpcServer::Shutdown(std::chrono::duration<double> grace) {
  server_->Shutdown(DeadlineAfter(grace));
  server_->Wait();
}

}  // namespace parallax
