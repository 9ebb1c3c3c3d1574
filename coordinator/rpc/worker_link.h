// A worker's stream, as the dispatcher sees it.
#pragma once

#include "common/base/status.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

// Thread-safe. No call blocks or calls back into the dispatcher on the same stack.
class WorkerLink {
 public:
  virtual ~WorkerLink() = default;
  virtual void Send(v1::CoordinatorMessage message) = 0;
  // `abort`: the peer doesn't answer, don't wait for it.
  virtual void Close(const absl::Status& status, bool abort) = 0;
};

}  // namespace parallax
