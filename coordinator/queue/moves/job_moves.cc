#include "coordinator/queue/moves/job_moves.h"

#include <fmt/core.h>

#include <algorithm>

#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/moves/waiters.h"
#include "coordinator/study/expansion.h"
#include "coordinator/study/rigs.h"

namespace parallax {

std::string AttemptFolder(const JobRow& job) {
  return fmt::format("{}/.attempt-{}", StorePrefixOf(job.work_key), job.fence);
}

// ---- Where a job belongs
absl::StatusOr<JobStanding> JobMoves::StandingOf(const JobRow& job) {
  const JobKind& kind = tables_.kinds[job.kind];
  ASSIGN_OR_RETURN(KnownWork known, kind.Look(*this, job));
  if (known.state == KnownWork::State::kDone) {
    return JobStanding{.state = JobState::kSucceeded, .result = std::move(known.result)};
  }
  if (known.state == KnownWork::State::kRejected) {
    return JobStanding{.state = JobState::kRejected, .rejected = std::move(known.reason)};
  }
  const bool alone = kind.traits().shares_part && known.part_missing;
  ASSIGN_OR_RETURN(JobStanding standing, StandingAmongLeased(job, alone));
  standing.part_missing = alone;
  return standing;
}

absl::StatusOr<JobStanding> JobMoves::StandingAmongLeased(const JobRow& job, bool whole_group) {
  JobStanding standing;
  ASSIGN_OR_RETURN(const std::vector<JobRow> leased, tables_.jobs.LeasedInGroup(job.group_key));
  for (const JobRow& leader : leased) {
    if (leader.kind != job.kind) continue;
    if (leader.work_key == job.work_key || (whole_group && !leader.part_given)) {
      standing.state = JobState::kBlocked;
      standing.awaits_job = leader.id;
      break;
    }
  }
  return standing;
}

NewJob JobMoves::NextOf(const JobRow& job) const {
  return {.kind = tables_.kinds[job.kind].name(),
          .variant = job.variant,
          .ordinal = job.ordinal,
          .input = job.input,
          .generation = job.generation + (tables_.options.unsafe_for_test.keep_generation ? 0 : 1)};
}

absl::StatusOr<bool> JobMoves::TakeNewKeys(JobRow& job) {
  const JobKind& kind = tables_.kinds[job.kind];
  // Pictures are stored under the keys of the release that takes them in.
  if (kind.traits().of_scene && !kind.traits().begins_scenes) return false;
  ASSIGN_OR_RETURN(const JobKeys keys, kind.Keys(*this, job));
  if (keys.work == job.work_key && keys.group == job.group_key) return false;
  RETURN_IF_ERROR(tables_.jobs.SetKeys(job.id, keys));
  job.work_key = keys.work;
  job.group_key = keys.group;
  // Attempts under the old keys are not resumed.
  RETURN_IF_ERROR(tables_.folders.SweepUnwanted(tables_.Now()));
  return true;
}

absl::Status JobMoves::Settle(int64_t id, bool waits_met) {
  ASSIGN_OR_RETURN(JobRow job, tables_.jobs.Get(id));
  if (IsTerminal(job.state)) return absl::OkStatus();  // Its variant gave up meanwhile.
  if (job.waits_open > 0 && !waits_met) return absl::OkStatus();
  if (waits_met) RETURN_IF_ERROR(TakeNewKeys(job).status());
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  ASSIGN_OR_RETURN(const JobStanding standing, StandingOf(job));
  switch (standing.state) {
    case JobState::kReady:
      if (job.state == JobState::kReady) return absl::OkStatus();
      RETURN_IF_ERROR(tables_.jobs.MoveToReady(id, tables_.Now()));
      if (standing.part_missing) tables_.without_part.insert(id);
      tables_.effects.work_ready = true;
      break;
    case JobState::kBlocked:
      if (job.state == JobState::kBlocked && job.awaits_job == standing.awaits_job) {
        return absl::OkStatus();
      }
      RETURN_IF_ERROR(tables_.jobs.MoveToBlocked(id, standing.awaits_job));
      break;
    default:
      RETURN_IF_ERROR(
          tables_.jobs.MoveToReused(id, standing.state, standing.rejected, tables_.Now()));
  }
  tables_.NoteMove(*variant, job, standing.state);
  if (standing.state == JobState::kRejected) {
    return EnterLoss(job, *variant, JobState::kRejected);
  }
  if (standing.state != JobState::kSucceeded) return absl::OkStatus();
  return EnterSuccess(job, *variant, {.result = standing.result}, /*by_own_attempt=*/false);
}

absl::Status JobMoves::ReleaseFollowers(int64_t leader) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> followers, tables_.jobs.Followers(leader));
  for (const int64_t follower : followers) RETURN_IF_ERROR(Settle(follower));
  return absl::OkStatus();
}

absl::Status JobMoves::BlockSiblings(const JobRow& leader, bool whole_group) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> ready, tables_.jobs.ReadyInGroup(leader.group_key));
  for (const int64_t id : ready) {
    ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(id));
    if (job.kind != leader.kind || (!whole_group && job.work_key != leader.work_key)) continue;
    ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
    RETURN_IF_ERROR(tables_.jobs.MoveToBlocked(id, leader.id));
    tables_.without_part.erase(id);
    tables_.NoteMove(*variant, job, JobState::kBlocked);
  }
  return absl::OkStatus();
}

// ---- New jobs
absl::StatusOr<int64_t> JobMoves::AddJob(const NewJob& asked) {
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(asked.variant));
  JobRow job;
  ASSIGN_OR_RETURN(job.kind, tables_.kinds.IdOf(asked.kind));
  job.study = variant->study;
  job.variant = variant->id;
  job.ordinal = asked.ordinal;
  job.rigs = RigsText(asked.rigs);
  job.rig_count = static_cast<uint32_t>(asked.rigs.size());
  job.input = asked.input;
  job.generation = asked.generation;
  const JobKind& kind = tables_.kinds[job.kind];
  const JobTraits& traits = kind.traits();
  if (traits.resumes && !traits.of_scene && job.input.empty()) {
    return Internal("a {} job without input", kind.name());
  }
  if (!asked.is_fresh) RETURN_IF_ERROR(kind.Trim(*this, job));
  ASSIGN_OR_RETURN(const JobKeys keys, kind.Keys(*this, job));
  job.work_key = keys.work;
  job.group_key = keys.group;
  ASSIGN_OR_RETURN(const JobStanding standing, asked.is_fresh && !traits.shares_part
                                                   ? StandingAmongLeased(job, /*whole_group=*/false)
                                                   : StandingOf(job));
  job.state = standing.state;
  job.awaits_job = standing.awaits_job;
  job.reused = IsTerminal(standing.state);
  job.error = standing.rejected;
  std::vector<const char*> waits;
  if (!IsTerminal(job.state)) {
    ASSIGN_OR_RETURN(waits, waiters_.Plan(asked.waits, job));
  }

  RETURN_IF_ERROR(tables_.jobs.Insert(job, tables_.Now()));
  for (size_t i = 0; i < waits.size(); ++i) {
    RETURN_IF_ERROR(tables_.waits.Insert(job.id, asked.waits[i], waits[i]));
  }
  tables_.ledger.CountNew(*variant, job.kind, job.state);
  if (job.state == JobState::kReady) tables_.CountReady(job, 1);
  if (traits.of_scene) {
    RETURN_IF_ERROR(tables_.ChangeScene(*variant, job.ordinal, {.jobs_open = 1}).status());
  }
  if (job.state == JobState::kReady) {
    if (standing.part_missing) tables_.without_part.insert(job.id);
    tables_.effects.work_ready = true;
  } else if (job.state == JobState::kSucceeded) {
    RETURN_IF_ERROR(EnterSuccess(job, *variant, {.result = standing.result}, false));
  } else if (IsTerminal(job.state)) {
    RETURN_IF_ERROR(EnterLoss(job, *variant, job.state));
  }
  return job.id;
}

// ---- Ends
absl::Status JobMoves::EnterSuccess(const JobRow& job, Variant& variant, const Ending& ending,
                                    bool by_own_attempt) {
  const JobKind& kind = tables_.kinds[job.kind];
  if (kind.traits().begins_scenes && !by_own_attempt)
    ++tables_.ledger.Change(variant).solves_reused;
  RETURN_IF_ERROR(kind.OnSuccess(*this, job, ending, by_own_attempt));
  if (kind.traits().of_scene) {
    return tables_.ChangeScene(variant, job.ordinal, {.jobs_open = -1}).status();
  }
  if (kind.traits().has_output) RETURN_IF_ERROR(tables_.results.InsertStudyResult(job));
  return kind.traits().resumes ? tables_.folders.SweepDone(job.work_key, tables_.Now())
                               : absl::OkStatus();
}

absl::Status JobMoves::EnterLoss(const JobRow& job, Variant& variant, JobState state) {
  if (!tables_.kinds[job.kind].traits().of_scene) {
    ++tables_.ledger.Change(variant).others_lost;
    return absl::OkStatus();
  }
  SceneChange change{.jobs_open = -1};
  change.all_lost = job.rig_count == 0;
  change.rigs_lost = static_cast<int>(job.rig_count);
  RETURN_IF_ERROR(tables_.ChangeScene(variant, job.ordinal, change).status());
  VariantTally& tally = tables_.ledger.Change(variant);
  if (state == JobState::kRejected) {
    ++tally.scenes_rejected;
    ++tally.tally_rejected;
  } else if (state != JobState::kCancelled) {
    ++tally.tally_lost;
  }
  return state == JobState::kCancelled ? absl::OkStatus() : GiveUpIfHopeless(variant, job.id);
}

absl::Status JobMoves::GiveUpIfHopeless(Variant& variant, int64_t job) {
  if (!variant.tally.problem.empty()) return absl::OkStatus();
  const VariantTally& tally = variant.tally;
  SceneTally scenes{.solved = tally.tally_solved,
                    .rejected = tally.tally_rejected,
                    .lost = tally.tally_lost,
                    .pairs = tally.pairs_done - tally.pairs_before};
  if (GiveUpReason(scenes).empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const JobRow last, tables_.jobs.Get(job));
  scenes.last_reason = last.error;
  const std::string reason = GiveUpReason(scenes);
  tables_.ledger.Change(variant).problem = reason;
  tables_.changed_variants.insert(variant.id);
  RETURN_IF_ERROR(tables_.Audit("coordinator", "give up", variant.study,
                                "variant " + variant.name + ": " + reason));
  // Other jobs are in a variant only to be numbered: those that need its pairs wait for them and
  // end with their waits, a baseline needs none.
  return CancelAll(variant.study, variant.id, "the variant gave up: " + reason,
                   /*only_of_scenes=*/true);
}

absl::Status JobMoves::CancelAll(int64_t study, int64_t variant_id, const std::string& reason,
                                 bool only_of_scenes) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> ids, tables_.jobs.Unfinished(study, variant_id));
  for (const int64_t id : ids) {
    ASSIGN_OR_RETURN(const JobRow job, tables_.jobs.Get(id));
    if (only_of_scenes && !tables_.kinds[job.kind].traits().of_scene) continue;
    // Releasing the followers of one may have ended another.
    if (!IsTerminal(job.state)) RETURN_IF_ERROR(Cancel(job, reason));
  }
  return absl::OkStatus();
}

absl::Status JobMoves::Cancel(const JobRow& job, const std::string& reason) {
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  RETURN_IF_ERROR(tables_.jobs.MoveToCancelled(job.id, reason, tables_.Now()));
  if (job.waits_open > 0) RETURN_IF_ERROR(tables_.waits.Drop(job.id));
  tables_.without_part.erase(job.id);
  tables_.NoteMove(*variant, job, JobState::kCancelled);
  // Before its scene may be over, with which goes what was kept of it.
  if (job.state == JobState::kLeased) RETURN_IF_ERROR(Litter(job));
  RETURN_IF_ERROR(EnterLoss(job, *variant, JobState::kCancelled));
  if (job.state != JobState::kLeased) return absl::OkStatus();
  --tables_.leased_now;
  tables_.effects.ended.push_back(
      {.job = job.id, .fence = job.fence, .worker = job.worker, .stop = true, .reason = reason});
  return ReleaseFollowers(job.id);
}

absl::Status JobMoves::Litter(const JobRow& job) {
  const JobTraits& traits = tables_.kinds[job.kind].traits();
  if (!traits.has_output) return absl::OkStatus();
  if (!traits.resumes) return tables_.folders.InsertLitter(AttemptFolder(job), tables_.Now());
  std::optional<KeptFor> scene;
  if (traits.of_scene) scene = KeptFor{job.variant, job.ordinal};
  ASSIGN_OR_RETURN(const Sha256Digest keep_key, tables_.kinds[job.kind].KeepKey(*this, job));
  return tables_.folders.Keep(AttemptFolder(job), keep_key, scene, tables_.Now());
}

// ---- The desk of kinds
absl::StatusOr<VariantFacts> JobMoves::VariantOf(int64_t id) {
  ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(id));
  return VariantFacts{.id = id,
                      .name = variant->name,
                      .seed = variant->seed,
                      .pairs_wanted = variant->pairs_wanted,
                      .rigs_per_scene = variant->rigs_per_scene,
                      .config = variant->config.get(),
                      .digests = &variant->digests};
}

absl::StatusOr<SceneFacts> JobMoves::SceneOf(int64_t variant, uint32_t ordinal) {
  ASSIGN_OR_RETURN(const SceneRow* scene, tables_.scenes.Open(variant, ordinal, /*change=*/false));
  return SceneFacts{scene->rigs, scene->scene_hash};
}

absl::StatusOr<JobFacts> JobMoves::NewestOf(int64_t id) {
  ASSIGN_OR_RETURN(std::optional<JobRow> job, tables_.jobs.FindNewest(id));
  if (job) return JobFacts(*std::move(job));
  return Internal("job {}: no such", id);
}

absl::StatusOr<std::optional<StoredResult>> JobMoves::FindResult(const Sha256Digest& key) {
  std::string stage;
  ASSIGN_OR_RETURN(std::optional<StoredResult> result, tables_.results.Find(key, &stage));
  if (result && !FilesAreThere(key, stage, result->bytes)) result.reset();
  return result;
}

absl::StatusOr<bool> JobMoves::HasResult(const Sha256Digest& key) {
  if (!tables_.options.files_there) return tables_.results.Has(key);
  ASSIGN_OR_RETURN(const std::optional<StoredResult> result, FindResult(key));
  return result.has_value();
}

bool JobMoves::FilesAreThere(const Sha256Digest& key, std::string_view stage,
                             std::string_view bytes) {
  if (!tables_.options.files_there || tables_.ending_fence != 0) return true;
  const std::vector<JobKind::OutputFile> files = tables_.kinds.StoredFiles(stage, bytes);
  if (files.empty() || tables_.options.files_there(files)) return true;
  const bool known = std::any_of(tables_.missing.begin(), tables_.missing.end(),
                                 [&key](const DamagedResult& other) { return other.key == key; });
  if (!known)
    tables_.missing.push_back({key, CommonFolder(files), "its files are not in the store"});
  return false;
}

absl::StatusOr<bool> JobMoves::PutResult(const JobFacts& by, std::string_view stage,
                                         const Sha256Digest& key, const StoredResult& result) {
  if (tables_.ending_fence == 0) {
    return Internal("job {}: a result that no attempt has made", by.id);
  }
  StoredResult kept = result;
  kept.reason = OneLine(result.reason);
  return tables_.results.Insert(key, stage, kept, by.id, tables_.ending_fence);
}

absl::Status JobMoves::SetScene(const JobFacts& job, const Sha256Digest& scene_hash) {
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  ++tables_.ledger.Change(*variant).tally_solved;
  return tables_.ChangeScene(*variant, job.ordinal, {.scene_hash = scene_hash}).status();
}

absl::Status JobMoves::Publish(const JobFacts& job, std::span<const FrameLink> frames) {
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  int64_t reused = 0;
  for (const FrameLink& frame : frames) {
    RETURN_IF_ERROR(tables_.results.InsertFrame(job, frame));
    reused += frame.reused ? 1 : 0;
  }
  if (reused > 0) tables_.ledger.Change(*variant).frames_reused += reused;
  return tables_.ChangeScene(*variant, job.ordinal, {.rigs_done = static_cast<int>(frames.size())})
      .status();
}

absl::Status JobMoves::Discard(std::string_view path) {
  return tables_.folders.InsertLitter(std::string(path), tables_.Now());
}

}  // namespace parallax
