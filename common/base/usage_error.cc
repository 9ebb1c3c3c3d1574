#include "common/base/usage_error.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "common/base/edit_distance.h"

namespace parallax {
namespace {

using Names = std::vector<std::string>;

struct Mistake {
  std::string message, hint;
};

std::string NameWithParents(const CLI::App* app) {
  return app->get_parent() == nullptr ? app->get_name()
                                      : NameWithParents(app->get_parent()) + " " + app->get_name();
}

Names CommandsOf(const CLI::App* app) {
  Names names;
  for (const CLI::App* command : app->get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  return names;
}

Names OptionsOf(const CLI::App* app) {
  Names names;
  for (const CLI::Option* option : app->get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  return names;
}

bool Has(const Names& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Returns the commands that the commands of `app` have by this name: "config check" for "check".
Names DeeperCommands(const CLI::App* app, const std::string& name) {
  Names found;
  for (const CLI::App* command : app->get_subcommands([](const CLI::App*) { return true; })) {
    if (Has(CommandsOf(command), name)) {
      found.push_back("`" + NameWithParents(command) + " " + name + "`");
    }
  }
  return found;
}

// CLI11 speaks of "arguments not expected" where a command was mistyped.
void NameWrongCommand(const CLI::App* command, const Names& arguments, Mistake& mistake) {
  const std::string name = NameWithParents(command);
  for (const std::string& typed : arguments) {
    if (typed.empty() || typed[0] == '-' ||
        (" " + name + " ").find(" " + typed + " ") != name.npos) {
      continue;
    }
    mistake.message = "there is no command '" + typed + "'";
    const std::string near = NearestName(typed, CommandsOf(command));
    const Names deeper = DeeperCommands(command, typed);
    if (!near.empty()) mistake.hint = "did you mean `" + name + " " + near + "`?";
    if (!deeper.empty()) {
      mistake.hint = fmt::format("did you mean {}?", fmt::join(deeper, " or "));
    }
    return;
  }
  if (mistake.message == "A subcommand is required") {
    mistake.message = "which command of `" + name + "`? There are " +
                      fmt::format("{}", fmt::join(CommandsOf(command), ", "));
  }
}

// Names the first option that a command does not have. CLI11 names all that it did not use, from
// the last to the first, or an option that is missing because its name was mistyped.
bool NameWrongOption(const CLI::App* command, const Names& arguments, Mistake& mistake) {
  const Names known = OptionsOf(command);
  for (const std::string& argument : arguments) {
    const std::string option = argument.substr(0, argument.find('='));
    if (option == "--") return false;
    if (!option.starts_with("--") || Has(known, option)) continue;
    mistake.message = "`" + NameWithParents(command) + "` has no option " + option;
    const std::string near = NearestName(option, known);
    if (!near.empty()) mistake.hint = "did you mean " + near + "?";
    return true;
  }
  return false;
}

// "--format: markdwn not in {text,markdown}": finds the one that was meant.
void NameNearestValue(Mistake& mistake) {
  const std::string& message = mistake.message;
  const size_t typed = message.find(": "), set = message.find(" not in {");
  if (typed == message.npos || set == message.npos || typed + 2 > set || message.back() != '}') {
    return;
  }
  const size_t first = set + 9;
  const Names allowed = CLI::detail::split(message.substr(first, message.size() - first - 1), ',');
  const std::string near = NearestName(message.substr(typed + 2, set - typed - 2), allowed);
  if (!near.empty()) mistake.hint = "did you mean " + near + "?";
}

}  // namespace

const CLI::App* ChosenCommand(const CLI::App* program) {
  const auto parsed = program->get_subcommands();
  return parsed.empty() ? program : ChosenCommand(parsed.back());
}

std::string ExplainUsage(const CLI::App& program, const CLI::ParseError& error,
                         const Names& arguments) {
  const CLI::App* command = ChosenCommand(&program);
  const std::string what = error.what();
  Mistake mistake{what.substr(0, what.find('\n')), "see `" + NameWithParents(command) + " --help`"};
  const bool extras = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  const bool required = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  // A command inherits the number from its parent, although there may be none below it.
  if (command->get_require_subcommand_max() > 0 && !CommandsOf(command).empty()) {
    NameWrongCommand(command, arguments, mistake);
  } else if (extras || required) {
    if (!NameWrongOption(command, arguments, mistake) && extras) {
      const Names rest = command->remaining();
      if (!rest.empty()) {
        mistake.message = "`" + NameWithParents(command) + "` takes no more arguments: " + rest[0];
      }
    }
  } else {
    NameNearestValue(mistake);
  }
  return mistake.message + "; " + mistake.hint;
}

}  // namespace parallax
