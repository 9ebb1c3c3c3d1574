#include "tests/noop/noop_kind.h"

namespace parallax {
namespace {

struct CheckedNoop final : CheckedResult {
  std::string bytes;
};

}  // namespace

NoopKind::NoopKind(Plan plan)
    : JobKind("noop", {.doing = "idling", .may_reject = true}), plan_(std::move(plan)) {}

absl::Status NoopKind::AfterPairs(WorkDesk& desk, const v1::StudySpec& study,
                                  std::span<const int64_t> variants) {
  for (const int64_t id : variants) {
    ASSIGN_OR_RETURN(const VariantFacts variant, desk.VariantOf(id));
    const std::string input = study.name() + "/" + std::string(variant.name);
    ASSIGN_OR_RETURN(const int64_t first,
                     desk.AddJob({.kind = "noop",
                                  .variant = id,
                                  .ordinal = 0,
                                  .input = input,
                                  .waits = {JobWait::OnPairs(id, variant.pairs_wanted)}}));
    RETURN_IF_ERROR(desk.AddJob({.kind = "noop",
                                 .variant = id,
                                 .ordinal = 1,
                                 .input = input + " again",
                                 .waits = {JobWait::OnJob(first)}})
                        .status());
  }
  return absl::OkStatus();
}

absl::StatusOr<std::string> NoopKind::Spec(const LeasedJob& lease, ResultReader& results) const {
  if (lease.job.input == "?") return DataLoss("an input without meaning");
  ASSIGN_OR_RETURN(const auto frames, results.FramesOf(lease.job.variant, 10'000));
  return lease.job.input + " of " + std::to_string(frames.size());
}

std::shared_ptr<const CheckedResult> NoopKind::CheckResult(std::string_view bytes) const {
  auto out = std::make_shared<CheckedNoop>();
  out->bytes = bytes;
  if (bytes == "!") out->invalid = "a result that is none";
  return out;
}

absl::StatusOr<JobKeys> NoopKind::Keys(WorkDesk&, const JobFacts& job) const {
  const Sha256Digest key = Sha256Of("noop " + job.input);
  return JobKeys{key, key};
}

absl::StatusOr<Ending> NoopKind::Store(WorkDesk& desk, const JobFacts& job,
                                       const CheckedResult& result) const {
  const std::string& bytes = static_cast<const CheckedNoop&>(result).bytes;
  Ending ending{
      .rejected = bytes.empty(), .reason = bytes.empty() ? "nothing" : "", .result = bytes};
  RETURN_IF_ERROR(
      desk.PutResult(job, name(), job.work_key, {bytes, ending.rejected, ending.reason}).status());
  return ending;
}

absl::Status NoopKind::OnSubmit(WorkDesk& desk, const v1::StudySpec& study,
                                std::span<const int64_t> variants) const {
  return plan_ ? plan_(desk, study, variants) : absl::OkStatus();
}

}  // namespace parallax
