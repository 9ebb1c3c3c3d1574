#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// The base, and whether there is a low back.
enum class BarChairStyle { kFourLegs, kPedestal, kLowBack, kCount };

// A high stool at bar or counter height.
struct BarChairParams {
  BarChairStyle style = BarChairStyle::kFourLegs;
  float seat_height_m = 0.74f;  // [0.62, 0.82]
  float seat_width_m = 0.36f;
  bool round_seat = true;
  bool padded = true;
  LegStyle legs = LegStyle::kRound;
  int leg_variant = 0;
  uint64_t seed = 0;
};

// Dimensions and slots that the parts of a bar chair share.
struct BarChair {
  explicit BarChair(const BarChairParams& params)
      : p(params),
        pedestal(params.style == BarChairStyle::kPedestal),
        h(params.seat_height_m),
        r(0.5f * params.seat_width_m),
        pad(params.padded ? 0.06f : 0.03f),
        under(h - pad + 0.004f),
        frame(pedestal ? metal : Slot("frame", {"wood", "metal", "paint"})),
        seat(params.padded ? FabricSlot("seat") : WoodSlot("frame")) {}

  const BarChairParams& p;
  const bool pedestal;
  const float h, r, pad;  // Height and radius of the seat, its thickness.
  const float under;      // Underside of the seat.
  const MaterialSlot metal = MetalSlot("metal");
  const MaterialSlot frame, seat;
};

// Points of a horizontal circle.
Path3 CirclePath(float radius, float z) {
  Path3 path;
  for (int i = 0; i < 48; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 48.0f;
    path.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
  return path;
}

// A round cushion with a cord round its lower edge.
void AddRoundCushion(AssetBuilder& b, const BarChair& c) {
  const float r = c.r, pad = c.pad;
  const Noise noise(c.p.seed);
  const Path2 profile = Filleted(Path2{{0, 0},
                                       {r - 0.005f, 0},
                                       {r, 0.02f},
                                       {r, pad - 0.012f},
                                       {0.75f * r, pad + 0.002f},
                                       {0, pad + 0.01f}},
                                 0.016f, 5);
  const LatheOptions options{.modulate = [&](float a, float z) {
    return 1 + 0.008f * noise.At({4 * std::cos(a), 4 * std::sin(a), z * 30});
  }};
  b.Add(Lathe(profile, options).Moved(0, 0, c.h - pad), c.seat);
  b.Add(Ring(CirclePath(r + 0.001f, c.h - pad + 0.012f), 0.004f), c.seat);
}

// A turned disk, hollowed for sitting.
void AddRoundBoard(AssetBuilder& b, const BarChair& c) {
  const float r = c.r, pad = c.pad;
  const Path2 profile = Filleted(Path2{{0, 0},
                                       {r - 0.006f, 0},
                                       {r, 0.015f},
                                       {r - 0.004f, pad},
                                       {0.8f * r, pad - 0.002f},
                                       {0, pad - 0.01f}},
                                 0.008f, 4);
  Shape seat = Lathe(profile).Moved(0, 0, c.h - pad);
  for (size_t i = 0; i < seat.points.size(); ++i) seat.texture[i] = seat.points[i];
  b.Add(seat, c.seat);
}

void AddSquareSeat(AssetBuilder& b, const BarChair& c) {
  const bool padded = c.p.padded;
  CushionOptions soft;
  soft.edge_radius_m = padded ? 0.022f : 0.008f;
  soft.bulge_top_m = padded ? 0.015f : 0.0f;
  soft.bulge_side_m = 0;
  soft.wrinkle_m = padded ? 0.0015f : 0.0f;
  const Shape seat =
      Cushion({2 * c.r, 1.9f * c.r, c.pad}, soft, Noise(c.p.seed)).Bent([&](const Vec3f& q) {
        return Vec3f(q.x(), q.y(), q.z() + (padded ? 0.1f : 0.55f) * q.x() * q.x());
      });
  b.Add(seat.Moved(0, 0, c.h - 0.5f * c.pad), c.seat);
}

void AddBarSeat(AssetBuilder& b, const BarChair& c) {
  if (!c.p.round_seat) {
    AddSquareSeat(b, c);
  } else if (c.p.padded) {
    AddRoundCushion(b, c);
  } else {
    AddRoundBoard(b, c);
  }
}

// A trumpet foot, a column and a rest for the feet.
void AddBarPedestal(AssetBuilder& b, const BarChair& c) {
  b.Add(Lathe(Spline(Path2{{0.21f, 0},
                           {0.212f, 0.006f},
                           {0.2f, 0.014f},
                           {0.1f, 0.03f},
                           {0.045f, 0.06f},
                           {0.03f, 0.13f},
                           {0.028f, 0.3f}},
                     5)),
        c.metal);
  b.Add(Cylinder(0.02f, c.under - 0.25f, 0.002f).Moved(0, 0, 0.26f), c.metal);
  b.Add(Cone(0.03f, 0.1f, 0.035f, 0.004f).Moved(0, 0, c.under - 0.034f), c.metal);
  const Path3 rest = Filleted(Path3{{0, 0.02f, 0.34f},
                                    {0.14f, 0.05f, 0.34f},
                                    {0.15f, 0.19f, 0.34f},
                                    {-0.15f, 0.19f, 0.34f},
                                    {-0.14f, 0.05f, 0.34f},
                                    {0, 0.02f, 0.34f}},
                              0.06f, 6);
  b.Add(Tube(rest, 0.01f, 0.002f, 14), c.metal);
  b.Add(Cylinder(0.036f, 0.05f, 0.004f).Moved(0, 0, 0.315f), c.metal);
}

// Rungs between four points of the legs, and aprons below the seat.
void AddBarRails(AssetBuilder& b, const BarChair& c, const std::vector<Vec3f>& at_rest, float top) {
  for (int i = 0; i < 4; ++i) {
    const float lift = i % 2 == 0 ? 0.0f : 0.06f;
    const Vec3f from = at_rest[i] + Vec3f(0, 0, lift),
                to = at_rest[(i + 1) % 4] + Vec3f(0, 0, lift);
    b.Add(Bar(from, to, {0.016f, 0.026f}, {0.016f, 0.026f}), c.frame);
  }
  for (int i = 0; i < 4; ++i) {
    const float sx = i == 0 || i == 3 ? 1.0f : -1.0f, sy = i < 2 ? 1.0f : -1.0f;
    const float nx = i == 1 || i == 0 ? -sx : sx, ny = i == 1 || i == 0 ? sy : -sy;
    const float t = top + 0.012f;
    b.Add(Bar({sx * t, sy * t, c.under - 0.03f}, {nx * t, ny * t, c.under - 0.03f}, {0.016f, 0.05f},
              {0.016f, 0.05f}),
          c.frame);
  }
}

// Four legs, splayed, and what joins them: a ring for round ones, else rungs and aprons.
void AddBarLegs(AssetBuilder& b, const BarChair& c) {
  const float top = 0.62f * c.r, foot = std::max(0.17f, 1.0f * c.r);
  std::vector<Vec3f> at_rest;
  const float z = 0.3f * c.h;
  for (int i = 0; i < 4; ++i) {
    const float sx = i == 0 || i == 3 ? 1.0f : -1.0f, sy = i < 2 ? 1.0f : -1.0f;
    const Vec3f from(sx * foot, sy * foot, 0), to(sx * top, sy * top, c.under);
    b.Add(FurnitureLeg(c.p.legs, from, to, 0.034f, c.p.leg_variant), c.frame);
    at_rest.push_back(from + (to - from) * (z / c.under));
  }
  if (c.p.round_seat && c.p.legs == LegStyle::kRound) {
    b.Add(Ring(CirclePath(at_rest[0].head<2>().norm(), z), 0.008f, 12), c.metal);
    b.Add(Cylinder(0.9f * c.r, 0.02f, 0.003f).Moved(0, 0, c.under - 0.018f), c.frame);
  } else {
    AddBarRails(b, c, at_rest, top);
  }
}

// A bent board on two tubes.
void AddLowBack(AssetBuilder& b, const BarChair& c) {
  const float r = c.r, h = c.h, rise = 0.2f, span = 1.15f;
  SheetOptions sheet;
  sheet.pieces_u = 24;
  sheet.pieces_v = 8;
  sheet.thickness_m = c.p.padded ? 0.024f : 0.012f;
  sheet.size_m = {2.4f * r, 0.13f};
  const Shape back = Sheet(
      [&](float u, float v) {
        const float a = -0.5f * kPi + span * (1 - 2 * u);
        const float rr = r * 0.98f + 0.02f * v;
        return Vec3f(rr * std::cos(a), rr * std::sin(a),
                     h + rise - 0.075f + 0.13f * v * (1 - 0.25f * std::pow(2 * u - 1, 4.0f)));
      },
      sheet);
  b.Add(back, c.seat);
  for (const float s : {-1.0f, 1.0f}) {
    const float a = -0.5f * kPi + 0.6f * span * s;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    b.Add(Tube(Filleted(Path3{0.5f * r * out + Vec3f(0, 0, c.under - 0.004f),
                              (r + 0.022f) * out + Vec3f(0, 0, c.under - 0.004f),
                              (r + 0.022f) * out + Vec3f(0, 0, h + rise)},
                        0.03f, 5),
               0.008f, 0.003f, 12),
          c.metal);
  }
}

Asset MakeBarChair(const BarChairParams& p) {
  AssetBuilder b(p.seed);
  const BarChair chair(p);
  AddBarSeat(b, chair);
  chair.pedestal ? AddBarPedestal(b, chair) : AddBarLegs(b, chair);
  if (p.style == BarChairStyle::kLowBack || (chair.pedestal && p.leg_variant % 2 == 0)) {
    AddLowBack(b, chair);
  }
  return b.Finish();
}

}  // namespace

Asset SampleBarChair(Rng& rng) {
  return MakeBarChair(
      {.style = DrawEnum<BarChairStyle>(rng, static_cast<int>(BarChairStyle::kCount)),
       .seat_height_m = Draw(rng, 0.63, 0.8),
       .seat_width_m = Draw(rng, 0.33, 0.4),
       .round_seat = rng.Bernoulli(0.6),
       .padded = rng.Bernoulli(0.6),
       .legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount)),
       .leg_variant = rng.UniformInt(0, 11),
       .seed = rng.Seed()});
}

}  // namespace parallax
