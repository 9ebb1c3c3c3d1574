// Chooses jobs for workers and leases them.
#include <algorithm>

#include "coordinator/queue/commands/machine.h"

namespace parallax {
namespace {

constexpr size_t kGroupsRemembered = 4;  // About as many scenes as a worker keeps built.
constexpr double kWorkerForgottenS = 120;
constexpr int kMostKept = 16;  // Folders of earlier attempts in a lease.
// Jobs that suit a worker and are looked at for one lease before the next study has its turn.
constexpr int kCandidates = 16;
// Jobs of one kind and study may need different things of a worker: at most so many that do not
// suit it are passed over.
constexpr int kMostUnsuitable = 2000;

constexpr char kReadyOfStudy[] = "SELECT " PARALLAX_JOB_COLUMNS
                                 " FROM jobs WHERE study_id = ?1 AND kind = ?2 AND state = 'READY'"
                                 " ORDER BY ordinal, variant_id LIMIT ?3";
constexpr char kReadyOfGroup[] =
    "SELECT " PARALLAX_JOB_COLUMNS
    " FROM jobs WHERE group_key = ?1 AND state = 'READY' ORDER BY id LIMIT ?2";

}  // namespace

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
  WorkerMemory& memory = workers_[worker.name];
  memory.seen_s = SteadySeconds();
  memory.machine = worker.machine;
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
  SqliteQuery query(db_, kReadyOfStudy, study.id, kinds_[kind].name(),
                    kCandidates + kMostUnsuitable);
  int suitable = 0;
  std::optional<JobRow> own;  // The job that this worker failed or lost comes after all others.
  while (suitable < kCandidates && query.Next()) {
    ASSIGN_OR_RETURN(JobRow job, JobRowOf(query, kinds_));
    if (!FitsJob(job, worker)) continue;
    ASSIGN_OR_RETURN(const bool complete, HasWhatItWaitedFor(job));
    if (!complete) continue;
    ++suitable;
    const double waited = Now() - job.ready_unix_s;
    const JobCandidate candidate{job.id, job.worker, waited < 0 ? kElsewhereS : waited};
    if (PickJob({&candidate, 1}, name, others) != 0) continue;
    if (job.worker != name) return std::optional<JobRow>(std::move(job));
    if (!own) own = std::move(job);
  }
  RETURN_IF_ERROR(query.status());
  return own;
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
  effects_.granted.push_back({.job = job.id, .fence = lease.fence, .worker = lease.worker});
  return lease;
}

}  // namespace parallax
