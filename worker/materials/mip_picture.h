// A picture from near and far: halved again and again down to a pixel. Constant; thread-safe.
#pragma once

#include <vector>

#include "common/image/image.h"
#include "common/math/types.h"

namespace parallax {

class MipPicture {
 public:
  enum class Values {
    kColor,   // sRGB, made linear and kept to what real surfaces reflect.
    kNumber,  // As they stand, in [0, 1].
  };
  enum class Edge { kClamp, kRepeat };

  // At most 1024 pixels wide or high: larger ones are halved. Requires a picture that is not empty.
  MipPicture(const ImageRgb8& image, Values values, Edge edge);

  // At (u, v), of which 1 is the picture's width and height and v goes up from the bottom; the mean
  // over about `width`, in units of u.
  Vec3f At(float u, float v, float width) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<Vec3f> pixels;
  };
  Level Halved(const Level& fine) const;
  const Vec3f& Pixel(const Level& level, int x, int y) const;
  Vec3f Bilinear(const Level& level, float u, float v) const;

  const Edge edge_;
  std::vector<Level> levels_;
};

}  // namespace parallax
