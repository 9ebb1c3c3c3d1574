// Counts the outcomes of workers' reports and adds up the work in accepted results, for /metrics.
// Thread-safe.
#pragma once

#include <map>
#include <mutex>
#include <string>

#include "common/base/status.h"
#include "coordinator/queue/job_kind.h"
#include "coordinator/rpc/coordinator_server.h"
#include "parallax/v1/service.pb.h"

namespace parallax {

class ReportMeter {
 public:
  // Counts a report by the name of its outcome or error; `if_ok` stands for REPORT_OUTCOME_OK.
  void Count(const absl::StatusOr<v1::ReportOutcome>& outcome, const char* if_ok);
  // Adds the work that an accepted result reports. `kind` is the kind of the result's job.
  void AddWork(const v1::CompleteRequest& request, const JobKind& kind);
  void AddTo(ServerMetrics& metrics) const;  // Sets `reports`, `stages` and `work`.

 private:
  mutable std::mutex mu_;
  // Guarded by mu_.
  std::map<std::string, int64_t> reports_;
  std::map<std::string, ServerMetrics::Stage> stages_;
  std::map<std::string, ServerMetrics::Work> work_;
};

}  // namespace parallax
