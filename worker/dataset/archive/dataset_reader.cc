#include "worker/dataset/archive/dataset_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "common/base/edit_distance.h"
#include "common/base/system/file.h"
#include "common/config/training_plan.h"
#include "worker/dataset/archive/archive_index.h"

namespace parallax {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Frame folders that no line of the index knows, and names that are no frame's.
void FindStrays(const DatasetVariant& variant, std::vector<std::string>& faults) {
  std::set<std::string> known;
  for (const DatasetFrame& frame : variant.frames) known.insert(frame.dir);
  std::error_code error;
  std::vector<std::string> strays;
  for (const auto& scene : fs::directory_iterator(variant.dir + "/frames", error)) {
    if (!scene.is_directory(error)) continue;
    for (const auto& rig : fs::directory_iterator(scene.path(), error)) {
      const std::string name = rig.path().filename();
      if (name[0] == '.') {
        strays.push_back(rig.path().string() + ": left over from an interrupted run");
      } else if (!known.contains(rig.path().string())) {
        strays.push_back(rig.path().string() + ": not in the index");
      }
    }
  }
  std::sort(strays.begin(), strays.end());
  faults.insert(faults.end(), strays.begin(), strays.end());
}

void ReadCard(DatasetVariant& variant) {
  const std::string path = variant.dir + "/dataset.json";
  const absl::StatusOr<std::string> text = ReadFile(path);
  if (!text.ok()) {
    variant.faults.push_back(path + ": missing");
    return;
  }
  const Json card = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (!card.is_object()) {
    variant.faults.push_back(path + ": not JSON");
    return;
  }
  const auto number = [&](const char* key) {
    return card.contains(key) && card[key].is_number_integer() ? card[key].get<int64_t>() : -1;
  };
  variant.pairs_wanted = std::max<int64_t>(0, number("pairs_wanted"));
  if (card.contains("type") && card["type"].is_string()) variant.type = card["type"];
  if (number("pairs") != static_cast<int64_t>(variant.frames.size())) {
    variant.faults.push_back(fmt::format("{}: says {} pairs, the index {}", path, number("pairs"),
                                         variant.frames.size()));
  }
}

// Frames without an index are a damaged variant, not none.
bool IsVariant(const fs::path& dir) {
  std::error_code error;
  return fs::exists(dir / "index.jsonl", error) ||
         fs::directory_iterator(dir / "frames", error) != fs::directory_iterator();
}

absl::StatusOr<DatasetVariant> ReadVariant(const std::string& dir) {
  DatasetVariant variant;
  variant.dir = dir;
  variant.name = fs::path(dir).filename();
  const std::string path = dir + "/index.jsonl";
  absl::StatusOr<std::string> text = ReadFile(path);
  if (absl::IsNotFound(text.status())) {
    variant.has_index = false;
    variant.faults.push_back(path + ": missing");
    text = std::string();
  }
  RETURN_IF_ERROR(text.status());
  std::istringstream in(*text);
  int number = 0;
  std::set<FrameId> keys;
  for (std::string row; std::getline(in, row);) {
    ++number;
    const absl::StatusOr<IndexLine> line = ParseIndexLine(row);
    if (!line.ok()) {
      return DataLoss("{}:{}: not a line of an index", path, number);
    }
    if (!keys.insert(line->key).second) {
      variant.faults.push_back(fmt::format("{}:{}: the frame is listed twice", path, number));
      continue;
    }
    DatasetFrame frame;
    frame.variant = variant.name;
    frame.scene = line->key.first;
    frame.rig = line->key.second;
    frame.dir = dir + "/" + FramePath(line->key);
    frame.files = line->files;
    frame.line = Json::parse(row);
    const auto& passed = frame.line["passed"];
    frame.passed = !passed.is_boolean() || passed.get<bool>();
    variant.frames.push_back(std::move(frame));
  }
  std::sort(variant.frames.begin(), variant.frames.end(), [](const auto& a, const auto& b) {
    return std::pair(a.scene, a.rig) < std::pair(b.scene, b.rig);
  });
  ReadCard(variant);
  FindStrays(variant, variant.faults);
  return variant;
}

bool Matches(const std::string& pattern, const std::string& name) {
  if (pattern.empty() || pattern.back() != '*') return pattern == name;
  return name.compare(0, pattern.size() - 1, pattern, 0, pattern.size() - 1) == 0;
}

}  // namespace

absl::StatusOr<Dataset> ReadDataset(const std::string& path) {
  Dataset dataset;
  dataset.dir = fs::absolute(path).lexically_normal();
  while (dataset.dir.size() > 1 && dataset.dir.back() == '/') dataset.dir.pop_back();
  std::error_code error;
  if (!fs::is_directory(dataset.dir, error)) {
    return NotFound("{}: no such folder", path);
  }
  std::vector<std::string> dirs;
  if (fs::exists(dataset.dir + "/index.jsonl", error)) {
    dirs.push_back(dataset.dir);
  } else {
    for (const auto& entry : fs::directory_iterator(dataset.dir, error)) {
      if (entry.path().filename().string()[0] == '.') continue;
      if (IsVariant(entry.path())) dirs.push_back(entry.path());
    }
  }
  if (dirs.empty()) {
    return NotFound("{}: no dataset (no index.jsonl in it or in its folders)", path);
  }
  std::sort(dirs.begin(), dirs.end());
  for (const std::string& dir : dirs) {
    ASSIGN_OR_RETURN(DatasetVariant variant, ReadVariant(dir));
    dataset.variants.push_back(std::move(variant));
  }
  return dataset;
}

absl::Status RequireIndices(const Dataset& dataset) {
  for (const DatasetVariant& variant : dataset.variants) {
    if (variant.has_index) continue;
    return FailedPrecondition("{}/index.jsonl is missing (fetch the dataset again)", variant.dir);
  }
  return absl::OkStatus();
}

bool LeaveOutHeldout(Dataset& dataset) {
  return std::erase_if(dataset.variants, [&](const DatasetVariant& variant) {
           return variant.name == kHeldoutName && variant.dir != dataset.dir;
         }) > 0;
}

absl::StatusOr<std::vector<DatasetVariant>> ChooseVariants(
    Dataset dataset, const std::vector<std::string>& patterns) {
  if (patterns.empty()) return std::move(dataset.variants);
  std::vector<DatasetVariant> chosen;
  for (const std::string& pattern : patterns) {
    const bool known =
        std::any_of(dataset.variants.begin(), dataset.variants.end(),
                    [&](const DatasetVariant& v) { return Matches(pattern, v.name); });
    if (known) continue;
    std::vector<std::string> names;
    for (const DatasetVariant& v : dataset.variants) names.push_back(v.name);
    return InvalidArgument("no variant \"{}\" in {}{} (there are {})", pattern, dataset.dir,
                           NearestHint(pattern, names), fmt::join(names, ", "));
  }
  for (DatasetVariant& variant : dataset.variants) {
    if (std::any_of(patterns.begin(), patterns.end(),
                    [&](const std::string& p) { return Matches(p, variant.name); })) {
      chosen.push_back(std::move(variant));
    }
  }
  return chosen;
}

}  // namespace parallax
