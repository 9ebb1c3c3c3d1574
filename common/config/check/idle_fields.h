// Inner part of common/config: finds fields of a file that change nothing, because another field
// turns off what they are about. Who writes such a field expects an effect.
#pragma once

#include <string>

#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {

// Tells `reader` of each field that the map `node` at `path` gives, and that is idle in `merged`,
// the scene config that it was merged into. Fields that have their defaults, and those that
// `merged` has from elsewhere, may be idle: a variant turns off what its base has.
void CheckIdleFields(YamlReader& reader, const YAML::Node& node, const std::string& path,
                     const v1::SceneConfig& merged);

}  // namespace parallax::config_internal
