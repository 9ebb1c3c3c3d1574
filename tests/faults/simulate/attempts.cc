// The part of a simulated worker that does the work and reports it.
#include <algorithm>

#include "tests/coordinator/queue/train_fixture.h"
#include "tests/faults/simulate/exact_math.h"
#include "tests/faults/simulate/work.h"
#include "tests/faults/simulate/worker.h"
#include "tests/job_messages.h"
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
  run.duration_s = world_.knobs.job_s * -Log(1 - dice_.Uniform()) + 1e-4;
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
    Submit(ReportOf(*run));
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
  // A trial of a search that fails for good ends, so that a calm farm would find another best one.
  const bool of_search = run.lease.study().starts_with("recipe-");
  if (world_.has_faults && !of_search && dice_.Bernoulli(knobs.fail_p)) {
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
  if (complete.kind() == "render") {
    EditRender(complete, [](v1::RenderResult& result) {
      for (v1::FrameResult& frame : *result.mutable_frames()) {
        (*frame.mutable_statistics())["mean_intensity"] = 100;
        (*frame.mutable_statistics())["min_depth_m"] = 1;
      }
    });
  }
  if (knobs.has_files) coordinator_.disk().PutFiles(complete);
  return {std::move(complete)};
}

// ---- Reports: as in worker/agent/session/report_sender.cc
void SimWorker::Submit(Report report) {
  if (!process_->outbox->Put(report).ok()) std::abort();
  unanswered_.insert({report.attempt().job_id(), report.attempt().fence()});
  coordinator_.model().Made(report.attempt(), process_->release);
  process_->reports->Add(std::move(report), /*leftover=*/false);
  SendNext();
}

std::vector<v1::AttemptId> SimWorker::Unanswered() const {
  return process_->reports->Pending(process_->link->coordinator_id());
}

void SimWorker::SendNext() {
  if (process_->in_flight != nullptr) return;
  ReportQueue::Entry* const next = process_->reports->Next();
  if (next == nullptr) return;
  if (next->due <= clock_.Steady()) return Send(next);
  Later(clock_.Until(next->due), [this] { SendNext(); });
}

// One call: its request or its reply may be lost, delayed or repeated.
void SimWorker::Send(ReportQueue::Entry* entry) {
  Process& process = *process_;
  const Key key{entry->report.attempt().job_id(), entry->report.attempt().fence()};
  if (!process.sent.insert(key).second && world_.mutation.send_once) return;
  if (world_.mutation.remove_early) process.outbox->Remove(entry->report).IgnoreError();
  process.in_flight = entry;
  const int64_t call = ++process.call;
  const auto answer = [this, call](const absl::StatusOr<v1::ReportOutcome>& outcome) {
    Later(0, [this, call, status = outcome.status()] {
      if (process_->call == call && process_->in_flight != nullptr) Answered(status);
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
  const auto arrive = [this, report = entry->report, reply] {
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

void SimWorker::Answered(const absl::Status& status) {
  Process& process = *process_;
  ReportQueue::Entry* const entry = std::exchange(process.in_flight, nullptr);
  if (ReportQueue::IsDefinitive(status)) {
    process.outbox->Remove(entry->report).IgnoreError();
    unanswered_.erase(Key{entry->report.attempt().job_id(), entry->report.attempt().fence()});
  }
  process.reports->Answered(entry, status);
  WakeSoon();
  SendNext();
}

}  // namespace parallax::faults
