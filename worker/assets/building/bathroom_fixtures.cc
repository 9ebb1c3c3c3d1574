// Sanitary ware: taps, wash basins, kitchen sinks, bathtubs.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/building/basin.h"
#include "worker/assets/kernel/subdivide.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

// Radius factor that turns a circle into a superellipse.
std::function<float(float, float)> Squarish(float exponent) {
  return [exponent](float theta, float) {
    const float c = std::pow(std::fabs(std::cos(theta)), exponent);
    const float s = std::pow(std::fabs(std::sin(theta)), exponent);
    return std::pow(c + s, -1.0f / exponent);
  };
}

// A turning handle that stands along +z.
Shape TapHandle(bool cross, float r) {
  Shape out = Cone(1.5f * r, 1.15f * r, 0.022f, 0.002f, 22);
  if (cross) {
    for (int i = 0; i < 2; ++i) {
      const float a = 0.5f * kPi * static_cast<float>(i);
      out.Add(Tube({Vec3f(-0.028f, 0, 0.032f), Vec3f(0.028f, 0, 0.032f)}, 0.0045f, 0.004f, 12)
                  .TurnedZ(a));
    }
    out.Add(Cylinder(0.75f * r, 0.024f, 0.003f, 18).Moved(0, 0, 0.018f));
  } else {
    out.Add(Cylinder(1.1f * r, 0.012f, 0.004f, 20).Moved(0, 0, 0.021f));
    out.Add(Tube({Vec3f(0, 0, 0.029f), Vec3f(0, 0.02f, 0.032f), Vec3f(0, 0.058f, 0.042f)}, 0.0042f,
                 0.004f, 12));
  }
  return out;
}

// A tap of square blocks with a lever on top.
void AddBlockTap(const std::function<void(const Shape&)>& add, const TapParams& p) {
  const float r = p.pipe_m, h = p.height_m, reach = p.reach_m;
  add(Board({-1.6f * r, -1.6f * r, 0}, {1.6f * r, 1.6f * r, 0.75f * h}, 0.003f));
  add(Board({-1.5f * r, -1.5f * r, 0.6f * h}, {1.5f * r, reach, 0.6f * h + 1.6f * r}, 0.003f));
  add(Cylinder(0.7f * r, 0.012f, 0.001f, 16).Moved(0, reach - 1.8f * r, 0.6f * h - 0.011f));
  add(Board({-0.9f * r, -1.4f * r, 0.75f * h + 0.003f}, {0.9f * r, 3.4f * r, 0.75f * h + 0.012f},
            0.003f)
          .TurnedX(0.0f));
  add(Cylinder(0.6f * r, 0.006f, 0.001f, 14).Moved(0, 0, 0.75f * h - 0.001f));
}

// The way of the water: low and forward, or up, over in a half circle and down.
Path3 SpoutPath(const TapParams& p) {
  const float h = p.height_m, reach = p.reach_m;
  if (p.style == TapStyle::kLow) {
    return Spline(Path3{{0, 0, 0.004f},
                        {0, 0.0f, 0.35f * h},
                        {0, 0.12f * reach, 0.72f * h},
                        {0, 0.55f * reach, h},
                        {0, 0.9f * reach, 0.86f * h},
                        {0, reach, 0.68f * h}},
                  7);
  }
  const float bow = 0.5f * reach, top = std::max(h - bow, 0.3f * h);
  Path3 path{{0, 0, 0.004f}, {0, 0, 0.5f * top}};
  for (const Vec2f& q : Arc({bow, top}, bow, h - top, kPi, 0.0f, 20))
    path.emplace_back(0, q.x(), q.y());
  path.emplace_back(0, reach, top - 0.18f * h);
  return path;
}

// A tube on a flange, with a sleeve at its end.
void AddSpout(const std::function<void(const Shape&)>& add, const TapParams& p) {
  const float r = p.pipe_m;
  add(Cone(2.2f * r, 1.7f * r, 0.012f, 0.003f, 28));
  const Path3 path = SpoutPath(p);
  SweepOptions options{.end_round_m = 0.002f};
  if (p.style == TapStyle::kLow)
    options.scale = [](float t) { return Vec2f(1.45f - 0.6f * t, 1.45f - 0.6f * t); };
  add(Sweep(path, EllipseSection(2 * r, 2 * r, 22), options));
  const Vec3f tip = path.back();
  const Vec3f along = (path.back() - path[path.size() - 2]).normalized();
  add(AlongZ(Cylinder(1.18f * r, 0.014f, 0.002f, 22), tip - 0.01f * along, tip + 0.01f * along));
}

// Two handles beside the spout; a bridge joins them above the basin.
void AddTwoHandles(const std::function<void(const Shape&)>& add, const TapParams& p) {
  const float r = p.pipe_m, gap = p.style == TapStyle::kBridge ? 0.09f : 0.075f;
  for (const float s : {-1.0f, 1.0f}) {
    add(Cone(2.0f * r, 1.5f * r, 0.01f, 0.002f, 24).Moved(s * gap, 0, 0));
    add(Cylinder(1.2f * r, 0.045f, 0.002f, 22).Moved(s * gap, 0, 0.006f));
    add(TapHandle(p.cross_handles, r).Moved(s * gap, 0, 0.048f));
  }
  if (p.style == TapStyle::kBridge)
    add(Tube({Vec3f(-gap, 0, 0.035f), Vec3f(gap, 0, 0.035f)}, 0.8f * r, 0.001f, 16));
}

// One lever on the side of the body.
void AddLever(const std::function<void(const Shape&)>& add, const TapParams& p) {
  const float r = p.pipe_m, h = p.height_m, z = 0.28f * h;
  add(Cylinder(1.5f * r, 0.3f * h, 0.003f, 26).Moved(0, 0, 0.008f));
  add(AlongZ(Cylinder(0.95f * r, 0.03f, 0.003f, 18), {0, 0, z}, {1, 0, z}).Moved(0.5f * r, 0, 0));
  add(Tube({Vec3f(0.5f * r + 0.024f, 0, z), Vec3f(0.5f * r + 0.03f, 0, z + 0.02f),
            Vec3f(0.5f * r + 0.045f, 0, z + 0.07f)},
           0.0045f, 0.0043f, 12));
}

Asset MakeTap(const TapParams& p) {
  AssetBuilder b(p.seed);
  AddTap(b, p, Vec3f::Zero());
  return b.Finish();
}

TapParams DrawTap(Rng& rng, double height_low, double height_high) {
  TapParams p{.style = DrawEnum<TapStyle>(rng, static_cast<int>(TapStyle::kCount))};
  p.height_m = Draw(rng, height_low, height_high) *
               (p.style == TapStyle::kLow || p.style == TapStyle::kBlock ? 0.6f : 1.0f);
  p.reach_m = Draw(rng, 0.11, 0.17);
  p.pipe_m = Draw(rng, 0.0095, 0.0135);
  p.two_handles =
      p.style == TapStyle::kBridge || (p.style != TapStyle::kBlock && rng.Bernoulli(0.3));
  p.cross_handles = rng.Bernoulli(0.5);
  p.seed = rng.Seed();
  return p;
}

Asset SampleTap(Rng& rng) { return MakeTap(DrawTap(rng, 0.24, 0.36)); }

// Height at which the bowl of a bathroom's sink begins, and the middle of the bowl from the wall.
constexpr float kBowlLedge = 0.07f;

enum class BasinMount { kPedestal, kVanity, kCount };

// A wash basin with its pedestal or vanity, and its tap.
struct BathroomSinkParams {
  BasinMount mount = BasinMount::kPedestal;
  float width_m = 0.55f;
  float depth_m = 0.44f;
  float basin_m = 0.15f;    // Its height.
  float squareness = 2.6f;  // 2 an ellipse, larger squarer.
  TapParams tap;
  uint64_t seed = 0;
};

float BowlFoot(const BathroomSinkParams& p) {
  return (p.mount == BasinMount::kPedestal ? 0.84f : 0.85f + p.basin_m) - p.basin_m;
}

// The bowl's outline drawn in by a share; a pedestal's rim runs back to the wall as a ledge that
// carries the tap.
Shape BathroomBowl(const BathroomSinkParams& p) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.basin_m, foot = BowlFoot(p);
  const bool pedestal = p.mount == BasinMount::kPedestal;
  const auto level = [&](float share, float inset, float z, bool outside, float sharpness = 0) {
    const float x = share * w - inset, y = share * d - inset;
    BasinLevel l{{-x, kBowlLedge - y}, {x, kBowlLedge + y}, foot + z, p.squareness, sharpness};
    if (pedestal && outside) l.low.y() = Lerp(-0.1f, -d - 0.02f, Smooth01(z / h));
    if (pedestal && !outside) l.low.y() = std::max(l.low.y(), -d + 0.14f);
    return l;
  };
  return Basin({level(0.4f, 0, 0, true), level(0.5f, 0, 0, true, 1),
                level(0.74f, 0, 0.3f * h, true), level(0.95f, 0, 0.72f * h, true),
                level(1, 0, 0.94f * h, true), level(1, 0.003f, h, true), level(1, 0.014f, h, false),
                level(0.98f, 0.018f, 0.9f * h, false), level(0.86f, 0.018f, 0.5f * h, false),
                level(0.6f, 0.018f, 0.028f, false), level(0.34f, 0, 0.026f, false),
                level(0.2f, 0, 0.026f, false)});
}

// A turned column carries the bowl.
void AddBasinColumn(AssetBuilder& b, const BathroomSinkParams& p, const MaterialSlot& ceramic) {
  const float r = 0.1f, foot = BowlFoot(p);
  const Path2 column = Spline(Path2{{1.25f * r, 0},
                                    {1.22f * r, 0.03f},
                                    {0.95f * r, 0.1f},
                                    {0.78f * r, 0.3f},
                                    {0.85f * r, 0.52f},
                                    {1.15f * r, foot + 0.02f},
                                    {1.3f * r, foot + 0.06f}},
                              6);
  b.Add(Lathe(column, {.modulate = Squarish(p.squareness)}).Moved(0, 0.5f * kBowlLedge, 0),
        ceramic);
}

// A cabinet with a stone top under the bowl.
void AddVanity(AssetBuilder& b, const BathroomSinkParams& p) {
  const MaterialSlot wood = WoodSlot("cabinet");
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m;
  const float cw = w + 0.14f, back = -d - 0.05f, front = d + kBowlLedge + 0.02f, top = BowlFoot(p);
  b.Add(Board({-cw, back, 0.1f}, {cw, front, top - 0.03f}, 0.002f), wood);
  b.Add(Board({-cw + 0.02f, back + 0.01f, 0}, {cw - 0.02f, front - 0.05f, 0.11f}, 0.001f), wood);
  b.Add(Board({-cw - 0.012f, back, top - 0.03f}, {cw + 0.012f, front + 0.012f, top}, 0.004f),
        Slot("top", {"stone", "wood"}));
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Front(FrontStyle::kShaker, cw - 0.006f, top - 0.145f, 0.018f, true)
              .Moved(s * 0.5f * cw, front - 0.0005f, 0.108f),
          wood);
    b.Add(Handle(HandleStyle::kKnob, 0.03f).Moved(s * 0.035f, front + 0.0175f, 0.7f * top),
          MetalSlot("handles"));
  }
  AddTap(b, p.tap, {0, back + 0.06f, top});
  b.Support({w + 0.01f, back + 0.02f}, {cw, front - 0.02f}, top);
}

Asset MakeBathroomSink(const BathroomSinkParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot ceramic = Slot("basin", {"SanitaryCeramic", "Marble", "GlazedCeramic"});
  b.Add(BathroomBowl(p), ceramic);
  AddDrain(b, {0, kBowlLedge, BowlFoot(p) + 0.0262f}, 0.024f);
  if (p.mount == BasinMount::kPedestal) {
    AddBasinColumn(b, p, ceramic);
    AddTap(b, p.tap, {0, -0.5f * p.depth_m - 0.02f + 0.1f, 0.84f - 0.005f});
  } else {
    AddVanity(b, p);
  }
  return b.Finish();
}

Asset SampleBathroomSink(Rng& rng) {
  BathroomSinkParams p;
  p.mount = DrawEnum<BasinMount>(rng, static_cast<int>(BasinMount::kCount));
  p.width_m = Draw(rng, 0.42, 0.62);
  p.depth_m = p.width_m * Draw(rng, 0.7, 0.95);
  p.basin_m = Draw(rng, 0.12, 0.17);
  p.squareness = Draw(rng, 2.0, 5.0);
  p.tap = DrawTap(rng, 0.18, 0.3);
  p.seed = rng.Seed();
  return MakeBathroomSink(p);
}

// A kitchen sink that is set into a worktop, with its tap.
struct SinkParams {
  float width_m = 0.6f;
  float depth_m = 0.46f;
  float basin_m = 0.2f;
  bool two_basins = false;
  bool drainer = false;  // Ribs beside the basin.
  TapParams tap;
  uint64_t seed = 0;
};

Asset MakeSink(const SinkParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot metal = Slot("sink", {"metal", "ceramic", "stone"});
  const float d = 0.5f * p.depth_m, h = p.basin_m, t = 0.004f, rim = 0.03f, ledge = 0.08f;
  const int basins = p.two_basins ? 2 : 1;
  const float each = p.width_m;
  const float left = -0.5f * each * static_cast<float>(basins);
  for (int i = 0; i < basins; ++i) {
    const float x0 = left + each * static_cast<float>(i), x1 = x0 + each;
    // A bowl pressed out of a sheet whose flange lies on the worktop, wider behind for the tap.
    const auto bowl = [&](float inset, float z, float sharpness = 0) {
      const float in = rim + inset;
      return BasinLevel{{x0 + in, -d + in}, {x1 - in, d - in}, z, 7, sharpness};
    };
    const auto flange = [&](float z, float sharpness) {
      return BasinLevel{{x0, -d - ledge}, {x1, d + 0.012f}, z, 0, sharpness, 2};
    };
    b.Add(Basin({bowl(0.1f, 0), bowl(0.04f, 0, 1), bowl(0.012f - t, 0.06f), bowl(-t, h - 0.01f),
                 flange(h - 0.003f, 3), flange(h + 0.002f, 2), bowl(-0.006f, h + 0.002f),
                 bowl(0, h - 0.004f), bowl(0.012f, 0.06f + t), bowl(0.04f, t),
                 bowl(0.1f, t - 0.001f), bowl(0.13f, t - 0.001f)}),
          metal);
    AddDrain(b, {0.5f * (x0 + x1), 0, t}, 0.042f);
  }
  if (p.drainer) {
    const float x0 = -left, x1 = -left + 0.8f * each;
    b.Add(Board({x0 - 0.002f, -d - ledge, h - 0.012f}, {x1, d + 0.012f, h + 0.001f}, 0.002f),
          metal);
    for (int i = 1; i < 8; ++i) {
      const float x = Lerp(x0, x1, static_cast<float>(i) / 8.0f);
      b.Add(Tube({Vec3f(x, -d + 0.02f, h + 0.0005f), Vec3f(x, d - 0.02f, h + 0.0005f)}, 0.0035f,
                 0.003f, 8),
            metal);
    }
  }
  AddTap(b, p.tap, {0, -d - 0.5f * ledge + 0.01f, h + 0.001f});
  return b.Finish();
}

Asset SampleSink(Rng& rng) {
  SinkParams p{.two_basins = rng.Bernoulli(0.3)};
  p.width_m = p.two_basins ? Draw(rng, 0.36, 0.44) : Draw(rng, 0.42, 0.7);
  p.depth_m = Draw(rng, 0.38, 0.48);
  p.basin_m = Draw(rng, 0.16, 0.24);
  p.drainer = !p.two_basins && rng.Bernoulli(0.35);
  p.tap = DrawTap(rng, 0.26, 0.4);
  p.seed = rng.Seed();
  return MakeSink(p);
}

}  // namespace

MaterialSlot ChromeSlot() { return Slot("fittings", {"metal"}); }

Shape Basin(const std::vector<BasinLevel>& levels) {
  std::vector<CageRing> rings;
  for (const BasinLevel& l : levels)
    rings.push_back({EightPoints(l.low, l.high, l.z, l.exponent), l.sharpness, l.corners});
  return Subdivided(Loft(rings), 3).Retextured();
}

void AddDrain(AssetBuilder& b, const Vec3f& at, float radius) {
  b.Add(LatheRing(Path2{{0.55f * radius, -0.002f},
                        {radius, -0.002f},
                        {radius, 0.0008f},
                        {0.9f * radius, 0.002f},
                        {0.55f * radius, 0.001f}},
                  28)
            .Moved(at),
        ChromeSlot());
  b.Add(Cylinder(0.5f * radius, 0.003f, 0.001f, 20).Moved(at - Vec3f(0, 0, 0.0025f)), ChromeSlot());
}

void AddTap(AssetBuilder& b, const TapParams& p, const Vec3f& at) {
  const auto add = [&](const Shape& shape) { b.Add(shape.Moved(at), ChromeSlot()); };
  if (p.style == TapStyle::kBlock) return AddBlockTap(add, p);
  AddSpout(add, p);
  p.two_handles ? AddTwoHandles(add, p) : AddLever(add, p);
}

void RegisterBathroom(std::vector<AssetClass>& classes) {
  classes.push_back({"BathroomSink", "bathroom", Placement::kFloorAgainstWall, true, 0.6f,
                     SampleBathroomSink, SizeRange({0.4f, 0.4f, 0.9f}, {1.0f, 0.85f, 1.4f})});
  classes.push_back({"Bathtub", "bathroom", Placement::kFloorAgainstWall, true, 0.6f, SampleBathtub,
                     SizeRange({1.4f, 0.65f, 0.5f}, {1.85f, 1.05f, 0.95f})});
  classes.push_back({"Sink", "bathroom", Placement::kOnTop, true, 0, SampleSink,
                     SizeRange({0.4f, 0.45f, 0.25f}, {1.35f, 0.75f, 0.75f})});
  classes.push_back({"Tap", "bathroom", Placement::kOnTop, true, 0, SampleTap,
                     SizeRange({0.02f, 0.1f, 0.1f}, {0.3f, 0.3f, 0.4f})});
}

}  // namespace parallax
