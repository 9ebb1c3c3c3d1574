#include "common/config/yaml/yaml_reader.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/edit_distance.h"
#include "common/config/catalogue_names.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/config_text.h"
#include "common/config/sensor_presets.h"
#include "common/config/yaml/yaml_distribution.h"

namespace parallax::config_internal {
namespace {

using google::protobuf::EnumValueDescriptor;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

void ForbidAll(v1::BiomeWeights* weights) {
  const google::protobuf::Descriptor& type = *weights->GetDescriptor();
  for (int i = 0; i < type.field_count(); ++i) {
    weights->GetReflection()->SetDouble(weights, type.field(i), 0);
  }
}

}  // namespace

bool NamesAny(const YAML::Node& weights) {
  if (!weights.IsMap()) return false;
  return std::any_of(weights.begin(), weights.end(),
                     [](const auto& entry) { return PlainNumber(entry.second).value_or(0) > 0; });
}

void YamlReader::Note(const YAML::Node& node, const std::string& path) {
  if (origins_ != nullptr) origins_->Set(path.substr(prefix_), OriginOf(node, path));
}

void YamlReader::Merge(const YAML::Node& node, Message* message, const std::string& path,
                       Origins* origins) {
  origins_ = origins;
  prefix_ = path.empty() ? 0 : path.size() + 1;
  MergeFields(node, message, path);
  origins_ = nullptr;
}

void YamlReader::MergeFields(const YAML::Node& node, Message* message, const std::string& path) {
  const auto& type = *message->GetDescriptor();
  if (auto* sensor = dynamic_cast<v1::SensorConfig*>(message); sensor != nullptr && node.IsMap()) {
    // Before the fields beside it, wherever it is among them.
    if (const YAML::Node preset = node["preset"]; preset && preset.IsScalar()) {
      TakeSensorPreset(preset.Scalar(), sensor);
    }
  }
  const OwnFiles* const own = node.IsMap() ? OwnFiles::Of(type) : nullptr;
  const bool has_files = own != nullptr && ReadOwnFiles(node, path, *own, *message);
  if (auto* nature = dynamic_cast<v1::NatureConfig*>(message); nature != nullptr && node.IsMap()) {
    ReadOwnWeights(node, path, *nature);
  }
  const bool weights = &type == v1::BiomeWeights::descriptor();
  for (const auto& [name, value] : Entries(node, path)) {
    if (errors().enough()) return;
    if (has_files && name == own->content) continue;
    if (const FieldDescriptor* field = FindKey(type, name)) {
      Set(value, Dotted(path, name), *field, message);
      continue;
    }
    std::vector<std::string> known = FieldNames(type);
    if (weights) {
      if (std::count(own_biomes_.begin(), own_biomes_.end(), name) > 0) continue;
      known.insert(known.end(), own_biomes_.begin(), own_biomes_.end());
    }
    UnknownField(value, path, name, known);
    const std::string meant = NearestName(name, known);
    if (type.FindFieldByName(meant) != nullptr) {
      CheckMeant(value, path, meant, *message);
    }
  }
  if (own != nullptr) {  // Files are their content now.
    message->GetReflection()->ClearField(message, type.FindFieldByName(own->files));
  }
  // Entries reports a list of maps; the fields in it are checked nevertheless.
  for (size_t i = 0; node.IsSequence() && i < node.size() && !errors().enough(); ++i) {
    if (node[i].IsMap()) MergeFields(node[i], message, path);
  }
}

void YamlReader::CheckMeant(const YAML::Node& node, const std::string& path,
                            const std::string& meant, const Message& message) {
  const std::unique_ptr<Message> scratch(message.New());
  Origins own_origins;
  Origins* const outer = std::exchange(origins_, &own_origins);
  Set(node, Dotted(path, meant), *message.GetDescriptor()->FindFieldByName(meant), scratch.get());
  origins_ = outer;
  Findings findings;
  CheckFields(*scratch, path.size() < prefix_ ? "" : path.substr(prefix_), &findings);
  errors().AddFindings(findings, own_origins, file());
}

void YamlReader::Set(const YAML::Node& node, const std::string& path, const FieldDescriptor& field,
                     Message* message) {
  Note(node, path);
  if (field.is_repeated()) {
    SetList(node, path, field, message);
  } else {
    SetField(node, path, field, message);
  }
}

template <typename Whole>
std::optional<int64_t> YamlReader::ReadWhole(const YAML::Node& node, const std::string& path,
                                             const v1::FieldRule& rule) {
  using Limits = std::numeric_limits<Whole>;
  const int64_t min = rule.has_min() ? static_cast<int64_t>(rule.min()) : Limits::min();
  const int64_t max = rule.has_max() ? static_cast<int64_t>(rule.max()) : Limits::max();
  return ReadInt(node, path, min, max, rule.unit());
}

void YamlReader::SetField(const YAML::Node& node, const std::string& path,
                          const FieldDescriptor& field, Message* message) {
  const Reflection& reflection = *message->GetReflection();
  const v1::FieldRule& rule = RuleOf(field);
  if (IsDistribution(field)) {
    if (const auto distribution = ReadDistribution(node, path, rule, *this)) {
      reflection.MutableMessage(message, &field)->CopyFrom(*distribution);
    }
    return;
  }
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE: {
      Message* const group = reflection.MutableMessage(message, &field);
      if (auto* quantity = dynamic_cast<v1::Quantity*>(group)) {
        SetQuantity(node, path, rule, *quantity);
        break;
      }
      if (HasListForm(*group->GetDescriptor()) && !node.IsMap()) {
        SetInOrder(node, path, group);
        break;
      }
      auto* biomes = dynamic_cast<v1::BiomeWeights*>(group);
      if (biomes != nullptr && NamesAny(node)) ForbidAll(biomes);
      MergeFields(node, group, path);
      break;
    }
    case FieldDescriptor::CPPTYPE_ENUM:
      if (const auto* value = ReadEnum(node, path, field)) {
        reflection.SetEnum(message, &field, value);
      }
      break;
    case FieldDescriptor::CPPTYPE_BOOL:
      if (const auto value = ReadBool(node, path)) reflection.SetBool(message, &field, *value);
      break;
    case FieldDescriptor::CPPTYPE_DOUBLE:
      if (const auto value = ReadNumber(node, path, rule)) {
        reflection.SetDouble(message, &field, *value);
      }
      break;
    case FieldDescriptor::CPPTYPE_INT32:
      if (const auto value = ReadWhole<int32_t>(node, path, rule)) {
        reflection.SetInt32(message, &field, static_cast<int32_t>(*value));
      }
      break;
    case FieldDescriptor::CPPTYPE_INT64:
      if (const auto value = ReadWhole<int64_t>(node, path, rule)) {
        reflection.SetInt64(message, &field, *value);
      }
      break;
    case FieldDescriptor::CPPTYPE_UINT64:
      if (const auto value = ReadUint64(node, path)) {
        reflection.SetUInt64(message, &field, *value);
      }
      break;
    case FieldDescriptor::CPPTYPE_STRING:
      if (const auto value = ReadText(node, path)) {
        reflection.SetString(message, &field, TextOf(*value, rule));
      }
      break;
    default:
      Error(node, path, "this field can't be given in a file");
  }
}

const EnumValueDescriptor* YamlReader::ReadEnum(const YAML::Node& node, const std::string& path,
                                                const FieldDescriptor& field) {
  const std::vector<std::string> names = EnumTexts(field);
  if (node.IsScalar() && std::count(names.begin(), names.end(), node.Scalar()) > 0) {
    for (int i = 0; i < field.enum_type()->value_count(); ++i) {
      const EnumValueDescriptor* const value = field.enum_type()->value(i);
      if (EnumText(*value) == node.Scalar()) return value;
    }
  }
  Error(node, path,
        Seen(node) + " is not known" + (node.IsScalar() ? NearestHint(node.Scalar(), names) : "") +
            " (allowed: " + JoinNames(names) + ")");
  return nullptr;
}

void YamlReader::SetQuantity(const YAML::Node& node, const std::string& path,
                             const v1::FieldRule& rule, v1::Quantity& quantity) {
  if (node.IsScalar() && !PlainNumber(node)) {
    if (const auto text = ReadText(node, path)) quantity.set_formula(*text);
  } else if (const auto distribution = ReadDistribution(node, path, rule, *this)) {
    *quantity.mutable_drawn() = *distribution;
  }
}

void YamlReader::SetInOrder(const YAML::Node& node, const std::string& path, Message* message) {
  const auto& type = *message->GetDescriptor();
  if (!node.IsSequence() || static_cast<int>(node.size()) != type.field_count()) {
    Error(node, path,
          (node.IsSequence() ? fmt::format("a list of {}", node.size()) : Seen(node)) +
              ", allowed is [" + JoinNames(FieldNames(type)) + "]");
    return;
  }
  for (int i = 0; i < type.field_count(); ++i) {
    Set(node[i], Dotted(path, type.field(i)->name()), *type.field(i), message);
  }
}

void YamlReader::SetMessages(const YAML::Node& node, const std::string& path,
                             const FieldDescriptor& field, Message* message) {
  if (!node.IsSequence()) {
    Error(node, path,
          Seen(node) + ", allowed is a list of {" + JoinNames(FieldNames(*field.message_type())) +
              "}");
    return;
  }
  const Reflection& reflection = *message->GetReflection();
  reflection.ClearField(message, &field);
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string item_path = fmt::format("{}[{}]", path, i);
    Note(node[i], item_path);
    Message* item = reflection.AddMessage(message, &field);
    if (i > kMaxListItems) continue;  // Can only be too many.
    MergeFields(node[i], item, item_path);
  }
}

void YamlReader::SetList(const YAML::Node& node, const std::string& path,
                         const FieldDescriptor& field, Message* message) {
  const v1::FieldRule& rule = RuleOf(field);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE) {
    SetMessages(node, path, field, message);
    return;
  }
  if (MapsFieldOf(field) != nullptr && node.IsSequence()) {
    return SetTextsAndMaps(node, path, field, message);
  }
  const bool numbers = field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE;
  if (!node.IsSequence() || (!numbers && field.cpp_type() != FieldDescriptor::CPPTYPE_STRING)) {
    Error(node, path, Seen(node) + ", allowed is a list of " + (numbers ? "numbers" : "texts"));
    return;
  }
  const std::vector<std::string> known =
      rule.names() == v1::FieldRule::NAMES_ROOM_KIND
          ? RoomKindNames()
          : std::vector<std::string>(rule.allowed().begin(), rule.allowed().end());
  if (static_cast<int>(node.size()) < rule.min_items()) {
    Error(node, path,
          fmt::format("an empty list, allowed is at least {}{}", rule.min_items(),
                      known.empty() ? "" : " of " + JoinNames(known)));
    return;
  }
  const Reflection& reflection = *message->GetReflection();
  reflection.ClearField(message, &field);
  std::vector<std::string> values;
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string item_path = fmt::format("{}[{}]", path, i);
    Note(node[i], item_path);
    if (numbers) {
      const std::optional<double> value = ReadNumber(node[i], item_path, rule);
      if (value) reflection.AddDouble(message, &field, *value);
      continue;
    }
    // A wrong item keeps its place, so later items are reported with their index in the file.
    values.push_back(TextOf(ReadText(node[i], item_path).value_or(""), rule));
  }
  for (std::string& value : values) reflection.AddString(message, &field, std::move(value));
}

void YamlReader::SetTextsAndMaps(const YAML::Node& node, const std::string& path,
                                 const FieldDescriptor& texts, Message* message) {
  const Reflection& reflection = *message->GetReflection();
  const FieldDescriptor& maps = *MapsFieldOf(texts);
  reflection.ClearField(message, &texts);
  reflection.ClearField(message, &maps);
  const std::string parent = path.substr(0, path.size() - texts.name().size());
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string seen_path = fmt::format("{}[{}]", path, i);
    const FieldDescriptor& field = node[i].IsMap() ? maps : texts;
    const int index = reflection.FieldSize(*message, &field);
    if (index > kMaxListItems) continue;  // Can only be too many.
    // The findings of checks name the item's place in its field, the user the one in the file.
    const std::string item_path = fmt::format("{}{}[{}]", parent, field.name(), index);
    if (origins_ != nullptr) origins_->Set(item_path.substr(prefix_), OriginOf(node[i], seen_path));
    if (node[i].IsMap()) {
      Origins* const outer = origins_;
      Origins own;
      origins_ = &own;
      Message* const item = reflection.AddMessage(message, &maps);
      const size_t prefix = std::exchange(prefix_, seen_path.size() + 1);
      MergeFields(node[i], item, seen_path);
      prefix_ = prefix;
      origins_ = outer;
      if (origins_ != nullptr) origins_->SetBelow(item_path.substr(prefix_), own);
    } else {
      reflection.AddString(message, &texts, ReadText(node[i], seen_path).value_or(""));
    }
  }
}

std::string YamlReader::TextOf(std::string text, const v1::FieldRule& rule) const {
  return rule.names() == v1::FieldRule::NAMES_FOLDER_BELOW_ROOT ? OwnPathOf(text, file()) : text;
}

}  // namespace parallax::config_internal
