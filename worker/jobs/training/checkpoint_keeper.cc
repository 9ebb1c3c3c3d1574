#include "worker/jobs/training/checkpoint_keeper.h"

#include <fmt/core.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/hash.h"
#include "common/base/system/file.h"
#include "common/config/frame_notes.h"
#include "worker/jobs/files/store_files.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kFactsName[] = "facts.json";
constexpr char kCurveName[] = "curve.csv";
constexpr size_t kNewest = 2;  // A checkpoint that is cut off has one before it.

Json ToJson(const CheckpointFacts& facts) {
  return {{"step", facts.step},     {"name", facts.name},           {"size", facts.size},
          {"sha256", facts.sha256}, {"for_curve", facts.for_curve}, {"train_s", facts.train_s}};
}

std::optional<CheckpointFacts> FactsFrom(const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  try {
    return CheckpointFacts{json.at("step"),   json.at("name"),      json.at("size"),
                           json.at("sha256"), json.at("for_curve"), json.at("train_s")};
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace

absl::StatusOr<std::vector<LeftCheckpoint>> ListCheckpoints(const Store& store,
                                                            const std::string& resume_folder) {
  std::vector<LeftCheckpoint> left;
  if (resume_folder.empty()) return left;
  ASSIGN_OR_RETURN(const std::vector<StoreEntry> entries, store.List(resume_folder));
  const std::string end = std::string("/") + kFactsName;
  const std::string resume = fmt::format("/{}/", kResumeFolder);
  for (const StoreEntry& entry : entries) {
    const bool is_facts = entry.path.size() > end.size() &&
                          entry.path.find(resume) != std::string::npos &&
                          entry.path.compare(entry.path.size() - end.size(), end.size(), end) == 0;
    if (!is_facts) continue;
    const absl::StatusOr<std::string> text = store.Get(entry.path);
    if (!text.ok()) continue;  // Its attempt may be removing it.
    const auto facts = FactsFrom(*text);
    if (facts) left.push_back({*facts, entry.path.substr(0, entry.path.size() - end.size())});
  }
  std::stable_sort(left.begin(), left.end(), [](const LeftCheckpoint& a, const LeftCheckpoint& b) {
    return a.facts.step < b.facts.step;
  });
  return left;
}

absl::Status FetchCheckpoint(const Store& store, const LeftCheckpoint& left,
                             const std::string& path, std::string* curve) {
  const std::string name = left.folder + "/" + left.facts.name;
  RETURN_IF_ERROR(CheckStorePath(name));
  ASSIGN_OR_RETURN(const std::string bytes, GetWhole(store, name, left.facts.size));
  if (Sha256Hex(bytes) != left.facts.sha256) return DataLoss("{}: damaged", name);
  if (curve != nullptr) {
    ASSIGN_OR_RETURN(*curve, store.Get(left.folder + "/" + kCurveName));
  }
  return WriteFile(path, bytes);
}

std::string CheckpointKeeper::FolderOf(int64_t step) const {
  return fmt::format("{}/{}/{:09}", attempt_path_, kResumeFolder, step);
}

absl::Status CheckpointKeeper::Put(const CheckpointFacts& facts, const std::string& path,
                                   const std::string& curve) {
  const std::string folder = FolderOf(facts.step);
  RETURN_IF_ERROR(store_.PutFile(folder + "/" + facts.name, path, {facts.size, facts.sha256},
                                 /*may_move=*/false));
  RETURN_IF_ERROR(store_.Put(folder + "/" + kCurveName, curve));
  RETURN_IF_ERROR(store_.Put(folder + "/" + kFactsName, ToJson(facts).dump() + "\n"));
  kept_.push_back(facts);
  std::sort(kept_.begin(), kept_.end(),
            [](const CheckpointFacts& a, const CheckpointFacts& b) { return a.step < b.step; });
  for (size_t i = 0; i + kNewest < kept_.size();) {
    if (kept_[i].for_curve) {
      ++i;
      continue;
    }
    store_.RemoveTree(FolderOf(kept_[i].step)).IgnoreError();
    kept_.erase(kept_.begin() + static_cast<ptrdiff_t>(i));
  }
  return absl::OkStatus();
}

}  // namespace parallax
