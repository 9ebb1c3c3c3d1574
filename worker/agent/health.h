// The health service of gRPC (grpc.health.v1), which Kubernetes and grpc_health_probe ask. It has
// two services: `alive` says that the agent's own loop runs, `ready` that the coordinator has
// welcomed the worker and it takes work. A request without a name means `alive`.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"

namespace parallax {

// The agent's state as probes see it.
struct WorkerHealth {
  double since_look_s = 0;  // Seconds since the agent's loop last ran.
  bool ready = false;
};

// Serves until it is destroyed. Unencrypted; reveals only those two states.
class HealthServer {
 public:
  // Starts to serve on `address`: HOST:PORT (port 0: any free one) or unix:/path. `ask` is called
  // twice a second on another thread. Errors: kInvalidArgument for a malformed address;
  // kUnavailable when the server can't listen on it.
  static absl::StatusOr<std::unique_ptr<HealthServer>> Start(const std::string& address,
                                                             std::function<WorkerHealth()> ask);
  virtual ~HealthServer() = default;

  virtual int port() const = 0;  // 0 for unix:/path.
};

}  // namespace parallax
