#include "coordinator/rpc/coordinator_server.h"

#include <algorithm>
#include <mutex>

#include "common/rpc/endpoint.h"
#include "common/rpc/revocation.h"
#include "common/store/store.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/access.h"
#include "coordinator/rpc/artifacts_service.h"
#include "coordinator/rpc/coordinator_service.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/workers/dispatcher.h"

namespace parallax {
namespace {

// Threads that wait in the queue, not threads that compute: enough for one group commit to carry
// many.
constexpr int kWorkerCalls = 16;
constexpr int kClientCalls = 8;
constexpr double kShutdownGrace_s = 2;

double LeaseFor(const CoordinatorServerOptions& options, const JobQueue& queue) {
  return options.lease_s > 0 ? std::min(options.lease_s, queue.lease_s()) : queue.lease_s();
}

class CoordinatorServerImpl final : public CoordinatorServer {
 public:
  CoordinatorServerImpl(const CoordinatorServerOptions& options, JobQueue& queue)
      : queue_(queue),
        worker_pool_(kWorkerCalls),
        client_pool_(kClientCalls),
        dispatcher_(queue, worker_pool_, *options.clock, options.reconnect_grace_s),
        artifacts_(options.store, options.spool_dir, HolderWritesBelowItsAttempt(queue)),
        service_(queue, dispatcher_, worker_pool_, client_pool_,
                 {.uri = options.store_uri,
                  .id = options.store == nullptr ? "" : options.store->Id(),
                  .access = options.store_access},
                 queue.database_id(), LeaseFor(options, queue),
                 options.check_outputs ? options.store : nullptr, artifacts_.content(),
                 options.hello_s) {
    queue_.SetObserver(&dispatcher_);
    worker_pool_.Start();
    client_pool_.Start();
  }

  ~CoordinatorServerImpl() override { Shutdown(); }

  absl::Status Listen(const CoordinatorServerOptions& options) {
    std::vector<RpcAddress> addresses;
    for (const std::string& text : options.listen) {
      ASSIGN_OR_RETURN(addresses.emplace_back(), ParseRpcAddress(text));
    }
    RETURN_IF_ERROR(artifacts_.Prepare());
    if (options.security.tls != nullptr) {
      const std::string list = options.revoked.empty()
                                   ? options.security.tls->dir + "/" + kRevokedFile
                                   : options.revoked;
      ASSIGN_OR_RETURN(revoked_, RevokedCertificates::Open(list, *options.clock));
    }
    ASSIGN_OR_RETURN(server_,
                     RpcServer::Start(addresses, options.security, {&service_, &artifacts_},
                                      [this](const RpcCaller& caller, std::string_view method) {
                                        RETURN_IF_ERROR(CheckNotRevoked(caller));
                                        return CheckAccess(caller, method);
                                      }));
    return absl::OkStatus();
  }

  std::vector<std::string> addresses() const override {
    std::vector<std::string> texts;
    for (const RpcAddress& address : server_->addresses()) texts.push_back(address.ToString());
    return texts;
  }

  std::vector<v1::WorkerStatus> Workers() const override { return dispatcher_.Workers(); }

  ServerMetrics Metrics() const override {
    ServerMetrics metrics = dispatcher_.Metrics();
    service_.meter().AddTo(metrics);
    return metrics;
  }

  ContentKeeper* content() override { return artifacts_.content(); }

  void Shutdown() override {
    std::lock_guard lock(shutdown_mu_);
    if (shut_down_) return;
    shut_down_ = true;
    dispatcher_.Stop();
    if (server_ != nullptr) server_->Shutdown(std::chrono::duration<double>(kShutdownGrace_s));
    service_.WaitForCalls();
    queue_.SetObserver(nullptr);
  }

 private:
  absl::Status CheckNotRevoked(const RpcCaller& caller) const {
    if (!caller.has_certificate || !revoked_->Contains(caller.sha256)) return absl::OkStatus();
    return Unauthenticated(
        "the certificate of '{}' is revoked; the farm's operator issues another one with "
        "`coordinator init DIR --renew FOLDER`",
        caller.name);
  }

  JobQueue& queue_;
  TaskPool worker_pool_;
  TaskPool client_pool_;
  Dispatcher dispatcher_;
  ArtifactsService artifacts_;
  CoordinatorService service_;
  std::unique_ptr<RevokedCertificates> revoked_;  // Present where callers have certificates.
  std::unique_ptr<RpcServer> server_;
  std::mutex shutdown_mu_;
  bool shut_down_ = false;  // Guarded by shutdown_mu_.
};

}  // namespace

absl::StatusOr<std::unique_ptr<CoordinatorServer>> CoordinatorServer::Start(
    const CoordinatorServerOptions& options, JobQueue& queue) {
  auto server = std::make_unique<CoordinatorServerImpl>(options, queue);
  RETURN_IF_ERROR(server->Listen(options));
  return std::unique_ptr<CoordinatorServer>(std::move(server));
}

}  // namespace parallax
