#include "worker/agent/attempts/attempt_report.h"

#include "worker/agent/attempts/failure.h"

namespace parallax {
namespace {

template <typename Request>
Request RequestOf(const v1::Lease& lease, const ReportNames& names) {
  Request request;
  *request.mutable_attempt() = lease.attempt();
  request.set_worker(names.worker);
  request.set_coordinator_id(names.coordinator_id);
  return request;
}

}  // namespace

Report CompleteReport(const v1::Lease& lease, const ReportNames& names, const JobOutcome& outcome,
                      double wall_s, double cpu_s) {
  auto complete = RequestOf<v1::CompleteRequest>(lease, names);
  complete.set_wall_s(wall_s);
  complete.set_cpu_s(cpu_s);
  complete.set_kind(lease.kind());
  complete.set_result(outcome.result);
  return {std::move(complete)};
}

Report FailReport(const v1::Lease& lease, const ReportNames& names, const absl::Status& status,
                  const std::string& place) {
  const Failure failure = DescribeFailure(status, place);
  auto fail = RequestOf<v1::FailRequest>(lease, names);
  fail.set_error(failure.error);
  fail.set_fingerprint(failure.fingerprint);
  fail.set_retryable(failure.retryable);
  fail.set_log_tail(LogTailOf(status));
  return {std::move(fail)};
}

Report UnusableReport(const v1::Lease& lease, const ReportNames& names,
                      const absl::Status& status) {
  auto fail = RequestOf<v1::FailRequest>(lease, names);
  fail.set_error(DescribeFailure(status, "lease").error);
  fail.set_fingerprint(absl::StatusCodeToString(status.code()) + "@lease");
  return {std::move(fail)};
}

}  // namespace parallax
