// The health service of gRPC (grpc.health.v1), which Kubernetes and grpc_health_probe ask. It has
// two services: `alive` says that the agent's own loop goes round, `ready` that the coordinator has
// welcomed the worker and it takes work. A request without a name means `alive`.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/base/status.h"

namespace parallax {

struct WorkerHealth {
  double since_look_s = 0;  // Since the agent's loop last went round.
  bool ready = false;
};

// Answers until it is destroyed. Unencrypted, and tells nothing but those two states.
class HealthServer {
 public:
  // `address`: HOST:PORT (port 0: any that is free) or unix:/path. `ask` is called twice a second
  // by another thread. Errors: kInvalidArgument for an address that is none; kUnavailable when it
  // can't be listened on.
  static absl::StatusOr<std::unique_ptr<HealthServer>> Start(const std::string& address,
                                                             std::function<WorkerHealth()> ask);
  virtual ~HealthServer() = default;

  virtual int port() const = 0;  // 0 for unix:/path.
};

}  // namespace parallax
