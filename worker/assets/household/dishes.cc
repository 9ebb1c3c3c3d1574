#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/household/vessel_parts.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// An open bowl.
struct BowlParams {
  float radius_m = 0.1f, height_m = 0.07f;
  int form = 0;      // 0 flaring, 1 straight-sided, 2 on a foot.
  int scallops = 0;  // Waves of the rim; 0 = round.
  uint64_t seed = 0;
};

Asset MakeBowl(const BowlParams& p) {
  const float r = p.radius_m, h = p.height_m;
  const int form = p.form, scallops = p.scallops;
  Path2 wall;
  if (form == 0)
    wall = Profile({{0.42f, 0}, {0.43f, 0.05f}, {0.5f, 0.1f}, {0.84f, 0.45f}, {1, 1}}, r, h, 7);
  if (form == 1)
    wall = Profile({{0.5f, 0}, {0.55f, 0.03f}, {0.86f, 0.3f}, {0.97f, 0.65f}, {0.98f, 1}}, r, h, 7);
  if (form == 2)
    wall = Profile(
        {{0.4f, 0}, {0.42f, 0.12f}, {0.6f, 0.2f}, {0.86f, 0.5f}, {0.92f, 0.85f}, {1.02f, 1}}, r, h,
        7);
  LatheOptions options{.segments = 72};
  if (scallops > 0) {
    options.modulate = [&](float a, float z) {
      return 1 + 0.03f * Smooth01(z / h) * std::cos(static_cast<float>(scallops) * a);
    };
  }
  AssetBuilder b(p.seed);
  b.Add(Lathe(VesselProfile(WithFoot(wall), 0.0035f, 0.006f), options),
        Slot("body", {"ceramic", "wood", "metal", "glass"}));
  return b.Finish();
}

// A plate.
struct PlateParams {
  float radius_m = 0.13f, height_m = 0.022f;
  bool coupe = false;   // Without a rim.
  bool square = false;  // In plan, with round corners.
  uint64_t seed = 0;
};

Asset MakePlate(const PlateParams& p) {
  const float r = p.radius_m, h = p.height_m;
  AssetBuilder b(p.seed);
  const Path2 wall =
      p.coupe ? Profile({{0.56f, 0}, {0.57f, 0.1f}, {0.64f, 0.14f}, {0.86f, 0.4f}, {1, 1}}, r, h, 6)
              : Profile({{0.58f, 0},
                         {0.59f, 0.1f},
                         {0.62f, 0.14f},
                         {0.68f, 0.45f},
                         {0.72f, 0.55f},
                         {0.86f, 0.75f},
                         {1, 1}},
                        r, h, 6);
  LatheOptions options{.segments = 72};
  if (p.square) {
    options.modulate = [](float a, float) {
      const float c = std::abs(std::cos(a)), s = std::abs(std::sin(a));
      return 0.96f / std::pow(std::pow(c, 5.0f) + std::pow(s, 5.0f), 0.2f);
    };
  }
  b.Add(Lathe(VesselProfile(WithFoot(wall), 0.004f, 0.005f), options), CeramicSlot("body"));
  return b.Finish();
}

MaterialSlot GripSlot() { return Slot("handles", {"metal", "plastic", "wood"}); }
MaterialSlot PotSlot() { return Slot("body", {"metal", "ceramic"}); }

// The long handle of a pan.
void AddPanHandle(AssetBuilder& b, float r, float height) {
  SweepOptions options;
  options.keep_up = true;
  options.end_round_m = 0.006f;
  options.scale = [](float t) { return Vec2f(0.7f + 0.5f * Smooth01(t * 1.4f), 1.0f); };
  const Path3 path = Spline(Path3{{r - 0.002f, 0, 0.7f * height},
                                  {r + 0.05f, 0, 0.82f * height},
                                  {r + 0.12f, 0, 0.95f * height},
                                  {r + 0.2f, 0, height + 0.012f}},
                            6);
  b.Add(Sweep(path, EllipseSection(0.022f, 0.013f, 16), options), GripSlot());
}

// Two loops on plates.
void AddLoopHandles(AssetBuilder& b, float r, float height) {
  const float z = 0.78f * height, w = 0.042f;
  b.AddMirroredX(Tube(Filleted(Path3{{r - 0.003f, -w, z},
                                     {r + 0.038f, -w, z + 0.006f},
                                     {r + 0.038f, w, z + 0.006f},
                                     {r - 0.003f, w, z}},
                               0.02f, 6),
                      0.0055f, 0, 14),
                 GripSlot());
  for (const float s : {-w, w})
    b.AddMirroredX(
        Board({r - 0.004f, s - 0.011f, z - 0.014f}, {r + 0.0025f, s + 0.011f, z + 0.014f}, 0.002f),
        GripSlot());
}

// A lid with a knob.
void AddPotLid(AssetBuilder& b, float r, float height) {
  const Path2 lid = Spline(Path2{{r + 0.002f, 0.0f},
                                 {r + 0.003f, 0.003f},
                                 {0.96f * r, 0.007f},
                                 {0.7f * r, 0.018f},
                                 {0.3f * r, 0.026f},
                                 {0.02f * r, 0.028f}},
                           5);
  b.Add(Lathe(lid, {.segments = 64}).Moved(0, 0, height + 0.0012f), PotSlot());
  b.Add(Lathe(Spline(Path2{{0.008f, 0},
                           {0.008f, 0.008f},
                           {0.018f, 0.016f},
                           {0.02f, 0.024f},
                           {0.012f, 0.029f},
                           {0.001f, 0.03f}},
                     4))
            .Moved(0, 0, height + 0.028f),
        GripSlot());
}

// A cooking pot or pan.
struct PotParams {
  float radius_m = 0.12f, height_m = 0.13f;
  bool pan = false;  // One long handle instead of two loops.
  bool lid = false;
  uint64_t seed = 0;
};

Asset MakePot(const PotParams& p) {
  const float r = p.radius_m, height = p.height_m;
  AssetBuilder b(p.seed);
  const Path2 wall = Filleted(Path2{{0.6f * r, 0},
                                    {0.97f * r, 0},
                                    {r, 0.4f * height},
                                    {r, height - 0.004f},
                                    {r + 0.003f, height}},
                              0.014f, 5);
  b.Add(Lathe(VesselProfile(WithFoot(wall), 0.0028f, 0.004f), {.segments = 64}), PotSlot());
  p.pan ? AddPanHandle(b, r, height) : AddLoopHandles(b, r, height);
  if (p.lid) AddPotLid(b, r, height);
  return b.Finish();
}

void AddScrewCap(AssetBuilder& b, float neck, float h) {
  b.Add(Lathe(Filleted(Path2{{0, 0},
                             {neck + 0.003f, 0},
                             {neck + 0.003f, 0.003f},
                             {neck + 0.003f, 0.013f},
                             {neck + 0.003f, 0.016f},
                             {0, 0.016f}},
                       0.0012f, 3),
              {.segments = 120,
               .modulate =
                   [](float a, float z) {
                     return z > 0.002f && z < 0.014f ? 1 + 0.006f * std::cos(40 * a) : 1.0f;
                   }})
            .Moved(0, 0, h - 0.012f),
        Slot("lid", {"metal", "plastic"}));
}

// A stopper with a knob, of glass.
void AddStopper(AssetBuilder& b, float neck, float h) {
  b.Add(Lathe(Spline(Path2{{neck - 0.004f, -0.008f},
                           {neck - 0.004f, 0.0025f},
                           {neck + 0.003f, 0.004f},
                           {neck + 0.002f, 0.01f},
                           {0.3f * neck, 0.016f},
                           {0.012f, 0.02f},
                           {0.016f, 0.032f},
                           {0.001f, 0.038f}},
                     4))
            .Moved(0, 0, h),
        Slot("lid", {"glass", "ceramic"}));
}

// Closures of jars.
enum class JarClosure { kScrewCap, kCork, kGlassStopper, kCount };

// A storage jar with its contents.
struct JarParams {
  float radius_m = 0.045f, height_m = 0.12f;
  bool square = false;  // In plan, up to the shoulder.
  JarClosure closure = JarClosure::kScrewCap;
  float filled = 0.5f;  // Share of the height.
  uint64_t seed = 0;
};

Asset MakeJar(const JarParams& p) {
  const float r = p.radius_m, h = p.height_m;
  AssetBuilder b(p.seed);
  const float neck = 0.78f * r;
  const Path2 wall = Filleted(
      Path2{{0.6f * r, 0}, {r, 0}, {r, 0.5f * h}, {r, 0.84f * h}, {neck, 0.91f * h}, {neck, h}},
      0.16f * r, 5);
  LatheOptions options{.segments = 64};
  if (p.square) {
    options.modulate = [&](float a, float z) {
      const float c = std::abs(std::cos(a)), s = std::abs(std::sin(a));
      const float k = 1.0f / std::pow(std::pow(c, 6.0f) + std::pow(s, 6.0f), 1.0f / 6.0f);
      return Lerp(k * 0.93f, 1.0f, Smooth01((z / h - 0.8f) / 0.12f));
    };
  }
  b.Add(Lathe(VesselProfile(WithFoot(wall), 0.0028f, 0.005f), options), GlassSlot("body"));
  if (p.closure == JarClosure::kScrewCap) {
    AddScrewCap(b, neck, h);
  } else if (p.closure == JarClosure::kCork) {
    b.Add(Cone(neck - 0.0032f, neck + 0.002f, 0.03f, 0.002f).Moved(0, 0, h - 0.012f),
          Slot("lid", {"wood", "bark"}));
  } else {
    AddStopper(b, neck, h);
  }
  // The contents: a filling that follows the wall.
  const float level = h * p.filled;
  const Path2 fill = Filleted(Path2{{0, 0.0058f},
                                    {0.955f * r - 0.0026f, 0.0058f},
                                    {r - 0.0034f, 0.2f * h},
                                    {r - 0.0034f, level},
                                    {0, level}},
                              0.1f * r, 3);
  b.Add(Lathe(fill, options), Slot("contents", {"sand", "Gravel", "soil"}));
  return b.Finish();
}

// A glass with a stem.
struct WineglassParams {
  float height_m = 0.19f, radius_m = 0.038f;
  int form = 0;  // 0 tulip, 1 flute, 2 coupe.
  uint64_t seed = 0;
};

Asset MakeWineglass(const WineglassParams& p) {
  const float h = p.height_m, r = p.radius_m;
  const int form = p.form;
  AssetBuilder b(p.seed);
  // One profile: foot, stem, bowl outside; bowl inside closes it.
  const float stem = 0.42f * h, foot = 0.95f * r, t = 0.0014f;
  Path2 wall = Spline(Path2{{0.99f * foot, 0},
                            {foot, 0.001f},
                            {0.85f * foot, 0.003f},
                            {0.4f * foot, 0.007f},
                            {0.0065f, 0.018f},
                            {0.0042f, 0.035f},
                            {0.0042f, 0.8f * stem},
                            {0.007f, 0.95f * stem}},
                      4);
  Path2 bowl;
  if (form == 0)
    bowl =
        Profile({{0.25f, 0}, {0.75f, 0.16f}, {1, 0.42f}, {0.95f, 0.7f}, {0.8f, 1}}, r, h - stem, 6);
  if (form == 1)
    bowl = Profile({{0.2f, 0}, {0.5f, 0.1f}, {0.72f, 0.4f}, {0.82f, 0.75f}, {0.84f, 1}}, r,
                   h - stem, 6);
  if (form == 2)
    bowl = Profile({{0.25f, 0}, {0.85f, 0.2f}, {1.1f, 0.55f}, {1.2f, 1}}, r, 0.6f * (h - stem), 6);
  for (Vec2f& q : bowl) q.y() += stem;
  Path2 profile{{0, 0}};
  profile.insert(profile.end(), wall.begin(), wall.end());
  profile.insert(profile.end(), bowl.begin(), bowl.end());
  // Rim and inside.
  const Vec2f rim = bowl.back();
  profile.push_back(rim + Vec2f(-0.3f * t, 0.4f * t));
  profile.push_back(rim + Vec2f(-0.8f * t, 0.3f * t));
  for (size_t i = bowl.size(); i-- > 0;) {
    if (bowl[i].x() < 0.3f * r) continue;
    const Vec2f before = bowl[i > 0 ? i - 1 : 0], after = bowl[std::min(i + 1, bowl.size() - 1)];
    const Vec2f along = (after - before).normalized();
    profile.push_back(bowl[i] + t * Vec2f(-along.y(), along.x()));
  }
  profile.emplace_back(0, stem + 0.006f);
  b.Add(Lathe(profile, {.segments = 56}), GlassSlot("body"));
  return b.Finish();
}

// A pot's lid by itself.
struct LidParams {
  float radius_m = 0.11f;
  float dome = 0.2f;  // Height in radii.
  bool knob = true;   // Else a bow handle.
  uint64_t seed = 0;
};

Asset MakeLid(const LidParams& p) {
  const float r = p.radius_m, dome = p.dome;
  AssetBuilder b(p.seed);
  const Path2 wall = Spline(Path2{{0.93f * r, 0},
                                  {0.935f * r, 0.006f},
                                  {r, 0.007f},
                                  {r, 0.01f},
                                  {0.95f * r, 0.014f},
                                  {0.7f * r, 0.7f * dome * r + 0.012f},
                                  {0.35f * r, 0.95f * dome * r + 0.012f},
                                  {0.01f * r, dome * r + 0.012f}},
                            5);
  Path2 profile = wall;
  // Hollow below.
  Path2 hollow;
  for (const Vec2f& q : wall) {
    if (q.y() > 0.015f && q.x() > 0.003f) hollow.emplace_back(q.x() - 0.001f, q.y() - 0.003f);
  }
  Path2 closed{{0, hollow.back().y()}};
  for (size_t i = hollow.size(); i-- > 0;) closed.push_back(hollow[i]);
  closed.emplace_back(0.9f * r, 0.008f);
  closed.emplace_back(0.9f * r, 0.0f);
  closed.insert(closed.end(), profile.begin(), profile.end());
  const MaterialSlot body = Slot("body", {"metal", "glass", "ceramic"}),
                     knob = Slot("knob", {"metal", "plastic", "wood"});
  b.Add(Lathe(closed, {.segments = 64}), body);
  const float z = dome * r + 0.0105f;
  if (p.knob) {
    b.Add(Lathe(Spline(Path2{{0.009f, 0},
                             {0.008f, 0.008f},
                             {0.019f, 0.017f},
                             {0.021f, 0.025f},
                             {0.012f, 0.031f},
                             {0.001f, 0.032f}},
                       4))
              .Moved(0, 0, z),
          knob);
  } else {
    b.Add(Tube(Filleted(Path3{{-0.04f, 0, z - 0.004f},
                              {-0.034f, 0, z + 0.03f},
                              {0.034f, 0, z + 0.03f},
                              {0.04f, 0, z - 0.004f}},
                        0.018f, 6),
               0.005f, 0, 14),
          knob);
  }
  return b.Finish();
}

}  // namespace

Asset SampleBowl(Rng& rng) {
  BowlParams p{.radius_m = Draw(rng, 0.065, 0.16)};
  p.height_m = p.radius_m * Draw(rng, 0.5, 0.9);
  p.form = rng.UniformInt(0, 2);
  p.scallops = rng.Bernoulli(0.25) ? rng.UniformInt(8, 14) : 0;
  p.seed = rng.Seed();
  return MakeBowl(p);
}

Asset SamplePlate(Rng& rng) {
  return MakePlate({.radius_m = Draw(rng, 0.085, 0.15),
                    .height_m = Draw(rng, 0.016, 0.03),
                    .coupe = rng.Bernoulli(0.4),
                    .square = rng.Bernoulli(0.15),
                    .seed = rng.Seed()});
}

Asset SamplePot(Rng& rng) {
  PotParams p{.radius_m = Draw(rng, 0.09, 0.15)};
  p.height_m = p.radius_m * Draw(rng, 0.75, 1.35);
  p.lid = rng.Bernoulli(0.5);
  p.seed = rng.Seed();
  return MakePot(p);
}

Asset SamplePan(Rng& rng) {
  PotParams p{.radius_m = Draw(rng, 0.09, 0.16), .pan = true};
  p.height_m = p.radius_m * Draw(rng, 0.3, 0.55);
  p.seed = rng.Seed();
  return MakePot(p);
}

Asset SampleJar(Rng& rng) {
  JarParams p{.radius_m = Draw(rng, 0.035, 0.06)};
  p.height_m = p.radius_m * Draw(rng, 2.0, 3.4);
  p.square = rng.Bernoulli(0.35);
  p.closure = DrawEnum<JarClosure>(rng, static_cast<int>(JarClosure::kCount));
  p.filled = Draw(rng, 0.35, 0.75);
  p.seed = rng.Seed();
  return MakeJar(p);
}

Asset SampleWineglass(Rng& rng) {
  WineglassParams p{.height_m = Draw(rng, 0.15, 0.23)};
  p.radius_m = p.height_m * Draw(rng, 0.17, 0.23);
  p.form = rng.UniformInt(0, 2);
  p.seed = rng.Seed();
  return MakeWineglass(p);
}

Asset SampleLid(Rng& rng) {
  return MakeLid({.radius_m = Draw(rng, 0.08, 0.15),
                  .dome = Draw(rng, 0.13, 0.3),
                  .knob = rng.Bernoulli(0.5),
                  .seed = rng.Seed()});
}

}  // namespace parallax
