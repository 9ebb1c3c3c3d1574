// The reports on attempts, as messages for the coordinator. Pure functions.
#pragma once

#include <string>

#include "common/base/status.h"
#include "parallax/v1/service.pb.h"
#include "worker/agent/attempts/job_handler.h"
#include "worker/agent/attempts/outbox.h"

namespace parallax {

// The names that every report carries.
struct ReportNames {
  std::string worker;
  std::string coordinator_id;  // The coordinator that gave the lease.
};

// Reports a result. `wall_s` and `cpu_s` are the seconds that the attempt took.
Report CompleteReport(const v1::Lease& lease, const ReportNames& names, const JobOutcome& outcome,
                      double wall_s, double cpu_s);
// Reports a failure at `place`; see DescribeFailure. `status` may carry a log; see WithLogTail.
Report FailReport(const v1::Lease& lease, const ReportNames& names, const absl::Status& status,
                  const std::string& place);
// Reports that the worker can't begin with the lease, for the reason `status`.
Report UnusableReport(const v1::Lease& lease, const ReportNames& names, const absl::Status& status);

}  // namespace parallax
