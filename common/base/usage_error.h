// Explains a mistake on a program's command line: what was wrong, and what was probably meant.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace parallax {

// Returns the command of `program` whose arguments were read when parsing ended.
const CLI::App* ChosenCommand(const CLI::App* program);

// Returns one line without an end: the mistake, and "; did you mean ...?" or "; see `... --help`".
// `arguments` are those of the program, without its name.
std::string ExplainUsage(const CLI::App& program, const CLI::ParseError& error,
                         const std::vector<std::string>& arguments);

}  // namespace parallax
