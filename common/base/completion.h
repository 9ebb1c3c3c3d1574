// Shell completion and the manual page of a program, made from the table of its commands and
// options, so that they say what --help says. Not thread-safe, as CLI11 is not.
#pragma once

namespace CLI {
class App;
}

namespace parallax {

// Adds the command `completion SHELL` to a program: it prints the script for bash, zsh or fish, or
// with `man` the manual page in troff. As --version, it throws CLI::CallForVersion with the text,
// which CLI::App::exit prints. `program` is the root, and may get further commands later.
// Returns the command.
CLI::App* AddCompletion(CLI::App& program);

}  // namespace parallax
