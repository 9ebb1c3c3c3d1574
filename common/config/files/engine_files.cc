#include "common/config/files/engine_files.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <regex>

#include "common/base/names.h"
#include "common/config/check/field_rules.h"
#include "common/config/config_text.h"
#include "common/config/yaml/named_files.h"

namespace parallax {
namespace {

using config_internal::Findings;
using Names = std::vector<std::string>;
using TextList = google::protobuf::RepeatedPtrField<std::string>;

bool Holds(const TextList& words, const std::string& placeholder) {
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return word.find(placeholder) != std::string::npos;
  });
}

class EngineChecker {
 public:
  explicit EngineChecker(Findings* findings) : findings_(*findings) {}

  void Words(const std::string& path, const TextList& words, const Names& known, bool needed) {
    if (needed && words.empty()) Tell(path, "is missing, expected a list of words");
    static const std::regex kPlaceholder(R"(\{([a-z_]+)\})");
    for (int i = 0; i < words.size(); ++i) {
      for (std::sregex_iterator it(words[i].begin(), words[i].end(), kPlaceholder), end; it != end;
           ++it) {
        if (std::count(known.begin(), known.end(), (*it)[1]) > 0) continue;
        Tell(fmt::format("{}[{}]", path, i), fmt::format("there is no {}, expected {{{}}}",
                                                         (*it)[0].str(), fmt::join(known, "}, {")));
      }
    }
  }

  // A program and its arguments. A placeholder of `several` becomes several words, so it is one of
  // its own; those of `needed` stand somewhere.
  void Command(const std::string& path, const TextList& words, const Names& known,
               const Names& several, const Names& needed) {
    Words(path, words, known, true);
    if (words.empty()) return;
    if (words[0].empty()) Tell(path + "[0]", "\"\", expected a program");
    for (int i = 0; i < words.size(); ++i) {
      for (const std::string& name : several) {
        if (words[i] == name || words[i].find(name) == std::string::npos) continue;
        Tell(fmt::format("{}[{}]", path, i),
             Quoted(words[i]) + ", expected " + name + " as a word of its own");
      }
    }
    for (const std::string& name : needed) {
      if (!Holds(words, name)) Tell(path, "has no " + name + ", expected one");
    }
  }

  // A pattern that must have at least `groups` groups; an absent one has none. Returns how many it
  // has; nothing for one that is absent or wrong.
  std::optional<int> Pattern(const std::string& path, const std::string& text, int groups,
                             bool needed) {
    if (text.empty()) {
      if (needed) Tell(path, "is missing, expected a regular expression");
      return std::nullopt;
    }
    try {
      const std::regex pattern(std::regex_replace(text, std::regex(R"(\{name\})"), "x"));
      const int has = static_cast<int>(pattern.mark_count());
      if (has >= groups) return has;
      Tell(path, fmt::format("{} has {} groups, expected {} at least", Quoted(text), has, groups));
    } catch (const std::regex_error&) {
      Tell(path, Quoted(text) + " is no regular expression, expected one (ECMAScript)");
    }
    return std::nullopt;
  }

  // A text made of the `groups` groups of a pattern; `needed`: of one at least.
  void Groups(const std::string& path, const std::string& text, int groups, bool needed) {
    static const std::regex kReference(R"(\$(?:\$|&|(\d\d?)))");
    bool any = false;
    for (std::sregex_iterator it(text.begin(), text.end(), kReference), end; it != end; ++it) {
      any = any || (*it)[0] != "$$";
      if (!(*it)[1].matched || std::stoi((*it)[1]) <= groups) continue;
      Tell(path,
           fmt::format("there is no group {} in list.pilot, which has {}", (*it)[0].str(), groups));
    }
    if (needed && !any) Tell(path, Quoted(text) + ", expected a group of list.pilot, such as $1");
  }

  void Tell(const std::string& path, std::string what) {
    findings_.push_back({path, std::move(what)});
  }

 private:
  Findings& findings_;
};

void CheckEngine(const v1::Engine& engine, const std::string&, Findings* findings) {
  EngineChecker check(findings);
  if (!IsName(engine.name())) check.Tell("name", WhyNotName(engine.name()));
  const v1::EngineSubmit& submit = engine.submit();
  const bool has_options = !submit.cores().empty() || !submit.memory().empty() ||
                           !submit.wall_time().empty() || !submit.log().empty();
  check.Command("submit.command", submit.command(),
                {"name", "pilots", "script", "options", "arguments"}, {"{options}", "{arguments}"},
                has_options ? Names{"{script}", "{options}"} : Names{"{script}"});
  if (!submit.command().empty() && !Holds(submit.command(), "{arguments}") &&
      !Holds(engine.environment(), "{arguments}")) {
    check.Tell("submit.command", "has no {arguments}, expected it here or in environment");
  }
  if (Holds(submit.command(), "{pilots}") != submit.array()) {
    check.Tell("submit.array", submit.array()
                                   ? "true, expected {pilots} in submit.command"
                                   : "not true, expected so where submit.command has {pilots}");
  }
  check.Words("submit.cores", submit.cores(), {"cores"}, false);
  check.Words("submit.memory", submit.memory(), {"memory_mb"}, false);
  check.Words("submit.wall_time", submit.wall_time(), {"wall_minutes", "wall_s"}, false);
  check.Words("submit.log", submit.log(), {"log"}, false);
  check.Pattern("submit.id", submit.id(), 1, true);
  check.Command("cancel", engine.cancel(), {"ids"}, {"{ids}"}, {"{ids}"});
  const v1::EngineList& list = engine.list();
  check.Command("list.command", list.command(), {"name", "user"}, {}, {});
  const int used = !list.has_state() ? 2 : list.has_id() ? 0 : 1;
  if (const auto groups = check.Pattern("list.pilot", list.pilot(), used, true)) {
    if (list.has_id()) check.Groups("list.id", list.id(), *groups, true);
    if (list.has_state()) check.Groups("list.state", list.state(), *groups, false);
  }
  check.Pattern("list.ignore", list.ignore(), 0, false);
  check.Pattern("list.none", list.none(), 0, false);
  if (list.states().empty()) check.Tell("list.states", "is missing, expected {pattern, is}");
  for (int i = 0; i < list.states_size(); ++i) {
    const std::string path = fmt::format("list.states[{}]", i);
    check.Pattern(path + ".pattern", list.states(i).pattern(), 0, true);
    if (list.states(i).is() == v1::EngineState::IS_UNSPECIFIED) {
      check.Tell(path + ".is", "is missing, expected waiting, running or ending");
    }
  }
  for (int i = 0; i < engine.environment_size(); ++i) {
    const size_t sign = engine.environment(i).find('=');
    if (sign != std::string::npos && sign > 0) continue;
    check.Tell(fmt::format("environment[{}]", i),
               Quoted(engine.environment(i)) + ", expected NAME=value");
  }
  check.Words("environment", engine.environment(),
              {"engine", "coordinator", "tls", "idle_s", "cores", "memory_mb", "wall_s",
               "arguments", "grace_s", "long_grace_s", "worker", "state"},
              false);
}

}  // namespace

absl::StatusOr<v1::Engine> ParseEngine(std::string_view yaml, const std::string& file_name) {
  return config_internal::ParseNamed<v1::Engine>(yaml, file_name, &CheckEngine);
}

absl::StatusOr<v1::Engine> LoadEngine(const std::string& path) {
  ASSIGN_OR_RETURN(const config_internal::ConfigText text,
                   config_internal::ReadConfigText(path, "engines"));
  return ParseEngine(text.text, text.file);
}

}  // namespace parallax
