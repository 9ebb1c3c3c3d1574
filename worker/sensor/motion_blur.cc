#include "worker/sensor/motion_blur.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace parallax {
namespace {

constexpr int kMostMoments = 64;
constexpr double kMostShift_px = 64;
constexpr int kIterations = 3;
constexpr double kFound_px = 0.75;

// For each pixel the shift of its own point; and the inverse depth of the nearest point that may
// come over it.
class Shifts {
 public:
  Shifts(const EyeMotion& motion, const ImageF& depth_m)
      : motion_(motion), depth_m_(depth_m), own_(depth_m.height(), depth_m.width(), CV_32FC2) {
    cv::Mat nearness(own_.size(), CV_32F);
    for (int y = 0; y < own_.rows; ++y) {
      for (int x = 0; x < own_.cols; ++x) {
        const Vec2d shift = At(x, y, double{depth_m(x, y)});
        longest_px_ = std::max(longest_px_, shift.norm());
        own_.at<cv::Vec2f>(y, x) = {static_cast<float>(shift.x()), static_cast<float>(shift.y())};
        nearness.at<float>(y, x) = depth_m(x, y) > 0 ? 1 / depth_m(x, y) : 0.0f;
      }
    }
    const int reach = static_cast<int>(std::ceil(longest_px_ / 2));
    const cv::Mat window = cv::Mat::ones(2 * reach + 1, 2 * reach + 1, CV_8U);
    cv::dilate(nearness, nearest_, window);
  }

  double longest_px() const { return longest_px_; }

  // The picture's coordinates of the point that is seen at (x, y) when the share `t` of the
  // exposure has passed since its middle. Two points are tried: one that moves as what is at (x,
  // y), and one that moves as the nearest around does.
  Vec2d Seen(int x, int y, double t) const {
    const double near = double{nearest_.at<float>(y, x)};
    const Candidate own = Follow(x, y, t, Own(x, y));
    if (near <= 0) return own.place;
    const Candidate other = Follow(x, y, t, At(x, y, 1 / near));
    const bool over =
        other.off_px < kFound_px && (own.off_px >= kFound_px || IsNearer(other.place, own.place));
    return over ? other.place : own.place;
  }

 private:
  struct Candidate {
    Vec2d place;
    double off_px;  // From (x, y), when it is followed.
  };

  Vec2d At(int x, int y, double depth_m) const {
    const Vec2d shift = ImageShift(motion_, x + 0.5, y + 0.5, depth_m);
    const double length = shift.norm();
    return length > kMostShift_px ? Vec2d(shift * (kMostShift_px / length)) : shift;
  }

  Vec2d Own(int x, int y) const {
    const cv::Vec2f shift = own_.at<cv::Vec2f>(y, x);
    return {double{shift[0]}, double{shift[1]}};
  }

  std::pair<int, int> PixelOf(const Vec2d& place) const {
    return {std::clamp(static_cast<int>(std::lround(place.x())), 0, own_.cols - 1),
            std::clamp(static_cast<int>(std::lround(place.y())), 0, own_.rows - 1)};
  }

  Candidate Follow(int x, int y, double t, Vec2d shift) const {
    const Vec2d here(x, y);
    Vec2d place = here;
    for (int i = 0; i < kIterations; ++i) {
      place = here - t * shift;
      const auto [px, py] = PixelOf(place);
      shift = Own(px, py);
    }
    return {place, (place + t * shift - here).norm()};
  }

  bool IsNearer(const Vec2d& a, const Vec2d& b) const {
    const auto [ax, ay] = PixelOf(a);
    const auto [bx, by] = PixelOf(b);
    const float depth_a = depth_m_(ax, ay), depth_b = depth_m_(bx, by);
    return depth_a > 0 && (depth_b <= 0 || depth_a < depth_b);
  }

  const EyeMotion& motion_;
  const ImageF& depth_m_;
  cv::Mat own_, nearest_;
  double longest_px_ = 0;
};

}  // namespace

bool EyeMotion::IsStill() const {
  return !(exposure_s > 0) || (velocity_m_s.isZero() && turn_rad_s.isZero());
}

Vec2d ImageShift(const EyeMotion& motion, double x_px, double y_px, double depth_m) {
  const Vec3d ray((x_px - motion.cx_px) / motion.fx_px, (y_px - motion.cy_px) / motion.fy_px, 1);
  // The point's velocity in the eye's frame, for depth 1.
  Vec3d moves = -motion.turn_rad_s.cross(ray);
  if (depth_m > 0) moves -= motion.velocity_m_s / depth_m;
  return motion.exposure_s * Vec2d(motion.fx_px * (moves.x() - ray.x() * moves.z()),
                                   motion.fy_px * (moves.y() - ray.y() * moves.z()));
}

void BlurByMotion(const EyeMotion& motion, const ImageF& depth_m, ImageF3& light) {
  if (motion.IsStill()) return;
  const Shifts shifts(motion, depth_m);
  const int moments =
      std::clamp(static_cast<int>(std::ceil(shifts.longest_px())) + 1, 2, kMostMoments);
  cv::Mat sharp(light.height(), light.width(), CV_32FC3, light.data()),
      sum = cv::Mat::zeros(sharp.size(), CV_32FC3);
  cv::Mat places(sharp.size(), CV_32FC2), moment;
  for (int k = 0; k < moments; ++k) {
    const double t = (k + 0.5) / moments - 0.5;
    tbb::parallel_for(0, light.height(), [&](int y) {
      for (int x = 0; x < light.width(); ++x) {
        const Vec2d place = shifts.Seen(x, y, t);
        places.at<cv::Vec2f>(y, x) = {static_cast<float>(place.x()), static_cast<float>(place.y())};
      }
    });
    cv::remap(sharp, moment, places, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    sum += moment;
  }
  sum /= moments;
  sum.copyTo(sharp);
}

}  // namespace parallax
