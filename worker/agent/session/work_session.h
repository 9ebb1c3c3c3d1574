// The worker's end of one `Work` stream. Sending never blocks, so that a stuck connection can't
// keep the agent from watching its leases.
#pragma once

#include <functional>
#include <memory>

#include "common/base/status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// One stream. Thread-safe.
class WorkSession {
 public:
  // Called on gRPC's threads, one at a time; must not block. `on_end` is the last event.
  struct Events {
    std::function<void(v1::CoordinatorMessage)> on_message;
    std::function<void(absl::Status)> on_end;
  };

  static std::unique_ptr<WorkSession> Open(v1::Coordinator::Stub& coordinator, Events events);
  ~WorkSession();  // Cancels the stream and waits for `on_end`; not to be called from an event.

  // Queues the message; messages are sent in order. A heartbeat replaces one that still waits.
  void Send(v1::WorkerMessage message);
  // Half-closes the stream; the coordinator ends it after reading everything.
  void Finish();
  void Cancel();

 private:
  class Stream;
  explicit WorkSession(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

}  // namespace parallax
