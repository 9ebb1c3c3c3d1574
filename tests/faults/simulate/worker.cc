#include "tests/faults/simulate/worker.h"

#include <filesystem>
#include <utility>

#include "common/base/version.h"
#include "tests/faults/simulate/work.h"
#include "worker/agent/attempts/running.h"
#include "worker/agent/session/credit.h"

namespace parallax::faults {
namespace {

bool Same(const v1::AttemptId& a, const v1::AttemptId& b) {
  return a.job_id() == b.job_id() && a.fence() == b.fence();
}

AgentOptions OptionsOf(const World& world, const std::string& name, int life, int release) {
  AgentOptions options = world.knobs.agent;
  const WorkerFacts facts = LivingWorker(name);
  options.name = name;
  options.kinds = facts.kinds;
  options.tags = facts.tags;
  options.memory_mb = facts.memory_mb;
  options.version = "simulated";
  options.versions = World::VersionsOf(release);
  options.instance = name + "-" + std::to_string(life);
  options.machine = "machine-of-" + name;
  return options;
}

}  // namespace

// The network, as the agent's link sees it.
class SimWorker::Port final : public CoordinatorPort {
 public:
  explicit Port(SimWorker& worker) : worker_(worker) {}
  absl::Status GetInfo(double, v1::GetInfoReply* info) override {
    const double now_s = worker_.world_.schedule.now();
    const Line& line = worker_.line_;
    if (!worker_.coordinator_.is_up() ||
        std::max(line.up_closed_until_s, line.down_closed_until_s) > now_s) {
      return DeadlineExceeded("no answer");
    }
    info->set_protocol(kWorkProtocol);
    info->set_coordinator_id(worker_.coordinator_.queue().database_id());
    return absl::OkStatus();
  }
  std::unique_ptr<WorkSession> Open(WorkSession::Events events) override {
    auto stream = worker_.coordinator_.Open(worker_.line_, std::move(events));
    worker_.stream_ = stream;
    return std::make_unique<SimSession>(std::move(stream));
  }

 private:
  SimWorker& worker_;
};

SimWorker::SimWorker(World& world, SimCoordinator& coordinator, const std::string& folder,
                     int number)
    : world_(world),
      coordinator_(coordinator),
      name_("w" + std::to_string(number)),
      clock_(world.schedule,
             1 + world.knobs.drift * world.rng.Child(name_ + "/clock").Uniform(-1, 1)),
      dice_(world.rng.Child(name_)),
      outbox_root_(folder + "/outbox-of-" + name_) {}

SimWorker::~SimWorker() = default;

void SimWorker::Start() {
  if (process_ != nullptr) return;
  const int life = ++lives_;
  sleeps_until_s_ = 0;
  process_ = std::make_unique<Process>();
  Process& process = *process_;
  process.release = DrawRelease();
  process.options = OptionsOf(world_, name_, life, process.release);
  if (!world_.has_faults) process.options.idle_exit_s = 0;
  world_.story.Tell("{}: starts, release {}", name_, process.release);
  process.port = std::make_unique<Port>(*this);
  process.link = std::make_unique<CoordinatorLink>(
      process.options, *process.port, clock_, dice_.Child("reconnect", static_cast<uint64_t>(life)),
      CoordinatorLink::Hooks{[this] { WakeSoon(); },
                             [this] { process_->reports->SetCoordinator(std::nullopt); }});
  process.departure = std::make_unique<Departure>(DepartureOptions{
      process.options.grace_s, process.options.long_grace_s, process.options.hand_back_s});
  process.retirement = std::make_unique<Retirement>(
      RetirementOptions{.idle_s = process.options.idle_exit_s, .deadline = {}, .margin_s = 0},
      clock_.Steady());
  process.outbox = *Outbox::Open(outbox_root_, name_);
  process.reports = std::make_unique<ReportQueue>(
      process.options.reports, clock_, dice_.Child("reports", static_cast<uint64_t>(life)));
  for (Report& report : process.outbox->TakeLeftovers()) {
    process.reports->Add(std::move(report), /*leftover=*/true);
  }
  PlanFaults(life);
  WakeSoon();
}

int SimWorker::DrawRelease() {
  if (world_.knobs.upgrade_at_s <= 0 || !world_.has_faults) return world_.upgraded ? 1 : 0;
  return dice_.Bernoulli(world_.upgraded ? 0.7 : 0.1) ? 1 : 0;
}

void SimWorker::Die(const char* how, double away_s) {
  world_.story.Tell("{}: {}", name_, how);
  const std::unique_ptr<Process> dead = std::move(process_);
  if (world_.mutation.no_outbox) std::filesystem::remove_all(outbox_root_);
  const auto stream = stream_.lock();
  if (stream != nullptr && !dead->finished && dice_.Bernoulli(0.3)) stream->Vanish();
  world_.schedule.After(away_s, [this] { Start(); });
}

void SimWorker::Later(double seconds, std::function<void()> event) {
  world_.schedule.After(seconds, [this, life = lives_, event = std::move(event)] {
    if (Lives(life)) event();
  });
}

std::vector<v1::AttemptId> SimWorker::running() const {
  std::vector<v1::AttemptId> attempts;
  if (process_ == nullptr) return attempts;
  for (const Run& run : process_->runs) attempts.push_back(run.lease.attempt());
  return attempts;
}

// ---- Faults
void SimWorker::PlanFaults(int) {
  if (!world_.has_faults) return;
  const Knobs& knobs = world_.knobs;
  if (knobs.worker_life_s > 0) {
    Later(world_.Next(knobs.worker_life_s), [this] {
      if (world_.has_faults) Die("is killed", world_.Next(world_.knobs.worker_away_s));
    });
  }
  if (knobs.leave_every_s > 0) {
    Later(world_.Next(knobs.leave_every_s), [this] {
      if (!world_.has_faults) return;
      process_->order = world_.dice.Bernoulli(0.3) ? LeaveOrder::kHandBack : LeaveOrder::kDrain;
      world_.story.Tell("{}: is told to leave", name_);
      WakeSoon();
    });
  }
  if (knobs.cut_every_s > 0) Later(world_.Next(knobs.cut_every_s), [this] { CloseLine(); });
  if (knobs.break_every_s > 0) Later(world_.Next(knobs.break_every_s), [this] { BreakStream(); });
}

void SimWorker::CloseLine() {
  if (!world_.has_faults) return;
  const double until_s = world_.schedule.now() + world_.Next(world_.knobs.cut_s);
  const int directions = world_.dice.UniformInt(1, 3);
  if (directions & 1) line_.up_closed_until_s = until_s;
  if (directions & 2) line_.down_closed_until_s = until_s;
  world_.story.Tell("{}: its line is closed until {:.3f}{}", name_, until_s,
                    directions == 1   ? ", upwards"
                    : directions == 2 ? ", downwards"
                                      : "");
  Later(world_.Next(world_.knobs.cut_every_s), [this] { CloseLine(); });
}

void SimWorker::BreakStream() {
  if (!world_.has_faults) return;
  if (const auto stream = stream_.lock()) {
    world_.story.Tell("{}: its stream breaks", name_);
    stream->Break();
  }
  Later(world_.Next(world_.knobs.break_every_s), [this] { BreakStream(); });
}

void SimWorker::Mend() {
  line_ = Line();
  if (process_ == nullptr) Start();
  if (process_->release != DrawRelease()) Die("is upgraded", 0);
}

// ---- The agent's loop: as in worker/agent/agent.cc
void SimWorker::WakeSoon() {
  if (std::exchange(wakes_, true)) return;
  world_.schedule.After(world_.knobs.turn_s * dice_.Uniform(), [this] {
    wakes_ = false;
    if (process_ != nullptr) Round();
  });
}

void SimWorker::Round() {
  Process& process = *process_;
  if (process.link->ConnectIsDue()) Connect();
  HandleMessages();
  process.link->HandleEnd();
  CheckLease();
  const SteadyTime now = clock_.Steady();
  process.retirement->Observe(!process.runs.empty(), now);
  if (process.retirement->WhyLeave(now) != nullptr && !process.departure->leaving()) {
    process.order = std::max(process.order, LeaveOrder::kDrain);
  }
  HandleDrain();
  if (!process.link->fatal().ok()) {
    // A hello of its name has come from a process that is dead by now.
    if (coordinator_.ProcessOf(name_) == process.options.instance) {
      coordinator_.model().Complain(
          name_ + " is ended by its own hello: " + process.link->fatal().ToString());
    }
    return Die("gives up", world_.knobs.queue.lease_s / 10);
  }
  if (process.finished) {
    process.link->HurryHeartbeat();
    if (process.link->HeartbeatIsDue()) process.link->SendHeartbeat(Held(), true);
    process.link->Finish();
    return Die("leaves", world_.Next(world_.knobs.worker_away_s));
  }
  GiveCredit();
  if (process.link->HeartbeatIsDue()) {
    process.link->SendHeartbeat(Held(), process.departure->leaving());
  }
  SleepUntilNext();
}

void SimWorker::Connect() {
  const std::string before = process_->link->coordinator_id();
  if (!process_->link->Meet()) return;
  if (!before.empty() && process_->link->coordinator_id() != before) {
    for (Run& run : process_->runs) Stop(run, StopCause::kCoordinator);
  }
  process_->credit = 0;
  process_->link->Open(Held());
}

std::vector<RunningAttempt> SimWorker::Running() const {
  std::vector<RunningAttempt> running;
  for (const Run& run : process_->runs) {
    RunningAttempt& attempt = running.emplace_back();
    attempt.attempt = run.lease.attempt();
    attempt.stop = run.stop;
    attempt.waiting = !run.working;
    attempt.remaining_s = 1e9;
    if (!run.working) continue;
    const double passed_s = std::chrono::duration<double>(run.started.time_since_epoch()).count();
    const double now_s =
        std::chrono::duration<double>(const_cast<MachineClock&>(clock_).Steady().time_since_epoch())
            .count();
    attempt.remaining_s = run.duration_s - (now_s - passed_s);
    attempt.fraction = std::clamp(1 - attempt.remaining_s / run.duration_s, 0.0, 1.0);
  }
  return running;
}

std::vector<v1::Progress> SimWorker::Held() const { return ProgressOf(Running(), Unanswered()); }

void SimWorker::HandleMessages() {
  for (v1::CoordinatorMessage& message : process_->link->TakeMessages()) {
    if (message.has_welcome()) HandleWelcome(message.welcome());
    if (message.has_lease()) HandleLease(std::move(*message.mutable_lease()));
    if (message.has_heartbeat_ack()) process_->link->Answered(message.heartbeat_ack().sequence());
    if (!message.has_stop()) continue;
    for (Run& run : process_->runs) {
      if (Same(run.lease.attempt(), message.stop().attempt())) Stop(run, StopCause::kCoordinator);
    }
  }
}

void SimWorker::HandleWelcome(const v1::Welcome& welcome) {
  process_->link->Welcomed(welcome);
  world_.story.Tell("{}: welcome, {} adopted", name_, welcome.adopted_size());
  for (Run& run : process_->runs) {
    bool adopted = false;
    for (const v1::AttemptId& attempt : welcome.adopted()) {
      adopted |= Same(attempt, run.lease.attempt());
    }
    if (!adopted) Stop(run, StopCause::kCoordinator);
  }
  process_->reports->SetCoordinator(process_->link->coordinator_id());
  SendNext();
}

void SimWorker::HandleLease(v1::Lease lease) {
  Process& process = *process_;
  process.credit = std::max(0, process.credit - 1);
  if (process.departure->leaving()) return process.link->HandBack(lease.attempt(), "draining");
  if (static_cast<int>(process.runs.size()) >= 2 * process.options.slots) {
    return process.link->HandBack(lease.attempt(), "no free slot");
  }
  process.retirement->Began({lease.attempt().job_id(), lease.attempt().fence()}, clock_.Steady());
  process.runs.push_back({std::move(lease)});
  FillSlots();
}

void SimWorker::CheckLease() {
  process_->link->BreakIfSilent();
  if (!process_->link->LeaseIsOver()) return;
  for (Run& run : process_->runs) {
    if (run.stop != StopCause::kNone) continue;
    world_.story.Tell("{}: stops job {}, its lease is over", name_, run.lease.attempt().job_id());
    Stop(run, StopCause::kLeaseLost);
  }
}

void SimWorker::GiveCredit() {
  Process& process = *process_;
  if (!process.link->IsWelcomed() || process.departure->leaving()) return;
  if (!process.retirement->TakesWork(clock_.Steady())) return;
  if (process.reports->HasUntriedLeftovers(process.link->coordinator_id())) return;
  const double ahead_s = process.options.ahead_s;
  const auto credit =
      CreditFor({.slots = process.options.slots,
                 .taken = static_cast<int>(process.runs.size()) + process.credit,
                 .ending_soon = ahead_s > 0 ? CountEndingSoon(Running(), ahead_s) : 0,
                 .pending_reports = static_cast<int>(process.reports->size()),
                 .max_pending_reports = process.options.max_pending_reports});
  if (!credit) return;
  process.credit += credit->jobs();
  process.link->Ask(*credit);
}

void SimWorker::HandleDrain() {
  Process& process = *process_;
  const Departure::Step step = process.departure->Advance(process.order, clock_.Steady());
  if (step.begins) {
    world_.story.Tell("{}: drains", name_);
    process.link->HurryHeartbeat();
    std::erase_if(process.runs, [&](const Run& run) {
      if (!run.working) process.link->HandBack(run.lease.attempt(), "draining");
      return !run.working;
    });
  }
  if (!process.departure->leaving()) return;
  if (step.hands_back) {
    for (Run& run : process.runs) Stop(run, StopCause::kHandBack);
    return;
  }
  const bool over = process.departure->IsOver(clock_.Steady());
  if (over) {
    for (const Run& run : process.runs) process.link->HandBack(run.lease.attempt(), "drained");
  }
  process.finished = (process.runs.empty() && Unanswered().empty()) || over;
}

void SimWorker::SleepUntilNext() {
  Process& process = *process_;
  const SteadyTime now = clock_.Steady();
  SteadyTime next = process.link->NextLook(SecondsAfter(now, world_.knobs.queue.lease_s),
                                           HasWorkUnderLease(Running()));
  next = process.departure->leaving() ? std::min(next, process.departure->deadline())
                                      : process.retirement->NextLook(next);
  const double ahead_s = process.options.ahead_s;
  if (process.link->IsWelcomed() && !process.departure->leaving() && ahead_s > 0 &&
      !process.runs.empty()) {
    next = std::min(next, SecondsAfter(now, ahead_s));
  }
  const double at_s = world_.schedule.now() + clock_.Until(next);
  if (sleeps_until_s_ > world_.schedule.now() && sleeps_until_s_ <= at_s) return;
  sleeps_until_s_ = at_s;
  Later(clock_.Until(next), [this] { WakeSoon(); });
}

}  // namespace parallax::faults
