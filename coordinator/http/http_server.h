// The coordinator's HTTP side, read-only: /healthz (JSON), /metrics (Prometheus), / (status page).
#pragma once

#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/base/status.h"

namespace parallax {

class CoordinatorServer;
class JobQueue;

struct HttpServerOptions {
  std::string listen;     // "HOST:PORT", port 0 for any free one.
  bool insecure = false;  // Allow other addresses than loopback.
  std::string store_uri;  // Shown.
  Clock* clock = &Clock::System();
};

// Thread-safe.
class HttpServer {
 public:
  // `queue` and `server` outlive it. Errors: kAlreadyExists for an address in use, named in the
  // message; kFailedPrecondition for one of another machine without `insecure`; kInvalidArgument;
  // those of the socket.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const HttpServerOptions& options,
                                                           JobQueue& queue,
                                                           const CoordinatorServer& server);
  virtual ~HttpServer() = default;  // Stops.

  virtual std::string address() const = 0;  // "HOST:PORT"
  virtual void Stop() = 0;                  // Idempotent.
};

}  // namespace parallax
