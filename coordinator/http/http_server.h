// The coordinator's HTTP server: /healthz (JSON), /metrics (Prometheus), the web page at / and its
// API under /api/v1.
//
// It speaks plain HTTP on loopback, and HTTPS with the coordinator's certificate on other
// addresses. Roles have the same rights as for RPCs (coordinator/rpc/access.h). A client
// certificate carries its role. The token in the TLS folder ("Authorization: Bearer TOKEN", or
// typed into the page) may read. On loopback, any caller may read in a farm with certificates, and
// do everything in a farm without. Strangers only get the page's own files and a bare /healthz. A
// request that changes something needs the CSRF header, and the page's content policy runs no
// scripts but its own files. A request by a name that another site may have pointed here is
// refused.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"
#include "common/base/system/clock.h"
#include "common/rpc/endpoint.h"
#include "coordinator/http/server/web_server.h"
#include "coordinator/rpc/storage/farm_space.h"
#include "parallax/v1/search.pb.h"

namespace parallax {

class CoordinatorServer;
class JobQueue;
class Store;

struct HttpServerOptions {
  std::string listen;    // "HOST:PORT", port 0 for any free one.
  RpcSecurity security;  // Other addresses than loopback need TLS or `insecure`.
  // List of revoked certificates (common/rpc/revocation.h); empty: kRevokedFile in security.tls.
  std::string revoked;
  std::string store_uri;         // Shown on the page.
  std::string db_path;           // The queue's database: the page has its own connections to it.
  const Store* store = nullptr;  // Has the pictures; null: none are shown. Must outlive the server.
  // Gives rights only to callers that opened link_url(), whatever the address: for a port of a
  // machine that other people use too.
  bool by_link_only = false;
  ListenerLimits limits = WebServerLimits().connections;
  int64_t reply_bytes = WebServerLimits().reply_bytes;
  // Returns a study's table of results, as JSON {"text", "table"}; null: the page shows none.
  std::function<absl::StatusOr<std::string>(int64_t study)> table;
  // Draws a search as SVG; null: the page shows no picture.
  std::function<std::string(const v1::SearchStatus&)> picture;
  // Returns the room on the farm's disks, for /metrics; null: not known.
  std::function<FarmSpace()> space;
  Clock* clock = &Clock::System();
};

// Thread-safe.
class HttpServer {
 public:
  // Starts to serve. `queue` and `server` must outlive it. Errors: kAlreadyExists for an address in
  // use, named in the message; kFailedPrecondition for an address that other machines reach without
  // TLS, token or `insecure`; kInvalidArgument for a bad address; those of the socket and database.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Start(const HttpServerOptions& options,
                                                           JobQueue& queue,
                                                           const CoordinatorServer& server);
  virtual ~HttpServer() = default;  // Stops.

  virtual std::string address() const = 0;  // "HOST:PORT"
  virtual std::string url() const = 0;      // "http://HOST:PORT/", "https://..."
  // Returns the page's address with a code that opens one session of `caller`; one without a
  // certificate has every right. The code works once, within a day. Errors: kInternal if the system
  // has no random numbers.
  virtual absl::StatusOr<std::string> link_url(const RpcCaller& caller = RpcCaller()) = 0;
  virtual void Stop() = 0;  // Idempotent.
};

}  // namespace parallax
