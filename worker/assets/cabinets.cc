#include <algorithm>
#include <cmath>

#include "worker/assets/storage.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kBoard = 0.019f;

// The fronts of one column, from the top down: `rows` drawers (taller downwards) or one door.
struct FrontPlacer {
  AssetBuilder& b;
  const CabinetParams& p;
  float front_y;  // Back of the fronts.
  MaterialSlot wood = WoodSlot("fronts"), metal = MetalSlot("handles");

  void Drawer(float x, float z, float width, float height) {
    b.Add(Front(p.fronts, width, height, kBoard, false).Moved(x, front_y, z), wood);
    if (p.handles == HandleStyle::kNone) return;
    const float surface = front_y + (p.fronts == FrontStyle::kFlat || height < 0.12f ||
                                             p.fronts == FrontStyle::kRaised
                                         ? kBoard
                                         : 0.55f * kBoard);
    const bool two = width > 0.62f && p.handles == HandleStyle::kKnob;
    for (const float s : two ? std::vector<float>{-0.28f, 0.28f} : std::vector<float>{0.0f}) {
      b.Add(Handle(p.handles, std::min(0.15f, 0.4f * width))
                .Moved(x + s * width, surface - 0.0005f, z + 0.52f * height),
            metal);
    }
  }

  // `opens` = +1: the handle is at the +x edge.
  void Door(float x, float z, float width, float height, float opens) {
    b.Add(Front(p.fronts, width, height, kBoard, true).Moved(x, front_y, z), wood);
    // Hinge barrels show at the other edge of framed doors.
    if (p.fronts == FrontStyle::kRaised) {
      for (const float at : {0.12f, 0.88f}) {
        b.Add(Cylinder(0.005f, 0.05f, 0.002f, 10)
                  .Moved(x - opens * (0.5f * width + 0.001f), front_y + kBoard,
                         z + at * height - 0.025f),
              metal);
      }
    }
    if (p.handles == HandleStyle::kNone) return;
    const bool bar = p.handles == HandleStyle::kBar || p.handles == HandleStyle::kBow;
    Shape handle = Handle(bar ? p.handles : HandleStyle::kKnob, std::min(0.2f, 0.3f * height));
    if (bar) handle = handle.TurnedY(0.5f * kPi);
    const float at =
        p.worktop || z < 0.5f * p.height_m - 0.2f ? (height > 1.0f ? 0.5f : 0.78f) : 0.4f;
    b.Add(handle.Moved(x + opens * (0.5f * width - 0.032f), front_y + kBoard - 0.0005f,
                       z + at * height),
          metal);
  }

  // Drawers between z0 and z1, heights growing downwards.
  void Stack(float x, float width, float z0, float z1, int rows) {
    float sum = 0;
    for (int i = 0; i < rows; ++i) sum += 1 + 0.22f * static_cast<float>(i);
    float z = z1;
    for (int i = 0; i < rows; ++i) {
      const float h = (z1 - z0) * (1 + 0.22f * static_cast<float>(i)) / sum;
      z -= h;
      Drawer(x, z + 0.0015f, width, h - 0.003f);
    }
  }
};

}  // namespace

Asset MakeCabinet(const CabinetParams& p) {
  AssetBuilder b(p.seed);
  const MaterialSlot wood = WoodSlot("carcass");
  const float w = 0.5f * p.width_m, d = 0.5f * p.depth_m;
  const float plinth = p.leg_m > 0 ? p.leg_m : (p.worktop ? 0.1f : 0.055f);
  const float slab = p.worktop ? 0.03f : (p.top_overhang ? 0.024f : 0.0f);
  const float top = p.height_m - slab;
  const float front_y = d - kBoard;
  // Carcass.
  b.AddMirroredX(Board({w - kBoard, -d, plinth}, {w, front_y, top}, 0.0015f), wood);
  b.Add(Board({-w + kBoard, -d, plinth}, {w - kBoard, front_y, plinth + kBoard}, 0.0015f), wood);
  b.Add(Board({-w + kBoard, -d, top - kBoard}, {w - kBoard, front_y, top}, 0.0015f), wood);
  b.Add(Board({-w + kBoard, -d, plinth + kBoard}, {w - kBoard, -d + 0.006f, top - kBoard}, 0.0005f),
        wood);
  if (p.leg_m > 0) {
    const float splay = p.legs == LegStyle::kTurned ? 0.0f : 0.12f * p.leg_m;
    b.AddFourfold(FurnitureLeg(p.legs, {w - 0.06f + splay, d - 0.07f + splay, 0},
                               {w - 0.06f, d - 0.07f, plinth + 0.004f}, 0.045f, 1),
                  WoodSlot("legs"));
  } else {
    const float recess = p.worktop ? 0.06f : 0.012f;
    b.Add(Board({-w + 0.004f, -d + 0.01f, 0}, {w - 0.004f, d - recess - kBoard, plinth}, 0.001f),
          p.worktop ? Slot("plinth", {"HousingPlastic", "BrushedMetal", "wood"}) : wood);
  }
  // The top.
  if (p.worktop) {
    b.Add(Board({-w - 0.01f, -d, top}, {w + 0.01f, d + 0.025f, p.height_m}, 0.005f),
          Slot("worktop", {"stone", "wood"}));
  } else if (p.top_overhang) {
    b.Add(Board({-w - 0.012f, -d, top}, {w + 0.012f, d + 0.014f, p.height_m}, 0.005f), wood);
  }
  if (p.crown) {
    const float z = p.height_m;
    b.Add(Board({-w - 0.02f, -d, z}, {w + 0.02f, d + 0.022f, z + 0.018f}, 0.007f), wood);
    b.Add(Board({-w - 0.035f, -d, z + 0.018f}, {w + 0.035f, d + 0.038f, z + 0.04f}, 0.009f), wood);
  }
  FrontPlacer fronts{b, p, front_y};
  const float z0 = plinth + 0.003f, z1 = top - 0.003f;
  const float pitch = (p.width_m - 0.006f) / static_cast<float>(p.columns);
  const float drawer_zone =
      p.doors ? (p.worktop ? 0.15f : 0.19f * static_cast<float>(p.drawer_rows)) : z1 - z0;
  for (int c = 0; c < p.columns; ++c) {
    const float x = -w + 0.003f + pitch * (static_cast<float>(c) + 0.5f), width = pitch - 0.003f;
    const float opens = p.columns == 1 ? 1.0f : (c % 2 == 0 ? 1.0f : -1.0f);
    if (!p.doors) {
      fronts.Stack(x, width, z0, z1, p.drawer_rows);
    } else if (p.worktop) {
      if (p.sink_side && c == 0) {
        fronts.Stack(x, width, z0, z1, 3);
      } else if (p.drawer_rows > 0) {
        fronts.Drawer(x, z1 - drawer_zone, width, drawer_zone);
        fronts.Door(x, z0, width, z1 - z0 - drawer_zone - 0.003f, opens);
      } else {
        fronts.Door(x, z0, width, z1 - z0, opens);
      }
    } else {
      // A wardrobe: drawers below over the whole width, doors above.
      fronts.Door(x, z0 + drawer_zone, width, z1 - z0 - drawer_zone, opens);
    }
  }
  if (p.doors && !p.worktop && p.drawer_rows > 0) {
    for (int r = 0; r < p.drawer_rows; ++r) {
      fronts.Drawer(0, z0 + 0.19f * static_cast<float>(r), p.width_m - 0.009f, 0.187f);
    }
  }
  const float surface = p.height_m + (p.crown ? 0.04f : 0.0f);
  b.Support({-0.95f * w, -0.92f * d}, {0.95f * w, 0.88f * d}, surface);
  return b.Finish();
}

Asset SampleSingleCabinet(Rng& rng) {
  CabinetParams p;
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.handles = DrawEnum<HandleStyle>(rng, static_cast<int>(HandleStyle::kCount));
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.leg_m = rng.Bernoulli(0.45) ? Draw(rng, 0.09, 0.2) : 0.0f;
  p.depth_m = Draw(rng, 0.38, 0.52);
  const int kind = rng.UniformInt(0, 2);
  if (kind == 0) {  // Wardrobe.
    p.columns = rng.UniformInt(1, 3);
    p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.42, 0.55);
    p.height_m = Draw(rng, 1.6, 2.1);
    p.depth_m = Draw(rng, 0.45, 0.6);
    p.drawer_rows = rng.UniformInt(0, 1);
    p.crown = rng.Bernoulli(0.45);
    p.leg_m = std::min(p.leg_m, 0.12f);
  } else if (kind == 1) {  // Chest of drawers.
    p.doors = false;
    p.columns = rng.UniformInt(1, 2);
    p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.5, 0.72);
    p.height_m = Draw(rng, 0.75, 1.15);
    p.drawer_rows = rng.UniformInt(3, 5);
  } else {  // Sideboard.
    p.columns = rng.UniformInt(2, 4);
    p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.38, 0.48);
    p.height_m = Draw(rng, 0.72, 0.95);
    p.leg_m = Draw(rng, 0.09, 0.2);
  }
  p.seed = rng.Seed();
  return MakeCabinet(p);
}

Asset SampleKitchenCabinet(Rng& rng) {
  CabinetParams p;
  p.worktop = true;
  p.columns = rng.UniformInt(2, 5);
  p.width_m = static_cast<float>(p.columns) * Draw(rng, 0.42, 0.6);
  p.depth_m = Draw(rng, 0.56, 0.63);
  p.height_m = Draw(rng, 0.86, 0.93);
  p.drawer_rows = rng.UniformInt(0, 1);
  p.sink_side = rng.Bernoulli(0.6);
  p.fronts = DrawEnum<FrontStyle>(rng, static_cast<int>(FrontStyle::kCount));
  p.handles = DrawEnum<HandleStyle>(rng, static_cast<int>(HandleStyle::kCount));
  p.seed = rng.Seed();
  return MakeCabinet(p);
}

void RegisterStorage(std::vector<AssetClass>& classes) {
  classes.push_back({"SimpleBookcase", "storage", Placement::kFloorAgainstWall, true, 0.5f,
                     SampleSimpleBookcase});
  classes.push_back(
      {"LargeShelf", "storage", Placement::kFloorAgainstWall, true, 0.5f, SampleLargeShelf});
  classes.push_back(
      {"CellShelf", "storage", Placement::kFloorAgainstWall, true, 0.5f, SampleCellShelf});
  classes.push_back(
      {"TriangleShelf", "storage", Placement::kFloorAgainstWall, true, 0.4f, SampleTriangleShelf});
  classes.push_back(
      {"TVStand", "storage", Placement::kFloorAgainstWall, true, 0.5f, SampleTVStand});
  classes.push_back(
      {"SingleCabinet", "storage", Placement::kFloorAgainstWall, true, 0.7f, SampleSingleCabinet});
  classes.push_back({"KitchenCabinet", "storage", Placement::kFloorAgainstWall, true, 0.8f,
                     SampleKitchenCabinet});
}

}  // namespace parallax
