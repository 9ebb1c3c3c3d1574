#include "coordinator/queue/commands/machine.h"

#include <utility>

namespace parallax {

absl::Status Machine::Load() {
  RETURN_IF_ERROR(tables_.ledger.LoadUnfinished());
  for (const auto& [id, study] : tables_.ledger.loaded_studies()) {
    tables_.hungry.insert(study.variants.begin(), study.variants.end());
  }
  ASSIGN_OR_RETURN(const auto leased,
                   tables_.db.Integer("SELECT count(*) FROM jobs WHERE state = 'LEASED'"));
  tables_.leased_now = leased.value_or(0);
  return tables_.waits.Load();
}

void Machine::BeginCommand() {
  tables_.ledger.BeginCommand();
  tables_.scenes.Close();
  tables_.ended_jobs.clear();
  tables_.changed_variants.clear();
  tables_.missing.clear();
  granted_mark_ = tables_.effects.granted.size();
  ended_mark_ = tables_.effects.ended.size();
  tables_.ready_mark = tables_.effects.ready.size();
  counts_mark_ = tables_.effects;
}

absl::Status Machine::EndCommand() {
  while (!tables_.missing.empty()) {
    const std::vector<DamagedResult> missing = std::exchange(tables_.missing, {});
    RETURN_IF_ERROR(repair_.TakeBack(missing, "coordinator").status());
  }
  RETURN_IF_ERROR(waiters_.Settle(jobs_));
  RETURN_IF_ERROR(tables_.scenes.Flush());
  tables_.scenes.Close();
  return absl::OkStatus();
}

void Machine::UndoCommand() {
  tables_.ledger.UndoCommand();
  tables_.scenes.Close();
  // Its knowledge may be of rows that are undone.
  tables_.without_part.clear();
  tables_.leased_now -= static_cast<int64_t>(tables_.effects.granted.size() - granted_mark_);
  tables_.leased_now += static_cast<int64_t>(tables_.effects.ended.size() - ended_mark_);
  tables_.effects.granted.resize(granted_mark_);
  tables_.effects.ended.resize(ended_mark_);
  tables_.effects.ready.resize(tables_.ready_mark);
  static_cast<EffectCounts&>(tables_.effects) = counts_mark_;
}

Effects Machine::TakeEffects() {
  Effects taken = std::move(tables_.effects);
  tables_.effects = Effects();
  granted_mark_ = ended_mark_ = tables_.ready_mark = 0;
  reports_.TakeEvidence(taken);
  return taken;
}

absl::Status Machine::Reload() {
  tables_.ledger.Drop();
  tables_.effects = Effects();  // Nothing of it has happened: it is evidence of nothing.
  TakeEffects();
  tables_.hungry.clear();
  tables_.without_part.clear();
  tables_.scenes.Close();
  return Load();
}

absl::Status Machine::Settle() {
  for (const int64_t id : tables_.ledger.changed_studies()) {
    Study* const study = &tables_.ledger.loaded_studies().at(id);
    if (study->tally.forgotten) continue;
    bool finished = true;
    for (const int64_t variant_id : study->variants) {
      ASSIGN_OR_RETURN(const Variant* variant, tables_.ledger.FindVariant(variant_id));
      const VariantTally& tally = variant->tally;
      const bool complete = study->tally.cancelled || !tally.problem.empty() ||
                            tally.pairs_planned >= variant->pairs_wanted;
      if (!complete || tally.OpenJobs() > 0) {
        finished = false;
        break;
      }
    }
    if (finished == study->tally.finished) continue;
    RETURN_IF_ERROR(tables_.db.Run("UPDATE studies SET finished_unix_s = ?2 WHERE id = ?1", id,
                                   finished ? std::optional<double>(tables_.Now()) : std::nullopt));
    study->tally.finished = finished;
    const double now = tables_.Now();
    if (finished) RETURN_IF_ERROR(tables_.notices.Raise(id, kNoticeDone, now, now));
  }
  return absl::OkStatus();
}

}  // namespace parallax
