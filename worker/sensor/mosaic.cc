#include "worker/sensor/mosaic.h"

#include <tbb/parallel_for.h>

namespace parallax {
namespace {

// Mirrored without repeating the rim, which keeps a pixel's colour.
int Mirrored(int i, int size) {
  if (size == 1) return 0;
  while (i < 0 || i >= size) i = i < 0 ? -i : 2 * (size - 1) - i;
  return i;
}

class Neighbourhood {
 public:
  Neighbourhood(const ImageF& mosaic, int x, int y) : mosaic_(mosaic), x_(x), y_(y) {}
  float operator()(int dx, int dy) const {
    return mosaic_(Mirrored(x_ + dx, mosaic_.width()), Mirrored(y_ + dy, mosaic_.height()));
  }
  // Sums over pixels that lie alike to all sides.
  float Across(int d) const { return (*this)(-d, 0) + (*this)(d, 0); }
  float Down(int d) const { return (*this)(0, -d) + (*this)(0, d); }
  float Diagonal() const {
    return (*this)(-1, -1) + (*this)(1, -1) + (*this)(-1, 1) + (*this)(1, 1);
  }

 private:
  const ImageF& mosaic_;
  const int x_, y_;
};

// The four filters of the source.
float GreenAtRedOrBlue(const Neighbourhood& n) {
  return (4 * n(0, 0) + 2 * (n.Across(1) + n.Down(1)) - (n.Across(2) + n.Down(2))) / 8;
}
// A colour whose pixels stand to the left and right of this green one.
float BesideGreen(const Neighbourhood& n) {
  return (5 * n(0, 0) + 4 * n.Across(1) - n.Diagonal() - n.Across(2) + 0.5f * n.Down(2)) / 8;
}
float AboveGreen(const Neighbourhood& n) {
  return (5 * n(0, 0) + 4 * n.Down(1) - n.Diagonal() - n.Down(2) + 0.5f * n.Across(2)) / 8;
}
// Red at blue, or blue at red.
float AtTheOther(const Neighbourhood& n) {
  return (6 * n(0, 0) + 2 * n.Diagonal() - 1.5f * (n.Across(2) + n.Down(2))) / 8;
}

}  // namespace

ImageF Mosaic(const ImageF3& picture) {
  ImageF mosaic(picture.width(), picture.height());
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) mosaic(x, y) = picture(x, y, MosaicChannel(x, y));
  }
  return mosaic;
}

ImageF3 Demosaic(const ImageF& mosaic) {
  ImageF3 picture(mosaic.width(), mosaic.height());
  tbb::parallel_for(0, mosaic.height(), [&](int y) {
    for (int x = 0; x < mosaic.width(); ++x) {
      const Neighbourhood n(mosaic, x, y);
      float* pixel = picture.At(x, y);
      const int own = MosaicChannel(x, y);
      pixel[own] = n(0, 0);
      if (own == 1) {
        const int beside = (y & 1) == 0 ? 0 : 2;
        pixel[beside] = BesideGreen(n);
        pixel[2 - beside] = AboveGreen(n);
      } else {
        pixel[1] = GreenAtRedOrBlue(n);
        pixel[2 - own] = AtTheOther(n);
      }
    }
  });
  return picture;
}

}  // namespace parallax
