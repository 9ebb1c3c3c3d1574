// Kind `noop`, for tests: the third kind of job, which proves that adding one takes a file on each
// side. Its jobs do nothing but wait and hand their input back. The coordinator's side; the
// worker's is noop_handler.h.
#pragma once

#include <functional>

#include "coordinator/queue/job_kind.h"

namespace parallax {

class NoopKind final : public JobKind {
 public:
  // `plan` adds a submitted study's noop jobs; null: none exist.
  using Plan =
      std::function<absl::Status(WorkDesk&, const v1::StudySpec&, std::span<const int64_t>)>;
  explicit NoopKind(Plan plan = nullptr);

  // For each variant: job 0 waits for all of its pairs, job 1 for job 0.
  static absl::Status AfterPairs(WorkDesk& desk, const v1::StudySpec& study,
                                 std::span<const int64_t> variants);

  // Spec: "<input> of <published pairs>". There is none for the input "?": kDataLoss.
  absl::StatusOr<std::string> Spec(const LeasedJob& lease, ResultReader& results) const override;
  // "" is a rejection, "!" can't be a result.
  std::shared_ptr<const CheckedResult> CheckResult(std::string_view bytes) const override;
  absl::StatusOr<JobKeys> Keys(WorkDesk& desk, const JobFacts& job) const override;
  absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                               const CheckedResult& result) const override;
  absl::Status OnSubmit(WorkDesk& desk, const v1::StudySpec& study,
                        std::span<const int64_t> variants) const override;

 private:
  const Plan plan_;
};

}  // namespace parallax
