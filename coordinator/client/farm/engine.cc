#include "coordinator/client/farm/engine.h"

#include <pwd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <regex>
#include <sstream>
#include <thread>

#include "common/base/names.h"
#include "common/base/shell_word.h"
#include "common/base/system/child_process.h"
#include "common/base/system/file.h"
#include "common/base/system/temporary_folder.h"
#include "coordinator/client/views/text.h"

namespace parallax::client {
namespace {

using Texts = std::vector<std::string>;
using Values = std::map<std::string, std::string>;

// std::regex recurses for each character: a line of 64 kB would use up the stack.
constexpr size_t kMostMatched = 2000;

// The words with their placeholders filled in; a word of `lists` becomes all of its list.
Texts Filled(const google::protobuf::RepeatedPtrField<std::string>& words, const Values& values,
             const std::map<std::string, Texts>& lists = {}) {
  static const std::regex kPlaceholder(R"(\{([a-z_]+)\})");
  Texts filled;
  for (const std::string& word : words) {
    if (const auto list = lists.find(word); list != lists.end()) {
      filled.insert(filled.end(), list->second.begin(), list->second.end());
      continue;
    }
    std::string& text = filled.emplace_back();
    auto rest = word.begin();
    for (std::sregex_iterator it(word.begin(), word.end(), kPlaceholder), end; it != end; ++it) {
      const auto value = values.find((*it)[1]);
      text.append(rest, (*it)[0].first) += value == values.end() ? "" : value->second;
      rest = (*it)[0].second;
    }
    text.append(rest, word.end());
  }
  return filled;
}

// Returns the first line of what a program printed, for messages.
std::string ShownLine(std::string_view text) {
  constexpr size_t kMostShown = 200;
  return CutText(Printable(FirstLine(text.substr(0, kMostMatched))), kMostShown);
}

// Output and errors of a program that ended well, or failed with a line that fits `allowed`.
absl::StatusOr<std::string> OutputOf(const Texts& command, const std::string& allowed = "",
                                     const Texts& environment = {}) {
  constexpr std::chrono::seconds kLimit(60);
  constexpr size_t kMostBytes = size_t{64} << 20;
  ASSIGN_OR_RETURN(const TemporaryFolder folder, TemporaryFolder::Make("engine"));
  const std::string log = folder.path() + "/log";
  ASSIGN_OR_RETURN(
      const auto child,
      ChildProcess::Start(
          {.command = command, .directory = "", .log = log, .environment = environment}));
  const auto deadline = std::chrono::steady_clock::now() + kLimit;
  std::optional<int> ended;
  while (!(ended = child->Poll())) {
    if (std::chrono::steady_clock::now() > deadline) {
      return DeadlineExceeded("{} did not end within a minute", command[0]);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  ASSIGN_OR_RETURN(const std::string text, ReadFile(log, kMostBytes));
  if (WIFEXITED(*ended) && WEXITSTATUS(*ended) == 0) return text;
  const std::string first = FirstLine(std::string_view(text).substr(0, kMostMatched));
  if (!allowed.empty() && std::regex_search(first, std::regex(allowed))) return std::string();
  return Unavailable("{}: {}: {}", command[0], DescribeExit(*ended), ShownLine(first));
}

absl::StatusOr<Pilot::State> StateOf(const v1::Engine& engine, const std::string& word) {
  for (const v1::EngineState& state : engine.list().states()) {
    if (!std::regex_match(word, std::regex(state.pattern()))) continue;
    return state.is() == v1::EngineState::IS_RUNNING   ? Pilot::State::kRunning
           : state.is() == v1::EngineState::IS_WAITING ? Pilot::State::kPending
                                                       : Pilot::State::kEnding;
  }
  return InvalidArgument("{}: state {} fits no row of list.states of engine {}",
                         engine.list().command(0), ShownLine(word), engine.name());
}

// The numbers in an id, for the order of submission.
std::vector<int64_t> NumbersIn(const std::string& id) {
  static const std::regex kNumber(R"(\d{1,18})");
  std::vector<int64_t> numbers;
  for (std::sregex_iterator it(id.begin(), id.end(), kNumber), end; it != end; ++it) {
    numbers.push_back(std::stoll((*it)[0]));
  }
  return numbers;
}

std::string UserName() {
  const passwd* const user = getpwuid(geteuid());
  return user == nullptr ? std::to_string(geteuid()) : user->pw_name;
}

}  // namespace

absl::StatusOr<std::vector<Pilot>> ParsePilots(const v1::Engine& engine,
                                               const std::string& job_name,
                                               const std::string& text) {
  const v1::EngineList& list = engine.list();
  const std::string name = std::regex_replace(job_name, std::regex(R"([^\w])"), R"(\$&)");
  const std::regex pilot(std::regex_replace(list.pilot(), std::regex(R"(\{name\})"), name));
  const std::regex ignore(list.has_ignore() ? list.ignore() : "^$");
  std::vector<Pilot> pilots;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch groups;
    line.resize(std::min(line.size(), kMostMatched));
    if (line.empty()) continue;
    if (!std::regex_search(line, groups, pilot)) {
      if (std::regex_search(line, ignore)) continue;
      return InvalidArgument("{}: expected a line that fits list.pilot of engine {}, got '{}'",
                             list.command(0), engine.name(), ShownLine(line));
    }
    ASSIGN_OR_RETURN(const Pilot::State state,
                     StateOf(engine, groups.format(list.has_state() ? list.state() : "$2")));
    pilots.push_back({groups.format(list.has_id() ? list.id() : "$1"), state});
  }
  std::stable_sort(pilots.begin(), pilots.end(), [](const Pilot& a, const Pilot& b) {
    return NumbersIn(a.id) < NumbersIn(b.id);
  });
  return pilots;
}

BatchEngine::BatchEngine(v1::Engine engine, PilotOptions options)
    : engine_(std::move(engine)), options_(std::move(options)) {}

absl::StatusOr<std::vector<Pilot>> BatchEngine::Pilots() const {
  ASSIGN_OR_RETURN(const std::string text,
                   OutputOf(Filled(engine_.list().command(),
                                   {{"name", options_.job_name}, {"user", UserName()}}),
                            engine_.list().none()));
  return ParsePilots(engine_, options_.job_name, text);
}

Texts BatchEngine::SubmitWords(int pilots) const {
  const v1::EngineSubmit& submit = engine_.submit();
  Texts options;
  for (const auto& [value, words] :
       {std::pair("cores", &submit.cores()), std::pair("memory_mb", &submit.memory()),
        std::pair("wall_minutes", &submit.wall_time()), std::pair("log", &submit.log())}) {
    if (!options_.values.contains(value)) continue;
    const Texts filled = Filled(*words, options_.values);
    options.insert(options.end(), filled.begin(), filled.end());
  }
  options.insert(options.end(), options_.submit_options.begin(), options_.submit_options.end());
  return Filled(submit.command(),
                {{"name", options_.job_name},
                 {"script", options_.script},
                 {"pilots", std::to_string(pilots)}},
                {{"{options}", options}, {"{arguments}", options_.worker_arguments}});
}

std::string BatchEngine::SubmitCommand(int pilots) const {
  std::string line;
  for (const std::string& setting : Filled(engine_.environment(), options_.values)) {
    const size_t value = std::min(setting.find('='), setting.size() - 1) + 1;
    line += setting.substr(0, value);
    line += (value < setting.size() ? ShellWord(setting.substr(value)) : "") + " ";
  }
  for (const std::string& word : SubmitWords(pilots)) line += ShellWord(word) + " ";
  line.pop_back();
  return line;
}

absl::StatusOr<std::string> BatchEngine::Submit(int pilots) const {
  const Texts words = SubmitWords(pilots);
  const std::regex pattern(engine_.submit().id());
  std::string ids;
  for (int call = 0; call < (engine_.submit().array() ? 1 : pilots); ++call) {
    ASSIGN_OR_RETURN(const std::string text,
                     OutputOf(words, "", Filled(engine_.environment(), options_.values)));
    std::istringstream lines(text);
    std::string id;
    std::smatch groups;
    for (std::string line; std::getline(lines, line);) {
      line.resize(std::min(line.size(), kMostMatched));
      if (std::regex_search(line, groups, pattern)) id = groups[1];
    }
    if (id.empty()) return Unavailable("{} named no job: {}", words[0], ShownLine(text));
    ids += (ids.empty() ? "" : " ") + id;
  }
  return ids;
}

absl::Status BatchEngine::Cancel(const Texts& ids) const {
  if (ids.empty()) return absl::OkStatus();
  return OutputOf(Filled(engine_.cancel(), {}, {{"{ids}", ids}})).status();
}

}  // namespace parallax::client
