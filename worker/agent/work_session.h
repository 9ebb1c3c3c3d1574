// The worker's end of one `Work` stream. Sending never blocks, so that a stuck connection can't
// stop the agent from watching its leases.
#pragma once

#include <functional>
#include <memory>

#include "common/base/status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// Thread-safe.
class WorkSession {
 public:
  // Called on gRPC's threads, one at a time, and must not block. After `on_end` nothing comes any
  // more.
  struct Events {
    std::function<void(v1::CoordinatorMessage)> on_message;
    std::function<void(absl::Status)> on_end;
  };

  static std::unique_ptr<WorkSession> Open(v1::Coordinator::Stub& coordinator, Events events);
  ~WorkSession();  // Cancels the stream and waits for `on_end`; not to be called from an event.

  // Queued and sent in order. A heartbeat replaces one that still waits.
  void Send(v1::WorkerMessage message);
  // Nothing more will be sent; the coordinator ends the stream after it has read everything.
  void Finish();
  void Cancel();

 private:
  class Stream;
  explicit WorkSession(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

}  // namespace parallax
