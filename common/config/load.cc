#include <algorithm>
#include <filesystem>
#include <limits>
#include <set>

#include "common/base/file.h"
#include "common/config/builtin.h"
#include "common/config/config.h"
#include "common/config/defaults.h"
#include "common/config/field_rules.h"
#include "common/config/yaml_reader.h"

namespace parallax {
namespace {

using config_internal::ApplyDefaults;
using config_internal::BuiltinFile;
using config_internal::BuiltinFiles;
using config_internal::ConfigErrors;
using config_internal::JoinNames;
using config_internal::NearestName;
using config_internal::YamlReader;

constexpr char kBuiltinPrefix[] = "builtin:";
constexpr int kMostPairs = 100'000'000;
constexpr int64_t kMostMemoryMb = int64_t{1} << 30;
constexpr size_t kMostTags = 32;

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

// The file at `path`, or the built-in `folder`/`name`.yaml when there is none.
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
  return MakeError(
      absl::StatusCode::kNotFound,
      path + (exists ? ": not a file" : ": no such file") +
          ", allowed is a path or a built-in name: " + JoinNames(BuiltinNames(folder)));
}

v1::SceneConfig Defaults() {
  v1::SceneConfig config;
  ApplyDefaults(&config);
  return config;
}

// Reads a study's map. The base's and the variants' trees are merged by the same reader, so that an
// error names the file and line where the value stands.
class StudyLoader {
 public:
  StudyLoader(std::string_view yaml, const std::string& file)
      : yaml_(yaml), reader_(file, &errors_) {}

  absl::StatusOr<v1::StudySpec> Load() {
    const std::optional<YAML::Node> root = reader_.Parse(yaml_);
    if (root) ReadRoot(*root);
    if (!errors_.empty()) return errors_.ToStatus();
    spec_.set_source_yaml(std::string(yaml_));
    return std::move(spec_);
  }

 private:
  void ReadRoot(const YAML::Node& root) {
    static const std::vector<std::string> kKnown = {"study", "base",           "seed",
                                                    "pairs", "rigs_per_scene", "priority",
                                                    "tags",  "memory_mb",      "variants"};
    YAML::Node variants, rigs_per_scene;
    std::set<std::string> seen;
    v1::SceneConfig base = DefaultSceneConfig();
    spec_.set_seed(1);
    for (const auto& [name, node] : reader_.Entries(root, "")) {
      seen.insert(name);
      if (name == "study") {
        if (const auto value = reader_.ReadName(node, name)) spec_.set_name(*value);
      } else if (name == "base") {
        ReadBase(node, "base", &base);
      } else if (name == "seed") {
        if (const auto value = reader_.ReadUint64(node, name)) spec_.set_seed(*value);
      } else if (name == "pairs") {
        if (const auto value = reader_.ReadInt(node, name, 1, kMostPairs)) spec_.set_pairs(*value);
      } else if (name == "rigs_per_scene") {
        rigs_per_scene = node;
        const auto value = reader_.ReadInt(node, name, 1, 1000);
        if (value) spec_.set_rigs_per_scene(static_cast<int32_t>(*value));
      } else if (name == "priority") {
        const auto value = reader_.ReadInt(node, name, -1000, 1000);
        if (value) spec_.set_priority(static_cast<int32_t>(*value));
      } else if (name == "tags") {
        ReadTags(node);
      } else if (name == "memory_mb") {
        const auto value = reader_.ReadInt(node, name, 0, kMostMemoryMb, "MB");
        if (value) spec_.set_memory_mb(*value);
      } else if (name == "variants") {
        variants = node;
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
    if (!seen.count("variants")) {
      reader_.Error(root, "variants", "missing, allowed is a list of at least one {name, set}");
    } else {
      ReadVariants(variants, base);
    }
    CheckRigs(seen.count("rigs_per_scene") > 0 ? &rigs_per_scene : nullptr);
  }

  // What a worker must have to get the study's jobs.
  void ReadTags(const YAML::Node& node) {
    if (!node.IsSequence() || node.size() > kMostTags) {
      reader_.Error(node, "tags",
                    "not a list of at most " + std::to_string(kMostTags) + ", allowed is [a, b]");
      return;
    }
    std::set<std::string> tags;
    for (size_t i = 0; i < node.size(); ++i) {
      const std::string path = "tags[" + std::to_string(i) + "]";
      const auto tag = reader_.ReadName(node[i], path);
      if (tag && !tags.insert(*tag).second) {
        reader_.Error(node[i], path, "\"" + *tag + "\" is there already, allowed is each tag once");
      }
    }
    for (const std::string& tag : tags) spec_.add_tags(tag);
  }

  void ReadBase(const YAML::Node& node, const std::string& path, v1::SceneConfig* base) {
    const std::optional<std::string> named = reader_.ReadText(node, path);
    if (!named) return;
    const absl::StatusOr<Text> text = FindBase(*named);
    if (!text.ok()) {
      reader_.Error(node, path, ToStd(text.status().message()));
      return;
    }
    YamlReader base_reader(text->file, &errors_);
    const std::optional<YAML::Node> root = base_reader.Parse(text->text);
    if (root && !root->IsNull()) base_reader.Merge(*root, base, "");
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

  void ReadVariants(const YAML::Node& node, const v1::SceneConfig& base) {
    if (!node.IsSequence() || node.size() == 0) {
      reader_.Error(node, "variants",
                    std::string(node.IsSequence() ? "an empty list" : "not a list") +
                        ", allowed is a list of at least one {name, set}");
    }
    for (size_t i = 0; node.IsSequence() && i < node.size(); ++i) {
      ReadVariant(node[i], "variants[" + std::to_string(i) + "]", /*named=*/false, base);
    }
    // Told above; what stands in it is checked nevertheless.
    for (auto entry = node.begin(); node.IsMap() && entry != node.end(); ++entry) {
      if (!entry->first.IsScalar() || !entry->second.IsMap()) continue;
      ReadVariant(entry->second, "variants." + entry->first.Scalar(), /*named=*/true, base);
    }
  }

  // `named`: a name of its own may be absent.
  void ReadVariant(const YAML::Node& node, const std::string& path, bool named,
                   const v1::SceneConfig& base) {
    v1::VariantSpec variant;
    bool has_name = named, has_set = false, has_config = false;
    *variant.mutable_config() = base;
    const auto entries = reader_.Entries(node, path);
    // First, wherever it stands: `set` is merged onto it.
    for (const auto& [name, value] : entries) {
      if (name != "base") continue;
      *variant.mutable_config() = DefaultSceneConfig();
      ReadBase(value, path + ".base", variant.mutable_config());
    }
    for (const auto& [name, value] : entries) {
      const std::string field_path = path + "." + name;
      if (name == "base") continue;
      if (name == "pairs") {
        if (const auto pairs = reader_.ReadInt(value, field_path, 1, kMostPairs)) {
          variant.set_pairs(*pairs);
        }
      } else if (name == "rigs_per_scene") {
        if (const auto rigs = reader_.ReadInt(value, field_path, 1, 1000)) {
          variant.set_rigs_per_scene(static_cast<int32_t>(*rigs));
          rigs_nodes_.emplace_back(spec_.variants_size(), value);
        }
      } else if (name == "name") {
        has_name = true;
        const auto text = reader_.ReadName(value, field_path);
        if (text) variant.set_name(*text);
        if (text && !names_.insert(*text).second) {
          reader_.Error(
              value, field_path,
              "\"" + *text + "\" names another variant too, allowed is a name of its own");
        }
      } else if (name == "set") {
        has_set = true;
        if (!value.IsNull()) reader_.Merge(value, variant.mutable_config(), field_path);
      } else if (name == "config") {
        has_config = true;
        *variant.mutable_config() = DefaultSceneConfig();
        if (!value.IsNull()) reader_.Merge(value, variant.mutable_config(), field_path);
      } else {
        const std::vector<std::string> known = {"name",           "base", "pairs",
                                                "rigs_per_scene", "set",  "config"};
        reader_.UnknownField(value, path, name, known);
        // What was probably meant is checked nevertheless.
        v1::SceneConfig scratch = base;
        if (NearestName(name, known) == "set" && value.IsMap()) {
          reader_.Merge(value, &scratch, path + ".set");
        }
      }
    }
    if (has_set && has_config) {
      reader_.Error(node, path,
                    "both set and config, allowed is one: set is merged onto the base, config "
                    "stands alone");
    }
    if (!has_name && node.IsMap()) {
      reader_.Error(node, path + ".name", "missing, allowed is a folder's name");
    }
    *spec_.add_variants() = std::move(variant);
  }

  // rigs_per_scene against what each variant's scenes have; all of them when it is absent.
  void CheckRigs(const YAML::Node* node) {
    int32_t fewest = std::numeric_limits<int32_t>::max();
    for (const v1::VariantSpec& variant : spec_.variants()) {
      if (variant.rigs_per_scene() > 0) continue;  // Has its own.
      const int32_t count = variant.config().rigs().count();
      fewest = std::min(fewest, count);
      if (node != nullptr && spec_.rigs_per_scene() > count) {
        reader_.Error(*node, "rigs_per_scene",
                      std::to_string(spec_.rigs_per_scene()) + " is more than variant \"" +
                          variant.name() +
                          "\" has, allowed 1 to rigs.count = " + std::to_string(count));
      }
    }
    for (const auto& [index, own] : rigs_nodes_) {
      const v1::VariantSpec& variant = spec_.variants(index);
      const int32_t count = variant.config().rigs().count();
      if (variant.rigs_per_scene() > count) {
        reader_.Error(own, "variants[" + std::to_string(index) + "].rigs_per_scene",
                      std::to_string(variant.rigs_per_scene()) +
                          " is more than the variant has, allowed 1 to rigs.count = " +
                          std::to_string(count));
      }
    }
    if (node == nullptr && !spec_.variants().empty()) {
      const bool all_own = fewest == std::numeric_limits<int32_t>::max();
      spec_.set_rigs_per_scene(all_own ? spec_.variants(0).rigs_per_scene() : fewest);
    }
  }

  std::string_view yaml_;
  ConfigErrors errors_;
  YamlReader reader_;
  v1::StudySpec spec_;
  std::set<std::string> names_;                         // Of variants.
  std::vector<std::pair<int, YAML::Node>> rigs_nodes_;  // Of variants with rigs_per_scene.
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
  const std::optional<YAML::Node> root = reader.Parse(yaml);
  if (root && !root->IsNull()) reader.Merge(*root, &config, "");
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
  return ParseStudy(StudyToYaml(study), "study").status();
}

std::vector<std::string> BuiltinStudies() { return BuiltinNames("studies/"); }
std::vector<std::string> BuiltinSceneConfigs() { return BuiltinNames("scenes/"); }

absl::StatusOr<std::string> BuiltinConfigText(std::string_view name) {
  const BuiltinFile* file = FindBuiltin(name);
  if (file == nullptr) {
    return MakeError(absl::StatusCode::kNotFound, "no built-in config " + std::string(name));
  }
  return std::string(file->text);
}

}  // namespace parallax
