#include "worker/dataset/verify/verify_occlusion.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

constexpr double kReprojection = 0.01;     // Relative to the depth: the seed's threshold.
constexpr double kMostReprojected = 1e-3;  // Largest share of pixels that may disagree.
constexpr double kRounding_px = 1e-3;      // Depth is a float: it rounds where a point lands.

void CheckBinary(const CheckedFrame& frame, const ImageU8& image, const char* check,
                 const std::string& file) {
  frame.Pixels(
      check, file, [&](size_t i) { return image.values()[i] != 0 && image.values()[i] != 255; },
      [&](size_t i) { return fmt::format("{}, wanted 0 or 255", image.values()[i]); });
}

// The column, in pixels, at which the other view sees the point that pixel `i` has at depth `z`.
// `sign` is -1 from left to right, and 1 from right to left.
double OtherX(const CheckedFrame& frame, size_t i, double z, double sign) {
  const size_t column = i % static_cast<size_t>(frame.k.width);
  return static_cast<double>(column) + 0.5 + sign * frame.k.fx * frame.baseline_m / z;
}

// Points outside of the other view's picture are occluded. Maps can't tell what hides the rest:
// rays found it between their pixels.
void CheckExactOcclusion(const CheckedFrame& frame, const CheckedEye& eye, double sign) {
  if (eye.exact_occlusion.empty()) return;
  const std::string file = "exact_occlusion_" + eye.name + ".png";
  CheckBinary(frame, eye.exact_occlusion, "exact_occlusion", file);
  if (eye.depth.empty()) return;
  frame.Pixels(
      "exact_occlusion", file,
      [&](size_t i) {
        const double z = double{eye.depth.values()[i]};
        if (!(z > 0) || eye.exact_occlusion.values()[i] != 0) return false;
        const double x = OtherX(frame, i, z, sign);
        return x < -kRounding_px || x > frame.k.width + kRounding_px;
      },
      [&](size_t) { return std::string("visible, but outside of the other picture"); });
}

// Recomputes left-right consistency from depth alone.
void CheckConsistency(const CheckedFrame& frame, const CheckedEye& eye, const CheckedEye& other,
                      double sign) {
  if (eye.occlusion.empty()) return;
  const std::string file = "occlusion_" + eye.name + ".png";
  CheckBinary(frame, eye.occlusion, "occlusion", file);
  if (eye.depth.empty() || other.depth.empty()) return;
  const auto visible = [&](size_t i) {
    const auto w = static_cast<size_t>(frame.k.width);
    const double z = double{eye.depth.values()[i]};
    const float* row = &other.depth.values()[i / w * w];
    if (!(z > 0)) return !(row[i % w] > 0);
    const double x = OtherX(frame, i, z, sign);
    if (x < 0 || x >= frame.k.width) return false;
    const double c = std::clamp(x - 0.5, 0.0, frame.k.width - 1.0);
    const auto x0 = static_cast<size_t>(c), x1 = std::min(x0 + 1, w - 1);
    const double a = double{row[x0]}, b = double{row[x1]};
    const auto agrees = [&](double d) { return d > 0 && std::abs(d - z) <= kReprojection * z; };
    if (agrees(a) || agrees(b)) return true;
    const double t = c - static_cast<double>(x0);
    return a > 0 && b > 0 && agrees(1 / ((1 - t) / a + t / b));
  };
  frame.Pixels(
      "occlusion", file, [&](size_t i) { return (eye.occlusion.values()[i] == 0) != visible(i); },
      [&](size_t i) {
        return std::string(eye.occlusion.values()[i] ? "occluded" : "visible") +
               ", re-projection says otherwise";
      },
      kMostReprojected);
}

}  // namespace

void CheckOcclusion(const CheckedFrame& frame) {
  CheckConsistency(frame, frame.eyes[0], frame.eyes[1], -1);
  CheckConsistency(frame, frame.eyes[1], frame.eyes[0], 1);
  CheckExactOcclusion(frame, frame.eyes[0], -1);
  CheckExactOcclusion(frame, frame.eyes[1], 1);
}

}  // namespace parallax
