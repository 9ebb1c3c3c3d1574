#include "common/config/search/search_values.h"

#include <cmath>
#include <optional>

#include "common/config/camera_settings.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/yaml/yaml_document.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax {

using config_internal::ConfigErrors;
using config_internal::Dotted;
using config_internal::Findings;
using config_internal::YamlReader;

namespace {

// Puts `value` at `path` into a tree of maps.
void PutAt(YAML::Node tree, std::string_view path, const YAML::Node& value) {
  const size_t dot = path.find('.');
  const std::string name(path.substr(0, dot));
  if (dot == std::string_view::npos) {
    tree[name] = value;
    return;
  }
  if (!tree[name] || !tree[name].IsMap()) tree[name] = YAML::Node(YAML::NodeType::Map);
  PutAt(tree[name], path.substr(dot + 1), value);
}

// Tells of fields that name files: a trial is made where they may not be.
void RefuseFiles(const YAML::Node& node, const google::protobuf::Descriptor& type,
                 const std::string& path, YamlReader& reader) {
  for (const YAML::Node& item : node.IsSequence() ? node : YAML::Node()) {
    RefuseFiles(item, type, path, reader);
  }
  if (!node.IsMap()) return;
  for (const auto& entry : node) {
    if (!entry.first.IsScalar()) continue;
    const auto* field = config_internal::FindKey(type, entry.first.Scalar());
    if (field == nullptr) continue;
    const std::string place = Dotted(path, field->name());
    const v1::FieldRule& rule = config_internal::RuleOf(*field);
    if (rule.stage() == v1::FieldRule::PLACE && rule.allowed().empty()) {
      reader.Error(entry.second, place, "names files, allowed in a search are other fields");
    } else if (field->message_type() != nullptr) {
      RefuseFiles(entry.second, *field->message_type(), place, reader);
    }
  }
}

}  // namespace

absl::StatusOr<v1::SceneConfig> WithSearchValues(
    const v1::SceneConfig& base,
    const google::protobuf::RepeatedPtrField<v1::SearchValue>& values) {
  ConfigErrors errors;
  YamlReader reader("", &errors);
  YAML::Node tree(YAML::NodeType::Map);
  for (const v1::SearchValue& value : values) {
    const std::optional<YAML::Node> node = config_internal::ParseYaml(value.yaml(), "", errors);
    if (node) PutAt(tree, value.path(), *node);
  }
  RefuseFiles(tree, *v1::SceneConfig::descriptor(), "", reader);
  if (!errors.empty()) return errors.ToStatus();
  v1::SceneConfig config = base;
  config_internal::MergeSceneConfig(reader, tree, &config, "", nullptr);
  Findings findings;
  config_internal::CheckConfig(config, "", &findings);
  errors.AddFindings(findings, config_internal::Origins(), "");
  if (!errors.empty()) return errors.ToStatus();
  return config;
}

int64_t PointsOfSpace(const v1::SearchSpec& search, int64_t most) {
  double points = 1;
  for (const v1::SearchField& field : search.space()) {
    points *= !field.choices().empty() ? field.choices_size()
              : field.integer()        ? field.high() - field.low() + 1
                                       : static_cast<double>(most);
  }
  return points < static_cast<double>(most) ? static_cast<int64_t>(points) : most;
}

std::string SearchNumberText(const v1::SearchField& field, double value) {
  return config_internal::NumberText(field.integer() ? std::round(value) : value);
}

}  // namespace parallax
