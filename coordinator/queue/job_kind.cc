#include "coordinator/queue/job_kind.h"

#include <fmt/core.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "parallax/v1/train.pb.h"

namespace parallax {
namespace {

[[noreturn]] void Die(const std::string& message) {
  std::fprintf(stderr, "kinds of jobs: %s\n", message.c_str());
  std::abort();
}

bool IsKindName(std::string_view name) {
  return !name.empty() && name.size() <= 32 && name[0] >= 'a' && name[0] <= 'z' &&
         std::all_of(name.begin(), name.end(), [](char c) {
           return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
         });
}

}  // namespace

WorkNeeds JobKind::NeedsOf(std::string_view input) const {
  v1::JobNeeds needs;
  if (!traits_.of_scene || input.empty()) return {};
  if (!needs.ParseFromArray(input.data(), static_cast<int>(input.size()))) return {};
  return {.memory_mb = needs.memory_mb()};
}

std::string JobKind::WithMemory(std::string_view, int64_t memory_mb) const {
  if (!traits_.of_scene) return "";
  v1::JobNeeds needs;
  needs.set_memory_mb(memory_mb);
  return needs.SerializeAsString();
}

std::vector<WorkNeeds> JobKind::NeedsOfStudy(const v1::StudySpec&) const {
  if (traits_.of_scene) return {WorkNeeds()};
  return {};
}

absl::StatusOr<Sha256Digest> JobKind::KeepKey(WorkDesk&, const JobFacts& job) const {
  return job.work_key;
}

absl::StatusOr<KnownWork> JobKind::Look(WorkDesk& desk, const JobFacts& job) const {
  KnownWork known;
  ASSIGN_OR_RETURN(std::optional<StoredResult> result, desk.FindResult(job.work_key));
  if (!result) return known;
  known.state = result->rejected ? KnownWork::State::kRejected : KnownWork::State::kDone;
  known.result = std::move(result->bytes);
  known.reason = std::move(result->reason);
  return known;
}

absl::Status JobKind::Trim(WorkDesk&, JobFacts&) const { return absl::OkStatus(); }

absl::StatusOr<bool> JobKind::HasPart(WorkDesk&, const JobFacts&) const { return false; }

absl::StatusOr<std::string> JobKind::WhyNot(WorkDesk&, const JobFacts&,
                                            const CheckedResult&) const {
  return std::string();
}

absl::Status JobKind::OnSuccess(WorkDesk&, const JobFacts&, const Ending&, bool) const {
  return absl::OkStatus();
}

absl::Status JobKind::OnSubmit(WorkDesk&, const v1::StudySpec&, std::span<const int64_t>) const {
  return absl::OkStatus();
}

absl::Status JobKind::OnMorePairs(WorkDesk&, int64_t, uint32_t, uint32_t, uint32_t) const {
  return absl::OkStatus();
}

absl::Status JobKind::Audit(SqliteConnection&, std::vector<std::string>&) const {
  return absl::OkStatus();
}

KindRegistry::KindRegistry(std::vector<const JobKind*> kinds) : kinds_(std::move(kinds)) {
  if (kinds_.size() > kMostKinds) Die(fmt::format("more than {}", kMostKinds));
  int beginning = 0;
  for (size_t i = 0; i < kinds_.size(); ++i) {
    const std::string& name = kinds_[i]->name();
    if (!IsKindName(name)) Die("'" + name + "' is no name");
    if (Find(name)->value != i) Die("two are named '" + name + "'");
    if (!kinds_[i]->traits().begins_scenes) continue;
    ++beginning;
    begins_scenes_ = KindId{static_cast<uint8_t>(i)};
  }
  if (beginning != 1) Die(fmt::format("{} begin scenes, wanted one", beginning));
}

KindRegistry KindRegistry::With(const JobKind& more) const {
  std::vector<const JobKind*> kinds = kinds_;
  kinds.push_back(&more);
  return KindRegistry(std::move(kinds));
}

std::optional<KindId> KindRegistry::Find(std::string_view name) const {
  for (size_t i = 0; i < kinds_.size(); ++i) {
    if (kinds_[i]->name() == name) return KindId{static_cast<uint8_t>(i)};
  }
  return std::nullopt;
}

absl::StatusOr<KindId> KindRegistry::IdOf(std::string_view name) const {
  if (const auto id = Find(name)) return *id;
  std::string known;
  for (const JobKind* kind : kinds_) known += (known.empty() ? "" : ", ") + kind->name();
  return NotFound("unknown kind of job '{}'; there are: {}", name.substr(0, 40), known);
}

std::vector<std::string> KindRegistry::Names() const {
  std::vector<std::string> names;
  for (const JobKind* kind : kinds_) names.push_back(kind->name());
  return names;
}

std::string CommonFolder(const std::vector<JobKind::OutputFile>& files) {
  if (files.empty()) return "";
  std::string folder = files[0].path.substr(0, files[0].path.rfind('/'));
  for (const JobKind::OutputFile& file : files) {
    while (!folder.empty() && file.path.compare(0, folder.size() + 1, folder + "/") != 0) {
      const size_t end = folder.rfind('/');
      folder.resize(end == std::string::npos ? 0 : end);
    }
  }
  // Never more than an attempt.
  return folder.find("/.attempt-") == std::string::npos ? "" : folder;
}

std::vector<JobKind::OutputFile> KindRegistry::StoredFiles(std::string_view stage,
                                                           std::string_view bytes) const {
  for (const JobKind* kind : kinds_) {
    std::vector<JobKind::OutputFile> files = kind->StoredFiles(stage, bytes);
    if (!files.empty()) return files;
  }
  return {};
}

}  // namespace parallax
