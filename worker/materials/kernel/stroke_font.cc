#include "worker/materials/kernel/stroke_font.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace parallax {
namespace {

// Polylines as pairs of digits x y; a blank lifts the pen.
struct Glyph {
  char character;
  std::string_view path;
};
constexpr Glyph kGlyphs[] = {
    {'A', "002640 1232"},
    {'B', "000636454433033342413000"},
    {'C', "4536160501103041"},
    {'D', "00062644422000"},
    {'E', "46060040 0333"},
    {'F', "460600 0333"},
    {'G', "453616050110304143 4323"},
    {'H', "0006 4046 0343"},
    {'I', "2026 1030 1636"},
    {'J', "4641301001"},
    {'K', "0006 460340"},
    {'L', "060040"},
    {'M', "0006234640"},
    {'N', "00064046"},
    {'O', "100105163645413010"},
    {'P', "00063645443303"},
    {'Q', "100105163645413010 2240"},
    {'R', "00063645443303 2340"},
    {'S', "453616050413334241301001"},
    {'T', "0646 2620"},
    {'U', "060110304146"},
    {'V', "062046"},
    {'W', "0610243046"},
    {'X', "0046 0640"},
    {'Y', "062346 2320"},
    {'Z', "06460040"},
    {'0', "100105163645413010"},
    {'1', "152620 1030"},
    {'2', "05163645440040"},
    {'3', "05163645443313 334241301001"},
    {'4', "30360242"},
    {'5', "460603334241301001"},
    {'6', "4536160501103041423303"},
    {'7', "064610"},
    {'8', "13040516364544331302011030414233"},
    {'9', "0110304145361605041343"},
    {'-', "1333"},
    {'.', "2021"},
    {'/', "0046"},
    {'+', "1333 2224"},
    {'%', "0046 1516 3031"},
    {'_', "0040"},
};

struct Font {
  std::array<std::vector<Stroke>, 128> strokes;

  Font() {
    for (const Glyph& glyph : kGlyphs) {
      auto& out = strokes[static_cast<size_t>(glyph.character)];
      for (size_t i = 0; i + 3 < glyph.path.size();) {
        if (glyph.path[i + 2] == ' ') {
          i += 3;
          continue;
        }
        const auto digit = [&](size_t at) { return static_cast<float>(glyph.path[at] - '0'); };
        out.push_back({digit(i), digit(i + 1), digit(i + 2), digit(i + 3)});
        i += 2;
      }
    }
  }
};

}  // namespace

std::span<const Stroke> GlyphStrokes(char character) {
  static const Font& font = *new Font;
  if (character >= 'a' && character <= 'z') character = static_cast<char>(character - 'a' + 'A');
  const auto index = static_cast<unsigned char>(character);
  return index < 128 ? std::span<const Stroke>(font.strokes[index]) : std::span<const Stroke>();
}

float TextDistance(std::string_view text, float x, float y) {
  const int letter = static_cast<int>(std::floor((x + 0.7f) / kGlyphAdvance));
  if (letter < 0 || letter >= static_cast<int>(text.size()) || y < -1 || y > kGlyphHeight + 1) {
    return kGlyphHeight;
  }
  x -= static_cast<float>(letter) * kGlyphAdvance;
  float best = kGlyphHeight * kGlyphHeight;
  for (const Stroke& s : GlyphStrokes(text[static_cast<size_t>(letter)])) {
    const float dx = s.x1 - s.x0, dy = s.y1 - s.y0;
    const float t =
        std::clamp(((x - s.x0) * dx + (y - s.y0) * dy) / (dx * dx + dy * dy), 0.0f, 1.0f);
    const float ex = x - s.x0 - t * dx, ey = y - s.y0 - t * dy;
    best = std::min(best, ex * ex + ey * ey);
  }
  return std::sqrt(best);
}

}  // namespace parallax
