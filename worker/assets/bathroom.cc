#include "worker/assets/bathroom.h"

#include <algorithm>
#include <cmath>

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

MaterialSlot ChromeSlot() { return Slot("fittings", {"metal"}); }

// Radius factor that turns a circle into a superellipse.
std::function<float(float, float)> Squarish(float exponent) {
  return [exponent](float theta, float) {
    const float c = std::pow(std::fabs(std::cos(theta)), exponent);
    const float s = std::pow(std::fabs(std::sin(theta)), exponent);
    return std::pow(c + s, -1.0f / exponent);
  };
}

// A tub of any outline: `outer` is a profile of unit radius; scaled to half extents x and y.
Shape Tub(const Path2& outer, float thickness, float floor, float half_x, float half_y,
          float exponent) {
  LatheOptions options;
  options.segments = 72;
  options.modulate = Squarish(exponent);
  const float scale = 0.5f * (half_x + half_y);
  Path2 sized;
  for (const Vec2f& q : outer) sized.emplace_back(q.x() * scale, q.y());
  Shape tub = Lathe(VesselProfile(sized, thickness, floor), options);
  return tub.Scaled({half_x / scale, half_y / scale, 1.0f});
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

}  // namespace

void AddTap(AssetBuilder& b, const TapParams& p, const Vec3f& at) {
  const MaterialSlot metal = ChromeSlot();
  const float r = p.pipe_m, h = p.height_m, reach = p.reach_m;
  const auto add = [&](const Shape& shape) { b.Add(shape.Moved(at), metal); };
  if (p.style == TapStyle::kBlock) {
    add(Board({-1.6f * r, -1.6f * r, 0}, {1.6f * r, 1.6f * r, 0.75f * h}, 0.003f));
    add(Board({-1.5f * r, -1.5f * r, 0.6f * h}, {1.5f * r, reach, 0.6f * h + 1.6f * r}, 0.003f));
    add(Cylinder(0.7f * r, 0.012f, 0.001f, 16).Moved(0, reach - 1.8f * r, 0.6f * h - 0.011f));
    add(Board({-0.9f * r, -1.4f * r, 0.75f * h + 0.003f}, {0.9f * r, 3.4f * r, 0.75f * h + 0.012f},
              0.003f)
            .TurnedX(0.0f));
    add(Cylinder(0.6f * r, 0.006f, 0.001f, 14).Moved(0, 0, 0.75f * h - 0.001f));
    return;
  }
  add(Cone(2.2f * r, 1.7f * r, 0.012f, 0.003f, 28));
  Path3 path;
  if (p.style == TapStyle::kLow) {
    path = Spline(Path3{{0, 0, 0.004f},
                        {0, 0.0f, 0.35f * h},
                        {0, 0.12f * reach, 0.72f * h},
                        {0, 0.55f * reach, h},
                        {0, 0.9f * reach, 0.86f * h},
                        {0, reach, 0.68f * h}},
                  7);
  } else {
    // Up, over in a half circle, down.
    const float bow = 0.5f * reach, top = std::max(h - bow, 0.3f * h);
    path = {{0, 0, 0.004f}, {0, 0, 0.5f * top}};
    for (const Vec2f& q : Arc({bow, top}, bow, h - top, kPi, 0.0f, 20))
      path.emplace_back(0, q.x(), q.y());
    path.emplace_back(0, reach, top - 0.18f * h);
  }
  SweepOptions options;
  options.end_round_m = 0.002f;
  if (p.style == TapStyle::kLow)
    options.scale = [](float t) { return Vec2f(1.45f - 0.6f * t, 1.45f - 0.6f * t); };
  add(Sweep(path, EllipseSection(2 * r, 2 * r, 22), options));
  const Vec3f tip = path.back();
  const Vec3f along = (path.back() - path[path.size() - 2]).normalized();
  add(AlongZ(Cylinder(1.18f * r, 0.014f, 0.002f, 22), tip - 0.01f * along, tip + 0.01f * along));
  if (p.two_handles) {
    const float gap = p.style == TapStyle::kBridge ? 0.09f : 0.075f;
    for (const float s : {-1.0f, 1.0f}) {
      add(Cone(2.0f * r, 1.5f * r, 0.01f, 0.002f, 24).Moved(s * gap, 0, 0));
      add(Cylinder(1.2f * r, 0.045f, 0.002f, 22).Moved(s * gap, 0, 0.006f));
      add(TapHandle(p.cross_handles, r).Moved(s * gap, 0, 0.048f));
    }
    if (p.style == TapStyle::kBridge)
      add(Tube({Vec3f(-gap, 0, 0.035f), Vec3f(gap, 0, 0.035f)}, 0.8f * r, 0.001f, 16));
  } else {
    // One lever on the side of the body.
    const float z = 0.28f * h;
    add(Cylinder(1.5f * r, 0.3f * h, 0.003f, 26).Moved(0, 0, 0.008f));
    add(AlongZ(Cylinder(0.95f * r, 0.03f, 0.003f, 18), {0, 0, z}, {1, 0, z}).Moved(0.5f * r, 0, 0));
    add(Tube({Vec3f(0.5f * r + 0.024f, 0, z), Vec3f(0.5f * r + 0.03f, 0, z + 0.02f),
              Vec3f(0.5f * r + 0.045f, 0, z + 0.07f)},
             0.0045f, 0.0043f, 12));
  }
}

Asset MakeTap(const TapParams& p) {
  AssetBuilder b(p.seed);
  AddTap(b, p, Vec3f::Zero());
  return b.Finish();
}

namespace {

TapParams DrawTap(Rng& rng, double height_low, double height_high) {
  TapParams p;
  p.style = DrawEnum<TapStyle>(rng, static_cast<int>(TapStyle::kCount));
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

}  // namespace

Asset SampleTap(Rng& rng) { return MakeTap(DrawTap(rng, 0.24, 0.36)); }

Asset MakeBathroomSink(const BathroomSinkParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot ceramic = Slot("basin", {"SanitaryCeramic", "stone", "GlazedCeramic"});
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, h = p.basin_m;
  const float rim_z = p.mount == BasinMount::kPedestal ? 0.84f : 0.85f + h;
  const float foot = rim_z - h;
  const Path2 outer = Spline(
      Path2{{0.34f, 0.0f}, {0.48f, 0.004f}, {0.74f, 0.28f * h}, {0.92f, 0.68f * h}, {1.0f, h}}, 6);
  // The bowl stands a little forward of the ledge that carries the tap.
  const float ledge = 0.07f;
  b.Add(Tub(outer, 0.016f, 0.03f, w, d, p.squareness).Moved(0, ledge, foot), ceramic);
  AddDrain(b, {0, ledge, foot + 0.031f}, 0.024f);
  if (p.mount == BasinMount::kPedestal) {
    // The ledge joins the bowl to the wall; a turned column carries both.
    const float back = -d - 0.02f;
    Shape shelf = Extrude(RectSection(1.72f * w, 0.2f, 0.03f, 4), 0.5f * h, 0.012f);
    b.Add(shelf.Moved(0, back + 0.1f, rim_z - 0.5f * h - 0.004f), ceramic);
    const float r = 0.1f;
    const Path2 column = Spline(Path2{{1.25f * r, 0},
                                      {1.22f * r, 0.03f},
                                      {0.95f * r, 0.1f},
                                      {0.78f * r, 0.3f},
                                      {0.85f * r, 0.52f},
                                      {1.15f * r, foot + 0.02f},
                                      {1.3f * r, foot + 0.06f}},
                                6);
    LatheOptions options;
    options.modulate = Squarish(p.squareness);
    b.Add(Lathe(column, options).Moved(0, 0.5f * ledge, 0), ceramic);
    AddTap(b, p.tap, {0, back + 0.1f, rim_z - 0.005f});
    return b.Finish();
  }
  // A cabinet with a stone top under the bowl.
  const MaterialSlot wood = WoodSlot("cabinet");
  const float cw = w + 0.14f, back = -d - 0.05f, front = d + ledge + 0.02f, top = foot;
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

Asset MakeSink(const SinkParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot metal = Slot("sink", {"metal", "ceramic", "stone"});
  const float d = 0.5f * p.depth_m, h = p.basin_m, t = 0.006f, rim = 0.03f, ledge = 0.08f;
  const int basins = p.two_basins ? 2 : 1;
  const float each = p.width_m;
  const float left = -0.5f * each * static_cast<float>(basins);
  const Path2 outer{{0.3f, 0}, {0.8f, 0}, {0.93f, 0.008f}, {0.965f, 0.035f}, {1.0f, h}};
  for (int i = 0; i < basins; ++i) {
    const float x = left + each * (static_cast<float>(i) + 0.5f);
    b.Add(Tub(outer, t, t, 0.5f * each - 0.5f * rim, d - 0.5f * rim, 9.0f).Moved(x, 0, 0), metal);
    AddDrain(b, {x, 0, t + 0.001f}, 0.042f);
    // The flange around it, four bars that overlap the bowl's rim.
    const float z0 = h - 0.004f, z1 = h + 0.002f;
    const float x0 = x - 0.5f * each, x1 = x + 0.5f * each;
    b.Add(Board({x0, d - rim, z0}, {x1, d + 0.012f, z1}, 0.0015f), metal);
    b.Add(Board({x0, -d - ledge, z0}, {x1, -d + rim, z1}, 0.0015f), metal);
    b.Add(Board({x0, -d + rim - 0.002f, z0}, {x0 + rim, d - rim + 0.002f, z1 - 0.0002f}, 0.0015f),
          metal);
    b.Add(Board({x1 - rim, -d + rim - 0.002f, z0}, {x1, d - rim + 0.002f, z1 - 0.0002f}, 0.0015f),
          metal);
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
  SinkParams p;
  p.two_basins = rng.Bernoulli(0.3);
  p.width_m = p.two_basins ? Draw(rng, 0.36, 0.44) : Draw(rng, 0.42, 0.7);
  p.depth_m = Draw(rng, 0.38, 0.48);
  p.basin_m = Draw(rng, 0.16, 0.24);
  p.drainer = !p.two_basins && rng.Bernoulli(0.35);
  p.tap = DrawTap(rng, 0.26, 0.4);
  p.seed = rng.Seed();
  return MakeSink(p);
}

Asset MakeBathtub(const BathtubParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot ceramic = Slot("tub", {"SanitaryCeramic", "stone", "GlazedCeramic"});
  const float l = 0.5f * p.length_m, w = 0.5f * p.width_m;
  const bool claw = p.style == BathtubStyle::kClawFoot, built = p.style == BathtubStyle::kBuiltIn;
  const float foot = claw ? 0.12f : built ? 0.05f : 0.0f;
  const float h = p.height_m - foot, low = 1.0f - p.slope;
  const float inset = built ? 0.07f : 0.0f;
  const Path2 outer = Spline(Path2{{0.45f * low, 0.0f},
                                   {0.86f * low, 0.004f},
                                   {0.98f * low, 0.03f},
                                   {Lerp(low, 1.0f, 0.4f), 0.45f * h},
                                   {0.97f, 0.9f * h},
                                   {1.0f, h}},
                             6);
  b.Add(Tub(outer, 0.028f, 0.04f, l - inset, w - inset, p.squareness).Moved(0, 0, foot), ceramic);
  AddDrain(b, {0.62f * (l - inset) * low, 0, foot + 0.041f}, 0.03f);
  if (built) {
    // A deck around the rim on an apron.
    const float z = p.height_m;
    b.Add(Board({-l, w - 0.022f, 0}, {l, w, z - 0.03f}, 0.004f), ceramic);
    b.Add(Board({-l, -w, 0}, {l, -w + 0.022f, z - 0.03f}, 0.004f), ceramic);
    b.Add(Board({-l, -w + 0.021f, 0}, {-l + 0.022f, w - 0.021f, z - 0.03f}, 0.004f), ceramic);
    b.Add(Board({l - 0.022f, -w + 0.021f, 0}, {l, w - 0.021f, z - 0.03f}, 0.004f), ceramic);
    // The deck: a frame whose inner edge follows the tub's outline.
    Shape deck;
    const int n = 96;
    const auto inner_radius = Squarish(p.squareness);
    const auto outer_radius = Squarish(24.0f);
    const float tops[2] = {z - 0.034f, z - 0.002f};
    for (int i = 0; i < n; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / n;
      const float ri = inner_radius(a, 0), ro = outer_radius(a, 0);
      const Vec2f dir(std::cos(a), std::sin(a));
      for (const float top : tops) {
        deck.AddPoint(
            {(l - inset - 0.014f) * ri * dir.x(), (w - inset - 0.014f) * ri * dir.y(), top});
        deck.AddPoint({(l + 0.004f) * ro * dir.x(), (w + 0.004f) * ro * dir.y(), top});
      }
    }
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t q = 4 * i, s = 4 * ((i + 1) % n);
      // Points of a spoke: inner low, outer low, inner high, outer high.
      deck.AddQuad(q + 2, q + 3, s + 3, s + 2);
      deck.AddQuad(q + 1, q, s, s + 1);
      deck.AddQuad(q + 3, q + 1, s + 1, s + 3);
      deck.AddQuad(q, q + 2, s + 2, s);
    }
    b.Add(deck, ceramic);
  } else {
    // A rolled rim.
    Path3 rim;
    const auto radius = Squarish(p.squareness);
    for (int i = 0; i < 72; ++i) {
      const float a = 2 * kPi * static_cast<float>(i) / 72.0f;
      rim.emplace_back((l - 0.006f) * radius(a, 0) * std::cos(a),
                       (w - 0.006f) * radius(a, 0) * std::sin(a), p.height_m - 0.012f);
    }
    b.Add(Ring(rim, 0.019f, 12), ceramic);
  }
  if (claw) {
    const MaterialSlot metal = Slot("feet", {"metal"});
    for (const float sx : {-1.0f, 1.0f}) {
      for (const float sy : {-1.0f, 1.0f}) {
        const Vec3f out(sx * 0.62f * l * low, sy * 0.62f * w * low, 0);
        b.Add(Ball(0.03f, 20).Moved(out + Vec3f(sx * 0.03f, sy * 0.03f, 0.03f)), metal);
        b.Add(Sweep(Spline(Path3{out + Vec3f(sx * 0.03f, sy * 0.03f, 0.035f),
                                 out + Vec3f(sx * 0.055f, sy * 0.055f, 0.08f),
                                 out + Vec3f(sx * 0.03f, sy * 0.03f, 0.13f),
                                 out + Vec3f(0, 0, 0.165f)},
                           5),
                    EllipseSection(0.05f, 0.04f, 14), {}),
              metal);
      }
    }
  }
  if (p.tap) {
    TapParams tap;
    tap.style = TapStyle::kBridge;
    tap.height_m = 0.16f;
    tap.reach_m = 0.15f;
    tap.pipe_m = 0.012f;
    tap.two_handles = true;
    tap.cross_handles = true;
    if (built) {
      AddTap(b, tap, {0, -w + 0.045f, p.height_m - 0.003f});
    } else {
      // On two risers behind the tub.
      const float y = -w - 0.07f;
      for (const float s : {-1.0f, 1.0f}) {
        b.Add(Rod({s * 0.09f, y, 0}, {s * 0.09f, y, p.height_m + 0.05f}, 0.012f, 0.012f),
              ChromeSlot());
        b.Add(Cone(0.03f, 0.02f, 0.01f, 0.002f).Moved(s * 0.09f, y, 0), ChromeSlot());
      }
      tap.reach_m = 0.2f;
      AddTap(b, tap, {0, y, p.height_m + 0.045f});
    }
  }
  return b.Finish();
}

Asset SampleBathtub(Rng& rng) {
  BathtubParams p;
  p.style = DrawEnum<BathtubStyle>(rng, static_cast<int>(BathtubStyle::kCount));
  p.length_m = Draw(rng, 1.45, 1.8);
  p.width_m = Draw(rng, 0.7, 0.85);
  p.height_m = Draw(rng, 0.52, 0.64);
  p.squareness = p.style == BathtubStyle::kBuiltIn ? Draw(rng, 3.0, 6.0) : Draw(rng, 2.2, 3.6);
  p.slope = Draw(rng, 0.12, 0.32);
  p.tap = rng.Bernoulli(0.7);
  p.seed = rng.Seed();
  return MakeBathtub(p);
}

void RegisterBathroom(std::vector<AssetClass>& classes) {
  classes.push_back(
      {"BathroomSink", "bathroom", Placement::kFloorAgainstWall, true, 0.6f, SampleBathroomSink});
  classes.push_back(
      {"Bathtub", "bathroom", Placement::kFloorAgainstWall, true, 0.6f, SampleBathtub});
  classes.push_back({"Sink", "bathroom", Placement::kOnTop, true, 0, SampleSink});
  classes.push_back({"Tap", "bathroom", Placement::kOnTop, true, 0, SampleTap});
}

}  // namespace parallax
