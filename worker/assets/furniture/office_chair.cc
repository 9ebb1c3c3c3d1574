#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kOfficeSeatDepth = 0.48f, kOfficeBackWidth = 0.46f;

// A swivel chair on a five-spoke base.
struct OfficeChairParams {
  float seat_width_m = 0.50f;
  float seat_height_m = 0.48f;
  float back_height_m = 0.56f;  // Above the seat.
  float base_radius_m = 0.32f;
  bool mesh_back = false;  // A framed net instead of a cushion.
  bool arms = true;
  bool headrest = false;
  uint64_t seed = 0;
};

// Dimensions and slots that the parts of an office chair share.
struct OfficeChair {
  explicit OfficeChair(const OfficeChairParams& params)
      : p(params),
        noise(params.seed),
        under(params.seat_height_m - 0.085f),
        low(params.seat_height_m + 0.07f),
        back_height(params.back_height_m - 0.07f) {}

  // A point of the back, curved in plan and in profile, leaning; `z` from its lower edge.
  Vec3f BackAt(float x, float z) const {
    const float t = z / back_height;
    const float lumbar = 0.028f * std::sin(kPi * std::min(1.0f, t * 1.35f));
    return Vec3f(x, -0.235f - 0.1f * t * t + lumbar - 0.02f + 0.9f * x * x * (0.6f + 0.2f * t),
                 low + z);
  }

  const OfficeChairParams& p;
  const Noise noise;
  const MaterialSlot base = Slot("base", {"HousingPlastic", "metal"}),
                     plastic = Slot("plastic", {"HousingPlastic", "plastic"}),
                     fabric = FabricSlot("seat");
  const float under;             // Height of the mechanism below the seat.
  const float low, back_height;  // The back's lower edge and its height above it.
};

CushionOptions OfficeUpholstery() {
  return {
      .edge_radius_m = 0.03f, .bulge_top_m = 0.014f, .wrinkle_m = 0.0015f, .target_edge_m = 0.026f};
}

// Two wheels on an axle, and the stem that holds them below the end of an arm.
void AddCaster(AssetBuilder& b, const OfficeChair& c, const Vec3f& hub, const Vec3f& axle) {
  b.Add(Cylinder(0.0055f, 0.03f, 0.001f, 12).Moved(hub + Vec3f(0, 0, 0.035f)), MetalSlot("stem"));
  for (const float s : {-1.0f, 1.0f}) {
    const Shape wheel = Lathe(Filleted(
        Path2{{0, 0}, {0.024f, 0}, {0.026f, 0.009f}, {0.022f, 0.018f}, {0, 0.02f}}, 0.004f, 3));
    b.Add(AlongZ(wheel, hub + 0.004f * s * axle + Vec3f(0, 0, 0.026f),
                 hub + s * axle + Vec3f(0, 0, 0.026f)),
          c.plastic);
  }
  b.Add(Ball(0.012f, 12).Moved(hub + Vec3f(0, 0, 0.04f)), c.plastic);
}

// Five arms on twin-wheel casters.
void AddStar(AssetBuilder& b, const OfficeChair& c) {
  for (int i = 0; i < 5; ++i) {
    const float a = 2 * kPi * static_cast<float>(i) / 5.0f + 0.3f;
    const Vec3f out(std::cos(a), std::sin(a), 0);
    SweepOptions options;
    options.keep_up = true;
    options.end_round_m = 0.008f;
    options.scale = [](float t) { return Vec2f(1.0f - 0.45f * t, 1.0f - 0.4f * t); };
    const float radius = c.p.base_radius_m;
    const Path3 arm =
        Spline(Path3{0.02f * out + Vec3f(0, 0, 0.1f), 0.5f * radius * out + Vec3f(0, 0, 0.092f),
                     radius * out + Vec3f(0, 0, 0.07f)},
               5);
    b.Add(Sweep(arm, RectSection(0.05f, 0.034f, 0.01f, 3), options), c.base);
    const float swivel = 0.9f * static_cast<float>(i * i % 4);
    const Vec3f across(-out.y(), out.x(), 0);
    const Vec3f axle = Eigen::AngleAxisf(swivel, Vec3f::UnitZ()) * across;
    AddCaster(b, c, (radius - 0.012f) * out, axle);
  }
}

// The gas spring in its sleeve, the mechanism with its lever.
void AddGasSpring(AssetBuilder& b, const OfficeChair& c) {
  b.Add(Lathe(Filleted(
            Path2{{0, 0.075f}, {0.042f, 0.075f}, {0.046f, 0.1f}, {0.03f, 0.13f}, {0, 0.13f}},
            0.008f, 3)),
        c.base);
  b.Add(Cylinder(0.025f, 0.16f, 0.002f).Moved(0, 0, 0.12f), c.plastic);
  b.Add(Cylinder(0.014f, c.p.seat_height_m - 0.3f, 0.001f).Moved(0, 0, 0.22f), MetalSlot("stem"));
  const float under = c.under;
  b.Add(Board({-0.09f, -0.12f, under - 0.035f}, {0.09f, 0.11f, under + 0.012f}, 0.012f), c.plastic);
  b.Add(Tube(Filleted(Path3{{0.05f, 0.04f, under - 0.012f},
                            {0.2f, 0.05f, under - 0.012f},
                            {0.24f, 0.055f, under - 0.018f}},
                      0.03f, 4),
             0.005f, 0.004f),
        c.plastic);
}

// A cushion with a waterfall front edge over a shell.
void AddOfficeSeat(AssetBuilder& b, const OfficeChair& c) {
  const float w = c.p.seat_width_m, d = kOfficeSeatDepth;
  const auto waterfall = [&](const Vec3f& q) {
    const float v = q.y() / (0.5f * d), u = q.x() / (0.5f * w);
    const float drop = v > 0.45f ? 0.055f * (v - 0.45f) * (v - 0.45f) / 0.3f : 0.0f;
    return Vec3f(q.x() * (1 - 0.07f * (1 - v) * 0.5f), q.y(),
                 q.z() - drop + 0.018f * u * u - 0.004f);
  };
  b.Add(Cushion({w, d, 0.07f}, OfficeUpholstery(), c.noise)
            .Bent(waterfall)
            .Moved(0, 0.01f, c.p.seat_height_m - 0.04f),
        c.fabric);
  b.Add(RoundedBox({w - 0.03f, d - 0.03f, 0.016f}, {.bevel_m = 0.007f, .pieces = {10, 12, 1}})
            .Bent(waterfall)
            .Moved(0, 0.01f, c.under + 0.016f),
        c.plastic);
}

// The rim of the back in its own (x, z), closed.
Path2 BackOutline(const OfficeChair& c) {
  const float height = c.back_height;
  Path2 outline;
  for (const Vec2f& q : SuperellipseSection(kOfficeBackWidth, height, 4.0f, 64)) {
    const float t = q.y() / height + 0.5f;
    outline.emplace_back(q.x() * (1 - 0.16f * (t - 0.35f) * (t - 0.35f) * 2),
                         q.y() + 0.5f * height);
  }
  return outline;
}

// Half of the outline's width at a height.
float HalfWidthAt(const Path2& outline, float z) {
  float half = 0;
  for (size_t k = 0; k < outline.size(); ++k) {
    const Vec2f &q0 = outline[k], &q1 = outline[(k + 1) % outline.size()];
    if ((q0.y() - z) * (q1.y() - z) <= 0 && std::abs(q1.y() - q0.y()) > 1e-6f) {
      half =
          std::max(half, std::abs(q0.x() + (q1.x() - q0.x()) * (z - q0.y()) / (q1.y() - q0.y())));
    }
  }
  return half;
}

// A frame with a net of threads both ways.
void AddNetBack(AssetBuilder& b, const OfficeChair& c) {
  const MaterialSlot net = Slot("net", {"fabric", "plastic"});
  const Path2 outline = BackOutline(c);
  Path3 rim;
  for (const Vec2f& q : outline) rim.push_back(c.BackAt(q.x(), q.y()));
  b.Add(Ring(rim, 0.011f, 10), c.plastic);
  for (int i = 1; i < 34; ++i) {
    const float z = c.back_height * static_cast<float>(i) / 34.0f;
    const float half = HalfWidthAt(outline, z);
    Path3 thread;
    for (int k = 0; k <= 12; ++k)
      thread.push_back(c.BackAt(half * (static_cast<float>(k) / 6.0f - 1), z));
    b.Add(Tube(thread, 0.0026f, 0, 6), net);
  }
  for (int i = 1; i < 9; ++i) {
    const float x = kOfficeBackWidth * (static_cast<float>(i) / 9.0f - 0.5f);
    Path3 thread;
    for (int k = 1; k < 20; ++k) {
      const float z = c.back_height * (0.035f + 0.93f * static_cast<float>(k - 1) / 18.0f);
      thread.push_back(c.BackAt(x * 0.93f, z) + Vec3f(0, -0.003f, 0));
    }
    b.Add(Tube(thread, 0.0024f, 0, 6), net);
  }
}

void AddPaddedBack(AssetBuilder& b, const OfficeChair& c) {
  const float width = kOfficeBackWidth, height = c.back_height;
  CushionOptions pad = OfficeUpholstery();
  pad.edge_radius_m = 0.024f;
  Shape back = Cushion({width, height, 0.06f}, pad, c.noise).Bent([&](const Vec3f& q) {
    const float t = q.y() / height + 0.5f;
    const float narrow = 1 - 0.32f * (t - 0.35f) * (t - 0.35f);
    const float corner =
        std::sqrt(1 - 0.22f * std::pow(std::min(1.0f, std::abs(2 * q.x() / width)), 4.0f));
    const float y = q.y() * corner;
    return Vec3f(c.BackAt(q.x() * narrow, y + 0.5f * height) + Vec3f(0, q.z(), 0));
  });
  for (Face& f : back.faces) std::reverse(f.v.begin(), f.v.begin() + f.corners);
  b.Add(back, c.fabric);
}

// The spine from the mechanism to the back, and the bar that holds a net's frame.
void AddSpine(AssetBuilder& b, const OfficeChair& c) {
  const SweepOptions options{.up = Vec3f::UnitX(), .keep_up = true};
  const float reach = 0.45f * c.back_height;
  const Vec3f hold = c.BackAt(0, reach) + Vec3f(0, c.p.mesh_back ? -0.012f : -0.028f, 0);
  const Path3 curve = Spline(Path3{{0, -0.08f, c.under - 0.012f},
                                   {0, -0.24f, c.under - 0.01f},
                                   {0, -0.315f, c.under + 0.09f},
                                   hold},
                             7);
  b.Add(Sweep(curve, RectSection(0.022f, 0.07f, 0.008f, 3), options), c.plastic);
  if (!c.p.mesh_back) return;
  Path3 bar;
  for (int k = 0; k <= 10; ++k)
    bar.push_back(c.BackAt(0.47f * kOfficeBackWidth * (static_cast<float>(k) / 5.0f - 1), reach) +
                  Vec3f(0, -0.012f, 0));
  b.Add(Tube(bar, 0.009f, 0.004f, 10), c.plastic);
}

void AddHeadrest(AssetBuilder& b, const OfficeChair& c) {
  const Vec3f at = c.BackAt(0, c.back_height);
  b.AddMirroredX(
      Tube({at + Vec3f(0.04f, -0.01f, -0.06f), at + Vec3f(0.04f, -0.015f, 0.09f)}, 0.005f),
      MetalSlot("stem"));
  b.Add(Cushion({0.26f, 0.13f, 0.055f}, OfficeUpholstery(), c.noise)
            .TurnedX(-0.5f * kPi)
            .Bent([](const Vec3f& q) { return Vec3f(q.x(), q.y() + 1.1f * q.x() * q.x(), q.z()); })
            .Moved(at + Vec3f(0, -0.012f, 0.11f)),
        c.fabric);
}

// Pads on posts that come from below the seat.
void AddOfficeArms(AssetBuilder& b, const OfficeChair& c) {
  const float x = 0.5f * c.p.seat_width_m + 0.035f, z = c.p.seat_height_m + 0.2f;
  const Path3 post = Filleted(
      Path3{{0.12f, -0.04f, c.under - 0.005f}, {x, -0.04f, c.under - 0.005f}, {x, -0.04f, z}},
      0.05f, 6);
  b.AddMirroredX(
      Sweep(post, RectSection(0.026f, 0.05f, 0.008f, 3), {.up = Vec3f::UnitY(), .keep_up = true}),
      c.plastic);
  const Shape pad = RoundedBox({0.085f, 0.26f, 0.03f},
                               {.bevel_m = 0.013f, .bevel_steps = 2, .pieces = {2, 10, 1}})
                        .Bent([](const Vec3f& q) {
                          return Vec3f(q.x() * (1 - 2.2f * std::abs(q.y()) * std::abs(q.y())),
                                       q.y(), q.z() - 0.6f * q.y() * q.y());
                        });
  b.AddMirroredX(pad.Moved(x, -0.01f, z + 0.012f), Slot("armrest", {"HousingPlastic", "leather"}));
}

Asset MakeOfficeChair(const OfficeChairParams& p) {
  AssetBuilder b(p.seed);
  const OfficeChair chair(p);
  AddStar(b, chair);
  AddGasSpring(b, chair);
  AddOfficeSeat(b, chair);
  p.mesh_back ? AddNetBack(b, chair) : AddPaddedBack(b, chair);
  AddSpine(b, chair);
  if (p.headrest) AddHeadrest(b, chair);
  if (p.arms) AddOfficeArms(b, chair);
  return b.Finish();
}

}  // namespace

Asset SampleOfficeChair(Rng& rng) {
  return MakeOfficeChair({.seat_width_m = Draw(rng, 0.47, 0.53),
                          .seat_height_m = Draw(rng, 0.43, 0.53),
                          .back_height_m = Draw(rng, 0.48, 0.68),
                          .base_radius_m = Draw(rng, 0.29, 0.34),
                          .mesh_back = rng.Bernoulli(0.5),
                          .arms = rng.Bernoulli(0.75),
                          .headrest = rng.Bernoulli(0.3),
                          .seed = rng.Seed()});
}

}  // namespace parallax
