#include "coordinator/client/scores/result_label.h"

#include <regex>

#include "common/base/names.h"

namespace parallax::client {

namespace {

bool IsName(const std::string& text) { return CheckName("name", text).ok(); }

}  // namespace

std::optional<ResultName> ParseResultLabel(const std::string& label) {
  static const std::regex kLabel(
      R"(([^ ,]+)(?:, seed (\d{1,9}))?(?: on ([^ ,]+))?(?:, checkpoint (\d{1,4}) of (\d{1,4}))?)");
  std::smatch match;
  if (!std::regex_match(label, match, kLabel)) return std::nullopt;
  ResultName name{.set = match[1], .benchmark = match[3]};
  if (match[2].matched) name.seed = std::stoll(match[2]);
  if (match[4].matched) {
    name.checkpoint = std::stoi(match[4]);
    name.checkpoints = std::stoi(match[5]);
  }
  if (!IsName(name.set) || (!name.benchmark.empty() && !IsName(name.benchmark)))
    return std::nullopt;
  return name;
}

void NameRun(const ResultName& name, const std::string& trainer, RunIdentity& run) {
  run.variant = name.set;
  if (name.seed) run.trainer = trainer;
  run.seed = name.seed;
}

}  // namespace parallax::client
