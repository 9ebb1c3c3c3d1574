#include "coordinator/queue/auditor.h"

#include <algorithm>

#include "coordinator/queue/compress.h"
#include "coordinator/queue/job_state.h"
#include "coordinator/study/keys.h"
#include "coordinator/study/rigs.h"
#include "parallax/v1/jobs.pb.h"
#include "parallax/v1/scene.pb.h"

namespace parallax {
namespace {

constexpr size_t kShownOfAKind = 10;

#define TERMINAL "('SUCCEEDED', 'REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')"
#define LOST "('REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')"

const std::vector<Invariant>* MakeInvariants() {
  return new std::vector<Invariant>{
      // ---- Leases and fences
      {"no two attempts hold equal work",
       "SELECT group_concat(id) FROM jobs WHERE state = 'LEASED' GROUP BY kind, work_key"
       " HAVING count(*) > 1"},
      {"no two attempts make one layout",
       "SELECT group_concat(id) FROM jobs WHERE state = 'LEASED' AND kind = 'solve'"
       " AND layout_given = 0 GROUP BY group_key HAVING count(*) > 1"},
      {"a blocked job awaits a lease of the same work or layout",
       "SELECT j.id FROM jobs AS j LEFT JOIN jobs AS l ON l.id = j.awaits_job"
       " WHERE j.state = 'BLOCKED' AND (l.id IS NULL OR l.state <> 'LEASED' OR l.kind <> j.kind"
       " OR (l.work_key <> j.work_key AND (j.kind <> 'solve' OR l.group_key <> j.group_key)))"},
      {"a ready job's work is not held or done by others",
       "SELECT j.id FROM jobs AS j WHERE j.state = 'READY' AND (EXISTS (SELECT 1 FROM jobs AS l"
       " WHERE l.state = 'LEASED' AND l.group_key = j.group_key AND l.work_key = j.work_key)"
       " OR (j.kind = 'solve' AND (EXISTS (SELECT 1 FROM scene_results AS r"
       " WHERE r.scene_key = j.work_key) OR EXISTS (SELECT 1 FROM layout_results AS r"
       " WHERE r.layout_key = j.group_key AND r.rejected IS NOT NULL))))"},
      {"a fence names one attempt",
       "SELECT fence FROM (SELECT fence, id FROM all_jobs WHERE fence IS NOT "
       "NULL"
       " UNION SELECT fence, job_id FROM all_losses) GROUP BY fence HAVING "
       "count(*) > 1"},
      {"a fence was issued by an epoch on record",
       "SELECT id FROM all_jobs WHERE fence IS NOT NULL"
       " AND (fence >> 32) NOT IN (SELECT epoch FROM epochs)"},
      {"an attempt that was lost did not win",
       "SELECT j.id FROM jobs AS j JOIN attempt_losses AS l ON l.job_id = j.id AND l.fence = "
       "j.fence"
       " WHERE j.state IN ('LEASED', 'SUCCEEDED', 'REJECTED')"},
      {"the ledgers agree with the jobs",
       "SELECT j.id FROM all_jobs AS j WHERE (j.app_failures > 0 OR j.infra_losses > 0"
       " OR j.id IN (SELECT job_id FROM all_losses)) AND (j.app_failures <>"
       " (SELECT count(*) FROM all_losses AS l WHERE l.job_id = j.id AND l.ledger = 'app')"
       " OR j.infra_losses <> (SELECT count(*) FROM all_losses AS l WHERE l.job_id = j.id"
       " AND l.ledger <> 'app') OR j.attempts < j.app_failures + j.infra_losses)"},
      {"only the work itself fails a job",
       "SELECT id FROM all_jobs WHERE state = 'FAILED' AND app_failures = 0"},
      {"a result is an attempt's or reused",
       "SELECT id FROM all_jobs WHERE state IN ('SUCCEEDED', 'REJECTED')"
       " AND (fence IS NULL) <> (reused = 1)"},
      // ---- Expansion
      {"a solved scene has its result",
       "SELECT j.id FROM all_jobs AS j LEFT JOIN scene_results AS r ON "
       "r.scene_key = j.work_key"
       " LEFT JOIN scenes AS s ON s.variant_id = j.variant_id AND s.ordinal = "
       "j.ordinal"
       " WHERE j.kind = 'solve' AND j.state = 'SUCCEEDED' AND (r.scene_hash IS "
       "NULL"
       " OR s.scene_hash IS NULL OR r.scene_hash <> s.scene_hash)"},
      {"a rejected scene has its verdict",
       "SELECT j.id FROM all_jobs AS j WHERE j.state = 'REJECTED' AND NOT "
       "EXISTS (SELECT 1 FROM"
       " scene_results AS r WHERE r.scene_key = j.work_key AND r.rejected IS "
       "NOT NULL)"
       " AND NOT EXISTS (SELECT 1 FROM layout_results AS r WHERE r.layout_key "
       "= j.group_key"
       " AND r.rejected IS NOT NULL)"},
      {"a scene's pairs are done, lost or asked for",
       "SELECT s.variant_id || '/' || s.ordinal FROM scenes AS s WHERE s.rigs - s.rigs_lost"
       " <> s.rigs_done + coalesce((SELECT sum(j.rig_count) FROM jobs AS j"
       " WHERE j.variant_id = s.variant_id AND j.ordinal = s.ordinal AND j.kind = 'render'"
       " AND j.state NOT IN " TERMINAL "), 0) + CASE WHEN EXISTS (SELECT 1 FROM jobs AS j"
       " WHERE j.variant_id = s.variant_id AND j.ordinal = s.ordinal AND j.kind = 'solve'"
       " AND j.state NOT IN " TERMINAL ") THEN s.rigs ELSE 0 END"},
      {"a scene counts its open jobs",
       "SELECT s.variant_id || '/' || s.ordinal FROM scenes AS s WHERE s.jobs_open <>"
       " (SELECT count(*) FROM jobs AS j WHERE j.variant_id = s.variant_id"
       " AND j.ordinal = s.ordinal AND j.state NOT IN " TERMINAL ")"},
      {"a scene counts its frames",
       "SELECT s.variant_id || '/' || s.ordinal FROM scenes AS s WHERE s.rigs_done <>"
       " (SELECT count(*) FROM frames AS f WHERE f.variant_id = s.variant_id"
       " AND f.ordinal = s.ordinal)"},
      {"a variant's scenes are its ordinals without gaps",
       "SELECT v.id FROM variants AS v WHERE v.next_ordinal <> (SELECT count(*) FROM scenes AS s"
       " WHERE s.variant_id = v.id) OR v.next_ordinal <> (SELECT coalesce(max(ordinal) + 1, 0)"
       " FROM scenes AS s WHERE s.variant_id = v.id)"},
      {"a frame belongs to a scene and its job",
       "SELECT cursor FROM frames AS f WHERE NOT EXISTS (SELECT 1 FROM scenes AS s"
       " WHERE s.variant_id = f.variant_id AND s.ordinal = f.ordinal AND f.rig < s.rigs)"},
      {"a published result was published by a job that succeeded",
       "SELECT hex(r.frame_key) FROM frame_results AS r LEFT JOIN jobs AS j ON "
       "j.id = r.job_id"
       " LEFT JOIN archived_jobs AS a ON a.id = r.job_id"
       " WHERE coalesce(j.state, a.state, '') <> 'SUCCEEDED'"
       " OR coalesce(j.kind, a.kind, '') <> 'render' OR coalesce(j.fence, "
       "a.fence) IS NOT r.fence"},
      // ---- Archive and litter
      {"a job is in one table",
       "SELECT a.id FROM archived_jobs AS a WHERE EXISTS (SELECT 1 FROM jobs "
       "AS j WHERE j.id = a.id)"},
      {"only finished studies are archived",
       "SELECT s.id FROM studies AS s WHERE s.archived = 1 AND "
       "s.finished_unix_s IS NULL"},
      {"archived jobs are of archived studies",
       "SELECT a.id FROM archived_jobs AS a JOIN studies AS s ON s.id = "
       "a.study_id"
       " WHERE s.archived = 0"},
      {"a cancelled study has nothing unfinished",
       "SELECT j.id FROM jobs AS j JOIN studies AS s ON s.id = j.study_id"
       " WHERE s.cancelled = 1 AND j.state NOT IN " TERMINAL},
      {"a study is finished exactly when nothing is left",
       "SELECT s.id FROM studies AS s WHERE (s.finished_unix_s IS NOT NULL) <> NOT EXISTS ("
       " SELECT 1 FROM variants AS v WHERE v.study_id = s.id AND (EXISTS (SELECT 1 FROM jobs AS j"
       " WHERE j.variant_id = v.id AND j.state NOT IN " TERMINAL ") OR (s.cancelled = 0"
       " AND v.problem = '' AND v.pairs_planned < v.pairs_wanted)))"},
      // ---- Counters
      {"job counts are right",
       "SELECT variant_id || ' ' || kind || ' ' || state FROM (SELECT "
       "variant_id, kind, state,"
       " jobs AS n FROM job_counts UNION ALL SELECT variant_id, kind, state, "
       "-count(*) FROM jobs"
       " GROUP BY variant_id, kind, state UNION ALL SELECT variant_id, kind, "
       "state, -count(*)"
       " FROM archived_jobs GROUP BY variant_id, kind, state) GROUP BY "
       "variant_id, kind, state HAVING sum(n) <> 0"},
      {"pairs planned are right",
       "SELECT id FROM variants AS v WHERE pairs_planned <> (SELECT coalesce(sum(rigs - "
       "rigs_lost), 0)"
       " FROM scenes AS s WHERE s.variant_id = v.id)"},
      {"pairs done are right",
       "SELECT id FROM variants AS v WHERE pairs_done <> (SELECT count(*) FROM frames AS f"
       " WHERE f.variant_id = v.id)"},
      {"open scenes are counted right",
       "SELECT id FROM variants AS v WHERE scenes_open <> (SELECT count(*) FROM scenes AS s"
       " WHERE s.variant_id = v.id AND s.jobs_open > 0)"},
      {"reuse is counted right",
       "SELECT id FROM variants AS v WHERE frames_reused <> (SELECT count(*) "
       "FROM frames AS f"
       " WHERE f.variant_id = v.id AND f.reused = 1) OR solves_reused <> "
       "(SELECT count(*)"
       " FROM jobs AS j WHERE j.variant_id = v.id AND j.kind = 'solve' AND "
       "j.state = 'SUCCEEDED'"
       " AND j.reused = 1) + (SELECT count(*) FROM archived_jobs AS j WHERE "
       "j.variant_id = v.id"
       " AND j.kind = 'solve' AND j.state = 'SUCCEEDED' AND j.reused = 1)"
       " OR layouts_reused <> (SELECT count(*) FROM jobs AS j"
       " WHERE j.variant_id = v.id AND j.layout_given = 1 AND j.reused = 0"
       " AND j.state IN ('SUCCEEDED', 'REJECTED')) + (SELECT count(*) FROM "
       "archived_jobs AS j"
       " WHERE j.variant_id = v.id AND j.layout_given = 1 AND j.reused = 0"
       " AND j.state IN ('SUCCEEDED', 'REJECTED'))"},
      {"rejections are counted right",
       "SELECT id FROM variants AS v WHERE scenes_rejected <> (SELECT count(*) "
       "FROM jobs AS j"
       " WHERE j.variant_id = v.id AND j.state = 'REJECTED') + (SELECT count(*)"
       " FROM archived_jobs AS j WHERE j.variant_id = v.id AND j.state = "
       "'REJECTED')"},
  };
}

using Violations = std::vector<std::string>;

absl::Status Collect(SqliteConnection& db, const char* name, const char* sql, Violations& out) {
  SqliteQuery query(db, sql);
  size_t shown = 0;
  while (query.Next() && shown < kShownOfAKind) {
    out.push_back(std::string(name) + ": not " + std::string(query.Text(0)));
    ++shown;
  }
  return WithContext(query.status(), name);
}

absl::Status CheckFile(SqliteConnection& db, Violations& out) {
  SqliteQuery integrity(db, "PRAGMA integrity_check(10)");
  while (integrity.Next()) {
    if (integrity.Text(0) != "ok") out.push_back("integrity: " + std::string(integrity.Text(0)));
  }
  RETURN_IF_ERROR(integrity.status());
  SqliteQuery keys(db, "PRAGMA foreign_key_check");
  while (keys.Next()) {
    out.push_back("foreign key: table " + std::string(keys.Text(0)) + " row " +
                  std::to_string(keys.Int(1)));
  }
  return keys.status();
}

// Every rig of a render job that succeeded is a frame; nothing else is.
absl::Status CheckRigs(SqliteConnection& db, Violations& out) {
  SqliteQuery jobs(db,
                   "SELECT id, variant_id, ordinal, rigs, rig_count FROM all_jobs"
                   " WHERE kind = 'render' AND state = 'SUCCEEDED'");
  while (jobs.Next()) {
    const auto rigs = ParseRigs(jobs.Text(3));
    bool all = rigs.ok() && static_cast<int64_t>(rigs->size()) == jobs.Int(4);
    for (size_t i = 0; all && i < rigs->size(); ++i) {
      ASSIGN_OR_RETURN(const auto found,
                       db.Integer("SELECT 1 FROM frames WHERE variant_id = ?1 AND ordinal = ?2"
                                  " AND rig = ?3",
                                  jobs.Int(1), jobs.Int(2), (*rigs)[i]));
      all = found.has_value();
    }
    if (!all) out.push_back("a render job has all its frames: not " + std::to_string(jobs.Int(0)));
  }
  return jobs.status();
}

// Stored messages are whole, recipes hash to their names, frames lie in the folder of the attempt
// that won.
absl::Status CheckPayloads(SqliteConnection& db, Violations& out) {
  SqliteQuery recipes(db, "SELECT scene_hash, scene_z FROM recipes");
  while (recipes.Next()) {
    const auto bytes = Decompress(recipes.Blob(1));
    if (!bytes.ok() || Sha256Of(*bytes) != recipes.Digest(0)) {
      out.push_back("a recipe hashes to its name: not " + HexOf(recipes.Digest(0)));
    }
  }
  RETURN_IF_ERROR(recipes.status());
  SqliteQuery frames(db,
                     "SELECT r.frame_key, r.frame_z, r.fence, coalesce(j.work_key, a.work_key)"
                     " FROM frame_results AS r LEFT JOIN jobs AS j ON j.id = r.job_id"
                     " LEFT JOIN archived_jobs AS a ON a.id = r.job_id");
  ASSIGN_OR_RETURN(const auto litter, db.Integer("SELECT count(*) FROM litter"));
  while (frames.Next()) {
    v1::FrameResult frame;
    const std::string folder = StorePrefixOf(frames.Digest(3)) + "/.attempt-" +
                               std::to_string(static_cast<uint64_t>(frames.Int(2))) + "/";
    if (!UnpackMessage(frames.Blob(1), frame).ok() ||
        frame.path().compare(0, folder.size(), folder) != 0) {
      out.push_back("a frame lies in the winner's folder: not " + HexOf(frames.Digest(0)));
    }
    if (litter.value_or(0) == 0) continue;
    for (const std::string& path : {frame.path(), folder.substr(0, folder.size() - 1)}) {
      ASSIGN_OR_RETURN(const auto found, db.Integer("SELECT 1 FROM litter WHERE path = ?1", path));
      if (found) out.push_back("a published frame is not litter: not " + path);
    }
  }
  return frames.status();
}

}  // namespace

const std::vector<Invariant>& SqlInvariants() {
  static const std::vector<Invariant>* invariants = MakeInvariants();
  return *invariants;
}

absl::StatusOr<std::vector<std::string>> AuditDatabase(SqliteConnection& db) {
  Violations out;
  RETURN_IF_ERROR(CheckFile(db, out));
  for (const Invariant& invariant : SqlInvariants()) {
    RETURN_IF_ERROR(Collect(db, invariant.name, invariant.sql, out));
  }
  RETURN_IF_ERROR(CheckRigs(db, out));
  RETURN_IF_ERROR(CheckPayloads(db, out));
  return out;
}

}  // namespace parallax
