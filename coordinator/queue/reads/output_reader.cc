// Reads outputs for clients and workers: frames, results, scenes, and the messages of leases.
#include <fmt/core.h>

#include <set>

#include "common/base/status.h"
#include "common/config/content_folders.h"
#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/reads/reader_rows.h"
#include "coordinator/queue/reads/readers.h"

namespace parallax {
namespace {

// "ab/ab12.../.attempt-7" of "ab/ab12.../.attempt-7/003", which must be rig 3's; empty if it is
// not.
std::string FolderOfRig(const std::string& path, uint32_t rig) {
  const std::string name = fmt::format("/{:03}", rig);
  if (path.size() <= name.size() || !path.ends_with(name)) return "";
  return path.substr(0, path.size() - name.size());
}

// Frames of one attempt share its folder, so that only the first of them is unpacked.
absl::StatusOr<std::vector<v1::FrameFolder>> FoldersIn(SqliteConnection& db, int64_t variant,
                                                       int64_t limit) {
  std::vector<v1::FrameFolder> folders;
  SqliteQuery query(db,
                    "SELECT f.ordinal, f.rig, r.fence, r.bytes FROM frames AS f"
                    " JOIN results AS r ON r.work_key = f.frame_key WHERE f.variant_id = ?1"
                    " ORDER BY f.ordinal, f.rig LIMIT ?2",
                    variant, limit);
  std::pair<int64_t, int64_t> last = {-1, -1};
  while (query.Next()) {
    const uint32_t rig = static_cast<uint32_t>(query.Int(1));
    const std::pair<int64_t, int64_t> attempt = {query.Int(0), query.Int(2)};
    if (query.IsNull(2) || attempt != last) {
      v1::FrameResult frame;
      RETURN_IF_ERROR(UnpackMessage(query.Blob(3), frame));
      const std::string folder = FolderOfRig(frame.path(), rig);
      if (folder.empty()) {
        return DataLoss("database: rig {} of scene {} is in '{}'", rig, attempt.first,
                        frame.path());
      }
      folders.emplace_back().set_folder(folder);
      folders.back().set_scene(static_cast<uint32_t>(attempt.first));
      last = attempt;
    }
    folders.back().add_rigs(rig);
  }
  RETURN_IF_ERROR(query.status());
  return folders;
}

class CommittedResults final : public ResultReader {
 public:
  explicit CommittedResults(Readers& readers) : readers_(readers) {}

  absl::StatusOr<std::string> ResultBytes(const Sha256Digest& key) override {
    return readers_.Get(0, [&](SqliteConnection& db) -> absl::StatusOr<std::string> {
      SqliteQuery query(db, "SELECT bytes FROM results WHERE work_key = ?1", key);
      RETURN_IF_ERROR(FirstRow(query, "result " + HexOf(key)));
      return std::string(query.Blob(0));
    });
  }

  absl::StatusOr<std::vector<Sha256Digest>> FramesOf(int64_t variant, int64_t limit) override {
    return readers_.Get(0, [&](SqliteConnection& db) {
      SqliteQuery query(db,
                        "SELECT frame_key FROM frames WHERE variant_id = ?1"
                        " ORDER BY ordinal, rig LIMIT ?2",
                        variant, limit);
      return query.Rows([&] { return query.Digest(0); });
    });
  }

  absl::StatusOr<std::vector<v1::FrameFolder>> FoldersOf(int64_t variant, int64_t limit) override {
    return readers_.Get(0, [&](SqliteConnection& db) { return FoldersIn(db, variant, limit); });
  }

  absl::StatusOr<std::string> ResultWaitedFor(int64_t job) override {
    return readers_.Get(0, [&](SqliteConnection& db) -> absl::StatusOr<std::string> {
      ASSIGN_OR_RETURN(const auto awaited,
                       db.Integer("SELECT on_job FROM waits WHERE job_id = ?1 AND state = 'MET'"
                                  " AND on_job IS NOT NULL",
                                  job));
      // If it was damaged, a later generation has made it again, after an upgrade under another
      // key.
      SqliteQuery query(db,
                        "SELECT r.bytes, n.generation FROM all_jobs AS j JOIN all_jobs AS n"
                        " ON n.variant_id = j.variant_id AND n.ordinal = j.ordinal"
                        " AND n.kind = j.kind AND n.rigs = j.rigs"
                        " JOIN results AS r ON r.work_key = n.work_key"
                        " WHERE j.id = ?1 AND r.bytes IS NOT NULL"
                        " ORDER BY n.generation DESC LIMIT 1",
                        awaited.value_or(0));
      RETURN_IF_ERROR(FirstRow(query, fmt::format("result that job {} waited for", job)));
      return std::string(query.Blob(0));
    });
  }

 private:
  Readers& readers_;
};

}  // namespace

absl::StatusOr<std::vector<v1::PublishedFrame>> Readers::ListFrames(
    const v1::ListFramesRequest& request) {
  std::vector<v1::PublishedFrame> frames;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT f.cursor, v.name, f.ordinal, f.reused, r.bytes FROM frames AS f"
                      " JOIN variants AS v ON v.id = f.variant_id"
                      " JOIN results AS r ON r.work_key = f.frame_key"
                      " WHERE f.study_id = ?1 AND f.cursor > ?2 ORDER BY f.cursor LIMIT ?3",
                      request.study_id(), request.cursor(), RowLimit(request.limit(), 1000));
    while (query.Next()) {
      v1::PublishedFrame& frame = frames.emplace_back();
      frame.set_cursor(query.Int(0));
      frame.set_variant(std::string(query.Text(1)));
      frame.set_scene(static_cast<uint32_t>(query.Int(2)));
      frame.set_reused(query.Int(3) != 0);
      RETURN_IF_ERROR(UnpackMessage(query.Blob(4), *frame.mutable_frame()));
    }
    return query.status();
  }));
  return frames;
}

absl::StatusOr<std::vector<v1::JobResult>> Readers::ListResults(
    const v1::ListResultsRequest& request) {
  std::vector<v1::JobResult> results;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) -> absl::Status {
    SqliteQuery query(db,
                      "SELECT s.cursor, s.job_id, coalesce(j.kind, a.kind), v.name,"
                      " coalesce(j.input, a.input), r.bytes FROM study_results AS s"
                      " LEFT JOIN jobs AS j ON j.id = s.job_id"
                      " LEFT JOIN archived_jobs AS a ON a.id = s.job_id"
                      " JOIN variants AS v ON v.id = coalesce(j.variant_id, a.variant_id)"
                      " JOIN results AS r ON r.work_key = s.work_key"
                      " WHERE s.study_id = ?1 AND s.cursor > ?2 ORDER BY s.cursor LIMIT ?3",
                      request.study_id(), request.cursor(), RowLimit(request.limit(), 1000));
    while (query.Next()) {
      ASSIGN_OR_RETURN(const KindId kind, kinds_.IdOf(query.Text(2)));
      v1::JobResult& result = results.emplace_back();
      result.set_cursor(query.Int(0));
      result.set_job_id(query.Int(1));
      result.set_kind(std::string(query.Text(2)));
      result.set_variant(std::string(query.Text(3)));
      result.set_label(kinds_[kind].LabelOf(query.Blob(4)));
      auto folder = kinds_[kind].FolderOf(query.Blob(5));
      if (!folder) {
        return DataLoss("database: the result of job {} has no files", query.Int(1));
      }
      result.set_path(folder->path);
      *result.mutable_files() = std::move(folder->files);
    }
    return query.status();
  }));
  return results;
}

absl::StatusOr<std::vector<std::string>> Readers::ListLitter(double before_unix_s, int limit) {
  return Get(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT path FROM litter WHERE since_unix_s <= ?1"
                      " ORDER BY since_unix_s LIMIT ?2",
                      before_unix_s, RowLimit(limit, 1000));
    return query.Rows([&] { return std::string(query.Text(0)); });
  });
}

absl::StatusOr<std::vector<std::string>> Readers::ListContentFolders() {
  std::set<std::string> folders;
  RETURN_IF_ERROR(Read(0, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT v.config_z FROM variants AS v JOIN studies AS s"
                      " ON s.id = v.study_id WHERE s.forgotten = 0");
    v1::SceneConfig config;
    while (query.Next()) {
      RETURN_IF_ERROR(UnpackMessage(query.Blob(0), config));
      for (const std::string* folder : ContentFoldersOf(config)) folders.insert(*folder);
    }
    RETURN_IF_ERROR(query.status());
    SqliteQuery studies(db, "SELECT spec_z FROM studies WHERE forgotten = 0");
    v1::StudySpec study;
    while (studies.Next()) {
      RETURN_IF_ERROR(UnpackMessage(studies.Blob(0), study));
      for (const auto& own : study.evaluate().own_benchmarks())
        folders.insert(PathOfBenchmark(own));
    }
    return studies.status();
  }));
  return std::vector<std::string>(folders.begin(), folders.end());
}

absl::StatusOr<v1::Scene> Readers::GetScene(const v1::GetSceneRequest& request) {
  v1::Scene scene;
  RETURN_IF_ERROR(Read(deadline_s_, [&](SqliteConnection& db) {
    SqliteQuery query(db,
                      "SELECT r.bytes FROM variants AS v"
                      " JOIN scenes AS s ON s.variant_id = v.id AND s.ordinal = ?3"
                      " JOIN results AS r ON r.work_key = s.scene_hash"
                      " WHERE v.study_id = ?1 AND v.name = ?2",
                      request.study_id(), request.variant(), request.scene());
    RETURN_IF_ERROR(
        FirstRow(query, fmt::format("solved scene {} of variant '{}' of study {}", request.scene(),
                                    request.variant(), request.study_id())));
    return UnpackMessage(query.Blob(0), scene);
  }));
  return scene;
}

absl::StatusOr<v1::Lease> Readers::LeaseMessage(const GrantedLease& lease) {
  v1::Lease message;
  message.mutable_attempt()->set_job_id(lease.work.job.id);
  message.mutable_attempt()->set_fence(lease.fence);
  message.set_attempt_number(lease.attempt_number);
  message.set_study(lease.study);
  message.set_variant(lease.variant);
  message.set_scene(lease.work.job.ordinal);
  const JobKind& kind = kinds_[lease.work.job.kind];
  message.set_kind(kind.name());
  message.set_label(kind.LabelOf(lease.work.job.input));
  if (kind.traits().has_output) message.set_store_prefix(StorePrefixOf(lease.work.job.work_key));
  CommittedResults results(*this);
  ASSIGN_OR_RETURN(*message.mutable_spec(), kind.Spec(lease.work, results));
  return message;
}

}  // namespace parallax
