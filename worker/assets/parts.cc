#include "worker/assets/parts.h"

#include <algorithm>
#include <cmath>

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot WoodSlot(const std::string& name) { return Slot(name, {"wood", "paint"}); }
MaterialSlot MetalSlot(const std::string& name) { return Slot(name, {"metal", "paint"}); }
MaterialSlot FabricSlot(const std::string& name) { return Slot(name, {"fabric", "leather"}); }
MaterialSlot PlasticSlot(const std::string& name) { return Slot(name, {"plastic", "paint"}); }
MaterialSlot CeramicSlot(const std::string& name) {
  return Slot(name, {"ceramic", "stone", "plastic"});
}
MaterialSlot GlassSlot(const std::string& name) { return Slot(name, {"glass"}); }
MaterialSlot PictureSlot(const std::string& name) { return Slot(name, {"picture"}); }

Asset FinishMeshes(const std::vector<const Mesh*>& meshes, uint64_t seed) {
  AssetBuilder b(seed);
  for (const Mesh* mesh : meshes) {
    if (!mesh->triangles.empty()) b.AddMesh(*mesh, Eigen::Affine3f::Identity());
  }
  return b.Finish(Anchor::kGround);
}

Shape AlongZ(const Shape& shape, const Vec3f& from, const Vec3f& to) {
  Eigen::Affine3f place = Eigen::Affine3f::Identity();
  place.translate(from);
  place.rotate(Eigen::Quaternionf::FromTwoVectors(Vec3f::UnitZ(), (to - from).normalized()));
  return shape.Placed(place);
}

Shape TurnedLeg(float height, float radius, int variant) {
  Path2 p;
  const auto at = [&](float r, float z) { p.emplace_back(r * radius, z * height); };
  // A half-round ring of the given width.
  const auto bead = [&](float z0, float z1, float r, float out) {
    for (int k = 0; k <= 6; ++k) {
      const float a = kPi * (static_cast<float>(k) / 6.0f - 0.5f);
      at(r + out * std::cos(a), Lerp(z0, z1, 0.5f + 0.5f * std::sin(a)));
    }
  };
  const auto curve = [&](std::vector<std::pair<float, float>> knots, int steps) {
    const auto f = SmoothThrough(knots);
    for (int k = 0; k <= steps; ++k) {
      const float z = Lerp(knots.front().first, knots.back().first,
                           static_cast<float>(k) / static_cast<float>(steps));
      at(f(z), z);
    }
  };
  at(0, 0);
  switch (variant % 4) {
    case 0:  // A ball foot, a long swelling, two rings.
      curve({{0.0f, 0.42f}, {0.03f, 0.62f}, {0.07f, 0.66f}, {0.11f, 0.42f}}, 9);
      bead(0.115f, 0.135f, 0.45f, 0.16f);
      curve({{0.14f, 0.42f}, {0.4f, 0.72f}, {0.62f, 0.95f}, {0.74f, 0.62f}}, 14);
      bead(0.745f, 0.765f, 0.62f, 0.2f);
      bead(0.77f, 0.8f, 0.62f, 0.32f);
      curve({{0.805f, 0.68f}, {0.86f, 0.94f}, {0.95f, 0.9f}, {1.0f, 0.86f}}, 8);
      break;
    case 1:  // Slender taper with a collar.
      curve({{0.0f, 0.46f}, {0.05f, 0.5f}, {0.55f, 0.82f}, {0.8f, 0.98f}}, 12);
      bead(0.8f, 0.825f, 0.86f, 0.16f);
      curve({{0.828f, 0.7f}, {0.86f, 0.74f}, {0.9f, 0.9f}, {1.0f, 0.96f}}, 7);
      break;
    case 2:  // Bobbins.
      at(0.5f, 0.0f);
      at(0.55f, 0.02f);
      for (int k = 0; k < 7; ++k) {
        const float z0 = 0.03f + 0.12f * static_cast<float>(k);
        bead(z0, z0 + 0.115f, 0.55f, 0.42f);
      }
      curve({{0.875f, 0.62f}, {0.92f, 0.86f}, {1.0f, 0.9f}}, 5);
      break;
    default:  // A vase.
      curve({{0.0f, 0.5f}, {0.02f, 0.56f}, {0.1f, 0.46f}, {0.3f, 0.52f}, {0.42f, 0.56f}}, 10);
      bead(0.425f, 0.45f, 0.56f, 0.22f);
      curve({{0.455f, 0.52f}, {0.52f, 0.9f}, {0.6f, 1.0f}, {0.72f, 0.7f}, {0.8f, 0.56f}}, 14);
      bead(0.805f, 0.825f, 0.58f, 0.18f);
      bead(0.83f, 0.86f, 0.62f, 0.3f);
      curve({{0.865f, 0.7f}, {0.92f, 0.9f}, {1.0f, 0.9f}}, 6);
      break;
  }
  return Lathe(p, {.segments = radius < 0.02f ? 14 : (radius < 0.035f ? 18 : 26)});
}

Shape FurnitureLeg(LegStyle style, const Vec3f& foot, const Vec3f& top, float thickness,
                   int variant) {
  const float t = thickness;
  switch (style) {
    case LegStyle::kSquare:
      return Bar(foot, top, {t, t}, {t, t}, 0.0025f, Vec3f::UnitY());
    case LegStyle::kTapered:
      return Bar(foot, top, {0.55f * t, 0.55f * t}, {t, t}, 0.0025f, Vec3f::UnitY());
    case LegStyle::kRound:
      return Rod(foot, top, 0.3f * t, 0.5f * t, 0.003f);
    default:
      return AlongZ(TurnedLeg((top - foot).norm(), 0.55f * t, variant), foot, top);
  }
}

namespace {

Shape KnobHandle() {
  const float r = 0.016f;
  const Path2 profile = Spline(Path2{{0.55f * r, 0},
                                     {0.4f * r, 0.5f * r},
                                     {0.5f * r, 0.9f * r},
                                     {0.98f * r, 1.3f * r},
                                     {0.9f * r, 1.7f * r},
                                     {0.5f * r, 1.95f * r},
                                     {0.02f * r, 2.0f * r}},
                               3);
  return Lathe(profile).TurnedX(-0.5f * kPi);
}

// A straight bar on two posts; `h`: half its length.
Shape StraightHandle(float h) {
  Shape out = Tube({{-h, 0.03f, 0}, {h, 0.03f, 0}}, 0.005f, 0.0015f, 12);
  for (const float x : {-0.72f * h, 0.72f * h})
    out.Add(Tube({{x, -0.002f, 0}, {x, 0.03f, 0}}, 0.004f, 0, 10));
  return out;
}

Shape BowHandle(float h) {
  const Path3 path = Spline(Path3{{-h, -0.002f, 0},
                                  {-0.93f * h, 0.014f, 0},
                                  {-0.5f * h, 0.026f, 0},
                                  {0.5f * h, 0.026f, 0},
                                  {0.93f * h, 0.014f, 0},
                                  {h, -0.002f, 0}},
                            5);
  SweepOptions options;
  options.scale = [](float t) { return Vec2f(1.0f, 1.25f - 0.6f * std::abs(2 * t - 1)); };
  Shape out = Sweep(path, EllipseSection(0.007f, 0.012f, 12), options);
  for (const float x : {-h, h})
    out.Add(Cylinder(0.008f, 0.003f, 0.001f, 14).TurnedX(-0.5f * kPi).Moved(x, 0, 0));
  return out;
}

// A quarter shell, open below.
Shape CupHandle(float size) {
  SheetOptions sheet;
  sheet.pieces_u = 16;
  sheet.pieces_v = 6;
  sheet.thickness_m = 0.0018f;
  sheet.size_m = {size, 0.04f};
  const float w = 0.5f * size, r = 0.024f;
  return Sheet(
      [=](float u, float v) {
        const float x = 2 * u - 1;
        const float fat = std::sqrt(std::max(0.0f, 1 - 0.86f * x * x * x * x));
        const float a = 0.5f * kPi * v;
        return Vec3f(w * x, r * fat * std::cos(a) - 0.001f, r * fat * std::sin(a) - 0.012f);
      },
      sheet);
}

}  // namespace

Shape Handle(HandleStyle style, float size) {
  switch (style) {
    case HandleStyle::kKnob:
      return KnobHandle();
    case HandleStyle::kBar:
      return StraightHandle(0.5f * size);
    case HandleStyle::kBow:
      return BowHandle(0.5f * size);
    case HandleStyle::kCup:
      return CupHandle(size);
    default:
      return {};
  }
}

Shape Front(FrontStyle style, float width, float height, float thickness, bool grain_up) {
  const float w = 0.5f * width, t = thickness;
  const auto grained = [&](Shape shape) {
    if (!grain_up) return shape;
    for (size_t i = 0; i < shape.points.size(); ++i) {
      const Vec3f& p = shape.points[i];
      shape.texture[i] = {p.z(), p.x(), p.y()};
    }
    return shape;
  };
  const float stile = std::min({0.07f, 0.25f * width, 0.25f * height});
  if (style == FrontStyle::kFlat || stile < 0.02f || height < 0.12f) {
    return grained(Board({-w, 0, 0}, {w, t, height}, 0.002f));
  }
  Shape out;
  for (const float side : {-1.0f, 1.0f}) {
    out.Add(Board({side * w, 0, 0}, {side * (w - stile), t, height}, 0.0015f));
  }
  out.Add(Board({-w + stile, 0, 0}, {w - stile, t, stile}, 0.0015f));
  out.Add(Board({-w + stile, 0, height - stile}, {w - stile, t, height}, 0.0015f));
  const float back = 0.15f * t;
  const Vec3f lo(-w + stile - 0.004f, back, stile - 0.004f),
      hi(w - stile + 0.004f, 0.55f * t, height - stile + 0.004f);
  if (style == FrontStyle::kShaker) {
    out.Add(grained(Board(lo, hi, 0.001f)));
    return out;
  }
  // Raised: the field rises from a thin edge over a bevel of a few centimetres.
  const float fall = std::min({0.035f, 0.3f * (hi.x() - lo.x()), 0.3f * (hi.z() - lo.z())});
  const BoxOptions box{.bevel_m = 0, .pieces = {6, 1, 6}};
  const Vec3f size = hi - lo, mid = 0.5f * (lo + hi);
  Shape field = RoundedBox(size, box);
  field.crease_rad = 0.2f;
  const auto snap = [&](float x, float half) {
    // Stations at 0, 0.7 and 1 of the bevel, then evenly over the field.
    const float s = std::abs(x) / half;
    if (s > 0.99f) return x;
    if (s > 0.5f) return std::copysign(half - 0.05f * fall, x);
    if (s > 0.2f) return std::copysign(half - fall, x);
    return 0.0f;
  };
  field = field.Bent([&](const Vec3f& p) -> Vec3f {
    const Vec3f q(snap(p.x(), 0.5f * size.x()), p.y(), snap(p.z(), 0.5f * size.z()));
    const float edge =
        std::min(0.5f * size.x() - std::abs(q.x()), 0.5f * size.z() - std::abs(q.z()));
    Vec3f r = q + mid;
    if (p.y() > 0) r.y() = Lerp(0.4f * t, 0.95f * t, std::clamp(edge / fall, 0.0f, 1.0f));
    return r;
  });
  out.Add(grained(field));
  return out;
}

Shape BowedRail(float half, float bow, float thickness, float height, float z, float y,
                float lean_rad) {
  Path3 path;
  const int steps = bow > 0.002f ? 12 : 1;
  for (int i = 0; i <= steps; ++i) {
    const float s = 2.0f * static_cast<float>(i) / static_cast<float>(steps) - 1.0f;
    path.emplace_back(half * s, y - bow * (1 - s * s), z);
  }
  SweepOptions options;
  options.up = Vec3f(0, -std::sin(lean_rad), std::cos(lean_rad));
  options.keep_up = true;
  return Sweep(path, RectSection(thickness, height, std::min(0.004f, 0.3f * thickness), 2),
               options);
}

}  // namespace parallax
