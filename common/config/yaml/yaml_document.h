// Inner part of common/config: turns the text of one file into a YAML tree. Thread-safe.
#pragma once

#include <yaml-cpp/yaml.h>

#include <optional>
#include <string>
#include <string_view>

#include "common/config/check/config_errors.h"
#include "common/config/check/limits.h"

namespace parallax::config_internal {

// Returns the root of the only document in `text`; an empty text gives a null node. Returns nothing
// for a text that is larger than `most_bytes` or not YAML. `errors` then says so, and names `file`;
// a second document is an error there, too.
std::optional<YAML::Node> ParseYaml(std::string_view text, const std::string& file,
                                    ConfigErrors& errors, size_t most_bytes = kMaxYamlBytes);

// Returns whether the text repeats a part of itself by an alias (*name), and so may say far more
// than it is long.
bool HasAlias(std::string_view text);

}  // namespace parallax::config_internal
