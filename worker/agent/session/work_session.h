// The worker's way to its coordinator: one `Work` stream, and the question who answers there.
// Sending never blocks, so that a stuck connection can't keep the agent from watching its leases.
#pragma once

#include <functional>
#include <memory>

#include "common/base/status.h"
#include "parallax/v1/service.grpc.pb.h"

namespace parallax {

// One stream. Thread-safe.
class WorkSession {
 public:
  // Called one at a time, by gRPC on its threads; must not block. `on_end` is the last event.
  struct Events {
    std::function<void(v1::CoordinatorMessage)> on_message;
    std::function<void(absl::Status)> on_end;
  };

  // Opens a stream over gRPC.
  static std::unique_ptr<WorkSession> Open(v1::Coordinator::Stub& coordinator, Events events);
  // Cancels the stream. No event comes afterwards; not to be called from an event.
  virtual ~WorkSession() = default;

  // Queues the message; messages are sent in order. A heartbeat replaces one that still waits.
  virtual void Send(v1::WorkerMessage message) = 0;
  // Half-closes the stream; the coordinator ends it after reading everything.
  virtual void Finish() = 0;
  virtual void Cancel() = 0;
};

// The coordinator as a link reaches it.
class CoordinatorPort {
 public:
  virtual ~CoordinatorPort() = default;
  // Asks the coordinator who it is, within a time limit. Errors: the call's.
  virtual absl::Status GetInfo(double timeout_s, v1::GetInfoReply* info) = 0;
  virtual std::unique_ptr<WorkSession> Open(WorkSession::Events events) = 0;
};

// The port over gRPC.
class GrpcPort final : public CoordinatorPort {
 public:
  // `coordinator` must outlive the port.
  explicit GrpcPort(v1::Coordinator::Stub& coordinator) : coordinator_(coordinator) {}
  absl::Status GetInfo(double timeout_s, v1::GetInfoReply* info) override;
  std::unique_ptr<WorkSession> Open(WorkSession::Events events) override {
    return WorkSession::Open(coordinator_, std::move(events));
  }

 private:
  v1::Coordinator::Stub& coordinator_;
};

}  // namespace parallax
