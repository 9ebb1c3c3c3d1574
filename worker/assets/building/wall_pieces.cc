// Objects with a picture that hang on walls or stand before them: art, mirrors, screens.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// One bar of a frame with mitred ends, along x from -half to +half at its outer edge, section
// (inwards, y out of the wall); the outer edge is z = 0, inwards is -z.
Shape MitredBar(float half, const Path2& section) {
  Shape bar;
  const uint32_t m = static_cast<uint32_t>(section.size());
  for (const float side : {-1.0f, 1.0f}) {
    for (const Vec2f& q : section) {
      const Vec3f p(side * (half - q.x()), q.y(), -q.x());
      bar.AddPoint(p, {p.x(), q.x(), q.y()});
    }
  }
  for (uint32_t s = 0; s < m; ++s) {
    const uint32_t t = (s + 1) % m;
    bar.AddQuad(s, t, m + t, m + s);
  }
  for (const auto& [i, j, k] : Triangulate(section)) {
    bar.AddTriangle(i, k, j);
    bar.AddTriangle(m + i, m + j, m + k);
  }
  if (bar.Volume() < 0) {
    for (Face& f : bar.faces) std::reverse(f.v.begin(), f.v.begin() + f.corners);
  }
  bar.crease_rad = 0.6f;
  return bar;
}

Path2 FrameSection(int profile, float w, float d) {
  switch (profile) {
    case 1: {
      Path2 p{{w, 0.0f}, {0.0f, 0.0f}};
      // Drawn from the outer edge over the top to the inner edge.
      const Path2 arc = Arc({0.5f * w, 0.45f * d}, 0.5f * w, 0.55f * d, kPi, 0.0f, 10);
      p.insert(p.end(), arc.begin(), arc.end());
      std::reverse(p.begin(), p.end());
      return p;
    }
    case 2:
      return {{0, 0},
              {w, 0},
              {w, 0.55f * d},
              {0.72f * w, 0.6f * d},
              {0.72f * w, 0.78f * d},
              {0.35f * w, 0.82f * d},
              {0.33f * w, d},
              {0.04f * w, d},
              {0, 0.96f * d}};
    case 3: {
      Path2 p{{0, 0}, {w, 0}, {w, 0.5f * d}, {0.94f * w, 0.55f * d}};
      for (int k = 0; k <= 8; ++k) {
        const float s = static_cast<float>(k) / 8.0f;
        p.emplace_back(Lerp(0.88f * w, 0.24f * w, s), Lerp(0.5f, 0.95f, s * s) * d);
      }
      p.emplace_back(0.2f * w, d);
      p.emplace_back(0.03f * w, d);
      p.emplace_back(0, 0.95f * d);
      return p;
    }
    default:
      return {{0, 0}, {w, 0}, {w, 0.93f * d}, {0.94f * w, d}, {0.06f * w, d}, {0, 0.93f * d}};
  }
}

// A framed picture or mirror.
struct FrameParams {
  float width_m = 0.6f, height_m = 0.45f;  // Outside.
  float frame_m = 0.03f;  // Width of the frame's bars; 0 = a bare stretched canvas.
  float depth_m = 0.025f;
  int profile = 0;      // 0 flat, 1 rounded, 2 stepped, 3 hollow moulding.
  float mat_m = 0.05f;  // Card border inside the frame; 0 = none.
  bool mirror = false;
  uint64_t seed = 0;
};

Asset MakeFramed(const FrameParams& p) {
  AssetBuilder b(p.seed);
  const float w = 0.5f * p.width_m, h = 0.5f * p.height_m;
  const MaterialSlot picture = p.mirror ? Slot("mirror", {"mirror"}) : PictureSlot();
  // The surface faces +y; seen from there +x is on the left.
  const auto panel = [&](float half_w, float half_h, float y0, float y1, float bevel,
                         const MaterialSlot& edge, const MaterialSlot& face) {
    Shape s = Board({-half_w, y0, -half_h}, {half_w, y1, half_h}, bevel);
    PrintFaces(s, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
    b.Add(s, {edge, face});
  };
  if (p.frame_m <= 0) {
    // Canvas folded round its stretcher: the edges carry the picture's colours.
    panel(w, h, 0, p.depth_m, 0.004f, Slot("edge", {"fabric", "paper"}), picture);
    return b.Finish(Anchor::kWall);
  }
  const MaterialSlot frame = Slot("frame", {"wood", "metal", "paint"});
  const Path2 section = FrameSection(p.profile, p.frame_m, p.depth_m);
  for (int side = 0; side < 4; ++side) {
    const bool level = side % 2 == 0;
    const Shape bar = MitredBar(level ? w : h, section).Moved(0, 0, level ? h : w);
    b.Add(bar.TurnedY(0.5f * kPi * static_cast<float>(side)), frame);
  }
  const float inner_w = w - p.frame_m + 0.004f, inner_h = h - p.frame_m + 0.004f,
              y = 0.3f * p.depth_m;
  b.Add(Board({-inner_w, 0.0005f, -inner_h}, {inner_w, y - 0.003f, inner_h}, 0),
        Slot("backing", {"wood", "paper"}));
  if (p.mirror) {
    panel(inner_w, inner_h, y - 0.004f, y, 0.0015f, Slot("edge", {"glass", "metal"}), picture);
    return b.Finish(Anchor::kWall);
  }
  const float mat = std::min(p.mat_m, 0.35f * std::min(inner_w, inner_h));
  panel(inner_w - mat, inner_h - mat, y - 0.004f, y, 0, Slot("paper", {"paper"}), picture);
  if (mat > 0) {
    // Card with a bevelled window: four mitred pieces.
    const Path2 card{{0, 0}, {mat + 0.002f, 0}, {mat, 0.002f}, {0, 0.002f}};
    for (int side = 0; side < 4; ++side) {
      const bool level = side % 2 == 0;
      const Shape bar = MitredBar(level ? inner_w : inner_h, card)
                            .Moved(0, y + 0.0004f, level ? inner_h : inner_w);
      b.Add(bar.TurnedY(0.5f * kPi * static_cast<float>(side)), Slot("mat", {"paper"}));
    }
  }
  return b.Finish(Anchor::kWall);
}

Asset SampleWallArt(Rng& rng) {
  FrameParams p;
  const float area = Draw(rng, 0.12, 0.75), aspect = Draw(rng, 0.65, 1.7);
  p.width_m = std::sqrt(area * aspect);
  p.height_m = std::sqrt(area / aspect);
  p.frame_m = rng.Bernoulli(0.2) ? 0.0f : Draw(rng, 0.015, 0.055);
  p.depth_m = Draw(rng, 0.018, 0.038);
  p.profile = rng.UniformInt(0, 3);
  p.mat_m = rng.Bernoulli(0.5) ? Draw(rng, 0.03, 0.09) : 0.0f;
  p.seed = rng.Seed();
  return MakeFramed(p);
}

Asset SampleMirror(Rng& rng) {
  FrameParams p;
  const float area = Draw(rng, 0.25, 0.8), aspect = Draw(rng, 0.5, 1.5);
  p.width_m = std::sqrt(area * aspect);
  p.height_m = std::sqrt(area / aspect);
  p.frame_m = Draw(rng, 0.015, 0.07);
  p.depth_m = Draw(rng, 0.02, 0.04);
  p.profile = rng.UniformInt(0, 3);
  p.mirror = true;
  p.seed = rng.Seed();
  if (!rng.Bernoulli(0.3)) return MakeFramed(p);
  // Round.
  AssetBuilder b(p.seed);
  const float r = 0.5f * std::min(p.width_m, p.height_m), f = p.frame_m;
  Path2 section;
  for (const Vec2f& q : FrameSection(p.profile, f, p.depth_m))
    section.emplace_back(r - q.x(), q.y());
  std::reverse(section.begin(), section.end());
  Shape ring = LatheRing(section, 80);
  if (ring.Volume() < 0) {
    for (Face& face : ring.faces) std::reverse(face.v.begin(), face.v.begin() + face.corners);
  }
  ring.crease_rad = 0.6f;
  // Lathed about z: z becomes y.
  const auto upright = [](const Shape& s) { return s.TurnedX(-0.5f * kPi); };
  b.Add(upright(ring), Slot("frame", {"wood", "metal", "paint"}));
  const float y = 0.3f * p.depth_m;
  b.Add(upright(Cylinder(r - f + 0.004f, y - 0.003f, 0, 80)), Slot("backing", {"wood", "paper"}));
  Shape glass = upright(Cylinder(r - f + 0.004f, 0.004f, 0, 80).Moved(0, 0, y - 0.004f));
  PrintFaces(glass, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  b.Add(glass, {Slot("edge", {"glass", "metal"}), Slot("mirror", {"mirror"})});
  return b.Finish(Anchor::kWall);
}

}  // namespace

void RegisterWall(std::vector<AssetClass>& classes) {
  classes.push_back({"WallArt", "wall", Placement::kOnWall, true, 0, SampleWallArt,
                     SizeRange({0.25f, 0.015f, 0.25f}, {1.2f, 0.05f, 1.15f})});
  classes.push_back({"Mirror", "wall", Placement::kOnWall, true, 0, SampleMirror,
                     SizeRange({0.3f, 0.015f, 0.38f}, {1.2f, 0.06f, 1.3f})});
  classes.push_back({"TV", "electronics", Placement::kOnTop, true, 0, SampleTv,
                     SizeRange({0.65f, 0.18f, 0.42f}, {1.55f, 0.32f, 1})});
  classes.push_back({"Monitor", "electronics", Placement::kOnTop, true, 0, SampleMonitor,
                     SizeRange({0.4f, 0.18f, 0.3f}, {0.82f, 0.3f, 0.7f})});
}

}  // namespace parallax
