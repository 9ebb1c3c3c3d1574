#include "coordinator/http/http_server.h"

#include <fmt/core.h>
#include <httplib.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "common/base/hash.h"
#include "common/base/seconds.h"
#include "common/base/system/file.h"
#include "common/base/system/secret.h"
#include "common/rpc/revocation.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/http/credentials.h"
#include "coordinator/http/page_files.h"
#include "coordinator/http/peer.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/workers/steering.h"

namespace parallax {
namespace {

using httplib::Request;
using httplib::Response;
using Handled = httplib::Server::HandlerResponse;

// A browser keeps up to six connections, and each holds a thread for as long as it lasts.
constexpr int kThreads = 64;
constexpr int kMostStreams = 32;
constexpr int kKeepAlive_s = 3;
constexpr size_t kShortestToken = 16;
constexpr double kCodeValid_s = 86400;
// Streams of events look this often whether something is new, and say so much later that they live.
constexpr double kEventEvery_s = 2;
constexpr double kBeatEvery_s = 15;
constexpr char kCsrfHeader[] = "X-Parallax-Csrf";
constexpr char kPolicy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; "
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

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
        sampler_(options.store_uri, *options.clock, queue, server),
        pictures_(options.store),
        sessions_(*options.clock) {}

  ~HttpServerImpl() override { Stop(); }

  absl::Status Listen() {
    ASSIGN_OR_RETURN(address_, ParseRpcAddress(options_.listen));
    if (address_.is_unix()) {
      return InvalidArgument("HTTP listens on HOST:PORT, not on {}", options_.listen);
    }
    RETURN_IF_ERROR(CheckRpcSecurity(address_, options_.security));
    if (!address_.is_local() && options_.security.tls != nullptr) RETURN_IF_ERROR(UseTls());
    if (is_tls_) {
      const std::string list = options_.revoked.empty()
                                   ? options_.security.tls->dir + "/" + kRevokedFile
                                   : options_.revoked;
      ASSIGN_OR_RETURN(revoked_, RevokedCertificates::Open(list, *options_.clock));
    }
    ASSIGN_OR_RETURN(csrf_secret_, NewSecret());
    ASSIGN_OR_RETURN(reader_, PageReader::Open(options_.db_path, queue_.kinds()));
    http_->set_socket_options(SetSocketOptions);
    http_->set_payload_max_length(8192);
    http_->set_read_timeout(5, 0);
    http_->set_write_timeout(5, 0);
    http_->set_keep_alive_timeout(kKeepAlive_s);
    http_->set_keep_alive_max_count(1000);
    http_->new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
    errno = 0;
    if (address_.port == 0) {
      address_.port = http_->bind_to_any_port(address_.host);
      if (address_.port <= 0) return BindError();
    } else if (!http_->bind_to_port(address_.host, address_.port)) {
      return BindError();
    }
    Route();
    serving_ = std::thread([this] {
      http_->listen_after_bind();
      serving_ended_ = true;
    });
    sampler_.Start();
    return absl::OkStatus();
  }

  std::string address() const override { return address_.ToString(); }
  std::string url() const override {
    return (is_tls_ ? "https://" : "http://") + address_.ToString() + "/";
  }
  absl::StatusOr<std::string> link_url() override {
    ASSIGN_OR_RETURN(const std::string code, sessions_.NewCode(RpcCaller(), kCodeValid_s));
    return url() + "#code=" + code;
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
    sampler_.Stop();
  }

 private:
  absl::Status UseTls() {
    const std::string& dir = options_.security.tls->dir;
    const auto token = ReadFile(dir + "/http.token", 4096);
    if (!token.ok()) {
      return FailedPrecondition(
          "{}; the page on another address than loopback needs a token there, as `coordinator "
          "init` makes it",
          token.status().message());
    }
    token_ = token->substr(0, token->find_last_not_of(" \r\n") + 1);
    if (token_.size() < kShortestToken) {
      return FailedPrecondition("{}/http.token: shorter than {} characters", dir, kShortestToken);
    }
    auto server = std::make_unique<httplib::SSLServer>(
        [&dir](SSL_CTX& context) { return SetUpTls(dir, context); });
    if (!server->is_valid()) {
      return FailedPrecondition("{}: tls.crt and tls.key can't be used for HTTPS", dir);
    }
    http_ = std::move(server);
    is_tls_ = true;
    return absl::OkStatus();
  }

  absl::Status BindError() const {
    const int error = errno;
    const std::string what = "cannot listen on http " + options_.listen;
    if (error == EADDRINUSE) return AlreadyExists("{}: address already in use", what);
    if (error == 0) return NotFound("{}: no such address on this machine", what);
    return ErrnoError(error, what);
  }

  // ---- Who asks
  // Whether everybody who reaches the port is known: may do everything, or, in a farm with
  // certificates, look.
  bool IsOpen() const { return token_.empty() && !options_.by_link_only; }

  std::optional<WebCaller> Identify(const Request& request) {
    WebCaller caller;
    const std::string from = (is_tls_ ? "https:" : "http:") + request.remote_addr;
    const std::string session = CookieIn(request.get_header_value("Cookie"), parts_->cookie);
    if (const auto certified = CallerOf(request.ssl)) {
      caller.rpc = *certified;
    } else if (const auto known = sessions_.Find(session)) {
      caller.rpc = *known;
      caller.session = session;
    } else if (!token_.empty() &&
               SameSecret(TokenIn(request.get_header_value("Authorization")), token_)) {
      caller.rpc = TokenCaller();
    } else if (!IsOpen()) {
      return std::nullopt;
    } else if (options_.security.tls != nullptr) {
      caller.rpc = MachineCaller();
    }
    if (revoked_ != nullptr && revoked_->Contains(caller.rpc.sha256)) return std::nullopt;
    caller.actor = caller.rpc.has_certificate ? ActorName(caller.rpc) + " " + from : from;
    caller.csrf = Sha256Hex(csrf_secret_ + "\n" + caller.session + "\n" + caller.rpc.name);
    return caller;
  }

  // Errors: kPermissionDenied for a request that another site's page may have caused.
  absl::Status CheckOrigin(const WebRoute& route, const Request& request,
                           const std::optional<WebCaller>& caller) const {
    if (std::string_view(route.method) != "POST") return absl::OkStatus();
    const std::string site = request.get_header_value("Sec-Fetch-Site");
    if (!site.empty() && site != "same-origin") {
      return PermissionDenied("a page of another site may change nothing here");
    }
    if (route.access == WebAccess::kAnybody) return absl::OkStatus();
    if (SameSecret(request.get_header_value(kCsrfHeader), caller->csrf)) return absl::OkStatus();
    return PermissionDenied("the header {} must say what /api/v1/me calls csrf", kCsrfHeader);
  }

  // ---- Routes
  void Route() {
    parts_.emplace(ApiParts{queue_, server_, sampler_, *reader_, pictures_, sessions_, token_,
                            fmt::format("parallax_{}", address_.port), is_tls_});
    routes_ = ApiRoutes(*parts_);
    http_->set_default_headers({{"X-Content-Type-Options", "nosniff"},
                                {"Referrer-Policy", "no-referrer"},
                                {"Cross-Origin-Resource-Policy", "same-origin"},
                                {"Content-Security-Policy", kPolicy}});
    http_->set_pre_routing_handler(
        [this](const Request& request, Response& response) { return Gate(request, response); });
    for (const PageFile& file : PageFiles()) {
      http_->Get(std::string(file.path), [&file](const Request& request, Response& response) {
        response.set_header("Cache-Control", "no-cache");
        response.set_header("ETag", std::string(file.etag));
        if (request.get_header_value("If-None-Match") == file.etag) {
          response.status = 304;
          return;
        }
        response.set_content(file.bytes.data(), file.bytes.size(), std::string(file.type));
      });
    }
    for (const WebRoute& route : routes_) {
      const auto handler = [this, &route](const Request& request, Response& response) {
        Serve(route, request, response);
      };
      if (std::string_view(route.method) == "POST") {
        http_->Post(route.pattern, handler);
      } else {
        http_->Get(route.pattern, handler);
      }
    }
  }

  // Strangers come no further than to what is open to anybody, also on paths that are no route.
  Handled Gate(const Request& request, Response& response) {
    if (!is_tls_ && address_.is_local() && !IsLoopbackHost(request.get_header_value("Host"))) {
      Send(ErrorReply(PermissionDenied("this port is for names of this machine only")), response);
      return Handled::Handled;
    }
    const bool open =
        std::any_of(PageFiles().begin(), PageFiles().end(),
                    [&](const PageFile& file) { return file.path == request.path; }) ||
        std::any_of(routes_.begin(), routes_.end(), [&](const WebRoute& route) {
          return route.access == WebAccess::kAnybody && route.example == request.path;
        });
    if (open || Identify(request)) return Handled::Unhandled;
    SendError(CheckWebAccess({.access = WebAccess::kKnown}, nullptr), request, response);
    return Handled::Handled;
  }

  void Serve(const WebRoute& route, const Request& request, Response& response) {
    const std::optional<WebCaller> caller = Identify(request);
    absl::Status status = CheckWebAccess(route, caller ? &*caller : nullptr);
    if (status.ok()) status = CheckOrigin(route, request, caller);
    if (!status.ok()) return SendError(status, request, response);
    if (route.events) return Stream(caller->session, response);
    WebRequest asked;
    for (size_t i = 1; i < request.matches.size(); ++i) asked.parts.push_back(request.matches[i]);
    for (const auto& [name, value] : request.params) asked.query[name] = value;
    asked.body = request.body;
    asked.if_none_match = request.get_header_value("If-None-Match");
    if (caller) asked.caller = *caller;
    const absl::StatusOr<WebReply> reply = route.handler(asked);
    if (!reply.ok()) return SendError(reply.status(), request, response);
    Send(*reply, response);
  }

  static void Send(const WebReply& reply, Response& response) {
    response.status = reply.status;
    bool cached = false;
    for (const auto& [name, value] : reply.headers) {
      response.set_header(name, value);
      cached |= name == "Cache-Control";
    }
    if (!cached) response.set_header("Cache-Control", "no-store");
    response.set_content(reply.body, reply.type);
  }

  // Programs that scrape know passwords; the page asks for itself.
  static void SendError(const absl::Status& status, const Request& request, Response& response) {
    if (absl::IsUnauthenticated(status) && request.path.rfind("/api/", 0) != 0) {
      response.set_header("WWW-Authenticate", "Basic realm=\"parallax: any name, the token\"");
    }
    Send(ErrorReply(status), response);
  }

  // ---- Events
  // "farm" with what /api/v1/farm says, whenever it says something else; ends with the session.
  void Stream(const std::string& session, Response& response) {
    if (streams_.fetch_add(1) >= kMostStreams) {
      streams_.fetch_sub(1);
      return Send(ErrorReply(Unavailable("too many watch already; ask now and then")), response);
    }
    response.set_header("Cache-Control", "no-store");
    struct State {
      std::string last;
      double silent_s = 0;
    };
    response.set_chunked_content_provider(
        "text/event-stream",
        [this, session, state = std::make_shared<State>()](size_t, httplib::DataSink& sink) {
          const bool is_first = state->last.empty();
          if ((!is_first && WaitForStop(kEventEvery_s)) || IsStopping() ||
              (!session.empty() && !sessions_.Find(session))) {
            sink.done();
            return true;
          }
          const std::string text = EventText(state->last, state->silent_s);
          return text.empty() || sink.write(text.data(), text.size());
        },
        [this](bool) { streams_.fetch_sub(1); });
  }

  std::string EventText(std::string& last, double& silent_s) {
    const auto snapshot = sampler_.Take();
    if (snapshot.ok()) {
      Json farm = FarmJson(**snapshot);
      Json still = farm;
      still.erase("uptime_s");
      still.erase("now_unix_s");
      std::string text = JsonText(still);
      if (text != last) {
        last = std::move(text);
        silent_s = 0;
        return "event: farm\ndata: " + JsonText(farm) + "\n";
      }
    }
    silent_s += kEventEvery_s;
    if (silent_s < kBeatEvery_s) return "";
    silent_s = 0;
    return ": still here\n\n";
  }

  bool IsStopping() {
    std::lock_guard lock(mu_);
    return stopping_;
  }
  bool WaitForStop(double seconds) {
    std::unique_lock lock(mu_);
    return stop_.wait_for(lock, std::chrono::duration<double>(seconds),
                          [this] { return stopping_; });
  }

  const HttpServerOptions options_;
  JobQueue& queue_;
  const CoordinatorServer& server_;
  RpcAddress address_;
  bool is_tls_ = false;
  std::string token_;                             // Empty: none is known.
  std::unique_ptr<RevokedCertificates> revoked_;  // Present where callers have certificates.
  std::string csrf_secret_;
  StatusSampler sampler_;
  Pictures pictures_;
  Sessions sessions_;
  std::unique_ptr<PageReader> reader_;
  std::optional<ApiParts> parts_;
  std::vector<WebRoute> routes_;  // Constant once it serves.
  std::unique_ptr<httplib::Server> http_ = std::make_unique<httplib::Server>();
  std::thread serving_;
  std::atomic<bool> serving_ended_ = false;
  std::atomic<int> streams_ = 0;

  std::mutex mu_;
  std::condition_variable stop_;
  bool stopping_ = false;  // Guarded by mu_.
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
