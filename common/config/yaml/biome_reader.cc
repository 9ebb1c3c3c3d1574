#include "common/config/yaml/biome_reader.h"

#include <fmt/core.h>

#include <filesystem>

#include "common/config/check/field_rules.h"
#include "common/config/yaml/yaml_document.h"

namespace parallax::config_internal {

v1::Biome ReadBiome(const ConfigText& text, ConfigErrors& errors, Origins& origins) {
  v1::Biome biome;
  YamlReader reader(text.file, &errors);
  const std::optional<YAML::Node> root = ParseYaml(text.text, text.file, errors);
  if (root) reader.Merge(*root, &biome, "", &origins);
  if (!biome.has_name()) biome.set_name(std::filesystem::path(text.file).stem());
  return biome;
}

void YamlReader::ReadBiomeFiles(const YAML::Node& files, const std::string& path,
                                v1::NatureConfig& nature) {
  nature.clear_own_biomes();
  for (size_t i = 0; files.IsSequence() && i < files.size(); ++i) {
    const std::string item = fmt::format("{}.biome_files[{}]", path, i);
    const std::optional<std::string> named = ReadText(files[i], item);
    if (!named) continue;
    const absl::StatusOr<ConfigText> text = ReadNamedText(*named, file(), "biomes");
    if (!text.ok()) {
      Error(files[i], item, ToStd(text.status().message()));
      continue;
    }
    Origins read;
    const std::string place = fmt::format("{}.own_biomes[{}]", path, nature.own_biomes_size());
    *nature.add_own_biomes()->mutable_biome() = ReadBiome(*text, errors(), read);
    if (origins_ == nullptr) continue;
    Note(files[i], place);
    origins_->Set(place.substr(prefix_) + ".biome", {text->file, 1, ""});
    origins_->SetBelow(place.substr(prefix_) + ".biome", read);
  }
}

bool YamlReader::ReadOwnBiomes(const YAML::Node& node, const std::string& path,
                               v1::NatureConfig& nature) {
  const YAML::Node files = node["biome_files"], written = node["own_biomes"];
  const bool given = files && files.IsSequence() && files.size() > 0;
  if (given && written && written.IsSequence() && written.size() > 0) {
    Error(written, Dotted(path, "own_biomes"),
          "given beside biome_files, whose content it is, allowed is one of them");
  }
  if (files && (given || !written)) ReadBiomeFiles(files, path, nature);
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
  return given;
}

}  // namespace parallax::config_internal
