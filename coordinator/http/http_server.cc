#include "coordinator/http/http_server.h"

#include <fmt/core.h>

#include <atomic>
#include <regex>

#include "common/base/hash.h"
#include "common/base/names.h"
#include "common/base/system/file.h"
#include "common/base/system/secret.h"
#include "common/rpc/revocation.h"
#include "coordinator/http/api.h"
#include "coordinator/http/api_json.h"
#include "coordinator/http/page_replies.h"
#include "coordinator/http/server/credentials.h"
#include "coordinator/http/server/peer.h"
#include "coordinator/http/server/web_server.h"
#include "coordinator/queue/job_queue.h"
#include "coordinator/rpc/workers/steering.h"

namespace parallax {
namespace {

constexpr int kMostStreams = 32;
constexpr size_t kShortestToken = 16;
constexpr double kCodeValid_s = 86400;
// Streams of events look this often whether something is new, and say so much later that they live.
constexpr double kEventEvery_s = 2;
constexpr double kBeatEvery_s = 15;
constexpr char kCsrfHeader[] = "x-parallax-csrf";  // In lower case, as ServerRequest has it.
constexpr std::string_view kHealthPath = "/healthz";

class HttpServerImpl final : public HttpServer {
 public:
  HttpServerImpl(const HttpServerOptions& options, JobQueue& queue, const CoordinatorServer& server)
      : options_(options),
        queue_(queue),
        server_(server),
        sampler_(options.store_uri, *options.clock, queue, server, options.space),
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
    if (options_.security.tls != nullptr) {
      const std::string list = options_.revoked.empty()
                                   ? options_.security.tls->dir + "/" + kRevokedFile
                                   : options_.revoked;
      ASSIGN_OR_RETURN(revoked_, RevokedCertificates::Open(list, *options_.clock));
    }
    ASSIGN_OR_RETURN(csrf_secret_, NewSecret());
    ASSIGN_OR_RETURN(reader_, PageReader::Open(options_.db_path, queue_.kinds()));
    ASSIGN_OR_RETURN(http_, WebServer::Bind(ServerOptions()));
    address_ = http_->address();
    parts_.emplace(ApiParts{queue_, server_, sampler_, *reader_, pictures_, sessions_, token_,
                            fmt::format("parallax_{}", address_.port), is_tls_, options_.table,
                            options_.picture});
    routes_ = ApiRoutes(*parts_);
    for (const WebRoute& route : routes_) patterns_.emplace_back(route.pattern);
    http_->Start([this](const ServerRequest& request) { return Answer(request); },
                 [](std::string_view path) { return path == kHealthPath; });
    sampler_.Start();
    return absl::OkStatus();
  }

  std::string address() const override { return address_.ToString(); }
  std::string url() const override {
    return (is_tls_ ? "https://" : "http://") + address_.ToString() + "/";
  }
  absl::StatusOr<std::string> link_url(const RpcCaller& caller) override {
    ASSIGN_OR_RETURN(const std::string code, sessions_.NewCode(caller, kCodeValid_s));
    return url() + "#code=" + code;
  }

  void Stop() override {
    if (http_ != nullptr) http_->Stop();
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
    is_tls_ = true;
    return absl::OkStatus();
  }

  WebServerOptions ServerOptions() const {
    WebServerOptions options;
    options.listen = address_;
    options.limits.connections = options_.limits;
    options.limits.reply_bytes = options_.reply_bytes;
    if (is_tls_) {
      options.tls = [dir = options_.security.tls->dir](ssl_ctx_st& context) {
        return SetUpTls(dir, context);
      };
    }
    options.headers = PageHeaders();
    return options;
  }

  // ---- Who asks
  // Whether callers need no credentials. They may do everything, or only read in a farm with
  // certificates.
  bool IsOpen() const { return token_.empty() && !options_.by_link_only; }

  std::optional<WebCaller> Identify(const ServerRequest& request) {
    WebCaller caller;
    const std::string from = (is_tls_ ? "https:" : "http:") + request.from;
    const std::string session = CookieIn(request.Header("cookie"), parts_->cookie);
    if (const auto certified = CallerOf(request.tls)) {
      caller.rpc = *certified;
    } else if (const auto known = sessions_.Find(session)) {
      caller.rpc = *known;
      caller.session = session;
    } else if (!token_.empty() && SameSecret(TokenIn(request.Header("authorization")), token_)) {
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

  // Errors: kPermissionDenied for a name that isn't this server's: another site's page may have
  // brought a browser here by it (DNS rebinding). Nobody can do that with an address, nor, over
  // TLS, with a name that the certificate has.
  absl::Status CheckHost(const ServerRequest& request) const {
    const std::string header = request.Header("host");
    const std::optional<std::string> host = HostIn(header);
    if (!host) return PermissionDenied("the header Host is no HOST or HOST:PORT");
    if (is_tls_) {
      if (IsIpAddress(*host) || IsNameOf(options_.security.tls->own.certificate_pem, *host)) {
        return absl::OkStatus();
      }
      return PermissionDenied(
          "this port is for its address and the names in its certificate (`coordinator init DIR "
          "--renew server --host NAME` adds one)");
    }
    if (address_.is_local()) {
      if (IsLoopbackHost(*host)) return absl::OkStatus();
      return PermissionDenied("this port is for names of this machine only");
    }
    if (IsIpAddress(*host) || IsOwnName(*host) || *host == address_.host) return absl::OkStatus();
    return PermissionDenied(
        "without TLS, this port is for its address, this machine's name and names without a dot");
  }

  // Errors: kPermissionDenied for a request that another site's page may have caused.
  absl::Status CheckOrigin(const WebRoute& route, const ServerRequest& request,
                           const std::optional<WebCaller>& caller) const {
    if (std::string_view(route.method) != "POST") return absl::OkStatus();
    const std::string site = request.Header("sec-fetch-site");
    if (!site.empty() && site != "same-origin") {
      return PermissionDenied("a page of another site may change nothing here");
    }
    if (route.access == WebAccess::kAnybody) return absl::OkStatus();
    if (SameSecret(request.Header(kCsrfHeader), caller->csrf)) return absl::OkStatus();
    return PermissionDenied("the header X-Parallax-Csrf must say what /api/v1/me calls csrf");
  }

  // ---- Routes
  // Strangers come no further than to what is open to anybody, also on paths that are no route.
  ServerReply Answer(const ServerRequest& request) {
    if (const absl::Status status = CheckHost(request); !status.ok()) {
      return ErrorFor(status, request);
    }
    if (const auto file = PageFileReply(request)) return *file;
    const std::optional<WebCaller> caller = Identify(request);
    std::smatch match;
    for (size_t i = 0; i < routes_.size(); ++i) {
      if (request.method == routes_[i].method &&
          std::regex_match(request.path, match, patterns_[i])) {
        return Serve(routes_[i], match, request, caller);
      }
    }
    absl::Status status =
        CheckWebAccess({.access = WebAccess::kKnown}, caller ? &*caller : nullptr);
    if (status.ok()) status = NotFound("there is no {}", Quoted(request.path));
    return ErrorFor(status, request);
  }

  ServerReply Serve(const WebRoute& route, const std::smatch& match, const ServerRequest& request,
                    const std::optional<WebCaller>& caller) {
    absl::Status status = CheckWebAccess(route, caller ? &*caller : nullptr);
    if (status.ok()) status = CheckOrigin(route, request, caller);
    // Who asks for health keeps no place from others, and needs none.
    if (status.ok() && caller && route.access != WebAccess::kAnybody && !request.know()) {
      status = Unavailable("too many are connected; try again");
    }
    if (!status.ok()) return ErrorFor(status, request);
    if (route.events) return Events(*caller, request);
    WebRequest asked;
    for (size_t i = 1; i < match.size(); ++i) asked.parts.push_back(match[i]);
    asked.query = request.query;
    asked.body = request.body;
    asked.if_none_match = request.Header("if-none-match");
    asked.reserve = request.reserve;
    if (caller) asked.caller = *caller;
    absl::StatusOr<WebReply> reply = route.handler(asked);
    if (!reply.ok()) return ErrorFor(reply.status(), request);
    return {.reply = *std::move(reply)};
  }

  // Programs that scrape know passwords; the page asks for itself.
  static ServerReply ErrorFor(const absl::Status& status, const ServerRequest& request) {
    ServerReply reply{.reply = ErrorReply(status)};
    if (absl::IsUnauthenticated(status) && request.path.rfind("/api/", 0) != 0) {
      reply.reply.headers.emplace_back("WWW-Authenticate",
                                       "Basic realm=\"parallax: any name, the token\"");
    }
    return reply;
  }

  // ---- Events
  // "farm" with what /api/v1/farm says, whenever it says something else; ends with the session, and
  // when the caller's certificate is revoked.
  ServerReply Events(const WebCaller& caller, const ServerRequest& request) {
    // The stream's place, for as long as somebody has a copy.
    const std::shared_ptr<void> place(nullptr, [this](void*) { streams_.fetch_sub(1); });
    if (streams_.fetch_add(1) >= kMostStreams) {
      return ErrorFor(Unavailable("too many watch already; ask now and then"), request);
    }
    struct State {
      std::string last;
      double silent_s = 0;
    };
    ServerReply reply;
    reply.every_s = kEventEvery_s;
    reply.events = [this, session = caller.session, sha256 = caller.rpc.sha256, place,
                    state = std::make_shared<State>()]() -> std::optional<std::string> {
      if (!session.empty() && !sessions_.Find(session)) return std::nullopt;
      if (revoked_ != nullptr && revoked_->Contains(sha256)) return std::nullopt;
      return EventText(state->last, state->silent_s);
    };
    return reply;
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
  std::vector<WebRoute> routes_;      // Constant once it serves.
  std::vector<std::regex> patterns_;  // The patterns of routes_, in their order.
  std::atomic<int> streams_ = 0;
  std::unique_ptr<WebServer> http_;  // Last: it stops before what its handlers use goes.
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
