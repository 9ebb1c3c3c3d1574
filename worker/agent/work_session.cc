#include "worker/agent/work_session.h"

#include <grpcpp/grpcpp.h>

#include <deque>
#include <mutex>

#include "common/rpc/grpc_status.h"

namespace parallax {

// Keeps itself alive until gRPC is through with it.
class WorkSession::Stream final
    : public grpc::ClientBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage> {
 public:
  explicit Stream(Events events) : events_(std::move(events)) {}

  void Start(v1::Coordinator::Stub& coordinator, std::shared_ptr<Stream> self) {
    self_ = std::move(self);
    coordinator.async()->Work(&context_, this);
    AddHold();  // Send() starts writes from outside the reactions.
    StartRead(&incoming_);
    StartCall();
  }

  void Send(v1::WorkerMessage message) {
    std::lock_guard lock(mu_);
    if (closed_ || finishing_) return;
    if (message.has_heartbeat() && !waiting_.empty() && waiting_.back().has_heartbeat()) {
      waiting_.back() = std::move(message);
      return;
    }
    waiting_.push_back(std::move(message));
    WriteNext();
  }

  void Finish() {
    std::lock_guard lock(mu_);
    if (closed_ || finishing_) return;
    finishing_ = true;
    WriteNext();
  }

  void Cancel() { context_.TryCancel(); }

 private:
  void OnReadDone(bool ok) override {
    if (ok) {
      events_.on_message(std::move(incoming_));
      incoming_.Clear();
      StartRead(&incoming_);
      return;
    }
    {
      std::lock_guard lock(mu_);
      closed_ = true;
    }
    RemoveHold();
  }

  void OnWriteDone(bool ok) override {
    std::lock_guard lock(mu_);
    writing_ = false;
    if (ok && !closed_) WriteNext();
  }

  void OnDone(const grpc::Status& status) override {
    const std::shared_ptr<Stream> self = std::move(self_);
    events_.on_end(FromGrpc(status));
  }

  // Requires mu_, not closed_.
  void WriteNext() {
    if (writing_) return;
    if (!waiting_.empty()) {
      writing_ = true;
      outgoing_ = std::move(waiting_.front());
      waiting_.pop_front();
      StartWrite(&outgoing_);
    } else if (finishing_ && !said_done_) {
      said_done_ = true;
      StartWritesDone();
    }
  }

  const Events events_;
  grpc::ClientContext context_;
  v1::CoordinatorMessage incoming_;
  std::shared_ptr<Stream> self_;

  std::mutex mu_;
  v1::WorkerMessage outgoing_;  // Guarded by mu_, as is all that follows; gRPC's while writing_.
  std::deque<v1::WorkerMessage> waiting_;
  bool writing_ = false;
  bool finishing_ = false;
  bool said_done_ = false;
  bool closed_ = false;
};

std::unique_ptr<WorkSession> WorkSession::Open(v1::Coordinator::Stub& coordinator, Events events) {
  auto stream = std::make_shared<Stream>(std::move(events));
  stream->Start(coordinator, stream);
  return std::unique_ptr<WorkSession>(new WorkSession(stream));
}

WorkSession::~WorkSession() { stream_->Cancel(); }
void WorkSession::Send(v1::WorkerMessage message) { stream_->Send(std::move(message)); }
void WorkSession::Finish() { stream_->Finish(); }
void WorkSession::Cancel() { stream_->Cancel(); }

}  // namespace parallax
