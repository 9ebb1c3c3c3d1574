// The machine's side of WorkDesk: the reads and changes that kinds of jobs may make.
#include <algorithm>

#include "common/base/status.h"
#include "coordinator/queue/commands/machine.h"

namespace parallax {

absl::StatusOr<VariantFacts> Machine::VariantOf(int64_t id) {
  ASSIGN_OR_RETURN(const Variant* variant, ledger_.FindVariant(id));
  return VariantFacts{.id = id,
                      .name = variant->name,
                      .seed = variant->seed,
                      .pairs_wanted = variant->pairs_wanted,
                      .rigs_per_scene = variant->rigs_per_scene,
                      .config = variant->config.get(),
                      .digests = &variant->digests};
}

absl::StatusOr<SceneFacts> Machine::SceneOf(int64_t variant, uint32_t ordinal) {
  ASSIGN_OR_RETURN(const SceneRow* scene, OpenScene(variant, ordinal, /*change=*/false));
  return SceneFacts{scene->rigs, scene->scene_hash};
}

absl::StatusOr<JobFacts> Machine::NewestOf(int64_t id) {
  ASSIGN_OR_RETURN(std::optional<JobRow> job, store_.FindNewest(id));
  if (job) return JobFacts(*std::move(job));
  return Internal("job {}: no such", id);
}

absl::StatusOr<std::optional<StoredResult>> Machine::FindResult(const Sha256Digest& key) {
  std::string stage;
  ASSIGN_OR_RETURN(std::optional<StoredResult> result, results_.Find(key, &stage));
  if (result && !FilesAreThere(key, stage, result->bytes)) result.reset();
  return result;
}

absl::StatusOr<bool> Machine::HasResult(const Sha256Digest& key) {
  if (!options_.files_there) return results_.Has(key);
  ASSIGN_OR_RETURN(const std::optional<StoredResult> result, FindResult(key));
  return result.has_value();
}

bool Machine::FilesAreThere(const Sha256Digest& key, std::string_view stage,
                            std::string_view bytes) {
  if (!options_.files_there || ending_fence_ != 0) return true;
  const std::vector<JobKind::OutputFile> files = kinds_.StoredFiles(stage, bytes);
  if (files.empty() || options_.files_there(files)) return true;
  const bool known = std::any_of(missing_.begin(), missing_.end(),
                                 [&key](const DamagedResult& other) { return other.key == key; });
  if (!known) missing_.push_back({key, CommonFolder(files), "its files are not in the store"});
  return false;
}

absl::StatusOr<bool> Machine::PutResult(const JobFacts& by, std::string_view stage,
                                        const Sha256Digest& key, const StoredResult& result) {
  if (ending_fence_ == 0) {
    return Internal("job {}: a result that no attempt has made", by.id);
  }
  StoredResult kept = result;
  kept.reason = OneLine(result.reason);
  return results_.Insert(key, stage, kept, by.id, ending_fence_);
}

absl::Status Machine::SetScene(const JobFacts& job, const Sha256Digest& scene_hash) {
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  ++ledger_.Change(*variant).tally_solved;
  return ChangeScene(*variant, job.ordinal, {.scene_hash = scene_hash}).status();
}

absl::Status Machine::Publish(const JobFacts& job, std::span<const FrameLink> frames) {
  ASSIGN_OR_RETURN(Variant * variant, ledger_.FindVariant(job.variant));
  int64_t reused = 0;
  for (const FrameLink& frame : frames) {
    RETURN_IF_ERROR(results_.InsertFrame(job, frame));
    reused += frame.reused ? 1 : 0;
  }
  if (reused > 0) ledger_.Change(*variant).frames_reused += reused;
  return ChangeScene(*variant, job.ordinal, {.rigs_done = static_cast<int>(frames.size())})
      .status();
}

absl::Status Machine::Discard(std::string_view path) {
  return folders_.InsertLitter(std::string(path), Now());
}

}  // namespace parallax
