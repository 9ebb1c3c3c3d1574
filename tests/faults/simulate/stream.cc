#include "tests/faults/simulate/stream.h"

#include <utility>

#include "coordinator/rpc/validation.h"
#include "tests/faults/simulate/coordinator.h"

namespace parallax::faults {

// ---- The worker's end
void SimStream::Up(std::function<void()> event) {
  const double at_s =
      std::max({last_up_s_, line_.up_closed_until_s, world_.schedule.now()}) + world_.Delay();
  last_up_s_ = at_s;
  world_.schedule.After(at_s - world_.schedule.now(),
                        [self = shared_from_this(), event = std::move(event)] { event(); });
}

void SimStream::Down(std::function<void()> event) {
  const double at_s =
      std::max({last_down_s_, line_.down_closed_until_s, world_.schedule.now()}) + world_.Delay();
  last_down_s_ = at_s;
  world_.schedule.After(at_s - world_.schedule.now(),
                        [self = shared_from_this(), event = std::move(event)] { event(); });
}

void SimStream::FromWorker(v1::WorkerMessage message) {
  if (!worker_open_) return;
  Up([this, message = std::move(message)] { Arrive(message); });
}

void SimStream::Finish() {
  if (worker_open_) Up([this] { EndUp(); });
}

void SimStream::Drop() {
  if (!std::exchange(worker_open_, false)) return;
  Up([this] { EndUp(); });
}

void SimStream::Vanish() { worker_open_ = false; }

void SimStream::Break() {
  EndDown(Unavailable("the connection broke"));
  Up([this] { EndUp(); });
}

// ---- The coordinator's end
void SimStream::Arrive(v1::WorkerMessage message) {
  if (!coordinator_.Lives(life_)) return EndDown(Unavailable("nobody listens"));
  if (closed_) return;
  incoming_.push_back(std::move(message));
  if (!busy_) coordinator_.Enter([this] { ReadNext(); });
}

void SimStream::EndUp() {
  if (closed_ || !coordinator_.Lives(life_)) return;
  coordinator_.Enter([this] {
    if (!worker_.empty()) {
      coordinator_.model().StreamEnds(worker_, this);
      coordinator_.dispatcher().Left(worker_, this);
    }
    Close(absl::OkStatus(), false);
  });
}

void SimStream::ReadNext() {
  if (busy_ || closed_ || incoming_.empty()) return;
  busy_ = true;
  v1::WorkerMessage message = std::move(incoming_.front());
  incoming_.pop_front();
  Handle(std::move(message));
}

void SimStream::Handle(v1::WorkerMessage message) {
  if (worker_.empty()) return Join(std::move(*message.mutable_hello()));
  Dispatcher& dispatcher = coordinator_.dispatcher();
  if (message.has_credit()) {
    dispatcher.AddCredit(worker_, this, message.credit());
    coordinator_.model().HeardCredit(worker_);
    return GoOn(CheckCredit(message.credit()));
  }
  if (message.has_heartbeat()) {
    Heartbeat(message.heartbeat());
    return GoOn(CheckHeartbeat(message.heartbeat()));
  }
  HandBack(message.hand_back());
}

void SimStream::Join(v1::Hello hello) {
  const absl::Status status = CheckHello(hello, coordinator_.queue().kinds());
  if (!status.ok()) return GoOn(status);
  if (!world_.mutation.any_worker) {
    const auto notes =
        DropKindsOfOtherVersions(coordinator_.versions(), coordinator_.queue().kinds(), hello);
    if (!notes.ok()) return GoOn(notes.status());
  }
  worker_ = hello.name();
  coordinator_.pool().Run([self = shared_from_this(), this, hello = std::move(hello)] {
    const std::vector<v1::AttemptId> holding(hello.holding().begin(), hello.holding().end());
    QueueModel& model = coordinator_.model();
    model.JoinBegins(worker_);
    const auto welcome = [&](const std::vector<v1::AttemptId>& adopted) {
      model.JoinEnds(worker_, this, holding, adopted);
      coordinator_.TookIn(worker_, hello.instance());
      v1::CoordinatorMessage message;
      v1::Welcome& body = *message.mutable_welcome();
      body.set_epoch(coordinator_.queue().epoch());
      body.set_lease_s(coordinator_.queue().lease_s());
      body.set_coordinator_id(coordinator_.queue().database_id());
      for (const v1::AttemptId& attempt : adopted) *body.add_adopted() = attempt;
      Send(std::move(message));
    };
    const absl::Status joined = coordinator_.dispatcher().Join(self, hello, welcome);
    if (!joined.ok()) model.JoinFails(worker_);
    GoOn(joined);
  });
}

void SimStream::Heartbeat(const v1::Heartbeat& heartbeat) {
  coordinator_.dispatcher().Heard(worker_, this, heartbeat);
  std::vector<v1::AttemptId> running;
  for (const v1::Progress& progress : heartbeat.running()) running.push_back(progress.attempt());
  coordinator_.model().Heard(worker_, running, heartbeat.draining());
}

void SimStream::HandBack(const v1::HandBack& back) {
  coordinator_.pool().Run([self = shared_from_this(), this, back] {
    coordinator_.model().ReportBegins(back.attempt());
    const auto outcome = coordinator_.queue().HandBack(worker_, back.attempt(), back.reason());
    world_.story.Tell("coordinator: job {} attempt {:x} handed back by {}: {}",
                      back.attempt().job_id(), back.attempt().fence(), worker_,
                      coordinator_.NameOf(outcome));
    coordinator_.model().ReportEnds(back.attempt(), QueueModel::Report::kHandBack, outcome);
    GoOn(absl::OkStatus());
  });
}

void SimStream::GoOn(const absl::Status& status) {
  busy_ = false;
  if (status.ok()) return ReadNext();
  if (!worker_.empty()) {
    coordinator_.model().StreamEnds(worker_, this);
    coordinator_.dispatcher().Left(worker_, this);
  }
  Close(status, false);
}

void SimStream::Send(v1::CoordinatorMessage message) {
  if (closed_ || !coordinator_.Lives(life_)) return;
  if (message.has_lease()) {
    world_.story.Tell("coordinator: {} job {} attempt {:x} leased to {}", message.lease().kind(),
                      message.lease().attempt().job_id(), message.lease().attempt().fence(),
                      worker_);
    coordinator_.model().LeaseGiven(worker_, message.lease(), coordinator_.queue());
  }
  Down([this, message = std::move(message)] {
    if (worker_open_) events_.on_message(message);
  });
}

void SimStream::Close(const absl::Status& status, bool) {
  if (std::exchange(closed_, true)) return;
  if (!worker_.empty() && coordinator_.Lives(life_)) {
    coordinator_.model().StreamEnds(worker_, this);
  }
  EndDown(status);
}

void SimStream::EndDown(const absl::Status& status) {
  Down([this, status] {
    if (std::exchange(worker_open_, false)) events_.on_end(status);
  });
}

}  // namespace parallax::faults
