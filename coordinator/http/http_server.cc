#include "coordinator/http/http_server.h"

#include <httplib.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/log.h"
#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "coordinator/http/metrics_text.h"
#include "coordinator/http/pair_rate.h"
#include "coordinator/http/status_page.h"

namespace parallax {
namespace {

constexpr int kStudiesShown = 50;
constexpr int kThreads = 4;
constexpr double kRateWindow_s = 600;
constexpr double kSampleEvery_s = 10;
// Many watchers cost as much as a few.
constexpr double kSnapshotAge_s = 0.5;

// Like httplib's own, but without SO_REUSEPORT, which lets two coordinators share a port in
// silence.
void SetSocketOptions(int socket) {
  const int yes = 1;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
}

class HttpServerImpl final : public HttpServer {
 public:
  HttpServerImpl(const HttpServerOptions& options, JobQueue& queue, const CoordinatorServer& server)
      : options_(options),
        queue_(queue),
        server_(server),
        started_(options.clock->Steady()),
        rate_(kRateWindow_s) {}

  ~HttpServerImpl() override { Stop(); }

  absl::Status Listen() {
    ASSIGN_OR_RETURN(address_, ParseRpcAddress(options_.listen));
    if (address_.is_unix()) {
      return absl::InvalidArgumentError("HTTP listens on HOST:PORT, not on " + options_.listen);
    }
    RETURN_IF_ERROR(CheckRpcSecurity(address_, {.insecure = options_.insecure}));
    http_.set_socket_options(SetSocketOptions);
    http_.set_payload_max_length(4096);
    http_.set_read_timeout(5, 0);
    http_.set_write_timeout(5, 0);
    http_.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    Route();
    errno = 0;
    if (address_.port == 0) {
      address_.port = http_.bind_to_any_port(address_.host);
      if (address_.port <= 0) return BindError();
    } else if (!http_.bind_to_port(address_.host, address_.port)) {
      return BindError();
    }
    serving_ = std::thread([this] {
      http_.listen_after_bind();
      serving_ended_ = true;
    });
    sampling_ = std::thread([this] { SampleLoop(); });
    return absl::OkStatus();
  }

  std::string address() const override { return address_.ToString(); }

  void Stop() override {
    {
      std::lock_guard lock(mu_);
      stopping_ = true;
    }
    stop_.notify_all();
    if (serving_.joinable()) {
      // stop() is only heard by a server that already listens.
      while (!http_.is_running() && !serving_ended_) std::this_thread::yield();
      http_.stop();
      serving_.join();
    }
    if (sampling_.joinable()) sampling_.join();
  }

 private:
  absl::Status BindError() const {
    const int error = errno;
    const std::string what = "cannot listen on http " + options_.listen;
    if (error == EADDRINUSE) return absl::AlreadyExistsError(what + ": address already in use");
    if (error == 0) return absl::NotFoundError(what + ": no such address on this machine");
    return ErrnoError(error, what);
  }

  void Route() {
    using httplib::Request;
    using httplib::Response;
    http_.set_default_headers(
        {{"X-Content-Type-Options", "nosniff"},
         {"Cache-Control", "no-store"},
         {"Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'"}});
    http_.Get("/healthz", [this](const Request&, Response& response) { Health(response); });
    http_.Get("/metrics", [this](const Request&, Response& response) {
      Answer(response, "text/plain; version=0.0.4; charset=utf-8", MetricsText);
    });
    http_.Get("/", [this](const Request&, Response& response) {
      Answer(response, "text/html; charset=utf-8", StatusPage);
    });
  }

  // Healthy: the database answers.
  void Health(httplib::Response& response) {
    const absl::Status status = queue_.ListStudies(1).status();
    nlohmann::ordered_json body = {{"status", status.ok() ? "ok" : "failing"},
                                   {"version", kProgramVersion},
                                   {"epoch", queue_.epoch()},
                                   {"schema_version", queue_.schema_version()},
                                   {"uptime_s", Uptime()},
                                   {"workers", server_.Metrics().workers_connected}};
    if (!status.ok()) {
      body["error"] = status.ToString();
      response.status = 503;
    }
    response.set_content(body.dump() + "\n", "application/json");
  }

  void Answer(httplib::Response& response, const char* type,
              std::string (*render)(const StatusSnapshot&)) {
    const absl::StatusOr<StatusSnapshot> snapshot = TakeSnapshot();
    if (!snapshot.ok()) {
      response.status = 503;
      response.set_content(snapshot.status().ToString() + "\n", "text/plain");
      return;
    }
    response.set_content(render(*snapshot), type);
  }

  double Uptime() const {
    return std::chrono::duration<double>(options_.clock->Steady() - started_).count();
  }

  absl::StatusOr<StatusSnapshot> TakeSnapshot() {
    std::lock_guard lock(snapshot_mu_);
    const SteadyTime now = options_.clock->Steady();
    if (has_snapshot_ &&
        std::chrono::duration<double>(now - snapshot_at_).count() < kSnapshotAge_s) {
      return snapshot_;
    }
    StatusSnapshot fresh;
    ASSIGN_OR_RETURN(fresh.studies, queue_.ListStudies(kStudiesShown));
    fresh.version = kProgramVersion;
    fresh.epoch = queue_.epoch();
    fresh.schema_version = queue_.schema_version();
    fresh.store_uri = options_.store_uri;
    fresh.uptime_s = Uptime();
    fresh.now_unix_s = options_.clock->UnixSeconds();
    fresh.workers = server_.Workers();
    fresh.server = server_.Metrics();
    fresh.queue = queue_.Stats();
    int64_t pairs = 0;
    for (const v1::StudyStatus& study : fresh.studies) pairs += CountPairs(study).done;
    rate_.Add(now, pairs);
    fresh.pairs_per_hour = rate_.per_hour();
    NoteEtas(now, fresh);
    snapshot_ = std::move(fresh);
    snapshot_at_ = now;
    has_snapshot_ = true;
    return snapshot_;
  }

  // Requires snapshot_mu_.
  void NoteEtas(SteadyTime now, StatusSnapshot& fresh) {
    std::map<int64_t, PairRate> rates;
    for (const v1::StudyStatus& study : fresh.studies) {
      if (study.state() != v1::STUDY_STATE_RUNNING) continue;
      const auto known = study_rates_.find(study.study_id());
      PairRate& rate =
          rates
              .emplace(study.study_id(), known == study_rates_.end() ? PairRate(kRateWindow_s)
                                                                     : std::move(known->second))
              .first->second;
      const PairCount pairs = CountPairs(study);
      rate.Add(now, pairs.done);
      if (rate.per_hour() <= 0) continue;
      fresh.eta_s[study.study_id()] =
          3600.0 * static_cast<double>(pairs.wanted - pairs.done) / rate.per_hour();
    }
    study_rates_ = std::move(rates);
  }

  // So that the rate is there when somebody looks.
  void SampleLoop() {
    std::unique_lock lock(mu_);
    while (!stopping_) {
      lock.unlock();
      const absl::Status status = TakeSnapshot().status();
      if (!status.ok()) LogWarning("status page: no snapshot", {{"error", status}});
      lock.lock();
      stop_.wait_for(lock, std::chrono::duration<double>(kSampleEvery_s),
                     [this] { return stopping_; });
    }
  }

  const HttpServerOptions options_;
  JobQueue& queue_;
  const CoordinatorServer& server_;
  const SteadyTime started_;
  RpcAddress address_;
  httplib::Server http_;
  std::thread serving_;
  std::thread sampling_;
  std::atomic<bool> serving_ended_ = false;

  std::mutex mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mu_.

  std::mutex snapshot_mu_;
  // Guarded by snapshot_mu_.
  PairRate rate_;
  std::map<int64_t, PairRate> study_rates_;  // Of those that run.
  StatusSnapshot snapshot_;
  SteadyTime snapshot_at_{};
  bool has_snapshot_ = false;
};

}  // namespace

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Start(const HttpServerOptions& options,
                                                              JobQueue& queue,
                                                              const CoordinatorServer& server) {
  auto http = std::make_unique<HttpServerImpl>(options, queue, server);
  RETURN_IF_ERROR(http->Listen());
  return std::unique_ptr<HttpServer>(std::move(http));
}

}  // namespace parallax
