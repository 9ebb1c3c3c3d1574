#include "common/image/jpeg.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "common/base/file.h"

namespace parallax {

absl::StatusOr<std::string> EncodeJpeg(const ImageRgb8& image, int quality) {
  if (image.empty()) return absl::InvalidArgumentError("JPEG of an empty image");
  const cv::Mat rgb(image.height(), image.width(), CV_8UC3, const_cast<uint8_t*>(image.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  try {
    cv::imencode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
  } catch (const cv::Exception& error) {
    return MakeError(absl::StatusCode::kInternal, "JPEG: " + error.err);
  }
  return std::string(bytes.begin(), bytes.end());
}

absl::Status WriteJpeg(const std::string& path, const ImageRgb8& image, int quality) {
  ASSIGN_OR_RETURN(const std::string bytes, EncodeJpeg(image, quality));
  return WriteFile(path, bytes);
}

absl::StatusOr<ImageRgb8> ReadPictureRgb8(const std::string& path) {
  ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  cv::Mat bgr;
  try {
    bgr = cv::imdecode(
        cv::Mat(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data())),
        cv::IMREAD_COLOR);
  } catch (const cv::Exception& error) {
    return MakeError(absl::StatusCode::kInvalidArgument, path + ": " + error.err);
  }
  if (bgr.empty()) {
    return MakeError(absl::StatusCode::kInvalidArgument, path + ": not a picture that can be read");
  }
  ImageRgb8 image(bgr.cols, bgr.rows);
  cv::Mat out(bgr.rows, bgr.cols, CV_8UC3, image.data());
  cv::cvtColor(bgr, out, cv::COLOR_BGR2RGB);
  return image;
}

}  // namespace parallax
