// Studies, leases and expansion; see machine_jobs.cc for the moves of jobs and machine_report.cc
// for the ends of leases.
#include "coordinator/queue/machine.h"

#include <algorithm>
#include <chrono>

#include "common/config/training.h"
#include "coordinator/queue/compress.h"
#include "coordinator/study/expansion.h"

namespace parallax {
namespace {

constexpr size_t kGroupsRemembered = 4;  // A worker keeps about so many scenes built.
constexpr double kWorkerForgottenS = 120;
constexpr int kMostKept = 16;    // Folders of earlier attempts in a lease.
constexpr int kCandidates = 16;  // Looked at for one lease before the next study has its turn.

constexpr char kReadyOfStudy[] = "SELECT " PARALLAX_JOB_COLUMNS
                                 " FROM jobs WHERE study_id = ?1 AND kind = ?2 AND state = 'READY'"
                                 " ORDER BY ordinal, variant_id LIMIT ?3";
constexpr char kReadyOfGroup[] =
    "SELECT " PARALLAX_JOB_COLUMNS
    " FROM jobs WHERE group_key = ?1 AND state = 'READY' ORDER BY id LIMIT ?2";

std::string JoinLines(const google::protobuf::RepeatedPtrField<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

}  // namespace

Machine::Machine(SqliteConnection& db, const JobQueueOptions& options, uint64_t epoch)
    : db_(db),
      options_(options),
      kinds_(*options.kinds),
      epoch_(epoch),
      store_(db, kinds_),
      losses_(db, options.most_logs),
      scenes_(db),
      results_(db),
      folders_(db),
      archive_(db, losses_),
      waits_(db),
      ledger_(db, kinds_, options.limits) {}

double Machine::SteadySeconds() {
  return std::chrono::duration<double>(options_.clock->Steady().time_since_epoch()).count();
}

absl::Status Machine::Load() {
  RETURN_IF_ERROR(ledger_.LoadUnfinished());
  for (const auto& [id, study] : ledger_.loaded_studies()) {
    hungry_.insert(study.variants.begin(), study.variants.end());
  }
  ASSIGN_OR_RETURN(const auto leased,
                   db_.Integer("SELECT count(*) FROM jobs WHERE state = 'LEASED'"));
  leased_now_ = leased.value_or(0);
  return waits_.Load();
}

void Machine::BeginCommand() {
  ledger_.BeginCommand();
  scene_.variant = 0;
  ended_jobs_.clear();
  changed_variants_.clear();
  granted_mark_ = effects_.granted.size();
  ended_mark_ = effects_.ended.size();
  counts_mark_ = effects_;
}

absl::Status Machine::EndCommand() {
  RETURN_IF_ERROR(SettleWaiters());
  RETURN_IF_ERROR(FlushScene());
  scene_.variant = 0;
  return absl::OkStatus();
}

void Machine::UndoCommand() {
  ledger_.UndoCommand();
  scene_.variant = 0;
  // Its knowledge may be of rows that are undone.
  without_part_.clear();
  leased_now_ -= static_cast<int64_t>(effects_.granted.size() - granted_mark_);
  leased_now_ += static_cast<int64_t>(effects_.ended.size() - ended_mark_);
  effects_.granted.resize(granted_mark_);
  effects_.ended.resize(ended_mark_);
  static_cast<EffectCounts&>(effects_) = counts_mark_;
}

Effects Machine::TakeEffects() {
  Effects taken = std::move(effects_);
  effects_ = Effects();
  granted_mark_ = ended_mark_ = 0;
  return taken;
}

absl::Status Machine::Reload() {
  ledger_.Drop();
  TakeEffects();
  hungry_.clear();
  without_part_.clear();
  scene_.variant = 0;
  return Load();
}

// ---- Studies
absl::StatusOr<v1::SubmitReply> Machine::Submit(const v1::SubmitRequest& request,
                                                std::string_view actor) {
  const v1::StudySpec& spec = request.study();
  const std::string spec_bytes = DeterministicBytes(spec);
  const Sha256Digest spec_hash = Sha256Of(spec_bytes);
  v1::SubmitReply reply;
  if (!request.idempotency_key().empty()) {
    SqliteQuery known(db_, "SELECT id, spec_hash FROM studies WHERE idempotency_key = ?1",
                      request.idempotency_key());
    if (known.Next()) {
      if (known.Digest(1) != spec_hash) {
        return AlreadyExists("idempotency key '{}' was used for another study ({})",
                             request.idempotency_key(), known.Int(0));
      }
      reply.set_study_id(known.Int(0));
      reply.set_existed(true);
      return reply;
    }
    RETURN_IF_ERROR(known.status());
  }
  const std::string user = UserOfActor(actor);
  RETURN_IF_ERROR(CheckUser(user, 1, TotalPairsOf(spec)));
  const auto key = request.idempotency_key().empty()
                       ? std::nullopt
                       : std::optional<std::string>(request.idempotency_key());
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO studies(name, spec_z, spec_hash, idempotency_key, seed, priority,"
              " needs_memory_mb, needs_tags, submitted_unix_s, user, max_running)"
              " VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11)",
              spec.name(), SqlBlob{Compress(spec_bytes)}, spec_hash, key,
              static_cast<int64_t>(spec.seed()), spec.priority(), spec.memory_mb(),
              JoinLines(spec.tags()), Now(), user, request.max_running()));
  const int64_t id = db_.last_insert_id();
  for (const v1::VariantSpec& variant : spec.variants()) {
    RETURN_IF_ERROR(
        db_.Run("INSERT INTO variants(study_id, name, config_z, pairs_wanted, rigs_per_scene, seed)"
                " VALUES (?1, ?2, ?3, ?4, ?5, ?6)",
                id, variant.name(), SqlBlob{PackMessage(variant.config())}, PairsOf(spec, variant),
                RigsPerSceneOf(spec, variant), static_cast<int64_t>(SeedOf(spec, variant))));
  }
  RETURN_IF_ERROR(Audit(actor, "submit", id, spec.name()));
  ledger_.NoteCreated(id);
  ASSIGN_OR_RETURN(const Study* study, ledger_.FindStudy(id));
  const std::vector<int64_t> variants = study->variants;
  for (size_t i = 0; i < kinds_.size(); ++i) {
    RETURN_IF_ERROR(kinds_.at(i).OnSubmit(*this, spec, variants));
  }
  hungry_.insert(variants.begin(), variants.end());  // Last: it isn't undone.
  reply.set_study_id(id);
  return reply;
}

absl::Status Machine::Cancel(int64_t id, std::string_view reason, std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  if (study->tally.cancelled) return absl::OkStatus();
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET cancelled = 1 WHERE id = ?1", id));
  ledger_.Change(*study).cancelled = true;
  changed_variants_.insert(study->variants.begin(), study->variants.end());
  RETURN_IF_ERROR(Audit(actor, "cancel", id, reason));
  RETURN_IF_ERROR(
      CancelJobs(id, 0, reason.empty() ? "cancelled" : "cancelled: " + std::string(reason)));
  return folders_.SweepUnwanted(Now());
}

absl::Status Machine::SetPaused(int64_t id, bool paused, std::string_view reason,
                                std::string_view actor) {
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
  if (study->tally.paused == paused) return absl::OkStatus();
  RETURN_IF_ERROR(db_.Run("UPDATE studies SET paused = ?2 WHERE id = ?1", id, paused));
  ledger_.Change(*study).paused = paused;
  if (!paused) effects_.work_ready = true;
  return Audit(actor, paused ? "pause" : "resume", id, reason);
}

// ---- Leases
absl::StatusOr<Machine::Taker> Machine::TakerOf(const WorkerFacts& worker) const {
  Taker taker{.facts = worker};
  for (const std::string& name : worker.kinds) {
    ASSIGN_OR_RETURN(const KindId kind, kinds_.IdOf(name));
    const JobTraits& traits = kinds_[kind].traits();
    StudyShare needs;
    needs.needs_memory_mb = traits.needs_memory_mb;
    needs.needs_tags = traits.needs_tags;
    taker.takes[kind.value] = Fits(needs, {worker.memory_mb, worker.tags});
  }
  for (const auto& [name, slots] : worker.farm) {
    ASSIGN_OR_RETURN(const KindId kind, kinds_.IdOf(name));
    taker.idle_slots[kind.value] = slots.idle;
    taker.slots[kind.value] = slots.all;
  }
  return taker;
}

absl::StatusOr<std::vector<GrantedLease>> Machine::Lease(const WorkerFacts& worker, int max_jobs) {
  std::vector<GrantedLease> leases;
  ASSIGN_OR_RETURN(Taker taker, TakerOf(worker));
  workers_[worker.name].seen_s = SteadySeconds();
  for (int i = 0; i < max_jobs; ++i) {
    ASSIGN_OR_RETURN(const std::optional<JobRow> job, Choose(taker));
    if (!job) break;
    ASSIGN_OR_RETURN(GrantedLease lease, Grant(*job, taker));
    leases.push_back(std::move(lease));
    for (int& idle : taker.idle_slots) --idle;
  }
  return leases;
}

bool Machine::OthersAround(const std::string& worker) {
  const double now = SteadySeconds();
  std::erase_if(workers_,
                [&](const auto& known) { return now - known.second.seen_s > kWorkerForgottenS; });
  return workers_.size() > (workers_.count(worker) ? 1u : 0u);
}

StudyShare Machine::ShareOf(Study& study, const Taker& worker) {
  int64_t ready = 0;
  int64_t ready_for_it = 0;
  for (size_t kind = 0; kind < kinds_.size(); ++kind) {
    ready += study.tally.ready[kind];
    if (worker.takes[kind]) ready_for_it += study.tally.ready[kind];
  }
  // A study that is full by its own wish waits for nothing. One that its user's other studies hold
  // back does: it ages, so that they can't do so for ever.
  const bool hungry =
      ready > 0 && !study.tally.paused && !study.tally.cancelled && !study.tally.IsFull();
  const double now = SteadySeconds();
  if (!hungry) {
    study.hungry_since_s = -1;
  } else if (study.hungry_since_s < 0) {
    // A study does not save up turns while it has no jobs.
    study.hungry_since_s = now;
    study.pass = std::max(study.pass, virtual_pass_);
  }
  return {.study = study.id,
          .priority = study.priority,
          .pass = study.pass,
          .waiting_s = hungry ? now - study.hungry_since_s : 0,
          .open = hungry && ready_for_it > 0 && !study.share->IsFull(),
          .needs_memory_mb = study.needs_memory_mb,
          .needs_tags = study.needs_tags};
}

absl::StatusOr<std::optional<JobRow>> Machine::Choose(const Taker& worker) {
  ASSIGN_OR_RETURN(std::optional<JobRow> warm, ChooseWarm(worker));
  if (warm) return warm;
  std::vector<StudyShare> shares;
  for (auto& [id, study] : ledger_.loaded_studies()) {
    if (!study.tally.finished) shares.push_back(ShareOf(study, worker));
  }
  for (const int64_t id : OrderStudies(shares, {worker.facts.memory_mb, worker.facts.tags})) {
    ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(id));
    // Later stages first: what has been begun is finished, and few scenes are open at a time.
    for (size_t kind = kinds_.size(); kind-- > 0;) {
      if (!worker.takes[kind] || study->tally.ready[kind] == 0) continue;
      ASSIGN_OR_RETURN(std::optional<JobRow> job,
                       ChooseOf(*study, KindId{static_cast<uint8_t>(kind)}, worker));
      if (job) return job;
    }
  }
  return std::optional<JobRow>();
}

absl::StatusOr<std::optional<JobRow>> Machine::ChooseOf(Study& study, KindId kind,
                                                        const Taker& worker) {
  const std::string& name = worker.facts.name;
  const bool others = OthersAround(name);
  SqliteQuery query(db_, kReadyOfStudy, study.id, kinds_[kind].name(), kCandidates);
  while (query.Next()) {
    ASSIGN_OR_RETURN(JobRow job, JobRowOf(query, kinds_));
    if (!FitsJob(job, worker)) continue;
    const double waited = Now() - job.ready_unix_s;
    const JobCandidate candidate{job.id, job.worker, waited < 0 ? kElsewhereS : waited};
    if (PickJob({&candidate, 1}, name, others) == 0) return std::optional<JobRow>(std::move(job));
  }
  RETURN_IF_ERROR(query.status());
  return std::optional<JobRow>();
}

bool Machine::FitsJob(const JobRow& job, const Taker& worker) const {
  const WorkNeeds needs = KindOf(job).NeedsOf(job.input);
  return Fits({.needs_memory_mb = needs.memory_mb, .needs_tags = needs.tags},
              {worker.facts.memory_mb, worker.facts.tags});
}

absl::StatusOr<std::optional<JobRow>> Machine::ChooseWarm(const Taker& worker) {
  const auto known = workers_.find(worker.facts.name);
  if (known == workers_.end()) return std::optional<JobRow>();
  for (const Sha256Digest& group : known->second.groups) {
    SqliteQuery query(db_, kReadyOfGroup, group, kCandidates);
    while (query.Next()) {
      ASSIGN_OR_RETURN(JobRow job, JobRowOf(query, kinds_));
      if (!worker.takes[job.kind.value] || job.worker == worker.facts.name) continue;
      ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(job.study));
      const StudyShare share = ShareOf(*study, worker);
      if (KindOf(job).traits().keeps_group_warm && share.open && FitsJob(job, worker) &&
          Fits(share, {worker.facts.memory_mb, worker.facts.tags})) {
        return std::optional<JobRow>(std::move(job));
      }
    }
    RETURN_IF_ERROR(query.status());
  }
  return std::optional<JobRow>();
}

absl::StatusOr<GrantedLease> Machine::Grant(JobRow job, const Taker& worker) {
  RETURN_IF_ERROR(SplitIfIdle(job, worker));
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(job.study));
  const JobKind& kind = KindOf(job);
  job.part_given = false;
  if (kind.traits().shares_part && without_part_.erase(job.id) == 0) {
    ASSIGN_OR_RETURN(job.part_given, kind.HasPart(*this, job));
  }
  GrantedLease lease{.work = {job, variant->seed, variant->config},
                     .fence = NextFence(),
                     .worker = worker.facts.name,
                     .attempt_number = job.attempts + 1,
                     .study = study->name,
                     .variant = variant->name};
  if (kind.traits().resumes) {
    ASSIGN_OR_RETURN(const Sha256Digest keep_key, kind.KeepKey(*this, job));
    ASSIGN_OR_RETURN(lease.work.kept_folders, folders_.Kept(keep_key, kMostKept));
  }
  RETURN_IF_ERROR(store_.MoveToLeased(job, lease.fence, lease.worker, job.part_given));
  NoteMove(*variant, job, JobState::kLeased);
  RETURN_IF_ERROR(BlockSiblings(job, /*whole_group=*/kind.traits().shares_part && !job.part_given));

  study->pass += 1;
  virtual_pass_ = study->pass;
  study->hungry_since_s = SteadySeconds();
  if (kind.traits().keeps_group_warm) {
    std::deque<Sha256Digest>& groups = workers_[lease.worker].groups;
    std::erase(groups, job.group_key);
    groups.push_front(job.group_key);
    if (groups.size() > kGroupsRemembered) groups.pop_back();
  }
  ++leased_now_;
  effects_.granted.push_back({job.id, lease.fence, lease.worker, false, ""});
  return lease;
}

// ---- Expansion
absl::Status Machine::TopUp(Variant& variant, const ScenePlan& plan) {
  ASSIGN_OR_RETURN(SceneRow * scene, OpenScene(variant.id, plan.ordinal, /*change=*/true));
  const uint32_t before = scene->rigs;
  scene->rigs = plan.rigs;
  ledger_.Change(variant).pairs_planned += plan.rigs - before;
  return kinds_[kinds_.begins_scenes()].OnMorePairs(*this, variant.id, plan.ordinal, before,
                                                    plan.rigs - before);
}

absl::StatusOr<bool> Machine::Expand(int64_t limit) {
  const std::vector<int64_t> hungry(hungry_.begin(), hungry_.end());
  for (const int64_t id : hungry) {
    ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(id));
    ASSIGN_OR_RETURN(Study * study, ledger_.FindStudy(variant->study));
    const int64_t missing = variant->pairs_wanted - variant->tally.pairs_planned;
    if (missing <= 0 || study->tally.cancelled || !variant->tally.problem.empty()) {
      hungry_.erase(id);
      continue;
    }
    if (limit <= 0) return true;
    VariantPlan plan{.pairs_wanted = variant->pairs_wanted,
                     .pairs_planned = variant->tally.pairs_planned,
                     .rigs_per_scene = variant->rigs_per_scene,
                     .next_ordinal = static_cast<uint32_t>(variant->tally.next_ordinal),
                     .scenes_open = variant->tally.scenes_open,
                     // A large farm needs more than a small one to choose from.
                     .scenes_ahead = std::max<int64_t>(options_.scenes_ahead, 2 * leased_now_)};
    RETURN_IF_ERROR(FlushScene());
    ASSIGN_OR_RETURN(const std::optional<uint32_t> highest, scenes_.HighestLiving(id));
    if (highest) {
      ASSIGN_OR_RETURN(const SceneRow* scene, OpenScene(id, *highest, /*change=*/false));
      if (scene->rigs_lost == 0) plan.highest_living = ScenePlan{*highest, scene->rigs};
    }
    const Expansion expansion = NextScenes(plan, limit);
    if (expansion.top_up) RETURN_IF_ERROR(TopUp(*variant, *expansion.top_up));
    for (const ScenePlan& scene : expansion.scenes) {
      RETURN_IF_ERROR(FlushScene());
      scene_ = {.variant = id, .ordinal = scene.ordinal, .is_new = true, .changed = true};
      scene_.row.rigs = scene.rigs;
      VariantTally& tally = ledger_.Change(*variant);
      tally.next_ordinal = scene.ordinal + 1;
      tally.pairs_planned += scene.rigs;
      RETURN_IF_ERROR(AddJob({.kind = kinds_[kinds_.begins_scenes()].name(),
                              .variant = id,
                              .ordinal = scene.ordinal})
                          .status());
      // Seeds known to be bad may have used up the variant's patience.
      if (!variant->tally.problem.empty()) break;
    }
    limit -= static_cast<int64_t>(expansion.scenes.size()) + (expansion.top_up ? 1 : 0);
    // With no room in its window it comes back when one of its scenes ends.
    if (expansion.scenes.empty() && !expansion.top_up) hungry_.erase(id);
  }
  return !hungry_.empty();
}

// ---- Litter and archive
absl::Status Machine::Audit(std::string_view actor, std::string_view action, int64_t study,
                            std::string_view detail) {
  return db_.Run(
      "INSERT INTO audit(unix_s, actor, action, study_id, detail) VALUES (?1, ?2, ?3, ?4, ?5)",
      Now(), actor, action, study == 0 ? std::nullopt : std::optional<int64_t>(study), detail);
}

absl::Status Machine::ForgetLitter(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) RETURN_IF_ERROR(folders_.DeleteLitter(path));
  return absl::OkStatus();
}

absl::StatusOr<bool> Machine::Archive(int limit) {
  if (options_.archive_after_s <= 0) return false;
  ASSIGN_OR_RETURN(const auto study, archive_.StudyToArchive(Now() - options_.archive_after_s));
  if (!study) return false;
  ASSIGN_OR_RETURN(const int moved, archive_.Add(*study, limit));
  effects_.archived += static_cast<uint64_t>(moved);
  RETURN_IF_ERROR(folders_.SweepUnwanted(Now()));
  ledger_.Forget(*study);
  return true;
}

absl::Status Machine::Settle() {
  for (const int64_t id : ledger_.changed_studies()) {
    Study* const study = &ledger_.loaded_studies().at(id);
    if (study->tally.forgotten) continue;
    bool finished = true;
    for (const int64_t variant_id : study->variants) {
      ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(variant_id));
      const VariantTally& tally = variant->tally;
      const bool complete = study->tally.cancelled || !tally.problem.empty() ||
                            tally.pairs_planned >= variant->pairs_wanted;
      if (!complete || tally.OpenJobs() > 0) {
        finished = false;
        break;
      }
    }
    if (finished == study->tally.finished) continue;
    RETURN_IF_ERROR(db_.Run("UPDATE studies SET finished_unix_s = ?2 WHERE id = ?1", id,
                            finished ? std::optional<double>(Now()) : std::nullopt));
    study->tally.finished = finished;
  }
  return absl::OkStatus();
}

}  // namespace parallax
