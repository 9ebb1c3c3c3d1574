// Images in memory: rows from the top, pixels from the left, channels interleaved. Images are
// values: a copy is deep, a move is cheap.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace parallax {

// An image with `channels` values of T for each pixel. The centre of pixel (x, y) is at (x + 0.5,
// y + 0.5). Not thread-safe, but threads may write different pixels at a time.
template <typename T, int channels = 1>
class Image {
 public:
  static constexpr int kChannels = channels;
  using Value = T;

  // Makes an empty image: no pixels, size 0 x 0.
  Image() = default;
  // Makes an image whose values are all `fill`. Requires sizes >= 0.
  Image(int width_px, int height_px, T fill = T{})
      : width_(width_px),
        height_(height_px),
        data_(static_cast<size_t>(width_px) * static_cast<size_t>(height_px) * channels, fill) {}

  int width() const { return width_; }
  int height() const { return height_; }
  bool empty() const { return data_.empty(); }
  size_t pixels() const { return static_cast<size_t>(width_) * static_cast<size_t>(height_); }

  // Return the channels of pixel (x, y), or one of them. Requires 0 <= x < width and 0 <= y <
  // height, which is not checked.
  T* At(int x, int y) { return data_.data() + Offset(x, y); }
  const T* At(int x, int y) const { return data_.data() + Offset(x, y); }
  T& operator()(int x, int y, int channel = 0) { return At(x, y)[channel]; }
  const T& operator()(int x, int y, int channel = 0) const { return At(x, y)[channel]; }

  // Returns all values: row by row, in each row pixel by pixel, in each pixel channel by channel.
  T* data() { return data_.data(); }
  const T* data() const { return data_.data(); }
  std::vector<T>& values() { return data_; }
  const std::vector<T>& values() const { return data_; }

  bool operator==(const Image&) const = default;

 private:
  size_t Offset(int x, int y) const {
    return (static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x)) *
           channels;
  }

  int width_ = 0;
  int height_ = 0;
  std::vector<T> data_;
};

using ImageF = Image<float>;
using ImageF3 = Image<float, 3>;
using ImageU8 = Image<uint8_t>;
using ImageRgb8 = Image<uint8_t, 3>;
using ImageU16 = Image<uint16_t>;

}  // namespace parallax
