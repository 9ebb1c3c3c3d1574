#include "coordinator/queue/tables/left_folders.h"

namespace parallax {

absl::Status LeftFolders::InsertLitter(const std::string& path, double now) {
  return db_.Run("INSERT INTO litter(path, since_unix_s) VALUES (?1, ?2) ON CONFLICT DO NOTHING",
                 path, now);
}

absl::Status LeftFolders::DeleteLitter(const std::vector<std::string>& paths) {
  for (const std::string& path : paths) {
    RETURN_IF_ERROR(db_.Run("DELETE FROM litter WHERE path = ?1", path));
  }
  return absl::OkStatus();
}

absl::Status LeftFolders::Keep(const std::string& path, const Sha256Digest& keep_key,
                               const std::optional<KeptFor>& scene, double now) {
  return db_.Run(
      "INSERT INTO kept_folders(path, work_key, since_unix_s, variant_id, ordinal)"
      " VALUES (?1, ?2, ?3, ?4, ?5) ON CONFLICT DO NOTHING",
      path, keep_key, now, scene ? std::optional<int64_t>(scene->variant) : std::nullopt,
      scene ? std::optional<int64_t>(scene->ordinal) : std::nullopt);
}

absl::StatusOr<std::vector<std::string>> LeftFolders::Kept(const Sha256Digest& keep_key,
                                                           int limit) {
  SqliteQuery query(db_,
                    "SELECT path FROM kept_folders WHERE work_key = ?1"
                    " ORDER BY since_unix_s DESC, path DESC LIMIT ?2",
                    keep_key, limit);
  return query.Rows([&] { return std::string(query.Text(0)); });
}

absl::StatusOr<bool> LeftFolders::IsKept(const std::string& path) {
  return db_.Has("SELECT 1 FROM kept_folders WHERE path = ?1", path);
}

absl::Status LeftFolders::SweepDone(const Sha256Digest& work_key, double now) {
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO litter(path, since_unix_s) SELECT path, ?2 FROM kept_folders"
              " WHERE work_key = ?1 ON CONFLICT DO NOTHING",
              work_key, now));
  return db_.Run("DELETE FROM kept_folders WHERE work_key = ?1", work_key);
}

absl::Status LeftFolders::SweepScene(const KeptFor& scene, double now) {
  ASSIGN_OR_RETURN(
      const bool any,
      db_.Has("SELECT 1 FROM kept_folders WHERE variant_id = ?1 AND ordinal = ?2 LIMIT 1",
              scene.variant, scene.ordinal));
  if (!any) return absl::OkStatus();
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO litter(path, since_unix_s) SELECT path, ?3 FROM kept_folders"
              " WHERE variant_id = ?1 AND ordinal = ?2 ON CONFLICT DO NOTHING",
              scene.variant, scene.ordinal, now));
  return db_.Run("DELETE FROM kept_folders WHERE variant_id = ?1 AND ordinal = ?2", scene.variant,
                 scene.ordinal);
}

absl::Status LeftFolders::SweepUnwanted(double now) {
#define PARALLAX_UNWANTED                                                            \
  "variant_id IS NULL AND"                                                           \
  " NOT EXISTS (SELECT 1 FROM jobs AS j JOIN studies AS s ON s.id = j.study_id"      \
  " WHERE j.work_key = kept_folders.work_key AND j.input <> x'' AND s.cancelled = 0" \
  " AND s.archived = 0)"
  RETURN_IF_ERROR(
      db_.Run("INSERT INTO litter(path, since_unix_s) SELECT path, ?1 FROM kept_folders"
              " WHERE " PARALLAX_UNWANTED " ON CONFLICT DO NOTHING",
              now));
  return db_.Run("DELETE FROM kept_folders WHERE " PARALLAX_UNWANTED);
#undef PARALLAX_UNWANTED
}

}  // namespace parallax
