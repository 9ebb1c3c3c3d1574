// A picture with its mip levels: halved repeatedly down to one pixel. Constant; thread-safe.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "common/math/types.h"

namespace parallax {

// Filters a picture at any footprint.
class MipPicture {
 public:
  enum class Values {
    kColor,   // sRGB, converted to linear and limited to albedos.
    kNumber,  // Linear values in [0, 1].
  };
  enum class Edge { kClamp, kRepeat, kMirror };
  // How the picture goes on beyond its edges along u and along v.
  struct Edges {
    Edge u = Edge::kRepeat, v = Edge::kRepeat;
  };

  // Builds the levels. A picture of more than 1024 pixels in width or height is first halved until
  // it fits. Requires a picture that is not empty.
  MipPicture(const ImageRgb8& image, Values values, Edges edges);

  // Returns the value at (u, v), where the picture is [0, 1]^2 and v goes up from the bottom;
  // averaged over a square of about `width`, in units of u.
  Vec3f At(float u, float v, float width) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<Vec3f> pixels;
  };
  // Returns the level above one of `width` x `height` with the values `pixel`(x, y).
  template <typename PixelAt>
  static Level Halved(int width, int height, const PixelAt& pixel);
  Level Halved(const Level& fine) const;
  const Vec3f& Pixel(const Level& level, int x, int y) const;
  Vec3f Bilinear(const Level& level, float u, float v) const;

  const Edges edges_;
  std::vector<Level> levels_;
};

}  // namespace parallax
