// A manual retry: jobs that were lost get a new generation.
#include <fmt/core.h>

#include <algorithm>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/study/rigs.h"

namespace parallax {

absl::StatusOr<int64_t> Machine::Retry(int64_t id, std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  if (study->tally.cancelled) {
    return FailedPrecondition("study {} is cancelled: submit it again instead", id);
  }
  ASSIGN_OR_RETURN(const auto archived,
                   db_.Integer("SELECT archived FROM studies WHERE id = ?1", id));
  if (archived.value_or(0) != 0) {
    return FailedPrecondition("study {} is archived: submit it again, what it has will be reused",
                              id);
  }
  if (study->tally.finished) RETURN_IF_ERROR(CheckUser(study->user, 1, 0));
  int64_t retried = 0;
  std::vector<int64_t> others;
  for (const int64_t variant_id : study->variants) {
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(variant_id));
    VariantTally& tally = ledger_.Change(*variant);
    tally.tally_solved = tally.tally_rejected = tally.tally_lost = 0;
    tally.pairs_before = tally.pairs_done;
    tally.problem.clear();
    hungry_.insert(variant_id);
    ASSIGN_OR_RETURN(const std::vector<int64_t> lost, store_.Lost(variant_id));
    for (const int64_t job_id : lost) {
      ASSIGN_OR_RETURN(const JobRow job, RowOf(job_id));
      if (!KindOf(job).traits().of_scene) {
        others.push_back(job_id);
        continue;
      }
      ASSIGN_OR_RETURN(const bool again, RetryOfScene(*variant, job));
      retried += again ? 1 : 0;
    }
  }
  // A job only waits for older ones, so that what it waits for is retried before it.
  std::sort(others.begin(), others.end());
  for (const int64_t job_id : others) {
    ASSIGN_OR_RETURN(const JobRow job, RowOf(job_id));
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
    ASSIGN_OR_RETURN(const bool again, RetryOther(*variant, job));
    retried += again ? 1 : 0;
  }
  RETURN_IF_ERROR(Audit(actor, "retry", id, fmt::format("{} jobs", retried)));
  return retried;
}

// Retries a job if the variant still lacks pairs: a scene that was replaced is not made again.
absl::StatusOr<bool> Machine::RetryOfScene(Variant& variant, const JobRow& job) {
  const int64_t missing = variant.pairs_wanted - variant.tally.pairs_planned;
  // A smaller gap than this job's rigs is filled by a new scene.
  if (missing <= 0 || job.rig_count > missing) return false;
  ASSIGN_OR_RETURN(SceneRow * scene, OpenScene(variant.id, job.ordinal, /*change=*/true));
  VariantTally& tally = ledger_.Change(variant);
  NewJob again{.kind = KindOf(job).name(),
               .variant = variant.id,
               .ordinal = job.ordinal,
               .input = job.input,
               .generation = job.generation + 1};
  if (job.rig_count > 0) {
    scene->rigs_lost -= job.rig_count;
    tally.pairs_planned += job.rig_count;
    auto rigs = ParseRigs(job.rigs);
    RETURN_IF_ERROR(rigs.status());
    again.rigs = *std::move(rigs);
  } else {
    scene->rigs = static_cast<uint32_t>(std::min<int64_t>(scene->rigs, missing));
    scene->rigs_lost = 0;
    tally.pairs_planned += scene->rigs;
  }
  RETURN_IF_ERROR(AddJob(again).status());
  return true;
}

// Retries a job without a scene. It waits again for the newest generations of the jobs that it
// waited for. While one of them is lost, there is nothing to retry.
absl::StatusOr<bool> Machine::RetryOther(Variant& variant, const JobRow& job) {
  NewJob again{.kind = KindOf(job).name(),
               .variant = variant.id,
               .ordinal = job.ordinal,
               .input = job.input,
               .generation = job.generation + 1};
  ASSIGN_OR_RETURN(again.waits, waits_.Of(job.id));
  for (JobWait& wait : again.waits) {
    if (wait.on_job != 0) {
      ASSIGN_OR_RETURN(const std::optional<JobRow> newest, store_.FindNewest(wait.on_job));
      if (newest) wait.on_job = newest->id;
    }
    ASSIGN_OR_RETURN(const Outlook outlook, OutlookOf(wait));
    if (outlook.prospect == Prospect::kVain) return false;
  }
  --ledger_.Change(variant).others_lost;
  RETURN_IF_ERROR(AddJob(again).status());
  return true;
}

}  // namespace parallax
