#include "coordinator/queue/database/startup.h"

#include <fmt/core.h>

#include <algorithm>

#include "common/base/hash.h"
#include "common/base/version.h"

namespace parallax {
namespace {

constexpr size_t kMostLimitsText = 2000;
constexpr double kEpochZeroUnixS = 1577836800;  // 2020-01-01

// The table of epochs keeps a program as its version and those of its stages: "0.3.0: layout 27,
// scene 27,".
std::string WordOf(const std::string& stage, const StageVersions& versions) {
  return " " + stage + " " + VersionOf(versions, stage) + ",";
}
std::string ProgramText(const StageVersions& versions) {
  std::string text = std::string(kProgramVersion) + ":";
  for (const auto& [stage, version] : ListVersions(versions)) text += WordOf(stage, versions);
  return text;
}

}  // namespace

absl::StatusOr<uint64_t> RaiseEpoch(SqliteConnection& db, double now_unix_s,
                                    const StageVersions& versions, bool keep_epoch) {
  ASSIGN_OR_RETURN(const auto last, db.Integer("SELECT max(epoch) FROM epochs"));
  if (keep_epoch && last) return static_cast<uint64_t>(*last);
  RETURN_IF_ERROR(db.Run("BEGIN IMMEDIATE"));
  const int64_t by_clock = std::clamp<int64_t>(static_cast<int64_t>(now_unix_s - kEpochZeroUnixS),
                                               1, (int64_t{1} << 31) - 1);
  const int64_t epoch = std::max(last.value_or(0) + 1, by_clock);
  RETURN_IF_ERROR(db.Run("INSERT INTO epochs(epoch, started_unix_s, program) VALUES (?1, ?2, ?3)",
                         epoch, now_unix_s, ProgramText(versions)));
  RETURN_IF_ERROR(db.Run("COMMIT"));
  return static_cast<uint64_t>(epoch);
}

absl::StatusOr<std::vector<int64_t>> LeasesOfOtherVersions(SqliteConnection& db,
                                                           const StageVersions& versions,
                                                           const KindRegistry& kinds) {
  std::vector<int64_t> others;
  SqliteQuery leased(db,
                     "SELECT j.id, j.kind, e.program FROM jobs AS j"
                     " JOIN epochs AS e ON e.epoch = j.fence >> 32 WHERE j.state = 'LEASED'");
  while (leased.Next()) {
    // Releases up to 0.2 kept no versions of stages: their leases go on.
    if (leased.Text(2).find(':') == std::string_view::npos) continue;
    ASSIGN_OR_RETURN(const KindId kind, kinds.IdOf(leased.Text(1)));
    const std::vector<std::string>& stages = kinds[kind].traits().stages;
    if (std::any_of(stages.begin(), stages.end(), [&](const std::string& stage) {
          return leased.Text(2).find(WordOf(stage, versions)) == std::string_view::npos;
        })) {
      others.push_back(leased.Int(0));
    }
  }
  RETURN_IF_ERROR(leased.status());
  return others;
}

absl::Status NoteUnheard(SqliteConnection& db, double now_unix_s) {
  RETURN_IF_ERROR(db.Run("BEGIN IMMEDIATE"));
  RETURN_IF_ERROR(
      db.Run("DELETE FROM unheard_workers WHERE worker NOT IN"
             " (SELECT worker FROM jobs WHERE state = 'LEASED')"));
  RETURN_IF_ERROR(
      db.Run("INSERT OR IGNORE INTO unheard_workers"
             " SELECT DISTINCT worker, ?1 FROM jobs WHERE state = 'LEASED'",
             now_unix_s));
  // The clock was set back.
  RETURN_IF_ERROR(
      db.Run("UPDATE unheard_workers SET since_unix_s = ?1 WHERE since_unix_s > ?1", now_unix_s));
  return db.Run("COMMIT");
}

absl::Status EnterKinds(SqliteConnection& db, const KindRegistry& kinds) {
  {
    SqliteQuery used(db, "SELECT DISTINCT kind FROM job_counts");
    while (used.Next()) {
      if (kinds.Find(used.Text(0))) continue;
      return FailedPrecondition(
          "it has jobs of kind '{}', which this program does not know; use the one that made them",
          used.Text(0));
    }
    RETURN_IF_ERROR(used.status());
  }
  RETURN_IF_ERROR(db.Run("BEGIN IMMEDIATE"));
  for (size_t i = 0; i < kinds.size(); ++i) {
    const JobTraits& t = kinds.at(i).traits();
    RETURN_IF_ERROR(db.Run(
        "INSERT INTO job_kinds(name, of_scene, may_reject, has_output, can_split,"
        " shares_part, resumes) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7) ON CONFLICT DO UPDATE SET"
        " of_scene = ?2, may_reject = ?3, has_output = ?4, can_split = ?5, shares_part = ?6,"
        " resumes = ?7",
        kinds.at(i).name(), t.of_scene, t.may_reject, t.has_output, t.can_split, t.shares_part,
        t.resumes));
  }
  return db.Run("COMMIT");
}

absl::Status AuditLimits(SqliteConnection& db, const LimitRules& limits, double now_unix_s) {
  std::string text = limits.Describe();
  if (text.size() > kMostLimitsText) {
    text = text.substr(0, kMostLimitsText) + "... (SHA-256 of all " + Sha256Hex(text) + ")";
  }
  std::string before = LimitRules().Describe();
  {
    SqliteQuery last(db,
                     "SELECT detail FROM audit WHERE action = 'limits' ORDER BY id DESC LIMIT 1");
    if (last.Next()) before = std::string(last.Text(0));
    RETURN_IF_ERROR(last.status());
  }
  if (before == text) return absl::OkStatus();
  return db.Run("INSERT INTO audit(unix_s, actor, action, detail) VALUES (?1, ?2, ?3, ?4)",
                now_unix_s, "coordinator", "limits", text);
}

absl::StatusOr<std::string> DatabaseId(SqliteConnection& db) {
  SqliteQuery first(db, "SELECT epoch, started_unix_s FROM epochs ORDER BY epoch LIMIT 1");
  if (!first.Next()) return DataLoss("no epoch");
  const std::string start = fmt::format("{} {:f}", first.Int(0), first.Real(1));
  return Sha256Hex(start).substr(0, 16);
}

}  // namespace parallax
