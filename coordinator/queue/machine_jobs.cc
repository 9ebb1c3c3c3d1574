// Jobs come, move and go; what each of that means for followers, scenes and counters.
#include <algorithm>

#include "coordinator/queue/machine.h"
#include "coordinator/study/rigs.h"

namespace parallax {
namespace {

absl::Status Gone(int64_t job) {
  return MakeError(absl::StatusCode::kInternal, "job " + std::to_string(job) + ": its row is gone");
}

}  // namespace

// ---- Where a job belongs ------------------------------------------------------------------------
absl::StatusOr<Machine::Standing> Machine::StandingOf(const JobRow& job, const Variant& variant) {
  Standing standing;
  bool whole_group = false;
  if (job.kind == WorkKind::kSolve) {
    ASSIGN_OR_RETURN(const auto scene, store_.FindSceneResult(job.work_key));
    if (scene) {
      standing.state = scene->scene_hash ? JobState::kSucceeded : JobState::kRejected;
      standing.scene_hash = scene->scene_hash;
      standing.rejected = scene->rejected;
      return standing;
    }
    ASSIGN_OR_RETURN(const auto layout, store_.FindLayoutResult(job.group_key));
    if (layout && !layout->solved) {
      standing.state = JobState::kRejected;
      standing.rejected = layout->rejected;
      return standing;
    }
    whole_group = standing.no_layout = !layout;
  } else {
    ASSIGN_OR_RETURN(const std::vector<uint32_t> rigs, ParseRigs(job.rigs));
    bool all = true;
    for (const uint32_t rig : rigs) {
      const Sha256Digest key = FrameKey(options_.versions, variant.digests, job.group_key, rig);
      ASSIGN_OR_RETURN(const bool has, store_.HasFrameResult(key));
      if (!has) {
        all = false;
        break;
      }
    }
    if (all) {
      standing.state = JobState::kSucceeded;
      return standing;
    }
  }
  ASSIGN_OR_RETURN(Standing among, StandingAmongLeased(job, whole_group));
  among.no_layout = standing.no_layout;
  return among;
}

absl::StatusOr<Machine::Standing> Machine::StandingAmongLeased(const JobRow& job,
                                                               bool whole_group) {
  Standing standing;
  if (hints_.LeasedIn(job.group_key) == 0) return standing;
  ASSIGN_OR_RETURN(const std::vector<JobRow> leased, store_.LeasedInGroup(job.group_key));
  for (const JobRow& leader : leased) {
    if (leader.kind != job.kind) continue;
    if (leader.work_key == job.work_key || (whole_group && !leader.layout_given)) {
      standing.state = JobState::kBlocked;
      standing.awaits_job = leader.id;
      break;
    }
  }
  return standing;
}

absl::Status Machine::SettleJob(int64_t id) {
  ASSIGN_OR_RETURN(const std::optional<JobRow> job, store_.Find(id));
  if (!job) return Gone(id);
  if (IsTerminal(job->state)) return absl::OkStatus();  // Its variant gave up meanwhile.
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job->variant));
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(job->study));
  ASSIGN_OR_RETURN(const Standing standing, StandingOf(*job, *variant));
  switch (standing.state) {
    case JobState::kReady:
      if (job->state == JobState::kReady) return absl::OkStatus();
      RETURN_IF_ERROR(store_.MoveToReady(id, Now()));
      if (standing.no_layout) without_layout_.insert(id);
      effects_.work_ready = true;
      break;
    case JobState::kBlocked:
      if (job->state == JobState::kBlocked && job->awaits_job == standing.awaits_job) {
        return absl::OkStatus();
      }
      RETURN_IF_ERROR(store_.MoveToBlocked(id, standing.awaits_job));
      break;
    default:
      RETURN_IF_ERROR(store_.MoveToReused(id, standing.state, standing.rejected, Now()));
  }
  NoteMove(*variant, *job, standing.state, standing.awaits_job);
  if (standing.state == JobState::kRejected) {
    return EnterLoss(*job, *variant, JobState::kRejected);
  }
  if (standing.state != JobState::kSucceeded) return absl::OkStatus();
  if (job->kind == WorkKind::kSolve) {
    ++ledger_.Change(*variant).solves_reused;
    return Solved(*job, *study, *variant, *standing.scene_hash,
                  /*new_recipe=*/false);
  }
  ASSIGN_OR_RETURN(const std::vector<uint32_t> rigs, ParseRigs(job->rigs));
  RETURN_IF_ERROR(PublishReused(*job, *variant, rigs));
  return ChangeScene(*variant, job->ordinal,
                     {.jobs_open = -1, .rigs_done = static_cast<int>(rigs.size())})
      .status();
}

absl::Status Machine::ReleaseFollowers(int64_t leader) {
  if (hints_.WaitingFor(leader) == 0) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<int64_t> followers, store_.Followers(leader));
  for (const int64_t follower : followers) RETURN_IF_ERROR(SettleJob(follower));
  return absl::OkStatus();
}

absl::Status Machine::BlockSiblings(const JobRow& leader, bool whole_group) {
  // The leader's own READY counts until its group is committed.
  if (hints_.ReadyIn(leader.group_key) <= 1) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<int64_t> ready, store_.ReadyInGroup(leader.group_key));
  for (const int64_t id : ready) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, store_.Find(id));
    if (!job) return Gone(id);
    if (job->kind != leader.kind || (!whole_group && job->work_key != leader.work_key)) continue;
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job->variant));
    RETURN_IF_ERROR(store_.MoveToBlocked(id, leader.id));
    without_layout_.erase(id);
    NoteMove(*variant, *job, JobState::kBlocked, leader.id);
  }
  return absl::OkStatus();
}

// ---- New jobs -----------------------------------------------------------------------------------
absl::Status Machine::InsertSolve(Study& study, Variant& variant, uint32_t ordinal,
                                  int generation) {
  const SceneSeed seed = SceneSeedOf(study.seed, ordinal);
  JobRow job;
  job.study = study.id;
  job.variant = variant.id;
  job.kind = WorkKind::kSolve;
  job.ordinal = ordinal;
  job.generation = generation;
  job.work_key = SceneKey(options_.versions, variant.digests, seed);
  job.group_key = LayoutKey(options_.versions, variant.digests, seed);
  ASSIGN_OR_RETURN(const Standing standing, StandingOf(job, variant));
  job.state = standing.state;
  job.awaits_job = standing.awaits_job;
  job.reused = IsTerminal(standing.state);
  job.error = standing.rejected;
  RETURN_IF_ERROR(store_.Insert(job, Now()));
  if (job.state == JobState::kReady && standing.no_layout) without_layout_.insert(job.id);
  NoteNew(variant, job);
  RETURN_IF_ERROR(ChangeScene(variant, ordinal, {.jobs_open = 1}).status());
  switch (job.state) {
    case JobState::kReady:
      effects_.work_ready = true;
      return absl::OkStatus();
    case JobState::kSucceeded:
      ++ledger_.Change(variant).solves_reused;
      return Solved(job, study, variant, *standing.scene_hash,
                    /*new_recipe=*/false);
    case JobState::kRejected:
      return EnterLoss(job, variant, JobState::kRejected);
    default:
      return absl::OkStatus();
  }
}

absl::Status Machine::InsertRender(Study& study, Variant& variant, uint32_t ordinal,
                                   const Sha256Digest& scene_hash, std::vector<uint32_t> rigs,
                                   int generation, bool new_recipe) {
  JobRow job;
  job.study = study.id;
  job.variant = variant.id;
  job.kind = WorkKind::kRender;
  job.ordinal = ordinal;
  job.generation = generation;
  job.group_key = scene_hash;

  // Frames that exist are linked; what is left is one job. If nothing is left the job stands for
  // the record.
  std::vector<uint32_t> reused;
  std::vector<uint32_t> left;
  for (const uint32_t rig : rigs) {
    if (new_recipe) {  // Nobody can have rendered it.
      left.push_back(rig);
      continue;
    }
    const Sha256Digest key = FrameKey(options_.versions, variant.digests, scene_hash, rig);
    ASSIGN_OR_RETURN(const bool has, store_.HasFrameResult(key));
    (has ? reused : left).push_back(rig);
  }
  // A retry keeps its predecessor's rigs, so that the two are known for the same work.
  if (generation > 1 && !left.empty()) {
    left = std::move(rigs);
    reused.clear();
  }
  if (!reused.empty()) RETURN_IF_ERROR(PublishReused(job, variant, reused));
  const std::vector<uint32_t>& own = left.empty() ? reused : left;
  job.rigs = RigsText(own);
  job.rig_count = static_cast<uint32_t>(own.size());
  job.work_key = RenderKey(options_.versions, variant.digests, scene_hash, job.rigs);
  if (left.empty()) {
    job.state = JobState::kSucceeded;
    job.reused = true;
  } else {
    ASSIGN_OR_RETURN(const Standing standing, StandingAmongLeased(job, /*whole_group=*/false));
    job.state = standing.state;
    job.awaits_job = standing.awaits_job;
  }
  RETURN_IF_ERROR(store_.Insert(job, Now()));
  NoteNew(variant, job);
  if (job.state == JobState::kReady) effects_.work_ready = true;
  return ChangeScene(
             variant, ordinal,
             {.jobs_open = left.empty() ? 0 : 1, .rigs_done = static_cast<int>(reused.size())})
      .status();
}

// ---- Splitting
// ----------------------------------------------------------------------------------
bool Machine::OnlyRendersLeft() const {
  if (!hungry_.empty()) return false;
  const JobCounts& jobs = ledger_.totals();
  const auto& solves = jobs[static_cast<size_t>(WorkKind::kSolve)];
  const auto& renders = jobs[static_cast<size_t>(WorkKind::kRender)];
  const auto of = [](const auto& counts, JobState state) {
    return counts[static_cast<size_t>(state)];
  };
  for (const JobState state :
       {JobState::kReady, JobState::kLeased, JobState::kBlocked, JobState::kRetryWait}) {
    if (of(solves, state) > 0) return false;
  }
  return of(renders, JobState::kBlocked) + of(renders, JobState::kRetryWait) == 0;
}

absl::Status Machine::SplitIfIdle(JobRow& job, const WorkerFacts& worker) {
  // A retry keeps its predecessor's rigs.
  if (job.kind != WorkKind::kRender || job.rig_count < 2 || job.generation > 1) {
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  // A part is not divided again and again while the slots fill.
  const bool whole = 2 * job.rig_count > variant->rigs_per_scene;
  const SplitFacts facts{
      .rigs = job.rig_count,
      .ready_renders = ledger_.totals()[static_cast<size_t>(WorkKind::kRender)]
                                       [static_cast<size_t>(JobState::kReady)],
      .ready_solves = worker.solves ? ledger_.totals()[static_cast<size_t>(WorkKind::kSolve)]
                                                      [static_cast<size_t>(JobState::kReady)]
                                    : 0,
      .idle_render_slots = idle_slots_,
      .render_slots = worker.render_slots,
      .only_renders_left = whole && OnlyRendersLeft()};
  const uint32_t parts = PartsToSplitInto(facts);
  if (parts < 2) return absl::OkStatus();
  ASSIGN_OR_RETURN(const std::vector<uint32_t> rigs, ParseRigs(job.rigs));
  const auto begin_of = [&](uint32_t part) {
    return rigs.begin() + static_cast<std::ptrdiff_t>(rigs.size() * part / parts);
  };
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(job.study));
  JobRow first = job;
  first.rig_count = static_cast<uint32_t>(begin_of(1) - begin_of(0));
  first.rigs = RigsText(std::vector<uint32_t>(begin_of(0), begin_of(1)));
  first.work_key = RenderKey(options_.versions, variant->digests, job.group_key, first.rigs);
  // Somebody may be at just that part, for another study.
  ASSIGN_OR_RETURN(const Standing standing, StandingAmongLeased(first, /*whole_group=*/false));
  if (standing.state != JobState::kReady) return absl::OkStatus();
  RETURN_IF_ERROR(store_.ShrinkReady(job.id, first.rigs, first.rig_count, first.work_key));
  job = first;
  for (uint32_t part = 1; part < parts; ++part) {
    RETURN_IF_ERROR(InsertRender(*study, *variant, job.ordinal, job.group_key,
                                 std::vector<uint32_t>(begin_of(part), begin_of(part + 1)),
                                 job.generation));
    ++effects_.splits;
  }
  return absl::OkStatus();
}

absl::Status Machine::PublishReused(const JobRow& job, Variant& variant,
                                    std::span<const uint32_t> rigs) {
  for (const uint32_t rig : rigs) {
    const Sha256Digest key = FrameKey(options_.versions, variant.digests, job.group_key, rig);
    RETURN_IF_ERROR(store_.InsertFrame(job, rig, key, /*reused=*/true));
  }
  ledger_.Change(variant).frames_reused += static_cast<int64_t>(rigs.size());
  return absl::OkStatus();
}

void Machine::NoteNew(Variant& variant, const JobRow& job) {
  ledger_.CountNew(variant, job.kind, job.state);
  hints_.Entered(job.state, job.group_key, job.awaits_job);
}

void Machine::NoteMove(Variant& variant, const JobRow& before, JobState to, int64_t awaits_job) {
  if (before.state != to) ledger_.CountMove(variant, before.kind, before.state, to);
  hints_.Left(before.state, before.group_key, before.awaits_job);
  hints_.Entered(to, before.group_key, awaits_job);
}

absl::StatusOr<SceneRow*> Machine::OpenScene(int64_t variant, uint32_t ordinal, bool change) {
  if (scene_.variant != variant || scene_.ordinal != ordinal) {
    RETURN_IF_ERROR(FlushScene());
    scene_.variant = 0;
    ASSIGN_OR_RETURN(scene_.row, store_.FindScene(variant, ordinal));
    scene_.variant = variant;
    scene_.ordinal = ordinal;
    scene_.is_new = scene_.changed = false;
  }
  scene_.changed |= change;
  return &scene_.row;
}

absl::Status Machine::FlushScene() {
  if (scene_.variant == 0 || !scene_.changed) return absl::OkStatus();
  RETURN_IF_ERROR(scene_.is_new ? store_.InsertScene(scene_.variant, scene_.ordinal, scene_.row)
                                : store_.WriteScene(scene_.variant, scene_.ordinal, scene_.row));
  scene_.is_new = scene_.changed = false;
  return absl::OkStatus();
}

// ---- Ends
// ---------------------------------------------------------------------------------------
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
  return scene;
}

absl::Status Machine::Solved(const JobRow& job, Study& study, Variant& variant,
                             const Sha256Digest& scene_hash, bool new_recipe) {
  ++ledger_.Change(variant).tally_solved;
  ASSIGN_OR_RETURN(const SceneRow scene,
                   ChangeScene(variant, job.ordinal, {.scene_hash = scene_hash}));
  RETURN_IF_ERROR(InsertRender(study, variant, job.ordinal, scene_hash, RigRange(0, scene.rigs), 1,
                               new_recipe));
  return ChangeScene(variant, job.ordinal, {.jobs_open = -1}).status();
}

absl::Status Machine::EnterLoss(const JobRow& job, Variant& variant, JobState state) {
  SceneChange change{.jobs_open = -1};
  if (job.kind == WorkKind::kSolve) {
    change.all_lost = true;
  } else {
    change.rigs_lost = static_cast<int>(job.rig_count);
  }
  RETURN_IF_ERROR(ChangeScene(variant, job.ordinal, change).status());
  VariantTally& tally = ledger_.Change(variant);
  if (state == JobState::kRejected) {
    ++tally.scenes_rejected;
    ++tally.tally_rejected;
  } else if (state != JobState::kCancelled) {
    ++tally.tally_lost;
  }
  return state == JobState::kCancelled ? absl::OkStatus() : GiveUpIfHopeless(variant);
}

absl::Status Machine::GiveUpIfHopeless(Variant& variant) {
  if (!variant.tally.problem.empty()) return absl::OkStatus();
  const VariantTally& tally = variant.tally;
  std::string reason = GiveUpReason({tally.tally_solved, tally.tally_rejected, tally.tally_lost});
  if (reason.empty()) return absl::OkStatus();
  ledger_.Change(variant).problem = reason;
  RETURN_IF_ERROR(store_.Audit(Now(), "coordinator", "give up", variant.study,
                               "variant " + variant.name + ": " + reason));
  return CancelJobs(variant.study, variant.id, "the variant gave up: " + reason);
}

absl::Status Machine::CancelJobs(int64_t study, int64_t variant_id, const std::string& reason) {
  ASSIGN_OR_RETURN(const std::vector<int64_t> ids, store_.Unfinished(study, variant_id));
  for (const int64_t id : ids) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, store_.Find(id));
    if (!job) return Gone(id);
    // Releasing the followers of one may have ended another.
    if (IsTerminal(job->state)) continue;
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job->variant));
    RETURN_IF_ERROR(store_.MoveToCancelled(id, reason, Now()));
    without_layout_.erase(id);
    NoteMove(*variant, *job, JobState::kCancelled);
    RETURN_IF_ERROR(EnterLoss(*job, *variant, JobState::kCancelled));
    if (job->state != JobState::kLeased) continue;
    RETURN_IF_ERROR(Litter(*job));
    --leased_now_;
    effects_.ended.push_back({id, job->fence, job->worker, /*stop=*/true, reason});
    RETURN_IF_ERROR(ReleaseFollowers(id));
  }
  return absl::OkStatus();
}

}  // namespace parallax
