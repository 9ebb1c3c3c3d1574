#include "common/config/yaml/named_files.h"

#include <fmt/core.h>

#include <filesystem>

#include "common/config/check/field_rules.h"
#include "common/config/yaml/yaml_document.h"

namespace parallax::config_internal {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

void ReadNamed(const ConfigText& text, ConfigErrors& errors, Origins& origins, Message* message) {
  YamlReader reader(text.file, &errors);
  const std::optional<YAML::Node> root = ParseYaml(text.text, text.file, errors);
  if (root) reader.Merge(*root, message, "", &origins);
  const FieldDescriptor& name = *message->GetDescriptor()->FindFieldByName("name");
  if (message->GetReflection()->HasField(*message, &name)) return;
  message->GetReflection()->SetString(message, &name,
                                      std::filesystem::path(text.file).stem().string());
}

const OwnFiles* OwnFiles::Of(const google::protobuf::Descriptor& type) {
  static const OwnFiles kLands = {"biome_files", "own_biomes", "biomes", "biome"};
  static const OwnFiles kRooms = {"room_files", "own_kinds", "rooms", ""};
  if (&type == v1::NatureConfig::descriptor()) return &kLands;
  return &type == v1::RoomConfig::descriptor() ? &kRooms : nullptr;
}

void YamlReader::ReadFiles(const YAML::Node& files, const std::string& path, const OwnFiles& own,
                           Message& group) {
  const Reflection& reflection = *group.GetReflection();
  const FieldDescriptor& list = *group.GetDescriptor()->FindFieldByName(own.content);
  reflection.ClearField(&group, &list);
  for (size_t i = 0; files.IsSequence() && i < files.size(); ++i) {
    const std::string item = fmt::format("{}.{}[{}]", path, own.files, i);
    const std::optional<std::string> named = ReadText(files[i], item);
    if (!named) continue;
    const absl::StatusOr<ConfigText> text = ReadNamedText(*named, file(), own.folder);
    if (!text.ok()) {
      Error(files[i], item, ToStd(text.status().message()));
      continue;
    }
    Origins read;
    const std::string place =
        fmt::format("{}.{}[{}]", path, own.content, reflection.FieldSize(group, &list));
    Message* message = reflection.AddMessage(&group, &list);
    if (!own.part.empty()) {
      const FieldDescriptor& part = *message->GetDescriptor()->FindFieldByName(own.part);
      message = message->GetReflection()->MutableMessage(message, &part);
    }
    ReadNamed(*text, errors(), read, message);
    if (origins_ == nullptr) continue;
    Note(files[i], place);
    const std::string content = place.substr(prefix_) + (own.part.empty() ? "" : "." + own.part);
    origins_->Set(content, {text->file, 1, ""});
    origins_->SetBelow(content, read);
  }
}

bool YamlReader::ReadOwnFiles(const YAML::Node& node, const std::string& path, const OwnFiles& own,
                              Message& group) {
  const YAML::Node files = node[own.files], written = node[own.content];
  const bool given = files && files.IsSequence() && files.size() > 0;
  if (given && written && written.IsSequence() && written.size() > 0) {
    Error(written, Dotted(path, own.content),
          "given beside " + own.files + ", whose content it is, allowed is one of them");
  }
  if (files && (given || !written)) ReadFiles(files, path, own, group);
  return given;
}

void YamlReader::ReadOwnWeights(const YAML::Node& node, const std::string& path,
                                v1::NatureConfig& nature) {
  own_biomes_.clear();
  const YAML::Node weights = node["biomes"];
  for (int i = 0; i < nature.own_biomes_size(); ++i) {
    v1::OwnBiome& own = *nature.mutable_own_biomes(i);
    const std::string& name = own_biomes_.emplace_back(own.biome().name());
    if (!weights || !weights.IsMap()) continue;
    if (NamesAny(weights)) own.clear_weight();
    if (!weights[name]) continue;
    const std::string place = Dotted(path, "biomes." + name);
    const v1::FieldRule& rule = RuleOf(*own.GetDescriptor()->FindFieldByName("weight"));
    if (const auto value = ReadNumber(weights[name], place, rule)) own.set_weight(*value);
    if (origins_ == nullptr) continue;
    origins_->Set(fmt::format("{}.own_biomes[{}].weight", path, i).substr(prefix_),
                  OriginOf(weights[name], place));
  }
}

}  // namespace parallax::config_internal
