#include "worker/agent/session/work_session.h"

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <deque>
#include <mutex>

#include "common/rpc/endpoint.h"
#include "common/rpc/grpc_status.h"

namespace parallax {

namespace {

// Its context holds the channel, and the thread that releases the last channel joins gRPC's
// callback threads. So it must not be destroyed on one of those: the session's owner waits for
// OnDone and destroys it.
class Stream final : public grpc::ClientBidiReactor<v1::WorkerMessage, v1::CoordinatorMessage> {
 public:
  explicit Stream(WorkSession::Events events) : events_(std::move(events)) {}

  void Start(v1::Coordinator::Stub& coordinator) {
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

  void WaitUntilDone() {
    std::unique_lock lock(done_->mu);
    done_->changed.wait(lock, [this] { return done_->done; });
  }

 private:
  // Outlives the stream until OnDone has woken the waiter.
  struct Done {
    std::mutex mu;
    std::condition_variable changed;
    bool done = false;  // Guarded by mu.
  };

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
    const std::shared_ptr<Done> done = done_;
    events_.on_end(FromGrpc(status));
    std::lock_guard lock(done->mu);
    done->done = true;
    done->changed.notify_all();
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

  const WorkSession::Events events_;
  grpc::ClientContext context_;
  v1::CoordinatorMessage incoming_;
  const std::shared_ptr<Done> done_ = std::make_shared<Done>();

  std::mutex mu_;
  v1::WorkerMessage outgoing_;  // Guarded by mu_, as is all that follows; gRPC's while writing_.
  std::deque<v1::WorkerMessage> waiting_;
  bool writing_ = false;
  bool finishing_ = false;
  bool said_done_ = false;
  bool closed_ = false;
};

class GrpcSession final : public WorkSession {
 public:
  GrpcSession(v1::Coordinator::Stub& coordinator, Events events) : stream_(std::move(events)) {
    stream_.Start(coordinator);
  }
  ~GrpcSession() override {
    stream_.Cancel();
    stream_.WaitUntilDone();
  }
  void Send(v1::WorkerMessage message) override { stream_.Send(std::move(message)); }
  void Finish() override { stream_.Finish(); }
  void Cancel() override { stream_.Cancel(); }

 private:
  Stream stream_;
};

}  // namespace

std::unique_ptr<WorkSession> WorkSession::Open(v1::Coordinator::Stub& coordinator, Events events) {
  return std::make_unique<GrpcSession>(coordinator, std::move(events));
}

absl::Status GrpcPort::GetInfo(double timeout_s, v1::GetInfoReply* info) {
  grpc::ClientContext context;
  SetRpcTimeout(context, std::chrono::duration<double>(timeout_s));
  return FromGrpc(coordinator_.GetInfo(&context, v1::GetInfoRequest(), info));
}

}  // namespace parallax
