#include "coordinator/queue/commands/retries.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/base/status.h"
#include "coordinator/study/rigs.h"

namespace parallax {

absl::StatusOr<Study*> Retries::FindRetryable(int64_t id) {
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
  if (study->tally.cancelled) {
    return FailedPrecondition("study {} is cancelled: submit it again instead", id);
  }
  ASSIGN_OR_RETURN(const auto archived,
                   tables_.db.Integer("SELECT archived FROM studies WHERE id = ?1", id));
  if (archived.value_or(0) != 0) {
    return FailedPrecondition("study {} is archived: submit it again, what it has will be reused",
                              id);
  }
  if (study->tally.finished) RETURN_IF_ERROR(limits_.CheckUser(study->user, 1, 0));
  return study;
}

absl::StatusOr<int64_t> Retries::Retry(int64_t id, std::string_view reason,
                                       std::string_view actor) {
  ASSIGN_OR_RETURN(const Study* study, FindRetryable(id));
  int64_t retried = 0;
  std::vector<int64_t> others;
  for (const int64_t variant_id : study->variants) {
    ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(variant_id));
    VariantTally& tally = tables_.ledger.Change(*variant);
    tally.tally_solved = tally.tally_rejected = tally.tally_lost = 0;
    tally.pairs_before = tally.pairs_done;
    tally.problem.clear();
    tables_.hungry.insert(variant_id);
    ASSIGN_OR_RETURN(const std::vector<int64_t> lost, tables_.jobs.Lost(variant_id));
    for (const int64_t job_id : lost) {
      ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(job_id));
      if (!tables_.kinds[job.kind].traits().of_scene) {
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
    ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(job_id));
    ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
    ASSIGN_OR_RETURN(const bool again, RetryOther(*variant, job));
    retried += again ? 1 : 0;
  }
  RETURN_IF_ERROR(
      tables_.Audit(actor, "retry", id, fmt::format("{} jobs{}", retried, Because(reason))));
  return retried;
}

absl::Status Retries::RetryJob(int64_t id, int64_t job_id, std::string_view reason,
                               std::string_view actor) {
  RETURN_IF_ERROR(FindRetryable(id).status());
  ASSIGN_OR_RETURN(const std::optional<JobRow> job, tables_.jobs.Find(job_id));
  if (!job || job->study != id) return NotFound("study {} has no job {}", id, job_id);
  ASSIGN_OR_RETURN(const std::optional<JobRow> newest, tables_.jobs.FindNewest(job_id));
  if (newest && newest->id != job_id) {
    return FailedPrecondition("job {} was retried before, as job {}, which is {}", job_id,
                              newest->id, NameOf(newest->state));
  }
  RETURN_IF_ERROR(job->state == JobState::kRetryWait ? jobs_.Settle(job_id) : RetryLost(*job));
  return tables_.Audit(actor, "retry", id, fmt::format("job {}{}", job_id, Because(reason)));
}

absl::Status Retries::RetryLost(const JobRow& job) {
  if (job.state != JobState::kFailed && job.state != JobState::kQuarantined &&
      job.state != JobState::kCancelled) {
    return FailedPrecondition("job {} is {}: there is nothing to retry", job.id, NameOf(job.state));
  }
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  const bool of_scene = tables_.kinds[job.kind].traits().of_scene;
  ASSIGN_OR_RETURN(const bool again,
                   of_scene ? RetryOfScene(*variant, job) : RetryOther(*variant, job));
  if (again) return absl::OkStatus();
  return of_scene
             ? FailedPrecondition(
                   "job {}: another scene has taken the place of its own, so variant {} lacks no "
                   "pairs that it could make",
                   job.id, variant->name)
             : FailedPrecondition("job {} waits for a job that is lost: retry that one first",
                                  job.id);
}

// Retries a job if the variant still lacks pairs: a scene that was replaced is not made again.
absl::StatusOr<bool> Retries::RetryOfScene(Variant& variant, const JobRow& job) {
  const int64_t missing = variant.pairs_wanted - variant.tally.pairs_planned;
  // A smaller gap than this job's rigs is filled by a new scene.
  if (missing <= 0 || job.rig_count > missing) return false;
  ASSIGN_OR_RETURN(SceneRow * scene, tables_.scenes.Open(variant.id, job.ordinal, /*change=*/true));
  VariantTally& tally = tables_.ledger.Change(variant);
  NewJob again = jobs_.NextOf(job);
  if (job.rig_count > 0) {
    scene->rigs_lost -= job.rig_count;
    tally.pairs_planned += job.rig_count;
    ASSIGN_OR_RETURN(again.rigs, ParseRigs(job.rigs));
  } else {
    scene->rigs = static_cast<uint32_t>(std::min<int64_t>(scene->rigs, missing));
    scene->rigs_lost = 0;
    tally.pairs_planned += scene->rigs;
  }
  RETURN_IF_ERROR(jobs_.AddJob(again).status());
  return true;
}

// Retries a job without a scene. It waits again for the newest generations of the jobs that it
// waited for. While one of them is lost, there is nothing to retry.
absl::StatusOr<bool> Retries::RetryOther(Variant& variant, const JobRow& job) {
  NewJob again = jobs_.NextOf(job);
  ASSIGN_OR_RETURN(again.waits, waiters_.WaitsAgain(job));
  for (const JobWait& wait : again.waits) {
    ASSIGN_OR_RETURN(const Waiters::Outlook outlook, waiters_.OutlookOf(wait));
    if (outlook.prospect == Waiters::Prospect::kVain) return false;
  }
  --tables_.ledger.Change(variant).others_lost;
  RETURN_IF_ERROR(jobs_.AddJob(again).status());
  return true;
}

absl::Status Retries::Wake() {
  ASSIGN_OR_RETURN(
      const std::vector<int64_t> due,
      tables_.jobs.BackoffsDue(tables_.Now(), tables_.options.retry.backoff_max_s, 10'000));
  for (const int64_t id : due) RETURN_IF_ERROR(jobs_.Settle(id));
  return absl::OkStatus();
}

}  // namespace parallax
