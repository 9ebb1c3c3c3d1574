#include "coordinator/queue/reads/output_files.h"

#include <fmt/core.h>

#include "coordinator/study/keys.h"

namespace parallax {
namespace {

constexpr int kSampledResults = 8;

// "ab/ab12.../.attempt-7" of a path in it; empty without.
std::string AttemptOf(const std::string& path) {
  const size_t at = path.find("/.attempt-");
  return at == std::string::npos ? "" : path.substr(0, path.find('/', at + 1));
}

}  // namespace

absl::StatusOr<std::vector<StoredOutput>> StoredOutputsIn(SqliteConnection& db,
                                                          const KindRegistry& kinds,
                                                          const std::string& after, int limit) {
  std::vector<StoredOutput> outputs;
  SqliteQuery query(db,
                    "SELECT work_key, stage, bytes FROM results WHERE work_key > ?1"
                    " AND bytes IS NOT NULL ORDER BY work_key",
                    SqlBlob{after});
  while (static_cast<int>(outputs.size()) < limit && query.Next()) {
    StoredOutput output{query.Digest(0), "", kinds.StoredFiles(query.Text(1), query.Blob(2))};
    output.folder = CommonFolder(output.files);
    if (!output.folder.empty()) outputs.push_back(std::move(output));
  }
  RETURN_IF_ERROR(query.status());
  return outputs;
}

absl::StatusOr<std::set<std::string>> AttemptFoldersIn(SqliteConnection& db,
                                                       const KindRegistry& kinds) {
  std::set<std::string> folders;
  SqliteQuery results(db, "SELECT stage, bytes FROM results WHERE bytes IS NOT NULL");
  while (results.Next()) {
    for (const auto& file : kinds.StoredFiles(results.Text(0), results.Blob(1))) {
      folders.insert(AttemptOf(file.path));
    }
  }
  RETURN_IF_ERROR(results.status());
  SqliteQuery left(db, "SELECT path FROM litter UNION ALL SELECT path FROM kept_folders");
  while (left.Next()) folders.insert(AttemptOf(std::string(left.Text(0))));
  RETURN_IF_ERROR(left.status());
  SqliteQuery leased(db, "SELECT work_key, fence FROM jobs WHERE state = 'LEASED'");
  while (leased.Next()) {
    folders.insert(fmt::format("{}/.attempt-{}", StorePrefixOf(leased.Digest(0)),
                               static_cast<uint64_t>(leased.Int(1))));
  }
  RETURN_IF_ERROR(leased.status());
  return folders;
}

absl::StatusOr<std::vector<std::string>> UsesOfIn(SqliteConnection& db, const Sha256Digest& key) {
  SqliteQuery pairs(db,
                    "SELECT s.id, s.name, v.name, f.ordinal, f.rig FROM frames AS f"
                    " JOIN studies AS s ON s.id = f.study_id JOIN variants AS v"
                    " ON v.id = f.variant_id WHERE f.frame_key = ?1 AND s.forgotten = 0",
                    key);
  ASSIGN_OR_RETURN(std::vector<std::string> uses, pairs.Rows([&] {
    return fmt::format("study {} ({}), variant {}, scene {}, rig {}", pairs.Int(0), pairs.Text(1),
                       pairs.Text(2), pairs.Int(3), pairs.Int(4));
  }));
  SqliteQuery results(db,
                      "SELECT s.id, s.name, j.kind, j.id FROM study_results AS r JOIN studies AS s"
                      " ON s.id = r.study_id JOIN all_jobs AS j ON j.id = r.job_id"
                      " WHERE r.work_key = ?1 AND s.forgotten = 0",
                      key);
  while (results.Next()) {
    uses.push_back(fmt::format("study {} ({}), {} job {}", results.Int(0), results.Text(1),
                               results.Text(2), results.Int(3)));
  }
  RETURN_IF_ERROR(results.status());
  return uses;
}

absl::StatusOr<std::optional<ScrubState>> ScrubIn(SqliteConnection& db) {
  std::optional<ScrubState> scrub;
  SqliteQuery query(
      db, "SELECT position, began_unix_s, ended_unix_s, files, bytes, damaged FROM scrub");
  if (query.Next()) {
    scrub = ScrubState{.position = std::string(query.Blob(0)),
                       .began_unix_s = query.Real(1),
                       .files = query.Int(3),
                       .bytes = query.Int(4),
                       .damaged = query.Int(5)};
    if (!query.IsNull(2)) scrub->ended_unix_s = query.Real(2);
  }
  RETURN_IF_ERROR(query.status());
  return scrub;
}

absl::StatusOr<KnownStore> ReadKnownStore(SqliteConnection& db, const KindRegistry& kinds) {
  KnownStore known;
  SqliteQuery id(db, "SELECT store_id FROM store");
  if (id.Next()) known.id = std::string(id.Text(0));
  RETURN_IF_ERROR(id.status());
  SqliteQuery newest(db,
                     "SELECT r.stage, r.bytes FROM frames AS f JOIN results AS r"
                     " ON r.work_key = f.frame_key ORDER BY f.cursor DESC LIMIT ?1",
                     kSampledResults);
  while (newest.Next()) {
    for (auto& file : kinds.StoredFiles(newest.Text(0), newest.Blob(1))) {
      known.sample.push_back(std::move(file));
    }
  }
  RETURN_IF_ERROR(newest.status());
  return known;
}

absl::Status EnterStore(SqliteConnection& db, const std::string& before, const std::string& id,
                        double now_unix_s) {
  RETURN_IF_ERROR(db.Run("BEGIN IMMEDIATE"));
  RETURN_IF_ERROR(
      db.Run("INSERT INTO store(one, store_id, since_unix_s) VALUES (1, ?1, ?2)"
             " ON CONFLICT DO UPDATE SET store_id = ?1, since_unix_s = ?2",
             id, now_unix_s));
  if (!before.empty()) {
    RETURN_IF_ERROR(
        db.Run("INSERT INTO audit(unix_s, actor, action, detail) VALUES (?1, ?2, ?3, ?4)",
               now_unix_s, "coordinator", "store", before + " is replaced by " + id));
  }
  return db.Run("COMMIT");
}

}  // namespace parallax
