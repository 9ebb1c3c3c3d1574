#include <algorithm>
#include <cmath>

#include "worker/assets/chairs.h"

namespace parallax {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Asset MakeOfficeChair(const OfficeChairParams& p) {
  AssetBuilder b(p.seed);
  const Noise noise(p.seed);
  const MaterialSlot base = Slot("base", {"HousingPlastic", "metal"}),
                     plastic = Slot("plastic", {"HousingPlastic", "plastic"});
  const MaterialSlot fabric = FabricSlot("seat");
  // Five arms on twin-wheel casters.
  for (int i = 0; i < 5; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 5.0f + 0.3f;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.008f;
    options.scale = [](float t) { return Vec2f(1.0f - 0.45f * t, 1.0f - 0.4f * t); };
    const Path3 arm = Spline(
        Path3{0.02f * out + Vec3f(0, 0, 0.1f), 0.5f * p.base_radius_m * out + Vec3f(0, 0, 0.092f),
              p.base_radius_m * out + Vec3f(0, 0, 0.07f)},
        5);
    b.Add(Sweep(arm, RectSection(0.05f, 0.034f, 0.01f, 3), options), base);
    const Vec3f hub = (p.base_radius_m - 0.012f) * out;
    b.Add(Cylinder(0.0055f, 0.03f, 0.001f, 12).Moved(hub + Vec3f(0, 0, 0.035f)), MetalSlot("stem"));
    const Vec3f axle(-out.y(), out.x(), 0);
    const float swivel = 0.9f * static_cast<float>(i * i % 4);
    const Vec3f roll = Eigen::AngleAxisf(swivel, Vec3f::UnitZ()) * axle;
    for (const float s : {-1.0f, 1.0f}) {
      const Shape wheel = Lathe(Filleted(
          Path2{{0, 0}, {0.024f, 0}, {0.026f, 0.009f}, {0.022f, 0.018f}, {0, 0.02f}}, 0.004f, 3));
      b.Add(AlongZ(wheel, hub + 0.004f * s * roll + Vec3f(0, 0, 0.026f),
                   hub + s * roll + Vec3f(0, 0, 0.026f)),
            plastic);
    }
    b.Add(Ball(0.012f, 12).Moved(hub + Vec3f(0, 0, 0.04f)), plastic);
  }
  b.Add(Lathe(Filleted(
            Path2{{0, 0.075f}, {0.042f, 0.075f}, {0.046f, 0.1f}, {0.03f, 0.13f}, {0, 0.13f}},
            0.008f, 3)),
        base);
  b.Add(Cylinder(0.025f, 0.16f, 0.002f).Moved(0, 0, 0.12f), plastic);
  b.Add(Cylinder(0.014f, p.seat_height_m - 0.3f, 0.001f).Moved(0, 0, 0.22f), MetalSlot("stem"));
  const float under = p.seat_height_m - 0.085f;
  b.Add(Board({-0.09f, -0.12f, under - 0.035f}, {0.09f, 0.11f, under + 0.012f}, 0.012f), plastic);
  b.Add(Tube(Filleted(Path3{{0.05f, 0.04f, under - 0.012f},
                            {0.2f, 0.05f, under - 0.012f},
                            {0.24f, 0.055f, under - 0.018f}},
                      0.03f, 4),
             0.005f, 0.004f),
        plastic);
  // Seat: a waterfall front edge over a shell.
  const float w = p.seat_width_m, d = 0.48f;
  const auto waterfall = [&](const Vec3f& q) {
    const float v = q.y() / (0.5f * d), u = q.x() / (0.5f * w);
    const float drop = v > 0.45f ? 0.055f * (v - 0.45f) * (v - 0.45f) / 0.3f : 0.0f;
    return Vec3f(q.x() * (1 - 0.07f * (1 - v) * 0.5f), q.y(),
                 q.z() - drop + 0.018f * u * u - 0.004f);
  };
  CushionOptions soft;
  soft.edge_radius_m = 0.03f;
  soft.bulge_top_m = 0.014f;
  soft.wrinkle_m = 0.0015f;
  soft.target_edge_m = 0.026f;
  b.Add(
      Cushion({w, d, 0.07f}, soft, noise).Bent(waterfall).Moved(0, 0.01f, p.seat_height_m - 0.04f),
      fabric);
  BoxOptions tray;
  tray.bevel_m = 0.007f;
  tray.pieces = {10, 12, 1};
  b.Add(RoundedBox({w - 0.03f, d - 0.03f, 0.016f}, tray)
            .Bent(waterfall)
            .Moved(0, 0.01f, under + 0.016f),
        plastic);
  // Back: curved in plan and in profile, leaning.
  const float low = p.seat_height_m + 0.07f, bh = p.back_height_m - 0.07f;
  const auto back_at = [&](float x, float z) {  // z from the back's lower edge.
    const float t = z / bh;
    const float lumbar = 0.028f * std::sin(kPi * std::min(1.0f, t * 1.35f));
    return Vec3f(x, -0.235f - 0.1f * t * t + lumbar - 0.02f + 0.9f * x * x * (0.6f + 0.2f * t),
                 low + z);
  };
  const float bw = 0.46f;
  const auto outline = [&](float a) {  // The back's rim, in (x, z).
    const Path2 s = SuperellipseSection(bw, bh, 4.0f, 64);
    const Vec2f q = s[static_cast<size_t>(std::lround(a * 64)) % 64];
    const float t = q.y() / bh + 0.5f;
    return Vec2f(q.x() * (1 - 0.16f * (t - 0.35f) * (t - 0.35f) * 2), q.y() + 0.5f * bh);
  };
  if (p.mesh_back) {
    Path3 rim;
    for (int i = 0; i < 64; ++i) {
      const Vec2f q = outline(static_cast<float>(i) / 64.0f);
      rim.push_back(back_at(q.x(), q.y()));
    }
    b.Add(Ring(rim, 0.011f, 10), plastic);
    // The net: threads both ways.
    for (int i = 1; i < 34; ++i) {
      const float z = bh * static_cast<float>(i) / 34.0f;
      float half = 0;
      for (int k = 0; k < 64; ++k) {
        const Vec2f q0 = outline(static_cast<float>(k) / 64.0f),
                    q1 = outline(static_cast<float>(k + 1) / 64.0f);
        if ((q0.y() - z) * (q1.y() - z) <= 0 && std::abs(q1.y() - q0.y()) > 1e-6f) {
          half = std::max(half,
                          std::abs(q0.x() + (q1.x() - q0.x()) * (z - q0.y()) / (q1.y() - q0.y())));
        }
      }
      Path3 thread;
      for (int k = 0; k <= 12; ++k)
        thread.push_back(back_at(half * (static_cast<float>(k) / 6.0f - 1), z));
      b.Add(Tube(thread, 0.0026f, 0, 6), Slot("net", {"fabric", "plastic"}));
    }
    for (int i = 1; i < 9; ++i) {
      const float x = bw * (static_cast<float>(i) / 9.0f - 0.5f);
      Path3 thread;
      for (int k = 1; k < 20; ++k) {
        const float z = bh * (0.035f + 0.93f * static_cast<float>(k - 1) / 18.0f);
        thread.push_back(back_at(x * 0.93f, z) + Vec3f(0, -0.003f, 0));
      }
      b.Add(Tube(thread, 0.0024f, 0, 6), Slot("net", {"fabric", "plastic"}));
    }
  } else {
    CushionOptions pad = soft;
    pad.edge_radius_m = 0.024f;
    const Shape back = Cushion({bw, bh, 0.06f}, pad, noise).Bent([&](const Vec3f& q) {
      const float t = q.y() / bh + 0.5f;
      const float narrow = 1 - 0.32f * (t - 0.35f) * (t - 0.35f);
      const float corner =
          std::sqrt(1 - 0.22f * std::pow(std::min(1.0f, std::abs(2 * q.x() / bw)), 4.0f));
      const float y = q.y() * corner;
      return Vec3f(back_at(q.x() * narrow, y + 0.5f * bh) + Vec3f(0, q.z(), 0));
    });
    Shape front = back;
    for (Face& f : front.faces) std::reverse(f.v.begin(), f.v.begin() + f.corners);
    b.Add(front, fabric);
  }
  // Spine from the mechanism to the back.
  SweepOptions spine;
  spine.keep_up = true;
  spine.up = Vec3f::UnitX();
  const float reach = 0.45f * bh;
  const Vec3f hold = back_at(0, reach) + Vec3f(0, p.mesh_back ? -0.012f : -0.028f, 0);
  Path3 curve = Spline(Path3{{0, -0.08f, under - 0.012f},
                             {0, -0.24f, under - 0.01f},
                             {0, -0.315f, under + 0.09f},
                             hold},
                       7);
  b.Add(Sweep(curve, RectSection(0.022f, 0.07f, 0.008f, 3), spine), plastic);
  if (p.mesh_back) {
    Path3 bar;
    for (int k = 0; k <= 10; ++k)
      bar.push_back(back_at(0.47f * bw * (static_cast<float>(k) / 5.0f - 1), reach) +
                    Vec3f(0, -0.012f, 0));
    b.Add(Tube(bar, 0.009f, 0.004f, 10), plastic);
  }
  if (p.headrest) {
    const Vec3f at = back_at(0, bh);
    b.AddMirroredX(
        Tube({at + Vec3f(0.04f, -0.01f, -0.06f), at + Vec3f(0.04f, -0.015f, 0.09f)}, 0.005f),
        MetalSlot("stem"));
    b.Add(
        Cushion({0.26f, 0.13f, 0.055f}, soft, noise)
            .TurnedX(-0.5f * kPi)
            .Bent([](const Vec3f& q) { return Vec3f(q.x(), q.y() + 1.1f * q.x() * q.x(), q.z()); })
            .Moved(at + Vec3f(0, -0.012f, 0.11f)),
        fabric);
  }
  if (p.arms) {
    const float x = 0.5f * w + 0.035f, z = p.seat_height_m + 0.2f;
    const Path3 post = Filleted(
        Path3{{0.12f, -0.04f, under - 0.005f}, {x, -0.04f, under - 0.005f}, {x, -0.04f, z}}, 0.05f,
        6);
    SweepOptions flat;
    flat.up = Vec3f::UnitY();
    flat.keep_up = true;
    b.AddMirroredX(Sweep(post, RectSection(0.026f, 0.05f, 0.008f, 3), flat), plastic);
    BoxOptions rest;
    rest.bevel_m = 0.013f;
    rest.bevel_steps = 2;
    rest.pieces = {2, 10, 1};
    const Shape pad = RoundedBox({0.085f, 0.26f, 0.03f}, rest).Bent([](const Vec3f& q) {
      return Vec3f(q.x() * (1 - 2.2f * std::abs(q.y()) * std::abs(q.y())), q.y(),
                   q.z() - 0.6f * q.y() * q.y());
    });
    b.AddMirroredX(pad.Moved(x, -0.01f, z + 0.012f),
                   Slot("armrest", {"HousingPlastic", "leather"}));
  }
  return b.Finish();
}

Asset SampleOfficeChair(Rng& rng) {
  OfficeChairParams p;
  p.seat_width_m = Draw(rng, 0.47, 0.53);
  p.seat_height_m = Draw(rng, 0.43, 0.53);
  p.back_height_m = Draw(rng, 0.48, 0.68);
  p.base_radius_m = Draw(rng, 0.29, 0.34);
  p.mesh_back = rng.Bernoulli(0.5);
  p.arms = rng.Bernoulli(0.75);
  p.headrest = rng.Bernoulli(0.3);
  p.seed = rng.Seed();
  return MakeOfficeChair(p);
}

}  // namespace parallax
