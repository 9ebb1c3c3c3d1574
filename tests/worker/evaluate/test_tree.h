// Small trees of pictures and truth in the layouts of the benchmarks.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "common/base/system/temporary_folder.h"
#include "common/image/io.h"
#include "worker/dataset/frame/plain_formats.h"

namespace parallax {

inline constexpr float kInf = std::numeric_limits<float>::infinity();
inline constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// One row of values, as an image.
inline ImageF Row(const std::vector<float>& values) {
  ImageF image(static_cast<int>(values.size()), 1);
  image.values() = values;
  return image;
}
inline ImageU8 RowU8(const std::vector<uint8_t>& values) {
  ImageU8 image(static_cast<int>(values.size()), 1);
  image.values() = values;
  return image;
}

// A folder that is removed with it; files by paths relative to it, folders made as needed.
class TestTree {
 public:
  const std::string& dir() const { return folder_.path(); }
  std::string Path(const std::string& name) const {
    const std::string path = dir() + "/" + name;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    return path;
  }

  void Picture(const std::string& name, int width, int height) const {
    ImageRgb8 image(width, height);
    for (size_t i = 0; i < image.values().size(); ++i) {
      image.values()[i] = static_cast<uint8_t>(37 * i);
    }
    ASSERT_TRUE(WritePng(Path(name), image).ok());
  }
  // Left and right.
  void Pictures(const std::string& left, const std::string& right, int width, int height) const {
    Picture(left, width, height);
    Picture(right, width, height);
  }
  void Pfm(const std::string& name, const ImageF& image) const {
    ASSERT_TRUE(WritePfm(Path(name), image).ok());
  }
  void Mask(const std::string& name, const ImageU8& image) const {
    ASSERT_TRUE(WritePng(Path(name), image).ok());
  }
  // 16 bits, `scale` steps a pixel, 0 for what is not finite.
  void Png16(const std::string& name, const ImageF& image, float scale = 256) const {
    ImageU16 png(image.width(), image.height());
    for (size_t i = 0; i < png.pixels(); ++i) {
      const float value = image.values()[i];
      png.values()[i] = std::isfinite(value) ? static_cast<uint16_t>(value * scale) : 0;
    }
    ASSERT_TRUE(WritePng(Path(name), png).ok());
  }
  void Npy(const std::string& name, const ImageF& image) const { Text(name, EncodeNpy(image)); }
  void Text(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name), std::ios::binary) << text;
  }
  void Remove(const std::string& name) const { std::filesystem::remove_all(dir() + "/" + name); }

 private:
  const TemporaryFolder folder_ = *TemporaryFolder::Make("evaluate");
};

}  // namespace parallax
