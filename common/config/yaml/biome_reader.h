// Inner part of common/config: reads the file of a land. Whether its values may be what they are is
// checked later (check/biome_check.h).
#pragma once

#include "common/config/config_text.h"
#include "common/config/yaml/yaml_reader.h"

namespace parallax::config_internal {

// Returns the land that the file has; without a name of its own it has the file's. Notes the places
// of its values in `origins`.
v1::Biome ReadBiome(const ConfigText& text, ConfigErrors& errors, Origins& origins);

}  // namespace parallax::config_internal
