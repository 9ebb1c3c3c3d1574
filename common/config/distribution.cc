#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/config/config.h"

namespace parallax {
namespace {

// Distribution function of the normal distribution.
double NormalCdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

// Its inverse for p in (0, 1), to double precision.
// Source: rational approximation by P. J. Acklam (relative error 1.15e-9), then one step of
// Halley's method.
double InverseNormalCdf(double p) {
  constexpr double a[] = {-3.969683028665376e+01, 2.209460984245205e+02,  -2.759285104469687e+02,
                          1.383577518672690e+02,  -3.066479806614716e+01, 2.506628277459239e+00};
  constexpr double b[] = {-5.447609879822406e+01, 1.615858368580409e+02, -1.556989798598866e+02,
                          6.680131188771972e+01, -1.328068155288572e+01};
  constexpr double c[] = {-7.784894002430293e-03, -3.223964580411365e-01, -2.400758277161838e+00,
                          -2.549732539343734e+00, 4.374664141464968e+00,  2.938163982698783e+00};
  constexpr double d[] = {7.784695709041462e-03, 3.224671290700398e-01, 2.445134137142996e+00,
                          3.754408661907416e+00};
  constexpr double kTail = 0.02425;
  const auto tail = [&](double q) {
    return (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
           ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1);
  };
  double x;
  if (p < kTail) {
    x = tail(std::sqrt(-2 * std::log(p)));
  } else if (p > 1 - kTail) {
    x = -tail(std::sqrt(-2 * std::log1p(-p)));
  } else {
    const double q = p - 0.5, r = q * q;
    x = (((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q /
        (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1);
  }
  if (x < -37) return x;  // exp(x * x / 2) is infinite from here on.
  const double error = NormalCdf(x) - p;
  const double step = error * std::sqrt(2 * std::numbers::pi) * std::exp(x * x / 2);
  return x - step / (1 + x * step / 2);
}

double DrawClipGaussian(const v1::Distribution::ClipGaussian& gaussian, double u) {
  double low = (gaussian.low() - gaussian.mean()) / gaussian.std();
  double high = (gaussian.high() - gaussian.mean()) / gaussian.std();
  // 1 - CDF loses all digits in the upper tail but not in the lower one: draws are mirrored.
  const bool mirror = low > 0;
  if (mirror) {
    std::swap(low, high);
    low = -low;
    high = -high;
    u = 1 - u;
  }
  const double p_low = NormalCdf(low), p_high = NormalCdf(high);
  const double p = p_low + u * (p_high - p_low);
  double x;
  if (p_high <= 0) {  // Beyond 38 standard deviations: the nearest end holds all there is.
    x = high;
  } else {
    x = p <= 0 ? low : InverseNormalCdf(std::min(p, std::nextafter(1.0, 0.0)));
  }
  if (mirror) x = -x;
  return std::clamp(gaussian.mean() + gaussian.std() * x, gaussian.low(), gaussian.high());
}

// Index of one of `count` equally likely things.
int64_t EqualPart(double u, int64_t count) {
  return std::clamp<int64_t>(static_cast<int64_t>(std::floor(u * static_cast<double>(count))), 0,
                             count - 1);
}

}  // namespace

double Draw(const v1::Distribution& distribution, double u) {
  switch (distribution.kind_case()) {
    case v1::Distribution::kConstant:
      return distribution.constant();
    case v1::Distribution::kUniform: {
      const auto& range = distribution.uniform();
      return std::min(range.low() + (range.high() - range.low()) * u, range.high());
    }
    case v1::Distribution::kUniformInt: {
      const auto& range = distribution.uniform_int();
      return static_cast<double>(range.low() + EqualPart(u, range.high() - range.low() + 1));
    }
    case v1::Distribution::kChoice: {
      const auto& values = distribution.choice().values();
      return values.empty() ? 0 : values.Get(static_cast<int>(EqualPart(u, values.size())));
    }
    case v1::Distribution::kClipGaussian:
      return DrawClipGaussian(distribution.clip_gaussian(), u);
    case v1::Distribution::kBernoulli:
      return u >= 1 - distribution.bernoulli().p() ? 1 : 0;
    case v1::Distribution::KIND_NOT_SET:
      break;
  }
  return 0;
}

Support SupportOf(const v1::Distribution& distribution) {
  switch (distribution.kind_case()) {
    case v1::Distribution::kConstant:
      return {distribution.constant(), distribution.constant()};
    case v1::Distribution::kUniform:
      return {distribution.uniform().low(), distribution.uniform().high()};
    case v1::Distribution::kUniformInt:
      return {static_cast<double>(distribution.uniform_int().low()),
              static_cast<double>(distribution.uniform_int().high())};
    case v1::Distribution::kChoice: {
      const auto& values = distribution.choice().values();
      if (values.empty()) return {};
      const auto [low, high] = std::minmax_element(values.begin(), values.end());
      return {*low, *high};
    }
    case v1::Distribution::kClipGaussian:
      return {distribution.clip_gaussian().low(), distribution.clip_gaussian().high()};
    case v1::Distribution::kBernoulli: {
      const double p = distribution.bernoulli().p();
      return {p < 1 ? 0.0 : 1.0, p > 0 ? 1.0 : 0.0};
    }
    case v1::Distribution::KIND_NOT_SET:
      break;
  }
  return {};
}

}  // namespace parallax
