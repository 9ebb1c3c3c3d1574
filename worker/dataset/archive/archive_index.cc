#include "worker/dataset/archive/archive_index.h"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "common/config/verdicts.h"

namespace parallax {

using Json = nlohmann::ordered_json;

namespace {

// Sets "passed" and "filters" from "statistics" and writes the text anew.
absl::Status SetVerdicts(const v1::FilterConfig& filters, Json& json, IndexLine& line) {
  FrameFacts facts;
  for (const auto& [name, value] : json["statistics"].items()) {
    if (value.is_number()) facts.statistics[name] = value.get<double>();
  }
  auto verdicts = Judge(facts, filters);
  if (!verdicts.ok()) return WithContext(verdicts.status(), FramePath(line.key));
  Json by_name = Json::object();
  bool passed = true;
  for (const Verdict& verdict : *verdicts) {
    by_name[verdict.name] = {
        {"passed", verdict.passed}, {"value", verdict.value}, {"threshold", verdict.threshold}};
    passed = passed && verdict.passed;
  }
  json["passed"] = passed;
  json["filters"] = std::move(by_name);
  line.text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
  return absl::OkStatus();
}

}  // namespace

std::string IndexText(const std::vector<IndexLine>& index) {
  std::string text;
  for (const IndexLine& line : index) text += line.text + "\n";
  return text;
}

std::string FramePath(const FrameId& key) {
  return fmt::format("frames/{:06}/{:03}", key.first, key.second);
}

absl::StatusOr<IndexLine> MakeIndexLine(const v1::PublishedFrame& published,
                                        const v1::FilterConfig& filters) {
  const v1::FrameResult& frame = published.frame();
  IndexLine line;
  line.key = {published.scene(), frame.rig()};
  int64_t bytes = 0;
  for (const v1::FileEntry& file : frame.files()) {
    line.files.emplace(file.name(), file.sha256());
    bytes += file.size();
  }
  const auto sorted = [](const auto& map) {
    return std::map<std::string, double>(map.begin(), map.end());
  };
  Json json = {{"variant", published.variant()},
               {"scene", published.scene()},
               {"rig", frame.rig()},
               {"path", FramePath(line.key)},
               {"passed", nullptr},
               {"filters", nullptr},
               {"statistics", sorted(frame.statistics())},
               {"seconds", sorted(frame.stage_s())},
               {"bytes", bytes},
               {"files", line.files}};
  RETURN_IF_ERROR(SetVerdicts(filters, json, line));
  return line;
}

absl::Status JudgeAnew(const v1::FilterConfig& filters, IndexLine& line) {
  Json json = Json::parse(line.text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object()) return DataLoss("not a line of an index");
  return SetVerdicts(filters, json, line);
}

absl::Status SetAmbiguousShare(std::optional<double> share, const v1::FilterConfig& filters,
                               IndexLine& line) {
  Json json = Json::parse(line.text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("statistics") || !json["statistics"].is_object()) {
    return DataLoss("not a line of an index");
  }
  json["statistics"].erase(kAmbiguousShare);
  if (share) json["statistics"][kAmbiguousShare] = *share;
  return SetVerdicts(filters, json, line);
}

std::optional<double> AmbiguousShareOf(const IndexLine& line) {
  const Json json = Json::parse(line.text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("statistics")) return std::nullopt;
  const auto share = json["statistics"].find(kAmbiguousShare);
  if (share == json["statistics"].end() || !share->is_number()) return std::nullopt;
  return share->get<double>();
}

absl::StatusOr<IndexLine> ParseIndexLine(const std::string& text) {
  const Json json = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  const auto number = [&](const char* key) {
    return json.contains(key) && json[key].is_number_unsigned();
  };
  if (!json.is_object() || !number("scene") || !number("rig") || !json.contains("files") ||
      !json["files"].is_object()) {
    return DataLoss("not a line of an index");
  }
  IndexLine line;
  line.key = {json["scene"].get<uint32_t>(), json["rig"].get<uint32_t>()};
  line.text = text;
  for (const auto& [name, hash] : json["files"].items()) {
    if (!hash.is_string()) return DataLoss("not a line of an index");
    line.files.emplace(name, hash.get<std::string>());
  }
  return line;
}

}  // namespace parallax
