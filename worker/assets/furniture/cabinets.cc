#include <algorithm>
#include <cmath>

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

constexpr float kBoard = 0.019f;

// A cabinet with doors and drawers: wardrobe, chest, kitchen unit.
struct CabinetParams {
  float width_m = 0.9f;
  float depth_m = 0.45f;
  float height_m = 1.9f;
  int columns = 2;      // Doors side by side.
  int drawer_rows = 0;  // Rows of drawers below the doors (wardrobe) or instead of them (chest).
  bool doors = true;
  float leg_m = 0.0f;
  LegStyle legs = LegStyle::kTapered;
  bool crown = false;
  bool top_overhang = true;
  FrontStyle fronts = FrontStyle::kShaker;
  HandleStyle handles = HandleStyle::kKnob;
  bool worktop = false;    // A kitchen's: stone slab, recessed plinth, back panel.
  bool sink_side = false;  // Drawers in one column, doors in the others.
  uint64_t seed = 0;
};

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

// Dimensions that the parts of a cabinet share: half width and depth, height of the plinth and of
// the carcass's top, back of the fronts.
struct Cabinet {
  explicit Cabinet(const CabinetParams& params)
      : p(params),
        w(0.5f * params.width_m),
        d(0.5f * params.depth_m),
        plinth(params.leg_m > 0 ? params.leg_m : (params.worktop ? 0.1f : 0.055f)),
        top(params.height_m - (params.worktop ? 0.03f : (params.top_overhang ? 0.024f : 0.0f))),
        front_y(d - kBoard) {}
  const CabinetParams& p;
  const float w, d, plinth, top, front_y;
  const MaterialSlot wood = WoodSlot("carcass");
};

void AddCabinetCarcass(AssetBuilder& b, const Cabinet& c) {
  const float w = c.w, d = c.d, plinth = c.plinth, top = c.top, front_y = c.front_y;
  b.AddMirroredX(Board({w - kBoard, -d, plinth}, {w, front_y, top}, 0.0015f), c.wood);
  b.Add(Board({-w + kBoard, -d, plinth}, {w - kBoard, front_y, plinth + kBoard}, 0.0015f), c.wood);
  b.Add(Board({-w + kBoard, -d, top - kBoard}, {w - kBoard, front_y, top}, 0.0015f), c.wood);
  b.Add(Board({-w + kBoard, -d, plinth + kBoard}, {w - kBoard, -d + 0.006f, top - kBoard}, 0.0005f),
        c.wood);
}

// Legs or a plinth.
void AddCabinetFoot(AssetBuilder& b, const Cabinet& c) {
  const float w = c.w, d = c.d, leg_m = c.p.leg_m;
  if (leg_m > 0) {
    const float splay = c.p.legs == LegStyle::kTurned ? 0.0f : 0.12f * leg_m;
    b.AddFourfold(FurnitureLeg(c.p.legs, {w - 0.06f + splay, d - 0.07f + splay, 0},
                               {w - 0.06f, d - 0.07f, c.plinth + 0.004f}, 0.045f, 1),
                  WoodSlot("legs"));
    return;
  }
  const float recess = c.p.worktop ? 0.06f : 0.012f;
  b.Add(Board({-w + 0.004f, -d + 0.01f, 0}, {w - 0.004f, d - recess - kBoard, c.plinth}, 0.001f),
        c.p.worktop ? Slot("plinth", {"HousingPlastic", "BrushedMetal", "wood"}) : c.wood);
}

// A worktop or a wooden top, and a moulding on it.
void AddCabinetTop(AssetBuilder& b, const Cabinet& c) {
  const float w = c.w, d = c.d, top = c.top, z = c.p.height_m;
  if (c.p.worktop) {
    b.Add(Board({-w - 0.01f, -d, top}, {w + 0.01f, d + 0.025f, z}, 0.005f),
          Slot("worktop", {"stone", "wood"}));
  } else if (c.p.top_overhang) {
    b.Add(Board({-w - 0.012f, -d, top}, {w + 0.012f, d + 0.014f, z}, 0.005f), c.wood);
  }
  if (!c.p.crown) return;
  b.Add(Board({-w - 0.02f, -d, z}, {w + 0.02f, d + 0.022f, z + 0.018f}, 0.007f), c.wood);
  b.Add(Board({-w - 0.035f, -d, z + 0.018f}, {w + 0.035f, d + 0.038f, z + 0.04f}, 0.009f), c.wood);
}

// Drawers and doors. A wardrobe has drawers below over the whole width, doors above.
void AddCabinetFronts(AssetBuilder& b, const Cabinet& c) {
  const CabinetParams& p = c.p;
  FrontPlacer fronts{b, p, c.front_y};
  const float z0 = c.plinth + 0.003f, z1 = c.top - 0.003f;
  const float pitch = (p.width_m - 0.006f) / static_cast<float>(p.columns);
  const float drawer_zone =
      p.doors ? (p.worktop ? 0.15f : 0.19f * static_cast<float>(p.drawer_rows)) : z1 - z0;
  for (int k = 0; k < p.columns; ++k) {
    const float x = -c.w + 0.003f + pitch * (static_cast<float>(k) + 0.5f), width = pitch - 0.003f;
    const float opens = p.columns == 1 ? 1.0f : (k % 2 == 0 ? 1.0f : -1.0f);
    if (!p.doors) {
      fronts.Stack(x, width, z0, z1, p.drawer_rows);
    } else if (!p.worktop) {
      fronts.Door(x, z0 + drawer_zone, width, z1 - z0 - drawer_zone, opens);
    } else if (p.sink_side && k == 0) {
      fronts.Stack(x, width, z0, z1, 3);
    } else if (p.drawer_rows > 0) {
      fronts.Drawer(x, z1 - drawer_zone, width, drawer_zone);
      fronts.Door(x, z0, width, z1 - z0 - drawer_zone - 0.003f, opens);
    } else {
      fronts.Door(x, z0, width, z1 - z0, opens);
    }
  }
  if (!p.doors || p.worktop) return;
  for (int r = 0; r < p.drawer_rows; ++r) {
    fronts.Drawer(0, z0 + 0.19f * static_cast<float>(r), p.width_m - 0.009f, 0.187f);
  }
}

Asset MakeCabinet(const CabinetParams& p) {
  AssetBuilder b(p.seed);
  const Cabinet cabinet(p);
  AddCabinetCarcass(b, cabinet);
  AddCabinetFoot(b, cabinet);
  AddCabinetTop(b, cabinet);
  AddCabinetFronts(b, cabinet);
  const float surface = p.height_m + (p.crown ? 0.04f : 0.0f);
  b.Support({-0.95f * cabinet.w, -0.92f * cabinet.d}, {0.95f * cabinet.w, 0.88f * cabinet.d},
            surface);
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
  CabinetParams p{.columns = rng.UniformInt(2, 5), .worktop = true};
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

}  // namespace

void RegisterStorage(std::vector<AssetClass>& classes) {
  classes.push_back({"SimpleBookcase", "storage", Placement::kFloorAgainstWall, true, 0.5f,
                     SampleSimpleBookcase, SizeRange({0.55f, 0.24f, 0.8f}, {1.15f, 0.45f, 2.1f})});
  classes.push_back({"LargeShelf", "storage", Placement::kFloorAgainstWall, true, 0.5f,
                     SampleLargeShelf, SizeRange({0.85f, 0.28f, 1.7f}, {2.9f, 0.5f, 2.4f})});
  classes.push_back({"CellShelf", "storage", Placement::kFloorAgainstWall, true, 0.5f,
                     SampleCellShelf, SizeRange({0.6f, 0.3f, 0.6f}, {2.15f, 0.46f, 2.4f})});
  classes.push_back({"TriangleShelf", "storage", Placement::kFloorAgainstWall, true, 0.4f,
                     SampleTriangleShelf, SizeRange({0.4f, 0.2f, 1.2f}, {0.9f, 0.6f, 2})});
  classes.push_back({"TVStand", "storage", Placement::kFloorAgainstWall, true, 0.5f, SampleTVStand,
                     SizeRange({1.1f, 0.34f, 0.33f}, {2, 0.55f, 0.7f})});
  classes.push_back({"SingleCabinet", "storage", Placement::kFloorAgainstWall, true, 0.7f,
                     SampleSingleCabinet, SizeRange({0.4f, 0.36f, 0.65f}, {2, 0.72f, 2.25f})});
  classes.push_back({"KitchenCabinet", "storage", Placement::kFloorAgainstWall, true, 0.8f,
                     SampleKitchenCabinet, SizeRange({0.8f, 0.55f, 0.83f}, {3.1f, 0.7f, 0.96f})});
}

}  // namespace parallax
