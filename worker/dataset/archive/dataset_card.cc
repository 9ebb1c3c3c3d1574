#include "worker/dataset/archive/dataset_card.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/system/file.h"
#include "common/base/version.h"
#include "common/config/config.h"
#include "common/config/content_folders.h"
#include "common/store/store.h"
#include "worker/dataset/archive/publication.h"
#include "worker/dataset/frame/frame_statistics.h"
#include "worker/dataset/frame/histogram.h"
#include "worker/scene/types/scene_types.h"
#include "worker/scene/upgrade.h"

namespace parallax {
namespace {

using Json = nlohmann::ordered_json;

int64_t PairsWanted(const v1::StudySpec& study, const v1::VariantSpec& variant) {
  return variant.pairs() > 0 ? variant.pairs() : study.pairs();
}

// "indoor", "dense", "nature".
std::string TypeName(const v1::SceneConfig& config) {
  std::string name = v1::SceneType_Name(config.type());
  name = name.substr(name.rfind('_') + 1);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

struct Range {
  double sum = 0, min = std::numeric_limits<double>::infinity(), max = -min;
  int64_t count = 0;
  void Add(double value) {
    sum += value;
    min = std::min(min, value);
    max = std::max(max, value);
    ++count;
  }
};

// The frequency of a class.
struct Share {
  int64_t made = 0;    // Objects or materials in the recipes.
  int64_t frames = 0;  // Frames in whose left image it is seen.
  int64_t pixels = 0;  // Pixels of the left images.
};

struct Summary {
  int64_t frames = 0, passed = 0, bytes = 0;
  std::set<uint32_t> scenes;
  std::map<std::string, int64_t> failed_by_filter;
  std::map<std::string, Range> statistics;
  std::map<std::string, double> seconds;
  std::map<std::string, int64_t> rooms;
  std::map<std::string, Share> classes, materials;
  Histogram disparity = DisparityHistogram(), depth = DepthHistogram();
  int64_t pixels = 0;

  // Number of seeds without a pair, mostly rejected ones.
  int64_t Rejected() const {
    return scenes.empty() ? 0 : int64_t{*scenes.rbegin()} + 1 - static_cast<int64_t>(scenes.size());
  }
};

// The object under `key`, or an empty one. A value of its own: items() refers to it.
Json Part(const Json& json, const char* key) { return json.value(key, Json::object()); }

void AddIndexLine(const Json& line, Summary& summary) {
  const Json filters = Part(line, "filters"), statistics = Part(line, "statistics"),
             seconds = Part(line, "seconds");
  ++summary.frames;
  summary.passed += line.value("passed", true);
  summary.bytes += line.value("bytes", int64_t{0});
  summary.scenes.insert(line["scene"].get<uint32_t>());
  for (const auto& [name, verdict] : filters.items()) {
    summary.failed_by_filter[name] += !verdict.value("passed", true);
  }
  for (const auto& [name, value] : statistics.items()) {
    summary.statistics[name].Add(value.get<double>());
  }
  for (const auto& [name, value] : seconds.items()) {
    summary.seconds[name] += value.get<double>();
  }
}

void AddCounts(const Json& histogram, Histogram& sum) {
  const auto counts = histogram.value("counts", std::vector<int64_t>());
  for (size_t i = 0; i < counts.size() && i < sum.counts.size(); ++i) sum.counts[i] += counts[i];
}

void AddFrameJson(const Json& frame, Summary& summary) {
  const Json object_pixels = Part(frame, "object_pixels");
  const Json material_pixels = Part(frame, "material_pixels");
  for (const auto& [name, pixels] : object_pixels.items()) {
    summary.classes[name].pixels += pixels.get<int64_t>();
    ++summary.classes[name].frames;
  }
  for (const auto& [name, pixels] : material_pixels.items()) {
    summary.materials[name].pixels += pixels.get<int64_t>();
    ++summary.materials[name].frames;
  }
  AddCounts(Part(frame, "disparity_histogram"), summary.disparity);
  AddCounts(Part(frame, "depth_histogram"), summary.depth);
  const Json& intrinsics = frame.at("intrinsics");
  summary.pixels += intrinsics.at("width").get<int64_t>() * intrinsics.at("height").get<int64_t>();
}

absl::Status AddRecipe(const v1::Scene& scene, Summary& summary) {
  ASSIGN_OR_RETURN(const SceneType* type, TypeOf(scene));
  ++summary.rooms[type->describe(scene).kind];
  for (const v1::SceneObject& object : scene.objects()) ++summary.classes[ClassOf(object)].made;
  for (const v1::SceneMaterial& material : scene.materials()) {
    ++summary.materials[material.material_class()].made;
  }
  return absl::OkStatus();
}

absl::StatusOr<Summary> Summarise(const std::string& dir, const std::vector<IndexLine>& index) {
  Summary summary;
  for (const IndexLine& line : index) {
    const std::string path = dir + "/" + FramePath(line.key) + "/frame.json";
    ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
    try {
      AddIndexLine(Json::parse(line.text), summary);
      AddFrameJson(Json::parse(text), summary);
    } catch (const Json::exception& error) {
      return DataLoss("{}: {}", path, error.what());
    }
  }
  for (const uint32_t number : summary.scenes) {
    const std::string path = fmt::format("{}/scenes/{:06}.pb", dir, number);
    const absl::StatusOr<std::string> bytes = ReadFile(path);
    if (absl::IsNotFound(bytes.status())) continue;  // The caller may fetch frames without recipes.
    RETURN_IF_ERROR(bytes.status());
    ASSIGN_OR_RETURN(const v1::Scene scene, ParseScene(*bytes, path));
    RETURN_IF_ERROR(AddRecipe(scene, summary));
  }
  return summary;
}

Json SharesJson(const std::map<std::string, Share>& shares) {
  Json json = Json::object();
  for (const auto& [name, share] : shares) {
    json[name] = {{"made", share.made}, {"frames", share.frames}, {"pixels", share.pixels}};
  }
  return json;
}

Json WholeHistogramJson(const Histogram& histogram, const char* width_key) {
  return {{width_key, histogram.bin_width},
          {"counts", histogram.counts},
          {"last_bin", "everything larger"}};
}

std::string CardJson(const v1::StudySpec& study, const v1::VariantSpec& variant, const Summary& s) {
  Json json;
  json["format"] = "parallax-dataset-1";
  json["study"] = study.name();
  json["variant"] = variant.name();
  json["seed"] = std::to_string(study.seed());  // As in frame.json.
  json["versions"] = {{"generator", kSceneVersion},
                      {"program", kProgramVersion},
                      {"layout", kLayoutVersion},
                      {"scene", kSceneVersion},
                      {"frame", kFrameVersion}};
  json["type"] = TypeName(variant.config());
  json["pairs_wanted"] = PairsWanted(study, variant);
  json["pairs"] = s.frames;
  json["pairs_passing_filters"] = s.passed;
  json["scenes"] = s.scenes.size();
  json["bytes"] = s.bytes;
  json["filters_failed"] = s.failed_by_filter;
  json["rooms"] = s.rooms;
  Json statistics = Json::object();
  for (const auto& [name, range] : s.statistics) {
    statistics[name] = {{"mean", range.sum / static_cast<double>(range.count)},
                        {"min", range.min},
                        {"max", range.max}};
  }
  json["statistics"] = statistics;
  json["disparity_histogram"] = WholeHistogramJson(s.disparity, "bin_px");
  Json limits = Json::object();
  for (const int limit : kDisparityLimitsPx) {
    limits[std::to_string(limit)] = s.disparity.FractionBelow(limit);
  }
  json["disparity_fraction_below_px"] = limits;
  json["depth_histogram"] = WholeHistogramJson(s.depth, "bin_m");
  json["classes"] = SharesJson(s.classes);
  json["materials"] = SharesJson(s.materials);
  json["wall_seconds"] = s.seconds;
  json["wall_seconds"].erase("cpu");
  const auto cpu = s.seconds.find("cpu");
  const double core_s = cpu == s.seconds.end() ? 0 : cpu->second;
  json["cost"] = {
      {"core_seconds", core_s},
      {"core_seconds_per_pair", core_s / static_cast<double>(std::max<int64_t>(s.frames, 1))}};
  json["scenes_rejected"] = s.Rejected();
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Rows "|64-96|########|12.3 %|" over groups of bins.
std::string BarTable(const Histogram& histogram, int bins_a_row, int rows, const char* unit) {
  const double total = static_cast<double>(std::max<int64_t>(histogram.Total(), 1));
  std::string text = std::string("| ") + unit + " | | share |\n|---|---|---|\n";
  int64_t left = histogram.Total();
  for (int row = 0; row < rows && left > 0; ++row) {  // Rows after the last count say nothing.
    const size_t begin = static_cast<size_t>(row * bins_a_row);
    const bool last = row == rows - 1;
    const size_t end =
        last ? histogram.counts.size()
             : std::min(begin + static_cast<size_t>(bins_a_row), histogram.counts.size());
    int64_t count = 0;
    for (size_t i = begin; i < end; ++i) count += histogram.counts[i];
    left -= count;
    const double share = static_cast<double>(count) / total;
    const double low = static_cast<double>(begin) * histogram.bin_width;
    const double high = static_cast<double>(end) * histogram.bin_width;
    text += fmt::format("| {:.0f}{} | {} | {:.1f} % |\n", low,
                        last ? " and more" : fmt::format("–{:.0f}", high),
                        std::string(static_cast<size_t>(share * 40 + 0.5), '#'), 100 * share);
  }
  return text;
}

std::string ShareTable(const std::map<std::string, Share>& shares, int64_t pixels,
                       const char* title) {
  std::vector<std::pair<std::string, Share>> rows(shares.begin(), shares.end());
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second.pixels > b.second.pixels; });
  std::string text =
      std::string("| ") + title + " | made | frames | pixels |\n|---|---:|---:|---:|\n";
  for (const auto& [name, share] : rows) {
    text += fmt::format("| {} | {} | {} | {:.2f} % |\n", name, share.made, share.frames,
                        100.0 * static_cast<double>(share.pixels) /
                            static_cast<double>(std::max<int64_t>(pixels, 1)));
  }
  return text;
}

std::string CardMarkdown(const v1::StudySpec& study, const v1::VariantSpec& variant,
                         const Summary& s, bool other_licence) {
  const double frames = static_cast<double>(std::max<int64_t>(s.frames, 1));
  std::string text = CardHead(s.frames, other_licence, /*configs=*/"");
  text += "# " + study.name() + " / " + variant.name() + "\n\n";
  text += fmt::format(
      "{} stereo pairs of {} procedural scenes with ground truth for both eyes, {:.1f} MB. Made by "
      "Parallax {} ({}) with seed {}; `study.lock.yaml` one folder up makes the same again.\n\n",
      s.frames, s.scenes.size(), static_cast<double>(s.bytes) / 1e6, kProgramVersion,
      DescribeVersions(), study.seed());
  if (s.frames < PairsWanted(study, variant)) {
    text +=
        fmt::format("**Incomplete:** {} pairs were asked for.\n\n", PairsWanted(study, variant));
  }
  text +=
      "`index.jsonl` has a line a pair with the verdict of each filter; `dataset.json` has the "
      "numbers below in full.\n\n## Filters\n\n| filter | pairs that fail |\n|---|---:|\n";
  for (const auto& [name, failed] : s.failed_by_filter) {
    text += fmt::format("| {} | {} |\n", name, failed);
  }
  text += fmt::format("| (whole scenes rejected before rendering: {}) | |\n", s.Rejected());
  text += fmt::format("| passing all | {} |\n", s.passed);

  text += "\n## Disparity of the left view\n\n" + BarTable(s.disparity, 8, 17, "pixels") + "\n";
  text += "Training code often cuts at a limit; pixels below it: ";
  bool first = true;
  for (const int limit : kDisparityLimitsPx) {
    text += fmt::format("{}{} px: {:.1f} %", first ? "" : ", ", limit,
                        100 * s.disparity.FractionBelow(limit));
    first = false;
  }
  text += ".\n\n## Depth of the left view\n\n" + BarTable(s.depth, 4, 13, "metres");

  text += "\n## Per pair\n\n| | mean | min | max |\n|---|---:|---:|---:|\n";
  for (const auto& [name, range] : s.statistics) {
    text += fmt::format("| {} | {:.3f} | {:.3f} | {:.3f} |\n", name,
                        range.sum / static_cast<double>(range.count), range.min, range.max);
  }
  text += "\n## Rooms\n\n";
  first = true;
  for (const auto& [kind, count] : s.rooms) {
    text += fmt::format("{}{}: {}", first ? "" : ", ", kind.empty() ? "unnamed" : kind, count);
    first = false;
  }
  text += "\n\n## Classes\n\n" + ShareTable(s.classes, s.pixels, "class");
  text += "\n## Materials\n\n" + ShareTable(s.materials, s.pixels, "material");
  const auto cpu = s.seconds.find("cpu");
  text += "\n## Cost\n\n";
  if (cpu != s.seconds.end()) {
    text += fmt::format("{:.2f} core-seconds a pair to render. ", cpu->second / frames);
  }
  text += "Wall seconds a pair on the machines that made it:";
  for (const auto& [stage, seconds] : s.seconds) {
    if (stage == "cpu") continue;
    text += fmt::format(" {} {:.2f},", stage, seconds / frames);
  }
  text.back() = '.';
  text += "\n\n" + CitationSection(other_licence);
  text += "\n## Configuration\n\n```yaml\n" + MessageToYaml(variant.config()) + "```\n";
  return text;
}

std::string CardCroissant(const v1::StudySpec& study, const v1::VariantSpec& variant,
                          const std::vector<IndexLine>& index, bool other_licence) {
  Publication publication;
  publication.name = study.name() + "-" + variant.name();
  publication.description = fmt::format(
      "Variant {} of the study {}: {} synthetic stereo pairs with exact ground truth for both "
      "eyes. `path` is a pair's folder.",
      variant.name(), study.name(), index.size());
  publication.version = kProgramVersion;
  publication.other_licence = other_licence;
  publication.table_file = "index.jsonl";
  publication.table_bytes = IndexText(index);
  publication.fields = {{"scene", "Number of the scene.", "Integer"},
                        {"rig", "Number of the rig in its scene.", "Integer"},
                        {"path", "Folder of the pair's files.", "Text"},
                        {"passed", "Whether the pair passes all filters.", "Boolean"},
                        {"bytes", "Size of the pair's files.", "Integer"}};
  return CroissantJson(publication);
}

}  // namespace

absl::Status WriteDatasetCard(const std::string& variant_dir, const v1::StudySpec& study,
                              const v1::VariantSpec& variant, const std::vector<IndexLine>& index) {
  ASSIGN_OR_RETURN(const Summary summary, Summarise(variant_dir, index));
  absl::StatusOr<std::string> licence = ReadFile(variant_dir + "/LICENSE");
  if (absl::IsNotFound(licence.status())) {
    v1::SceneConfig config = variant.config();
    licence = DataLicence(/*own_content=*/!ContentFoldersOf(config).empty());
  }
  RETURN_IF_ERROR(licence.status());
  const bool other = *licence != DataLicence(/*own_content=*/false);
  const std::pair<const char*, std::string> files[] = {
      {"index.jsonl", IndexText(index)},
      {"dataset.json", CardJson(study, variant, summary)},
      {"README.md", CardMarkdown(study, variant, summary, other)},
      {"croissant.json", CardCroissant(study, variant, index, other)},
      {"LICENSE", *licence}};
  for (const auto& [name, text] : files) {
    RETURN_IF_ERROR(WriteFileAtomically(variant_dir + "/" + name, text));
  }
  return absl::OkStatus();
}

}  // namespace parallax
