// The base class of kinds whose result is one folder of files in the store. `Result` is a message
// with `path` and `files`; it is stored, packed, under the job's work key. `Input` is the message
// with `needs` that the coordinator keeps for a job. A derived kind adds its own checks of results.
//
// Errors: those of JobKind.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "coordinator/queue/database/compress.h"
#include "coordinator/queue/kinds/train_data.h"

namespace parallax {

template <typename Input, typename Result>
class FolderKind : public JobKind {
 public:
  // ---- Messages
  WorkNeeds NeedsOf(std::string_view bytes) const override {
    const auto input = InputOf<Input>(bytes);
    if (!input.ok()) return WorkNeeds();
    WorkNeeds needs = parallax::NeedsOf(input->needs());
    AddAbilities(*input, &needs.tags);
    return needs;
  }

  std::string WithMemory(std::string_view bytes, int64_t memory_mb) const override {
    auto input = InputOf<Input>(bytes);
    if (!input.ok()) return "";
    input->mutable_needs()->set_memory_mb(memory_mb);
    return input->SerializeAsString();
  }

  std::shared_ptr<const CheckedResult> CheckResult(std::string_view bytes) const override {
    auto out = std::make_shared<Checked>();
    if (!out->result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
      out->invalid = "a result that is no " + Result::descriptor()->name();
      return out;
    }
    out->invalid = WhyBadFiles(out->result.path(), out->result.files());
    if (out->invalid.empty()) out->invalid = WhyBad(out->result);
    out->paths = {out->result.path()};
    out->packed = PackMessage(out->result);
    return out;
  }

  std::vector<OutputFile> FilesOf(std::string_view bytes) const override {
    Result result;
    if (!result.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) return {};
    return OutputFilesOf(result.path(), result.files());
  }

  std::optional<StoredFolder> FolderOf(std::string_view packed) const override {
    Result result;
    if (!UnpackMessage(packed, result).ok()) return std::nullopt;
    return StoredFolder{result.path(), result.files()};
  }

  std::vector<OutputFile> StoredFiles(std::string_view stage,
                                      std::string_view packed) const override {
    const auto folder = stage == name() ? FolderOf(packed) : std::nullopt;
    return folder ? OutputFilesOf(folder->path, folder->files) : std::vector<OutputFile>();
  }

  // ---- Hooks
  absl::StatusOr<Ending> Store(WorkDesk& desk, const JobFacts& job,
                               const CheckedResult& result) const override {
    const auto& checked = static_cast<const Checked&>(result);
    ASSIGN_OR_RETURN(const bool is_first,
                     desk.PutResult(job, name(), job.work_key, {checked.packed, false, ""}));
    if (!is_first) RETURN_IF_ERROR(desk.Discard(checked.result.path()));
    return Ending();
  }

  absl::Status Audit(SqliteConnection& db, std::vector<std::string>& violations) const override {
    return AuditFolders(db, *this, violations);
  }

 protected:
  using JobKind::JobKind;

  struct Checked final : CheckedResult {
    Result result;
    std::string packed;
  };
  static const Result& ResultIn(const CheckedResult& result) {
    return static_cast<const Checked&>(result).result;
  }

  // Adds the tags of what a worker must have for this job; see common/base/ability_tags.h.
  virtual void AddAbilities(const Input& input, std::vector<std::string>* tags) const = 0;
  // Returns why no job can have this result, whose files were found good; empty if a job can.
  virtual std::string WhyBad(const Result& result) const = 0;
};

}  // namespace parallax
