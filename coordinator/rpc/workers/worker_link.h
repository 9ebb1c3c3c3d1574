// The interface of a worker's stream for the dispatcher.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// Thread-safe. Calls don't block, and don't call back into the dispatcher on the same stack.
class WorkerLink {
 public:
  virtual ~WorkerLink() = default;
  // Queues a message for the worker; does nothing after the stream has ended.
  virtual void Send(v1::CoordinatorMessage message) = 0;
  // Ends the stream with `status`. With `abort`, does not wait for the peer, which does not answer.
  virtual void Close(const absl::Status& status, bool abort) = 0;
};

}  // namespace parallax
