#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "common/base/rng.h"
#include "common/config/config.h"

namespace parallax {
namespace {

v1::Distribution ParsedDistribution(const std::string& yaml) {
  const auto config = ParseSceneConfig("rigs: {altitude_m: " + yaml + "}", "d");
  EXPECT_TRUE(config.ok()) << config.status();
  return config->rigs().altitude_m();
}

double Cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

TEST(Draw, GivesTheInverseOfTheDistributionFunction) {
  const double below_one = std::nextafter(1.0, 0.0);
  const struct {
    const char* yaml;
    double u, want;
  } rows[] = {
      {"1.25", 0.7, 1.25},
      {"{uniform: [1, 3]}", 0, 1},
      {"{uniform: [1, 3]}", 0.25, 1.5},
      {"{uniform_int: [2, 4]}", 0, 2},
      {"{uniform_int: [2, 4]}", 0.34, 3},
      {"{uniform_int: [2, 4]}", below_one, 4},
      {"{choice: [3, 1, 2]}", 0.1, 3},
      {"{choice: [3, 1, 2]}", 0.5, 1},
      {"{choice: [3, 1, 2]}", below_one, 2},
      {"{clip_gaussian: [2, 0.5, 1, 3]}", 0.5, 2},
      {"{clip_gaussian: [2, 0.5, 1, 3]}", 0, 1},
      {"{clip_gaussian: [0, 1e-3, 5, 6]}", 0.5, 5},  // 5000 standard deviations off.
      {"{clip_gaussian: [9, 1e-3, 5, 6]}", 0.5, 6},
      {"{clip_gaussian: [5, 0.1, 0.5, 6]}", 0, 0.5},  // 45 standard deviations off.
  };
  for (const auto& row : rows) {
    EXPECT_NEAR(Draw(ParsedDistribution(row.yaml), row.u), row.want, 1e-12)
        << row.yaml << " at " << row.u;
  }
  v1::Distribution coin;
  coin.mutable_bernoulli()->set_p(0.3);
  EXPECT_EQ(Draw(coin, 0.69), 0);
  EXPECT_EQ(Draw(coin, 0.71), 1);
  EXPECT_EQ(Draw(v1::Distribution(), 0.5), 0);
}

TEST(Draw, TruncatedGaussianHasItsTails) {
  const double below_one = std::nextafter(1.0, 0.0);
  const auto upper_half = ParsedDistribution("{clip_gaussian: [1, 0.1, 1, 6]}");
  EXPECT_NEAR(Draw(upper_half, below_one), 1.82, 0.01) << "8.2 standard deviations";
  // Hardly any probability can be so small.
  const auto far_off = ParsedDistribution("{clip_gaussian: [1, 0.1, 4.775, 4.8]}");
  EXPECT_NEAR(Draw(far_off, 0.5), 4.777, 0.002);
}

TEST(Draw, TruncatedGaussianFollowsItsDistributionFunction) {
  const struct {
    double mean, std, low, high;
  } cases[] = {{1.5, 0.8, 0.5, 2.2}, {90, 15, 60, 95}, {0, 1, 3, 8}, {0, 1, -8, -3}, {0, 1, 7, 9}};
  for (const auto& c : cases) {
    v1::Distribution d;
    auto* g = d.mutable_clip_gaussian();
    g->set_mean(c.mean);
    g->set_std(c.std);
    g->set_low(c.low);
    g->set_high(c.high);
    // Upper tails are compared through the mirrored function, which keeps its digits there.
    const double sign = c.low > c.mean ? -1 : 1;
    const auto f = [&](double x) { return Cdf(sign * (x - c.mean) / c.std); };
    double last = c.low;
    for (double u = 1.0 / 64; u < 1; u += 1.0 / 64) {
      const double x = Draw(d, u);
      EXPECT_GE(x, last);
      last = x;
      EXPECT_NEAR((f(x) - f(c.low)) / (f(c.high) - f(c.low)), u, 1e-9) << c.mean << " " << c.low;
    }
  }
}

TEST(Draw, EveryKindHasItsMeanAndStaysInItsSupport) {
  const struct {
    const char* yaml;
    double mean;
  } rows[] = {{"{uniform: [1, 3]}", 2},
              {"{uniform_int: [1, 3]}", 2},
              {"{choice: [1, 2, 6]}", 3},
              {"{clip_gaussian: [2, 0.4, 1, 3]}", 2}};
  for (const auto& row : rows) {
    const v1::Distribution d = ParsedDistribution(row.yaml);
    const Support support = SupportOf(d);
    Rng rng(SceneSeed{3}, row.yaml);
    double sum = 0;
    for (int i = 0; i < 20000; ++i) {
      const double x = Draw(d, rng.Uniform());
      ASSERT_GE(x, support.low);
      ASSERT_LE(x, support.high);
      sum += x;
    }
    EXPECT_NEAR(sum / 20000, row.mean, 0.06) << row.yaml;
  }
}

}  // namespace
}  // namespace parallax
