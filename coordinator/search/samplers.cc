#include "coordinator/search/samplers.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "common/base/names.h"
#include "common/base/seconds.h"
#include "common/base/system/file.h"
#include "common/config/check/field_rules.h"
#include "common/config/yaml/yaml_document.h"
#include "common/config/yaml/yaml_values.h"
#include "coordinator/search/rung_study.h"

namespace parallax {
namespace {

constexpr size_t kMostAnswerBytes = 1 << 20;

// Reads the fields of a sampler's file; wrong ones become errors of `values`.
class SamplerReader {
 public:
  SamplerReader(const std::filesystem::path& file, config_internal::ConfigErrors* errors)
      : file_(file), values_(file.string(), errors) {}

  void Read(const YAML::Node& root, Sampler& sampler) {
    std::map<std::string, std::string> missing = {{"sampler", "the file's name"},
                                                  {"command", "a list of words"}};
    for (const auto& [field, node] : values_.Entries(root, "")) {
      missing.erase(field);
      if (field == "sampler") {
        ReadName(node, sampler.name);
      } else if (field == "command") {
        ReadCommand(node, sampler.command);
      } else if (field == "timeout_s") {
        ReadTimeout(node, sampler.timeout_s);
      } else {
        values_.UnknownField(node, "", field, {"sampler", "command", "timeout_s"});
      }
    }
    if (!root.IsMap()) return;
    for (const auto& [field, wanted] : missing) {
      values_.Error(root, field, "is missing, expected " + wanted);
    }
  }

 private:
  void ReadName(const YAML::Node& node, std::string& name) {
    name = values_.ReadText(node, "sampler").value_or("");
    if (!node.IsScalar()) return;
    if (!IsName(name)) {
      values_.Error(node, "sampler", WhyNotName(name));
    } else if (name != file_.stem()) {
      values_.Error(node, "sampler",
                    Quoted(name) + ", expected the file's name, " + Quoted(file_.stem().string()));
    } else if (name == kSobolSampler) {
      values_.Error(node, "sampler", Quoted(name) + " is built in, expected another name");
    }
  }

  void ReadCommand(const YAML::Node& node, std::vector<std::string>& command) {
    if (!node.IsSequence() || node.size() == 0) {
      values_.Error(node, "command", config_internal::Seen(node) + ", expected a list of words");
      return;
    }
    for (size_t i = 0; i < node.size(); ++i) {
      command.push_back(values_.ReadText(node[i], fmt::format("command[{}]", i)).value_or(""));
    }
    if (node[0].IsScalar() && command[0].empty()) {
      values_.Error(node[0], "command[0]", "\"\", expected a program");
    }
    for (const std::string place : {"{ask}", "{answer}"}) {
      const auto has = [&](const std::string& word) { return word.find(place) != word.npos; };
      if (std::any_of(command.begin(), command.end(), has)) continue;
      values_.Error(node, "command", "has no " + place + ", expected one at least");
    }
  }

  void ReadTimeout(const YAML::Node& node, double& timeout_s) {
    v1::FieldRule rule;
    rule.set_min(0.1);
    rule.set_max(3600);
    rule.set_unit("s");
    timeout_s = values_.ReadNumber(node, "timeout_s", rule).value_or(rule.min());
    const std::string why = config_internal::WhyNotNumber(timeout_s, rule);
    if (!why.empty()) values_.Error(node, "timeout_s", why);
  }

  const std::filesystem::path file_;
  config_internal::YamlValues values_;
};

absl::StatusOr<Sampler> ReadSampler(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string text, ReadFile(path));
  const std::filesystem::path file(path);
  Sampler sampler;
  sampler.directory = file.parent_path().string();
  config_internal::ConfigErrors errors;
  const auto root = config_internal::ParseYaml(text, path, errors);
  if (root) SamplerReader(file, &errors).Read(*root, sampler);
  if (!errors.empty()) return errors.ToStatus();
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
