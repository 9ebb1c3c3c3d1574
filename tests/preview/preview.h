// The subcommands of `preview`. Each function adds its options to `command` and returns the action,
// which is called once they are parsed.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "common/base/status.h"

namespace parallax::preview {

using Action = std::function<absl::Status()>;

Action Assets(CLI::App& command);
Action Frames(CLI::App& command);
Action Materials(CLI::App& command);
Action Plants(CLI::App& command);
Action Render(CLI::App& command);
Action Rooms(CLI::App& command);
Action Terrain(CLI::App& command);

}  // namespace parallax::preview
