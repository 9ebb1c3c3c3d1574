#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>
#include <set>

#include "common/base/status.h"
#include "common/base/system/file.h"
#include "common/config/builtin.h"
#include "common/config/camera_settings.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/idle_fields.h"
#include "common/config/check/limits.h"
#include "common/config/check/rig_counts.h"
#include "common/config/config.h"
#include "common/config/defaults.h"
#include "common/config/training_plan.h"
#include "common/config/yaml/yaml_document.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax {
namespace {

using config_internal::ApplyDefaults;
using config_internal::BuiltinFile;
using config_internal::BuiltinFiles;
using config_internal::CheckConfig;
using config_internal::CheckIdleFields;
using config_internal::CheckStudy;
using config_internal::ConfigErrors;
using config_internal::Findings;
using config_internal::JoinNames;
using config_internal::MergeSceneConfig;
using config_internal::NearestName;
using config_internal::Origins;
using config_internal::ParseYaml;
using config_internal::YamlReader;

constexpr char kBuiltinPrefix[] = "builtin:";

const BuiltinFile* FindBuiltin(std::string_view name) {
  for (const BuiltinFile& file : BuiltinFiles()) {
    if (file.name == name) return &file;
  }
  return nullptr;
}

std::vector<std::string> BuiltinNames(std::string_view folder) {
  std::vector<std::string> names;
  for (const BuiltinFile& file : BuiltinFiles()) {
    if (file.name.substr(0, folder.size()) != folder) continue;
    names.push_back(std::filesystem::path(std::string(file.name)).stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

struct Text {
  std::string file;  // For messages.
  std::string text;
};

bool IsFile(const std::string& path) {
  std::error_code error;
  return std::filesystem::is_regular_file(path, error);
}

// The file at `path`, or the built-in `folder`/`name`.yaml when none exists.
absl::StatusOr<Text> ReadFileOrBuiltin(const std::string& path, const std::string& folder,
                                       const std::string& name) {
  if (IsFile(path)) {
    ASSIGN_OR_RETURN(std::string text, ReadFile(path, 4 << 20));
    return Text{path, std::move(text)};
  }
  const BuiltinFile* builtin = FindBuiltin(folder + "/" + name + ".yaml");
  if (builtin != nullptr) {
    return Text{kBuiltinPrefix + std::string(builtin->name), std::string(builtin->text)};
  }
  std::error_code error;
  const bool exists = std::filesystem::exists(path, error);
  return NotFound("{}{}, allowed is a path or a built-in name: {}", path,
                  exists ? ": not a file" : ": no such file", JoinNames(BuiltinNames(folder)));
}

v1::SceneConfig Defaults() {
  v1::SceneConfig config;
  ApplyDefaults(&config);
  return config;
}

// Reads a study's map and checks what it gives. The base's and the variants' trees are merged by
// the same reader, so that an error names the file and line where the value stands.
class StudyLoader {
 public:
  StudyLoader(std::string_view yaml, const std::string& file)
      : yaml_(yaml), reader_(file, &errors_) {}

  absl::StatusOr<v1::StudySpec> Load() {
    const std::optional<YAML::Node> root = ParseYaml(yaml_, reader_.file(), errors_);
    if (root && root->IsNull()) {
      errors_.Add({reader_.file(), 0, ""},
                  "nothing, allowed is a map of fields: those of a study (study, pairs, variants) "
                  "or of a scene config");
      return errors_.ToStatus();
    }
    if (root) ReadRoot(*root);
    spec_.set_source_yaml(std::string(yaml_));
    if (root) errors_.AddFindings(CheckStudy(spec_), origins_, reader_.file());
    if (!errors_.empty()) return errors_.ToStatus();
    std::sort(spec_.mutable_tags()->begin(), spec_.mutable_tags()->end());
    ResolveTraining(&spec_);
    return std::move(spec_);
  }

 private:
  void ReadRoot(const YAML::Node& root) {
    static const std::vector<std::string> kKnown = {
        "study", "base",      "seed",     "pairs", "rigs_per_scene", "priority",
        "tags",  "memory_mb", "variants", "train", "evaluate"};
    std::optional<YAML::Node> variants;
    std::set<std::string> seen;
    base_ = DefaultSceneConfig();
    spec_.set_seed(1);
    for (const auto& [name, node] : reader_.Entries(root, "")) {
      seen.insert(name);
      Note(node, name);
      if (name == "study") {
        if (const auto value = reader_.ReadText(node, name)) spec_.set_name(*value);
      } else if (name == "base") {
        ReadBase(node, "base", &base_, &base_origins_);
      } else if (name == "seed") {
        if (const auto value = reader_.ReadUint64(node, name)) spec_.set_seed(*value);
      } else if (name == "pairs") {
        if (const auto value = reader_.ReadInt(node, name, 1, kMaxPairs)) spec_.set_pairs(*value);
      } else if (name == "rigs_per_scene") {
        const auto value = reader_.ReadInt(node, name, 1, kMaxRigsPerScene);
        if (value) spec_.set_rigs_per_scene(static_cast<int32_t>(*value));
      } else if (name == "priority") {
        const auto value = reader_.ReadInt(node, name, -kMaxPriority, kMaxPriority);
        if (value) spec_.set_priority(static_cast<int32_t>(*value));
      } else if (name == "tags") {
        ReadTags(node);
      } else if (name == "memory_mb") {
        const auto value = reader_.ReadInt(node, name, 0, kMaxMemoryMb, "MB");
        if (value) spec_.set_memory_mb(*value);
      } else if (name == "variants") {
        variants = node;
      } else if (name == "train") {
        ReadPart(node, name, spec_.mutable_train());
      } else if (name == "evaluate") {
        ReadPart(node, name, spec_.mutable_evaluate());
      } else if (v1::SceneConfig::descriptor()->FindFieldByName(name) != nullptr) {
        reader_.Error(node, name,
                      "no field of a study but of its scenes, allowed is variants[].set." + name +
                          ", or the file that `base` names");
      } else {
        reader_.UnknownField(node, "", name, kKnown);
      }
    }
    if (!root.IsMap()) return;
    if (!seen.count("study")) reader_.Error(root, "study", "missing, allowed is the study's name");
    if (!seen.count("pairs")) {
      reader_.Error(root, "pairs",
                    "missing, allowed is the number of pairs of each variant, from 1");
    }
    if (variants) {
      ReadVariants(*variants);
    } else {
      reader_.Error(root, "variants", "missing, allowed is a list of at least one {name, set}");
    }
    if (!seen.count("rigs_per_scene")) FillInRigs();
  }

  void Note(const YAML::Node& node, const std::string& path) {
    origins_.Set(path, reader_.OriginOf(node, path));
  }

  // A part of the study that is a message with rules.
  void ReadPart(const YAML::Node& node, const std::string& path,
                google::protobuf::Message* message) {
    ApplyDefaults(message);
    Origins origins;
    reader_.Merge(node, message, path, &origins);
    origins_.SetBelow(path, origins);
  }

  // Reads the tags that a worker must have to get the study's jobs.
  void ReadTags(const YAML::Node& node) {
    if (!node.IsSequence()) {
      reader_.Error(node, "tags", "not a list, allowed is [a, b]");
      return;
    }
    for (size_t i = 0; i < node.size(); ++i) {
      const std::string path = fmt::format("tags[{}]", i);
      Note(node[i], path);
      spec_.add_tags(reader_.ReadText(node[i], path).value_or(""));
    }
  }

  void ReadBase(const YAML::Node& node, const std::string& path, v1::SceneConfig* base,
                Origins* origins) {
    const std::optional<std::string> named = reader_.ReadText(node, path);
    if (!named) return;
    const absl::StatusOr<Text> text = FindBase(*named);
    if (!text.ok()) {
      reader_.Error(node, path, ToStd(text.status().message()));
      return;
    }
    YamlReader base_reader(text->file, &errors_);
    const std::optional<YAML::Node> root = ParseYaml(text->text, text->file, errors_);
    if (!root || root->IsNull()) return;
    MergeSceneConfig(base_reader, *root, base, "", origins);
    Findings findings;  // Also of values that every variant replaces.
    CheckConfig(*base, "", &findings);
    errors_.AddFindings(findings, *origins, text->file);
  }

  absl::StatusOr<Text> FindBase(const std::string& named) const {
    const std::string& file = reader_.file();
    if (file.compare(0, sizeof(kBuiltinPrefix) - 1, kBuiltinPrefix) == 0) {
      const std::string name = std::filesystem::path(named).stem();
      return ReadFileOrBuiltin("", "scenes", name);
    }
    const std::filesystem::path path = std::filesystem::path(file).parent_path() / named;
    return ReadFileOrBuiltin(path.lexically_normal(), "scenes", named);
  }

  void ReadVariants(const YAML::Node& node) {
    if (!node.IsSequence()) {
      reader_.Error(node, "variants", "not a list, allowed is a list of at least one {name, set}");
    }
    // The entries of a map are checked nevertheless.
    for (auto entry = node.begin(); node.IsMap() && entry != node.end(); ++entry) {
      if (!entry->first.IsScalar() || !entry->second.IsMap()) continue;
      ReadVariant(entry->second, "variants." + entry->first.Scalar(), /*named=*/true);
    }
    for (size_t i = 0; node.IsSequence() && i < node.size(); ++i) {
      const std::string path = fmt::format("variants[{}]", i);
      Note(node[i], path);
      // Each is checked; more than these can only be too many.
      if (i > kMaxVariants) {
        spec_.add_variants();
      } else {
        ReadVariant(node[i], path, /*named=*/false);
      }
    }
  }

  // `named`: a name of its own may be absent.
  void ReadVariant(const YAML::Node& node, const std::string& path, bool named) {
    const std::string place = fmt::format("variants[{}]", spec_.variants_size());
    v1::VariantSpec& variant = *spec_.add_variants();
    v1::SceneConfig& config = *variant.mutable_config();
    config = base_;
    Origins origins = base_origins_;
    const auto entries = reader_.Entries(node, path);
    // First, wherever it stands: `set` is merged onto it.
    for (const auto& [name, value] : entries) {
      if (name != "base") continue;
      config = DefaultSceneConfig();
      origins = {};
      ReadBase(value, path + ".base", &config, &origins);
    }
    std::set<std::string> seen;
    for (const auto& [name, value] : entries) {
      seen.insert(name);
      const std::string field_path = path + "." + name;
      Note(value, field_path);
      if (name == "base") continue;
      if (name == "pairs") {
        if (const auto pairs = reader_.ReadInt(value, field_path, 1, kMaxPairs)) {
          variant.set_pairs(*pairs);
        }
      } else if (name == "rigs_per_scene") {
        if (const auto rigs = reader_.ReadInt(value, field_path, 1, kMaxRigsPerScene)) {
          variant.set_rigs_per_scene(static_cast<int32_t>(*rigs));
        }
      } else if (name == "name") {
        if (const auto text = reader_.ReadText(value, field_path)) variant.set_name(*text);
      } else if (name == "seed") {
        if (const auto seed = reader_.ReadUint64(value, field_path)) variant.set_seed(*seed);
      } else if (name == "heldout") {
        if (const auto heldout = reader_.ReadBool(value, field_path)) variant.set_heldout(*heldout);
      } else if (name == "set") {
        if (value.IsNull()) continue;
        MergeSceneConfig(reader_, value, &config, field_path, &origins);
        CheckIdleFields(reader_, value, field_path, config);
      } else if (name == "config") {
        config = DefaultSceneConfig();
        origins = {};
        if (!value.IsNull()) MergeSceneConfig(reader_, value, &config, field_path, &origins);
      } else {
        const std::vector<std::string> known = {"name", "base", "pairs",  "rigs_per_scene",
                                                "seed", "set",  "config", "heldout"};
        reader_.UnknownField(value, path, name, known);
        if (NearestName(name, known) == "set" && value.IsMap()) CheckMeantSet(value, path);
      }
    }
    if (seen.count("set") && seen.count("config")) {
      reader_.Error(node, path,
                    "both set and config, allowed is one: set is merged onto the base, config "
                    "stands alone");
    }
    if (!seen.count("name") && !named && node.IsMap()) {
      reader_.Error(node, path + ".name", "missing, allowed is a folder's name");
    }
    origins_.SetBelow(place + ".config", origins);
  }

  // Checks a value that was probably meant to be `set` as if it were.
  void CheckMeantSet(const YAML::Node& node, const std::string& path) {
    v1::SceneConfig scratch = base_;
    Origins origins = base_origins_;
    MergeSceneConfig(reader_, node, &scratch, path + ".set", &origins);
    Findings findings;
    CheckConfig(scratch, "", &findings);
    errors_.AddFindings(findings, origins, reader_.file());
  }

  // Absent: all rigs that every variant has.
  void FillInRigs() {
    int64_t fewest = std::numeric_limits<int32_t>::max();
    for (const v1::VariantSpec& variant : spec_.variants()) {
      if (variant.rigs_per_scene() > 0) continue;  // Has its own.
      fewest = std::min(fewest, PairsOfScene(variant.config().rigs()));
    }
    if (spec_.variants().empty()) return;
    const bool all_own = fewest == std::numeric_limits<int32_t>::max();
    spec_.set_rigs_per_scene(all_own ? spec_.variants(0).rigs_per_scene()
                                     : static_cast<int32_t>(fewest));
  }

  std::string_view yaml_;
  ConfigErrors errors_;
  YamlReader reader_;
  Origins origins_;
  v1::StudySpec spec_;
  v1::SceneConfig base_;
  Origins base_origins_;
};

}  // namespace

v1::SceneConfig DefaultSceneConfig() {
  static const v1::SceneConfig* config = new v1::SceneConfig(Defaults());
  return *config;
}

absl::StatusOr<v1::SceneConfig> ParseSceneConfig(std::string_view yaml,
                                                 std::string_view file_name) {
  ConfigErrors errors;
  YamlReader reader(std::string(file_name), &errors);
  v1::SceneConfig config = DefaultSceneConfig();
  const std::optional<YAML::Node> root = ParseYaml(yaml, reader.file(), errors);
  Origins origins;
  if (root && !root->IsNull()) MergeSceneConfig(reader, *root, &config, "", &origins);
  Findings findings;
  CheckConfig(config, "", &findings);
  errors.AddFindings(findings, origins, reader.file());
  if (errors.empty() && root) CheckIdleFields(reader, *root, "", config);
  if (!errors.empty()) return errors.ToStatus();
  return config;
}

absl::StatusOr<v1::SceneConfig> LoadSceneConfig(const std::string& path) {
  ASSIGN_OR_RETURN(const Text text, ReadFileOrBuiltin(path, "scenes", path));
  return ParseSceneConfig(text.text, text.file);
}

absl::StatusOr<v1::StudySpec> ParseStudy(std::string_view yaml, const std::string& file_name) {
  return StudyLoader(yaml, file_name).Load();
}

absl::StatusOr<v1::StudySpec> LoadStudy(const std::string& path) {
  ASSIGN_OR_RETURN(const Text text, ReadFileOrBuiltin(path, "studies", path));
  return ParseStudy(text.text, text.file);
}

absl::Status ValidateStudy(const v1::StudySpec& study) {
  return config_internal::ToStatus(CheckStudy(study));
}

int LineOfField(std::string_view yaml, std::string_view path) {
  ConfigErrors ignored;
  YAML::Node node = ParseYaml(yaml, "", ignored).value_or(YAML::Node());
  while (!path.empty()) {
    const std::string name(path.substr(0, path.find('.')));
    path.remove_prefix(std::min(name.size() + 1, path.size()));
    if (!node.IsMap() || !node[name]) return 0;
    node.reset(YAML::Node(node[name]));
  }
  return node.Mark().is_null() ? 0 : node.Mark().line + 1;
}

std::vector<std::string> BuiltinStudies() { return BuiltinNames("studies/"); }
std::vector<std::string> BuiltinSceneConfigs() { return BuiltinNames("scenes/"); }

absl::StatusOr<std::string> BuiltinConfigText(std::string_view name) {
  const BuiltinFile* file = FindBuiltin(name);
  if (file == nullptr) {
    return NotFound("no built-in config {}", name);
  }
  return std::string(file->text);
}

}  // namespace parallax
