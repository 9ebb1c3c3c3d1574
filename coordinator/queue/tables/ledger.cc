#include "coordinator/queue/tables/ledger.h"

#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/ready_key.h"

namespace parallax {
namespace {

absl::Status NoSuchId(const char* what, int64_t id) { return NotFound("{} {}: no such", what, id); }

}  // namespace

int64_t VariantTally::OpenJobs() const {
  int64_t open = 0;
  for (const auto& kind : jobs) {
    for (size_t state = 0; state < kJobStates; ++state) {
      if (!IsTerminal(static_cast<JobState>(state))) open += kind[state];
    }
  }
  return open;
}

absl::StatusOr<Study*> Ledger::FindStudy(int64_t id) {
  if (const auto found = studies_.find(id); found != studies_.end()) {
    return found->second.tally.forgotten ? NoSuchId("study", id)
                                         : absl::StatusOr<Study*>(&found->second);
  }
  Study study;
  {
    SqliteQuery query(db_,
                      "SELECT name, seed, priority, needs_memory_mb, needs_tags, paused, cancelled,"
                      " finished_unix_s IS NOT NULL, user, max_running FROM studies"
                      " WHERE id = ?1 AND forgotten = 0",
                      id);
    if (!query.Next()) return query.status().ok() ? NoSuchId("study", id) : query.status();
    study.id = id;
    study.name = query.Text(0);
    study.seed = static_cast<uint64_t>(query.Int(1));
    study.tally.priority = static_cast<int>(query.Int(2));
    study.needs_memory_mb = query.Int(3);
    study.needs_tags = TagLines(query.Text(4));
    study.tally.paused = query.Int(5) != 0;
    study.tally.cancelled = query.Int(6) != 0;
    study.tally.finished = query.Int(7) != 0;
    study.user = query.Text(8);
    study.tally.max_running = query.Int(9);
    study.share = &users_.try_emplace(study.user, UserShare{limits_.Of(study.user)}).first->second;
  }
  Study& kept = studies_.emplace(id, std::move(study)).first->second;
  if (const absl::Status status = LoadVariants(kept); !status.ok()) {
    Forget(id);
    return status;
  }
  return &kept;
}

absl::StatusOr<Variant*> Ledger::FindVariant(int64_t id) {
  if (const auto found = variants_.find(id); found != variants_.end()) return &found->second;
  ASSIGN_OR_RETURN(const auto study,
                   db_.Integer("SELECT study_id FROM variants WHERE id = ?1", id));
  if (!study) return NoSuchId("variant", id);
  RETURN_IF_ERROR(FindStudy(*study).status());
  const auto loaded = variants_.find(id);
  if (loaded != variants_.end()) return &loaded->second;
  return DataLoss("database: variant {} is not among those of its study {}", id, *study);
}

absl::Status Ledger::LoadVariants(Study& study) {
  SqliteQuery query(db_,
                    "SELECT id, name, config_z, pairs_wanted, rigs_per_scene, next_ordinal,"
                    " pairs_planned, pairs_done, scenes_open, solves_reused, layouts_reused,"
                    " frames_reused, scenes_rejected, tally_solved, tally_rejected, tally_lost,"
                    " others_lost, problem, seed FROM variants WHERE study_id = ?1 ORDER BY id",
                    study.id);
  while (query.Next()) {
    Variant variant;
    variant.id = query.Int(0);
    variant.study = study.id;
    variant.name = query.Text(1);
    auto config = std::make_shared<v1::SceneConfig>();
    RETURN_IF_ERROR(UnpackMessage(query.Blob(2), *config));
    variant.digests = DigestsOf(*config);
    variant.config = std::move(config);
    variant.pairs_wanted = query.Int(3);
    variant.rigs_per_scene = static_cast<uint32_t>(query.Int(4));
    VariantTally& tally = variant.tally;
    int column = 5;
    for (int64_t* field :
         {&tally.next_ordinal, &tally.pairs_planned, &tally.pairs_done, &tally.scenes_open,
          &tally.solves_reused, &tally.layouts_reused, &tally.frames_reused, &tally.scenes_rejected,
          &tally.tally_solved, &tally.tally_rejected, &tally.tally_lost, &tally.others_lost}) {
      *field = query.Int(column++);
    }
    tally.problem = query.Text(column++);
    variant.seed = static_cast<uint64_t>(query.Int(column));
    Variant& kept = variants_.emplace(variant.id, std::move(variant)).first->second;
    study.variants.push_back(kept.id);
    RETURN_IF_ERROR(LoadCounts(kept));
    for (size_t kind = 0; kind < kinds_.size(); ++kind) {
      study.tally.ready[kind] += kept.tally.jobs[kind][static_cast<size_t>(JobState::kReady)];
      const int64_t running = kept.tally.jobs[kind][static_cast<size_t>(JobState::kLeased)];
      study.tally.running += running;
      study.share->running += running;
    }
  }
  return query.status();
}

absl::Status Ledger::LoadCounts(Variant& variant) {
  SqliteQuery query(db_, "SELECT kind, state, jobs FROM job_counts WHERE variant_id = ?1",
                    variant.id);
  while (query.Next()) {
    const std::optional<KindId> known_kind = kinds_.Find(query.Text(0));
    const std::optional<JobState> known_state = JobStateOf(query.Text(1));
    if (!known_kind || !known_state) {
      return DataLoss(
          "database: it counts jobs of kind '{}' in state '{}', which this program does not know",
          query.Text(0), query.Text(1));
    }
    const size_t kind = known_kind->value;
    const size_t state = static_cast<size_t>(*known_state);
    variant.tally.jobs[kind][state] = query.Int(2);
    totals_[kind][state] += query.Int(2);
    undo_totals_[kind][state] += query.Int(2);  // Undoing a command does not unload.
  }
  written_[variant.id] = variant.tally.jobs;
  return query.status();
}

absl::Status Ledger::LoadUnfinished() {
  ASSIGN_OR_RETURN(
      const std::vector<int64_t> ids,
      db_.Integers("SELECT id FROM studies WHERE finished_unix_s IS NULL ORDER BY id"));
  for (const int64_t id : ids) RETURN_IF_ERROR(FindStudy(id).status());
  return absl::OkStatus();
}

VariantTally& Ledger::Change(Variant& variant) {
  undo_variants_.try_emplace(variant.id, variant.tally);
  dirty_variants_.insert(variant.id);
  dirty_studies_.insert(variant.study);
  return variant.tally;
}

StudyTally& Ledger::Change(Study& study) {
  undo_studies_.try_emplace(study.id, study.tally);
  dirty_studies_.insert(study.id);
  return study.tally;
}

void Ledger::Count(Variant& variant, KindId kind, JobState state, int64_t change) {
  const size_t k = kind.value;
  const size_t s = static_cast<size_t>(state);
  variant.tally.jobs[k][s] += change;
  totals_[k][s] += change;
  if (state == JobState::kReady) Change(studies_.at(variant.study)).ready[k] += change;
  if (state == JobState::kLeased) {
    Study& study = studies_.at(variant.study);
    Change(study).running += change;
    study.share->running += change;
  }
}

bool Ledger::IsFull(const Variant& variant) const {
  const Study& study = studies_.at(variant.study);
  return study.tally.IsFull() || study.share->IsFull();
}

void Ledger::CountNew(Variant& variant, KindId kind, JobState state) {
  Change(variant);
  Count(variant, kind, state, 1);
}

void Ledger::CountMove(Variant& variant, KindId kind, JobState from, JobState to) {
  Change(variant);
  Count(variant, kind, from, -1);
  Count(variant, kind, to, 1);
}

void Ledger::BeginCommand() {
  undo_variants_.clear();
  undo_studies_.clear();
  created_.clear();
  undo_totals_ = totals_;
}

void Ledger::UndoCommand() {
  for (auto& [id, tally] : undo_variants_) variants_.at(id).tally = std::move(tally);
  for (auto& [id, tally] : undo_studies_) {
    Study& study = studies_.at(id);
    study.share->running += tally.running - study.tally.running;
    study.tally = tally;
  }
  totals_ = undo_totals_;
  for (const int64_t id : created_) {
    const auto study = studies_.find(id);
    if (study == studies_.end()) continue;
    for (const int64_t variant : study->second.variants) {
      variants_.erase(variant);
      written_.erase(variant);
      dirty_variants_.erase(variant);
    }
    dirty_studies_.erase(id);
    studies_.erase(study);
  }
  BeginCommand();
}

absl::Status Ledger::Flush() {
  for (const int64_t id : dirty_variants_) {
    const VariantTally& t = variants_.at(id).tally;
    RETURN_IF_ERROR(
        db_.Run("UPDATE variants SET next_ordinal = ?2, pairs_planned = ?3, pairs_done = ?4,"
                " scenes_open = ?5, solves_reused = ?6, layouts_reused = ?7, frames_reused = ?8,"
                " scenes_rejected = ?9, tally_solved = ?10, tally_rejected = ?11, tally_lost = ?12,"
                " problem = ?13, others_lost = ?14 WHERE id = ?1",
                id, t.next_ordinal, t.pairs_planned, t.pairs_done, t.scenes_open, t.solves_reused,
                t.layouts_reused, t.frames_reused, t.scenes_rejected, t.tally_solved,
                t.tally_rejected, t.tally_lost, t.problem, t.others_lost));
    JobCounts& written = written_[id];
    for (size_t kind = 0; kind < kinds_.size(); ++kind) {
      for (size_t state = 0; state < kJobStates; ++state) {
        if (written[kind][state] == t.jobs[kind][state]) continue;
        RETURN_IF_ERROR(
            db_.Run("INSERT INTO job_counts(variant_id, kind, state, jobs) VALUES (?1, ?2, ?3, ?4)"
                    " ON CONFLICT DO UPDATE SET jobs = ?4",
                    id, kinds_.at(kind).name(), kJobStateNames[state], t.jobs[kind][state]));
        written[kind][state] = t.jobs[kind][state];
      }
    }
  }
  dirty_variants_.clear();
  dirty_studies_.clear();
  return absl::OkStatus();
}

void Ledger::Forget(int64_t id) {
  const auto study = studies_.find(id);
  if (study == studies_.end() || dirty_studies_.count(id) > 0) return;
  for (const int64_t variant : study->second.variants) {
    for (size_t kind = 0; kind < kinds_.size(); ++kind) {
      for (size_t state = 0; state < kJobStates; ++state) {
        totals_[kind][state] -= written_[variant][kind][state];
        undo_totals_[kind][state] -= written_[variant][kind][state];
      }
    }
    variants_.erase(variant);
    written_.erase(variant);
  }
  study->second.share->running -= study->second.tally.running;
  studies_.erase(study);
}

void Ledger::Drop() {
  studies_.clear();
  users_.clear();
  variants_.clear();
  written_.clear();
  dirty_studies_.clear();
  dirty_variants_.clear();
  undo_variants_.clear();
  undo_studies_.clear();
  created_.clear();
  totals_ = {};
  undo_totals_ = {};
}

}  // namespace parallax
