// Drawing for pictures that people look at: an RGB canvas with text, boxes, images and colour maps.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/image/image.h"

namespace parallax {

using Rgb = std::array<uint8_t, 3>;

// Colours of the sheets: light text on a dark ground, so that the images are brightest.
inline constexpr Rgb kGround = {22, 24, 29};
inline constexpr Rgb kPanel = {33, 36, 43};
inline constexpr Rgb kText = {228, 230, 235};
inline constexpr Rgb kFaint = {140, 146, 158};
inline constexpr Rgb kAccent = {92, 169, 255};
inline constexpr Rgb kWarn = {255, 159, 64};

// An RGB picture to draw on. Clips everything to its bounds.
class Canvas {
 public:
  Canvas(int width, int height) : image_(width, height) { FillBox(0, 0, width, height, kGround); }

  void FillBox(int x, int y, int width, int height, const Rgb& color);
  // Draws with the top left at (x, y), resampled by area (by nearest neighbour if `exact`).
  void DrawImage(int x, int y, int width, int height, const ImageRgb8& image, bool exact = false);
  // Draws text. `y` is the baseline, `size_px` the height of capitals. Draws ASCII, and '?' for
  // other characters.
  void DrawText(int x, int y, std::string_view text, double size_px, const Rgb& color = kText,
                bool bold = false);
  static int TextWidth(std::string_view text, double size_px);

  const ImageRgb8& image() const { return image_; }

 private:
  ImageRgb8 image_;
};

// Cuts `text` to at most `width`, with ".." in place of the rest.
std::string FitText(std::string text, double size_px, int width);

// Returns the height of a tile whose shape is that of a picture; at least 1.
int TileHeight(int tile_width_px, int width, int height);
// Returns the indices of at most `most` of `count` things, spread evenly, first and last included.
std::vector<size_t> Spread(size_t count, int most);

// Returns an image with the colour of each pixel of `map`. `color` gets its channels.
template <typename Map, typename Color>
ImageRgb8 Colored(const Map& map, Color color) {
  ImageRgb8 out(map.width(), map.height());
  for (size_t i = 0; i < map.pixels(); ++i) {
    const Rgb rgb = color(map.data() + Map::kChannels * i);
    std::copy(rgb.begin(), rgb.end(), out.data() + 3 * i);
  }
  return out;
}

// Returns the end of a picture's colours: the disparity that one in `part` of the finite, positive
// ones exceeds. 1 without any.
double ColorScale(const ImageF& disparity_px, int part = 50);
// Returns a colour of Google's Turbo map: `value` in [0, 1] goes from dark blue to dark red.
Rgb Turbo(double value);
// Returns a distinct colour for an index; neighbours differ strongly. 0 is black.
Rgb IndexColor(uint32_t index);

// Returns disparities as Turbo colours of their square root, so that the far half of a room stays
// distinct beside a near chair. 0 is black.
ImageRgb8 ColorDisparity(const ImageF& disparity_px, double full_scale_px);
ImageRgb8 ColorIndices(const ImageU16& indices);
ImageRgb8 ColorOcclusion(const ImageU8& occlusion);
ImageRgb8 ColorNormals(
    const ImageF3& normals);  // (x, y, z) -> (r, g, b), the camera's -y and -z bright.

}  // namespace parallax
