#include "tests/faults/simulate/coordinator.h"

#include <sqlite3.h>

#include <regex>
#include <utility>

#include "coordinator/rpc/validation.h"
#include "coordinator/rpc/workers/output_check.h"
#include "tests/faults/simulate/users/searcher.h"
#include "tests/faults/simulate/work.h"

namespace parallax::faults {
namespace {

// Thrown where the queue would end the process.
struct ProcessEnds {};

constexpr double kTicksPerLease = 20;
constexpr int kMostStarts = 10'000;  // More of them lead nowhere.

Rng DriftOf(const World& world) { return world.rng.Child("coordinator"); }

double Rate(Rng rng, double drift) { return 1 + drift * rng.Uniform(-1, 1); }

}  // namespace

SimCoordinator::SimCoordinator(World& world, const std::string& folder)
    : world_(world),
      folder_(folder),
      clock_(world.schedule, Rate(DriftOf(world), world.knobs.drift)),
      model_({.lease_s = world.knobs.queue.lease_s,
              .grace_s = std::min(world.knobs.queue.lease_s, world.knobs.reconnect_grace_s),
              .slack_s = 8 * world.knobs.turn_s,
              .user_running = world.knobs.user_running,
              .pairs_stay = !world.knobs.has_files,
              .disk_lies = world.knobs.disk_errs || world.knobs.lie != Lie::kNone},
             clock_),
      dice_(world.rng.Child("coordinator/events")),
      liar_(folder),
      disk_(folder) {
  if (world.knobs.has_stream || world.knobs.has_search) model_.HasOtherStudies();
  RegisterPowerCutVfs();
  // Random numbers of SQLite become the same for the same seed.
  sqlite3_test_control(SQLITE_TESTCTRL_PRNG_SEED, static_cast<int>(world.seed % 0x7fffffff) + 1,
                       nullptr);
  sqlite3_randomness(0, nullptr);
}

SimCoordinator::~SimCoordinator() {
  life_.reset();
  SetVfsPlan({});
}

VfsPlan SimCoordinator::DrawPlan() {
  VfsPlan plan{.lose_unsynced = true, .seed = dice_.Bits64()};
  end_chance_ = 0;
  if (!world_.has_faults || IsInCrashLoop()) return plan;
  // Some lives end at one of the operations on files, others at a step of a command, if they come
  // so far.
  if (world_.knobs.coordinator_life_s > 0 && dice_.Bernoulli(0.3)) {
    plan.die_at = dice_.UniformInt(1, dice_.Bernoulli(0.3) ? 60 : 3000);
    plan.lose_unsynced = dice_.Bernoulli(world_.knobs.power_cut_p);
  } else if (world_.knobs.coordinator_life_s > 0 && dice_.Bernoulli(0.8)) {
    end_chance_ = 0.1 * Power(0.002, dice_.Uniform());
    dies_of_power_ = dice_.Bernoulli(world_.knobs.power_cut_p);
  }
  if (world_.knobs.disk_errs && dice_.Bernoulli(0.7)) {
    plan.errors = {.at = dice_.UniformInt(1, dice_.Bernoulli(0.3) ? 100 : 5000),
                   .count = dice_.Bernoulli(0.5) ? 1 : dice_.UniformInt(2, 200),
                   .full = dice_.Bernoulli(0.5),
                   .reads = dice_.Bernoulli(0.5)};
  }
  return plan;
}

// Some lives end at a fail point of the queue.
absl::Status SimCoordinator::Pass(const std::string& command, int step) {
  if (VfsHasEnded()) throw ProcessEnds();
  if (!world_.has_faults || !points_.Pass(command, step, end_chance_, dice_)) {
    return absl::OkStatus();
  }
  world_.story.Tell("coordinator: is at step {} of {}", step, command);
  EndVfs(dies_of_power_);
  throw ProcessEnds();
}

void SimCoordinator::Start() {
  if (is_up() || refused_) return;
  if (++lives_ > kMostStarts) return model_.Complain("the coordinator starts again and again");
  release_ = world_.upgraded ? 1 : 0;
  SetVfsPlan(DrawPlan());
  model_.Starts();
  absl::Status status;
  try {
    status = OpenOrPutBack();
  } catch (const ProcessEnds&) {
  }
  if (VfsHasEnded()) return Bury("dies in its start");
  if (!status.ok()) {
    HandleFatal(status);
    return Bury("does not start");
  }
  model_.Started(queue().epoch(), release_);
  world_.story.Tell("coordinator: starts, epoch {:x}", queue().epoch());
  const int life = lives_;
  if (world_.has_faults && world_.knobs.coordinator_life_s > 0) {
    world_.schedule.After(world_.Next(world_.knobs.coordinator_life_s), [this, life] {
      if (world_.has_faults && Lives(life)) Die(dice_.Bernoulli(world_.knobs.power_cut_p));
    });
  }
  if (world_.knobs.lie == Lie::kOlder && backup_ == nullptr) BackUpLater(life);
  if (IsInCrashLoop()) {
    world_.schedule.After(world_.knobs.queue.lease_s * dice_.Uniform(0.1, 0.8), [this, life] {
      if (Lives(life)) Die(/*power_cut=*/false);
    });
    if (!std::exchange(loop_.checks, true)) {
      world_.schedule.After(2 * world_.knobs.queue.lease_s, [this] { CheckCrashLoop(); });
    }
  }
  TickLater(life);
  const double lease_s = world_.knobs.queue.lease_s;
  if (world_.knobs.has_stream) Often(life, lease_s / 10, [this] { return streams().Tick(); });
  if (world_.knobs.has_search) Often(life, lease_s / 10, [this] { return searches().Tick(); });
  if (!world_.knobs.queue.notice_targets.empty()) {
    Often(life, lease_s / 2, [this] { return DeliverNotices(); });
  }
  if (world_.knobs.has_files) LookIntoStoreLater(life);
  Enter([this] { model_.Compare(queue(), /*at_end=*/false); });
}

absl::Status SimCoordinator::OpenQueue() {
  JobQueueOptions options = world_.knobs.queue;
  options.db_path = folder_ + "/queue.db";
  options.vfs = kPowerCutVfs;
  options.clock = &clock_;
  options.kinds = &Kinds();
  options.versions = versions();
  if (end_chance_ > 0) {
    options.fail_point = [this](const std::string& command, int step) {
      return Pass(command, step);
    };
  }
  auto life = std::make_unique<Life>();
  options.open_store = [this,
                        &life = *life](const KnownStore& known) -> absl::StatusOr<std::string> {
    ASSIGN_OR_RETURN(life.store, ClaimStore(disk_.uri(), known, false));
    life.there = std::make_unique<FilePresence>(*life.store, clock_);
    return life.store->Id();
  };
  if (world_.knobs.has_files) {
    options.files_there = [&life = *life](const auto& files) { return life.there->Has(files); };
  }
  options.on_fatal = [this](const absl::Status& status) {
    HandleFatal(status);
    throw ProcessEnds();
  };
  options.unsafe_for_test = world_.mutation.queue;
  ASSIGN_OR_RETURN(life->queue, JobQueue::Open(options));
  life->dispatcher = std::make_unique<Dispatcher>(
      *life->queue, life->pool, clock_, world_.knobs.reconnect_grace_s, /*own_thread=*/false);
  life->queue->SetObserver(this);
  life->streams = std::make_unique<StreamKeeper>(*life->queue, clock_);
  life->searches = std::make_unique<SearchKeeper>(*life->queue, clock_, ScorerOf(*life->queue));
  life_ = std::move(life);
  return absl::OkStatus();
}

absl::Status SimCoordinator::OpenOrPutBack() {
  const bool lies = world_.has_faults && world_.knobs.lie != Lie::kNone && !liar_.has_lied() &&
                    lives_ >= world_.knobs.lie_at &&
                    (world_.knobs.lie != Lie::kOlder || backup_ != nullptr);
  if (!lies) return OpenQueue();
  SetVfsPlan({.lose_unsynced = true, .seed = dice_.Bits64()});
  end_chance_ = 0;
  const std::string what = liar_.Tell(world_.knobs.lie, dice_, clock_.UnixSeconds());
  model_.DiskLies();
  world_.story.Tell("coordinator: {}", what);
  if (world_.knobs.lie == Lie::kOlder) clock_.JumpWall(86400);
  const absl::Status status = OpenQueue();
  if (status.ok()) {
    if (world_.knobs.lie == Lie::kOlder) {
      model_.Rewind(*backup_);
      model_.Starts();  // What it noted was of the other database.
    }
    return status;
  }
  if (VfsHasEnded()) return status;
  // Who has put it there reads the line, and puts back what was there.
  model_.Expect(status, "refuses " + what);
  world_.story.Tell("coordinator: refuses: {}", Plain(status));
  liar_.PutBack();
  return OpenQueue();
}

void SimCoordinator::BackUpLater(int life) {
  world_.schedule.After(world_.Next(world_.knobs.queue.lease_s), [this, life] {
    if (!Lives(life) || backup_ != nullptr) return;
    Enter([this] {
      if (!queue().Backup(liar_.backup_path()).ok()) return;
      world_.story.Tell("coordinator: a backup is made");
      backup_ = std::make_unique<QueueModel>(model_);
    });
  });
}

// Without the name of the run's folder and the store's id, which are others each time.
std::string SimCoordinator::Plain(const absl::Status& status) const {
  static const std::regex* const id = new std::regex("[0-9a-f]{32}");
  std::string text = std::regex_replace(status.ToString(), *id, "ID");
  for (size_t at = 0; (at = text.find(folder_)) != std::string::npos;)
    text.erase(at, folder_.size());
  return text;
}

// The queue ends the process, with one line.
void SimCoordinator::HandleFatal(const absl::Status& status) {
  if (VfsHasEnded()) return;
  world_.story.Tell("coordinator: ends itself: {}", Plain(status));
  // Its database is damaged, which no restart mends.
  refused_ = absl::IsDataLoss(status) && liar_.has_lied();
  model_.Expect(status, "the coordinator ends itself");
  EndVfs(/*lose_unsynced=*/false);
}

void SimCoordinator::Die(bool power_cut) {
  EndVfs(power_cut);
  Bury(power_cut ? "loses its power" : "is killed");
}

// The machine's files are as its end left them. What the process still does changes nothing.
void SimCoordinator::Bury(const char* how) {
  world_.story.Tell("coordinator: {}", how);
  model_.Died();
  const std::unique_ptr<Life> dead = std::move(life_);
  if (dead != nullptr) dead->queue->SetObserver(nullptr);
  if (refused_) return world_.story.Tell("coordinator: its database is damaged");
  const double away_s = world_.has_faults && !IsInCrashLoop() && dice_.Bernoulli(0.3)
                            ? dice_.Uniform() * 2 * world_.knobs.queue.lease_s
                            : world_.knobs.turn_s;
  world_.schedule.After(away_s, [this] { Start(); });
}

void SimCoordinator::Enter(const std::function<void()>& event) {
  if (!is_up()) return;
  try {
    event();
  } catch (const ProcessEnds&) {
  }
  if (VfsHasEnded()) return Bury("dies at a file operation");
  Stir();
}

// ---- Turns of its threads
void SimCoordinator::Stir() {
  TurnSoon(queue_turn_, &SimCoordinator::QueueTurn, world_.knobs.turn_s);
  TurnSoon(pool_turn_, &SimCoordinator::PoolTurn, world_.knobs.turn_s);
  TurnSoon(dispatcher_turn_, &SimCoordinator::DispatcherTurn, world_.knobs.turn_s);
}

void SimCoordinator::TurnSoon(bool& planned, bool (SimCoordinator::*turn)(), double within_s) {
  if (std::exchange(planned, true)) return;
  world_.schedule.After(within_s * dice_.Uniform(), [this, &planned, turn] {
    planned = false;
    if (!is_up()) return;
    bool worked = false;
    try {
      worked = (this->*turn)();
    } catch (const ProcessEnds&) {
    }
    if (VfsHasEnded()) return Bury("dies at a file operation");
    if (worked) Stir();
  });
}

bool SimCoordinator::QueueTurn() { return queue().Work(); }

bool SimCoordinator::PoolTurn() { return pool().RunNext(); }

bool SimCoordinator::DispatcherTurn() {
  const SteadyTime next = dispatcher().Work();
  const double at_s = world_.schedule.now() + clock_.Until(next);
  if (look_at_s_ <= world_.schedule.now() || at_s < look_at_s_) {
    look_at_s_ = at_s;
    world_.schedule.After(clock_.Until(next), [this, life = lives_] {
      if (Lives(life)) TurnSoon(dispatcher_turn_, &SimCoordinator::DispatcherTurn, 0);
    });
  }
  // What it asked for waits in the queue and in the pool.
  TurnSoon(queue_turn_, &SimCoordinator::QueueTurn, world_.knobs.turn_s);
  TurnSoon(pool_turn_, &SimCoordinator::PoolTurn, world_.knobs.turn_s);
  return false;
}

void SimCoordinator::TickLater(int life) {
  world_.schedule.After(world_.knobs.queue.lease_s / kTicksPerLease, [this, life] {
    if (!Lives(life)) return;
    TurnSoon(queue_turn_, &SimCoordinator::QueueTurn, 0);
    TickLater(life);
  });
}

// ---- Calls
std::shared_ptr<SimStream> SimCoordinator::Open(Line& line, WorkSession::Events events) {
  return std::make_shared<SimStream>(world_, *this, line, std::move(events), lives_);
}

std::string SimCoordinator::NameOf(const absl::StatusOr<v1::ReportOutcome>& outcome) {
  return outcome.ok() ? v1::ReportOutcome_Name(*outcome) : outcome.status().ToString();
}

void SimCoordinator::Complete(const v1::CompleteRequest& request, Reply reply) {
  if (request.coordinator_id() != queue().database_id())
    return reply(v1::REPORT_OUTCOME_STALE_FENCE);
  const absl::StatusOr<std::string> wrong = WhyWrong(request);
  if (!wrong.ok()) return reply(Unavailable("{}", wrong.status().message()));
  model_.ReportBegins(request.attempt());
  queue().CompleteAsync(
      request, *wrong,
      [this, attempt = request.attempt(), worker = request.worker(), is_wrong = !wrong->empty(),
       reply = std::move(reply)](const absl::StatusOr<v1::ReportOutcome>& outcome) {
        if (VfsHasEnded()) return;
        world_.story.Tell("coordinator: job {} attempt {:x} of {} done: {}", attempt.job_id(),
                          attempt.fence(), worker, NameOf(outcome));
        if (outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK) dispatcher().Reported(worker, true);
        if (is_wrong && absl::IsInvalidArgument(outcome.status())) {
          model_.ReportEnds(attempt, QueueModel::Report::kFail, v1::REPORT_OUTCOME_OK);
        } else {
          model_.ReportEnds(attempt, QueueModel::Report::kComplete, outcome);
        }
        reply(outcome);
      });
}

void SimCoordinator::Fail(const v1::FailRequest& request, Reply reply) {
  if (request.coordinator_id() != queue().database_id())
    return reply(v1::REPORT_OUTCOME_STALE_FENCE);
  pool().Run([this, request, reply = std::move(reply)] {
    model_.ReportBegins(request.attempt());
    const auto outcome = queue().Fail(CleanFail(request));
    world_.story.Tell("coordinator: job {} attempt {:x} of {} failed: {}",
                      request.attempt().job_id(), request.attempt().fence(), request.worker(),
                      NameOf(outcome));
    if (outcome.ok() && *outcome == v1::REPORT_OUTCOME_OK) {
      dispatcher().Reported(request.worker(), false);
    }
    model_.ReportEnds(request.attempt(), QueueModel::Report::kFail, outcome);
    reply(outcome);
  });
}

// ---- News from the queue
void SimCoordinator::OnWorkReady() { dispatcher().OnWorkReady(); }

void SimCoordinator::OnStop(const std::string& worker, const v1::AttemptId& attempt,
                            const std::string& reason) {
  world_.story.Tell("coordinator: job {} attempt {:x} taken from {}: {}", attempt.job_id(),
                    attempt.fence(), worker, reason);
  model_.LeaseTaken(attempt, reason);
  dispatcher().OnStop(worker, attempt, reason);
}

void SimCoordinator::OnDrains(const std::vector<v1::DrainOrder>& drains) {
  dispatcher().OnDrains(drains);
}

}  // namespace parallax::faults
