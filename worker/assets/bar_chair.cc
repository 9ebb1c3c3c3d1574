#include <algorithm>
#include <cmath>

#include "worker/assets/chairs.h"

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Asset MakeBarChair(const BarChairParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  const float h = p.seat_height_m, r = 0.5f * p.seat_width_m;
  const MaterialSlot metal = MetalSlot("metal");
  const bool pedestal = p.style == BarChairStyle::kPedestal;
  const MaterialSlot frame = pedestal ? metal : Slot("frame", {"wood", "metal", "paint"});
  const MaterialSlot seat_slot = p.padded ? FabricSlot("seat") : WoodSlot("frame");
  const float pad = p.padded ? 0.06f : 0.03f;
  if (p.round_seat) {
    if (p.padded) {
      const Path2 profile = Filleted(Path2{{0, 0},
                                           {r - 0.005f, 0},
                                           {r, 0.02f},
                                           {r, pad - 0.012f},
                                           {0.75f * r, pad + 0.002f},
                                           {0, pad + 0.01f}},
                                     0.016f, 5);
      LatheOptions options;
      options.modulate = [&](float a, float z) {
        return 1 + 0.008f * noise.At({4 * std::cos(a), 4 * std::sin(a), z * 30});
      };
      b.Add(Lathe(profile, options).Moved(0, 0, h - pad), seat_slot);
      std::vector<Vec3f> ring;
      for (int i = 0; i < 48; ++i) {
        const float a = 2 * kPi * static_cast<float>(i) / 48.0f;
        ring.emplace_back((r + 0.001f) * std::cos(a), (r + 0.001f) * std::sin(a), h - pad + 0.012f);
      }
      b.Add(Ring(ring, 0.004f), seat_slot);
    } else {
      const Path2 profile = Filleted(Path2{{0, 0},
                                           {r - 0.006f, 0},
                                           {r, 0.015f},
                                           {r - 0.004f, pad},
                                           {0.8f * r, pad - 0.002f},
                                           {0, pad - 0.01f}},
                                     0.008f, 4);
      Shape seat = Lathe(profile).Moved(0, 0, h - pad);
      for (size_t i = 0; i < seat.points.size(); ++i) seat.texture[i] = seat.points[i];
      b.Add(seat, seat_slot);
    }
  } else {
    CushionOptions soft;
    soft.edge_radius_m = p.padded ? 0.022f : 0.008f;
    soft.bulge_top_m = p.padded ? 0.015f : 0.0f;
    soft.bulge_side_m = 0;
    soft.wrinkle_m = p.padded ? 0.0015f : 0.0f;
    const Shape seat = Cushion({2 * r, 1.9f * r, pad}, soft, noise).Bent([&](const Vec3f& q) {
      return Vec3f(q.x(), q.y(), q.z() + (p.padded ? 0.1f : 0.55f) * q.x() * q.x());
    });
    b.Add(seat.Moved(0, 0, h - 0.5f * pad), seat_slot);
  }
  const float under = h - pad + 0.004f;
  if (pedestal) {
    b.Add(Lathe(Spline(Path2{{0.21f, 0},
                             {0.212f, 0.006f},
                             {0.2f, 0.014f},
                             {0.1f, 0.03f},
                             {0.045f, 0.06f},
                             {0.03f, 0.13f},
                             {0.028f, 0.3f}},
                       5)),
          metal);
    b.Add(Cylinder(0.02f, under - 0.25f, 0.002f).Moved(0, 0, 0.26f), metal);
    b.Add(Cone(0.03f, 0.1f, 0.035f, 0.004f).Moved(0, 0, under - 0.034f), metal);
    const Path3 rest = Filleted(Path3{{0, 0.02f, 0.34f},
                                      {0.14f, 0.05f, 0.34f},
                                      {0.15f, 0.19f, 0.34f},
                                      {-0.15f, 0.19f, 0.34f},
                                      {-0.14f, 0.05f, 0.34f},
                                      {0, 0.02f, 0.34f}},
                                0.06f, 6);
    b.Add(Tube(rest, 0.01f, 0.002f, 14), metal);
    b.Add(Cylinder(0.036f, 0.05f, 0.004f).Moved(0, 0, 0.315f), metal);
  } else {
    const float top = 0.62f * r, foot = std::max(0.17f, 1.0f * r);
    std::vector<Vec3f> at_rest;
    const float z = 0.3f * h;
    for (int i = 0; i < 4; ++i) {
      const float sx = i == 0 || i == 3 ? 1.0f : -1.0f, sy = i < 2 ? 1.0f : -1.0f;
      const Vec3f from(sx * foot, sy * foot, 0), to(sx * top, sy * top, under);
      b.Add(FurnitureLeg(p.legs, from, to, 0.034f, p.leg_variant), frame);
      at_rest.push_back(from + (to - from) * (z / under));
    }
    if (p.round_seat && p.legs == LegStyle::kRound) {
      const float ring = at_rest[0].head<2>().norm();
      std::vector<Vec3f> path;
      for (int i = 0; i < 48; ++i) {
        const float a = 2 * kPi * static_cast<float>(i) / 48.0f;
        path.emplace_back(ring * std::cos(a), ring * std::sin(a), z);
      }
      b.Add(Ring(path, 0.008f, 12), metal);
      b.Add(Cylinder(0.9f * r, 0.02f, 0.003f).Moved(0, 0, under - 0.018f), frame);
    } else {
      for (int i = 0; i < 4; ++i) {
        const float lift = i % 2 == 0 ? 0.0f : 0.06f;
        const Vec3f a = at_rest[i] + Vec3f(0, 0, lift),
                    c = at_rest[(i + 1) % 4] + Vec3f(0, 0, lift);
        b.Add(Bar(a, c, {0.016f, 0.026f}, {0.016f, 0.026f}), frame);
      }
      for (int i = 0; i < 4; ++i) {
        const float sx = i == 0 || i == 3 ? 1.0f : -1.0f, sy = i < 2 ? 1.0f : -1.0f;
        const float nx = i == 1 || i == 0 ? -sx : sx, ny = i == 1 || i == 0 ? sy : -sy;
        const float t = top + 0.012f;
        b.Add(Bar({sx * t, sy * t, under - 0.03f}, {nx * t, ny * t, under - 0.03f}, {0.016f, 0.05f},
                  {0.016f, 0.05f}),
              frame);
      }
    }
  }
  if (p.style == BarChairStyle::kLowBack || (pedestal && p.leg_variant % 2 == 0)) {
    const float rise = 0.2f;
    SheetOptions sheet;
    sheet.pieces_u = 24;
    sheet.pieces_v = 8;
    sheet.thickness_m = p.padded ? 0.024f : 0.012f;
    sheet.size_m = {2.4f * r, 0.13f};
    const float span = 1.15f;
    const Shape back = Sheet(
        [&](float u, float v) {
          const float a = -0.5f * kPi + span * (1 - 2 * u);
          const float rr = r * 0.98f + 0.02f * v;
          return Vec3f(rr * std::cos(a), rr * std::sin(a),
                       h + rise - 0.075f + 0.13f * v * (1 - 0.25f * std::pow(2 * u - 1, 4.0f)));
        },
        sheet);
    b.Add(back, seat_slot);
    for (const float s : {-1.0f, 1.0f}) {
      const float a = -0.5f * kPi + 0.6f * span * s;
      const Vec3f out(std::cos(a), std::sin(a), 0);
      b.Add(Tube(Filleted(Path3{0.5f * r * out + Vec3f(0, 0, under - 0.004f),
                                (r + 0.022f) * out + Vec3f(0, 0, under - 0.004f),
                                (r + 0.022f) * out + Vec3f(0, 0, h + rise)},
                          0.03f, 5),
                 0.008f, 0.003f, 12),
            metal);
    }
  }
  return b.Finish();
}

Asset SampleBarChair(Rng& rng) {
  BarChairParams p;
  p.style = DrawEnum<BarChairStyle>(rng, static_cast<int>(BarChairStyle::kCount));
  p.seat_height_m = Draw(rng, 0.63, 0.8);
  p.seat_width_m = Draw(rng, 0.33, 0.4);
  p.round_seat = rng.Bernoulli(0.6);
  p.padded = rng.Bernoulli(0.6);
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.leg_variant = rng.UniformInt(0, 11);
  p.seed = rng.Seed();
  return MakeBarChair(p);
}

}  // namespace parallax
