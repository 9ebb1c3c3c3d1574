#include "common/config/files/engine_files.h"

#include <fmt/ranges.h>

#include <algorithm>
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

  // A pattern that must have at least `groups` groups; an absent one has none.
  void Pattern(const std::string& path, const std::string& text, int groups, bool needed) {
    if (text.empty()) {
      if (needed) Tell(path, "is missing, expected a regular expression");
      return;
    }
    try {
      const std::regex pattern(std::regex_replace(text, std::regex(R"(\{name\})"), "x"));
      if (static_cast<int>(pattern.mark_count()) >= groups) return;
      Tell(path, fmt::format("{} has {} groups, expected {} at least", Quoted(text),
                             pattern.mark_count(), groups));
    } catch (const std::regex_error&) {
      Tell(path, Quoted(text) + " is no regular expression, expected one (ECMAScript)");
    }
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
  check.Words("submit.command", submit.command(),
              {"name", "pilots", "script", "options", "arguments"}, true);
  check.Words("submit.cores", submit.cores(), {"cores"}, false);
  check.Words("submit.memory", submit.memory(), {"memory_mb"}, false);
  check.Words("submit.wall_time", submit.wall_time(), {"wall_minutes", "wall_s"}, false);
  check.Words("submit.log", submit.log(), {"log"}, false);
  check.Pattern("submit.id", submit.id(), 1, true);
  check.Words("cancel", engine.cancel(), {"ids"}, true);
  const v1::EngineList& list = engine.list();
  check.Words("list.command", list.command(), {"name", "user"}, true);
  check.Pattern("list.pilot", list.pilot(), list.has_id() && list.has_state() ? 0 : 2, true);
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
    if (engine.environment(i).find('=') != std::string::npos) continue;
    check.Tell(fmt::format("environment[{}]", i),
               Quoted(engine.environment(i)) + ", expected NAME=value");
  }
  check.Words("environment", engine.environment(),
              {"engine", "coordinator", "tls", "idle_s", "cores", "memory_mb", "wall_s",
               "arguments", "grace_s", "long_grace_s"},
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
