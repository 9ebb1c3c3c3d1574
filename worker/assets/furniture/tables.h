// Tables: dining, standing (cocktail), coffee, side; desks.
#pragma once

#include "worker/assets/asset_families.h"
#include "worker/assets/parts.h"

namespace parallax {

// Outlines of table tops.
enum class TopStyle { kSquare, kRound, kOval, kRounded, kPlanks, kCount };
enum class TableBase { kLegs, kTrestle, kPedestal, kSledge, kCrossed, kHairpin, kColumn, kCount };

// A table of any height.
struct TableParams {
  float width_m = 1.6f;  // Along x.
  float depth_m = 0.9f;
  float height_m = 0.75f;
  float top_m = 0.032f;  // Thickness of the top.
  TopStyle top = TopStyle::kSquare;
  TableBase base = TableBase::kLegs;
  LegStyle legs = LegStyle::kTapered;
  int leg_variant = 0;
  float leg_m = 0.065f;
  bool apron = true;
  bool shelf = false;  // A lower board between the legs.
  bool rungs = false;  // Bars between the legs, for feet.
  bool glass_top = false;
  uint64_t seed = 0;
};
Asset MakeTable(const TableParams& params);
Asset SampleTableDining(Rng& rng);
Asset SampleTableCocktail(Rng& rng);  // To stand at.
Asset SampleCoffeeTable(Rng& rng);
Asset SampleSideTable(Rng& rng);

// Construction of a desk.
enum class DeskStyle { kLegs, kPedestals, kWriting, kSawhorse, kCount };

// A desk; its user sits at +y.
struct DeskParams {
  DeskStyle style = DeskStyle::kLegs;
  float width_m = 1.3f;
  float depth_m = 0.65f;
  float height_m = 0.74f;
  HandleStyle handles = HandleStyle::kBar;
  FrontStyle fronts = FrontStyle::kFlat;
  LegStyle legs = LegStyle::kTapered;
  uint64_t seed = 0;
};
Asset MakeDesk(const DeskParams& params);
Asset SampleSimpleDesk(Rng& rng);

}  // namespace parallax
