#include "coordinator/http/http_server.h"

#include <httplib.h>

#include <condition_variable>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/file.h"
#include "common/base/hash.h"
#include "common/base/log.h"
#include "common/base/rate_estimator.h"
#include "common/base/seconds.h"
#include "common/base/version.h"
#include "common/rpc/endpoint.h"
#include "coordinator/http/metrics_text.h"
#include "coordinator/http/status_page.h"

namespace parallax {
namespace {

constexpr int kStudiesShown = 50;
constexpr int kThreads = 4;
constexpr size_t kShortestToken = 16;
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

// Without padding or what follows a character that is none.
std::string DecodeBase64(const std::string& text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    const size_t digit = kDigits.find(c);
    if (digit == std::string_view::npos) break;
    bits = bits << 6 | static_cast<unsigned>(digit);
    count += 6;
    if (count >= 8) bytes += static_cast<char>(bits >> (count -= 8) & 255);
  }
  return bytes;
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
    RETURN_IF_ERROR(CheckRpcSecurity(address_, options_.security));
    if (!address_.is_local() && options_.security.tls != nullptr) RETURN_IF_ERROR(UseTls());
    http_->set_socket_options(SetSocketOptions);
    http_->set_payload_max_length(4096);
    http_->set_read_timeout(5, 0);
    http_->set_write_timeout(5, 0);
    http_->new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    Route();
    errno = 0;
    if (address_.port == 0) {
      address_.port = http_->bind_to_any_port(address_.host);
      if (address_.port <= 0) return BindError();
    } else if (!http_->bind_to_port(address_.host, address_.port)) {
      return BindError();
    }
    serving_ = std::thread([this] {
      http_->listen_after_bind();
      serving_ended_ = true;
    });
    sampling_ = std::thread([this] { SampleLoop(); });
    return absl::OkStatus();
  }

  std::string address() const override { return address_.ToString(); }
  std::string url() const override {
    return (token_.empty() ? "http://" : "https://") + address_.ToString() + "/";
  }

  void Stop() override {
    {
      std::lock_guard lock(mu_);
      stopping_ = true;
    }
    stop_.notify_all();
    if (serving_.joinable()) {
      // stop() is only heard by a server that already listens.
      while (!http_->is_running() && !serving_ended_) std::this_thread::yield();
      http_->stop();
      serving_.join();
    }
    if (sampling_.joinable()) sampling_.join();
  }

 private:
  absl::Status UseTls() {
    const std::string& dir = options_.security.tls->dir;
    const auto token = ReadFile(dir + "/http.token", 4096);
    if (!token.ok()) {
      return absl::FailedPreconditionError(
          std::string(ToStd(token.status().message())) +
          "; the status page on another address than loopback needs a token there, as "
          "`coordinator init` makes it");
    }
    token_ = token->substr(0, token->find_last_not_of(" \r\n") + 1);
    if (token_.size() < kShortestToken) {
      return absl::FailedPreconditionError(dir + "/http.token: shorter than " +
                                           std::to_string(kShortestToken) + " characters");
    }
    auto server = std::make_unique<httplib::SSLServer>((dir + "/tls.crt").c_str(),
                                                       (dir + "/tls.key").c_str());
    if (!server->is_valid()) {
      return absl::FailedPreconditionError(dir + ": tls.crt and tls.key can't be used for HTTPS");
    }
    http_ = std::move(server);
    return absl::OkStatus();
  }

  bool IsAllowed(const httplib::Request& request) const {
    if (token_.empty()) return true;
    const std::string given = request.get_header_value("Authorization");
    std::string token;
    if (given.rfind("Bearer ", 0) == 0) {
      token = given.substr(7);
    } else if (given.rfind("Basic ", 0) == 0) {
      const std::string pair = DecodeBase64(given.substr(6));
      token = pair.substr(std::min(pair.size(), pair.find(':') + 1));
    }
    // Of equal length digests: how long the comparison takes tells nothing.
    const Sha256Digest ours = Sha256Of(token_), theirs = Sha256Of(token);
    unsigned difference = 0;
    for (size_t i = 0; i < ours.size(); ++i) difference |= ours[i] ^ theirs[i];
    return difference == 0;
  }

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
    http_->set_default_headers(
        {{"X-Content-Type-Options", "nosniff"},
         {"Cache-Control", "no-store"},
         {"Content-Security-Policy", "default-src 'none'; style-src 'unsafe-inline'"}});
    http_->set_pre_routing_handler([this](const Request& request, Response& response) {
      if (request.path == "/healthz" || IsAllowed(request)) {
        return httplib::Server::HandlerResponse::Unhandled;
      }
      response.status = 401;
      response.set_header("WWW-Authenticate", "Basic realm=\"parallax: any name, the token\"");
      response.set_content("the token of the coordinator's http.token is needed\n", "text/plain");
      return httplib::Server::HandlerResponse::Handled;
    });
    http_->Get("/healthz", [this](const Request& request, Response& response) {
      Health(response, IsAllowed(request));
    });
    http_->Get("/metrics", [this](const Request&, Response& response) {
      Answer(response, "text/plain; version=0.0.4; charset=utf-8", MetricsText);
    });
    http_->Get("/", [this](const Request&, Response& response) {
      Answer(response, "text/html; charset=utf-8", StatusPage);
    });
  }

  // Healthy: the database answers.
  void Health(httplib::Response& response, bool in_full) {
    const absl::Status status = queue_.ListStudies(1).status();
    if (!in_full) {
      response.status = status.ok() ? 200 : 503;
      response.set_content(status.ok() ? "{\"status\":\"ok\"}\n" : "{\"status\":\"failing\"}\n",
                           "application/json");
      return;
    }
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

  double Uptime() const { return SecondsBetween(started_, options_.clock->Steady()); }

  absl::StatusOr<StatusSnapshot> TakeSnapshot() {
    std::lock_guard lock(snapshot_mu_);
    const SteadyTime now = options_.clock->Steady();
    if (has_snapshot_ && SecondsBetween(snapshot_at_, now) < kSnapshotAge_s) return snapshot_;
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
    ASSIGN_OR_RETURN(fresh.running, queue_.ListRunning());
    int64_t pairs = 0;
    for (const v1::StudyStatus& study : fresh.studies) pairs += CountPairs(study).done;
    rate_.Add(fresh.uptime_s, static_cast<double>(pairs));
    fresh.pairs_per_hour = 3600 * rate_.PerSecond().value_or(0);
    NoteEtas(fresh);
    snapshot_ = std::move(fresh);
    snapshot_at_ = now;
    has_snapshot_ = true;
    return snapshot_;
  }

  // Requires snapshot_mu_.
  void NoteEtas(StatusSnapshot& fresh) {
    std::map<int64_t, RateEstimator> rates;
    for (const v1::StudyStatus& study : fresh.studies) {
      if (study.state() != v1::STUDY_STATE_RUNNING) continue;
      RateEstimator& rate = rates.emplace(study.study_id(), kRateWindow_s).first->second;
      if (const auto known = study_rates_.find(study.study_id()); known != study_rates_.end()) {
        rate = std::move(known->second);
      }
      const PairCount pairs = CountPairs(study);
      rate.Add(fresh.uptime_s, static_cast<double>(pairs.done));
      // The time that trainings take is unknown.
      if (pairs.done >= pairs.wanted) continue;
      const auto eta_s = rate.SecondsFor(static_cast<double>(pairs.wanted - pairs.done));
      if (eta_s) fresh.eta_s[study.study_id()] = *eta_s;
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
  std::unique_ptr<httplib::Server> http_ = std::make_unique<httplib::Server>();
  std::string token_;  // Empty: not asked for.
  std::thread serving_;
  std::thread sampling_;
  std::atomic<bool> serving_ended_ = false;

  std::mutex mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mu_.

  std::mutex snapshot_mu_;
  // Guarded by snapshot_mu_.
  RateEstimator rate_;
  std::map<int64_t, RateEstimator> study_rates_;  // By running study.
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
