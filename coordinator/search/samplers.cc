#include "coordinator/search/samplers.h"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "common/base/names.h"
#include "common/base/seconds.h"
#include "common/base/system/file.h"
#include "coordinator/search/rung_study.h"

namespace parallax {
namespace {

constexpr double kLongestTimeout_s = 3600;
constexpr size_t kMostAnswerBytes = 1 << 20;

absl::StatusOr<Sampler> ReadSampler(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  Sampler sampler;
  const std::filesystem::path file(path);
  sampler.directory = file.parent_path().string();
  try {
    const YAML::Node root = YAML::Load(text);
    const std::set<std::string> known = {"sampler", "command", "timeout_s"};
    for (const auto& field : root) {
      const auto name = field.first.as<std::string>();
      if (known.count(name) > 0) continue;
      return InvalidArgument("{}: line {}: {} is not known; known are: sampler, command, timeout_s",
                             path, field.first.Mark().line + 1, Quoted(name));
    }
    sampler.name = root["sampler"].as<std::string>();
    sampler.command = root["command"].as<std::vector<std::string>>();
    if (root["timeout_s"]) sampler.timeout_s = root["timeout_s"].as<double>();
  } catch (const YAML::Exception& error) {
    return InvalidArgument(
        "{}: line {}: {}; wanted are sampler: NAME and command: [PROGRAM, \"{{ask}}\", "
        "\"{{answer}}\"]",
        path, error.mark.line + 1, error.msg);
  }
  if (sampler.name != file.stem() || sampler.name == kSobolSampler) {
    return InvalidArgument("{}: sampler is {}, wanted the file's name, and not {}", path,
                           Quoted(sampler.name), kSobolSampler);
  }
  for (const char* place : {"{ask}", "{answer}"}) {
    const auto has = [&](const std::string& word) { return word.find(place) != std::string::npos; };
    if (std::any_of(sampler.command.begin(), sampler.command.end(), has)) continue;
    return InvalidArgument("{}: command: no {} in it, wanted once at least", path, place);
  }
  if (!(sampler.timeout_s > 0 && sampler.timeout_s <= kLongestTimeout_s)) {
    return InvalidArgument("{}: timeout_s is {}, allowed is (0, {}]", path, sampler.timeout_s,
                           kLongestTimeout_s);
  }
  return sampler;
}

std::string Replaced(std::string text, const std::string& what, const std::string& by) {
  for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size())) {
    text.replace(at, what.size(), by);
  }
  return text;
}

std::string LastLineOf(const std::string& path) {
  const absl::StatusOr<std::string> log = ReadFile(path);
  if (!log.ok()) return "";
  const size_t end = log->find_last_not_of(" \n\r");
  if (end == std::string::npos) return "";
  const size_t before = log->rfind('\n', end);
  const size_t begin = before == std::string::npos ? 0 : before + 1;
  return ": " + CutText(log->substr(begin, end + 1 - begin), 300);
}

}  // namespace

absl::StatusOr<std::map<std::string, Sampler>> LoadSamplers(const std::string& dir) {
  std::map<std::string, Sampler> samplers;
  if (dir.empty()) return samplers;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(dir, error)) {
    if (entry.path().extension() != ".yaml") continue;
    ASSIGN_OR_RETURN(Sampler sampler, ReadSampler(entry.path().string()));
    const std::string name = sampler.name;
    samplers[name] = std::move(sampler);
  }
  if (error) return ErrnoError(error.value(), "folder of samplers " + dir);
  return samplers;
}

SamplerRun::SamplerRun(const Sampler& sampler, TemporaryFolder folder, Clock& clock)
    : sampler_(sampler), folder_(std::move(folder)), clock_(clock), begun_(clock.Steady()) {}

absl::StatusOr<std::unique_ptr<SamplerRun>> SamplerRun::Start(const Sampler& sampler,
                                                              const std::string& ask,
                                                              Clock& clock) {
  ASSIGN_OR_RETURN(TemporaryFolder folder, TemporaryFolder::Make("sampler"));
  std::unique_ptr<SamplerRun> run(new SamplerRun(sampler, std::move(folder), clock));
  const std::string& path = run->folder_.path();
  RETURN_IF_ERROR(WriteFile(path + "/ask.json", ask));
  ChildOptions child{.directory = sampler.directory, .log = path + "/log.txt"};
  for (const std::string& word : sampler.command) {
    child.command.push_back(
        Replaced(Replaced(word, "{ask}", path + "/ask.json"), "{answer}", path + "/answer.json"));
  }
  ASSIGN_OR_RETURN(run->child_, ChildProcess::Start(child));
  return run;
}

std::optional<absl::StatusOr<std::string>> SamplerRun::Poll() {
  const std::optional<int> status = child_->Poll();
  if (!status) {
    if (SecondsBetween(begun_, clock_.Steady()) < sampler_.timeout_s) return std::nullopt;
    child_->Kill();
    return DeadlineExceeded("sampler {}: no answer within {} s", sampler_.name, sampler_.timeout_s);
  }
  if (*status != 0) {
    return Unavailable("sampler {}: {}{}", sampler_.name, DescribeExit(*status),
                       LastLineOf(folder_.path() + "/log.txt"));
  }
  absl::StatusOr<std::string> answer = ReadFile(folder_.path() + "/answer.json");
  if (!answer.ok()) return DataLoss("sampler {}: ended without an answer", sampler_.name);
  if (answer->size() > kMostAnswerBytes) {
    return DataLoss("sampler {}: an answer of {} bytes, allowed are {}", sampler_.name,
                    answer->size(), kMostAnswerBytes);
  }
  return answer;
}

}  // namespace parallax
