// Inner part of common/config: reads a distribution, which is a number or a map with one key, such
// as {uniform: [low, high]}.
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>

#include "common/config/yaml/yaml_reader.h"
#include "parallax/v1/config.pb.h"

namespace parallax::config_internal {

// Reads the distribution that `node`, at `path` of the reader's file, holds. `rule` only words what
// is allowed: checks.h judges the numbers. Notes the places of the numbers. Returns nothing for
// what is no distribution, which is then in the reader's errors.
std::optional<v1::Distribution> ReadDistribution(const YAML::Node& node, const std::string& path,
                                                 const v1::FieldRule& rule, YamlReader& reader);

}  // namespace parallax::config_internal
