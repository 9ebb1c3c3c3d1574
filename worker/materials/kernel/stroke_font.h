// A small stroke font: capitals, digits and a little punctuation as line segments in a cell 4 wide
// and 6 high, baseline at 0. For lettering in printed pictures. Constant data; thread-safe.
#pragma once

#include <span>
#include <string_view>

namespace parallax {

// A line segment from (x0, y0) to (x1, y1).
struct Stroke {
  float x0, y0, x1, y1;
};

// Width of a cell with its gap.
constexpr float kGlyphAdvance = 5.4f;
constexpr float kGlyphHeight = 6.0f;

// Strokes of one character; small letters look like capitals. Empty for a space and for characters
// that the font lacks.
std::span<const Stroke> GlyphStrokes(char character);

// Returns the distance from a point to the nearest stroke of a line of text that starts at the
// origin, in cell units. Considers only the letter under the point; returns kGlyphHeight when the
// nearest stroke is more than about one unit away.
float TextDistance(std::string_view text, float x, float y);

// Returns the width of the whole line, in cell units.
inline float TextWidth(std::string_view text) {
  return text.empty() ? 0.0f : kGlyphAdvance * static_cast<float>(text.size()) - 1.4f;
}

}  // namespace parallax
