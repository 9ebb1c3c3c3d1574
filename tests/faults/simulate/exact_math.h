// Logarithm and power from sums, products and exact operations only: a C library may round its own
// in another way on each machine, and a seed's story must be the same bytes everywhere.
#pragma once

#include <cmath>

namespace parallax::faults {

inline constexpr double kLn2 = 0.69314718055994530942;

// Requires x > 0.
inline double Log(double x) {
  int exponent = 0;
  const double mantissa = std::frexp(x, &exponent);  // In [0.5, 1).
  const double s = (mantissa - 1) / (mantissa + 1);
  double sum = 0, power = s;
  for (int i = 1; i < 40; i += 2, power *= s * s) sum += power / i;
  return 2 * sum + exponent * kLn2;
}

// Requires base > 0, and a result within a double's range.
inline double Power(double base, double exponent) {
  const double log = exponent * Log(base);
  const double twos = std::floor(log / kLn2);
  const double rest = log - twos * kLn2;
  double sum = 1, term = 1;
  for (int i = 1; i < 25; ++i) sum += term *= rest / i;
  return std::ldexp(sum, static_cast<int>(twos));
}

}  // namespace parallax::faults
