#include "coordinator/queue/tables/ready_board.h"

#include <vector>

namespace parallax {
namespace {

struct CountedKind {
  int64_t study = 0;
  const JobKind* kind = nullptr;
  int64_t jobs = 0;
  WorkNeeds needs;
};

absl::StatusOr<std::vector<CountedKind>> ReadyByKind(SqliteConnection& db,
                                                     const KindRegistry& kinds) {
  SqliteQuery query(db, R"sql(
SELECT s.id, c.kind, sum(c.jobs), s.needs_memory_mb, s.needs_tags
FROM studies AS s JOIN variants AS v ON v.study_id = s.id
  JOIN job_counts AS c ON c.variant_id = v.id AND c.state = 'READY' AND c.jobs > 0
WHERE s.finished_unix_s IS NULL GROUP BY s.id, c.kind)sql");
  std::vector<CountedKind> counted;
  while (query.Next()) {
    ASSIGN_OR_RETURN(const KindId kind, kinds.IdOf(query.Text(1)));
    counted.push_back({query.Int(0), &kinds[kind], query.Int(2),
                       WorkNeeds{query.Int(3), TagLines(query.Text(4))}});
  }
  RETURN_IF_ERROR(query.status());
  return counted;
}

}  // namespace

absl::Status ReadyBoard::Load(SqliteConnection& db, const KindRegistry& kinds) {
  ASSIGN_OR_RETURN(const std::vector<CountedKind> counted, ReadyByKind(db, kinds));
  const std::lock_guard lock(mutex_);
  jobs_.clear();
  for (const CountedKind& one : counted) {
    // Jobs of scenes are many, and few have needs of their own.
    const ReadyKey usual = ReadyKeyOf(one.study, one.needs, *one.kind, {});
    int64_t left = one.jobs;
    SqliteQuery query(db,
                      "SELECT input FROM jobs"
                      " WHERE study_id = ?1 AND kind = ?2 AND state = 'READY' AND input <> x''",
                      one.study, one.kind->name());
    while (query.Next()) {
      ++jobs_[ReadyKeyOf(one.study, one.needs, *one.kind, one.kind->NeedsOf(query.Blob(0)))];
      --left;
    }
    RETURN_IF_ERROR(query.status());
    if (left > 0) jobs_[usual] += left;
  }
  return absl::OkStatus();
}

void ReadyBoard::Apply(const ReadyChanges& changes) {
  const std::lock_guard lock(mutex_);
  for (const auto& [key, change] : changes) {
    const auto group = jobs_.try_emplace(key, 0).first;
    group->second += change;
    if (group->second == 0) jobs_.erase(group);
  }
}

std::map<ReadyKey, int64_t> ReadyBoard::Groups(int64_t study) const {
  const std::lock_guard lock(mutex_);
  if (study == 0) return jobs_;
  return {jobs_.lower_bound(ReadyKey{.study = study}),
          jobs_.lower_bound(ReadyKey{.study = study + 1})};
}

}  // namespace parallax
