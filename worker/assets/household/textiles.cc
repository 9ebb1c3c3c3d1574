// Rugs and clothes.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// The distances to the sides and to the ends in metres, for patterns with a border (materials read
// them from uv).
void MarkBorder(Shape& rug, const std::function<Vec2f(const Vec3f&)>& to_edge) {
  for (Face& f : rug.faces) {
    for (int k = 0; k < f.corners; ++k) f.uv[k] = to_edge(rug.points[f.v[k]]).cwiseMax(1e-4f);
  }
}

// Outlines of rugs; kHide is an animal's skin.
enum class RugStyle { kSquare, kRound, kOval, kRunner, kHide, kCount };

// A rug; its pattern comes from its material.
struct RugParams {
  RugStyle style = RugStyle::kSquare;
  float width_m = 2.0f, depth_m = 1.4f;
  float thickness_m = 0.01f;
  float fringe_m = 0;  // Length of the threads at the short ends; 0 = none.
  uint64_t seed = 0;
};

// Lies a little uneven; corners and edges lift here and there.
Vec3f Laid(const Vec3f& q, const RugParams& p, const Noise& noise) {
  if (q.z() <= 0.5f * p.thickness_m) return q;
  const float edge = std::max(2 * std::abs(q.x()) / p.width_m, 2 * std::abs(q.y()) / p.depth_m);
  const float lift = Smooth01((edge - 0.9f) / 0.1f) * std::max(0.0f, noise.At(q * 1.2f));
  return Vec3f(q.x(), q.y(), q.z() + 0.0015f * noise.At(q * 3) + 0.002f * lift);
}

// Turned: circles, ovals, and hides whose outline wanders.
Shape RoundRug(const RugParams& p, const Noise& noise) {
  const float r = 0.5f * p.width_m, t = p.thickness_m, squash = p.depth_m / p.width_m;
  Path2 profile{{0, 0}, {r - 0.004f, 0}};
  const Path2 lip = Arc({r - 0.5f * t, 0.5f * t}, 0.5f * t, 0.5f * t, -0.5f * kPi, 0.5f * kPi, 6);
  profile.insert(profile.end(), lip.begin(), lip.end());
  for (int k = 12; k >= 0; --k)
    profile.emplace_back((r - 0.5f * t) * static_cast<float>(k) / 13.0f, t);
  LatheOptions options{.segments = 96};
  if (p.style == RugStyle::kHide) {
    // Four legs, a neck and a tail stump.
    options.modulate = [&](float a, float) {
      const Vec3f way(std::cos(a), std::sin(a), 0.5f);
      return 0.8f + 0.1f * std::cos(4 * a + kPi) + 0.06f * std::cos(2 * a) +
             0.05f * noise.At(way * 2.1f) + 0.02f * noise.At(way * 6);
    };
  }
  Shape rug = Lathe(profile, options);
  MarkBorder(rug, [&](const Vec3f& q) {
    return Vec2f::Constant(squash * (r - std::hypot(q.x(), q.y()))).eval();
  });
  return rug.Bent([&](const Vec3f& q) { return Laid({q.x(), squash * q.y(), q.z()}, p, noise); });
}

Shape SquareRug(const RugParams& p, const Noise& noise) {
  Shape rug =
      RoundedBox({p.width_m, p.depth_m, p.thickness_m},
                 {.bevel_m = 0.45f * p.thickness_m, .bevel_steps = 2, .pieces = {24, 16, 1}})
          .Moved(0, 0, 0.5f * p.thickness_m);
  MarkBorder(rug, [&](const Vec3f& q) {
    return Vec2f(0.5f * p.width_m - std::abs(q.x()), 0.5f * p.depth_m - std::abs(q.y()));
  });
  return rug.Bent([&](const Vec3f& q) { return Laid(q, p, noise); });
}

// Threads at the short ends.
Shape RugFringe(const RugParams& p, Rng& rng) {
  const int count = static_cast<int>(p.depth_m / 0.022f);
  Shape fringe;
  for (const float side : {-1.0f, 1.0f}) {
    for (int i = 0; i < count; ++i) {
      const float y =
          p.depth_m * ((static_cast<float>(i) + 0.5f) / static_cast<float>(count) - 0.5f);
      const float x = side * (0.5f * p.width_m - 0.004f),
                  length = p.fringe_m * Draw(rng, 0.85, 1.15), sway = Draw(rng, -0.012, 0.012);
      fringe.Add(Tube({{x, y, 0.004f},
                       {x + side * 0.5f * length, y + 0.3f * sway, 0.0035f},
                       {x + side * length, y + sway, 0.003f}},
                      0.0026f, 0.001f, 6));
    }
  }
  return fringe;
}

Asset MakeRug(const RugParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "rug");
  const Noise noise(rng);
  const bool square = p.style == RugStyle::kSquare || p.style == RugStyle::kRunner;
  b.Add(square ? SquareRug(p, noise) : RoundRug(p, noise),
        Slot("pile", {"RugPattern", "carpet", "fabric"}));
  if (square && p.fringe_m > 0) b.Add(RugFringe(p, rng), Slot("fringe", {"fabric"}));
  return b.Finish();
}

Asset SampleRug(Rng& rng) {
  RugParams p;
  const RugStyle styles[] = {RugStyle::kSquare, RugStyle::kSquare, RugStyle::kRound,
                             RugStyle::kOval,   RugStyle::kRunner, RugStyle::kHide};
  p.style = rng.Pick(styles);
  p.width_m = Draw(rng, 1.6, 2.7);
  p.depth_m = p.width_m * Draw(rng, 0.58, 0.74);
  if (p.style == RugStyle::kRound) p.depth_m = p.width_m = Draw(rng, 1.2, 2.2);
  if (p.style == RugStyle::kRunner) p.depth_m = std::max(0.6f, 0.32f * p.width_m);
  if (p.style == RugStyle::kHide) p.depth_m = p.width_m * Draw(rng, 0.75, 0.95);
  p.thickness_m = Draw(rng, 0.007, 0.014);
  p.fringe_m = rng.Bernoulli(0.5) ? Draw(rng, 0.05, 0.07) : 0.0f;
  p.seed = rng.Seed();
  return MakeRug(p);
}

}  // namespace

void RegisterTextiles(std::vector<AssetClass>& classes) {
  classes.push_back({"Rug", "textiles", Placement::kFloor, true, 0, SampleRug,
                     SizeRange({1.1f, 0.55f, 0.005f}, {3, 2.6f, 0.03f})});
  classes.push_back({"Shirt", "textiles", Placement::kOnTop, true, 0, SampleShirt,
                     SizeRange({0.42f, 0.55f, 0.01f}, {1.75f, 0.85f, 0.09f})});
  classes.push_back({"Pants", "textiles", Placement::kOnTop, true, 0, SamplePants,
                     SizeRange({0.34f, 0.34f, 0.01f}, {0.85f, 1.15f, 0.09f})});
}

}  // namespace parallax
