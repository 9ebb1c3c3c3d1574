// The part of a simulated worker that does the work and reports it.
#include <algorithm>
#include <cmath>

#include "tests/faults/life.h"
#include "tests/faults/simulate/worker.h"
#include "tests/noop/noop_kind.h"

namespace parallax::faults {

// ---- Slots: as in worker/agent/attempts/job_slots.cc
void SimWorker::FillSlots() {
  auto& runs = process_->runs;
  auto working = std::count_if(runs.begin(), runs.end(), [](const Run& r) { return r.working; });
  for (Run& run : runs) {
    if (working >= process_->options.slots) return;
    if (run.working) continue;
    ++working;
    Begin(run);
  }
}

void SimWorker::Begin(Run& run) {
  run.working = true;
  run.started = clock_.Steady();
  // Most jobs are short, few are ten times as long.
  run.duration_s = world_.knobs.job_s * -std::log(1 - dice_.Uniform()) + 1e-4;
  if (world_.has_faults && dice_.Bernoulli(0.03)) run.duration_s *= 10;
  const Key key{run.lease.attempt().job_id(), run.lease.attempt().fence()};
  if (world_.has_faults && dice_.Bernoulli(world_.knobs.kill_p)) {
    Later(run.duration_s * dice_.Uniform(),
          [this] { Die("is killed by its job", world_.Next(world_.knobs.worker_away_s)); });
  }
  Later(run.duration_s, [this, key] { EndRun(key); });
}

void SimWorker::Stop(Run& run, StopCause cause) {
  if (run.stop != StopCause::kNone) return;
  run.stop = cause;
  // It notices soon, or not before it has ended.
  const Key key{run.lease.attempt().job_id(), run.lease.attempt().fence()};
  if (dice_.Bernoulli(0.9)) {
    Later(world_.knobs.agent.hand_back_s * dice_.Uniform(), [this, key] { EndRun(key); });
  }
}

void SimWorker::EndRun(const Key& key) {
  Process& process = *process_;
  const auto run = std::find_if(process.runs.begin(), process.runs.end(), [&](const Run& other) {
    return Key{other.lease.attempt().job_id(), other.lease.attempt().fence()} == key;
  });
  if (run == process.runs.end()) return;
  const bool whole =
      run->working && SecondsBetween(run->started, clock_.Steady()) >= run->duration_s * 0.9;
  process.retirement->Ended(key, clock_.Steady());
  if (run->stop == StopCause::kNone || (run->stop == StopCause::kHandBack && whole)) {
    Submit(ReportOf(*run), /*leftover=*/false);
  } else if (run->stop == StopCause::kHandBack) {
    process.link->HandBack(run->lease.attempt(), "drained");
  }
  process.runs.erase(run);
  FillSlots();
  WakeSoon();
}

Report SimWorker::ReportOf(const Run& run) {
  const Knobs& knobs = world_.knobs;
  const std::string id = process_->link->coordinator_id();
  if (world_.has_faults && dice_.Bernoulli(knobs.fail_p)) {
    v1::FailRequest fail =
        Failure(run.lease, name_, dice_.Bernoulli(0.5) ? "bang" : "boom", dice_.Bernoulli(0.9));
    fail.set_coordinator_id(id);
    return {std::move(fail)};
  }
  const bool rejects =
      run.lease.kind() == "solve" && world_.has_faults && dice_.Bernoulli(knobs.reject_p);
  v1::CompleteRequest complete =
      rejects ? RejectAnswer(run.lease, name_, dice_.Bernoulli(0.5)) : AnswerOf(run.lease, name_);
  complete.set_coordinator_id(id);
  return {std::move(complete)};
}

// ---- Reports: as in worker/agent/session/report_sender.cc
void SimWorker::Submit(Report report, bool leftover) {
  Process& process = *process_;
  const Key key{report.attempt().job_id(), report.attempt().fence()};
  outbox_[key] = report;
  unanswered_.insert(key);
  using Seconds = Backoff::Seconds;
  process.reports.push_back({.report = std::move(report),
                             .backoff = Backoff(dice_.Child("report", key.second),
                                                Seconds(process.options.reports.backoff_base_s),
                                                Seconds(process.options.reports.backoff_cap_s)),
                             .leftover = leftover});
  SendNext();
}

std::vector<v1::AttemptId> SimWorker::Unanswered() const {
  std::vector<v1::AttemptId> attempts;
  for (const Pending& pending : process_->reports) attempts.push_back(pending.report.attempt());
  return attempts;
}

void SimWorker::SendNext() {
  Process& process = *process_;
  if (process.in_flight || !process.reporting_to) return;
  Pending* next = nullptr;
  for (Pending& pending : process.reports) {
    if (world_.mutation == Mutation::kSendOnce && pending.sent) continue;
    if (next == nullptr || pending.due < next->due) next = &pending;
  }
  if (next == nullptr) return;
  if (next->due <= clock_.Steady()) return Send(*next);
  Later(clock_.Until(next->due), [this] { SendNext(); });
}

// One call: its request or its reply may be lost, delayed or repeated.
void SimWorker::Send(Pending& pending) {
  Process& process = *process_;
  const Key key{pending.report.attempt().job_id(), pending.report.attempt().fence()};
  pending.sent = true;
  process.in_flight = key;
  const int64_t call = ++process.call;
  const auto answer = [this, call, key](const absl::StatusOr<v1::ReportOutcome>& outcome) {
    Later(0, [this, call, key, outcome] {
      if (process_->call == call && process_->in_flight == key) Answered(key, outcome);
    });
  };
  const auto reply = [this, life = lives_,
                      answer](const absl::StatusOr<v1::ReportOutcome>& outcome) {
    const bool lost = line_.down_closed_until_s > world_.schedule.now() ||
                      (world_.has_faults && dice_.Bernoulli(world_.knobs.loss_p));
    if (lost) return world_.story.Tell("{}: a reply to it is lost", name_);
    world_.schedule.After(world_.Delay(), [this, life, answer, outcome] {
      if (Lives(life)) answer(outcome);
    });
  };
  const auto arrive = [this, report = pending.report, reply] {
    coordinator_.Enter([this, &report, &reply] {
      if (const auto* complete = std::get_if<v1::CompleteRequest>(&report.body)) {
        coordinator_.Complete(*complete, reply);
      } else {
        coordinator_.Fail(std::get<v1::FailRequest>(report.body), reply);
      }
    });
  };
  const bool lost = line_.up_closed_until_s > world_.schedule.now() ||
                    (world_.has_faults && dice_.Bernoulli(world_.knobs.loss_p));
  if (!lost) world_.schedule.After(world_.Delay(), arrive);
  if (world_.has_faults && dice_.Bernoulli(world_.knobs.repeat_p)) {
    world_.schedule.After(10 * world_.Delay(), arrive);
  }
  Later(process.options.reports.timeout_s,
        [answer] { answer(DeadlineExceeded("no answer to a report")); });
}

void SimWorker::Answered(const Key& key, const absl::StatusOr<v1::ReportOutcome>& outcome) {
  Process& process = *process_;
  process.in_flight.reset();
  const auto pending =
      std::find_if(process.reports.begin(), process.reports.end(), [&](const Pending& other) {
        return Key{other.report.attempt().job_id(), other.report.attempt().fence()} == key;
      });
  if (pending == process.reports.end()) return;
  if (outcome.ok() || absl::IsInvalidArgument(outcome.status())) {
    outbox_.erase(key);
    unanswered_.erase(key);
    process.reports.erase(pending);
  } else {
    pending->tried = true;
    pending->due = SecondsAfter(clock_.Steady(), pending->backoff.Next().count());
  }
  WakeSoon();
  SendNext();
}

}  // namespace parallax::faults
