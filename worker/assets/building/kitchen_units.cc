// Fitted kitchens: islands and runs along a wall.
#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/building/basin.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kBoard = 0.019f;
constexpr float kPlinth = 0.1f;

MaterialSlot FrontSlot() { return WoodSlot("fronts"); }
MaterialSlot CarcassSlot() { return WoodSlot("carcass"); }
MaterialSlot WorktopSlot() { return Slot("worktop", {"stone", "wood"}); }
MaterialSlot HandleSlot() { return MetalSlot("handles"); }

// A kitchen island, or a run of units along a wall.
struct KitchenParams {
  float width_m = 2.4f;
  float depth_m = 0.62f;
  float height_m = 0.9f;
  int columns = 4;
  FrontStyle fronts = FrontStyle::kShaker;
  HandleStyle handles = HandleStyle::kBar;
  int sink_column = 1;   // Where the basin is let in; -1 = none.
  float overhang_m = 0;  // How far the worktop juts out at the back: an island's bar.
  // Kitchen runs only:
  float upper_low_m = 1.42f, upper_high_m = 2.15f;
  int hood_column = 3;  // An extractor hood instead of a wall cabinet; -1 = none.
  int open_column = 0;  // Shelves instead of doors; -1 = none.
  uint64_t seed = 0;
};

// A front with its handle: a door (upright handle near `opens`) or, with opens = 0, a drawer.
void AddFront(AssetBuilder& b, const KitchenParams& p, float x, float y, float z, float width,
              float height, float opens, bool upper) {
  b.Add(Front(p.fronts, width, height, kBoard, opens != 0).Moved(x, y, z), FrontSlot());
  if (p.handles == HandleStyle::kNone) return;
  const bool long_handle = p.handles == HandleStyle::kBar || p.handles == HandleStyle::kBow;
  if (opens == 0) {
    const float surface =
        p.fronts == FrontStyle::kShaker && height > 0.12f ? 0.55f * kBoard : kBoard;
    b.Add(Handle(p.handles, std::min(0.16f, 0.4f * width))
              .Moved(x, y + surface - 0.0005f, z + 0.52f * height),
          HandleSlot());
    return;
  }
  Shape handle =
      Handle(long_handle ? p.handles : HandleStyle::kKnob, std::min(0.2f, 0.3f * height));
  if (long_handle) handle = handle.TurnedY(0.5f * kPi);
  b.Add(handle.Moved(x + opens * (0.5f * width - 0.032f), y + kBoard - 0.0005f,
                     z + (upper ? 0.18f : 0.8f) * height),
        HandleSlot());
}

// Base units from x = -width/2, backs at y = -depth/2: carcass, plinth, fronts. Below the worktop.
void AddBase(AssetBuilder& b, const KitchenParams& p, Rng& rng) {
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, top = p.height_m - 0.035f,
              front = d - kBoard;
  const float pitch = p.width_m / static_cast<float>(p.columns);
  for (int i = 0; i <= p.columns; ++i) {
    const float x = -w + pitch * static_cast<float>(i);
    const float half = i == 0 || i == p.columns ? kBoard : 0.5f * kBoard;
    const float x0 = i == 0 ? x : x - half, x1 = i == p.columns ? x : x + half;
    // Under a basin the sides stay; only the top rail is left out.
    b.Add(Board({x0, -d, kPlinth}, {x1, front, top}, 0.0015f), CarcassSlot());
  }
  b.Add(Board({-w + 0.002f, -d + 0.001f, kPlinth}, {w - 0.002f, front - 0.001f, kPlinth + kBoard},
              0.0015f),
        CarcassSlot());
  b.Add(Board({-w + 0.002f, -d, kPlinth + 0.002f}, {w - 0.002f, -d + 0.008f, top - 0.001f}, 0.001f),
        CarcassSlot());
  b.Add(Board({-w + 0.004f, -d + 0.02f, 0}, {w - 0.004f, front - 0.06f, kPlinth + 0.001f}, 0.001f),
        Slot("plinth", {"HousingPlastic", "BrushedMetal", "wood"}));
  const float z0 = kPlinth + 0.003f, z1 = top - 0.003f, width = pitch - 0.003f;
  for (int i = 0; i < p.columns; ++i) {
    const float x = -w + pitch * (static_cast<float>(i) + 0.5f);
    const int kind = i == p.sink_column ? 0 : rng.UniformInt(0, 3);
    if (kind == 1) {  // Three drawers.
      const float heights[3] = {0.42f, 0.35f, 0.23f};
      float z = z0;
      for (const float share : heights) {
        const float h = (z1 - z0) * share;
        AddFront(b, p, x, front, z + 0.0015f, width, h - 0.003f, 0, false);
        z += h;
      }
    } else if (kind == 2) {  // A drawer over a door.
      AddFront(b, p, x, front, z0, width, (z1 - z0) * 0.78f - 0.003f, i % 2 ? -1.0f : 1.0f, false);
      AddFront(b, p, x, front, z0 + (z1 - z0) * 0.78f, width, (z1 - z0) * 0.22f, 0, false);
    } else if (pitch > 0.55f) {  // A pair of doors.
      for (const float s : {-1.0f, 1.0f})
        AddFront(b, p, x + s * 0.25f * pitch, front, z0, 0.5f * pitch - 0.003f, z1 - z0, -s, false);
    } else {
      AddFront(b, p, x, front, z0, width, z1 - z0, i % 2 ? -1.0f : 1.0f, false);
    }
  }
}

// The worktop, with a basin let in where there is one.
void AddWorktop(AssetBuilder& b, const KitchenParams& p, float side_overhang) {
  const float w = 0.5f * p.width_m + side_overhang, d = 0.5f * p.depth_m, z0 = p.height_m - 0.036f,
              z1 = p.height_m;
  const float back = -d - p.overhang_m, front = d + 0.02f;
  const MaterialSlot slot = WorktopSlot();
  if (p.sink_column < 0) {
    b.Add(Board({-w, back, z0}, {w, front, z1}, 0.005f), slot);
    b.Support({-w + 0.03f, back + 0.03f}, {w - 0.03f, front - 0.03f}, z1);
    return;
  }
  const float pitch = p.width_m / static_cast<float>(p.columns);
  const float x = -0.5f * p.width_m + pitch * (static_cast<float>(p.sink_column) + 0.5f);
  const float half = std::min(0.5f * pitch - 0.03f, 0.36f), hole = 0.2f, mid = 0.03f;
  b.Add(Board({-w, back, z0}, {x - half, front, z1}, 0.005f), slot);
  b.Add(Board({x + half, back, z0}, {w, front, z1}, 0.005f), slot);
  b.Add(Board({x - half - 0.003f, mid + hole, z0 + 0.0005f},
              {x + half + 0.003f, front - 0.0005f, z1 - 0.0005f}, 0.005f),
        slot);
  b.Add(Board({x - half - 0.003f, back + 0.0005f, z0 + 0.0005f},
              {x + half + 0.003f, mid - hole, z1 - 0.0005f}, 0.005f),
        slot);
  // Basin: five walls of sheet, a flange over the cut.
  const MaterialSlot metal = Slot("sink", {"metal", "ceramic"});
  const float low = z1 - 0.19f, t = 0.008f;
  b.Add(Board({x - half, mid - hole, low}, {x + half, mid + hole, low + t}, 0.002f), metal);
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Board({x + s * (half - t), mid - hole, low + 0.001f},
                {x + s * half, mid + hole, z1 + 0.001f}, 0.002f),
          metal);
    b.Add(Board({x - half, mid + s * (hole - t), low + 0.0005f},
                {x + half, mid + s * hole, z1 + 0.0008f}, 0.002f),
          metal);
    b.Add(Board({x + s * (half - 0.5f * t), mid - hole - 0.012f, z1 - 0.001f},
                {x + s * (half + 0.014f), mid + hole + 0.012f, z1 + 0.0022f}, 0.001f),
          metal);
    b.Add(Board({x - half - 0.013f, mid + s * (hole - 0.5f * t), z1 - 0.001f},
                {x + half + 0.013f, mid + s * (hole + 0.014f), z1 + 0.002f}, 0.001f),
          metal);
  }
  b.Add(Cylinder(0.045f, 0.004f, 0.0015f, 28).Moved(x, mid, low + t - 0.002f), metal);
  TapParams tap{.style = static_cast<TapStyle>(p.seed % 4)};
  tap.two_handles = tap.style == TapStyle::kBridge;
  AddTap(b, tap, {x, mid - hole - 0.05f, z1});
  if (x - half - 0.03f > -w + 0.15f)
    b.Support({-w + 0.03f, back + 0.03f}, {x - half - 0.03f, front - 0.03f}, z1);
  if (w - 0.15f > x + half + 0.03f)
    b.Support({x + half + 0.03f, back + 0.03f}, {w - 0.03f, front - 0.03f}, z1);
}

void AddHood(AssetBuilder& b, float x, float width, float back, float low, float high) {
  const MaterialSlot metal = Slot("hood", {"metal", "paint"});
  const float h = 0.5f * width - 0.01f, deep = 0.44f;
  b.Add(Board({x - h, back, low}, {x + h, back + deep, low + 0.05f}, 0.004f), metal);
  // The canopy narrows to the flue.
  SweepOptions options{.up = Vec3f::UnitY(), .keep_up = true};
  const float flue = 0.13f;
  options.scale = [=](float t) {
    return Vec2f(Lerp(h, flue, t) / h, Lerp(0.5f * deep, flue, t) / (0.5f * deep));
  };
  b.Add(Sweep(Path3{{x, back + 0.5f * deep, low + 0.049f}, {x, back + flue + 0.002f, low + 0.24f}},
              RectSection(2 * h, deep, 0.004f, 1), options),
        metal);
  b.Add(Board({x - flue, back + 0.001f, low + 0.235f}, {x + flue, back + 2 * flue, high}, 0.003f),
        metal);
}

Asset MakeKitchenIsland(const KitchenParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "fronts");
  AddBase(b, p, rng);
  AddWorktop(b, p, 0.02f);
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m, top = p.height_m - 0.036f;
  // The back and the ends are panelled like the fronts.
  const float pitch = p.width_m / static_cast<float>(p.columns);
  for (int i = 0; i < p.columns; ++i) {
    b.Add(Front(p.fronts, pitch - 0.002f, top - kPlinth, 0.016f, true)
              .TurnedZ(kPi)
              .Moved(-w + pitch * (static_cast<float>(i) + 0.5f), -d + 0.001f, kPlinth),
          FrontSlot());
  }
  for (const float s : {-1.0f, 1.0f}) {
    b.Add(Front(p.fronts, p.depth_m - kBoard, top - kPlinth, 0.014f, true)
              .TurnedZ(-s * 0.5f * kPi)
              .Moved(s * (w - 0.001f), -0.5f * kBoard, kPlinth),
          FrontSlot());
  }
  if (p.overhang_m > 0.2f) {
    for (const float s : {-1.0f, 1.0f}) {
      b.Add(Bar({s * (w - 0.04f), -d - p.overhang_m + 0.06f, 0},
                {s * (w - 0.04f), -d - p.overhang_m + 0.06f, top + 0.002f}, {0.06f, 0.06f},
                {0.06f, 0.06f}, 0.004f, Vec3f::UnitY()),
            FrontSlot());
    }
  }
  return b.Finish();
}

// A wall cabinet's place: between x0 and x1, from the wall to the fronts' back.
struct WallUnit {
  float x0, x1, back, front;
};

// The carcass with two boards; those of an open one can carry things.
void AddWallCarcass(AssetBuilder& b, const KitchenParams& p, const WallUnit& u, bool open) {
  const float x0 = u.x0, x1 = u.x1, back = u.back, front = u.front, low = p.upper_low_m,
              high = p.upper_high_m;
  for (const float z : {low, high - kBoard})
    b.Add(Board({x0 + 0.001f, back, z}, {x1 - 0.001f, front, z + kBoard}, 0.0015f), CarcassSlot());
  b.Add(Board({x0, back, low - 0.0005f}, {x0 + kBoard, front - 0.0005f, high + 0.0005f}, 0.0015f),
        CarcassSlot());
  b.Add(Board({x1 - kBoard, back, low - 0.0005f}, {x1, front - 0.0005f, high + 0.0005f}, 0.0015f),
        CarcassSlot());
  b.Add(
      Board({x0 + 0.002f, back, low + 0.002f}, {x1 - 0.002f, back + 0.008f, high - 0.002f}, 0.001f),
      CarcassSlot());
  for (int k = 1; k < 3; ++k) {
    const float z = Lerp(low, high, static_cast<float>(k) / 3.0f);
    b.Add(
        Board({x0 + 0.002f, back + 0.002f, z}, {x1 - 0.002f, front - 0.002f, z + kBoard}, 0.0015f),
        CarcassSlot());
    if (open)
      b.Support({x0 + 0.03f, back + 0.03f}, {x1 - 0.03f, front - 0.03f}, z + kBoard,
                (high - low) / 3.0f - 2 * kBoard - 0.005f);
  }
}

// One door, or two before a wide cabinet.
void AddWallDoors(AssetBuilder& b, const KitchenParams& p, const WallUnit& u, int column) {
  const float mid = 0.5f * (u.x0 + u.x1), pitch = p.width_m / static_cast<float>(p.columns),
              low = p.upper_low_m, high = p.upper_high_m;
  if (pitch > 0.55f) {
    for (const float s : {-1.0f, 1.0f})
      AddFront(b, p, mid + s * 0.25f * pitch, u.front, low, 0.5f * pitch - 0.003f, high - low, -s,
               true);
  } else {
    AddFront(b, p, mid, u.front, low, pitch - 0.003f, high - low, column % 2 ? -1.0f : 1.0f, true);
  }
}

// Cabinets side by side on the wall, a hood among them.
void AddWallUnits(AssetBuilder& b, const KitchenParams& p) {
  const float w = 0.5f * p.width_m, back = -0.5f * p.depth_m, depth = 0.34f;
  const float pitch = p.width_m / static_cast<float>(p.columns);
  for (int i = 0; i < p.columns; ++i) {
    const float x0 = -w + pitch * static_cast<float>(i);
    const WallUnit unit{x0, x0 + pitch, back, back + depth - kBoard};
    if (i == p.hood_column) {
      AddHood(b, 0.5f * (unit.x0 + unit.x1), pitch, back, p.upper_low_m + 0.12f, p.upper_high_m);
      continue;
    }
    AddWallCarcass(b, p, unit, i == p.open_column);
    if (i != p.open_column) AddWallDoors(b, p, unit, i);
  }
}

Asset MakeKitchenSpace(const KitchenParams& p) {
  AssetBuilder b(p.seed);
  Rng rng(SceneSeed{p.seed}, "fronts");
  AddBase(b, p, rng);
  AddWorktop(b, p, 0.0f);
  const float w = 0.5f * p.width_m, back = -0.5f * p.depth_m, low = p.upper_low_m;
  // Splashback from worktop to wall cabinets.
  b.Add(Board({-w, back - 0.008f, p.height_m - 0.02f}, {w, back + 0.003f, low + 0.3f}, 0.001f),
        Slot("splashback", {"ceramic", "stone", "glass"}));
  AddWallUnits(b, p);
  Asset asset = b.Finish();
  // Things on the worktop must fit below the wall cabinets.
  for (SupportSurface& s : asset.supports) {
    if (std::fabs(s.z_m - p.height_m) < 0.01f) s.clearance_m = low - p.height_m - 0.01f;
  }
  return asset;
}

KitchenParams DrawKitchen(Rng& rng) {
  KitchenParams p;
  p.height_m = Draw(rng, 0.87, 0.94);
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.handles = DrawEnum<HandleStyle>(rng, static_cast<int>(HandleStyle::kCount));
  p.seed = rng.Seed();
  return p;
}

Asset SampleKitchenIsland(Rng& rng) {
  KitchenParams p = DrawKitchen(rng);
  p.columns = rng.UniformInt(2, 4);
  p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.45, 0.62);
  p.depth_m = Draw(rng, 0.6, 0.9);
  p.sink_column = rng.Bernoulli(0.35) ? rng.UniformInt(0, p.columns - 1) : -1;
  p.overhang_m = rng.Bernoulli(0.6) ? Draw(rng, 0.15, 0.35) : 0.02f;
  return MakeKitchenIsland(p);
}

Asset SampleKitchenSpace(Rng& rng) {
  KitchenParams p = DrawKitchen(rng);
  p.columns = rng.UniformInt(3, 6);
  p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.48, 0.65);
  p.depth_m = Draw(rng, 0.58, 0.64);
  p.sink_column = rng.UniformInt(0, p.columns - 1);
  p.hood_column = rng.Bernoulli(0.7) ? rng.UniformInt(0, p.columns - 1) : -1;
  p.open_column = rng.Bernoulli(0.6) ? rng.UniformInt(0, p.columns - 1) : -1;
  p.upper_low_m = p.height_m + Draw(rng, 0.48, 0.58);
  p.upper_high_m = p.upper_low_m + Draw(rng, 0.62, 0.85);
  return MakeKitchenSpace(p);
}

}  // namespace

void RegisterKitchens(std::vector<AssetClass>& classes) {
  classes.push_back({"KitchenIsland", "kitchen", Placement::kFloor, true, 0.8f, SampleKitchenIsland,
                     SizeRange({0.85f, 0.55f, 0.84f}, {2.7f, 1.4f, 1.35f})});
  classes.push_back({"KitchenSpace", "kitchen", Placement::kFloorAgainstWall, true, 0.9f,
                     SampleKitchenSpace, SizeRange({1.4f, 0.56f, 1.9f}, {4, 0.72f, 2.45f})});
}

}  // namespace parallax
