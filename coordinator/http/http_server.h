// The coordinator's HTTP side: /healthz (JSON), /metrics (Prometheus), the page at / and its API
// under /api/v1.
//
// Plain on loopback. On other addresses HTTPS with the coordinator's certificate. Who may do what
// is as for the RPCs (coordinator/rpc/access.h): a client certificate carries its role; the token
// in the TLS folder ("Authorization: Bearer TOKEN", or typed into the page) may look; on loopback
// whoever reaches the port may look in a farm with certificates, and do everything in one without.
// Strangers get the page's own files and a bare /healthz, nothing else. A request that changes
// something needs the CSRF header, and the page's policy lets no script run but its own files.
#pragma once

#include <memory>
#include <string>

#include "common/base/clock.h"
#include "common/base/status.h"
#include "common/rpc/endpoint.h"

namespace parallax {

class CoordinatorServer;
class JobQueue;
class Store;

struct HttpServerOptions {
  std::string listen;            // "HOST:PORT", port 0 for any free one.
  RpcSecurity security;          // Other addresses than loopback need TLS or `insecure`.
  std::string store_uri;         // Shown.
  std::string db_path;           // Of the queue: the page reads from connections of its own.
  const Store* store = nullptr;  // Of the pictures; null: none are shown. Outlives the server.
  // Nobody may do anything, whatever the address, but who opens link_url(): for a port of a
  // machine that others use too.
  bool by_link_only = false;
  Clock* clock = &Clock::System();
};

// Thread-safe.
class HttpServer {
 public:
  // `queue` and `server` outlive it. Errors: kAlreadyExists for an address in use, named in the
  // message; kFailedPrecondition for one of another machine without TLS, token or `insecure`;
  // kInvalidArgument; those of the socket and the database.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const HttpServerOptions& options,
                                                           JobQueue& queue,
                                                           const CoordinatorServer& server);
  virtual ~HttpServer() = default;  // Stops.

  virtual std::string address() const = 0;  // "HOST:PORT"
  virtual std::string url() const = 0;      // "http://HOST:PORT/", "https://..."
  // The page's address with a code that opens one session with every right, once, within a day.
  // Errors: kInternal when the system has no random numbers.
  virtual absl::StatusOr<std::string> link_url() = 0;
  virtual void Stop() = 0;  // Idempotent.
};

}  // namespace parallax
