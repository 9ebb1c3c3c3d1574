#include "common/base/completion.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/base/version.h"

namespace parallax {
namespace {

using Names = std::vector<std::string>;

struct Argument {
  Names names;        // "-o", "--out"; of a positional argument its label.
  std::string value;  // "DIR"; empty: a flag.
  Names choices;      // The only values, where they are a set.
  std::string help;
  bool positional = false, required = false, many = false;
};

struct Command {
  std::string path;  // "parallax scene show"
  std::string help, footer;
  std::vector<Argument> arguments;
  std::vector<std::pair<std::string, std::string>> commands;  // Names and help.
};

std::string OneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  for (size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

// CLI11 appends the checks to the type: "TEXT:{auto,direct}", "INT:INT in [1 - 256]".
Argument Read(const CLI::Option& option, bool positional) {
  Argument argument;
  argument.help = OneLine(option.get_description());
  argument.positional = positional;
  argument.required = option.get_required();
  argument.many = option.get_expected_max() > 1;
  const std::string type = option.get_type_size() == 0 ? "" : option.get_type_name();
  argument.value = type.substr(0, type.find(':'));
  if (argument.value == "INT" || argument.value == "UINT") argument.value = "N";
  const size_t begin = type.find('{'), end = type.find('}');
  if (begin != std::string::npos && end != std::string::npos) {
    argument.choices = CLI::detail::split(type.substr(begin + 1, end - begin - 1), ',');
  }
  if (argument.positional) {
    argument.names = {option.get_name(true, false)};
  } else {
    for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  }
  return argument;
}

void Walk(const CLI::App& app, const std::string& path, std::vector<Command>& out) {
  Command command{path, OneLine(app.get_description()), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    // One option may be both, "ENGINE,--engine".
    if (option->get_positional()) command.arguments.push_back(Read(*option, true));
    if (option->get_lnames().empty() && option->get_snames().empty()) continue;
    command.arguments.push_back(Read(*option, false));
  }
  const auto below = app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); });
  for (const CLI::App* sub : below) {
    command.commands.emplace_back(sub->get_name(), OneLine(sub->get_description()));
  }
  out.push_back(std::move(command));
  for (const CLI::App* sub : below) Walk(*sub, path + " " + sub->get_name(), out);
}

// The words that may come where no option does.
Names WordsOf(const Command& command) {
  Names words;
  for (const auto& [name, help] : command.commands) words.push_back(name);
  for (const Argument& argument : command.arguments) {
    if (argument.positional) {
      words.insert(words.end(), argument.choices.begin(), argument.choices.end());
    }
  }
  return words;
}

std::string ShellQuoted(const std::string& text) {
  return "'" + Replaced(text, "'", "'\\''") + "'";
}

// ---- bash

constexpr char kBashEnd[] = R"(
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} i
  # bash cuts --option=value into three words.
  if [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi
  if [[ $word == = ]]; then word=; fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    if [[ ${options["$at ${COMP_WORDS[i]}"]+set} ]]; then at+=" ${COMP_WORDS[i]}"; fi
  done
  local offered=${words[$at]}
  if [[ ${values["$at $before"]+set} ]]; then offered=${values["$at $before"]}
  elif [[ $word == -* ]]; then offered=${options[$at]}; fi
  COMPREPLY=($(compgen -W "$offered" -- "$word"))
}
)";

std::string Bash(const std::string& program, const std::vector<Command>& commands) {
  std::string words, options, values;
  for (const Command& command : commands) {
    const std::string at = "    [" + ShellQuoted(command.path) + "]=";
    Names names;
    for (const Argument& argument : command.arguments) {
      if (argument.positional) continue;
      names.insert(names.end(), argument.names.begin(), argument.names.end());
      if (argument.value.empty()) continue;
      for (const std::string& name : argument.names) {
        values += "    [" + ShellQuoted(command.path + " " + name) +
                  "]=" + ShellQuoted(fmt::format("{}", fmt::join(argument.choices, " "))) + "\n";
      }
    }
    words += at + ShellQuoted(fmt::format("{}", fmt::join(WordsOf(command), " "))) + "\n";
    options += at + ShellQuoted(fmt::format("{}", fmt::join(names, " "))) + "\n";
  }
  return "_" + program + "() {\n  local -A words=(\n" + words + "  ) options=(\n" + options +
         "  ) values=(\n" + values + "  )\n  local at=" + program + kBashEnd +
         "complete -o default -F _" + program + " " + program;  // No word fits: files.
}

// ---- zsh

// Puts a backslash before what zsh or _arguments could take for its own.
std::string ZshWord(const std::string& text) {
  std::string word;
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 128 && std::isalnum(static_cast<unsigned char>(c)) == 0) {
      word += '\\';
    }
    word += c;
  }
  return word;
}

std::string ZshAction(const Argument& argument) {
  if (argument.choices.empty()) return "_files";
  return fmt::format("({})", fmt::join(argument.choices, " "));
}

std::string Zsh(const std::string& program, const std::vector<Command>& commands) {
  std::string paths, cases;
  for (const Command& command : commands) {
    paths += " " + ShellQuoted(command.path);
    std::string specs, below;
    Argument positional;
    for (const Argument& argument : command.arguments) {
      if (argument.positional) {
        positional = positional.names.empty() ? argument : positional;
        continue;
      }
      std::string help = Replaced(argument.help, "\\", "\\\\");
      help = Replaced(Replaced(help, "[", "\\["), "]", "\\]");
      for (const std::string& name : argument.names) {
        std::string spec = (argument.many ? "*" : "") + name;
        if (!argument.value.empty() && name.starts_with("--")) spec += "=";
        spec += "[" + help + "]";
        if (!argument.value.empty()) spec += ":" + argument.value + ":" + ZshAction(argument);
        specs += " \\\n      " + ShellQuoted(spec);
      }
    }
    for (const auto& [name, help] : command.commands) {
      below += (below.empty() ? "" : " ") + name + "\\:" + ZshWord(help);
    }
    const std::string rest = !below.empty() ? "*:command:((" + below + "))"
                             : positional.names.empty()
                                 ? ""
                                 : "*:" + positional.names[0] + ":" + ZshAction(positional);
    if (!rest.empty()) specs += " \\\n      " + ShellQuoted(rest);
    cases += "    " + ShellQuoted(command.path) + ") _arguments" + specs + " ;;\n";
  }
  // The file is the function's body where zsh loads it by itself, and defines it where it is read.
  return "#compdef " + program + "\n_" + program + "() {\n  local -a known=(" + paths +
         " )\n  local at=" + program + " word\n" +
         "  for word in ${words[2,CURRENT-1]}; do\n"
         "    if (( ${known[(Ie)$at $word]} )); then at+=\" $word\"; fi\n"
         "  done\n"
         "  case $at in\n" +
         cases + "  esac\n}\nif [[ $funcstack[1] == _" + program + " ]]; then _" + program +
         " \"$@\"; else compdef _" + program + " " + program + "; fi";
}

// ---- fish

std::string Fish(const std::string& program, const std::vector<Command>& commands) {
  const auto quoted = [](const std::string& text) {
    return "'" + Replaced(Replaced(text, "\\", "\\\\"), "'", "\\'") + "'";
  };
  std::string paths, rows;
  for (const Command& command : commands) {
    paths += " " + quoted(command.path);
    const std::string row =
        "complete -c " + program + " -n '__" + program + "_at " + command.path + "'";
    for (const auto& [name, help] : command.commands) {
      rows += row + " -f -a " + name + " -d " + quoted(help) + "\n";
    }
    for (const Argument& argument : command.arguments) {
      const std::string choices = fmt::format("{}", fmt::join(argument.choices, " "));
      const std::string offer = choices.empty() ? "" : " -f -a " + quoted(choices);
      if (argument.positional) {
        if (!offer.empty()) rows += row + offer + "\n";
        continue;
      }
      rows += row;
      for (const std::string& name : argument.names) {
        rows += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      }
      rows += (argument.value.empty() ? "" : " -r") + offer + " -d " + quoted(argument.help) + "\n";
    }
  }
  return "function __" + program + "_at\n  set -l commands" + paths + "\n  set -l at " + program +
         "\n  for word in (commandline -opc)[2..-1]\n"
         "    contains -- \"$at $word\" $commands; and set at \"$at $word\"\n"
         "  end\n"
         "  test \"$at\" = \"$argv\"\n"
         "end\n" +
         rows;
}

// ---- man

std::string Troff(const std::string& text) {
  std::string escaped = Replaced(Replaced(text, "\\", "\\e"), "-", "\\-");
  escaped = Replaced(Replaced(escaped, "\n.", "\n\\&."), "\n'", "\n\\&'");
  return (escaped.starts_with('.') || escaped.starts_with('\'') ? "\\&" : "") + escaped;
}

std::string ManPage(const std::string& program, const std::vector<Command>& commands) {
  std::string title = program;
  for (char& c : title) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  std::string text = ".TH " + title + " 1 \"\" \"Parallax " + Troff(kProgramVersion) + "\"\n";
  for (const Command& command : commands) {
    std::string synopsis = command.path, arguments;
    for (const Argument& argument : command.arguments) {
      std::string names = fmt::format("{}", fmt::join(argument.names, ", "));
      if (argument.positional) {
        const std::string label = names + (argument.many ? "..." : "");
        synopsis += " " + (argument.required ? label : "[" + label + "]");
      } else if (!argument.value.empty()) {
        names += " " + argument.value;
      }
      std::string help = argument.help;
      if (!argument.choices.empty()) {
        help += fmt::format("{}({})", help.empty() ? "" : " ", fmt::join(argument.choices, ", "));
      }
      arguments += ".TP\n\\fB" + Troff(names) + "\\fR\n" + Troff(help) + "\n";
    }
    if (&command == &commands.front()) {
      std::string summary = command.help;
      if (summary.starts_with(program + ": ")) summary.erase(0, program.size() + 2);
      text += ".SH NAME\n" + program + " \\- " + Troff(summary) + "\n.SH SYNOPSIS\n" + program +
              (command.commands.empty() ? "" : " COMMAND") + " [options]\n.SH OPTIONS\n" +
              arguments;
      if (!command.footer.empty()) {
        text += ".SH NOTES\n.nf\n" + Troff(command.footer) + "\n.fi\n";
      }
      if (!command.commands.empty()) text += ".SH COMMANDS\n";
      continue;
    }
    text += ".SS " + Troff(synopsis) + "\n" + Troff(command.help) + "\n" + arguments;
    if (!command.footer.empty()) text += ".PP\n.nf\n" + Troff(command.footer) + "\n.fi\n";
  }
  while (text.ends_with('\n')) text.pop_back();  // Who prints it ends the line.
  return text;
}

}  // namespace

CLI::App* AddCompletion(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "completion", "Print what a shell needs to complete commands, or the manual page");
  auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "The shell; man: the manual page in troff")
      ->required()
      ->check(CLI::IsMember(Names{"bash", "zsh", "fish", "man"}));
  const std::string name = program.get_name();
  command->footer("Examples:\n  source <(" + name + " completion bash)\n  " + name +
                  " completion fish > ~/.config/fish/completions/" + name + ".fish\n");
  // Runs before the root looks for options that it requires.
  command->parse_complete_callback([&program, shell, name] {
    std::vector<Command> commands;
    Walk(program, name, commands);
    throw CLI::CallForVersion(*shell == "bash"   ? Bash(name, commands)
                              : *shell == "zsh"  ? Zsh(name, commands)
                              : *shell == "fish" ? Fish(name, commands)
                                                 : ManPage(name, commands),
                              0);
  });
  return command;
}

}  // namespace parallax
