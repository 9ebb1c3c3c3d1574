#include "common/config/study_loader.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <vector>

#include "common/base/edit_distance.h"
#include "common/base/names.h"
#include "common/config/camera_settings.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/idle_fields.h"
#include "common/config/check/limits.h"
#include "common/config/check/rig_counts.h"
#include "common/config/config.h"
#include "common/config/config_text.h"
#include "common/config/defaults.h"
#include "common/config/search/search_space.h"
#include "common/config/training_plan.h"
#include "common/config/yaml/yaml_document.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {
namespace {

constexpr double kHalfDegree = std::numbers::pi / 360;
constexpr double kMostVerticalFov_deg = 110;  // Limits pictures whose height is not given.
constexpr size_t kMostFiles = 10;             // In a row of studies that extend each other.
constexpr const char* kStudyFields[] = {
    "study", "extends",        "base",     "set",       "seed",     "pairs",  "priority", "tags",
    "train", "rigs_per_scene", "evaluate", "memory_mb", "variants", "stream", "search",   "notify"};

// One of the files that a study is read from.
struct StudyFile {
  std::string text;
  YamlReader reader;
  YAML::Node root;
  std::optional<YAML::Node> set;  // For all variants.
};

// A variant's entry in one file.
struct VariantPart {
  StudyFile* file;
  YAML::Node node;
  std::string path;
};

struct BaseConfig {
  v1::SceneConfig config = DefaultSceneConfig();
  Origins origins;
};

// Reads the files, from the last that `file` extends to `file` itself. Tells `errors` of what can't
// be read; the list is then shorter.
std::list<StudyFile> ReadFiles(std::string_view yaml, const std::string& file,
                               ConfigErrors& errors) {
  std::list<StudyFile> files;
  ConfigText next{file, std::string(yaml)};
  while (true) {
    const std::optional<YAML::Node> root =
        ParseYaml(next.text, next.file, errors, kMaxStudyFileBytes);
    if (!root) return files;
    files.push_front({next.text, YamlReader(next.file, &errors), *root, std::nullopt});
    StudyFile& read = files.front();
    if (root->IsNull()) {
      errors.Add({next.file, 0, ""},
                 "nothing, allowed is a map of fields: those of a study (study, pairs, variants) "
                 "or of a scene config");
    }
    if (!root->IsMap() || !(*root)["extends"]) return files;
    const YAML::Node extends = (*root)["extends"];
    const std::optional<std::string> named = read.reader.ReadText(extends, "extends");
    if (!named) return files;
    absl::StatusOr<ConfigText> extended = ReadNamedText(*named, next.file, "studies");
    if (!extended.ok()) {
      read.reader.Error(extends, "extends", ToStd(extended.status().message()));
      return files;
    }
    const bool again = std::any_of(files.begin(), files.end(), [&](const StudyFile& known) {
      return known.reader.file() == extended->file;
    });
    if (again || files.size() == kMostFiles) {
      read.reader.Error(extends, "extends",
                        Quoted(*named) + (again ? " extends this file itself, allowed is another"
                                                : fmt::format(" is one study more, allowed are {} "
                                                              "that extend each other",
                                                              kMostFiles)));
      return files;
    }
    next = *std::move(extended);
  }
}

// Reads a study's maps and checks what they give. Trees are merged by the readers of their files,
// so that an error names the file and line where the value is.
class StudyLoader {
 public:
  StudyLoader(std::string_view yaml, const std::string& file)
      : yaml_(yaml), file_(file), files_(ReadFiles(yaml, file, errors_)) {
    chain_is_whole_ = errors_.empty();
  }

  absl::StatusOr<v1::StudySpec> Load() {
    const bool readable = !files_.empty() && files_.back().reader.file() == file_;
    if (readable && files_.back().root.IsNull()) return errors_.ToStatus();
    spec_.set_seed(1);
    for (StudyFile& file : files_) ReadRoot(file);
    if (readable) Complete(files_.back());
    if (yaml_.size() <= kMaxYamlBytes) spec_.set_source_yaml(std::string(yaml_));
    if (readable) errors_.AddFindings(CheckStudy(spec_), origins_, file_);
    if (!errors_.empty()) return errors_.ToStatus();
    std::sort(spec_.mutable_tags()->begin(), spec_.mutable_tags()->end());
    ResolveTraining(&spec_);
    return std::move(spec_);
  }

 private:
  void ReadRoot(StudyFile& file) {
    YamlReader& reader = file.reader;
    std::optional<YAML::Node> variants;
    for (const auto& [name, node] : reader.Entries(file.root, "")) {
      const bool is_first = seen_.insert(name).second;
      origins_.Set(name, reader.OriginOf(node, name));
      if (name == "study") {
        if (const auto value = reader.ReadText(node, name)) spec_.set_name(*value);
      } else if (name == "extends") {
        continue;  // Read already.
      } else if (name == "base") {
        base_ = {};
        ReadBase(reader, node, name, &base_);
      } else if (name == "set") {
        if (!node.IsNull()) file.set = node;
      } else if (name == "seed") {
        if (const auto value = reader.ReadUint64(node, name)) spec_.set_seed(*value);
      } else if (name == "pairs") {
        ReadPairs(reader, node);
      } else if (name == "rigs_per_scene") {
        const auto value = reader.ReadInt(node, name, 1, kMaxRigsPerScene);
        if (value) spec_.set_rigs_per_scene(static_cast<int32_t>(*value));
      } else if (name == "priority") {
        const auto value = reader.ReadInt(node, name, -kMaxPriority, kMaxPriority);
        if (value) spec_.set_priority(static_cast<int32_t>(*value));
      } else if (name == "tags") {
        ReadTags(reader, node);
      } else if (name == "memory_mb") {
        const auto value = reader.ReadInt(node, name, 0, kMaxMemoryMb, "MB");
        if (value) spec_.set_memory_mb(*value);
      } else if (name == "variants") {
        variants = node;
      } else if (name == "stream") {
        if (is_first) ApplyDefaults(&stream_);
        ReadPart(reader, node, name, &stream_);
      } else if (name == "search") {
        ReadSearch(reader, node, &search_, &search_origins_);
        origins_.SetBelow(name, search_origins_);
      } else if (name == "train") {
        if (is_first) ApplyDefaults(spec_.mutable_train());
        ReadPart(reader, node, name, spec_.mutable_train());
      } else if (name == "evaluate") {
        if (is_first) ApplyDefaults(spec_.mutable_evaluate());
        ReadPart(reader, node, name, spec_.mutable_evaluate());
      } else if (name == "notify") {
        ReadNotify(file, node);
      } else if (v1::SceneConfig::descriptor()->FindFieldByName(name) != nullptr) {
        reader.Error(node, name,
                     "no field of a study but of its scenes, allowed is set." + name +
                         ", variants[].set." + name + ", or the file that `base` names");
      } else {
        reader.UnknownField(node, "", name, {std::begin(kStudyFields), std::end(kStudyFields)});
      }
    }
    // After `base`, wherever it is.
    if (file.set) CheckMeantSet(file, *file.set, "set");
    if (variants) ReadVariants(file, *variants);
  }

  // A number, or `endless`.
  void ReadPairs(YamlReader& reader, const YAML::Node& node) {
    is_endless_ = node.IsScalar() && node.Scalar() == "endless";
    if (is_endless_) return;
    if (const auto value = reader.ReadInt(node, "pairs", 1, kMaxPairs)) spec_.set_pairs(*value);
  }

  // `stream` counts where the pairs are endless. A study with a number of pairs may extend one that
  // is endless, but says nothing of streams itself.
  void ResolveStream(StudyFile& own) {
    if (is_endless_) {
      if (seen_.count("stream") == 0) ApplyDefaults(&stream_);
      spec_.set_pairs(stream_.chunk_pairs());
      *spec_.mutable_stream() = stream_;
    } else if (own.root.IsMap() && own.root["stream"]) {
      own.reader.Error(own.root["stream"], "stream",
                       "beside a number of pairs, allowed only with `pairs: endless`");
    }
  }

  // `search` counts unless the study's own file names variants: it then is a study of its own, such
  // as that of a search's best trial. Without any, the base and `set` are the only variant.
  void ResolveSearch(StudyFile& own) {
    if (seen_.count("search") == 0 || !own.root.IsMap()) return;
    if (own.root["variants"] && !own.root["search"]) return;
    ApplyDefaults(&search_);
    *spec_.mutable_search() = search_;
    if (!seen_.insert("variants").second) return;
    ResolveVariant({}, "variants[0]");
    spec_.mutable_variants(0)->set_name(kDefaultVariant);
  }

  // Merges what the files say, and tells `own`, the study's own file, what is missing.
  void Complete(StudyFile& own) {
    for (size_t i = 0; i < variants_.size(); ++i) {
      ResolveVariant(variants_[i], fmt::format("variants[{}]", i));
    }
    ResolveSearch(own);
    CheckIdleSets();
    ResolveStream(own);
    if (!own.root.IsMap() || !chain_is_whole_) return;
    FillInPairs();
    const struct {
      const char* field;
      const char* what;
    } needed[] = {
        {"study", "missing, allowed is the study's name"},
        {"pairs", "missing, allowed is the number of pairs of each variant, from 1, or endless"},
        {"variants", "missing, allowed is a list of at least one {name, set}"}};
    for (const auto& [field, what] : needed) {
      if (seen_.count(field) == 0) own.reader.Error(own.root, field, what);
    }
    if (seen_.count("rigs_per_scene") == 0) FillInRigs();
  }

  // A part of the study that is a message with rules.
  void ReadPart(YamlReader& reader, const YAML::Node& node, const std::string& path,
                google::protobuf::Message* message) {
    Origins origins;
    reader.Merge(node, message, path, &origins);
    origins_.SetBelow(path, origins);
  }

  // The address may be a secret: where the text is shown to others, it is sought and cut out.
  void ReadNotify(StudyFile& file, const YAML::Node& node) {
    ReadPart(file.reader, node, "notify", spec_.mutable_notify());
    if (!node.IsMap() || !node["url"]) return;  // As an earlier file gives it.
    if (file.text.find(spec_.notify().url()) != std::string::npos) return;
    file.reader.Error(node, "notify.url", "written with escapes, allowed is the address as it is");
  }

  // Reads the tags that a worker must have to get the study's jobs.
  void ReadTags(YamlReader& reader, const YAML::Node& node) {
    if (!node.IsSequence()) {
      reader.Error(node, "tags", "not a list, allowed is [a, b]");
      return;
    }
    spec_.clear_tags();
    for (size_t i = 0; i < node.size(); ++i) {
      const std::string path = fmt::format("tags[{}]", i);
      origins_.Set(path, reader.OriginOf(node[i], path));
      spec_.add_tags(reader.ReadText(node[i], path).value_or(""));
    }
  }

  void ReadBase(YamlReader& reader, const YAML::Node& node, const std::string& path,
                BaseConfig* base) {
    const std::optional<std::string> named = reader.ReadText(node, path);
    if (!named) return;
    const absl::StatusOr<ConfigText> text = ReadNamedText(*named, reader.file(), "scenes");
    if (!text.ok()) {
      reader.Error(node, path, ToStd(text.status().message()));
      return;
    }
    YamlReader base_reader(text->file, &errors_);
    const std::optional<YAML::Node> root = ParseYaml(text->text, text->file, errors_);
    if (!root || root->IsNull()) return;
    MergeSceneConfig(base_reader, *root, &base->config, "", &base->origins);
    Findings findings;  // Also of values that every variant replaces.
    CheckConfig(base->config, "", &findings);
    errors_.AddFindings(findings, base->origins, text->file);
  }

  // Checks each value of a map as if it were the `set` at `path`, whatever variants add to it.
  void CheckMeantSet(StudyFile& file, const YAML::Node& node, const std::string& path) {
    BaseConfig scratch = base_;
    MergeSceneConfig(file.reader, node, &scratch.config, path, &scratch.origins);
    Findings findings;
    CheckFields(scratch.config, "", &findings);
    errors_.AddFindings(findings, scratch.origins, file_);
  }

  void ReadVariants(StudyFile& file, const YAML::Node& node) {
    const size_t of_others = variants_.size();
    if (!node.IsSequence()) {
      file.reader.Error(node, "variants",
                        "not a list, allowed is a list of at least one {name, set}");
    }
    // The entries of a map are checked nevertheless.
    for (auto entry = node.begin(); node.IsMap() && entry != node.end(); ++entry) {
      if (!entry->first.IsScalar() || !entry->second.IsMap()) continue;
      variants_.push_back({{&file, entry->second, "variants." + entry->first.Scalar()}});
    }
    for (size_t i = 0; node.IsSequence() && i < node.size(); ++i) {
      const VariantPart part{&file, node[i], fmt::format("variants[{}]", i)};
      if (!node[i].IsMap() || !node[i]["name"]) {
        if (node[i].IsMap()) {
          file.reader.Error(node[i], part.path + ".name", "missing, allowed is a folder's name");
        }
        variants_.push_back({part});
        continue;
      }
      const auto known = std::find_if(
          variants_.begin(), variants_.begin() + static_cast<ptrdiff_t>(of_others),
          [&](const std::vector<VariantPart>& variant) {
            const YAML::Node& first = variant.front().node;
            return first.IsMap() && first["name"] && node[i]["name"].IsScalar() &&
                   first["name"].IsScalar() && first["name"].Scalar() == node[i]["name"].Scalar();
          });
      if (known == variants_.begin() + static_cast<ptrdiff_t>(of_others)) {
        variants_.push_back({part});
      } else {
        known->push_back(part);
      }
    }
    // The pairs that are held out follow from the rest.
    if (&file == &files_.back()) return;
    std::erase_if(variants_, [](const std::vector<VariantPart>& variant) {
      const YAML::Node& node = variant.front().node;
      return node.IsMap() && node["heldout"] && node["heldout"].IsScalar() &&
             node["heldout"].Scalar() == "true";
    });
  }

  // Merges the parts of a variant, which becomes the study's at `place`.
  void ResolveVariant(const std::vector<VariantPart>& parts, const std::string& place) {
    v1::VariantSpec& variant = *spec_.add_variants();
    // Each is checked; more than these can only be too many.
    if (spec_.variants_size() > kMaxVariants + 1) return;
    BaseConfig merged = base_;
    // First, wherever it is: each `set` is merged onto it.
    for (const VariantPart& part : parts) {
      if (!part.node.IsMap() || !part.node["base"]) continue;
      merged = {};
      ReadBase(part.file->reader, part.node["base"], part.path + ".base", &merged);
    }
    for (StudyFile& file : files_) {
      if (file.set) {
        MergeSceneConfig(file.reader, *file.set, &merged.config, "set", &merged.origins);
        NoteIdle(file, merged.config);
      }
      for (const VariantPart& part : parts) {
        if (part.file == &file) ReadVariant(part, place, &variant, &merged);
      }
    }
    CheckShape(merged);
    *variant.mutable_config() = std::move(merged.config);
    origins_.SetBelow(place + ".config", merged.origins);
  }

  void ReadVariant(const VariantPart& part, const std::string& place, v1::VariantSpec* variant,
                   BaseConfig* merged) {
    YamlReader& reader = part.file->reader;
    // Entries of a map have no place in the list that there should be.
    if (part.path.ends_with(']')) origins_.Set(place, reader.OriginOf(part.node, part.path));
    std::set<std::string> seen;
    for (const auto& [name, value] : reader.Entries(part.node, part.path)) {
      seen.insert(name);
      const std::string path = part.path + "." + name;
      origins_.Set(place + "." + name, reader.OriginOf(value, path));
      if (name == "base") continue;
      if (name == "pairs") {
        if (const auto pairs = reader.ReadInt(value, path, 1, kMaxPairs)) {
          variant->set_pairs(*pairs);
        }
      } else if (name == "rigs_per_scene") {
        if (const auto rigs = reader.ReadInt(value, path, 1, kMaxRigsPerScene)) {
          variant->set_rigs_per_scene(static_cast<int32_t>(*rigs));
        }
      } else if (name == "name") {
        if (const auto text = reader.ReadText(value, path)) variant->set_name(*text);
      } else if (name == "seed") {
        if (const auto seed = reader.ReadUint64(value, path)) variant->set_seed(*seed);
      } else if (name == "heldout") {
        if (const auto heldout = reader.ReadBool(value, path)) variant->set_heldout(*heldout);
      } else if (name == "set") {
        if (value.IsNull()) continue;
        MergeSceneConfig(reader, value, &merged->config, path, &merged->origins);
        CheckIdleFields(reader, value, path, merged->config);
      } else if (name == "config") {
        *merged = {};
        if (!value.IsNull()) {
          MergeSceneConfig(reader, value, &merged->config, path, &merged->origins);
        }
      } else if (v1::SceneConfig::descriptor()->FindFieldByName(name) != nullptr) {
        reader.Error(
            value, path,
            "no field of a variant but of its scenes, allowed is " + part.path + ".set." + name);
      } else {
        const std::vector<std::string> known = {"name", "base", "pairs",  "rigs_per_scene",
                                                "seed", "set",  "config", "heldout"};
        reader.UnknownField(value, part.path, name, known);
        if (NearestName(name, known) == "set" && value.IsMap()) {
          CheckMeantSet(*part.file, value, part.path + ".set");
        }
      }
    }
    if (seen.count("set") > 0 && seen.count("config") > 0) {
      reader.Error(part.node, part.path,
                   "both set and config, allowed is one: set is merged onto the base, config "
                   "stands alone");
    }
  }

  // A width alone changes the picture's shape: the height has its default.
  void CheckShape(const BaseConfig& merged) {
    const v1::RigConfig& rigs = merged.config.rigs();
    const v1::RigConfig usual = DefaultSceneConfig().rigs();
    bool width_is_given = false, height_is_given = false;
    const auto width = merged.origins.Find("rigs.width_px", &width_is_given);
    merged.origins.Find("rigs.height_px", &height_is_given);
    if (rigs.has_camera() || !width_is_given || height_is_given || rigs.width_px() <= 0) return;
    const double half_width = std::tan(SupportOf(rigs.horizontal_fov_deg()).high * kHalfDegree);
    const double fov_deg = std::atan(half_width * rigs.height_px() / rigs.width_px()) / kHalfDegree;
    if (fov_deg <= kMostVerticalFov_deg) return;
    errors_.Add(*width,
                fmt::format("{} px alone makes pictures of {} x {} px, up to {:.0f} degrees "
                            "high, allowed are both sides: height_px: {} keeps the shape",
                            rigs.width_px(), rigs.width_px(), rigs.height_px(), fov_deg,
                            rigs.width_px() * usual.height_px() / usual.width_px()));
  }

  // A field of the `set` for all variants is idle if it is so in each.
  void NoteIdle(StudyFile& file, const v1::SceneConfig& merged) {
    ConfigErrors idle;
    YamlReader reader(file.reader.file(), &idle);
    CheckIdleFields(reader, *file.set, "set", merged);
    bool& used = is_used_[&file];
    used = used || idle.empty();
    last_merged_ = merged;
  }

  void CheckIdleSets() {
    for (StudyFile& file : files_) {
      if (!file.set || spec_.variants().empty() || is_used_[&file]) continue;
      CheckIdleFields(file.reader, *file.set, "set", last_merged_);
    }
  }

  // Absent, and each variant has its own: as many as the largest has.
  void FillInPairs() {
    int64_t most = 0;
    for (const v1::VariantSpec& variant : spec_.variants()) {
      if (variant.pairs() == 0) return;
      most = std::max(most, variant.pairs());
    }
    if (most > 0 && seen_.insert("pairs").second) spec_.set_pairs(most);
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

  const std::string_view yaml_;
  const std::string file_;
  ConfigErrors errors_;
  std::list<StudyFile> files_;
  bool chain_is_whole_ = true;  // All files that extend each other could be read.
  std::vector<std::vector<VariantPart>> variants_;  // The parts of each, in the order of files.
  std::set<std::string> seen_;                      // Fields that some file gives.
  std::map<const StudyFile*, bool> is_used_;        // Some variant uses all of the file's `set`.
  v1::SceneConfig last_merged_;
  Origins origins_;
  v1::StudySpec spec_;
  bool is_endless_ = false;
  v1::StreamSpec stream_;
  v1::SearchSpec search_;
  Origins search_origins_;
  BaseConfig base_;
};

}  // namespace

absl::StatusOr<v1::StudySpec> ReadStudy(std::string_view yaml, const std::string& file) {
  return StudyLoader(yaml, file).Load();
}

bool IsStudyText(std::string_view yaml) {
  ConfigErrors ignored;
  const std::optional<YAML::Node> root = ParseYaml(yaml, "", ignored, kMaxStudyFileBytes);
  if (!root || !root->IsMap()) return true;
  const google::protobuf::Descriptor& scene = *v1::SceneConfig::descriptor();
  return std::any_of(std::begin(kStudyFields), std::end(kStudyFields), [&](const char* field) {
    return (*root)[field] && scene.FindFieldByName(field) == nullptr;
  });
}

std::string PlaceOf(std::string_view yaml, const std::string& file, std::string_view path) {
  ConfigErrors ignored;
  std::list<StudyFile> files = ReadFiles(yaml, file, ignored);
  for (auto read = files.rbegin(); read != files.rend(); ++read) {
    YAML::Node node = read->root;
    std::string_view rest = path;
    while (!rest.empty() && node.IsMap()) {
      const std::string name(rest.substr(0, rest.find('.')));
      rest.remove_prefix(std::min(name.size() + 1, rest.size()));
      node.reset(node[name] ? YAML::Node(node[name]) : YAML::Node());
    }
    if (!rest.empty() || node.Mark().is_null()) continue;
    return fmt::format("{}:{}", read->reader.file(), node.Mark().line + 1);
  }
  return file;
}

}  // namespace parallax::config_internal
