#include <fmt/core.h>

#include <cmath>

#include "common/config/check/checks.h"
#include "common/config/check/field_rules.h"
#include "common/config/check/limits.h"
#include "common/config/config.h"

namespace parallax::config_internal {

const char kDistributionForms[] =
    "a number, {uniform: [low, high]}, {uniform_int: [low, high]}, {choice: [a, b, ...]}, "
    "{clip_gaussian: [mean, std, low, high]} or {bernoulli: p}";

namespace {

constexpr int64_t kMaxWhole = 1'000'000'000'000'000;  // Doubles count whole numbers up to 9e15.

// One distribution; stops at its first wrong value.
class Checker {
 public:
  Checker(const v1::Distribution& distribution, const std::string& path, const v1::FieldRule& rule,
          Findings* findings)
      : distribution_(distribution), path_(path), rule_(rule), findings_(findings) {}

  void Run() {
    switch (distribution_.kind_case()) {
      case v1::Distribution::kConstant:
        if (const std::string why = WhyNotNumber(distribution_.constant(), rule_); !why.empty()) {
          Tell("", why);
        }
        return;
      case v1::Distribution::kUniform:
        return CheckUniform();
      case v1::Distribution::kUniformInt:
        return CheckUniformInt();
      case v1::Distribution::kChoice:
        return CheckChoice();
      case v1::Distribution::kClipGaussian:
        return CheckClipGaussian();
      case v1::Distribution::kBernoulli:
        return CheckBernoulli();
      case v1::Distribution::KIND_NOT_SET:
        return Tell("", std::string("nothing, allowed is ") + kDistributionForms);
    }
  }

 private:
  void Tell(const std::string& below, std::string what) {
    findings_->push_back({path_ + below, std::move(what)});
  }

  // False if one is no number; it has been told then.
  bool AreNumbers(const std::string& kind, std::initializer_list<double> numbers) {
    int i = 0;
    for (const double number : numbers) {
      const std::string why = WhyNotNumber(number, {});
      if (!why.empty()) {
        Tell(fmt::format(".{}[{}]", kind, i), why);
        return false;
      }
      ++i;
    }
    return true;
  }

  bool IsOrdered(const std::string& kind, double low, double high, bool may_be_equal,
                 const char* form) {
    if (low < high || (may_be_equal && low == high)) return true;
    Tell("." + kind, "low " + NumberText(low) + " is not below high " + NumberText(high) +
                         ", allowed is " + form + " with low < high");
    return false;
  }

  void CheckUniform() {
    const auto& range = distribution_.uniform();
    if (!AreNumbers("uniform", {range.low(), range.high()}) ||
        !IsOrdered("uniform", range.low(), range.high(), true, "[low, high]")) {
      return;
    }
    CheckSupport(/*continuous=*/true);
  }

  void CheckUniformInt() {
    const auto& range = distribution_.uniform_int();
    for (const int64_t end : {range.low(), range.high()}) {
      if (end < -kMaxWhole || end > kMaxWhole) {
        return Tell(".uniform_int", "too large, allowed is -1e15 to 1e15");
      }
    }
    if (IsOrdered("uniform_int", static_cast<double>(range.low()),
                  static_cast<double>(range.high()), true, "[low, high]")) {
      CheckSupport(/*continuous=*/false);
    }
  }

  void CheckChoice() {
    const auto& values = distribution_.choice().values();
    if (values.empty() || values.size() > kMaxListItems) {
      return Tell(".choice",
                  fmt::format("a list of {}, allowed is {}", values.size(),
                              values.empty() ? "[a, b, ...] with at least one number"
                                             : fmt::format("at most {} numbers", kMaxListItems)));
    }
    v1::FieldRule any;
    any.set_integer(rule_.integer());
    for (int i = 0; i < values.size(); ++i) {
      const std::string why = WhyNotNumber(values[i], any);
      if (!why.empty()) return Tell(fmt::format(".choice[{}]", i), why);
    }
    CheckSupport(/*continuous=*/false);
  }

  void CheckClipGaussian() {
    const auto& gaussian = distribution_.clip_gaussian();
    if (!AreNumbers("clip_gaussian",
                    {gaussian.mean(), gaussian.std(), gaussian.low(), gaussian.high()}) ||
        !IsOrdered("clip_gaussian", gaussian.low(), gaussian.high(), false,
                   "[mean, std, low, high]")) {
      return;
    }
    if (!(gaussian.std() > 0)) {
      return Tell(".clip_gaussian", "std " + NumberText(gaussian.std()) + ", allowed is above 0");
    }
    CheckSupport(/*continuous=*/true);
  }

  void CheckBernoulli() {
    v1::FieldRule probability;
    probability.set_min(0);
    probability.set_max(1);
    const std::string why = WhyNotNumber(distribution_.bernoulli().p(), probability);
    if (!why.empty()) return Tell(".bernoulli", why);
    CheckSupport(/*continuous=*/false);
  }

  // Checks the values that the distribution can give against the field's range.
  void CheckSupport(bool continuous) {
    if (rule_.integer() && continuous) {
      return Tell("",
                  "gives fractions, allowed are whole numbers: a number, {uniform_int: [low, "
                  "high]}, {choice: [a, b, ...]} or {bernoulli: p}");
    }
    const Support support = SupportOf(distribution_);
    if (InRange(support.low, rule_) && InRange(support.high, rule_)) return;
    Tell("", "reaches from " + NumberText(support.low) + " to " + NumberText(support.high) +
                 ", allowed " + AllowedRange(rule_));
  }

  const v1::Distribution& distribution_;
  const std::string& path_;
  const v1::FieldRule& rule_;
  Findings* const findings_;
};

}  // namespace

void CheckDistribution(const v1::Distribution& distribution, const std::string& path,
                       const v1::FieldRule& rule, Findings* findings) {
  Checker(distribution, path, rule, findings).Run();
}

}  // namespace parallax::config_internal
