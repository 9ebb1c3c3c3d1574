#include "worker/dataset/archive/judge_archive.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "common/base/system/file.h"
#include "worker/dataset/archive/dataset_card.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

void Count(const IndexLine& line, JudgedVariant& judged) {
  const Json json = Json::parse(line.text);
  ++judged.frames;
  judged.passed += json["passed"].get<bool>();
  const Json& filters = json["filters"];
  judged.ambiguous += filters.contains("ambiguous") && !filters["ambiguous"]["passed"].get<bool>();
}

}  // namespace

absl::StatusOr<JudgedVariant> JudgeVariant(const std::string& dir, const v1::StudySpec& study,
                                           const v1::VariantSpec& variant,
                                           const std::map<FrameId, double>& shares) {
  const std::string path = dir + "/index.jsonl";
  ASSIGN_OR_RETURN(const std::string before, ReadFile(path));
  JudgedVariant judged;
  std::vector<IndexLine> lines;
  std::istringstream in(before);
  for (std::string row; std::getline(in, row);) {
    absl::StatusOr<IndexLine> line = ParseIndexLine(row);
    if (!line.ok()) return WithContext(line.status(), path);
    const auto share = shares.find(line->key);
    const absl::Status status =
        SetAmbiguousShare(share == shares.end() ? std::nullopt : std::optional(share->second),
                          variant.config().filters(), *line);
    if (!status.ok()) return WithContext(status, path);
    Count(*line, judged);
    lines.push_back(*std::move(line));
  }
  RETURN_IF_ERROR(WriteDatasetCard(dir, study, variant, lines));
  return judged;
}

}  // namespace parallax
