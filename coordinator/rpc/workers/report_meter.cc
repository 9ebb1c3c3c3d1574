#include "coordinator/rpc/workers/report_meter.h"

#include <algorithm>

namespace parallax {
namespace {

constexpr size_t kMostStages = 32;

// "REPORT_OUTCOME_OK" -> "OK"
std::string ShortName(v1::ReportOutcome outcome) {
  const std::string name = v1::ReportOutcome_Name(outcome);
  constexpr std::string_view kPrefix = "REPORT_OUTCOME_";
  return name.size() > kPrefix.size() ? name.substr(kPrefix.size()) : name;
}

}  // namespace

void ReportMeter::Count(const absl::StatusOr<v1::ReportOutcome>& outcome, const char* if_ok) {
  const std::string name = !outcome.ok() ? absl::StatusCodeToString(outcome.status().code())
                           : *outcome == v1::REPORT_OUTCOME_OK ? if_ok
                                                               : ShortName(*outcome);
  std::lock_guard lock(mu_);
  ++reports_[name];
}

void ReportMeter::AddWork(const v1::CompleteRequest& request, const JobKind& kind) {
  std::lock_guard lock(mu_);
  for (const JobKind::StageSeconds& stage : kind.StagesOf(request.result())) {
    if (!(stage.seconds > 0)) continue;
    // Names come from workers: no more than there can be stages.
    if (stages_.count(stage.stage) == 0 && stages_.size() >= kMostStages) continue;
    ServerMetrics::Stage& total = stages_[stage.stage];
    ++total.count;
    total.seconds += stage.seconds;
  }
  ServerMetrics::Work& work = work_[request.kind()];
  ++work.jobs;
  work.wall_s += std::max(0.0, request.wall_s());
  work.cpu_s += std::max(0.0, request.cpu_s());
}

void ReportMeter::AddTo(ServerMetrics& metrics) const {
  std::lock_guard lock(mu_);
  metrics.reports = reports_;
  metrics.stages = stages_;
  metrics.work = work_;
}

}  // namespace parallax
