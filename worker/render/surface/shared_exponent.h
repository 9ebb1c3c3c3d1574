// Radiance in 32 bits: three mantissas of 9 bits under one exponent, rounded to nearest, off by at
// most 1/512 of the largest channel. Range up to 65408, in steps of 2^-24 or more.
// Source: Khronos, EXT_texture_shared_exponent, appendix.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/math/types.h"

namespace parallax {

// Packs a colour. Negative channels become 0, too bright ones the largest value.
inline uint32_t PackRadiance(const Vec3f& rgb) {
  constexpr float kLargest = 65408.0f;
  const Vec3f c = rgb.cwiseMax(0.0f).cwiseMin(kLargest);
  // The exponent whose mantissa of 9 bits holds the largest channel, rounding included.
  int exponent = std::max(-15, std::ilogb(std::max(c.maxCoeff(), 0x1p-30f)) + 1);
  if (std::lrint(std::ldexp(c.maxCoeff(), 9 - exponent)) > 511) ++exponent;
  const auto mantissa = [&](float x) {
    return static_cast<uint32_t>(std::lrint(std::ldexp(x, 9 - exponent)));
  };
  return mantissa(c.x()) | mantissa(c.y()) << 9 | mantissa(c.z()) << 18 |
         static_cast<uint32_t>(exponent + 15) << 27;
}

// Unpacks a colour; the inverse of PackRadiance except for its rounding.
inline Vec3f UnpackRadiance(uint32_t packed) {
  // 2^(exponent - 15 - 9), put together bit by bit.
  const float scale = __builtin_bit_cast(float, ((packed >> 27) + 127 - 24) << 23);
  return Vec3f(static_cast<float>(packed & 511), static_cast<float>(packed >> 9 & 511),
               static_cast<float>(packed >> 18 & 511)) *
         scale;
}

}  // namespace parallax
