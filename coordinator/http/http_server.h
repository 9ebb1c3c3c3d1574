// The coordinator's HTTP side, read-only: /healthz (JSON), /metrics (Prometheus), / (status page).
//
// Plain on loopback. On other addresses HTTPS with the coordinator's certificate, and everything
// but a bare /healthz needs the token in its TLS folder: "Authorization: Bearer TOKEN", or a
// browser's password prompt (any name).
#pragma once

#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

class CoordinatorServer;
class JobQueue;

struct HttpServerOptions {
  std::string listen;     // "HOST:PORT", port 0 for any free one.
  RpcSecurity security;   // Other addresses than loopback need TLS or `insecure`.
  std::string store_uri;  // Shown.
  Clock* clock = &Clock::System();
};

// Thread-safe.
class HttpServer {
 public:
  // `queue` and `server` outlive it. Errors: kAlreadyExists for an address in use, named in the
  // message; kFailedPrecondition for one of another machine without TLS, token or `insecure`;
  // kInvalidArgument;
  // those of the socket.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const HttpServerOptions& options,
                                                           JobQueue& queue,
                                                           const CoordinatorServer& server);
  virtual ~HttpServer() = default;  // Stops.

  virtual std::string address() const = 0;  // "HOST:PORT"
  virtual std::string url() const = 0;      // "http://HOST:PORT/", "https://..."
  virtual void Stop() = 0;                  // Idempotent.
};

}  // namespace parallax
