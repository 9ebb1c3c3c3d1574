#include "tests/faults/simulate/users/client.h"

#include <algorithm>

#include "tests/coordinator/queue/train_fixture.h"

namespace parallax::faults {
namespace {

constexpr int kMostOpen = 100;  // Studies at a time.

}  // namespace

SimClient::SimClient(World& world, SimCoordinator& coordinator, std::vector<std::string> workers)
    : world_(world),
      coordinator_(coordinator),
      workers_(std::move(workers)),
      dice_(world.rng.Child("client")) {}

void SimClient::Start() {
  for (int i = 0; i < world_.knobs.studies; ++i) {
    ++open_;
    ++submitted_;
    world_.schedule.After(i == 0 ? 0 : world_.knobs.faults_s * 0.7 * dice_.Uniform(),
                          [this, request = StudyOf(i)] {
                            --open_;
                            Submit(request);
                          });
  }
  if (world_.knobs.order_every_s > 0) OrderLater();
  if (world_.knobs.replaces_studies) ReplaceLater();
}

void SimClient::ReplaceLater() {
  world_.schedule.After(world_.Next(world_.knobs.queue.lease_s), [this] {
    if (!world_.has_faults) return;
    Call([this] {
      const auto open = coordinator_.queue().ListStudies(kMostOpen, 0, /*only_unfinished=*/true);
      if (!open.ok() || !world_.has_faults) return;
      std::erase_if(studies_, [&](int64_t study) {
        const auto is_this = [&](const auto& status) { return status.study_id() == study; };
        return std::none_of(open->begin(), open->end(), is_this) && Forget(study);
      });
      const auto wanted = static_cast<size_t>(world_.knobs.studies);
      if (is_done() && studies_.size() < wanted) Submit(StudyOf(submitted_++));
    });
    ReplaceLater();
  });
}

v1::SubmitRequest SimClient::StudyOf(int index) {
  const std::string name = "study" + std::to_string(index);
  // Studies of one seed share their results.
  const v1::SubmitRequest study =
      MakeStudy({.name = name,
                 .seed = static_cast<uint64_t>(dice_.UniformInt(1, 2)),
                 .pairs = dice_.UniformInt(1, world_.knobs.pairs),
                 .rigs_per_scene = dice_.UniformInt(1, 4),
                 .variants = dice_.Bernoulli(0.3) ? std::vector<std::string>{"a", "b"}
                                                  : std::vector<std::string>{"only"},
                 .priority = dice_.UniformInt(0, 1),
                 .key = name});
  return dice_.Bernoulli(world_.knobs.trainings_p) ? WithTrainings(study, dice_.UniformInt(0, 1))
                                                   : study;
}

void SimClient::Submit(const v1::SubmitRequest& request) {
  CallUntilDone([this, request] {
    const auto reply = coordinator_.queue().Submit(request, "client");
    if (!reply.ok()) {
      coordinator_.model().Expect(reply.status(), "submit");
      return false;
    }
    const int64_t id = reply->study_id();
    world_.story.Tell("client: {} is study {}", request.study().name(), id);
    coordinator_.model().SubmitEnds(request.study(), id);
    if (std::find(studies_.begin(), studies_.end(), id) == studies_.end()) studies_.push_back(id);
    // The answer may be lost, too: then it is asked for again.
    return !world_.has_faults || !dice_.Bernoulli(world_.knobs.loss_p);
  });
}

void SimClient::CallUntilDone(std::function<bool()> call) {
  ++open_;
  Repeat(std::make_shared<OpenCall>(OpenCall{std::move(call), false}));
}

void SimClient::Repeat(const std::shared_ptr<OpenCall>& open) {
  Call([this, open] {
    if (open->done || !open->call()) return;
    open->done = true;
    --open_;
  });
  world_.schedule.After(world_.knobs.queue.lease_s / 2, [this, open] {
    if (!open->done) Repeat(open);
  });
}

void SimClient::Call(std::function<void()> call) {
  if (world_.has_faults && dice_.Bernoulli(world_.knobs.loss_p)) return;
  world_.schedule.After(world_.Delay(), [this, call = std::move(call)] {
    coordinator_.Enter([this, &call] { coordinator_.pool().Run(call); });
  });
}

void SimClient::OrderLater() {
  world_.schedule.After(world_.Next(world_.knobs.order_every_s), [this] {
    if (!world_.has_faults) return;
    GiveOrder();
    OrderLater();
  });
}

void SimClient::GiveOrder() {
  const int draw = dice_.UniformInt(0, 99);
  if (draw < 10) {
    if (coordinator_.IsInCrashLoop()) return;  // Starts count by the wall clock.
    // Epochs follow the clock, so that a backup does not repeat them if that is not set back.
    const double least = world_.knobs.lie == Lie::kOlder ? 0 : -1;
    return coordinator_.clock().JumpWall(dice_.Uniform(least, 1) * 60 * world_.knobs.queue.lease_s);
  }
  if (draw < 25) {
    const std::string worker = dice_.Pick(workers_);
    const bool undo = dice_.Bernoulli(0.6);
    return Call([this, worker, undo] {
      if (world_.has_faults) SetDrain(worker, undo);
    });
  }
  if (studies_.empty()) return;
  const int64_t study = dice_.Pick(studies_);
  Call([this, study, draw] {
    if (world_.has_faults) Steer(study, draw);
  });
}

void SimClient::SetDrain(const std::string& worker, bool undo) {
  v1::DrainOrder order;
  order.set_pattern(worker);
  order.set_actor("client");
  // Until it is answered, both may hold.
  coordinator_.model().DrainEnds(worker, true);
  const absl::Status status = coordinator_.queue().Drain(order, undo);
  world_.story.Tell("client: drain {}{}: {}", worker, undo ? " no more" : "", status.ToString());
  if (status.ok()) coordinator_.model().DrainEnds(worker, undo);
}

void SimClient::Steer(int64_t study, int draw) {
  JobQueue& queue = coordinator_.queue();
  QueueModel& model = coordinator_.model();
  const StudyId id{study};
  using Kind = QueueModel::Order;
  const auto forgets = [&] { model.OrderFails(study); };  // It changes nothing of a promise.
  const auto ends = [&](Kind kind) { return [&, kind] { model.OrderEnds(study, kind); }; };
  if (draw < 40) {
    Order(
        study, "pause", [&] { return queue.Pause(id, "", "client"); }, ends(Kind::kPause));
  } else if (draw < 43) {
    Order(
        study, "comment", [&] { return queue.Comment(id, "slow", "client"); }, forgets);
  } else if (draw < 46) {
    Order(
        study, "priority", [&] { return queue.SetPriority(id, draw % 3, "", "client"); }, forgets);
  } else if (draw < 60) {
    Order(
        study, "resume", [&] { return queue.Resume(id, "", "client"); }, ends(Kind::kResume));
  } else if (draw < 75) {
    Order(
        study, "retry", [&] { return queue.Retry(id, "client").status(); }, ends(Kind::kRetry));
  } else if (draw < 85) {
    const int limit = draw % 3;
    Order(
        study, "limit", [&] { return queue.SetMaxRunning(id, limit, "", "client"); },
        [&] { model.LimitEnds(study, limit); });
  } else if (draw < 92) {
    Order(
        study, "cancel", [&] { return queue.Cancel(id, "", "client"); }, ends(Kind::kCancel));
  } else {
    Forget(study);
  }
}

bool SimClient::Forget(int64_t study) {
  return Order(
      study, "forget",
      [&] { return coordinator_.queue().Forget(StudyId{study}, "", "client").status(); },
      [&] { coordinator_.model().OrderEnds(study, QueueModel::Order::kForget); });
}

bool SimClient::Order(int64_t study, const char* name, const std::function<absl::Status()>& ask,
                      const std::function<void()>& tell) {
  QueueModel& model = coordinator_.model();
  if (!model.Knows(study)) return false;  // A backup from before it was put back.
  model.OrderBegins(study);
  const absl::Status status = ask();
  world_.story.Tell("client: {} study {}: {}", name, study, status.ToString());
  status.ok() ? tell() : model.OrderFails(study);
  // A refusal is the queue's own word, not SQLite's.
  if (std::string(status.message()).starts_with("database:")) model.Expect(status, name);
  return status.ok();
}

void SimClient::Settle() {
  for (const std::string& worker : workers_) {
    CallUntilDone([this, worker] {
      SetDrain(worker, true);
      return true;
    });
  }
  CallUntilDone([this] {
    for (const int64_t study : studies_) {
      Order(
          study, "resume", [&] { return coordinator_.queue().Resume(StudyId{study}, "", "c"); },
          [&] { coordinator_.model().OrderEnds(study, QueueModel::Order::kResume); });
    }
    return true;
  });
}

}  // namespace parallax::faults
