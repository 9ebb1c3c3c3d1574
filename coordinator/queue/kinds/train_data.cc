#include "coordinator/queue/kinds/train_data.h"

#include <fmt/core.h>

#include <set>

#include "common/base/ability_tags.h"
#include "common/base/status.h"
#include "common/config/frame_files.h"
#include "coordinator/queue/commands/report_check.h"
#include "coordinator/queue/database/sqlite.h"

namespace parallax {
namespace {

constexpr int kMostFiles = 10'000;

// Returns no bytes without a sensor, so that keys of such sets stay as they were.
std::string SensorBytes(const v1::FrameSet& set) {
  if (!set.has_sensor()) return "";
  return std::string("\nsensor ") + kSensorVersion + "\n" + DeterministicBytes(set.sensor());
}

// Returns no bytes for the truth of first surfaces, for the same reason.
std::string TruthBytes(const v1::FrameSet& set) {
  return set.truth().empty() ? "" : "\ntruth " + set.truth();
}

}  // namespace

void TakeTruth(const std::string& truth, v1::FrameSet* set) {
  if (truth == "behind") set->set_truth(truth);
}

void TakeFinish(const v1::SceneConfig& config, v1::FrameSet* set) {
  *set->mutable_filters() = config.filters();
  const std::string& preset = config.sensor().preset();
  if (!preset.empty() && preset != "off") *set->mutable_sensor() = config.sensor();
}

DataPart DataPartOf(const VariantFacts& variant, const v1::FrameSet& set) {
  return {.config = *variant.digests,
          .seed = variant.seed,
          .pairs = variant.pairs_wanted,
          .rigs_per_scene = variant.rigs_per_scene,
          .weight = set.weight(),
          .filters = DeterministicBytes(set.filters()) + SensorBytes(set) + TruthBytes(set)};
}

absl::StatusOr<v1::TrainResult> TrainingWaitedFor(int64_t job, ResultReader& results) {
  ASSIGN_OR_RETURN(const std::string bytes, results.ResultWaitedFor(job));
  v1::TrainResult training;
  RETURN_IF_ERROR(UnpackMessage(bytes, training));
  if (!training.checkpoints().empty()) return training;
  return DataLoss("database: a training without checkpoints");
}

StoredCheckpoint StoredCheckpointOf(const v1::TrainResult& training,
                                    const v1::TrainedCheckpoint& checkpoint) {
  StoredCheckpoint stored{training.path() + "/" + checkpoint.name(), {}};
  for (const v1::FileEntry& file : training.files()) {
    if (file.name() == checkpoint.name()) stored.file = file;
  }
  return stored;
}

absl::Status AddFolders(int64_t variant, int64_t pairs, ResultReader& results, v1::FrameSet* set) {
  ASSIGN_OR_RETURN(const std::vector<v1::FrameFolder> folders, results.FoldersOf(variant, pairs));
  int64_t found = 0;
  for (const v1::FrameFolder& folder : folders) {
    found += folder.rigs_size();
    *set->add_folders() = folder;
  }
  if (found == pairs) return absl::OkStatus();
  return DataLoss("database: variant {} has {} pairs of {}", set->variant(), found, pairs);
}

WorkNeeds NeedsOf(const v1::JobNeeds& needs) {
  WorkNeeds out{.memory_mb = needs.memory_mb(), .tags = {needs.tags().begin(), needs.tags().end()}};
  if (needs.gpus() > 0) out.tags.push_back(kGpuTag);
  return out;
}

std::string WhyBadFiles(const std::string& path,
                        const google::protobuf::RepeatedPtrField<v1::FileEntry>& files) {
  if (!IsConfinedPath(path)) return "path '" + OneLine(path) + "' leaves the store";
  if (files.empty()) return "no files";
  if (files.size() > kMostFiles) {
    return fmt::format("{} files, allowed are at most {}", files.size(), kMostFiles);
  }
  std::set<std::string> names;
  for (const v1::FileEntry& file : files) {
    const std::string name = OneLine(file.name());
    if (!IsConfinedPath(file.name())) return "file name '" + name + "' leaves its folder";
    if (!names.insert(file.name()).second) return "file " + name + " is named twice";
    if (file.size() < 0) return name + " has a negative size";
    if (!IsSha256Hex(file.sha256())) return name + " has no SHA-256 of 64 lower-case hex digits";
  }
  return "";
}

std::vector<JobKind::OutputFile> OutputFilesOf(
    const std::string& path, const google::protobuf::RepeatedPtrField<v1::FileEntry>& files) {
  std::vector<JobKind::OutputFile> out;
  for (const v1::FileEntry& file : files)
    out.push_back({path + "/" + file.name(), file.size(), file.sha256()});
  return out;
}

absl::Status AuditFolders(SqliteConnection& db, const JobKind& kind,
                          std::vector<std::string>& violations) {
  SqliteQuery results(db,
                      "SELECT r.work_key, r.bytes, r.fence FROM results AS r WHERE r.stage = ?1"
                      " AND r.bytes IS NOT NULL",
                      kind.name());
  while (results.Next()) {
    const std::string name = HexOf(results.Digest(0));
    const auto stored = kind.FolderOf(results.Blob(1));
    const std::string folder = fmt::format("{}/.attempt-{}", StorePrefixOf(results.Digest(0)),
                                           static_cast<uint64_t>(results.Int(2)));
    if (!stored || (stored->path + "/").compare(0, folder.size() + 1, folder + "/") != 0) {
      violations.push_back("a result lies in the winner's folder: not " + name);
      continue;
    }
    ASSIGN_OR_RETURN(
        const auto swept,
        db.Integer("SELECT 1 FROM litter WHERE path = ?1 OR path = ?2"
                   " UNION ALL SELECT 1 FROM kept_folders WHERE path = ?1 OR path = ?2",
                   folder, stored->path));
    if (swept) violations.push_back("a published result is not litter: not " + name);
  }
  return results.status();
}

}  // namespace parallax
