#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// A picture over the large faces of a box, parts of it over the narrow ones.
void PrintCarton(Shape& carton, float width, float depth) {
  PrintFaces(carton, Vec3f::UnitY(), -Vec3f::UnitX(), Vec3f::UnitZ(), 1);
  PrintFaces(carton, -Vec3f::UnitY(), Vec3f::UnitX(), Vec3f::UnitZ(), 2);
  PrintFaces(carton, Vec3f::UnitX(), Vec3f::UnitY(), Vec3f::UnitZ(), 3);
  PrintFaces(carton, -Vec3f::UnitX(), -Vec3f::UnitY(), Vec3f::UnitZ(), 4);
  const float share = std::min(1.0f, depth / width);
  for (Face& f : carton.faces) {
    if (f.group < 3) continue;
    for (Vec2f& q : f.uv) q.x() *= share;
  }
}

void AddCarton(AssetBuilder& b, const Shape& carton) {
  const MaterialSlot front = PictureSlot("front");
  b.Add(carton, {Slot("card", {"paper"}), front, front, front, front});
}

// Card bulges a little and is never quite flat. Centred on the origin.
Shape CardBox(const Vec3f& size, const Noise& noise) {
  const BoxOptions box{.bevel_m = 0.0012f, .pieces = {8, 4, 10}};
  return RoundedBox(size, box).Bent([&](const Vec3f& q) {
    const Vec3f u = 2 * q.cwiseQuotient(size);
    const float dome = std::max(0.0f, 1 - u.x() * u.x()) * std::max(0.0f, 1 - u.z() * u.z());
    return Vec3f(q.x(), q.y() + u.y() * 0.003f * dome + 0.0012f * noise.At(q * 14) * dome, q.z());
  });
}

enum class FoodBoxStyle { kCereal, kGable, kTray, kSlab, kBrick, kCount };

// A carton.
struct FoodBoxParams {
  FoodBoxStyle style = FoodBoxStyle::kCereal;
  float width_m = 0.17f, depth_m = 0.06f, height_m = 0.24f;
  float flap_rad = 0;  // How far the lid's flap stands open; 0 = shut.
  uint64_t seed = 0;
};

// A flap hinged at the upper back edge of a box whose top is at z.
void AddFlap(AssetBuilder& b, const FoodBoxParams& p, float z) {
  SheetOptions sheet;
  sheet.pieces_u = 6;
  sheet.pieces_v = 4;
  sheet.thickness_m = 0.0008f;
  sheet.round_rim = false;
  sheet.size_m = {p.width_m, 0.9f * p.depth_m};
  b.Add(Sheet(
            [&](float u, float v) {
              const float reach = 0.9f * p.depth_m * v;
              return Vec3f((u - 0.5f) * (p.width_m - 0.002f),
                           -0.5f * p.depth_m + reach * std::cos(p.flap_rad),
                           z - 0.0005f + reach * std::sin(p.flap_rad) - 0.004f * v * v);
            },
            sheet),
        Slot("card", {"paper"}));
}

// A milk carton: the walls run together to a ridge with a crimped fin; a screw cap on the slope.
void AddGableCarton(AssetBuilder& b, const FoodBoxParams& p, const Noise& noise) {
  const float w = p.width_m, h = p.height_m, roof = 0.42f * w;
  Shape carton = RoundedBox({w, w, h + roof}, {.bevel_m = 0.0015f, .pieces = {6, 8, 12}})
                     .Moved(0, 0, 0.5f * (h + roof));
  carton = carton.Bent([&](const Vec3f& q) {
    const float t = std::clamp((q.z() - h) / roof, 0.0f, 1.0f);
    const float dome = 0.002f * Smooth01(3 * q.z() / h) * (1 - t);
    // The side walls fold inwards between the slopes.
    const float tuck = 0.28f * w * t * (1 - std::abs(2 * q.y() / w));
    const float x = q.x() - std::copysign(std::min(std::abs(q.x()), tuck), q.x());
    return Vec3f(x + 0.0008f * noise.At(q * 12),
                 q.y() * (1 - 0.96f * t) + dome * (q.y() > 0 ? 1.0f : -1.0f) * (1 - t), q.z());
  });
  PrintCarton(carton, w, w);
  AddCarton(b, carton);
  b.Add(Board({-0.497f * w, -0.0016f, h + roof - 0.006f}, {0.497f * w, 0.0016f, h + roof + 0.016f},
              0.0006f),
        Slot("card", {"paper"}));
  const float lean = std::atan2(0.48f * w, roof);
  b.Add(Lathe(Filleted(Path2{{0, 0}, {0.016f, 0}, {0.0155f, 0.012f}, {0, 0.012f}}, 0.0012f, 2),
              {.segments = 72,
               .modulate = [](float a, float) { return 1 + 0.012f * std::cos(24 * a); }})
            .TurnedX(-lean)
            .Moved(0, 0.25f * w, h + 0.5f * roof),
        PlasticSlot("cap"));
}

// An open tray of card with a film over what lies in it.
void AddTray(AssetBuilder& b, const FoodBoxParams& p, Rng& rng) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.height_m, h = p.depth_m, t = 0.0016f;
  const MaterialSlot card = Slot("card", {"paper", "plastic"});
  const Path2 outer = RectSection(2 * w, 2 * d, 0.012f, 4);
  b.Add(Extrude(outer, t, 0.0005f), card);
  Path3 wall;
  for (const Vec2f& q : outer) wall.emplace_back(0.985f * q.x(), 0.985f * q.y(), 0.5f * h);
  const SweepOptions closed{.closed = true, .up = Vec3f::UnitZ(), .keep_up = true};
  b.Add(Sweep(wall, RectSection(t, h - 0.001f, 0.0004f, 1), closed), card);
  Path3 rim;
  for (const Vec2f& q : outer) rim.emplace_back(q.x(), q.y(), h - 0.001f);
  b.Add(Sweep(rim, RectSection(0.012f, 0.0016f, 0.0006f, 1), closed), card);
  // Biscuits, sausages, tomatoes: rows of one thing.
  const int rows = rng.UniformInt(2, 4), columns = rng.UniformInt(3, 5);
  const Vec2f pitch(1.86f * w / static_cast<float>(columns), 1.86f * d / static_cast<float>(rows));
  const float r = 0.49f * std::min(pitch.x(), pitch.y()), high = std::min(0.9f * h, 1.6f * r);
  const bool round = rng.Bernoulli(0.5);
  for (int i = 0; i < columns; ++i) {
    for (int j = 0; j < rows; ++j) {
      const float x = pitch.x() * (static_cast<float>(i) - 0.5f * static_cast<float>(columns - 1)),
                  y = pitch.y() * (static_cast<float>(j) - 0.5f * static_cast<float>(rows - 1));
      const Shape each = round ? Ellipsoid({r, r, 0.5f * high}, 20).Moved(0, 0, 0.5f * high)
                               : Cylinder(r, 0.5f * high, 0.15f * r, 24);
      b.Add(each.TurnedZ(Draw(rng, 0, 6)).Moved(x, y, t - 0.0004f),
            Slot("food", {"food", "paper"}));
    }
  }
}

Shape PrintedBox(const FoodBoxParams& p, const Noise& noise) {
  Shape carton = CardBox({p.width_m, p.depth_m, p.height_m}, noise);
  PrintCarton(carton, p.width_m, p.depth_m);
  return carton;
}

// A juice pack's top: ears folded down at the sides, a straw or a cap.
void AddBrickTop(AssetBuilder& b, const FoodBoxParams& p, float top) {
  b.Add(Board({-0.5f * p.width_m + 0.002f, -0.001f, top - 0.001f},
              {0.5f * p.width_m - 0.002f, 0.001f, top + 0.0022f}, 0.0006f),
        Slot("card", {"paper"}));
  if (p.flap_rad > 0.6f) {
    const Vec3f in(0.25f * p.width_m, 0.2f * p.depth_m, top - 0.004f);
    b.Add(Tube(Filleted(Path3{in, in + Vec3f(0.002f, 0, 0.045f), in + Vec3f(-0.03f, 0, 0.08f)},
                        0.01f, 4),
               0.0026f, 0, 12),
          PlasticSlot("straw"));
  } else {
    b.Add(Cylinder(0.012f, 0.012f, 0.0015f).Moved(0.22f * p.width_m, 0, top - 0.001f),
          PlasticSlot("straw"));
  }
}

void AddUprightCarton(AssetBuilder& b, const FoodBoxParams& p, const Noise& noise) {
  AddCarton(b, PrintedBox(p, noise));
  const float top = 0.5f * p.height_m;
  if (p.style == FoodBoxStyle::kBrick) {
    AddBrickTop(b, p, top);
  } else if (p.flap_rad > 0) {
    AddFlap(b, p, top);
  }
}

Asset MakeFoodBox(const FoodBoxParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "food box");
  const Noise noise(rng);
  switch (p.style) {
    case FoodBoxStyle::kGable:
      AddGableCarton(b, p, noise);
      break;
    case FoodBoxStyle::kTray:
      AddTray(b, p, rng);
      break;
    case FoodBoxStyle::kSlab:
      // Lies on its back: chocolates, pizza, frozen fish.
      AddCarton(b, PrintedBox(p, noise).TurnedX(0.5f * kPi));
      break;
    default:
      AddUprightCarton(b, p, noise);
  }
  return b.Finish();
}

}  // namespace

Asset SampleFoodBox(Rng& rng) {
  FoodBoxParams p{.style = DrawEnum<FoodBoxStyle>(rng, static_cast<int>(FoodBoxStyle::kCount))};
  switch (p.style) {
    case FoodBoxStyle::kGable:
      p.width_m = p.depth_m = Draw(rng, 0.068, 0.096);
      p.height_m = p.width_m * Draw(rng, 1.5, 2.2);
      break;
    case FoodBoxStyle::kTray:
      p.width_m = Draw(rng, 0.14, 0.22);
      p.height_m = p.width_m * Draw(rng, 0.6, 0.85);
      p.depth_m = Draw(rng, 0.03, 0.06);
      break;
    case FoodBoxStyle::kSlab:
      p.width_m = Draw(rng, 0.16, 0.3);
      p.height_m = p.width_m * Draw(rng, 0.55, 1.0);
      p.depth_m = Draw(rng, 0.025, 0.05);
      break;
    case FoodBoxStyle::kBrick:
      p.width_m = Draw(rng, 0.06, 0.1);
      p.depth_m = p.width_m * Draw(rng, 0.6, 0.75);
      p.height_m = p.width_m * Draw(rng, 1.4, 2.3);
      break;
    default:
      p.width_m = Draw(rng, 0.12, 0.21);
      p.depth_m = p.width_m * Draw(rng, 0.25, 0.5);
      p.height_m = p.width_m * Draw(rng, 1.1, 1.6);
  }
  p.flap_rad = rng.Bernoulli(0.5) ? Draw(rng, 0.5, 1.3) : 0.0f;
  p.seed = rng.Seed();
  return MakeFoodBox(p);
}

}  // namespace parallax
