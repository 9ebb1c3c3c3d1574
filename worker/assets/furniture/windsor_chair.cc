#include <algorithm>
#include <cmath>

#include "worker/assets/furniture/chair_kinds.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A hollowed plank, narrower behind, its outline a superellipse.
void AddPlank(AssetBuilder& b, const ChairParams& p, float thick) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m;
  const BoxOptions box{.bevel_m = 0.014f, .bevel_steps = 2, .pieces = {18, 18, 1}};
  Shape seat = RoundedBox({2.0f, 2.0f, thick}, box).Bent([&](const Vec3f& q) {
    // Square to superellipse, keeping the rounded edge.
    const float u = std::clamp(q.x(), -1.0f, 1.0f), v = std::clamp(q.y(), -1.0f, 1.0f);
    const float x = u * std::sqrt(1 - 0.32f * v * v), y = v * std::sqrt(1 - 0.32f * u * u);
    const float narrow = 1 - 0.07f * (1 - y) * 0.5f;
    const float saddle =
        std::max(0.0f, 1 - 1.15f * x * x) * std::max(0.0f, 1 - (y + 0.2f) * (y + 0.2f) * 0.95f);
    const float ridge = std::exp(-30.0f * x * x) * Smooth01((y - 0.1f) * 1.4f);
    const float z = q.z() > 0 ? q.z() - 0.016f * saddle * (1 - 0.5f * ridge) : q.z();
    return Vec3f(x * w * narrow, y * d, z);
  });
  TextureAlongLongest(seat);
  b.Add(seat.Moved(0, 0, p.seat_height_m - 0.5f * thick), WoodSlot("frame"));
}

// A rung that is thickest in its middle.
Shape SwellingRung(const Vec3f& from, const Vec3f& to) {
  SweepOptions options;
  options.scale = [](float t) { return Vec2f::Constant(0.62f + 0.38f * std::sin(kPi * t)).eval(); };
  Path3 path;
  for (int i = 0; i <= 10; ++i) path.push_back(from + (to - from) * (0.1f * static_cast<float>(i)));
  return Sweep(path, EllipseSection(0.026f, 0.026f, 14), options);
}

// Four splayed legs up to `under`, joined by an H of rungs.
void AddSplayedLegs(AssetBuilder& b, const ChairParams& p, float under) {
  const MaterialSlot wood = WoodSlot("frame");
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m;
  const Vec3f front_top(0.66f * w, 0.6f * d, under), front_foot(0.95f * w, 0.98f * d, 0);
  const Vec3f back_top(0.58f * w, -0.58f * d, under), back_foot(0.9f * w, -1.12f * d, 0);
  b.AddMirroredX(FurnitureLeg(LegStyle::kTurned, front_foot, front_top, 0.04f, p.leg_variant),
                 wood);
  b.AddMirroredX(FurnitureLeg(LegStyle::kTurned, back_foot, back_top, 0.04f, p.leg_variant), wood);
  const auto on = [](const Vec3f& foot, const Vec3f& top, float z) {
    return Vec3f(foot + (top - foot) * (z / top.z()));
  };
  const Vec3f f = on(front_foot, front_top, 0.2f), r = on(back_foot, back_top, 0.2f);
  b.AddMirroredX(SwellingRung(f, r), wood);
  const Vec3f mid = 0.5f * (f + r);
  b.Add(SwellingRung({-mid.x(), mid.y(), mid.z()}, mid), wood);
}

// The bow goes up from the seat's back corners, over, and down, leaning back; `a` in [0, pi] runs
// from right to left.
Vec3f BowPoint(const ChairParams& p, float a) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.seat_height_m;
  const float rise = p.back_height_m - h;
  const float s = std::sin(a), c = std::cos(a);
  const float z = h - 0.02f + (rise + 0.02f) * std::pow(std::max(s, 0.0f), 0.62f);
  const float x = 0.82f * w * std::copysign(std::pow(std::abs(c), 0.72f), c);
  const float t = (z - h) / rise;
  return Vec3f(x, -0.62f * d - 0.22f * d * s - p.lean_m * 1.3f * t, z);
}

// The bow, and sticks from the plank to it.
void AddBowBack(AssetBuilder& b, const ChairParams& p) {
  const MaterialSlot wood = WoodSlot("frame");
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.seat_height_m;
  Path3 bow;
  for (int i = 0; i <= 40; ++i) bow.push_back(BowPoint(p, kPi * static_cast<float>(i) / 40.0f));
  b.Add(Sweep(bow, RectSection(0.022f, 0.026f, 0.009f, 3)), wood);
  const int n = p.back_parts + 3;
  for (int i = 0; i < n; ++i) {
    const float a = Lerp(0.2f, 0.8f, (static_cast<float>(i) + 0.5f) / static_cast<float>(n)) * kPi;
    const Vec3f to = BowPoint(p, a);
    const float x = 0.62f * to.x();
    const Vec3f from(x, -0.86f * d * std::sqrt(std::max(0.1f, 1 - (x / w) * (x / w) * 0.9f)),
                     h - 0.015f);
    b.Add(Rod(from, to, 0.0085f, 0.006f), wood);
  }
}

}  // namespace

void AddWindsorChair(AssetBuilder& b, const ChairParams& p) {
  const float thick = 0.042f;
  AddPlank(b, p, thick);
  AddSplayedLegs(b, p, p.seat_height_m - thick + 0.012f);
  AddBowBack(b, p);
}

}  // namespace parallax
