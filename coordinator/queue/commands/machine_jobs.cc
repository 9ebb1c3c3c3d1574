// Jobs come, move and go; what each of that means for followers, scenes and counters.
#include <algorithm>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"
#include "coordinator/study/rigs.h"

namespace parallax {
absl::StatusOr<JobRow> Machine::RowOf(int64_t id) {
  ASSIGN_OR_RETURN(std::optional<JobRow> job, store_.Find(id));
  if (job) return *std::move(job);
  return Internal("job {}: its row is gone", id);
}

// ---- Where a job belongs ------------------------------------------------------------------------
absl::StatusOr<Machine::Standing> Machine::StandingOf(const JobRow& job) {
  const JobKind& kind = KindOf(job);
  ASSIGN_OR_RETURN(KnownWork known, kind.Look(*this, job));
  switch (known.state) {
    case KnownWork::State::kDone:
      return Standing{.state = JobState::kSucceeded, .result = std::move(known.result)};
    case KnownWork::State::kRejected:
      return Standing{.state = JobState::kRejected, .rejected = std::move(known.reason)};
    case KnownWork::State::kOpen:
      break;
  }
  const bool alone = kind.traits().shares_part && known.part_missing;
  ASSIGN_OR_RETURN(Standing standing, StandingAmongLeased(job, alone));
  standing.part_missing = alone;
  return standing;
}

absl::StatusOr<Machine::Standing> Machine::StandingAmongLeased(const JobRow& job,
                                                               bool whole_group) {
  Standing standing;
  ASSIGN_OR_RETURN(const std::vector<JobRow> leased, store_.LeasedInGroup(job.group_key));
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

absl::Status Machine::SettleJob(int64_t id, bool waits_met) {
  ASSIGN_OR_RETURN(const JobRow job, RowOf(id));
  if (IsTerminal(job.state)) return absl::OkStatus();  // Its variant gave up meanwhile.
  if (job.waits_open > 0 && !waits_met) return absl::OkStatus();
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  ASSIGN_OR_RETURN(const Standing standing, StandingOf(job));
  switch (standing.state) {
    case JobState::kReady:
      if (job.state == JobState::kReady) return absl::OkStatus();
      RETURN_IF_ERROR(store_.MoveToReady(id, Now()));
      if (standing.part_missing) without_part_.insert(id);
      effects_.work_ready = true;
      break;
    case JobState::kBlocked:
      if (job.state == JobState::kBlocked && job.awaits_job == standing.awaits_job) {
        return absl::OkStatus();
      }
      RETURN_IF_ERROR(store_.MoveToBlocked(id, standing.awaits_job));
      break;
    default:
      RETURN_IF_ERROR(store_.MoveToReused(id, standing.state, standing.rejected, Now()));
  }
  NoteMove(*variant, job, standing.state);
  if (standing.state == JobState::kRejected) {
    return EnterLoss(job, *variant, JobState::kRejected);
  }
  if (standing.state != JobState::kSucceeded) return absl::OkStatus();
  return EnterSuccess(job, *variant, {.result = standing.result}, /*by_own_attempt=*/false);
}

absl::Status Machine::ReleaseFollowers(int64_t leader) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> followers, store_.Followers(leader));
  for (const int64_t follower : followers) RETURN_IF_ERROR(SettleJob(follower));
  return absl::OkStatus();
}

absl::Status Machine::BlockSiblings(const JobRow& leader, bool whole_group) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> ready, store_.ReadyInGroup(leader.group_key));
  for (const int64_t id : ready) {
    ASSIGN_OR_RETURN(const JobRow job, RowOf(id));
    if (job.kind != leader.kind || (!whole_group && job.work_key != leader.work_key)) continue;
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
    RETURN_IF_ERROR(store_.MoveToBlocked(id, leader.id));
    without_part_.erase(id);
    NoteMove(*variant, job, JobState::kBlocked);
  }
  return absl::OkStatus();
}

// ---- New jobs -----------------------------------------------------------------------------------
absl::StatusOr<int64_t> Machine::AddJob(const NewJob& asked) {
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(asked.variant));
  JobRow job;
  ASSIGN_OR_RETURN(job.kind, kinds_.IdOf(asked.kind));
  job.study = variant->study;
  job.variant = variant->id;
  job.ordinal = asked.ordinal;
  job.rigs = RigsText(asked.rigs);
  job.rig_count = static_cast<uint32_t>(asked.rigs.size());
  job.input = asked.input;
  job.generation = asked.generation;
  const JobKind& kind = KindOf(job);
  const JobTraits& traits = kind.traits();
  if (traits.resumes && !traits.of_scene && job.input.empty()) {
    return Internal("a {} job without input", kind.name());
  }
  if (!asked.is_fresh) RETURN_IF_ERROR(kind.Trim(*this, job));
  ASSIGN_OR_RETURN(const JobKeys keys, kind.Keys(*this, job));
  job.work_key = keys.work;
  job.group_key = keys.group;
  ASSIGN_OR_RETURN(const Standing standing, asked.is_fresh && !traits.shares_part
                                                ? StandingAmongLeased(job, /*whole_group=*/false)
                                                : StandingOf(job));
  job.state = standing.state;
  job.awaits_job = standing.awaits_job;
  job.reused = IsTerminal(standing.state);
  job.error = standing.rejected;
  std::vector<const char*> waits;
  if (!IsTerminal(job.state)) {
    ASSIGN_OR_RETURN(waits, PlanWaits(asked.waits, job));
  }

  RETURN_IF_ERROR(store_.Insert(job, Now()));
  for (size_t i = 0; i < waits.size(); ++i) {
    RETURN_IF_ERROR(waits_.Insert(job.id, asked.waits[i], waits[i]));
  }
  ledger_.CountNew(*variant, job.kind, job.state);
  if (job.state == JobState::kReady) CountReady(job, 1);
  if (traits.of_scene) {
    RETURN_IF_ERROR(ChangeScene(*variant, job.ordinal, {.jobs_open = 1}).status());
  }
  if (job.state == JobState::kReady) {
    if (standing.part_missing) without_part_.insert(job.id);
    effects_.work_ready = true;
  } else if (job.state == JobState::kSucceeded) {
    RETURN_IF_ERROR(EnterSuccess(job, *variant, {.result = standing.result}, false));
  } else if (IsTerminal(job.state)) {
    RETURN_IF_ERROR(EnterLoss(job, *variant, job.state));
  }
  return job.id;
}

// ---- Splitting ----------------------------------------------------------------------------------
bool Machine::OnlyTheseLeft(KindId kind) const {
  if (!hungry_.empty()) return false;
  const auto of = [&](size_t other, JobState state) {
    return ledger_.totals()[other][static_cast<size_t>(state)];
  };
  for (size_t other = 0; other < kinds_.size(); ++other) {
    // Jobs that only wait for these pairs will not make more of them.
    if (other == kind.value || !kinds_.at(other).traits().of_scene) continue;
    for (const JobState state :
         {JobState::kReady, JobState::kLeased, JobState::kBlocked, JobState::kRetryWait}) {
      if (of(other, state) > 0) return false;
    }
  }
  return of(kind.value, JobState::kBlocked) + of(kind.value, JobState::kRetryWait) == 0;
}

absl::Status Machine::SplitIfIdle(JobRow& job, const Taker& worker) {
  const JobKind& kind = KindOf(job);
  // A retry keeps its predecessor's rigs.
  if (!kind.traits().can_split || job.rig_count < 2 || job.generation > 1) {
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  const auto ready = [&](size_t k) {
    return ledger_.totals()[k][static_cast<size_t>(JobState::kReady)];
  };
  SplitFacts facts{.rigs = job.rig_count,
                   .ready_jobs = ready(job.kind.value),
                   .idle_slots = worker.idle_slots[job.kind.value],
                   .slots = worker.slots[job.kind.value]};
  ASSIGN_OR_RETURN(const Study* study, ledger_.FindStudy(job.study));
  // Slots that its limits keep from it are none for its parts.
  const int room = static_cast<int>(std::min<int64_t>(RoomOf(*study), INT32_MAX));
  facts.idle_slots = std::min(facts.idle_slots, room);
  facts.slots = std::min(facts.slots, room);
  for (size_t other = 0; other < kinds_.size(); ++other) {
    if (other != job.kind.value && worker.takes[other]) facts.ready_others += ready(other);
  }
  // A part is not divided again and again while the slots fill.
  facts.only_these_left = 2 * job.rig_count > variant->rigs_per_scene && OnlyTheseLeft(job.kind);
  const uint32_t parts = PartsToSplitInto(facts);
  if (parts < 2) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<uint32_t> rigs, ParseRigs(job.rigs));
  const auto part_of = [&](uint32_t part) {
    const auto at = [&](uint32_t i) {
      return rigs.begin() + static_cast<std::ptrdiff_t>(rigs.size() * i / parts);
    };
    return std::vector<uint32_t>(at(part), at(part + 1));
  };
  JobRow first = job;
  first.rigs = RigsText(part_of(0));
  first.rig_count = static_cast<uint32_t>(part_of(0).size());
  ASSIGN_OR_RETURN(const JobKeys keys, kind.Keys(*this, first));
  first.work_key = keys.work;
  // A job of another study may be making that part.
  ASSIGN_OR_RETURN(const Standing standing, StandingAmongLeased(first, /*whole_group=*/false));
  if (standing.state != JobState::kReady) return absl::OkStatus();
  RETURN_IF_ERROR(store_.ShrinkReady(job.id, first.rigs, first.rig_count, first.work_key));
  job = first;
  for (uint32_t part = 1; part < parts; ++part) {
    RETURN_IF_ERROR(AddJob({.kind = kind.name(),
                            .variant = job.variant,
                            .ordinal = job.ordinal,
                            .rigs = part_of(part),
                            .input = job.input,
                            .generation = job.generation})
                        .status());
    ++effects_.splits;
  }
  return absl::OkStatus();
}

void Machine::NoteMove(Variant& variant, const JobRow& before, JobState to) {
  // Where a limit held others back, one of them may go now.
  if (before.state == JobState::kLeased && ledger_.IsFull(variant)) effects_.work_ready = true;
  if (before.state != to) ledger_.CountMove(variant, before.kind, before.state, to);
  if (IsTerminal(to)) ended_jobs_.emplace_back(before.id, to);
  if (before.state == to) return;
  if (before.state == JobState::kReady) CountReady(before, -1);
  if (to == JobState::kReady) CountReady(before, 1);
}

void Machine::CountReady(const JobRow& job, int64_t change) {
  const Study& study = ledger_.loaded_studies().at(job.study);
  ReadyKey key = ReadyKeyOf(job.study, {study.needs_memory_mb, study.needs_tags}, KindOf(job),
                            KindOf(job).NeedsOf(job.input));
  ReadyChanges& changes = effects_.ready;
  if (changes.size() > ready_mark_ && changes.back().first == key) {
    changes.back().second += change;
  } else {
    changes.emplace_back(std::move(key), change);
  }
}

absl::StatusOr<SceneRow*> Machine::OpenScene(int64_t variant, uint32_t ordinal, bool change) {
  if (scene_.variant != variant || scene_.ordinal != ordinal) {
    RETURN_IF_ERROR(FlushScene());
    scene_.variant = 0;
    ASSIGN_OR_RETURN(scene_.row, scenes_.Find(variant, ordinal));
    scene_.variant = variant;
    scene_.ordinal = ordinal;
    scene_.is_new = scene_.changed = false;
  }
  scene_.changed |= change;
  return &scene_.row;
}

absl::Status Machine::FlushScene() {
  if (scene_.variant == 0 || !scene_.changed) return absl::OkStatus();
  RETURN_IF_ERROR(scene_.is_new ? scenes_.Insert(scene_.variant, scene_.ordinal, scene_.row)
                                : scenes_.Write(scene_.variant, scene_.ordinal, scene_.row));
  scene_.is_new = scene_.changed = false;
  return absl::OkStatus();
}

// ---- Ends ---------------------------------------------------------------------------------------
absl::StatusOr<SceneRow> Machine::ChangeScene(Variant& variant, uint32_t ordinal,
                                              const SceneChange& change) {
  ASSIGN_OR_RETURN(SceneRow * open, OpenScene(variant.id, ordinal, /*change=*/true));
  SceneRow& scene = *open;
  const SceneRow before = scene;
  scene.jobs_open += static_cast<uint32_t>(change.jobs_open);
  scene.rigs_lost =
      change.all_lost ? scene.rigs : scene.rigs_lost + static_cast<uint32_t>(change.rigs_lost);
  scene.rigs_done += static_cast<uint32_t>(change.rigs_done);
  if (change.scene_hash) scene.scene_hash = change.scene_hash;

  VariantTally& tally = ledger_.Change(variant);
  tally.pairs_planned -= static_cast<int64_t>(scene.rigs_lost) - before.rigs_lost;
  tally.pairs_done += static_cast<int64_t>(scene.rigs_done) - before.rigs_done;
  tally.scenes_open += (scene.jobs_open > 0) - (before.jobs_open > 0);
  if (scene.jobs_open == 0 || scene.rigs_lost != before.rigs_lost) hungry_.insert(variant.id);
  if (change.rigs_done > 0) changed_variants_.insert(variant.id);
  if (before.jobs_open > 0 && scene.jobs_open == 0) {
    RETURN_IF_ERROR(folders_.SweepScene({variant.id, ordinal}, Now()));
  }
  return scene;
}

absl::Status Machine::EnterSuccess(const JobRow& job, Variant& variant, const Ending& ending,
                                   bool by_own_attempt) {
  const JobKind& kind = KindOf(job);
  if (kind.traits().begins_scenes && !by_own_attempt) ++ledger_.Change(variant).solves_reused;
  RETURN_IF_ERROR(kind.OnSuccess(*this, job, ending, by_own_attempt));
  if (kind.traits().of_scene) {
    return ChangeScene(variant, job.ordinal, {.jobs_open = -1}).status();
  }
  if (kind.traits().has_output) RETURN_IF_ERROR(results_.InsertStudyResult(job));
  return kind.traits().resumes ? folders_.SweepDone(job.work_key, Now()) : absl::OkStatus();
}

absl::Status Machine::EnterLoss(const JobRow& job, Variant& variant, JobState state) {
  if (!KindOf(job).traits().of_scene) {
    ++ledger_.Change(variant).others_lost;
    return absl::OkStatus();
  }
  SceneChange change{.jobs_open = -1};
  change.all_lost = job.rig_count == 0;
  change.rigs_lost = static_cast<int>(job.rig_count);
  RETURN_IF_ERROR(ChangeScene(variant, job.ordinal, change).status());
  VariantTally& tally = ledger_.Change(variant);
  if (state == JobState::kRejected) {
    ++tally.scenes_rejected;
    ++tally.tally_rejected;
  } else if (state != JobState::kCancelled) {
    ++tally.tally_lost;
  }
  return state == JobState::kCancelled ? absl::OkStatus() : GiveUpIfHopeless(variant, job.id);
}

absl::Status Machine::GiveUpIfHopeless(Variant& variant, int64_t job) {
  if (!variant.tally.problem.empty()) return absl::OkStatus();
  const VariantTally& tally = variant.tally;
  SceneTally scenes{.solved = tally.tally_solved,
                    .rejected = tally.tally_rejected,
                    .lost = tally.tally_lost,
                    .pairs = tally.pairs_done - tally.pairs_before};
  if (GiveUpReason(scenes).empty()) return absl::OkStatus();
  ASSIGN_OR_RETURN(const JobRow last, RowOf(job));
  scenes.last_reason = last.error;
  const std::string reason = GiveUpReason(scenes);
  ledger_.Change(variant).problem = reason;
  changed_variants_.insert(variant.id);
  RETURN_IF_ERROR(
      Audit("coordinator", "give up", variant.study, "variant " + variant.name + ": " + reason));
  // Other jobs stand in a variant only to be numbered: those that need its pairs wait for them and
  // end with their waits, a baseline needs none.
  return CancelJobs(variant.study, variant.id, "the variant gave up: " + reason,
                    /*only_of_scenes=*/true);
}

absl::Status Machine::CancelJobs(int64_t study, int64_t variant_id, const std::string& reason,
                                 bool only_of_scenes) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> ids, store_.Unfinished(study, variant_id));
  for (const int64_t id : ids) {
    ASSIGN_OR_RETURN(const JobRow job, RowOf(id));
    if (only_of_scenes && !KindOf(job).traits().of_scene) continue;
    // Releasing the followers of one may have ended another.
    if (!IsTerminal(job.state)) RETURN_IF_ERROR(CancelJob(job, reason));
  }
  return absl::OkStatus();
}

absl::Status Machine::CancelJob(const JobRow& job, const std::string& reason) {
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  RETURN_IF_ERROR(store_.MoveToCancelled(job.id, reason, Now()));
  if (job.waits_open > 0) RETURN_IF_ERROR(waits_.Drop(job.id));
  without_part_.erase(job.id);
  NoteMove(*variant, job, JobState::kCancelled);
  // Before its scene may be over, with which goes what was kept of it.
  if (job.state == JobState::kLeased) RETURN_IF_ERROR(Litter(job));
  RETURN_IF_ERROR(EnterLoss(job, *variant, JobState::kCancelled));
  if (job.state != JobState::kLeased) return absl::OkStatus();
  --leased_now_;
  effects_.ended.push_back(
      {.job = job.id, .fence = job.fence, .worker = job.worker, .stop = true, .reason = reason});
  return ReleaseFollowers(job.id);
}

}  // namespace parallax
