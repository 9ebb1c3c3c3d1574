#include "worker/evaluate/shrink_picture.h"

#include <opencv2/imgproc.hpp>

namespace parallax {

ImageRgb8 ShrinkPicture(const ImageRgb8& picture, int factor) {
  ImageRgb8 small((picture.width() + factor - 1) / factor,
                  (picture.height() + factor - 1) / factor);
  const cv::Mat from(picture.height(), picture.width(), CV_8UC3,
                     const_cast<uint8_t*>(picture.data()));
  cv::Mat to(small.height(), small.width(), CV_8UC3, small.data());
  cv::resize(from, to, to.size(), 0, 0, cv::INTER_AREA);
  return small;
}

}  // namespace parallax
