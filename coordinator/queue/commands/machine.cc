// The frame of all commands: their beginning, end and undoing, and what belongs to no other part.
#include "coordinator/queue/commands/machine.h"

#include <chrono>
#include <utility>

namespace parallax {

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
  missing_.clear();
  granted_mark_ = effects_.granted.size();
  ended_mark_ = effects_.ended.size();
  ready_mark_ = effects_.ready.size();
  counts_mark_ = effects_;
}

absl::Status Machine::EndCommand() {
  while (!missing_.empty()) {
    const std::vector<DamagedResult> missing = std::exchange(missing_, {});
    RETURN_IF_ERROR(TakeBack(missing, "coordinator").status());
  }
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
  effects_.ready.resize(ready_mark_);
  static_cast<EffectCounts&>(effects_) = counts_mark_;
}

Effects Machine::TakeEffects() {
  Effects taken = std::move(effects_);
  effects_ = Effects();
  granted_mark_ = ended_mark_ = ready_mark_ = 0;
  evidence_.Pass(SteadySeconds(), workers_.size());
  for (const LeaseRef& lease : taken.granted) evidence_.Begin(lease.job, lease.fence);
  for (const LeaseRef& lease : taken.ended) {
    evidence_.End(lease.job, lease.fence, lease.end, lease.machine, lease.progress);
  }
  evidence_.CountLost(taken.workers_lost);
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

absl::Status Machine::KeepScrub(const ScrubState& scrub) {
  return db_.Run(
      "INSERT INTO scrub(one, position, began_unix_s, ended_unix_s, files, bytes, damaged)"
      " VALUES (1, ?1, ?2, ?3, ?4, ?5, ?6) ON CONFLICT DO UPDATE SET position = ?1,"
      " began_unix_s = ?2, ended_unix_s = ?3, files = ?4, bytes = ?5, damaged = ?6",
      SqlBlob{scrub.position}, scrub.began_unix_s, scrub.ended_unix_s, scrub.files, scrub.bytes,
      scrub.damaged);
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

}  // namespace parallax
