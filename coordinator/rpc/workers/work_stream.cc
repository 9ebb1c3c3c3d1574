#include "coordinator/rpc/workers/work_stream.h"

#include "common/base/status.h"
#include "common/base/system/log.h"
#include "common/rpc/grpc_status.h"
#include "coordinator/rpc/validation.h"

namespace parallax {

WorkStream* WorkStream::Open(const WorkStreamContext& shared, grpc::CallbackServerContext* call) {
  std::shared_ptr<WorkStream> stream(new WorkStream(shared, call));
  stream->self_ = stream;
  WorkStream* const raw = stream.get();
  // Closed by a thread of the pool, because closing a stream calls back into it.
  stream->no_hello_.emplace(
      shared.watch,
      [weak = std::weak_ptr<WorkStream>(stream), &pool = shared.pool] {
        pool.Run([weak] {
          if (const auto self = weak.lock()) {
            self->Close(DeadlineExceeded("no hello on this stream"), false);
          }
        });
      },
      shared.hello_s);
  raw->ReadNext();
  return raw;
}

void WorkStream::ReadNext() {
  std::lock_guard lock(mu_);
  if (closing_) return;
  incoming_.Clear();
  StartRead(&incoming_);
}

void WorkStream::OnReadDone(bool ok) {
  no_hello_.reset();
  if (!ok) {
    if (!worker_.empty()) shared_.dispatcher.Left(worker_, this);
    return Close(absl::OkStatus(), false);
  }
  if (worker_.empty()) return Join();
  switch (incoming_.message_case()) {
    case v1::WorkerMessage::kCredit: {
      const absl::Status status = CheckCredit(incoming_.credit());
      if (status.ok()) shared_.dispatcher.AddCredit(worker_, this, incoming_.credit());
      return EndUnlessOk(status);
    }
    case v1::WorkerMessage::kHeartbeat: {
      const absl::Status status = CheckHeartbeat(incoming_.heartbeat());
      if (status.ok()) shared_.dispatcher.Heard(worker_, this, incoming_.heartbeat());
      return EndUnlessOk(status);
    }
    case v1::WorkerMessage::kHandBack:
      return HandleHandBack();
    case v1::WorkerMessage::kHello:
      return EndUnlessOk(InvalidArgument("a second hello on one stream"));
    case v1::WorkerMessage::MESSAGE_NOT_SET:
      return EndUnlessOk(absl::OkStatus());  // A newer worker's.
  }
}

// The first message. Taking the worker in waits for a commit; the next read starts after it.
void WorkStream::Join() {
  if (!incoming_.has_hello()) {
    return EndUnlessOk(InvalidArgument("the first message on a stream must be hello"));
  }
  const absl::Status status = CheckHello(incoming_.hello(), shared_.queue.kinds());
  if (!status.ok()) return EndUnlessOk(status);
  const auto notes =
      DropKindsOfOtherVersions(StageVersions(), shared_.queue.kinds(), *incoming_.mutable_hello());
  if (!notes.ok()) return EndUnlessOk(notes.status());
  for (const std::string& note : *notes) LogWarning(note);
  worker_ = incoming_.hello().name();
  shared_.pool.Run([self = shared_from_this(), notes = *notes] {
    const auto welcome = [&self, &notes](const std::vector<v1::AttemptId>& adopted) {
      v1::CoordinatorMessage message;
      v1::Welcome& body = *message.mutable_welcome();
      body.set_epoch(self->shared_.queue.epoch());
      body.set_lease_s(self->shared_.lease_s);
      body.set_store_uri(self->shared_.store.uri);
      body.set_store_id(self->shared_.store.id);
      body.set_store_access(self->shared_.store.access);
      body.set_coordinator_id(self->shared_.coordinator_id);
      for (const v1::AttemptId& attempt : adopted) *body.add_adopted() = attempt;
      for (const std::string& note : notes) body.add_notes(note);
      self->Send(std::move(message));
    };
    self->EndUnlessOk(self->shared_.dispatcher.Join(self, self->incoming_.hello(), welcome));
  });
}

void WorkStream::HandleHandBack() {
  const absl::Status status = CheckAttempt(incoming_.hand_back().attempt());
  if (!status.ok()) return EndUnlessOk(status);
  shared_.pool.Run([self = shared_from_this()] {
    const v1::HandBack& back = self->incoming_.hand_back();
    const auto outcome =
        self->shared_.queue.HandBack(self->worker_, back.attempt(), CleanText(back.reason()));
    if (!outcome.ok()) {
      LogWarning("attempt not handed back", {{"worker", self->worker_},
                                             {"job", back.attempt().job_id()},
                                             {"error", outcome.status()}});
    }
    self->EndUnlessOk(absl::OkStatus());
  });
}

// Ends the stream, or goes on reading.
void WorkStream::EndUnlessOk(const absl::Status& status) {
  if (status.ok()) return ReadNext();
  if (!worker_.empty()) shared_.dispatcher.Left(worker_, this);
  Close(status, false);
}

void WorkStream::Send(v1::CoordinatorMessage message) {
  std::lock_guard lock(mu_);
  if (closing_) return;
  // A worker that doesn't read must not fill our memory: of answers to heartbeats only the newest
  // counts.
  if (message.has_heartbeat_ack() && !waiting_.empty() && waiting_.back().has_heartbeat_ack()) {
    waiting_.back() = std::move(message);
    return;
  }
  if (writing_) {
    waiting_.push_back(std::move(message));
    return;
  }
  writing_ = true;
  outgoing_ = std::move(message);
  StartWrite(&outgoing_);
}

void WorkStream::Close(const absl::Status& status, bool abort) {
  if (abort) call_->TryCancel();
  {
    std::lock_guard lock(mu_);
    if (closing_) return;
    closing_ = true;
    end_ = ToGrpc(status);
    if (writing_) return;  // OnWriteDone finishes.
  }
  Finish(end_);
}

void WorkStream::OnWriteDone(bool ok) {
  {
    std::lock_guard lock(mu_);
    writing_ = false;
    if (!closing_) {
      // A broken stream is noticed by the read.
      if (!ok || waiting_.empty()) return;
      writing_ = true;
      outgoing_ = std::move(waiting_.front());
      waiting_.pop_front();
      StartWrite(&outgoing_);
      return;
    }
  }
  Finish(end_);
}

void WorkStream::OnDone() {
  const std::shared_ptr<WorkStream> self = std::move(self_);
  const std::function<void()> on_done = shared_.on_done;
  on_done();
}

}  // namespace parallax
