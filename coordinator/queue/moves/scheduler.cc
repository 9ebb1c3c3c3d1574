#include "coordinator/queue/moves/scheduler.h"

#include <algorithm>
#include <set>

#include "coordinator/study/rigs.h"

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

absl::StatusOr<Scheduler::Taker> Scheduler::TakerOf(const WorkerFacts& worker) const {
  Taker taker{.facts = worker};
  for (const std::string& name : worker.kinds) {
    ASSIGN_OR_RETURN(const KindId kind, tables_.kinds.IdOf(name));
    const JobTraits& traits = tables_.kinds[kind].traits();
    StudyShare needs;
    needs.needs_memory_mb = traits.needs_memory_mb;
    needs.needs_tags = traits.needs_tags;
    taker.takes[kind.value] = Fits(needs, {worker.memory_mb, worker.tags});
  }
  for (const auto& [name, slots] : worker.farm) {
    ASSIGN_OR_RETURN(const KindId kind, tables_.kinds.IdOf(name));
    taker.idle_slots[kind.value] = slots.idle;
    taker.slots[kind.value] = slots.all;
  }
  return taker;
}

absl::StatusOr<std::vector<GrantedLease>> Scheduler::Lease(const WorkerFacts& worker,
                                                           int max_jobs) {
  std::vector<GrantedLease> leases;
  ASSIGN_OR_RETURN(Taker taker, TakerOf(worker));
  WorkerMemory& memory = workers_[worker.name];
  memory.seen_s = tables_.SteadySeconds();
  memory.machine = worker.machine;
  if (Abilities& now = abilities_[worker.name]; now.memory_mb != worker.memory_mb) {
    now = {worker.kinds, worker.tags, worker.memory_mb};
  }
  while (static_cast<int>(leases.size()) < max_jobs) {
    ASSIGN_OR_RETURN(std::optional<JobRow> job, Choose(taker));
    if (!job) break;
    ASSIGN_OR_RETURN(const bool is_other, jobs_.TakeNewKeys(*job));
    if (is_other) {
      RETURN_IF_ERROR(jobs_.Settle(job->id));  // It may be done by now, or another's.
      continue;
    }
    ASSIGN_OR_RETURN(GrantedLease lease, Grant(*std::move(job), taker));
    leases.push_back(std::move(lease));
    for (int& idle : taker.idle_slots) --idle;
  }
  return leases;
}

std::string Scheduler::MachineOf(const std::string& worker) const {
  const auto known = workers_.find(worker);
  return known == workers_.end() || known->second.machine.empty() ? worker : known->second.machine;
}

int64_t Scheduler::MemoryOf(const std::string& worker) const {
  const auto known = abilities_.find(worker);
  return known == abilities_.end() ? 0 : known->second.memory_mb;
}

int64_t Scheduler::LargestMemory(const ReadyKey& jobs) const {
  int64_t largest_mb = 0;
  for (const auto& [name, worker] : abilities_) {
    const bool takes = std::count(worker.kinds.begin(), worker.kinds.end(), jobs.kind) > 0;
    if (!takes || !Fits({.needs_tags = jobs.tags}, {worker.memory_mb, worker.tags})) continue;
    largest_mb = std::max(largest_mb, worker.memory_mb);
  }
  return largest_mb;
}

int Scheduler::Machines() const {
  std::set<std::string> machines;
  for (const auto& [name, memory] : workers_) machines.insert(MachineOf(name));
  return static_cast<int>(machines.size());
}

bool Scheduler::OthersAround(const std::string& worker) {
  const double now = tables_.SteadySeconds();
  std::erase_if(workers_,
                [&](const auto& known) { return now - known.second.seen_s > kWorkerForgottenS; });
  return workers_.size() > (workers_.count(worker) ? 1u : 0u);
}

StudyShare Scheduler::ShareOf(Study& study, const Taker& worker) {
  int64_t ready = 0;
  int64_t ready_for_it = 0;
  for (size_t kind = 0; kind < tables_.kinds.size(); ++kind) {
    ready += study.tally.ready[kind];
    if (worker.takes[kind]) ready_for_it += study.tally.ready[kind];
  }
  // A study that is full by its own wish waits for nothing. One that its user's other studies hold
  // back does: it ages, so that they can't do so for ever.
  const bool ignored = tables_.options.unsafe_for_test.ignore_limits;
  const bool hungry = ready > 0 && !study.tally.paused && !study.tally.cancelled &&
                      (!study.tally.IsFull() || ignored);
  const double now = tables_.SteadySeconds();
  if (!hungry) {
    study.hungry_since_s = -1;
  } else if (study.hungry_since_s < 0) {
    // A study does not save up turns while it has no jobs.
    study.hungry_since_s = now;
    study.pass = std::max(study.pass, virtual_pass_);
  }
  return {.study = study.id,
          .priority = study.Priority(),
          .pass = study.pass,
          .waiting_s = hungry ? now - study.hungry_since_s : 0,
          .open = hungry && ready_for_it > 0 && (!study.share->IsFull() || ignored),
          .needs_memory_mb = study.needs_memory_mb,
          .needs_tags = study.needs_tags};
}

absl::StatusOr<std::optional<JobRow>> Scheduler::Choose(const Taker& worker) {
  ASSIGN_OR_RETURN(std::optional<JobRow> warm, ChooseWarm(worker));
  if (warm) return warm;
  std::vector<StudyShare> shares;
  for (auto& [id, study] : tables_.ledger.loaded_studies()) {
    if (!study.tally.finished) shares.push_back(ShareOf(study, worker));
  }
  for (const int64_t id : OrderStudies(shares, {worker.facts.memory_mb, worker.facts.tags})) {
    ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(id));
    // Later stages first: what has been begun is finished, and few scenes are open at a time.
    for (size_t kind = tables_.kinds.size(); kind-- > 0;) {
      if (!worker.takes[kind] || study->tally.ready[kind] == 0) continue;
      ASSIGN_OR_RETURN(std::optional<JobRow> job,
                       ChooseOf(*study, KindId{static_cast<uint8_t>(kind)}, worker));
      if (job) return job;
    }
  }
  return std::optional<JobRow>();
}

absl::StatusOr<std::optional<JobRow>> Scheduler::ChooseOf(Study& study, KindId kind,
                                                          const Taker& worker) {
  const std::string& name = worker.facts.name;
  const bool others = OthersAround(name);
  SqliteQuery query(tables_.db, kReadyOfStudy, study.id, tables_.kinds[kind].name(),
                    kCandidates + kMostUnsuitable);
  int suitable = 0;
  std::optional<JobRow> own;  // The job that this worker failed or lost comes after all others.
  while (suitable < kCandidates && query.Next()) {
    ASSIGN_OR_RETURN(JobRow job, JobRowOf(query, tables_.kinds));
    if (!FitsJob(job, worker)) continue;
    ASSIGN_OR_RETURN(const bool complete, waiters_.HasWhatItWaitedFor(job));
    if (!complete) continue;
    ++suitable;
    const double waited = tables_.Now() - job.ready_unix_s;
    const JobCandidate candidate{job.id, job.worker, waited < 0 ? kElsewhereS : waited};
    if (PickJob({&candidate, 1}, name, others) != 0) continue;
    if (job.worker != name) return std::optional<JobRow>(std::move(job));
    if (!own) own = std::move(job);
  }
  RETURN_IF_ERROR(query.status());
  return own;
}

bool Scheduler::FitsJob(const JobRow& job, const Taker& worker) const {
  const WorkNeeds needs = tables_.kinds[job.kind].NeedsOf(job.input);
  return Fits({.needs_memory_mb = needs.memory_mb, .needs_tags = needs.tags},
              {worker.facts.memory_mb, worker.facts.tags});
}

absl::StatusOr<std::optional<JobRow>> Scheduler::ChooseWarm(const Taker& worker) {
  const auto known = workers_.find(worker.facts.name);
  if (known == workers_.end()) return std::optional<JobRow>();
  for (const Sha256Digest& group : known->second.groups) {
    SqliteQuery query(tables_.db, kReadyOfGroup, group, kCandidates);
    while (query.Next()) {
      ASSIGN_OR_RETURN(JobRow job, JobRowOf(query, tables_.kinds));
      if (!worker.takes[job.kind.value] || job.worker == worker.facts.name) continue;
      ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(job.study));
      const StudyShare share = ShareOf(*study, worker);
      if (tables_.kinds[job.kind].traits().keeps_group_warm && share.open && FitsJob(job, worker) &&
          Fits(share, {worker.facts.memory_mb, worker.facts.tags})) {
        return std::optional<JobRow>(std::move(job));
      }
    }
    RETURN_IF_ERROR(query.status());
  }
  return std::optional<JobRow>();
}

absl::StatusOr<GrantedLease> Scheduler::Grant(JobRow job, const Taker& worker) {
  RETURN_IF_ERROR(SplitIfIdle(job, worker));
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  ASSIGN_OR_RETURN(Study * study, tables_.ledger.FindStudy(job.study));
  const JobKind& kind = tables_.kinds[job.kind];
  job.part_given = false;
  if (kind.traits().shares_part && tables_.without_part.erase(job.id) == 0) {
    ASSIGN_OR_RETURN(job.part_given, kind.HasPart(jobs_.desk(), job));
  }
  GrantedLease lease{.work = {job, variant->seed, variant->config},
                     .fence = NextFence(),
                     .worker = worker.facts.name,
                     .attempt_number = job.attempts + 1,
                     .study = study->name,
                     .variant = variant->name};
  if (kind.traits().resumes) {
    ASSIGN_OR_RETURN(const Sha256Digest keep_key, kind.KeepKey(jobs_.desk(), job));
    ASSIGN_OR_RETURN(lease.work.kept_folders, tables_.folders.Kept(keep_key, kMostKept));
  }
  RETURN_IF_ERROR(tables_.jobs.MoveToLeased(job, lease.fence, lease.worker, job.part_given));
  tables_.NoteMove(*variant, job, JobState::kLeased);
  RETURN_IF_ERROR(
      jobs_.BlockSiblings(job, /*whole_group=*/kind.traits().shares_part && !job.part_given));

  study->pass += 1;
  virtual_pass_ = study->pass;
  study->hungry_since_s = tables_.SteadySeconds();
  if (kind.traits().keeps_group_warm) {
    std::deque<Sha256Digest>& groups = workers_[lease.worker].groups;
    std::erase(groups, job.group_key);
    groups.push_front(job.group_key);
    if (groups.size() > kGroupsRemembered) groups.pop_back();
  }
  ++tables_.leased_now;
  tables_.effects.granted.push_back({.job = job.id, .fence = lease.fence, .worker = lease.worker});
  return lease;
}

bool Scheduler::OnlyTheseLeft(KindId kind) const {
  if (!tables_.hungry.empty()) return false;
  const auto of = [&](size_t other, JobState state) {
    return tables_.ledger.totals()[other][static_cast<size_t>(state)];
  };
  for (size_t other = 0; other < tables_.kinds.size(); ++other) {
    // Jobs that only wait for these pairs will not make more of them.
    if (other == kind.value || !tables_.kinds.at(other).traits().of_scene) continue;
    for (const JobState state :
         {JobState::kReady, JobState::kLeased, JobState::kBlocked, JobState::kRetryWait}) {
      if (of(other, state) > 0) return false;
    }
  }
  return of(kind.value, JobState::kBlocked) + of(kind.value, JobState::kRetryWait) == 0;
}

absl::Status Scheduler::SplitIfIdle(JobRow& job, const Taker& worker) {
  const JobKind& kind = tables_.kinds[job.kind];
  // A retry keeps its predecessor's rigs.
  if (!kind.traits().can_split || job.rig_count < 2 || job.generation > 1) {
    return absl::OkStatus();
  }
  ASSIGN_OR_RETURN(Variant * variant, tables_.ledger.FindVariant(job.variant));
  const auto ready = [&](size_t k) {
    return tables_.ledger.totals()[k][static_cast<size_t>(JobState::kReady)];
  };
  SplitFacts facts{.rigs = job.rig_count,
                   .ready_jobs = ready(job.kind.value),
                   .idle_slots = worker.idle_slots[job.kind.value],
                   .slots = worker.slots[job.kind.value]};
  ASSIGN_OR_RETURN(const Study* study, tables_.ledger.FindStudy(job.study));
  // Slots that its limits keep from it are none for its parts.
  const int room = static_cast<int>(std::min<int64_t>(study->Room(), INT32_MAX));
  facts.idle_slots = std::min(facts.idle_slots, room);
  facts.slots = std::min(facts.slots, room);
  for (size_t other = 0; other < tables_.kinds.size(); ++other) {
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
  ASSIGN_OR_RETURN(const JobKeys keys, kind.Keys(jobs_.desk(), first));
  first.work_key = keys.work;
  // A job of another study may be making that part.
  ASSIGN_OR_RETURN(const JobStanding standing,
                   jobs_.StandingAmongLeased(first, /*whole_group=*/false));
  if (standing.state != JobState::kReady) return absl::OkStatus();
  RETURN_IF_ERROR(tables_.jobs.ShrinkReady(job.id, first.rigs, first.rig_count, first.work_key));
  job = first;
  for (uint32_t part = 1; part < parts; ++part) {
    RETURN_IF_ERROR(jobs_
                        .AddJob({.kind = kind.name(),
                                 .variant = job.variant,
                                 .ordinal = job.ordinal,
                                 .rigs = part_of(part),
                                 .input = job.input,
                                 .generation = job.generation})
                        .status());
    ++tables_.effects.splits;
  }
  return absl::OkStatus();
}

}  // namespace parallax
