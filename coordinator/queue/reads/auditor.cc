#include "coordinator/queue/reads/auditor.h"

#include <fmt/core.h>
#include <sqlite3.h>

#include <algorithm>
#include <charconv>
#include <string_view>

#include "coordinator/study/rigs.h"

namespace parallax {
namespace {

constexpr size_t kShownOfAKind = 10;

#define TERMINAL "('SUCCEEDED', 'REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')"
#define LOST "('REJECTED', 'FAILED', 'QUARANTINED', 'CANCELLED')"
#define OF_SCENE "(SELECT name FROM job_kinds WHERE of_scene = 1)"
#define SHARES "(SELECT name FROM job_kinds WHERE shares_part = 1)"
#define WITH_PART "j.part_given = 1 AND j.reused = 0 AND j.state IN ('SUCCEEDED', 'REJECTED')"
// Variants of forgotten studies, whose rows go bit by bit.
#define GOING                                                              \
  "(SELECT v.id FROM variants AS v JOIN studies AS s ON s.id = v.study_id" \
  " WHERE s.forgotten > 0)"
#define LOST_OTHER "j.kind NOT IN " OF_SCENE " AND j.state IN " LOST

constexpr JobKind::Invariant kInvariants[] = {
    // ---- Leases and fences
    {"no two attempts hold equal work",
     "SELECT group_concat(id) FROM jobs WHERE state = 'LEASED' GROUP BY kind, work_key"
     " HAVING count(*) > 1"},
    {"no two attempts make one group's part",
     "SELECT group_concat(id) FROM jobs WHERE state = 'LEASED' AND kind IN " SHARES
     " AND part_given = 0 GROUP BY kind, group_key HAVING count(*) > 1"},
    {"a blocked job awaits a lease of the same work or part",
     "SELECT j.id FROM jobs AS j LEFT JOIN jobs AS l ON l.id = j.awaits_job"
     " WHERE j.state = 'BLOCKED' AND j.waits_open = 0"
     " AND (l.id IS NULL OR l.state <> 'LEASED' OR l.kind <> j.kind"
     " OR (l.work_key <> j.work_key AND (j.kind NOT IN " SHARES
     " OR l.group_key <> j.group_key)))"},
    {"a ready job's work is not held or done by others",
     "SELECT j.id FROM jobs AS j WHERE j.state = 'READY' AND (EXISTS (SELECT 1 FROM jobs AS l"
     " WHERE l.state = 'LEASED' AND l.group_key = j.group_key AND l.kind = j.kind"
     " AND l.work_key = j.work_key)"
     " OR EXISTS (SELECT 1 FROM results AS r WHERE r.work_key = j.work_key))"},
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
     " AND l.ledger = 'lost') OR j.attempts < (SELECT count(*) FROM all_losses AS l"
     " WHERE l.job_id = j.id))"},
    {"only the work itself fails a job",
     "SELECT id FROM all_jobs WHERE state = 'FAILED' AND app_failures = 0"},
    {"a result is an attempt's or reused",
     "SELECT id FROM all_jobs WHERE state IN ('SUCCEEDED', 'REJECTED')"
     " AND (fence IS NULL) <> (reused = 1)"},
    {"only kinds that may reject do",
     "SELECT id FROM all_jobs AS j WHERE state = 'REJECTED'"
     " AND NOT (SELECT may_reject FROM job_kinds WHERE name = j.kind)"},
    // ---- Waits
    {"a job counts its open waits",
     "SELECT j.id FROM jobs AS j WHERE (j.waits_open > 0 OR j.id IN (SELECT job_id FROM waits"
     " WHERE state = 'OPEN')) AND j.waits_open <> (SELECT count(*) FROM waits AS w"
     " WHERE w.job_id = j.id AND w.state = 'OPEN')"},
    {"only blocked jobs wait",
     "SELECT j.id FROM jobs AS j WHERE j.waits_open > 0 AND j.state <> 'BLOCKED'"},
    {"a wait is over when the job it is for ends",
     "SELECT w.rowid FROM waits AS w LEFT JOIN jobs AS j ON j.id = w.on_job"
     " WHERE w.state = 'OPEN' AND w.on_job IS NOT NULL AND (j.id IS NULL OR j.state IN " TERMINAL
     ")"},
    {"a wait is over when the variant has its pairs or can't have them",
     "SELECT w.rowid FROM waits AS w JOIN variants AS v ON v.id = w.on_variant"
     " JOIN studies AS s ON s.id = v.study_id WHERE w.state = 'OPEN'"
     " AND (v.pairs_done >= w.pairs OR v.problem <> '' OR s.cancelled = 1)"},
    {"a met wait was for what has happened",
     "SELECT w.rowid FROM waits AS w LEFT JOIN all_jobs AS j ON j.id = w.on_job"
     " LEFT JOIN variants AS v ON v.id = w.on_variant WHERE w.state = 'MET'"
     " AND coalesce(j.state = 'SUCCEEDED', v.pairs_done >= w.pairs, 0) = 0"
     // Some of its pairs may have been taken back.
     " AND NOT EXISTS (SELECT 1 FROM repairs AS p WHERE p.variant_id = w.on_variant)"},
    {"a job that waited in vain was never leased",
     "SELECT j.id FROM jobs AS j WHERE j.attempts > 0 AND j.id IN (SELECT job_id FROM waits"
     " WHERE state <> 'MET')"},
    // ---- Expansion
    {"a scene's pairs are done, lost or asked for",
     "SELECT s.variant_id || '/' || s.ordinal FROM scenes AS s WHERE s.variant_id NOT IN " GOING
     " AND s.rigs - s.rigs_lost"
     " <> s.rigs_done + (SELECT coalesce(sum(CASE j.rig_count WHEN 0 THEN s.rigs"
     " ELSE j.rig_count END), 0) FROM jobs AS j WHERE j.variant_id = s.variant_id"
     " AND j.ordinal = s.ordinal AND j.kind IN " OF_SCENE " AND j.state NOT IN " TERMINAL ")"},
    {"a scene counts its open jobs",
     "SELECT s.variant_id || '/' || s.ordinal FROM scenes AS s WHERE s.jobs_open <>"
     " (SELECT count(*) FROM jobs AS j WHERE j.variant_id = s.variant_id"
     " AND j.ordinal = s.ordinal AND j.kind IN " OF_SCENE " AND j.state NOT IN " TERMINAL ")"},
    {"a scene counts its frames",
     "SELECT s.variant_id || '/' || s.ordinal FROM scenes AS s WHERE s.variant_id NOT IN " GOING
     " AND s.rigs_done <> (SELECT count(*) FROM frames AS f WHERE f.variant_id = s.variant_id"
     " AND f.ordinal = s.ordinal)"},
    {"a variant's scenes are its ordinals without gaps",
     "SELECT v.id FROM variants AS v WHERE v.id NOT IN " GOING
     " AND (v.next_ordinal <> (SELECT count(*) FROM scenes AS s WHERE s.variant_id = v.id)"
     " OR v.next_ordinal <> (SELECT coalesce(max(ordinal) + 1, 0) FROM scenes AS s"
     " WHERE s.variant_id = v.id))"},
    {"a frame belongs to a scene and its job",
     "SELECT cursor FROM frames AS f WHERE NOT EXISTS (SELECT 1 FROM scenes AS s"
     " WHERE s.variant_id = f.variant_id AND s.ordinal = f.ordinal AND f.rig < s.rigs)"},
    {"a published result was published by a job that ended with it",
     "SELECT hex(r.work_key) FROM results AS r LEFT JOIN jobs AS j ON j.id = r.job_id"
     " LEFT JOIN archived_jobs AS a ON a.id = r.job_id WHERE r.job_id IS NOT NULL"
     // Another study may use it after its maker's was forgotten.
     " AND (j.id IS NOT NULL OR a.id IS NOT NULL"
     " OR NOT EXISTS (SELECT 1 FROM studies WHERE forgotten > 0))"
     " AND (coalesce(j.state, a.state, '') NOT IN ('SUCCEEDED', 'REJECTED')"
     " OR coalesce(j.fence, a.fence) IS NOT r.fence)"},
    {"a frame's result is one",
     "SELECT f.cursor FROM frames AS f LEFT JOIN results AS r ON r.work_key = f.frame_key"
     " WHERE r.stage IS NOT 'frame'"},
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
    {"a folder is kept only while its work is wanted and not done",
     "SELECT k.path FROM kept_folders AS k WHERE k.variant_id IS NULL AND (EXISTS (SELECT 1"
     " FROM results AS r WHERE r.work_key = k.work_key) OR NOT EXISTS (SELECT 1 FROM jobs AS j"
     " JOIN studies AS s ON s.id = j.study_id WHERE j.work_key = k.work_key"
     " AND j.input <> x'' AND s.cancelled = 0 AND s.archived = 0))"},
    {"a scene's folder is kept only while one of its jobs is open",
     "SELECT k.path FROM kept_folders AS k WHERE k.variant_id IS NOT NULL AND NOT EXISTS ("
     "SELECT 1 FROM scenes AS s WHERE s.variant_id = k.variant_id AND s.ordinal = k.ordinal"
     " AND s.jobs_open > 0)"},
    {"a folder that is kept is not litter",
     "SELECT k.path FROM kept_folders AS k JOIN litter AS l ON l.path = k.path"},
    {"a study lists the results of its jobs that have files",
     "SELECT j.id FROM all_jobs AS j JOIN job_kinds AS k ON k.name = j.kind"
     " LEFT JOIN study_results AS r ON r.job_id = j.id WHERE k.of_scene = 0 AND k.has_output = 1"
     " AND j.variant_id NOT IN " GOING " AND ((j.state = 'SUCCEEDED'"
     " AND j.id NOT IN (SELECT job_id FROM taken_back)) <> (r.job_id IS NOT NULL)"
     " OR r.work_key <> j.work_key OR r.study_id <> j.study_id)"},
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
     " FROM archived_jobs GROUP BY variant_id, kind, state) WHERE variant_id NOT IN " GOING
     " GROUP BY "
     "variant_id, kind, state HAVING sum(n) <> 0"},
    {"pairs planned are right", "SELECT id FROM variants AS v WHERE v.id NOT IN " GOING
                                " AND pairs_planned <> (SELECT coalesce(sum(rigs - "
                                "rigs_lost), 0)"
                                " FROM scenes AS s WHERE s.variant_id = v.id)"},
    {"pairs done are right", "SELECT id FROM variants AS v WHERE v.id NOT IN " GOING
                             " AND pairs_done <> (SELECT count(*) FROM frames AS f"
                             " WHERE f.variant_id = v.id)"},
    {"open scenes are counted right", "SELECT id FROM variants AS v WHERE v.id NOT IN " GOING
                                      " AND scenes_open <> (SELECT count(*) FROM scenes AS s"
                                      " WHERE s.variant_id = v.id AND s.jobs_open > 0)"},
    {"reuse is counted right",
     "SELECT id FROM variants AS v WHERE v.id NOT IN " GOING
     " AND (frames_reused <> (SELECT count(*) FROM frames AS f"
     " WHERE f.variant_id = v.id AND f.reused = 1) OR layouts_reused <>"
     " (SELECT count(*) FROM jobs AS j WHERE j.variant_id = v.id AND " WITH_PART ")"
     " + (SELECT count(*) FROM archived_jobs AS j WHERE j.variant_id = v.id AND " WITH_PART "))"},
    // ---- Forgotten studies
    {"only finished studies are forgotten",
     "SELECT id FROM studies WHERE forgotten > 0 AND (finished_unix_s IS NULL OR archived = 0)"},
    {"nothing is left of a forgotten study that is gone",
     "SELECT s.id FROM studies AS s JOIN variants AS v ON v.study_id = s.id"
     " WHERE s.forgotten = 2"},
    {"rejections are counted right",
     "SELECT id FROM variants AS v WHERE v.id NOT IN " GOING
     " AND scenes_rejected <> (SELECT count(*) FROM jobs AS j"
     " WHERE j.variant_id = v.id AND j.state = 'REJECTED' AND j.kind IN " OF_SCENE ")"
     " + (SELECT count(*) FROM archived_jobs AS j WHERE j.variant_id = v.id"
     " AND j.state = 'REJECTED' AND j.kind IN " OF_SCENE ")"},
    {"lost jobs outside of scenes are counted right",
     "SELECT id FROM variants AS v WHERE v.id NOT IN " GOING
     " AND others_lost <> (SELECT count(*) FROM jobs AS j"
     " WHERE j.variant_id = v.id AND " LOST_OTHER " AND NOT EXISTS (SELECT 1 FROM jobs AS n"
     " WHERE n.variant_id = j.variant_id AND n.ordinal = j.ordinal AND n.kind = j.kind"
     " AND n.generation > j.generation)) + (SELECT count(*) FROM archived_jobs AS j"
     " WHERE j.variant_id = v.id AND " LOST_OTHER " AND NOT EXISTS (SELECT 1 FROM all_jobs AS n"
     " WHERE n.variant_id = j.variant_id AND n.ordinal = j.ordinal AND n.kind = j.kind"
     " AND n.generation > j.generation))"},
};

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

// SQLite tells a page that the disk did not give as it tells damage, by the number of the error.
bool TellsOfADiskThatErrs(std::string_view finding) {
  constexpr std::string_view kCode = "error code=";
  for (size_t at = 0; (at = finding.find(kCode, at)) != std::string_view::npos;) {
    at += kCode.size();
    int code = 0;
    std::from_chars(finding.data() + at, finding.data() + finding.size(), code);
    if ((code & 0xff) == SQLITE_IOERR && code != SQLITE_IOERR_DATA) return true;
  }
  return false;
}

constexpr char kCheckPages[] = "PRAGMA integrity_check(10)";

absl::Status DiskErrs() { return Unavailable("database: disk I/O error (in: {})", kCheckPages); }

absl::Status CheckPages(SqliteConnection& db, Violations& out) {
  SqliteQuery integrity(db, kCheckPages);
  while (integrity.Next()) {
    const std::string_view finding = integrity.Text(0);
    if (TellsOfADiskThatErrs(finding)) return DiskErrs();
    if (finding != "ok") out.push_back("integrity: " + std::string(finding));
  }
  return integrity.status();
}

absl::Status CheckFile(SqliteConnection& db, Violations& out) {
  Violations found, again;
  RETURN_IF_ERROR(CheckPages(db, found));
  // Why SQLite could not get a page of the free list, it does not say: damage is still there at a
  // second look.
  if (std::any_of(found.begin(), found.end(), [](const std::string& finding) {
        return finding.find("failed to get page") != std::string::npos;
      })) {
    RETURN_IF_ERROR(CheckPages(db, again));
    if (again != found) return DiskErrs();
  }
  out.insert(out.end(), found.begin(), found.end());
  SqliteQuery keys(db, "PRAGMA foreign_key_check");
  while (keys.Next()) {
    out.push_back(fmt::format("foreign key: table {} row {}", keys.Text(0), keys.Int(1)));
  }
  return keys.status();
}

// Every rig of a job that succeeded is a frame; nothing else is.
absl::Status CheckRigs(SqliteConnection& db, Violations& out) {
  SqliteQuery jobs(db,
                   "SELECT id, variant_id, ordinal, rigs, rig_count FROM all_jobs"
                   " WHERE rig_count > 0 AND state = 'SUCCEEDED'"
                   " AND variant_id NOT IN " GOING);
  while (jobs.Next()) {
    const auto rigs = ParseRigs(jobs.Text(3));
    bool all = rigs.ok() && static_cast<int64_t>(rigs->size()) == jobs.Int(4);
    for (size_t i = 0; all && i < rigs->size(); ++i) {
      ASSIGN_OR_RETURN(all, db.Has("SELECT 1 FROM frames WHERE variant_id = ?1 AND ordinal = ?2"
                                   " AND rig = ?3 UNION ALL SELECT 1 FROM repairs"
                                   " WHERE variant_id = ?1 AND ordinal = ?2 AND rig = ?3",
                                   jobs.Int(1), jobs.Int(2), (*rigs)[i]));
    }
    if (!all) out.push_back(fmt::format("a job has all its frames: not {}", jobs.Int(0)));
  }
  return jobs.status();
}

}  // namespace

std::span<const JobKind::Invariant> SqlInvariants() { return kInvariants; }

absl::StatusOr<std::vector<std::string>> AuditDatabase(SqliteConnection& db,
                                                       const KindRegistry& kinds) {
  Violations out;
  RETURN_IF_ERROR(CheckFile(db, out));
  for (const JobKind::Invariant& invariant : kInvariants) {
    RETURN_IF_ERROR(Collect(db, invariant.name, invariant.sql, out));
  }
  RETURN_IF_ERROR(CheckRigs(db, out));
  for (size_t i = 0; i < kinds.size(); ++i) {
    for (const JobKind::Invariant& invariant : kinds.at(i).Invariants()) {
      RETURN_IF_ERROR(Collect(db, invariant.name, invariant.sql, out));
    }
    RETURN_IF_ERROR(kinds.at(i).Audit(db, out));
  }
  return out;
}

}  // namespace parallax
