#include "common/rpc/endpoint.h"

#include <grpc/support/log.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/security/auth_metadata_processor.h>
#include <grpcpp/support/server_interceptor.h>

#include <cstdlib>

#include "common/rpc/grpc_status.h"
#include "common/rpc/probe.h"

namespace parallax {
namespace {

// Who has not finished TLS and the beginning of HTTP/2 by then is disconnected.
constexpr int kHandshake_ms = 10'000;

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

// Tells the listener who is known: the callers whose calls have come as far as to a handler, past
// certificate and gate.
class KnownCallers final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit KnownCallers(Listener& listener) : listener_(listener) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    listener_.Know(info->server_context()->peer());
    return nullptr;
  }

 private:
  Listener& listener_;
};

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

void AwaitRpc(grpc::Channel& channel, std::chrono::duration<double> span) {
  if (channel.GetState(false) != GRPC_CHANNEL_TRANSIENT_FAILURE) return;
  channel.WaitForConnected(DeadlineAfter(span));
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

RpcServer::RpcServer(std::unique_ptr<Listener> listener, const RpcSecurity& security)
    : listener_(std::move(listener)), security_(security) {}

RpcServer::~RpcServer() { Shutdown(std::chrono::seconds(0)); }

absl::StatusOr<std::unique_ptr<RpcServer>> RpcServer::Start(
    const std::vector<RpcAddress>& addresses, const RpcSecurity& security,
    const std::vector<grpc::Service*>& services, RpcGate gate, const ListenerLimits& limits) {
  if (addresses.empty()) return InvalidArgument("no address to listen on");
  for (const RpcAddress& address : addresses) RETURN_IF_ERROR(CheckRpcSecurity(address, security));
  QuietGrpcLog();
  ASSIGN_OR_RETURN(auto listener, Listener::Bind(addresses, limits));
  std::unique_ptr<RpcServer> server(new RpcServer(std::move(listener), security));
  grpc::ServerBuilder builder;
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 20'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 5'000);
  builder.AddChannelArgument(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, kHandshake_ms);
  builder.SetMaxReceiveMessageSize(kMaxRpcMessageBytes);
  builder.SetMaxSendMessageSize(kMaxRpcMessageBytes);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(std::make_unique<KnownCallers>(*server->listener_));
  builder.experimental().SetInterceptorCreators(std::move(interceptors));
  using Acceptor = grpc::experimental::ExternalConnectionAcceptor;
  std::vector<std::shared_ptr<Acceptor>> acceptors;
  for (const RpcAddress& address : addresses) {
    acceptors.push_back(builder.experimental().AddExternalConnectionAcceptor(
        grpc::ServerBuilder::experimental_type::ExternalConnectionType::FROM_FD,
        ServerCredentialsFor(address, security, gate)));
  }
  for (grpc::Service* service : services) builder.RegisterService(service);
  server->server_ = builder.BuildAndStart();
  if (server->server_ == nullptr) return Internal("the gRPC server could not be started");
  server->listener_->Start([acceptors](int fd, size_t address, const std::string&) {
    Acceptor::NewConnectionParameters connection;
    connection.fd = fd;
    acceptors[address]->HandleNewConnection(&connection);
  });
  return server;
}

const std::vector<RpcAddress>& RpcServer::addresses() const { return listener_->addresses(); }

absl::Status RpcServer::CheckAnswers() const {
  for (const RpcAddress& address : addresses()) {
    const bool has_tls = security_.tls != nullptr && !address.is_unix();
    RETURN_IF_ERROR(CheckRpcAnswers(address, has_tls,
                                    [this](const std::string& peer) { listener_->Expect(peer); }));
  }
  return absl::OkStatus();
}

void RpcServer::Shutdown(std::chrono::duration<double> grace) {
  listener_->Stop();
  if (server_ == nullptr) return;
  server_->Shutdown(DeadlineAfter(grace));
  server_->Wait();
}

}  // namespace parallax
