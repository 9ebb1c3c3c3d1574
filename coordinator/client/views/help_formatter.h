// The layout of --help: usage first, options in columns, examples last.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>

namespace parallax::client {

std::shared_ptr<CLI::FormatterBase> MakeHelpFormatter();

}  // namespace parallax::client
