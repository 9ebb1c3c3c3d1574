#include "worker/materials/art/printed.h"

#include <array>

#include "worker/materials/kernel/stroke_font.h"

namespace parallax {

using namespace noise;  // NOLINT: the vocabulary of patterns.

std::string DrawWord(Rng& rng, int syllables) {
  static constexpr std::array<const char*, 24> kOnsets = {
      "B", "C", "D", "F",  "G",  "K",  "L",  "M",  "N",  "P",  "R", "S",
      "T", "V", "Z", "BR", "CL", "GR", "ST", "TR", "SH", "PL", "H", "J"};
  static constexpr std::array<const char*, 8> kVowels = {"A", "E", "I", "O", "U", "IA", "EO", "A"};
  static constexpr std::array<const char*, 10> kEnds = {"",  "",  "",  "",  "N",
                                                        "R", "S", "L", "X", "NT"};
  std::string word;
  for (int i = 0; i < syllables; ++i) {
    word += rng.Pick(kOnsets);
    word += rng.Pick(kVowels);
    if (i + 1 == syllables) word += rng.Pick(kEnds);
  }
  return word;
}

Vec3f Lettering::Over(const Vec3f& under, float at_u, float at_v, float w) const {
  const float margin = 0.02f + w;
  if (at_u < u - margin || at_u > u + width + margin || at_v < v - margin ||
      at_v > v + height + margin)
    return under;
  const float unit_u = width / TextWidth(text), unit_v = height / kGlyphHeight;
  const float unit = std::sqrt(unit_u * unit_v);
  const float d = TextDistance(text, (at_u - u) / unit_u, (at_v - v) / unit_v);
  const float soft = std::max(0.12f, 1.2f * w / unit);
  // A pen finer than the footprint greys its surroundings by its share.
  const float thin = std::min(1.0f, 2.0f * stroke / soft + 0.3f);
  return Mix(under, color,
             thin * (1.0f - noise::SmoothStep(stroke - 0.5f * soft, stroke + 0.5f * soft, d)));
}

Vec3f SmallPrint::Over(const Vec3f& under, float u, float v, float w) const {
  if (u < u0 || u > u1 || v < v0 || v > v1) return under;
  const float row = (v1 - v) / line;
  const int j = noise::FloorInt(row);
  const uint32_t id = Hash(j, seed);
  const float end = UnitByte(id, 0) < 0.22f ? 0.3f + 0.6f * UnitByte(id, 1) : 1.0f;
  if ((u - u0) > end * (u1 - u0)) return under;
  // Letters are bumps of noise along the line; words are their gaps.
  const float x = (u - u0) / line;
  const float letter = Gradient2(x * 5.5f, static_cast<float>(j) * 3.7f, seed + 1);
  const float word = Gradient2(x * 0.9f, static_cast<float>(j) * 5.3f, seed + 2);
  const float body = std::fabs(row - static_cast<float>(j) - 0.5f);
  const float ink = noise::SmoothStep(-0.12f, 0.12f, letter) *
                    noise::SmoothStep(-0.42f, -0.32f, word) *
                    (1.0f - noise::SmoothStep(0.2f, 0.28f, body));
  const float fade = Fade(0.5f * line, w);
  return Mix(under, color, 0.24f + fade * (ink - 0.24f));
}

}  // namespace parallax
