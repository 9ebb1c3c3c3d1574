#include "common/config/yaml/yaml_distribution.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/base/edit_distance.h"
#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"

namespace parallax::config_internal {
namespace {

// The nearest 64-bit number; NaN gives one that is too large for any field.
int64_t WholeOf(double value) {
  constexpr double kMost = 9e18;
  return static_cast<int64_t>(value >= -kMost && value <= kMost ? value
                                                                : std::copysign(kMost, value));
}

// The distributions that are lists of numbers, with the list's size (0: any).
constexpr struct {
  const char* kind;
  size_t size;
  const char* form;
} kForms[] = {{"uniform", 2, "[low, high]"},
              {"uniform_int", 2, "[low, high]"},
              {"choice", 0, "[a, b, ...] with at least one number"},
              {"clip_gaussian", 4, "[mean, std, low, high]"}};

// Reads the list of a distribution that is one. Nothing if anything in it is wrong.
std::optional<std::vector<double>> ReadNumbers(const YAML::Node& node, const std::string& path,
                                               const std::string& kind, YamlReader& reader) {
  const auto* form = std::find_if(std::begin(kForms), std::end(kForms),
                                  [&](const auto& f) { return kind == f.kind; });
  if (form == std::end(kForms)) {
    reader.Error(
        node, path,
        "no such distribution" +
            NearestHint(kind, {"uniform", "uniform_int", "choice", "clip_gaussian", "bernoulli"}) +
            ", allowed is " + kDistributionForms);
    return std::nullopt;
  }
  if (!node.IsSequence() || (form->size != 0 && node.size() != form->size)) {
    reader.Error(node, path,
                 (node.IsSequence() ? fmt::format("a list of {}", node.size()) : Seen(node)) +
                     ", allowed is " + form->form);
    return std::nullopt;
  }
  std::vector<double> numbers;
  for (size_t i = 0; i < node.size(); ++i) {
    const std::string number_path = fmt::format("{}[{}]", path, i);
    reader.Note(node[i], number_path);
    const std::optional<double> number = reader.ReadNumber(node[i], number_path, {});
    if (!number) continue;
    if (kind == "uniform_int" && *number != std::floor(*number)) {
      reader.Error(node[i], number_path,
                   Seen(node[i]) + " is not a whole number, allowed a whole number");
      continue;
    }
    numbers.push_back(*number);
  }
  if (numbers.size() < node.size()) return std::nullopt;
  return numbers;
}

v1::Distribution OfNumbers(const std::string& kind, const std::vector<double>& numbers) {
  v1::Distribution distribution;
  if (kind == "uniform") {
    distribution.mutable_uniform()->set_low(numbers[0]);
    distribution.mutable_uniform()->set_high(numbers[1]);
  } else if (kind == "uniform_int") {
    distribution.mutable_uniform_int()->set_low(WholeOf(numbers[0]));
    distribution.mutable_uniform_int()->set_high(WholeOf(numbers[1]));
  } else if (kind == "choice") {
    distribution.mutable_choice()->mutable_values()->Add(numbers.begin(), numbers.end());
  } else {
    auto* gaussian = distribution.mutable_clip_gaussian();
    gaussian->set_mean(numbers[0]);
    gaussian->set_std(numbers[1]);
    gaussian->set_low(numbers[2]);
    gaussian->set_high(numbers[3]);
  }
  return distribution;
}

}  // namespace

std::optional<v1::Distribution> ReadDistribution(const YAML::Node& node, const std::string& path,
                                                 const v1::FieldRule& rule, YamlReader& reader) {
  v1::Distribution distribution;
  if (node.IsScalar()) {
    const std::optional<double> value = reader.ReadNumber(node, path, rule);
    if (!value) return std::nullopt;
    distribution.set_constant(*value);
    return distribution;
  }
  if (!node.IsMap() || node.size() != 1) {
    reader.Error(node, path,
                 (node.IsMap() ? fmt::format("a map with {} keys", node.size()) : Seen(node)) +
                     ", allowed is " + kDistributionForms);
    return std::nullopt;
  }
  const auto entries = reader.Entries(node, path);
  if (entries.empty()) return std::nullopt;
  const auto& [kind, value] = entries.front();
  const std::string kind_path = path + "." + kind;
  // The line of a distribution's own errors is that of its numbers.
  reader.Note(value, path);
  reader.Note(value, kind_path);
  if (kind != "bernoulli") {
    const auto numbers = ReadNumbers(value, kind_path, kind, reader);
    if (!numbers) return std::nullopt;
    return OfNumbers(kind, *numbers);
  }
  v1::FieldRule probability;
  probability.set_min(0);
  probability.set_max(1);
  const std::optional<double> p = reader.ReadNumber(value, kind_path, probability);
  if (!p) return std::nullopt;
  distribution.mutable_bernoulli()->set_p(*p);
  return distribution;
}

}  // namespace parallax::config_internal
