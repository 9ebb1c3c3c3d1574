#include <algorithm>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "common/base/status.h"
#include "common/image/fill_holes.h"
#include "common/image/io.h"
#include "common/image/picture_pair.h"
#include "worker/evaluate/predictors/predictor.h"

namespace parallax {
namespace {

constexpr int kBlock_px = 5;
constexpr int kSubpixels = 16;  // OpenCV's disparities are sixteenths of a pixel.

// A multiple of 16, as OpenCV wants it.
int DisparitiesFor(int width_px) { return std::max(16, (width_px / 4 + 15) / 16 * 16); }

cv::Ptr<cv::StereoSGBM> MakeMatcher(int disparities) {
  // Penalties as OpenCV's manual recommends for three channels.
  const int block = kBlock_px * kBlock_px;
  return cv::StereoSGBM::create(/*minDisparity=*/0, disparities, kBlock_px, /*P1=*/8 * 3 * block,
                                /*P2=*/32 * 3 * block, /*disp12MaxDiff=*/1, /*preFilterCap=*/63,
                                /*uniquenessRatio=*/10, /*speckleWindowSize=*/100,
                                /*speckleRange=*/2, cv::StereoSGBM::MODE_SGBM);
}

cv::Mat MatOf(const ImageRgb8& image) {
  return cv::Mat(image.height(), image.width(), CV_8UC3, const_cast<uint8_t*>(image.data()));
}

// NaN where no match was found.
ImageF Match(const ImageRgb8& left, const ImageRgb8& right) {
  // The matcher skips the first `disparities` columns; with as many more in front it skips those.
  const int disparities = DisparitiesFor(left.width());
  cv::Mat wide_left, wide_right, matched;
  cv::copyMakeBorder(MatOf(left), wide_left, 0, 0, disparities, 0, cv::BORDER_REPLICATE);
  cv::copyMakeBorder(MatOf(right), wide_right, 0, 0, disparities, 0, cv::BORDER_REPLICATE);
  MakeMatcher(disparities)->compute(wide_left, wide_right, matched);
  ImageF disparity_px(left.width(), left.height(), std::numeric_limits<float>::quiet_NaN());
  for (int y = 0; y < left.height(); ++y) {
    for (int x = 0; x < left.width(); ++x) {
      const int16_t value = matched.at<int16_t>(y, x + disparities);
      if (value >= 0) disparity_px(x, y) = static_cast<float>(value) / kSubpixels;
    }
  }
  return disparity_px;
}

class SgbmPredictor : public Predictor {
 public:
  std::string name() const override { return "sgbm"; }

  absl::Status Predict(const std::vector<PredictionTask>& tasks,
                       const PredictionContext& context) override {
    int done = 0;
    for (const PredictionTask& task : tasks) {
      if (context.cancel.cancelled()) return Cancelled("sgbm: stopped");
      const absl::StatusOr<PicturePair> pair = ReadPicturePair(task.left, task.right);
      if (!pair.ok()) return WithContext(pair.status(), "pair " + task.name);
      RETURN_IF_ERROR(WritePfm(task.output, FillHoles(Match(pair->left, pair->right))));
      context.progress(++done);
    }
    return absl::OkStatus();
  }
};

}  // namespace

std::unique_ptr<Predictor> MakeSgbmPredictor() { return std::make_unique<SgbmPredictor>(); }

}  // namespace parallax
