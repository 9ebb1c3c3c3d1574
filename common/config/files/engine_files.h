// Batch systems as files (proto/parallax/v1/engine.proto): the built-in ones of configs/engines,
// and the user's own. Errors of the loaders are those of config.h. Thread-safe.
#pragma once

#include <string>
#include <string_view>

#include "common/base/status.h"
#include "parallax/v1/engine.pb.h"

namespace parallax {

// Loads an engine. `path` is a file or, if there is no such file, the name of a built-in engine.
// The engine has all commands and patterns that it needs, its patterns are regular expressions, and
// its words hold only the placeholders that engine.proto names for them.
absl::StatusOr<v1::Engine> LoadEngine(const std::string& path);
// Parses the text of such a file. `file_name` is for messages, and names an engine without a name.
absl::StatusOr<v1::Engine> ParseEngine(std::string_view yaml, const std::string& file_name);

}  // namespace parallax
