#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/base/file.h"
#include "common/image/io.h"

namespace parallax {
namespace {

template <typename T>
constexpr int kCvDepth = sizeof(T) == 1 ? CV_8U : CV_16U;

// A view of the image's own memory.
template <typename T, int channels>
cv::Mat MatOf(const Image<T, channels>& image) {
  return cv::Mat(image.height(), image.width(), CV_MAKETYPE(kCvDepth<T>, channels),
                 const_cast<T*>(image.data()));
}

absl::StatusOr<std::string> Encode(const cv::Mat& mat, int compression,
                                   const std::vector<int>& more = {}) {
  if (mat.empty()) return absl::InvalidArgumentError("PNG of an empty image");
  std::vector<uint8_t> bytes;
  std::vector<int> options = {cv::IMWRITE_PNG_COMPRESSION, compression, cv::IMWRITE_PNG_STRATEGY,
                              cv::IMWRITE_PNG_STRATEGY_DEFAULT};
  options.insert(options.end(), more.begin(), more.end());
  try {
    cv::imencode(".png", mat, bytes, options);
  } catch (const cv::Exception& error) {
    return MakeError(absl::StatusCode::kInternal, "PNG: " + error.err);
  }
  return std::string(bytes.begin(), bytes.end());
}

template <typename T, int channels>
absl::StatusOr<Image<T, channels>> Decode(std::string_view bytes) {
  if (bytes.substr(0, 4) != "\x89PNG") return absl::InvalidArgumentError("not a PNG");
  cv::Mat mat;
  try {
    mat = cv::imdecode(
        cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())),
        cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& error) {
    return MakeError(absl::StatusCode::kInvalidArgument, "broken PNG: " + error.err);
  }
  if (mat.empty()) return absl::InvalidArgumentError("broken PNG");
  if (mat.depth() != kCvDepth<T> || mat.channels() != channels) {
    return MakeError(absl::StatusCode::kInvalidArgument,
                     "PNG of " + std::to_string(8 * mat.elemSize1()) + " bits and " +
                         std::to_string(mat.channels()) + " channels, wanted " +
                         std::to_string(8 * sizeof(T)) + " bits and " + std::to_string(channels));
  }
  Image<T, channels> image(mat.cols, mat.rows);
  cv::Mat out = MatOf(image);
  if (channels == 3) {
    cv::cvtColor(mat, out, cv::COLOR_BGR2RGB);
  } else {
    mat.copyTo(out);
  }
  return image;
}

template <typename T, int channels>
absl::StatusOr<Image<T, channels>> Read(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  absl::StatusOr<Image<T, channels>> image = Decode<T, channels>(bytes);
  if (!image.ok()) return WithContext(image.status(), path);
  return image;
}

template <typename ImageType>
absl::Status Write(const std::string& path, const ImageType& image, int compression) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodePng(image, compression));
  return WriteFile(path, bytes);
}

}  // namespace

absl::StatusOr<std::string> EncodePng(const ImageRgb8& image, int compression) {
  cv::Mat bgr;
  if (!image.empty()) cv::cvtColor(MatOf(image), bgr, cv::COLOR_RGB2BGR);
  return Encode(bgr, compression);
}
absl::StatusOr<std::string> EncodePng(const ImageU8& image, int compression) {
  return Encode(MatOf(image), compression);
}
absl::StatusOr<std::string> EncodePng(const ImageU16& image, int compression) {
  return Encode(MatOf(image), compression);
}

absl::StatusOr<std::string> EncodePngBits(const ImageU8& image) {
  if (image.empty()) return absl::InvalidArgumentError("PNG of an empty image");
  ImageU8 full(image.width(), image.height());
  for (size_t i = 0; i < image.pixels(); ++i) full.values()[i] = image.values()[i] ? 255 : 0;
  return Encode(MatOf(full), kPngCompression, {cv::IMWRITE_PNG_BILEVEL, 1});
}

absl::StatusOr<ImageRgb8> DecodePngRgb8(std::string_view bytes) {
  return Decode<uint8_t, 3>(bytes);
}
absl::StatusOr<ImageU8> DecodePngU8(std::string_view bytes) { return Decode<uint8_t, 1>(bytes); }
absl::StatusOr<ImageU16> DecodePngU16(std::string_view bytes) { return Decode<uint16_t, 1>(bytes); }

absl::StatusOr<ImageRgb8> ReadPngRgb8(const std::string& path) { return Read<uint8_t, 3>(path); }
absl::StatusOr<ImageU8> ReadPngU8(const std::string& path) { return Read<uint8_t, 1>(path); }
absl::StatusOr<ImageU16> ReadPngU16(const std::string& path) { return Read<uint16_t, 1>(path); }

absl::Status WritePng(const std::string& path, const ImageRgb8& image, int compression) {
  return Write(path, image, compression);
}
absl::Status WritePng(const std::string& path, const ImageU8& image, int compression) {
  return Write(path, image, compression);
}
absl::Status WritePng(const std::string& path, const ImageU16& image, int compression) {
  return Write(path, image, compression);
}

}  // namespace parallax
