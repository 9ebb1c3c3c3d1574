#include "coordinator/rpc/coordinator_server.h"

#include <algorithm>
#include <mutex>
#include <optional>

#include "common/base/seconds.h"
#include "common/rpc/endpoint.h"
#include "common/rpc/revocation.h"
#include "common/store/store.h"
#include "common/store/store_guard.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/access.h"
#include "coordinator/rpc/artifacts_service.h"
#include "coordinator/rpc/coordinator_service.h"
#include "coordinator/rpc/searches_service.h"
#include "coordinator/rpc/streams_service.h"
#include "coordinator/rpc/task_pool.h"
#include "coordinator/rpc/workers/dispatcher.h"
#include "coordinator/rpc/workers/wait_reasons.h"

namespace parallax {
namespace {

// Threads that wait in the queue, not threads that compute: enough for one group commit to carry
// many.
constexpr int kWorkerCalls = 16;
constexpr int kClientCalls = 8;
constexpr double kShutdownGrace_s = 2;
constexpr double kAskEvery_s = 1;

double LeaseFor(const CoordinatorServerOptions& options, const JobQueue& queue) {
  return options.lease_s > 0 ? std::min(options.lease_s, queue.lease_s()) : queue.lease_s();
}

class CoordinatorServerImpl final : public CoordinatorServer {
 public:
  CoordinatorServerImpl(const CoordinatorServerOptions& options, JobQueue& queue)
      : queue_(queue),
        worker_pool_(kWorkerCalls),
        client_pool_(kClientCalls),
        clock_(*options.clock),
        dispatcher_(queue, worker_pool_, *options.clock, options.reconnect_grace_s),
        waits_(queue, *options.clock, [this] { return dispatcher_.WorkerGroups(); }),
        artifacts_(options.store, options.spool_dir, HolderWritesBelowItsAttempt(queue)),
        service_(queue, dispatcher_, waits_, worker_pool_, client_pool_,
                 {.uri = options.store_uri,
                  .id = options.store == nullptr ? "" : options.store->Id(),
                  .access = options.store_access},
                 queue.database_id(), LeaseFor(options, queue),
                 options.check_outputs ? options.store : nullptr, artifacts_.content(),
                 options.notify_hosts, options.hello_s),
        streams_(queue, client_pool_, *options.clock, options.store_uri, artifacts_.content(),
                 options.notify_hosts),
        searches_(queue, client_pool_, *options.clock, options.scorer, options.samplers,
                  artifacts_.content(), options.notify_hosts) {
    queue_.SetObserver(&dispatcher_);
    worker_pool_.Start();
    client_pool_.Start();
    streams_.Start();
    searches_.Start();
    if (options.store == nullptr || options.store->Id().empty()) return;
    guard_ = std::make_unique<StoreGuard>(
        *options.store, StoreGuard::Options{.every_s = options.store_look_s,
                                            .patient = true,
                                            .changed = [this](const absl::Status& status) {
                                              dispatcher_.HoldLeases(!status.ok());
                                            }});
    service_.SetGuard(guard_.get());
    artifacts_.SetGuard(guard_.get());
    if (!options.scrub) return;
    scrubber_ = std::make_unique<Scrubber>(queue, *options.store, *options.scrub);
    scrubber_->Start();
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
    ASSIGN_OR_RETURN(
        server_, RpcServer::Start(
                     addresses, options.security, {&service_, &artifacts_, &streams_, &searches_},
                     [this](const RpcCaller& caller, std::string_view method) {
                       RETURN_IF_ERROR(CheckNotRevoked(caller));
                       return CheckAccess(caller, method);
                     },
                     options.connections));
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
    metrics.store_problem = std::string(ToStd(StoreStatus().message()));
    if (scrubber_ != nullptr) metrics.scrub = scrubber_->figures();
    return metrics;
  }

  absl::StatusOr<std::vector<v1::StreamStatus>> Streams() const override {
    return streams_.Statuses();
  }

  absl::StatusOr<std::vector<v1::SearchStatus>> Searches() const override {
    return searches_.Statuses();
  }

  absl::Status CheckAnswers() const override {
    std::lock_guard lock(answers_mu_);
    if (!asked_ || SecondsBetween(*asked_, clock_.Steady()) >= kAskEvery_s) {
      answers_ = server_->CheckAnswers();
      asked_ = clock_.Steady();
    }
    return answers_;
  }

  const WaitReasons& waits() const override { return waits_; }

  void SetPage(PageOpener page) override { service_.SetPage(std::move(page)); }

  ContentKeeper* content() override { return artifacts_.content(); }

  absl::Status StoreStatus() const override {
    return guard_ == nullptr ? absl::OkStatus() : guard_->status();
  }

  void Shutdown() override {
    std::lock_guard lock(shutdown_mu_);
    if (shut_down_) return;
    shut_down_ = true;
    scrubber_.reset();
    streams_.Stop();
    searches_.Stop();
    dispatcher_.Stop();
    if (server_ != nullptr) server_->Shutdown(std::chrono::duration<double>(kShutdownGrace_s));
    service_.WaitForCalls();
    streams_.Stop();  // Calls that came since.
    searches_.Stop();
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
  Clock& clock_;
  Dispatcher dispatcher_;
  WaitReasons waits_;
  ArtifactsService artifacts_;
  CoordinatorService service_;
  mutable StreamsService streams_;  // Its first look reads the database.
  mutable SearchesService searches_;
  std::unique_ptr<RevokedCertificates> revoked_;  // Present where callers have certificates.
  std::unique_ptr<RpcServer> server_;
  mutable std::mutex answers_mu_;
  mutable std::optional<SteadyTime> asked_;  // Guarded by answers_mu_.
  mutable absl::Status answers_;             // Guarded by answers_mu_.
  std::unique_ptr<StoreGuard> guard_;  // Null for a store that has no id. Tells the dispatcher.
  std::unique_ptr<Scrubber> scrubber_;
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
