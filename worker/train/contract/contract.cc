#include "worker/train/contract/contract.h"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "common/base/system/file.h"
#include "worker/train/contract/contract_predict.h"
#include "worker/train/contract/contract_reader.h"

namespace parallax {
namespace {

const std::set<std::string> kTrainNames = {"data",   "weight",     "out",
                                           "seed",   "steps",      "threads",
                                           "device", "repository", "checkpoint_every"};
const std::set<std::string> kSizeNames = {"width", "height"};
const std::set<std::string> kBatchNames = {"batch"};
const std::set<std::string> kStartNames = {"start"};
const std::set<std::string> kLooksNames = {"looks"};
const std::set<std::string> kResumeNames = {"resume", "out", "repository"};
const std::set<std::string> kDirectoryNames = {"out", "repository"};
const std::set<std::string> kLinkNames = {"out", "data", "repository"};

// std::regex recurses for each character: a line of 64 kB would use up the stack.
constexpr std::ptrdiff_t kMostMatched = 2000;

const std::vector<std::string> kLayouts = {"archive",   "flyingthings", "fsd",   "crestereo",
                                           "wmgstereo", "middlebury",   "kitti", "webdataset"};
const std::vector<std::string> kExits = {"not_finite", "out_of_memory", "usage"};
const std::vector<std::string> kProgressGroups = {"step",  "loss",  "epe_px",
                                                  "eta_s", "epoch", "epoch_steps"};

void ReadProgressFields(ContractReader& reader, const YAML::Node& root, TrainerContract& contract) {
  const YAML::Node node = root["progress"];
  if (!node) return reader.Error(root, "\"progress\" is missing (json, or {pattern, groups})");
  if (node.IsScalar()) {
    if (node.Scalar() != "json")
      reader.Error(node, "\"progress\" is \"" + node.Scalar() +
                             "\", but must be json, or {pattern, groups}");
    return;
  }
  reader.CheckKeys(node, "progress", {"pattern", "groups"});
  contract.progress = ProgressFormat::kPattern;
  const std::string pattern = reader.Text(node, "pattern", true);
  contract.progress_groups = reader.Texts(node, "groups", true);
  for (const std::string& group : contract.progress_groups) {
    if (std::find(kProgressGroups.begin(), kProgressGroups.end(), group) == kProgressGroups.end()) {
      reader.Error(node,
                   "unknown group \"" + group + "\" (there are " + Listed(kProgressGroups) + ")");
    }
  }
  try {
    contract.progress_pattern = std::make_shared<const std::regex>(pattern);
    const size_t groups = contract.progress_pattern->mark_count();
    if (groups != contract.progress_groups.size()) {
      reader.Error(node, fmt::format("the pattern has {} groups, but {} are named", groups,
                                     contract.progress_groups.size()));
    }
  } catch (const std::regex_error&) {
    reader.Error(node, "the pattern is not a regular expression (ECMAScript)");
  }
}

void ReadOutcomeFields(ContractReader& reader, const YAML::Node& root, TrainerContract& contract) {
  const YAML::Node leaves = root["leaves"];
  if (!leaves) return reader.Error(root, "\"leaves\" is missing ({checkpoints, final})");
  reader.CheckKeys(leaves, "leaves", {"checkpoints", "final"});
  contract.checkpoint_pattern = reader.Text(leaves, "checkpoints", !contract.resume.empty());
  contract.final_checkpoint = reader.Text(leaves, "final", true);
  if (!contract.checkpoint_pattern.empty() &&
      std::count(contract.checkpoint_pattern.begin(), contract.checkpoint_pattern.end(), '*') !=
          1) {
    reader.Error(leaves["checkpoints"], "\"checkpoints\" must have one * (for the step)");
  }
}

void ReadExits(ContractReader& reader, const YAML::Node& root, TrainerContract& contract) {
  const YAML::Node exits = root["exits"];
  if (!exits) return;
  reader.CheckKeys(exits, "exits", kExits);
  if (!exits.IsMap()) return;
  for (const auto& entry : exits) {
    const std::string name = entry.first.Scalar();
    contract.exits[name] = static_cast<int>(reader.Count(exits, name.c_str()));
  }
}

// Memory and tags choose workers, and the coordinator, which does that, does not see this file.
void ReadNeeds(ContractReader& reader, const YAML::Node& root, TrainerContract& contract) {
  const YAML::Node needs = root["needs"];
  if (!needs) return;
  reader.CheckKeys(needs, "needs", {"gpus", "memory_mb", "tags"});
  if (!needs.IsMap()) return;
  if (needs["memory_mb"]) {
    reader.Error(needs["memory_mb"],
                 "\"memory_mb\" has no effect here: write train.needs.memory_mb in the study");
  }
  if (needs["tags"]) {
    reader.Error(needs["tags"],
                 "\"tags\" has no effect here: workers that may run this trainer are found by its "
                 "name, and other tags are train.needs.tags of the study");
  }
  contract.gpus = static_cast<int>(reader.Count(needs, "gpus"));
}

bool Names(const std::vector<std::string>& command, const std::string& placeholder) {
  return std::any_of(command.begin(), command.end(), [&](const std::string& argument) {
    const std::vector<std::string> names = PlaceholdersIn(argument);
    return std::find(names.begin(), names.end(), placeholder) != names.end();
  });
}

void ReadTrain(ContractReader& reader, const YAML::Node& root, TrainerContract& contract) {
  const YAML::Node train = root["train"];
  contract.train = reader.Texts(root, "train", true);
  reader.CheckPlaceholders(train, contract.train, kTrainNames);
  if (!train || !train.IsSequence()) return;
  if (contract.train.empty()) return reader.Error(train, "\"train\" must not be empty");
  if (Names(contract.train, "seed")) return;
  reader.Error(train,
               "\"train\" must name {seed}: else all seeds of a study would train one network");
}

}  // namespace

absl::StatusOr<TrainerContract> ParseTrainerContract(std::string_view yaml,
                                                     const std::string& file) {
  TrainerContract contract;
  ContractReader reader(file);
  YAML::Node root;
  try {
    root = YAML::Load(std::string(yaml));
  } catch (const YAML::Exception& error) {
    return InvalidArgument("{}:{}: not YAML: {}", file, error.mark.line + 1, error.msg);
  }
  if (!root.IsMap()) {
    return InvalidArgument("{}: must be a map with \"trainer\", \"train\"...", file);
  }
  reader.CheckKeys(root, "the trainer",
                   {"trainer", "layout", "directory", "links", "train", "resume", "size", "batch",
                    "start", "environment", "steps", "steps_per_minute", "progress", "leaves",
                    "exits", "predict", "looks", "needs"});
  contract.name = reader.Text(root, "trainer", true);
  contract.layout = reader.Text(root, "layout", true);
  if (!contract.layout.empty() &&
      std::find(kLayouts.begin(), kLayouts.end(), contract.layout) == kLayouts.end()) {
    reader.Error(root["layout"],
                 "unknown layout \"" + contract.layout + "\" (there are " + Listed(kLayouts) + ")");
  }
  contract.directory = reader.Text(root, "directory", false);
  reader.CheckPlaceholders(root["directory"], {contract.directory}, kDirectoryNames);
  contract.links = reader.Texts(root, "links", false);
  reader.CheckPlaceholders(root["links"], contract.links, kLinkNames);
  ReadTrain(reader, root, contract);
  contract.resume = reader.Texts(root, "resume", false);
  reader.CheckPlaceholders(root["resume"], contract.resume, kResumeNames);
  contract.size = reader.Texts(root, "size", false);
  reader.CheckPlaceholders(root["size"], contract.size, kSizeNames);
  contract.batch = reader.Texts(root, "batch", false);
  reader.CheckPlaceholders(root["batch"], contract.batch, kBatchNames);
  contract.start = reader.Texts(root, "start", false);
  reader.CheckPlaceholders(root["start"], contract.start, kStartNames);
  contract.looks = reader.Texts(root, "looks", false);
  reader.CheckPlaceholders(root["looks"], contract.looks, kLooksNames);
  contract.environment = reader.Texts(root, "environment", false);
  contract.default_steps = reader.Count(root, "steps");
  contract.steps_per_minute = reader.Number(root, "steps_per_minute");
  ReadProgressFields(reader, root, contract);
  ReadOutcomeFields(reader, root, contract);
  contract.predict = ReadPredictCommand(reader, root);
  ReadExits(reader, root, contract);
  ReadNeeds(reader, root, contract);
  if (!reader.errors().empty()) return InvalidArgument("{}", reader.errors());
  return contract;
}

absl::StatusOr<TrainerContract> ReadTrainerContract(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path, size_t{1} << 20));
  return ParseTrainerContract(text, path);
}

absl::StatusOr<std::vector<std::string>> ExpandCommand(const std::vector<std::string>& command,
                                                       const CommandValues& values) {
  std::vector<std::string> expanded;
  const auto expand = [&](std::string argument,
                          const std::map<std::string, std::string>& by_name) -> absl::Status {
    std::string result;
    size_t at = 0;
    for (const std::string& name : PlaceholdersIn(argument)) {
      const std::string token = "{" + name + "}";
      const size_t place = argument.find(token, at);
      const auto value = by_name.find(name);
      if (value == by_name.end()) {
        return InvalidArgument("no value for {} in \"{}\"", token, argument);
      }
      result += argument.substr(at, place - at) + value->second;
      at = place + token.size();
    }
    expanded.push_back(result + argument.substr(at));
    return absl::OkStatus();
  };
  for (const std::string& argument : command) {
    const std::vector<std::string> names = PlaceholdersIn(argument);
    if (std::find(names.begin(), names.end(), "data") == names.end()) {
      RETURN_IF_ERROR(expand(argument, values.values));
      continue;
    }
    for (const auto& [folder, weight] : values.data) {
      std::map<std::string, std::string> by_name = values.values;
      by_name["data"] = folder;
      by_name["weight"] = weight;
      RETURN_IF_ERROR(expand(argument, by_name));
    }
  }
  return expanded;
}

namespace {

constexpr char kNotANumber[] = "not a number";

// JSON has no word for what a lost training tells of its loss; Python writes NaN and Infinity.
nlohmann::json ParseLenient(std::string line) {
  for (const std::string word : {"-Infinity", "Infinity", "NaN"}) {
    for (size_t at; (at = line.find(": " + word)) != std::string::npos;) {
      line.replace(at + 2, word.size(), std::string("\"") + kNotANumber + "\"");
    }
  }
  return nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
}

std::optional<TrainerProgress> ReadJsonProgress(const std::string& line) {
  const nlohmann::json json = ParseLenient(line);
  if (!json.is_object() || !json.contains("step") || !json["step"].is_number_integer())
    return std::nullopt;
  const auto number = [&](const char* key) -> std::optional<double> {
    if (!json.contains(key)) return std::nullopt;
    if (json[key] == kNotANumber) return std::numeric_limits<double>::quiet_NaN();
    if (!json[key].is_number()) return std::nullopt;
    return json[key].get<double>();
  };
  return TrainerProgress{.step = json["step"].get<int64_t>(),
                         .loss = number("loss"),
                         .epe_px = number("epe_px"),
                         .eta_s = number("eta_s")};
}

// The numbers in the groups of a match, by the groups' names.
TrainerProgress ProgressIn(const std::cmatch& match, const std::vector<std::string>& groups) {
  TrainerProgress progress;
  double epoch = 0, epoch_steps = 0;
  for (size_t i = 0; i < groups.size(); ++i) {
    const std::string &name = groups[i], text = match[i + 1];
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (end == text.c_str()) continue;
    if (name == "epoch") epoch = value;
    if (name == "epoch_steps") epoch_steps = value;
    if (name == "step") progress.step = static_cast<int64_t>(value);
    if (name == "loss") progress.loss = value;
    if (name == "epe_px") progress.epe_px = value;
    if (name == "eta_s") progress.eta_s = value;
  }
  if (progress.step) *progress.step += static_cast<int64_t>(epoch * epoch_steps);
  return progress;
}

}  // namespace

std::optional<TrainerProgress> ReadProgress(const TrainerContract& contract,
                                            const std::string& line) {
  if (contract.progress == ProgressFormat::kJsonLines) return ReadJsonProgress(line);
  const char* const begin = line.data();
  const char* const end = begin + std::min<std::ptrdiff_t>(std::ssize(line), kMostMatched);
  std::cmatch match;
  if (!std::regex_search(begin, end, match, *contract.progress_pattern)) return std::nullopt;
  return ProgressIn(match, contract.progress_groups);
}

}  // namespace parallax
