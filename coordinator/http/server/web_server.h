// An HTTP/1.1 server that strangers can't fill. The only home of Boost.Beast.
//
// - Connections are bounded, in total and by address, and a newcomer gets a place (see
//   common/rpc/listener.h). A connection counts as known only while a request of a known caller is
//   answered.
// - Memory: a request has at most kMostHeaderBytes of headers and kMostBodyBytes of body, however
//   it is sent. More is refused: 431, 413. All replies together have WebServerLimits::reply_bytes.
// - Time: TLS, a whole request and a whole reply each have a time, however the bytes come.
// - Handlers run on a few threads. Urgent requests have a thread of their own.
// - Ranges are not served: a reply is the whole.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/status.h"
#include "common/rpc/address.h"
#include "common/rpc/listener.h"
#include "coordinator/http/web.h"

struct ssl_st;
struct ssl_ctx_st;

namespace parallax {

inline constexpr size_t kMostHeaderBytes = 16 << 10;
inline constexpr size_t kMostBodyBytes = 8 << 10;
inline constexpr size_t kMostTargetBytes = 2 << 10;

// A request as it came.
struct ServerRequest {
  std::string method;  // "GET", also in place of "HEAD", or "POST".
  std::string path;    // Decoded, without the query.
  std::map<std::string, std::string> query;
  std::map<std::string, std::string> headers;  // Names in lower case; the first of each.
  std::string body;
  std::string from;             // The peer's address, without port.
  const ssl_st* tls = nullptr;  // The connection, while the handler runs; null without TLS.
  std::function<bool()> know;   // Says that the caller is known. False: too many are already.
  // Says that the reply will have so many bytes, before they are read. Errors: kUnavailable if all
  // replies have too many.
  std::function<absl::Status(int64_t bytes)> reserve;

  // Returns a header's value; empty if it is absent. `name` is in lower case.
  std::string Header(const std::string& name) const;
};

struct ServerReply {
  WebReply reply;
  // Present: the body is a stream of what this returns every `every_s` seconds, until it returns
  // nothing. It is called on the handlers' threads.
  std::function<std::optional<std::string>()> events;
  double every_s = 2;
};

struct WebServerLimits {
  ListenerLimits connections = {
      .known = 256, .known_an_address = 192, .strangers = 256, .strangers_an_address = 128};
  double handshake_s = 10;
  double request_s = 10;  // From the end of the one before to the end of this one.
  double reply_s = 10;    // Beside the time of its bytes at bytes_per_s.
  double bytes_per_s = 50e3;
  int requests = 1000;  // On one connection.
  // Memory of all replies until they are sent, beside small ones, which the number of connections
  // bounds. More are refused: 503.
  int64_t reply_bytes = 256 << 20;
};

struct WebServerOptions {
  RpcAddress listen;
  // Prepares TLS; returns false if that fails. Null: plain HTTP.
  std::function<bool(ssl_ctx_st&)> tls;
  std::vector<std::pair<std::string, std::string>> headers;  // Every reply has them.
  WebServerLimits limits;
};

// Thread-safe.
class WebServer {
 public:
  using Handler = std::function<ServerReply(const ServerRequest&)>;
  using IsUrgent = std::function<bool(std::string_view path)>;

  // Binds the address; connections wait until Start. Errors: those of Listener::Bind;
  // kFailedPrecondition if TLS can't be prepared.
  static absl::StatusOr<std::unique_ptr<WebServer>> Bind(WebServerOptions options);
  virtual ~WebServer() = default;  // Stops.

  virtual const RpcAddress& address() const = 0;  // With the actual port.
  // Serves. Call it once. `handler` is called from several threads at a time, also for requests
  // that are refused no further than this: it gets every path of well-formed requests by GET, HEAD
  // and POST.
  virtual void Start(Handler handler, IsUrgent is_urgent) = 0;
  // Ends all connections; no handler runs any more when it returns. Idempotent.
  virtual void Stop() = 0;
};

}  // namespace parallax
