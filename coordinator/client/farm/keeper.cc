#include "coordinator/client/farm/keeper.h"

#include <fmt/core.h>

#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

double SteadySeconds(Clock& clock) {
  return std::chrono::duration<double>(clock.Steady().time_since_epoch()).count();
}

}  // namespace

bool KeeperStep::finished() const {
  return view.demand.waiting + view.demand.leased == 0 && view.pilots.empty();
}

bool KeeperStep::did_something() const { return decision.submit > 0 || !decision.cancel.empty(); }

std::string KeeperStep::Line() const {
  std::string line = fmt::format("{} jobs wait, {} run; pilots: {} run, {} wait, {} wanted: ",
                                 FormatCount(view.demand.waiting), FormatCount(view.demand.leased),
                                 decision.running, decision.pending, decision.wanted);
  if (decision.submit > 0 && paused_s > 0) {
    return fmt::format("{}no worker came of the last ones; submits {} in {}", line, decision.submit,
                       FormatDuration(paused_s));
  }
  if (decision.submit > 0) {
    return fmt::format("{}{}{}{}", line, array.empty() ? "would submit " : "submitted ",
                       decision.submit,
                       array.empty() ? "" : (is_array ? " as array " : " as ") + array);
  }
  if (decision.cancel.empty()) return line + "nothing to do";
  return fmt::format("{}cancels {} that still wait", line, decision.cancel.size());
}

void FarmKeeper::Remember(const std::vector<v1::WorkerStatus>& workers) {
  for (const v1::WorkerStatus& worker : workers) {
    const bool connected = worker.state() == "idle" || worker.state() == "busy" ||
                           worker.state() == "draining" || worker.state() == "drained";
    if (connected && worker.name().starts_with(options_.worker_prefix)) fruitless_ = 0;
  }
}

absl::StatusOr<FarmView> FarmKeeper::See() {
  FarmView view;
  ASSIGN_OR_RETURN(const auto studies, world_.studies());
  ASSIGN_OR_RETURN(const auto workers, world_.workers());
  ASSIGN_OR_RETURN(view.pilots, world_.pilots());
  view.demand = DemandOf(studies);
  view.other_slots = OtherSlots(workers, options_.worker_prefix);
  Remember(workers);
  return view;
}

absl::StatusOr<KeeperStep> FarmKeeper::Look(bool dry) {
  KeeperStep step{.is_array = options_.arrays};
  ASSIGN_OR_RETURN(step.view, See());
  step.decision = Decide(step.view, options_.limits);
  if (dry) return step;
  RETURN_IF_ERROR(world_.cancel(step.decision.cancel));
  if (step.decision.submit == 0) return step;
  const double now_s = SteadySeconds(*world_.clock);
  if (fruitless_ > 0 && now_s < next_submission_s_) {
    step.paused_s = next_submission_s_ - now_s;
    return step;
  }
  ASSIGN_OR_RETURN(step.array, world_.submit(step.decision.submit));
  next_submission_s_ = now_s + SubmissionPause(options_.interval_s, ++fruitless_);
  return step;
}

}  // namespace parallax::client
