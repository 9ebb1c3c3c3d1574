#include <algorithm>
#include <cmath>

#include "worker/assets/furniture/chair_kinds.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A curve in (y, z) that is walked by its length.
struct ShellProfile {
  explicit ShellProfile(Path2 points) : curve(std::move(points)), arc(curve.size(), 0) {
    for (size_t i = 1; i < curve.size(); ++i)
      arc[i] = arc[i - 1] + (curve[i] - curve[i - 1]).norm();
  }
  // The point at the share `v` of the length.
  Vec2f At(float v) const {
    const float s = v * arc.back();
    size_t i = 1;
    while (i + 1 < arc.size() && arc[i] < s) ++i;
    const float t = (s - arc[i - 1]) / (arc[i] - arc[i - 1]);
    return Vec2f(curve[i - 1] + t * (curve[i] - curve[i - 1]));
  }
  Path2 curve;
  std::vector<float> arc;
};

// From the seat's front edge, above its height, up the back.
ShellProfile ShellProfileOf(const ChairParams& p) {
  const float rise = p.back_height_m - p.seat_height_m;
  return ShellProfile(Spline(Path2{{0.235f, -0.028f},
                                   {0.2f, -0.002f},
                                   {0.06f, -0.004f},
                                   {-0.08f, -0.012f},
                                   {-0.165f, 0.02f},
                                   {-0.205f, 0.11f},
                                   {-0.228f, 0.55f * rise},
                                   {-0.255f, rise}},
                             6));
}

void AddMouldedShell(AssetBuilder& b, const ChairParams& p) {
  const float h = p.seat_height_m, w = 0.5f * p.width_m;
  const ShellProfile profile = ShellProfileOf(p);
  SheetOptions sheet;
  sheet.pieces_u = 28;
  sheet.pieces_v = 44;
  sheet.thickness_m = 0.007f;
  sheet.size_m = {p.width_m, profile.arc.back()};
  const bool arms = p.arms;
  const Shape shell = Sheet(
      [&](float u, float v) {
        // A disc-like parameter square keeps the corners round.
        const float a = 2 * u - 1, c = 2 * v - 1;
        const float x = a * std::sqrt(1 - 0.42f * c * c * c * c);
        const float y = 0.5f + 0.5f * c * std::sqrt(1 - 0.16f * a * a);
        const Vec2f mid = profile.At(y);
        const float back = Smooth01((y - 0.42f) / 0.25f);
        const float curl = x * x * (0.6f + 0.4f * x * x);
        const float hips = std::exp(-18.0f * (y - 0.5f) * (y - 0.5f));
        const float narrow = 1 - 0.1f * back - 0.06f * (1 - y);
        const float lift = curl * (0.028f + (arms ? 0.17f : 0.075f) * hips) * (1 - 0.4f * back);
        const float wrap = curl * (0.055f * back + (arms ? 0.1f : 0.03f) * hips * back);
        return Vec3f(-x * w * narrow, mid.x() + wrap, h + mid.y() + lift);
      },
      sheet);
  // Seen from above the parameter runs clockwise, so the sheet's top is the sitting side.
  b.Add(shell, Slot("shell", {"plastic", "wood", "leather", "paint"}));
}

// Ends of the leg in the quarter (sx, sy).
struct ShellLeg {
  ShellLeg(float sx, float sy, float under)
      : from(sx * kFoot * 1.05f, sy * kFoot - 0.02f, 0), to(sx * kTop, sy * kTop - 0.01f, under) {}
  Vec3f At(float t) const { return from * (1 - t) + to * t; }
  static constexpr float kFoot = 0.21f, kTop = 0.12f;
  Vec3f from, to;
};

// Dowels or rods with a cross of wire on each side.
void AddShellLegs(AssetBuilder& b, const ChairParams& p) {
  const bool dowels = p.leg_variant % 2 == 0;
  const MaterialSlot legs = dowels ? Slot("legs", {"wood"}) : MetalSlot("legs");
  const float under = p.seat_height_m - 0.032f, low = 0.62f, high = 0.97f;
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      const auto [from, to] = ShellLeg(sx, sy, under);
      b.Add(dowels ? Rod(from, to, 0.01f, 0.016f, 0.003f) : Rod(from, to, 0.009f, 0.009f, 0.003f),
            legs);
      b.Add(Cylinder(0.02f, 0.026f, 0.003f).Moved(to.x(), to.y(), under - 0.006f),
            MetalSlot("brace"));
    }
  }
  const auto wire = [&](const ShellLeg& from, const ShellLeg& to) {
    b.Add(Rod(from.At(low), to.At(high), 0.0045f, 0.0045f), MetalSlot("brace"));
  };
  for (const float s : {-1.0f, 1.0f}) {
    wire({s, -1, under}, {s, 1, under});
    wire({s, 1, under}, {s, -1, under});
    wire({-1, s, under}, {1, s, under});
    wire({1, s, under}, {-1, s, under});
  }
}

}  // namespace

void AddShellChair(AssetBuilder& b, const ChairParams& p) {
  AddMouldedShell(b, p);
  AddShellLegs(b, p);
}

}  // namespace parallax
