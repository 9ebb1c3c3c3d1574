// Tables: dining, standing (cocktail), coffee, side; desks.
#include <algorithm>

#include "worker/assets/asset_families.h"
#include "worker/assets/furniture/table_bases.h"

namespace parallax {
namespace {

using namespace kernel;  // NOLINT: the modelling vocabulary of this folder.

Path2 TopOutline(const TableParams& p) {
  switch (p.top) {
    case TopStyle::kRound:
    case TopStyle::kOval:
      return EllipseSection(p.width_m, p.depth_m, 72);
    case TopStyle::kRounded:
      return RectSection(p.width_m, p.depth_m, 0.16f * p.depth_m, 10);
    default:
      return RectSection(p.width_m, p.depth_m, 0.008f, 2);
  }
}

void AddTableTop(AssetBuilder& b, const TableParams& p) {
  const MaterialSlot slot =
      p.glass_top ? GlassSlot("top") : Slot("top", {"wood", "stone", "paint"});
  const float z = p.height_m - p.top_m;
  if (p.top == TopStyle::kPlanks) {
    // Boards side by side with breadboard ends.
    const int n = std::max(3, static_cast<int>(p.depth_m / 0.16f));
    const float each = p.depth_m / static_cast<float>(n), end = 0.09f;
    for (int i = 0; i < n; ++i) {
      const float y = -0.5f * p.depth_m + each * static_cast<float>(i);
      b.Add(Board({-0.5f * p.width_m + end, y + 0.0006f, z},
                  {0.5f * p.width_m - end, y + each - 0.0006f, p.height_m}, 0.003f),
            slot);
    }
    b.AddMirroredX(Board({0.5f * p.width_m - end, -0.5f * p.depth_m, z},
                         {0.5f * p.width_m, 0.5f * p.depth_m, p.height_m}, 0.003f),
                   slot);
    return;
  }
  b.Add(Extrude(TopOutline(p), p.top_m, std::min(0.006f, 0.3f * p.top_m)).Moved(0, 0, z), slot);
}

Asset MakeTable(const TableParams& p) {
  AssetBuilder b(p.seed);
  AddTableTop(b, p);
  AddTableBase(b, p);
  const bool round = p.top == TopStyle::kRound || p.top == TopStyle::kOval;
  const float f = round ? 0.35f : 0.48f;  // The square inside the outline.
  b.Support({-f * p.width_m, -f * p.depth_m}, {f * p.width_m, f * p.depth_m}, p.height_m);
  return b.Finish();
}

Asset SampleTableDining(Rng& rng) {
  TableParams p;
  p.height_m = Draw(rng, 0.72, 0.78);
  p.top = DrawEnum<TopStyle>(rng, static_cast<int>(TopStyle::kCount));
  p.width_m = Draw(rng, 1.3, 2.1);
  p.depth_m = Draw(rng, 0.8, 1.0);
  if (p.top == TopStyle::kRound) p.width_m = p.depth_m = Draw(rng, 0.95, 1.35);
  p.top_m = Draw(rng, 0.024, 0.045);
  p.base = DrawEnum<TableBase>(rng, static_cast<int>(TableBase::kColumn));
  if (p.base == TableBase::kHairpin) p.base = TableBase::kLegs;
  if (p.top == TopStyle::kRound && p.base != TableBase::kLegs) p.base = TableBase::kPedestal;
  if (p.top == TopStyle::kOval && p.base != TableBase::kPedestal) p.base = TableBase::kLegs;
  if (p.base == TableBase::kPedestal && p.top != TopStyle::kRound) {
    p.top = TopStyle::kOval;
    p.width_m = std::min(p.width_m, 1.5f);
  }
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.leg_variant = rng.UniformInt(0, 7);
  p.leg_m = Draw(rng, 0.055, 0.09);
  p.apron = p.legs != LegStyle::kRound;
  p.seed = rng.Seed();
  return MakeTable(p);
}

Asset SampleCoffeeTable(Rng& rng) {
  TableParams p;
  p.height_m = Draw(rng, 0.38, 0.48);
  p.top = DrawEnum<TopStyle>(rng, static_cast<int>(TopStyle::kCount));
  p.width_m = Draw(rng, 0.85, 1.25);
  p.depth_m = Draw(rng, 0.5, 0.68);
  if (p.top == TopStyle::kRound) p.width_m = p.depth_m = Draw(rng, 0.6, 0.9);
  p.top_m = Draw(rng, 0.018, 0.036);
  p.base = DrawEnum<TableBase>(rng, static_cast<int>(TableBase::kColumn));
  if (p.base == TableBase::kTrestle) p.base = TableBase::kHairpin;
  if (p.base == TableBase::kPedestal && p.top != TopStyle::kRound) p.base = TableBase::kLegs;
  const bool curved = p.top == TopStyle::kRound || p.top == TopStyle::kOval;
  if (curved && p.base != TableBase::kPedestal && p.base != TableBase::kHairpin)
    p.base = TableBase::kLegs;
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.leg_variant = rng.UniformInt(0, 7);
  p.leg_m = Draw(rng, 0.035, 0.055);
  p.apron = rng.Bernoulli(0.6) && p.legs != LegStyle::kRound;
  p.shelf = rng.Bernoulli(0.4) && p.base == TableBase::kLegs && p.legs != LegStyle::kTurned &&
            p.top != TopStyle::kRound && p.top != TopStyle::kOval;
  p.glass_top = rng.Bernoulli(0.15) && p.top != TopStyle::kPlanks;
  if (p.glass_top) p.top_m = 0.012f;
  p.seed = rng.Seed();
  return MakeTable(p);
}

// Small and high, for glasses and elbows.
Asset SampleTableCocktail(Rng& rng) {
  TableParams p{.height_m = Draw(rng, 0.98, 1.12)};
  const TopStyle tops[] = {TopStyle::kRound, TopStyle::kSquare, TopStyle::kRounded,
                           TopStyle::kPlanks};
  p.top = rng.Pick(tops);
  p.width_m = Draw(rng, 0.55, 0.78);
  p.depth_m =
      p.top == TopStyle::kRound || rng.Bernoulli(0.6) ? p.width_m : p.width_m * Draw(rng, 0.8, 1.0);
  p.top_m = Draw(rng, 0.02, 0.042);
  const TableBase bases[] = {TableBase::kColumn, TableBase::kColumn, TableBase::kLegs,
                             TableBase::kPedestal, TableBase::kCrossed};
  p.base = rng.Pick(bases);
  if (p.base == TableBase::kCrossed && p.top == TopStyle::kRound) p.base = TableBase::kLegs;
  const LegStyle legs[] = {LegStyle::kSquare, LegStyle::kTapered, LegStyle::kRound};
  p.legs = rng.Pick(legs);
  p.leg_variant = rng.UniformInt(0, 7);
  p.leg_m = p.base == TableBase::kColumn ? Draw(rng, 0.05, 0.085) : Draw(rng, 0.036, 0.05);
  p.apron = p.legs != LegStyle::kRound;
  p.rungs = p.base == TableBase::kLegs || rng.Bernoulli(0.35);
  p.glass_top = rng.Bernoulli(0.12) && p.top != TopStyle::kPlanks;
  if (p.glass_top) p.top_m = 0.012f;
  p.seed = rng.Seed();
  return MakeTable(p);
}

// A small table beside a bed or sofa, with a shelf or a drawer.
Asset SampleSideTable(Rng& rng) {
  TableParams p;
  p.height_m = Draw(rng, 0.5, 0.64);
  p.width_m = Draw(rng, 0.4, 0.55);
  p.depth_m = Draw(rng, 0.36, 0.46);
  p.top_m = Draw(rng, 0.018, 0.028);
  p.leg_m = Draw(rng, 0.032, 0.045);
  p.leg_variant = rng.UniformInt(0, 7);
  p.top = rng.Bernoulli(0.35) ? TopStyle::kRound
                              : (rng.Bernoulli(0.5) ? TopStyle::kSquare : TopStyle::kRounded);
  if (p.top == TopStyle::kRound) p.depth_m = p.width_m;
  p.base =
      p.top == TopStyle::kRound && rng.Bernoulli(0.6) ? TableBase::kPedestal : TableBase::kLegs;
  p.legs = DrawEnum<LegStyle>(rng, static_cast<int>(LegStyle::kCount));
  p.apron = true;
  p.shelf = p.base == TableBase::kLegs && p.top == TopStyle::kSquare &&
            p.legs != LegStyle::kTurned && rng.Bernoulli(0.6);
  if (p.legs == LegStyle::kRound && !p.shelf) p.apron = false;
  p.seed = rng.Seed();
  return MakeTable(p);
}

}  // namespace

void RegisterTables(std::vector<AssetClass>& classes) {
  classes.push_back({"TableDining", "tables", Placement::kFloor, true, 0.6f, SampleTableDining,
                     SizeRange({0.9f, 0.75f, 0.68f}, {2.2f, 1.4f, 0.82f})});
  classes.push_back({"TableCocktail", "tables", Placement::kFloor, true, 0.3f, SampleTableCocktail,
                     SizeRange({0.5f, 0.42f, 0.95f}, {0.9f, 0.9f, 1.15f})});
  classes.push_back({"CoffeeTable", "tables", Placement::kFloor, true, 0.3f, SampleCoffeeTable,
                     SizeRange({0.55f, 0.45f, 0.34f}, {1.35f, 0.95f, 0.55f})});
  classes.push_back({"SideTable", "tables", Placement::kFloor, true, 0.1f, SampleSideTable,
                     SizeRange({0.36f, 0.34f, 0.48f}, {0.75f, 0.75f, 0.68f})});
  classes.push_back({"SimpleDesk", "tables", Placement::kFloorAgainstWall, true, 0.7f,
                     SampleSimpleDesk, SizeRange({0.95f, 0.5f, 0.68f}, {1.75f, 0.85f, 0.82f})});
}

}  // namespace parallax
