// Upholstered seats: armchairs and sofas of one to four places, straight or L-shaped.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/kernel/subdivide.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kBackCushion = 0.15f;  // Thickness.
constexpr float kBackFrame = 0.13f;

// A padded block: rounded, slightly bulging, with shallow dents.
Shape Padded(const Vec3f& size, float radius, const Noise& noise, float target_edge = 0.05f) {
  CushionOptions o;
  o.edge_radius_m = radius;
  o.bulge_top_m = 0.006f;
  o.bulge_side_m = 0.005f;
  o.wrinkle_m = 0.002f;
  o.wrinkle_size_m = 0.2f;
  o.target_edge_m = target_edge;
  return Cushion(size, o, noise);
}

enum class BackStyle { kLoose, kTight, kPillows, kCount };

// Forms of arm rests.
enum class ArmStyle { kTrack, kRolled, kFlared, kSlope, kWood, kCount };

// A sofa; an armchair is one of one place.
struct SofaParams {
  int places = 3;               // Seat cushions, [1, 4].
  float place_m = 0.62f;        // Width of a seat cushion.
  float seat_depth_m = 0.58f;   // In front of the back cushions, [0.5, 0.68].
  float seat_height_m = 0.43f;  // Top of the cushion, [0.38, 0.48].
  float back_height_m = 0.82f;  // [0.7, 1.0]
  float arm_height_m = 0.62f;
  float arm_width_m = 0.16f;
  float cushion_m = 0.16f;  // Thickness of the seat cushions.
  ArmStyle arms = ArmStyle::kTrack;
  BackStyle back = BackStyle::kLoose;
  LegStyle legs = LegStyle::kTapered;
  float leg_height_m = 0.11f;
  float piping_m = 0.0f;  // Radius of the seam cord; 0 = none.
  bool tufted = false;    // Buttons in a tight back.
  bool barrel = false;    // One shell, round in plan, instead of arms and back.
  bool chaise = false;    // The last place is drawn out to lie on.
  int throw_pillows = 0;  // Small cushions of another cloth.
  uint64_t seed = 0;
};

struct SofaFrame {
  explicit SofaFrame(const SofaParams& p)
      : inner(0.5f * p.place_m * static_cast<float>(p.places)),
        front(0.5f * p.seat_depth_m),
        back(-0.5f * p.seat_depth_m - (p.back == BackStyle::kTight ? 0.02f : kBackCushion)),
        rear(back - kBackFrame),
        base_top(p.seat_height_m - p.cushion_m),
        floor(p.leg_height_m) {}
  float inner, front, back, rear, base_top, floor;
};

// The arm's outline in (x outwards, z), swept from the rear to the front.
Shape RolledArm(const SofaParams& p, const SofaFrame& f, const Noise& noise) {
  const float w = p.arm_width_m, r = 0.58f * w, top = p.arm_height_m;
  Path2 outline{{0.0f, f.floor}, {0.78f * w, f.floor}};
  const Vec2f center(0.62f * w, top - r);
  const Path2 roll = Arc(center, r, r, -0.62f * kPi, 1.0f * kPi, 22);
  outline.emplace_back(0.74f * w, center.y() - r - 0.06f);
  outline.insert(outline.end(), roll.begin(), roll.end());
  outline.emplace_back(0.0f, center.y() - 0.12f);
  const float length = f.front - f.rear;
  Shape arm = Extrude(outline, length, 0.012f);
  // Extruded along z: turn that to +y, x stays out, polygon's y to z.
  arm = arm.Bent([&](const Vec3f& q) { return Vec3f(q.x(), f.front - q.z(), q.y()); });
  for (size_t i = 0; i < arm.points.size(); ++i) {
    const Vec3f& q = arm.points[i];
    arm.texture[i] = {q.y(), q.x(), q.z()};
  }
  arm = arm.Bent([&](const Vec3f& q) {
    return Vec3f(q.x() + 0.003f * noise.At(q * 9), q.y() + 0.002f * noise.At(q * 7),
                 q.z() + 0.003f * noise.At(q * 8 + Vec3f(9, 0, 0)));
  });
  // A cord round the front panel and a button at the heart of the scroll.
  Path3 cord;
  for (const Vec2f& q : outline) cord.emplace_back(q.x(), f.front - 0.004f, q.y());
  cord.push_back(cord.front());
  cord = Resampled(cord, 0.03f);
  cord.pop_back();
  arm.Add(Ring(cord, 0.006f));
  arm.Add(Ellipsoid({0.017f, 0.008f, 0.017f}, 16).Moved(center.x(), f.front + 0.001f, center.y()));
  return arm;
}

void AddArms(AssetBuilder& b, const SofaParams& p, const SofaFrame& f, const Noise& noise,
             bool right) {
  const MaterialSlot fabric = FabricSlot("upholstery");
  const float w = p.arm_width_m, length = f.front - f.rear, mid = 0.5f * (f.front + f.rear);
  const float height = p.arm_height_m - f.floor;
  Shape arm;
  MaterialSlot slot = fabric;
  switch (p.arms) {
    case ArmStyle::kRolled:
      arm = RolledArm(p, f, noise).Moved(f.inner, 0, 0);
      break;
    case ArmStyle::kWood: {
      slot = WoodSlot("legs");
      const float t = 0.045f, x = f.inner + 0.5f * t + 0.004f;
      for (const float y : {f.rear + 0.08f, f.front - 0.05f}) {
        arm.Add(Bar({x, y, 0}, {x, y, p.arm_height_m - 0.02f}, {0.032f, 0.04f}, {0.036f, 0.055f},
                    0.006f, Vec3f::UnitY()));
      }
      const Path3 path = Spline(Path3{{x, f.rear + 0.02f, p.arm_height_m - 0.012f},
                                      {x + 0.004f, mid, p.arm_height_m + 0.008f},
                                      {x + 0.002f, f.front - 0.06f, p.arm_height_m},
                                      {x, f.front + 0.015f, p.arm_height_m - 0.012f}},
                                6);
      arm.Add(Sweep(path, RectSection(0.062f, 0.028f, 0.011f, 3),
                    {.end_round_m = 0.012f, .keep_up = true}));
      arm.Add(Board({x - 0.014f, f.rear + 0.08f, f.floor + 0.02f},
                    {x + 0.014f, f.front - 0.05f, f.floor + 0.09f}, 0.004f));
      break;
    }
    default: {
      const float radius = p.arms == ArmStyle::kTrack ? 0.028f : 0.05f;
      arm = Padded({w, length, height}, radius, noise, 0.045f)
                .Bent([&](const Vec3f& q) {
                  const float up = q.z() / height + 0.5f, along = q.y() / length + 0.5f;
                  Vec3f r = q;
                  if (p.arms == ArmStyle::kFlared)
                    r.x() += 0.09f * up * up * up * (0.5f + 0.5f * along);
                  if (p.arms == ArmStyle::kSlope)
                    r.z() += up * 0.16f * (1 - along) * (1 - along) - up * 0.03f;
                  return r;
                })
                .Moved(f.inner + 0.5f * w, mid, f.floor + 0.5f * height);
    }
  }
  b.Add(arm.MirroredX(), slot);
  if (right) b.Add(arm, slot);
}

CushionOptions SeatSoftness(const SofaParams& p) {
  CushionOptions o;
  o.edge_radius_m = 0.038f;
  o.bulge_top_m = 0.032f;
  o.bulge_bottom_m = 0.0f;
  o.bulge_side_m = 0.01f;
  o.wrinkle_m = 0.0045f;
  o.wrinkle_size_m = 0.16f;
  o.target_edge_m = 0.042f;
  o.piping_m = p.piping_m;
  return o;
}

void AddSeats(AssetBuilder& b, const SofaParams& p, const SofaFrame& f, float chaise_front) {
  const CushionOptions soft = SeatSoftness(p);
  for (int i = 0; i < p.places; ++i) {
    const bool chaise = p.chaise && i + 1 == p.places;
    const float x = -f.inner + p.place_m * (static_cast<float>(i) + 0.5f);
    const float front = (chaise ? chaise_front : f.front) + 0.012f, back = f.back + 0.01f;
    const Noise own(p.seed + 17 * static_cast<uint64_t>(i) + 1);
    b.Add(Cushion({p.place_m - 0.006f, front - back, p.cushion_m}, soft, own)
              .Moved(x, 0.5f * (front + back), f.base_top + 0.5f * p.cushion_m),
          FabricSlot("cushions"));
  }
}

// The frame of the back with its upholstery: tight and perhaps tufted, or padded to carry cushions.
// Its lower edge is at the seat's frame.
Shape TightBack(const SofaParams& p, const SofaFrame& f, float width, float height,
                const Noise& noise) {
  const float thick = kBackFrame + 0.03f;
  CushionOptions o;
  o.edge_radius_m = 0.05f;
  o.bulge_top_m = 0.02f;
  o.bulge_side_m = 0.0f;
  o.wrinkle_m = 0.002f;
  o.target_edge_m = p.tufted ? 0.022f : 0.035f;
  if (p.tufted) {
    o.tufts_x = std::max(2, static_cast<int>(width / 0.2f));
    o.tufts_y = 3;
    o.tuft_depth_m = 0.028f;
  }
  // The cushion's top faces forwards.
  Shape back = Cushion({width, height, thick}, o, noise)
                   .TurnedX(-0.5f * kPi)
                   .Moved(0, f.rear + 0.5f * thick, f.floor + 0.5f * height);
  if (!p.tufted) return back;
  for (int i = 0; i < o.tufts_x; ++i) {
    for (int j = 0; j < o.tufts_y; ++j) {
      const float x =
          width * ((static_cast<float>(i) + 0.5f) / static_cast<float>(o.tufts_x) - 0.5f);
      const float z =
          f.floor + height * (static_cast<float>(j) + 0.5f) / static_cast<float>(o.tufts_y);
      if (z < p.seat_height_m) continue;
      back.Add(Ellipsoid({0.011f, 0.006f, 0.011f}, 12).Moved(x, f.rear + thick - 0.004f, z));
    }
  }
  return back;
}

// Loose cushions or pillows that lean against the back.
void AddBackCushions(AssetBuilder& b, const SofaParams& p, const SofaFrame& f) {
  const bool pillows = p.back == BackStyle::kPillows;
  CushionOptions soft = SeatSoftness(p);
  soft.bulge_top_m = 0.045f;
  soft.bulge_bottom_m = 0.01f;
  soft.wrinkle_m = 0.006f;
  const float low = p.seat_height_m + 0.004f, tall = p.back_height_m - low + 0.02f;
  const int count =
      pillows ? std::max(p.places, static_cast<int>(std::lround(2 * f.inner / 0.58f))) : p.places;
  const float each = 2 * f.inner / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    const float x = -f.inner + each * (static_cast<float>(i) + 0.5f);
    const Noise own(p.seed + 31 * static_cast<uint64_t>(i) + 7);
    const Shape pad = pillows
                          ? Pillow(each + 0.01f, tall + 0.02f, 0.24f, {.wrinkle_m = 0.008f}, own)
                          : Cushion({each - 0.008f, tall, kBackCushion}, soft, own);
    const float tilt = 0.2f + 0.03f * own.At({0.5f, 0.3f, 0.1f});
    b.Add(pad.TurnedX(-0.5f * kPi + tilt)
              .TurnedY(0.03f * own.At({1.7f, 0.2f, 0.4f}))
              .Moved(x, f.back + 0.5f * kBackCushion + 0.005f, low + 0.49f * tall),
          FabricSlot("cushions"));
  }
}

void AddSofaBack(AssetBuilder& b, const SofaParams& p, const SofaFrame& f, const Noise& noise) {
  const bool tight = p.back == BackStyle::kTight;
  const float height = p.back_height_m - f.floor;
  const float width = 2 * f.inner + (p.arms == ArmStyle::kWood ? 0.0f : 0.08f);
  const float top_frame = tight ? height : height - 0.07f;
  const auto lean = [&](float z) { return -0.1f * std::max(0.0f, z - p.seat_height_m); };
  const Shape back = tight ? TightBack(p, f, width, top_frame, noise)
                           : Padded({width, kBackFrame, top_frame}, 0.04f, noise)
                                 .Moved(0, f.rear + 0.5f * kBackFrame, f.floor + 0.5f * top_frame);
  b.Add(back.Bent([&](const Vec3f& q) { return Vec3f(q.x(), q.y() + lean(q.z()), q.z()); }),
        FabricSlot("upholstery"));
  if (!tight) AddBackCushions(b, p, f);
}

// The shell of a barrel chair: an upholstered section carried round the seat, from one arm's front
// over the back to the other's, rising as it goes.
void AddShell(AssetBuilder& b, const SofaParams& p, const SofaFrame& f, const Noise& noise) {
  const float w = p.arm_width_m, turn = 0.05f, half = f.inner + 0.5f * w;
  constexpr int kRound = 14;
  Path3 path{{half, f.front + 0.01f, 0}, {half, 0.5f * (f.front + turn), 0}};
  for (int i = 0; i <= kRound; ++i) {
    const float a = kPi * static_cast<float>(i) / kRound;
    const auto bow = [](float v) { return std::copysign(std::pow(std::abs(v), 0.72f), v); };
    path.emplace_back(half * bow(std::cos(a)), turn - (turn - f.back + 0.4f * w) * bow(std::sin(a)),
                      0);
  }
  path.emplace_back(-half, 0.5f * (f.front + turn), 0);
  path.emplace_back(-half, f.front + 0.01f, 0);
  std::vector<CageRing> rings;
  for (size_t i = 0; i < path.size(); ++i) {
    const Vec3f along = (path[std::min(i + 1, path.size() - 1)] - path[i ? i - 1 : 0]).normalized();
    const Vec3f out = Vec3f::UnitZ().cross(along);
    const float behind = Smooth01((f.front - path[i].y()) / (f.front - f.back + 0.3f * w));
    const float top = Lerp(p.arm_height_m, p.back_height_m, behind);
    CageRing ring{EightPoints({-0.5f * w, f.floor}, {0.5f * w, top}, 0, 3.4f)};
    // The back leans outwards as it rises.
    for (Vec3f& q : ring.points) {
      const float up = (q.y() - f.floor) / (top - f.floor);
      q = path[i] + (q.x() + 0.05f * up * up) * out + Vec3f(0, 0, q.y());
    }
    if (i == 0 || i + 1 == path.size()) ring.sharpness = 1.5f;
    rings.push_back(std::move(ring));
  }
  b.Add(Subdivided(Loft(rings), 2).Bent([&](const Vec3f& q) {
    return Vec3f(q + 0.003f * noise.Vector(7 * q));
  }),
        FabricSlot("upholstery"));
}

void AddThrowPillows(AssetBuilder& b, const SofaParams& p, const SofaFrame& f) {
  Rng rng(SceneSeed{p.seed}, "throw_pillows");
  for (int i = 0; i < p.throw_pillows; ++i) {
    const float size = Draw(rng, 0.38, 0.46);
    const float side = i % 2 == 0 ? -1.0f : 1.0f;
    const float x = side * (f.inner - 0.5f * size - 0.03f - 0.3f * static_cast<float>(i / 2));
    const Noise own(rng);
    const float tilt = Draw(rng, 0.32, 0.5);
    const float front_of_back =
        f.back + (p.back == BackStyle::kTight ? 0.1f : kBackCushion + 0.13f);
    b.Add(Pillow(size, size, 0.15f, {}, own)
              .TurnedZ(Draw(rng, -0.12, 0.12))
              .TurnedX(-0.5f * kPi + tilt)
              .TurnedZ(side * Draw(rng, 0.0, 0.3))
              .Moved(x, front_of_back + 0.03f,
                     p.seat_height_m + 0.02f + 0.5f * size * std::cos(tilt)),
          Slot(i % 2 == 0 ? "pillows" : "pillows_b", {"fabric"}));
  }
}

// Legs under the corners, one more pair under the middle of a long sofa, and two under a chaise.
void AddSofaLegs(AssetBuilder& b, const SofaParams& p, const SofaFrame& f, float chaise_front) {
  const float x = p.barrel ? 0.85f * f.inner : f.inner + 0.4f * p.arm_width_m;
  std::vector<float> at{-x, x};
  if (p.places >= 3) at.push_back(0);
  const MaterialSlot legs = Slot("legs", {"wood", "metal"});
  for (const float lx : at) {
    for (const float ly : {(p.barrel ? f.back : f.rear) + 0.07f, f.front - 0.07f}) {
      const float splay = p.legs == LegStyle::kRound ? 0.25f * f.floor : 0.0f;
      const float sx = lx == 0 ? 0.0f : (lx > 0 ? splay : -splay);
      b.Add(FurnitureLeg(p.legs, {lx + sx, ly + (ly > 0 ? splay : -splay), 0},
                         {lx, ly, f.floor + 0.012f}, 0.05f, 1),
            legs);
    }
  }
  if (p.chaise) {
    for (const float lx : {f.inner - 0.07f, f.inner - p.place_m + 0.07f}) {
      b.Add(FurnitureLeg(p.legs, {lx, chaise_front - 0.07f, 0},
                         {lx, chaise_front - 0.07f, f.floor + 0.012f}, 0.05f, 1),
            legs);
    }
  }
}

Asset MakeSofa(const SofaParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  const SofaFrame f(p);
  const MaterialSlot fabric = FabricSlot("upholstery");
  const float chaise_front = f.front + 0.72f;
  // Under the cushions.
  const float depth = f.front - (p.barrel ? f.back : f.rear) - 0.02f, base = f.base_top - f.floor;
  const float side = p.arms == ArmStyle::kWood ? 0.0f : 0.02f;
  b.Add(Padded({2 * (f.inner + side), depth, base}, 0.02f, noise, 0.08f)
            .Moved(0, f.front - 0.01f - 0.5f * depth, f.floor + 0.5f * base),
        fabric);
  if (p.chaise) {
    b.Add(Padded({p.place_m, chaise_front - f.front + 0.2f, base}, 0.02f, noise, 0.08f)
              .Moved(f.inner - 0.5f * p.place_m, 0.5f * (chaise_front + f.front) - 0.1f,
                     f.floor + 0.5f * base),
          fabric);
  }
  AddSeats(b, p, f, chaise_front);
  if (p.barrel) {
    AddShell(b, p, f, noise);
  } else {
    AddSofaBack(b, p, f, noise);
    AddArms(b, p, f, noise, true);
  }
  AddThrowPillows(b, p, f);
  if (p.arms != ArmStyle::kWood) AddSofaLegs(b, p, f, chaise_front);
  return b.Finish();
}

SofaParams SampleCommon(Rng& rng) {
  SofaParams p;
  p.seat_depth_m = Draw(rng, 0.52, 0.62);
  p.seat_height_m = Draw(rng, 0.40, 0.47);
  p.back_height_m = Draw(rng, 0.76, 0.94);
  p.arm_height_m = p.seat_height_m + Draw(rng, 0.14, 0.22);
  p.arm_width_m = Draw(rng, 0.11, 0.22);
  p.cushion_m = Draw(rng, 0.12, 0.18);
  p.arms = DrawEnum<ArmStyle>(rng, static_cast<int>(ArmStyle::kCount));
  p.back = DrawEnum<BackStyle>(rng, static_cast<int>(BackStyle::kCount));
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.leg_height_m = Draw(rng, 0.06, 0.16);
  p.piping_m = rng.Bernoulli(0.4) ? 0.005f : 0.0f;
  p.tufted = rng.Bernoulli(0.5);
  if (p.arms == ArmStyle::kRolled) p.arm_width_m = Draw(rng, 0.17, 0.22);
  return p;
}

Asset SampleSofa(Rng& rng) {
  SofaParams p = SampleCommon(rng);
  p.places = rng.UniformInt(2, 3);
  p.place_m = p.places == 2 ? Draw(rng, 0.62, 0.78) : Draw(rng, 0.56, 0.68);
  p.chaise = p.places == 3 && p.arms != ArmStyle::kWood && rng.Bernoulli(0.3);
  p.throw_pillows = rng.UniformInt(0, 3);
  p.seed = rng.Seed();
  return MakeSofa(p);
}

Asset SampleArmChair(Rng& rng) {
  SofaParams p = SampleCommon(rng);
  p.places = 1;
  p.place_m = Draw(rng, 0.5, 0.62);
  p.seat_depth_m = Draw(rng, 0.5, 0.58);
  p.back_height_m = Draw(rng, 0.8, 1.0);
  p.arm_width_m = std::min(p.arm_width_m, 0.18f);
  p.throw_pillows = rng.Bernoulli(0.3) ? 1 : 0;
  p.barrel = rng.Bernoulli(0.22);
  if (p.barrel) {
    p.back = BackStyle::kTight;
    p.arms = ArmStyle::kTrack;
    p.back_height_m = Draw(rng, 0.72, 0.84);
    p.arm_width_m = Draw(rng, 0.1, 0.14);
  }
  p.seed = rng.Seed();
  return MakeSofa(p);
}

}  // namespace

void RegisterSofas(std::vector<AssetClass>& classes) {
  classes.push_back({"ArmChair", "seating", Placement::kFloor, true, 0.5f, SampleArmChair,
                     SizeRange({0.6f, 0.65f, 0.7f}, {1.25f, 1.1f, 1.15f})});
  classes.push_back({"Sofa", "seating", Placement::kFloorAgainstWall, true, 0.6f, SampleSofa,
                     SizeRange({1.3f, 0.65f, 0.65f}, {2.7f, 1.75f, 1.1f})});
}

}  // namespace parallax
