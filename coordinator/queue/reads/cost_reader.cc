#include "coordinator/queue/reads/cost_reader.h"

#include "coordinator/queue/database/compress.h"
#include "parallax/v1/jobs.pb.h"

namespace parallax {
namespace {

absl::Status AddPairs(SqliteConnection& db, int64_t study, StudyCosts& costs) {
  SqliteQuery query(db,
                    "SELECT v.name, f.reused, r.bytes FROM frames AS f"
                    " JOIN variants AS v ON v.id = f.variant_id"
                    " JOIN results AS r ON r.work_key = f.frame_key"
                    " WHERE f.study_id = ?1 ORDER BY v.id, f.ordinal, f.rig",
                    study);
  while (query.Next()) {
    v1::FrameResult frame;
    RETURN_IF_ERROR(UnpackMessage(query.Blob(2), frame));
    const auto found = frame.stage_s().find("cpu");
    const double core_s = found == frame.stage_s().end() ? 0 : found->second;
    StudyCosts::Pairs& of_variant = costs.variants[std::string(query.Text(0))];
    ++of_variant.pairs;
    of_variant.core_s += core_s;
    if (query.Int(1) == 0) costs.fresh_core_s += core_s;
  }
  return query.status();
}

// A variant's solves count in it whoever made them, so that variants that share layouts can be
// compared.
absl::Status AddSolves(SqliteConnection& db, const KindRegistry& kinds, int64_t study,
                       StudyCosts& costs) {
  SqliteQuery query(db,
                    "SELECT v.name, r.core_s, r.job_id = j.id, v.id, j.id, r.stage"
                    " FROM variants AS v JOIN all_jobs AS j ON j.variant_id = v.id"
                    " JOIN results AS r ON r.work_key IN (j.work_key, j.group_key)"
                    " WHERE v.study_id = ?1 AND j.kind = ?2"
                    " AND j.state IN ('SUCCEEDED', 'REJECTED') ORDER BY v.id, j.id, r.stage",
                    study, kinds[kinds.begins_scenes()].name());
  while (query.Next()) {
    costs.variants[std::string(query.Text(0))].core_s += query.Real(1);
    if (query.Int(2) == 1) costs.fresh_core_s += query.Real(1);
  }
  return query.status();
}

absl::Status AddOthers(SqliteConnection& db, const KindRegistry& kinds, int64_t study,
                       StudyCosts& costs) {
  SqliteQuery query(db,
                    "SELECT j.kind, j.input, j.reused, r.bytes, j.variant_id, j.ordinal, j.id"
                    " FROM study_results AS s"
                    " JOIN all_jobs AS j ON j.id = s.job_id"
                    " JOIN results AS r ON r.work_key = s.work_key"
                    " WHERE s.study_id = ?1 ORDER BY j.variant_id, j.kind, j.ordinal, j.id",
                    study);
  while (query.Next()) {
    ASSIGN_OR_RETURN(const KindId kind, kinds.IdOf(query.Text(0)));
    const double core_s = kinds[kind].CoreSecondsOf(query.Blob(1), query.Blob(3));
    // Jobs without a scene are trainings, which can resume, and evaluations, which can't.
    (kinds[kind].traits().resumes ? costs.train_core_s : costs.evaluate_core_s) += core_s;
    if (query.Int(2) == 0) costs.fresh_core_s += core_s;
  }
  return query.status();
}

}  // namespace

absl::StatusOr<StudyCosts> StudyCostsIn(SqliteConnection& db, const KindRegistry& kinds,
                                        int64_t study) {
  StudyCosts costs;
  RETURN_IF_ERROR(AddPairs(db, study, costs));
  RETURN_IF_ERROR(AddSolves(db, kinds, study, costs));
  RETURN_IF_ERROR(AddOthers(db, kinds, study, costs));
  return costs;
}

}  // namespace parallax
